//! How far the machine frame lies from the work frame: presets, work offset and tool together.

use crate::channel_context::ChannelContext;
use crate::modal::group;
use crate::offset_tables::{BASE, OffsetTable};
use crate::position::MotionState;
use counterpoint_control_api::NO_OFFSET;
use counterpoint_event::event::{MAX_AXES, Position};
use counterpoint_machine::ident::{CodeId, codes};
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_machine::model::LengthInMachineFrame;

/// Codes that compensate the radius of the tool.
pub const DIAMETERS: [CodeId; 3] = [codes::COMP_DIAM_LEFT, codes::COMP_DIAM_RIGHT, codes::COMP_3D_VECTOR];

impl ChannelContext<'_> {
    /// The part of the shift that is the tool.
    pub fn tool_shift(&self) -> Position {
        let place = &self.state.place;
        let mut shift = self.length_shift();
        let mut add = |values: Position| shift.iter_mut().zip(values).for_each(|(slot, value)| *slot += value);
        if place.in_force.tool_offset != BASE {
            add(self.worn_length(place.in_force.tool_offset));
            if place.offsets.is_some() && place.in_force.length_sign == 0.0 {
                add(self.state.place.directed(self.offset_values(OffsetTable::Length, BASE)));
            }
        }
        shift
    }

    /// The part of it that is length compensation.
    fn length_shift(&self) -> Position {
        let place = &self.state.place;
        let in_force = &place.in_force;
        let mut shift = [0.0; MAX_AXES];
        if in_force.length_sign == 0.0 {
            return shift;
        }
        let mut add = |values: Position| {
            shift.iter_mut().zip(values).for_each(|(slot, value)| *slot += in_force.length_sign * value);
        };
        if in_force.length_number != BASE {
            add(self.length_values());
        }
        if place.offsets.is_some() {
            add(self.state.place.directed(self.offset_values(OffsetTable::Length, BASE)));
        }
        let off = |slot: &AxisSlot| in_force.length_off & slot.bit() != 0;
        place.layout.axes.ids().filter(off).for_each(|slot| *shift.at_mut(slot) = 0.0);
        shift
    }

    /// Values of the active length offset.
    fn length_values(&self) -> Position {
        let in_force = &self.state.place.in_force;
        in_force.length_held.unwrap_or_else(|| self.state.place.directed(self.worn_length(in_force.length_number)))
    }

    /// Called before an offset gets new values: if the control changes the active values only by a word, keeps the old
    /// ones.
    pub fn hold_length(&mut self, table: OffsetTable, number: u32) {
        let in_force = &self.state.place.in_force;
        let concerns = table != OffsetTable::Work && number == in_force.length_number && in_force.length_sign != 0.0;
        if concerns && number != BASE && self.env.machine.compensation.length.by_word {
            self.state.place.in_force.length_held = Some(self.length_values());
        }
    }

    /// Suspends length compensation for axes, one bit each; `false` if it shifts none of them.
    pub fn take_length_off(&mut self, axes: u8) -> bool {
        let shift = self.length_shift();
        let shifted = self.state.place.layout.axes.ids().filter(|slot| shift.at(*slot) != 0.0);
        let axes = shifted.fold(0, |bits, slot| bits | slot.bit()) & axes;
        self.state.place.in_force.length_off |= axes;
        axes != 0
    }

    /// The offset that the tool adds to positions of the machine frame; under tool centre point control these are axis
    /// positions.
    pub fn tool_in_machine_frame(&self) -> Position {
        let added = self.env.machine.compensation.length.in_machine_frame == LengthInMachineFrame::Added;
        if added && self.state.place.tip().is_none() { self.tool_shift() } else { [0.0; MAX_AXES] }
    }

    /// Distance of the work frame from the frame in which positions of the machine frame are programmed.
    pub fn shift_in_machine_frame(&self, axis: AxisSlot) -> f64 {
        self.state.place.shift.at(axis) - self.tool_in_machine_frame().at(axis)
    }

    /// Presets, the work offset and the tool together.
    pub fn wanted_shift(&self) -> Position {
        let place = &self.state.place;
        let mut shift = place.preset;
        let mut add = |values: Position, more: Position| {
            for ((slot, value), more) in shift.iter_mut().zip(values).zip(more) {
                *slot += value + more;
            }
        };
        add(self.offset_values(OffsetTable::Work, place.in_force.work_offset), self.tool_shift());
        if place.in_force.work_offset == BASE {
            add(self.part_zero(), self.offset_values(OffsetTable::Work, NO_OFFSET));
        } else if place.offsets.is_some() {
            add(self.offset_values(OffsetTable::Work, BASE), [0.0; MAX_AXES]);
        }
        shift
    }

    /// Whether the tool word carries the offset number.
    pub fn is_turning(&self) -> bool {
        self.env.machine.tool.offset_digits > 0
    }

    /// Number of the active diameter offset.
    pub fn diameter_in_force(&self) -> Option<u32> {
        let active = self.state.modal.code(group::DIAMETER).filter(|code| DIAMETERS.contains(code));
        active.map(|_| self.diameter_number())
    }

    /// The offset whose radius paths keep from contours where they are compensated.
    pub fn diameter_number(&self) -> u32 {
        if self.is_turning() { self.state.place.in_force.tool_offset } else { self.state.remembered.diameter() }
    }
}

impl MotionState {
    /// Length compensation along one direction, with the amount that the offset has along Z.
    pub fn directed(&self, values: Position) -> Position {
        let direction = self.compensation.direction;
        if direction == 0 {
            return values;
        }
        let axis = |role: usize| self.layout.cartesian.get(role).copied().flatten();
        let amount = axis(2).map_or(0.0, |z| values.at(z));
        let mut turned = [0.0; counterpoint_event::event::MAX_AXES];
        let role = usize::from((direction - 1) % 3);
        if let Some(axis) = axis(role) {
            *turned.at_mut(axis) = if direction > 3 { -amount } else { amount } / self.scale_of(role);
        }
        turned
    }
}
