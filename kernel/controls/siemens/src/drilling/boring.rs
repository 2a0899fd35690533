//! CYCLE86 to CYCLE89: boring.
//!
//! Facts: reference siemens-cycles.md 1. CYCLE86 orients the spindle and moves the tool off the wall before the
//! retract. CYCLE87 and CYCLE88 stop the spindle and the program at the depth. CYCLE89 retracts at feed.

use super::super::number_text::shown;
use super::super::{Outcome, SiemensBlockError};
use super::SiemensHoleBuilder;
use counterpoint_fault as diag;

impl SiemensHoleBuilder<'_> {
    /// CYCLE86(RTP, RFP, SDIS, DP, DPR, DTB, SDIR, RPA, RPO, RPAP, POSS, _GMODE, _DMODE, _AMODE).
    pub(super) fn bore_oriented(&mut self) -> Outcome<()> {
        let [dwell, direction, aside, angle, modes] = [5, 6, 7, 10, 11];
        self.depth_modes(modes, 99_991, Some(dwell), 22)?;
        let levels = self.levels()?;
        let lacks = (0..2).find(|&at| self.arguments.number(aside + at) != 0.0 && !self.axes.has(at));
        if let Some(at) = lacks.filter(|_| self.arguments.digit(modes, 0) != 1) {
            let axis = self.axes.letters.get(at).copied().map_or('Y', char::from);
            let text = format!(
                "12550 name not defined or option missing: {} moves {axis} off the wall, and this channel has no axis \
                 {axis}",
                self.name
            );
            return Err(SiemensBlockError::Alarm(&diag::UNKNOWN_TEXT, text));
        }
        self.rapid_absolute(levels.start);
        self.start_spindle(direction)?;
        self.feed(levels.bottom);
        self.dwell(self.arguments.number(dwell));
        self.orient_spindle(self.arguments.number(angle));
        if self.arguments.digit(modes, 0) == 1 {
            // The tool is not moved off the wall.
            self.rapid(levels.retract);
            return Ok(());
        }
        let [first, second, along] = [0, 1, 2].map(|at| self.arguments.number(aside + at));
        self.rapid_by([first, second, along]);
        self.rapid_absolute(levels.start);
        self.rapid_by([-first, -second, levels.retract - levels.start]);
        self.letter(b'G', 90.0);
        self.end();
        Ok(())
    }

    /// Moves by distances along the axes of the plane (G91 G0).
    fn rapid_by(&mut self, distances: [f64; 3]) {
        self.letter(b'G', 91.0);
        self.letter(b'G', 0.0);
        for (at, distance) in distances.into_iter().enumerate() {
            self.axis(at, distance);
        }
        self.end();
    }

    /// CYCLE87(RTP, RFP, SDIS, DP, DPR, SDIR), CYCLE88(RTP, RFP, SDIS, DP, DPR, DTB, SDIR).
    pub(super) fn bore_stopped(&mut self, dwells: bool) -> Outcome<()> {
        let direction = if dwells { 6 } else { 5 };
        let levels = self.levels()?;
        self.rapid_absolute(levels.start);
        self.start_spindle(direction)?;
        self.feed(levels.bottom);
        if dwells {
            self.dwell(self.arguments.number(5));
        }
        self.function(5.0);
        self.function(0.0);
        self.rapid(levels.retract);
        Ok(())
    }

    /// CYCLE89(RTP, RFP, SDIS, DP, DPR, DTB).
    pub(super) fn bore(&mut self) -> Outcome<()> {
        let levels = self.levels()?;
        self.rapid_absolute(levels.start);
        self.feed(levels.bottom);
        self.dwell(self.arguments.number(5));
        self.feed(levels.start);
        self.rapid(levels.retract);
        Ok(())
    }

    /// Starts the spindle in the direction of an argument: M3 or M4.
    fn start_spindle(&mut self, at: usize) -> Outcome<()> {
        let direction = self.arguments.number(at);
        if direction != 3.0 && direction != 4.0 {
            self.alarm(61102, &format!("direction of the spindle is {}, expected 3 or 4", shown(direction)))?;
        }
        self.function(direction);
        Ok(())
    }
}
