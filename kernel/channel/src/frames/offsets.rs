//! Offsets in effect: values of the tables, else of the machine definition, with the base values.
//!
//! Values are by channel axis, as programmed. Base values are added for every number, of fixtures even when none is
//! active. *Invariant:* an offset that has not been set is that of the definition; one that does not exist is zero.
//! Facts: reference functions.md 12.

use counterpoint_control_api::NO_OFFSET;
use counterpoint_event::event::{MAX_AXES, Position};
use counterpoint_machine::index::BySlot;

use crate::channel_context::ChannelContext;
use crate::offset_tables::{BOUND, MOST, OffsetTable, Radii};

impl ChannelContext<'_> {
    /// Values of an offset.
    pub fn offset_values(&self, table: OffsetTable, number: u32) -> Position {
        let set = self.state.place.offsets.as_deref().and_then(|offsets| {
            let table = match table {
                OffsetTable::Work => &offsets.work,
                OffsetTable::Length => &offsets.length,
                OffsetTable::Wear => &offsets.wear,
            };
            table.get(&number)
        });
        if let Some(values) = set {
            return *values;
        }
        let known = self.env.machine.work_offsets.len();
        if table == OffsetTable::Work && number != NO_OFFSET && number as usize > known {
            return self.part_zero();
        }
        let own = || self.env.machine.tool.offsets.iter().find(|own| own.number == number);
        let values = match table {
            OffsetTable::Work => (number as usize).checked_sub(1).and_then(|at| self.env.machine.work_offsets.get(at)),
            OffsetTable::Length => own().map(|own| &own.values),
            OffsetTable::Wear => own().map(|own| &own.wear),
        };
        let mut position = [0.0; MAX_AXES];
        if let Some(values) = values {
            for (slot, axis) in self.state.place.layout.axes.entries() {
                *position.at_mut(slot) = values[axis.machine];
            }
        }
        position
    }

    /// Machine position of the part zero where no work offset says it.
    pub fn part_zero(&self) -> Position {
        let mut position = [0.0; MAX_AXES];
        for (slot, axis) in self.state.place.layout.axes.entries() {
            *position.at_mut(slot) = self.env.machine.axes[axis.machine].positioning.part_zero;
        }
        position
    }

    /// Length and wear of an offset together.
    pub fn worn_length(&self, number: u32) -> Position {
        let mut values = self.offset_values(OffsetTable::Length, number);
        for (slot, wear) in values.iter_mut().zip(self.offset_values(OffsetTable::Wear, number)) {
            *slot += wear;
        }
        values
    }

    /// Radius and wear of an offset together, for the compensation of paths.
    pub fn worn_radius(&self, number: u32) -> f64 {
        self.offset_radius(Radii::Cutter, number) + self.offset_radius(Radii::Wear, number)
    }

    fn radii(&self, table: Radii) -> Radii {
        if self.env.machine.tool.offset_digits > 0 && table == Radii::Corner { Radii::Cutter } else { table }
    }

    /// A radius, without the base value.
    pub fn offset_radius(&self, table: Radii, number: u32) -> f64 {
        let table = self.radii(table);
        let set = self.state.place.offsets.as_deref().and_then(|offsets| {
            let table = match table {
                Radii::Cutter => &offsets.radius,
                Radii::Corner => &offsets.corner,
                Radii::Wear => &offsets.worn_radius,
            };
            table.get(&number)
        });
        set.copied().unwrap_or_else(|| {
            let own = self.env.machine.tool.offsets.iter().find(|own| own.number == number);
            own.map_or(0.0, |own| match table {
                Radii::Cutter => own.radius,
                Radii::Corner => 0.0,
                Radii::Wear => own.radius_wear,
            })
        })
    }

    /// Direction of the imaginary tip, 0 to 9.
    pub fn offset_tip(&self, number: u32) -> u8 {
        let set = self.state.place.offsets.as_deref().and_then(|offsets| offsets.tip.get(&number)).copied();
        let own = || self.env.machine.tool.offsets.iter().find(|offset| offset.number == number).map_or(0, |o| o.tip);
        set.unwrap_or_else(own)
    }

    /// Sets a radius; `false` when there is no room for it or it is out of all bounds.
    pub fn set_offset_radius(&mut self, table: Radii, number: u32, value: f64) -> bool {
        let table = self.radii(table);
        if value.is_nan() || value.abs() > BOUND {
            return false;
        }
        let offsets = self.state.place.offsets.get_or_insert_default();
        let slot = match table {
            Radii::Cutter => &mut offsets.radius,
            Radii::Corner => &mut offsets.corner,
            Radii::Wear => &mut offsets.worn_radius,
        };
        if slot.len() >= MOST && !slot.contains_key(&number) {
            return false;
        }
        slot.insert(number, value);
        true
    }
}
