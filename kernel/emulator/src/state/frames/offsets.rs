//! Offsets of the control while it runs: those of the machine definition, and later values of macros.
//!
//! Values are by channel axis, as programmed. Base values are added for every number, of fixtures even when none is
//! active. *Invariant:* an offset that has not been set is that of the definition; one that does not exist is zero.
//! Facts: reference functions.md 12.

use counterpoint_machine::index::BySlot;
use std::collections::BTreeMap;

use crate::state::channel::ChannelContext;
use counterpoint_control_api::NO_OFFSET;
use counterpoint_event::event::{MAX_AXES, Position};
use counterpoint_motion::frame::affine::Affine;

/// Number of the base values.
pub(crate) const BASE: u32 = 0;

/// The first extended work offset has this number plus one.
pub(crate) const EXTENDED: u32 = 6;

/// Extended work offsets of a range.
pub(crate) const RANGE: u32 = 300;

/// Largest value of an offset.
const BOUND: f64 = 1e9;

/// Most offsets that macros set.
const MOST: usize = 10_000;

/// Values set by macros, by number.
#[derive(Debug, Clone, Default)]
pub(crate) struct Offsets {
    work: BTreeMap<u32, Position>,
    length: BTreeMap<u32, Position>,
    wear: BTreeMap<u32, Position>,
    worn_radius: BTreeMap<u32, f64>,
    radius: BTreeMap<u32, f64>,
    corner: BTreeMap<u32, f64>,
    tip: BTreeMap<u32, u8>,
    /// Rotations of work offsets.
    turned: BTreeMap<u32, Affine>,
}

impl Offsets {
    /// Rotation of a work offset.
    pub(crate) fn turn(&self, number: u32) -> Option<Affine> {
        self.turned.get(&number).copied()
    }

    /// Stores the rotation of a work offset, which takes effect when the frame is rebuilt. Returns `false` if the
    /// table is full.
    pub(crate) fn store_turn(&mut self, number: u32, turn: Option<Affine>) -> bool {
        let turned = &mut self.turned;
        match turn {
            None => {
                turned.remove(&number);
            }
            Some(_) if turned.len() >= MOST && !turned.contains_key(&number) => return false,
            Some(turn) => {
                turned.insert(number, turn);
            }
        }
        true
    }

    /// Stores an offset, which takes effect when the frame is rebuilt. Returns `false` if the table is full or a value
    /// is out of bounds.
    pub(crate) fn store(&mut self, table: OffsetTable, number: u32, values: Position) -> bool {
        if values.iter().any(|value| value.is_nan() || value.abs() > BOUND) {
            return false;
        }
        let slot = match table {
            OffsetTable::Work => &mut self.work,
            OffsetTable::Length => &mut self.length,
            OffsetTable::Wear => &mut self.wear,
        };
        if slot.len() >= MOST && !slot.contains_key(&number) {
            return false;
        }
        slot.insert(number, values);
        true
    }

    /// Sets the direction of the imaginary tip. Returns `false` if the table is full or the direction is not 0 to 9.
    pub(crate) fn set_tip(&mut self, number: u32, value: f64) -> bool {
        let tips = &mut self.tip;
        let possible = (0.0..=9.0).contains(&value) && value.fract() == 0.0;
        if !possible || tips.len() >= MOST && !tips.contains_key(&number) {
            return false;
        }
        tips.insert(number, value as u8);
        true
    }
}

/// A table of offsets with a value per axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum OffsetTable {
    Work,
    Length,
    /// Wear, which is added to the length.
    Wear,
}

/// A table of radii.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Radii {
    /// For the compensation of paths.
    Cutter,
    /// Of the corner; on a lathe the same as the other.
    Corner,
    /// Wear, which is added to the radius for the compensation of paths.
    Wear,
}

impl Offsets {
    /// Whether a value of the tool offset has been set.
    pub(crate) fn has_tool(&self, number: u32) -> bool {
        self.length.contains_key(&number) || self.radius.contains_key(&number)
    }

    /// Whether a work offset has been set.
    pub(crate) fn has_work(&self, number: u32) -> bool {
        self.work.contains_key(&number)
    }
}

impl ChannelContext<'_> {
    /// Values of an offset.
    pub(crate) fn offset_values(&self, table: OffsetTable, number: u32) -> Position {
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
    pub(crate) fn part_zero(&self) -> Position {
        let mut position = [0.0; MAX_AXES];
        for (slot, axis) in self.state.place.layout.axes.entries() {
            *position.at_mut(slot) = self.env.machine.axes[axis.machine].positioning.part_zero;
        }
        position
    }

    /// Length and wear of an offset together.
    pub(crate) fn worn_length(&self, number: u32) -> Position {
        let mut values = self.offset_values(OffsetTable::Length, number);
        for (slot, wear) in values.iter_mut().zip(self.offset_values(OffsetTable::Wear, number)) {
            *slot += wear;
        }
        values
    }

    /// Radius and wear of an offset together, for the compensation of paths.
    pub(crate) fn worn_radius(&self, number: u32) -> f64 {
        self.offset_radius(Radii::Cutter, number) + self.offset_radius(Radii::Wear, number)
    }

    fn radii(&self, table: Radii) -> Radii {
        if self.env.machine.tool.offset_digits > 0 && table == Radii::Corner { Radii::Cutter } else { table }
    }

    /// A radius, without the base value.
    pub(crate) fn offset_radius(&self, table: Radii, number: u32) -> f64 {
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
    pub(crate) fn offset_tip(&self, number: u32) -> u8 {
        let set = self.state.place.offsets.as_deref().and_then(|offsets| offsets.tip.get(&number)).copied();
        let own = || self.env.machine.tool.offsets.iter().find(|offset| offset.number == number).map_or(0, |o| o.tip);
        set.unwrap_or_else(own)
    }

    /// Sets a radius; `false` when there is no room for it or it is out of all bounds.
    pub(crate) fn set_offset_radius(&mut self, table: Radii, number: u32, value: f64) -> bool {
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
