//! Cycles 206 and 207: tapping with a floating holder, and rigid tapping.
//!
//! Facts: see the parent module. The spindle reverses for the retract and returns to its previous direction afterwards.
//! In 207 the sign of the pitch Q239 is the hand of the thread.

use counterpoint_fault::Halt;

use super::HeidenhainHoleBuilder;

/// M functions for a direction of the spindle and for the opposite direction.
const CLOCKWISE: [f64; 2] = [3.0, 4.0];
const COUNTERCLOCKWISE: [f64; 2] = [4.0, 3.0];

impl HeidenhainHoleBuilder<'_> {
    /// 206: tapping at the feed Q206.
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

    /// 207: tapping at the speed times the pitch.
    pub(super) fn rigid_tap(&mut self) -> Result<(), Halt> {
        let pitch = self.parameter(239);
        let speed = self.control.system_number(self.host, 20.0, 4.0, None)?;
        // Programs in inches have feeds in tenths of an inch.
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
