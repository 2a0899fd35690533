//! Levels and modes that all drilling cycles share.
//!
//! Facts: reference siemens-cycles.md 1: DPR, the depth from the reference plane, takes precedence over DP; each digit
//! of a mode is independent. *Invariant:* the reference plane lies between the retraction plane and the depth.

use super::super::Outcome;
use super::super::expression::whole;
use super::super::number_text::shown;
use super::super::syntax;
use super::super::system::plane;
use super::SiemensHoleBuilder;
use super::words::HoleAxes;

/// Levels along the tool axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct SiemensHoleLevels {
    /// Start of machining: the safety distance before the reference plane.
    pub(super) start: f64,
    /// Bottom of the hole.
    pub(super) bottom: f64,
    /// Drilling direction: -1 towards smaller values.
    pub(super) sign: f64,
    /// Retraction plane.
    pub(super) retract: f64,
    /// Reference plane.
    pub(super) reference: f64,
}

impl SiemensHoleLevels {
    /// Depth below the reference plane.
    pub(super) fn total(&self) -> f64 {
        (self.bottom - self.reference).abs()
    }

    /// The level at a depth below the reference plane.
    pub(super) fn at(&self, depth: f64) -> f64 {
        self.reference + self.sign * depth
    }
}

impl SiemensHoleBuilder<'_> {
    /// Levels from RTP, RFP, SDIS, DP and DPR, which are the first arguments of every cycle.
    pub(super) fn levels(&mut self) -> Outcome<SiemensHoleLevels> {
        let [retract, reference, distance, depth, relative] = [0, 1, 2, 3, 4].map(|at| self.arguments.number(at));
        let (bottom, sign);
        if relative == 0.0 && self.arguments.is_given(3) {
            bottom = depth;
            sign = if depth > retract { 1.0 } else { -1.0 };
        } else {
            sign = if retract < reference { 1.0 } else { -1.0 };
            bottom = reference + sign * relative.abs();
            if retract == reference {
                self.alarm(61101, "retraction plane and reference plane are the same")?;
            }
        }
        if (retract - reference) * sign > 0.0 || (bottom - reference) * sign <= 0.0 {
            let [reference, retract, bottom] = [reference, retract, bottom].map(shown);
            let text = format!(
                "reference plane {reference} does not lie between retraction plane {retract} and depth {bottom}"
            );
            self.alarm(61101, &text)?;
        }
        Ok(SiemensHoleLevels { start: reference - sign * distance.abs(), bottom, sign, retract, reference })
    }

    /// Checks and applies _GMODE, _DMODE and _AMODE, the arguments from `modes` on. No digit may exceed the digit of
    /// `most_gmode` or `most_amode` in the same place.
    ///
    /// Units digit of _AMODE: 1 = the depth counts from the reference plane, 2 = the depth is absolute. Tens digit, if
    /// `most_amode` allows it: 1 = the dwell at `dwell` is in seconds, 2 = in revolutions.
    pub(super) fn depth_modes(
        &mut self,
        modes: usize,
        most_gmode: i64,
        dwell: Option<usize>,
        most_amode: i64,
    ) -> Outcome<()> {
        if (modes..modes + 3).all(|at| self.arguments.number(at) == 0.0) {
            return Ok(());
        }
        self.check_mode("_GMODE", modes, most_gmode)?;
        self.check_mode("_AMODE", modes + 2, most_amode)?;
        self.choose_plane(modes + 1)?;
        let amode = modes + 2;
        match self.arguments.digit(amode, 0) {
            1 if self.arguments.number(4) == 0.0 => self.arguments.set(4, self.arguments.number(3).abs()),
            2 => self.arguments.set(4, 0.0),
            _ => {}
        }
        if let Some(dwell) = dwell.filter(|_| most_amode / 10 % 10 == 2) {
            self.unit_of_time(dwell, amode, 1);
        }
        Ok(())
    }

    /// Applies a digit of _AMODE to a time: 1 = seconds, 2 = revolutions, otherwise the sign of the time decides.
    pub(super) fn unit_of_time(&mut self, time: usize, amode: usize, place: u32) {
        let value = self.arguments.number(time);
        match self.arguments.digit(amode, place) {
            1 => self.arguments.set(time, value.abs()),
            2 => self.arguments.set(time, -value.abs()),
            _ => {}
        }
    }

    fn check_mode(&mut self, name: &str, at: usize, most: i64) -> Outcome<()> {
        let value = self.arguments.number(at) as i64;
        if value < 0 {
            return self.alarm(61002, &format!("{name} is {value}, which is below 0"));
        }
        let (mut left, mut room, mut place) = (value, most, 1);
        while left > 0 {
            let (digit, highest) = (left % 10, room % 10);
            if digit > highest {
                let text = format!(
                    "{name} is {value}; its digit {place} from the right is {digit}, and only 0 to {highest} is emulated"
                );
                self.alarm(61002, &text)?;
            }
            (left, room, place) = (left / 10, room / 10, place + 1);
        }
        Ok(())
    }

    /// Applies the units digit of _DMODE: the plane of the cycle, 0 = the active plane.
    fn choose_plane(&mut self, at: usize) -> Outcome<()> {
        let value = self.arguments.number(at) as i64;
        let chosen = value % 10;
        if value < 0 || chosen > 3 {
            let text = format!("_DMODE is {value}; its units are the plane, expected 0 to 3");
            return self.alarm(61002, &text);
        }
        if chosen > 0 && plane(self.host) != Some(chosen) {
            self.letter(b'G', 16.0 + chosen as f64);
            self.end();
            self.axes = HoleAxes::in_plane(self.host, Some(chosen));
        }
        Ok(())
    }

    /// Distance from the tip of the tool to the place where its cone has a radius, from the tip angle.
    pub(super) fn tip_depth(&mut self, radius: f64) -> Outcome<f64> {
        if self.variable("$P_TOOL")? == 0.0 {
            self.alarm(61000, "no tool offset is active")?;
        }
        let angle = whole("$TC_DP24[$P_TOOLNO,$P_TOOL]").or_else(syntax)?;
        let angle = super::super::conversions::number(&self.siemens.evaluate(self.host, &angle)?)?;
        if angle <= 0.0 || angle > 180.0 {
            let angle = shown(angle);
            let text = format!("the angle of the tool's tip ($TC_DP24) is {angle}, expected above 0 and up to 180");
            self.alarm(61000, &text)?;
        }
        Ok(if angle < 179.999 { radius / libm::tan((angle / 2.0).to_radians()) } else { 0.0 })
    }

    /// Distance from the shank of the tool to its tip.
    pub(super) fn shank_depth(&mut self) -> Outcome<f64> {
        let radius = self.variable("$P_TOOLR")?;
        self.tip_depth(radius)
    }
}
