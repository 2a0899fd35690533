//! How far the machine frame lies from the work frame: presets, work offset and tool together.

use super::offsets::{BASE, Table};
use crate::state::channel::Channel;
use crate::state::modal::group;
use counterpoint_event::event::{MAX_AXES, Position};
use counterpoint_machine::ident::{CodeId, codes};
use counterpoint_machine::index::BySlot;

pub(crate) const DIAMETERS: [CodeId; 3] = [codes::COMP_DIAM_LEFT, codes::COMP_DIAM_RIGHT, codes::COMP_3D_VECTOR];

impl Channel<'_> {
    /// The part of the shift that is the tool.
    pub(crate) fn tool_shift(&self) -> Position {
        let place = &self.state.place;
        let mut shift = [0.0; MAX_AXES];
        let mut add = |values: Position, sign: f64| {
            for (slot, value) in shift.iter_mut().zip(values) {
                *slot += sign * value;
            }
        };
        if place.in_force.tool_offset != BASE {
            add(self.worn_length(place.in_force.tool_offset), 1.0);
        }
        if place.in_force.length_sign != 0.0 && place.in_force.length_number != BASE {
            add(self.directed(self.worn_length(place.in_force.length_number)), place.in_force.length_sign);
        }
        if place.offsets.is_some() && (place.in_force.length_sign != 0.0 || place.in_force.tool_offset != BASE) {
            let sign = if place.in_force.length_sign < 0.0 { -1.0 } else { 1.0 };
            add(self.directed(self.offset_values(Table::Length, BASE)), sign);
        }
        shift
    }

    /// Presets, the work offset and the tool together.
    pub(crate) fn wanted_shift(&self) -> Position {
        let place = &self.state.place;
        let mut shift = place.preset;
        let mut add = |values: Position, more: Position| {
            for ((slot, value), more) in shift.iter_mut().zip(values).zip(more) {
                *slot += value + more;
            }
        };
        add(self.offset_values(Table::Work, place.in_force.work_offset), self.tool_shift());
        if place.in_force.work_offset != BASE && place.offsets.is_some() {
            add(self.offset_values(Table::Work, BASE), [0.0; MAX_AXES]);
        }
        shift
    }

    /// Length compensation along one direction: what the offset has along Z goes there.
    pub(crate) fn directed(&self, values: Position) -> Position {
        let direction = self.state.place.compensation.direction;
        if direction == 0 {
            return values;
        }
        let axis = |role: usize| self.state.place.layout.cartesian.get(role).copied().flatten();
        let amount = axis(2).map_or(0.0, |z| values.at(z));
        let mut turned = [0.0; counterpoint_event::event::MAX_AXES];
        let role = usize::from((direction - 1) % 3);
        if let Some(axis) = axis(role) {
            *turned.at_mut(axis) = if direction > 3 { -amount } else { amount } / self.state.place.scale_of(role);
        }
        turned
    }

    /// The tool word carries the offset number.
    pub(crate) fn is_turning(&self) -> bool {
        self.env.machine.tool.offset_digits > 0
    }

    /// Number of the diameter offset in force.
    pub(crate) fn diameter_in_force(&self) -> Option<u32> {
        let active = self.state.modal.code(group::DIAMETER).filter(|code| DIAMETERS.contains(code));
        active.map(|_| self.diameter_number())
    }

    /// The offset whose radius paths keep from contours where they are compensated.
    pub(crate) fn diameter_number(&self) -> u32 {
        if self.is_turning() { self.state.place.in_force.tool_offset } else { self.state.place.compensation.diameter }
    }
}
