//! Tables of offsets of the control while it runs: those of the machine definition, and later values of macros.
//!
//! Values are by channel axis, as programmed. *Invariant:* a table holds only values that were set while the program
//! runs, and none out of bounds. Facts: reference functions.md 12.

use std::collections::BTreeMap;

use counterpoint_event::event::Position;
use counterpoint_motion::frame::affine::Affine;

/// Number of the base values.
pub const BASE: u32 = 0;

/// The first extended work offset has this number plus one.
pub const EXTENDED: u32 = 6;

/// Extended work offsets of a range.
pub const RANGE: u32 = 300;

/// Largest value of an offset.
pub(crate) const BOUND: f64 = 1e9;

/// Most offsets that macros set.
pub(crate) const MOST: usize = 10_000;

/// Values set by macros, by number.
#[derive(Debug, Clone, Default)]
pub struct Offsets {
    pub(crate) work: BTreeMap<u32, Position>,
    pub(crate) length: BTreeMap<u32, Position>,
    pub(crate) wear: BTreeMap<u32, Position>,
    pub(crate) worn_radius: BTreeMap<u32, f64>,
    pub(crate) radius: BTreeMap<u32, f64>,
    pub(crate) corner: BTreeMap<u32, f64>,
    pub(crate) tip: BTreeMap<u32, u8>,
    /// Rotations of work offsets.
    pub(crate) turned: BTreeMap<u32, Affine>,
}

impl Offsets {
    /// Rotation of a work offset.
    pub fn turn(&self, number: u32) -> Option<Affine> {
        self.turned.get(&number).copied()
    }

    /// Stores the rotation of a work offset, which takes effect when the frame is rebuilt. Returns `false` if the
    /// table is full.
    pub fn store_turn(&mut self, number: u32, turn: Option<Affine>) -> bool {
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
    pub fn store(&mut self, table: OffsetTable, number: u32, values: Position) -> bool {
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
    pub fn set_tip(&mut self, number: u32, value: f64) -> bool {
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
pub enum OffsetTable {
    /// Work offsets.
    Work,
    /// Tool lengths.
    Length,
    /// Wear, which is added to the length.
    Wear,
}

/// A table of radii.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Radii {
    /// For the compensation of paths.
    Cutter,
    /// Of the corner; on a lathe the same as the other.
    Corner,
    /// Wear, which is added to the radius for the compensation of paths.
    Wear,
}

impl Offsets {
    /// Whether a value of the tool offset has been set.
    pub fn has_tool(&self, number: u32) -> bool {
        self.length.contains_key(&number) || self.radius.contains_key(&number)
    }

    /// Whether a work offset has been set.
    pub fn has_work(&self, number: u32) -> bool {
        self.work.contains_key(&number)
    }
}
