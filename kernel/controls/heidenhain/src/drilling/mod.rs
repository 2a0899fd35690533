//! Drilling cycles that move only along the tool axis, as blocks of words: 200, 201, 203, 205 to 207 and 240.
//!
//! Facts: reference heidenhain-cycles.md; programming manuals of the control, drilling cycles. A stored program with
//! one of these numbers has a head and no blocks. Instead of entering it, the kernel requests the blocks of the hole
//! from [`Heidenhain::hole`]. Decisions: a cycle reads its parameters, the feed and the spindle when it starts.
//! *Invariants:* a cycle file of the user's machine is an ordinary program; the sign of the depth is checked before the
//! first block of a hole is generated.

mod pecking;
mod tapping;
mod words;

use counterpoint_control_api::host::InterpreterHost;
use counterpoint_control_api::interpreter::MadeBlocks;
use counterpoint_event::FileId;
use counterpoint_fault as diag;
use counterpoint_fault::Halt;

use super::eval::Evaluator;
use super::path_state::RadiusCompensation;
use super::q_parameter::{ParameterKind, ParameterValue, QParameter};
use super::{Heidenhain, flow};

pub(super) use words::HoleWords;

/// Maximum infeeds of a hole.
const MOST_INFEEDS: u32 = 10_000;
/// Remaining depths below this count as 0.
const NEGLIGIBLE: f64 = 0.0001;

/// A drilling cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum HeidenhainHoleCycle {
    /// 200: drilling in infeeds, with a retract to the clearance after each.
    Drill,
    /// 201: reaming, with a retract at feed.
    Ream,
    /// 203: decreasing infeeds with chip breaking.
    Universal,
    /// 205: decreasing infeeds with chip breaking; each return stops above the depth already reached.
    Peck,
    /// 206: tapping with a floating holder.
    FloatingTap,
    /// 207: rigid tapping.
    RigidTap,
    /// 240: centring.
    Centre,
}

impl HeidenhainHoleCycle {
    /// Parameters that it reads.
    fn parameters(self) -> &'static [u32] {
        match self {
            Self::Drill => &[200, 201, 202, 203, 204, 206, 210, 211, 395],
            Self::Ream => &[200, 201, 203, 204, 206, 208, 211],
            Self::Universal => &[200, 201, 202, 203, 204, 205, 206, 208, 210, 211, 212, 213, 256, 395],
            Self::Peck => &[200, 201, 202, 203, 204, 205, 206, 208, 211, 212, 253, 256, 257, 258, 259, 379, 395],
            Self::FloatingTap => &[200, 201, 203, 204, 206, 211],
            Self::RigidTap => &[200, 201, 203, 204, 239],
            Self::Centre => &[200, 201, 203, 204, 206, 211, 343, 344],
        }
    }

    fn numbered(number: u32) -> Option<Self> {
        Some(match number {
            200 => Self::Drill,
            201 => Self::Ream,
            203 => Self::Universal,
            205 => Self::Peck,
            206 => Self::FloatingTap,
            207 => Self::RigidTap,
            240 => Self::Centre,
            _ => return None,
        })
    }
}

/// A hole while its blocks are generated.
struct HeidenhainHoleBuilder<'h> {
    control: &'h mut Heidenhain,
    host: &'h mut dyn InterpreterHost,
    blocks: &'h mut MadeBlocks,
    words: HoleWords,
    /// Feed of the calling program.
    feed: f64,
    levels: HeidenhainHoleLevels,
}

/// Levels along the tool axis.
#[derive(Debug, Clone, Copy)]
struct HeidenhainHoleLevels {
    surface: f64,
    clearance: f64,
    /// The second clearance, unless it is below the first one.
    second: Option<f64>,
    depth: f64,
}

impl Heidenhain {
    /// Generates the blocks of the drilling cycle that the block calls; false if the program is not such a cycle.
    pub(super) fn hole(
        &mut self,
        host: &mut dyn InterpreterHost,
        program: FileId,
        blocks: &mut MadeBlocks,
    ) -> Result<bool, Halt> {
        let number = match self.calling {
            Some(flow::CalleeKind::Cycle) => {
                let defined = &self.cycles.defined;
                defined.program.as_deref().filter(|_| defined.stored).and_then(|name| name.parse().ok())
            }
            // A program calls the file of the cycle.
            _ => host.source(program).and_then(|source| {
                let name = source.name.rsplit('/').next()?;
                name.split('.').next()?.parse().ok()
            }),
        };
        let Some(cycle) = number.and_then(HeidenhainHoleCycle::numbered) else { return Ok(false) };
        self.calling = None;
        let unset = self.set_parameters(host, cycle)?;
        let made = self.hole_of(host, cycle, blocks);
        unset.into_iter().for_each(|name| self.variables.put_back(name, None));
        for (name, value) in std::mem::take(&mut self.cycles.running.changed) {
            self.variables.set(name, ParameterValue::Number(value));
        }
        made.map(|()| true)
    }

