//! Cycles 206 and 207: tapping with a floating holder, and rigid.
//!
//! Facts: as those of the folder. The spindle turns the other way for the retract and as before behind it; in 207 the
//! sign of the pitch Q239 is the hand of the thread.

use counterpoint_fault::Halt;

use super::Hole;

/// M functions of a spindle that turns, and the other way round.
const CLOCKWISE: [f64; 2] = [3.0, 4.0];
const COUNTERCLOCKWISE: [f64; 2] = [4.0, 3.0];

impl Hole<'_> {
    /// 206: the feed is Q206.
    pub(super) fn floating_tap(&mut self) -> Result<(), Halt> {
        let feed = self.parameter(206);
        let turns = self.control.system_number(self.host, 20.0, 5.0, None)?;
        let [before, other] = if turns == 1.0 { COUNTERCLOCKWISE } else { CLOCKWISE };
        self.line(self.levels.depth, feed);
        self.function(other);
        self.dwell(self.parameter(211));
        self.line(self.levels.clearance, feed);
        self.function(before);
        Ok(())
    }

    /// 207: the feed is the speed times the pitch.
    pub(super) fn rigid_tap(&mut self) -> Result<(), Halt> {
        let pitch = self.parameter(239);
        let speed = self.control.system_number(self.host, 20.0, 4.0, None)?;
        // Feeds of programs in inches are tenths of an inch.
        let unit = if self.control.units.inches { 10.0 } else { 1.0 };
        let feed = speed * pitch.abs() * unit;
        let [inwards, outwards] = if pitch < 0.0 { COUNTERCLOCKWISE } else { CLOCKWISE };
        self.function(inwards);
        self.line(self.levels.depth, feed);
        self.function(outwards);
        self.line(self.levels.clearance, feed);
        self.function(inwards);
        Ok(())
    }
}
