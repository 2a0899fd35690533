//! CYCLE84 and CYCLE840: tapping, rigid and with a compensating chuck.
//!
//! Facts: reference siemens-cycles.md 1; nominal sizes have the coarse leads of ISO 261. The sign of a size or a lead
//! is the hand of the thread.

use super::super::Outcome;
use super::super::number_text::shown;
use super::{MOST_STROKES, NEGLIGIBLE, SiemensHoleBuilder};

/// Nominal sizes below which the coarse lead is this.
const COARSE: [(f64, f64); 14] = [
    (4.0, 0.5),
    (5.0, 0.7),
    (6.0, 0.8),
    (8.0, 1.0),
    (10.0, 1.25),
    (12.0, 1.5),
    (14.0, 1.75),
    (18.0, 2.0),
    (24.0, 2.5),
    (30.0, 3.0),
    (36.0, 3.5),
    (42.0, 4.0),
    (48.0, 4.5),
    (f64::INFINITY, 5.0),
];

impl SiemensHoleBuilder<'_> {
    /// CYCLE84(RTP, RFP, SDIS, DP, DPR, DTB, SDAC, MPIT, PIT, POSS, SST, SST1, _AXN, _PITA, _TECHNO, _VARI, _DAM, _VRT,
    /// _PITM, _PTAB, _PTABA, _GMODE, _DMODE, _AMODE).
    pub(super) fn rigid_tap(&mut self) -> Outcome<()> {
        let [dwell, after, angle, inwards, outwards, kind, step, back, modes] = [5, 6, 9, 10, 11, 15, 16, 17, 21];
        self.depth_modes(modes, 99_999, Some(dwell), 2_992_992)?;
        let levels = self.levels()?;
        self.check_spindle_after(after)?;
        let mut lead = self.lead([7, 8, 13])?;
        match self.arguments.digit(modes + 2, 3) {
            1 => lead = lead.abs(),
            2 => lead = -lead.abs(),
            _ => {}
        }
        let kind = self.arguments.number(kind);
        if !(0.0..=2.0).contains(&kind) {
            self.alarm(61002, &format!("kind of machining is {}, expected 0 to 2", shown(kind)))?;
        }
        let speed = self.arguments.number(inwards);
        if speed <= 0.0 {
            self.alarm(61102, &format!("speed of tapping is {}", shown(speed)))?;
        }
        let out_speed = Some(self.arguments.number(outwards)).filter(|speed| *speed > 0.0).unwrap_or(speed);
        let back = Some(self.arguments.number(back)).filter(|back| *back != 0.0).unwrap_or(1.0);
        let step = self.arguments.number(step).abs();
        let total = levels.total();
        let mut done = 0.0;
        self.rapid_absolute(levels.start);
        self.orient_spindle(self.arguments.number(angle));
        for _ in 0..MOST_STROKES {
            done = if kind == 0.0 || step == 0.0 { total } else { done + step };
            let is_last = done >= total - NEGLIGIBLE;
            done = if is_last { total } else { done };
            self.tap(331.0, levels.at(done), lead, speed);
            if is_last {
                self.dwell(self.arguments.number(dwell));
                self.tap(332.0, levels.start, lead, out_speed);
                self.rapid(levels.retract);
                self.function(self.arguments.number(after));
                return Ok(());
            }
            let above = if kind == 1.0 { levels.at(done - back) } else { levels.start };
            self.tap(332.0, above, lead, out_speed);
        }
        self.alarm(61107, &format!("the hole needs more than {MOST_STROKES} strokes; make them longer"))
    }

    /// CYCLE840(RTP, RFP, SDIS, DP, DPR, DTB, SDR, SDAC, ENC, MPIT, PIT, _AXN, _PITA, _TECHNO, _PITM, _PTAB, _PTABA,
    /// _GMODE, _DMODE, _AMODE).
    pub(super) fn floating_tap(&mut self) -> Outcome<()> {
        let [dwell, turn_back, after, encoder, modes] = [5, 6, 7, 8, 17];
        self.depth_modes(modes, 99_999, Some(dwell), 2_992_992)?;
        let levels = self.levels()?;
        self.check_spindle_after(after)?;
        let mut back = self.arguments.number(turn_back);
        if back == 0.0 {
            back = if self.variable("$P_SDIR")? == 3.0 { 4.0 } else { 3.0 };
        }
        let feed = self.variable("$P_F")?;
        let encoder = self.arguments.number(encoder);
        let by_feed = encoder == 1.0 || encoder == 11.0;
        let lead = if encoder == 1.0 { 0.0 } else { self.lead([9, 10, 12])?.abs() };
        let speed = if encoder == 11.0 { self.variable("$P_S")? } else { 0.0 };
        self.rapid_absolute(levels.start);
        if encoder == 11.0 {
            self.set_feed(speed * lead);
        }
        self.float(by_feed, levels.bottom, lead);
        self.dwell(self.arguments.number(dwell));
        self.function(back);
        self.float(by_feed, levels.start, lead);
        self.rapid(levels.retract);
        self.function(self.arguments.number(after));
        self.set_feed(feed);
        Ok(())
    }

    /// Adds a stroke at feed (G63), or a stroke that follows the spindle (G33).
    fn float(&mut self, by_feed: bool, level: f64, lead: f64) {
        if by_feed {
            return self.move_by(63.0, level);
        }
        self.letter(b'G', 33.0);
        self.along(level);
        self.lead_word(lead);
        self.end();
    }

    /// Adds a stroke of rigid tapping (G331) or its retract (G332).
    fn tap(&mut self, code: f64, level: f64, lead: f64, speed: f64) {
        self.letter(b'G', code);
        self.along(level);
        self.lead_word(lead);
        self.letter(b'S', speed);
        self.end();
    }

    /// Adds the word for the lead along the applicate: I, J or K.
    fn lead_word(&mut self, lead: f64) {
        let letter = match self.axes.letters {
            [_, _, b'Y'] => b'J',
            [_, _, b'X'] => b'I',
            _ => b'K',
        };
        self.letter(letter, lead);
    }

    fn check_spindle_after(&mut self, at: usize) -> Outcome<()> {
        let after = self.arguments.number(at);
        if !(3.0..=5.0).contains(&after) {
            let text = format!("spindle after the cycle is {}, expected 3, 4 or 5", shown(after));
            self.alarm(61102, &text)?;
        }
        Ok(())
    }

    /// Lead from the arguments PIT, MPIT and _PITA: PIT, or the coarse lead of the nominal size MPIT. Unit of PIT by
    /// _PITA: 2 = threads per inch, 3 = inches, 4 = module.
    fn lead(&mut self, at: [usize; 3]) -> Outcome<f64> {
        let [size, pitch, kind] = at.map(|at| self.arguments.number(at));
        if size == 0.0 && pitch == 0.0 {
            self.alarm(61001, "neither a size nor a lead of the thread is given")?;
        }
        let lead = match kind as i64 {
            2 if pitch != 0.0 => 25.4 / pitch,
            3 => 25.4 * pitch,
            4 => std::f64::consts::PI * pitch,
            _ => pitch,
        };
        if size == 0.0 {
            return Ok(lead);
        }
        if !(3.0..=48.0).contains(&size.abs()) {
            self.alarm(61001, &format!("size {} of the thread is not from 3 to 48", shown(size)))?;
        }
        let coarse = COARSE.iter().find(|(below, _)| size.abs() < *below).map_or(5.0, |(_, lead)| *lead);
        let coarse = if size < 0.0 { -coarse } else { coarse };
        if pitch != 0.0 && (coarse - pitch).abs() > NEGLIGIBLE {
            let (size, pitch) = (shown(size), shown(pitch));
            self.alarm(61001, &format!("size {size} and lead {pitch} of the thread contradict each other"))?;
        }
        Ok(coarse)
    }
}