    /// Gives parameters without a value that of the machine, or warns that 0 is used. Returns the parameters that have
    /// a value only for this hole.
    fn set_parameters(
        &mut self,
        host: &mut dyn InterpreterHost,
        cycle: HeidenhainHoleCycle,
    ) -> Result<Vec<QParameter>, Halt> {
        let mut unset = Vec::new();
        for &index in cycle.parameters() {
            let name = QParameter { kind: ParameterKind::Q, index };
            if self.variables.get(name).is_none()
                && let Some(value @ ParameterValue::Number(_)) =
                    Evaluator::new(&mut self.variables, host).value_or_kept(name)?
            {
                self.variables.set(name, value);
                unset.push(name);
            }
        }
        Ok(unset)
    }

    /// The path ends at a hole: a corner cannot follow, and the radius is not compensated from there on.
    fn leave_path(&mut self, host: &mut dyn InterpreterHost) -> Result<(), Halt> {
        if self.path.corner.take().is_some() {
            let text = format!("no corner can follow the hole of '{}'", host.block_text());
            return Err(host.alarm(&diag::PATH_REFUSED, text));
        }
        self.path.base = None;
        self.path.side = RadiusCompensation::default();
        self.path.round = false;
        Ok(())
    }

    fn hole_of(
        &mut self,
        host: &mut dyn InterpreterHost,
        cycle: HeidenhainHoleCycle,
        blocks: &mut MadeBlocks,
    ) -> Result<(), Halt> {
        let depth = self.parameter(201);
        if depth == 0.0 {
            return Ok(());
        }
        if depth > 0.0 && cycle != HeidenhainHoleCycle::Centre {
            let text = format!(
                "error 1098: the depth Q201 is above 0 in '{}'; the control drills towards smaller values",
                host.block_text()
            );
            return Err(host.alarm(&diag::MACRO_ALARM, text));
        }
        self.leave_path(host)?;
        let feed = self.units.programmed(host);
        let (surface, second) = (self.parameter(203), self.parameter(204));
        let clearance = self.parameter(200);
        let levels = HeidenhainHoleLevels {
            surface,
            clearance: surface + clearance,
            second: (second >= clearance).then_some(surface + second),
            depth: surface + depth,
        };
        let words = *self.cycles.holes.get_or_insert_with(|| HoleWords::of(host));
        let mut hole = HeidenhainHoleBuilder { control: self, host, blocks, words, feed, levels };
        hole.rapid(hole.levels.clearance);
        match cycle {
            HeidenhainHoleCycle::Drill => hole.drill(),
            HeidenhainHoleCycle::Ream => hole.ream(),
            HeidenhainHoleCycle::Universal => hole.universal(),
            HeidenhainHoleCycle::Peck => hole.peck(),
            HeidenhainHoleCycle::FloatingTap => hole.floating_tap(),
            HeidenhainHoleCycle::RigidTap => hole.rigid_tap(),
            HeidenhainHoleCycle::Centre => hole.centre(),
        }?;
        hole.leave();
        Ok(())
    }

    /// A Q parameter, 0 without a value.
    fn parameter(&self, index: u32) -> f64 {
        self.number(QParameter { kind: ParameterKind::Q, index })
    }
}

impl HeidenhainHoleBuilder<'_> {
    /// A Q parameter, 0 without a value.
    fn parameter(&self, index: u32) -> f64 {
        self.control.parameter(index)
    }

    /// The feed of a parameter; if that is 0, the drilling feed Q206.
    fn feed_or_drilling(&self, index: u32) -> f64 {
        let feed = self.parameter(index);
        if feed == 0.0 { self.parameter(206) } else { feed }
    }

    /// Retracts to the second clearance, if it counts, and restores the feed of the program.
    fn leave(&mut self) {
        if let Some(second) = self.levels.second {
            self.rapid(second);
        }
        self.set_feed(self.feed);
    }

    /// Tip angle in the tool table, 0 if the table has none.
    fn tip_angle(&mut self) -> Result<f64, Halt> {
        self.control.system_number(self.host, 50.0, 32.0, None)
    }

    /// With Q395 = 1, makes the depth apply to the full diameter.
    fn add_tip(&mut self) -> Result<(), Halt> {
        if self.parameter(395) == 0.0 {
            return Ok(());
        }
        let angle = self.tip_angle()?;
        if angle != 0.0 {
            let [_, radius] = self.host.tool_in_force().map(|length| length / self.host.length_factor());
            self.levels.depth -= cone(radius, angle);
        }
        Ok(())
    }

    /// 201: reaming.
    fn ream(&mut self) -> Result<(), Halt> {
        let back = self.feed_or_drilling(208);
        self.line(self.levels.depth, self.parameter(206));
        self.dwell(self.parameter(211));
        self.line(self.levels.clearance, back);
        Ok(())
    }

    /// 240: centring. With Q343 = 1 the diameter Q344 gives the depth; a missing tip angle counts as 90 degrees.
    fn centre(&mut self) -> Result<(), Halt> {
        if self.parameter(343) != 0.0 {
            let angle = self.tip_angle()?;
            let angle = if angle == 0.0 { 90.0 } else { angle };
            self.levels.depth = self.levels.surface - cone(self.parameter(344).abs() / 2.0, angle);
        }
        self.line(self.levels.depth, self.parameter(206));
        self.dwell(self.parameter(211));
        self.rapid(self.levels.clearance);
        Ok(())
    }
}

/// Height of a cone, from its radius and tip angle.
fn cone(radius: f64, angle: f64) -> f64 {
    let half = (angle / 2.0).to_radians();
    radius * libm::cos(half) / libm::sin(half)
}
