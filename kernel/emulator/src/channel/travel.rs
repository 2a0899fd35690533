//! Limits of travel and of the working area: checks the ends of moves, and the extent of circles between their ends.
//!
//! *Invariant:* a block is reported once; a straight move is within the limits where both its ends are, except under
//! tool tip control, where places along it are checked. Circles in the face plane of polar interpolation are checked at
//! their ends only, those on a cylinder along its axis too.

use counterpoint_channel::travel_limits::{
    FEWEST_DIGITS, LimitKind, NOISE, Over, beyond, circle_of, leads_beyond, place_along, stays_within_travel,
    turns_beyond,
};
use counterpoint_event::event::{Motion, MotionKind, Position};
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_program::block::Word;

use super::Kernel;

impl Kernel<'_> {
    /// Reports a motion beyond the limits.
    #[inline(always)]
    pub(super) fn check_travel(&mut self, motion: &Motion) {
        if self.channel.state.place.layout.bounds.limited && !self.channel.state.place.layout.bounds.stop {
            self.check_limits_of_motion(motion);
        }
    }

    /// If the limit is an alarm, a motion beyond it stops the channel before it begins; a motion beyond a limit of the
    /// program always stops the channel.
    #[inline(always)]
    pub(super) fn check_travel_before(&mut self, motion: &Motion) -> Acted {
        if self.channel.state.place.layout.bounds.limited {
            if self.channel.state.place.stored.is_some() {
                self.check_stored_area(motion);
            }
            if self.channel.state.place.layout.bounds.stop {
                self.check_limits_of_motion(motion);
            }
            return self.channel.check_stop();
        }
        Ok(())
    }

    #[inline(always)]
    fn check_limits_of_motion(&mut self, motion: &Motion) {
        if !stays_within_travel(&self.channel, motion) {
            self.measure_travel(motion);
        }
    }

    #[cold]
    #[inline(never)]
    fn measure_travel(&mut self, motion: &Motion) {
        let over = leads_beyond(&self.channel, motion, LimitKind::Travel);
        self.report_over_travel(over);
    }

    /// Stops the channel before a motion that leads out of the working area.
    pub(super) fn check_area(&mut self, motion: &Motion) -> Acted {
        let Some((axis, at, [low, high])) = leads_beyond(&self.channel, motion, LimitKind::Area) else { return Ok(()) };
        let name = &self.channel.env.machine.axes[axis].name;
        let bound = if at > high { high } else { low };
        let text = format!(
            "axis {name} would be at {at:.3} in the basic coordinate system, beyond the limit {bound} of the working area, \
             in '{}'; no part of the block acts",
            self.channel.block_text()
        );
        self.diagnose(&diag::WORK_AREA, text);
        self.channel.check_stop()
    }

    /// Reports a motion that breaks the limit that the program has set.
    #[cold]
    fn check_stored_area(&mut self, motion: &Motion) {
        let Some(area) = self.channel.state.place.stored.as_deref().copied().filter(|area| area.on) else { return };
        let at = |place: &Position| {
            let machine = self.channel.state.place.machine_point(place);
            self.channel.state.place.layout.cartesian.map(|axis| axis.map(|axis| machine.at(axis)))
        };
        let round = match motion.kind {
            MotionKind::ArcCw | MotionKind::ArcCcw => circle_of(&self.channel, motion),
            _ => None,
        };
        let broken = match round {
            Some(_) => area.breaks_round(|share| at(&place_along(motion, &round, share))),
            None => area.breaks(&at(&motion.from), &at(&motion.to)),
        };
        let Some(role) = broken else { return };
        let name = ["X", "Y", "Z"].get(role).copied().unwrap_or_default();
        let does = if area.keep_out { "enters the forbidden area" } else { "leaves the allowed area" };
        let text = format!("the tool {does} along {name} in '{}'", self.channel.block_text());
        self.diagnose(&diag::STORED_LIMIT, text);
    }

    /// Reports axes that stand beyond their limits.
    pub(super) fn check_limits_of_axes(&mut self, at: &Position) {
        let over = beyond(&self.channel, at, NOISE, LimitKind::Travel);
        self.report_over_travel(over);
    }

    /// Reports a circle that is straight for its axes and turns one of them back beyond its limits, at `values` in
    /// radius.
    #[cold]
    pub fn check_swing(&mut self, to: &Position, axis: AxisSlot, values: [Option<f64>; 2]) -> Acted {
        if self.channel.state.place.layout.bounds.limited
            && beyond(&self.channel, to, NOISE, LimitKind::Travel).is_none()
        {
            let over = turns_beyond(&self.channel, to, axis, values, (NOISE, LimitKind::Travel));
            self.report_over_travel(over);
            if self.channel.state.place.layout.bounds.stop {
                return self.channel.check_stop();
            }
        }
        Ok(())
    }

    fn report_over_travel(&mut self, over: Option<Over>) {
        let Some((axis, at, [low, high])) = over else { return };
        let axis = &self.channel.env.machine.axes[axis];
        let hint = match self.channel.block.words.iter().find_map(|word| whole_number(self, word, &axis.letter)) {
            Some(word) => format!("; if {word} counts least increments, run with --set numbers=increments"),
            None => String::new(),
        };
        let text = format!(
            "axis {} at {at:.3} in the machine frame is beyond its limits {low} to {high} in '{}'{hint}",
            axis.name,
            self.channel.block_text()
        );
        self.diagnose(&diag::OVER_TRAVEL, text);
    }
}

/// The text of an axis word with many digits and no decimal point; `None` if the control never counts least increments,
/// or already counts them.
fn whole_number(kernel: &Kernel<'_>, word: &Word, axis: &str) -> Option<String> {
    let machine = kernel.channel.env.machine;
    let register = &machine.registers[word.register];
    if register.before != axis || register.counts || word.made || !machine.preprocessor.row().counts_increments {
        return None;
    }
    let text = String::from_utf8_lossy(&kernel.channel.word_bytes(word)).into_owned();
    let digits = text.trim_start_matches(|c: char| !c.is_ascii_digit());
    (digits.len() >= FEWEST_DIGITS && digits.bytes().all(|byte| byte.is_ascii_digit())).then_some(text)
}
