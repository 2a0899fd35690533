//! Clamped axes of a channel, and whole turns of rotary ones.
//!
//! Invariant: `MotionState::clamped` is zero unless an axis is clamped, so a motion only looks at that.

use super::channel_context::ChannelContext;
use super::position::MotionState;
use crate::ChannelMemory;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::{CodeId, DataId, code_facts};
use counterpoint_machine::index::AxisSlot;

/// How whole turns are taken off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Modulo {
    /// Above −180 up to 180.
    Normal,
    /// From 0 to below 360.
    Plus,
    /// Between −360 and 360, with the sign that it has.
    Minus,
}

impl Modulo {
    /// The angle without whole turns.
    pub fn of(self, angle: f64) -> f64 {
        if !angle.is_finite() {
            return angle;
        }
        let positive = angle.rem_euclid(360.0);
        match self {
            Self::Normal if positive > 180.0 => positive - 360.0,
            // A tiny negative angle rounds up to the whole turn.
            Self::Normal | Self::Plus if positive < 360.0 => positive,
            Self::Normal | Self::Plus => 0.0,
            Self::Minus => angle % 360.0,
        }
    }
}

impl ChannelContext<'_> {
    /// Name of a channel axis for listings.
    pub fn axis_name(&self, axis: AxisSlot) -> String {
        self.env.machine.axes[self.state.place.layout.axes[axis].machine].letter.to_lowercase()
    }
}

impl MotionState {
    /// Channel axis that these data move.
    pub fn axis_of_data(&self, id: DataId) -> Option<AxisSlot> {
        self.layout.axes.find(|axis| axis.data == id)
    }

    /// Records whether an axis is clamped.
    pub fn set_clamp(&mut self, axis: AxisSlot, on: bool) {
        let clamped = self.clamped;
        self.clamped = if on { clamped | axis.bit() } else { clamped & !axis.bit() };
    }
}

impl ChannelMemory {
    /// Follows the groups of clamps after a macro has changed active codes.
    pub fn follow_clamps(&mut self) {
        for axis in self.place.layout.axes.ids() {
            let code = CodeId::of_kind(CodeKind::Clamp(self.place.layout.axes[axis].data, true));
            let group = code.and_then(code_facts).map_or(0, |facts| facts.group);
            let active = self.modal.code(group).filter(|_| group != 0);
            if let Some(CodeKind::Clamp(_, on)) = active.map(CodeId::kind) {
                self.place.set_clamp(axis, on);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_turns_go_by_each_rule() {
        let all = |angle: f64| [Modulo::Normal, Modulo::Plus, Modulo::Minus].map(|modulo| modulo.of(angle));
        assert_eq!(all(540.0), [180.0, 180.0, 180.0]);
        assert_eq!(all(-540.0), [180.0, 180.0, -180.0]);
        assert_eq!(all(-450.0), [-90.0, 270.0, -90.0]);
        assert_eq!(all(-1e-20), [0.0, 0.0, -1e-20]);
        assert!(all(f64::NAN).iter().all(|angle| angle.is_nan()));
    }
}
