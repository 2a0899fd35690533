//! Clamped axes of a channel.
//!
//! Invariant: `Place::clamped` is zero unless an axis is clamped, so a motion only looks at that.

use super::channel::Channel;
use crate::machine::ident::kind::axis::clamp_of;
use crate::machine::ident::{self, DataId, code_facts};

impl Channel<'_> {
    /// Channel axis that these data move.
    pub(crate) fn axis_of_data(&self, id: DataId) -> Option<usize> {
        self.state.place.axes.iter().position(|axis| axis.data == id)
    }

    /// Name of a channel axis for listings.
    pub(crate) fn axis_name(&self, axis: usize) -> String {
        let own = self.state.place.axes.get(axis).and_then(|axis| self.env.machine.axes.get(axis.machine));
        own.map_or_else(String::new, |own| own.letter.to_lowercase())
    }

    pub(crate) fn set_clamp(&mut self, axis: usize, on: bool) {
        let bit = 1_u8.checked_shl(axis as u32).unwrap_or(0);
        self.state.place.clamped = if on { self.state.place.clamped | bit } else { self.state.place.clamped & !bit };
    }

    /// Follows the groups of clamps after a macro has changed active codes.
    pub(crate) fn follow_clamps(&mut self) {
        for axis in 0..self.state.place.axes.len() {
            let Some(name) = self.state.place.axes.get(axis).map(|axis| self.env.machine.data_name(axis.data)) else {
                break;
            };
            let code = ident::code(&name.replacen("REG_AXIS", "CODE_CLAMP", 1));
            let group = code.and_then(code_facts).map_or(0, |facts| facts.group);
            if let Some((_, on)) = self.state.modal.code(group).filter(|_| group != 0).and_then(clamp_of) {
                self.set_clamp(axis, on);
            }
        }
    }
}
