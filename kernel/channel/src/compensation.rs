//! States of compensation: numbers, sets and directions of offsets, dynamic fixtures, corners.
//!
//! Facts: reference system-variables.md 7.

use super::offset_tables::{EXTENDED, RANGE};
use counterpoint_machine::Machine;
use counterpoint_machine::model::OutsideCorner;

/// States that only offsets and macros use.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompensationModes {
    /// Type of length compensation, 1 to 4.
    pub set: u8,
    /// Direction of the length: 0 as the offset has its values, 1 to 3 along X Y Z, 4 to 6 against them.
    pub direction: u8,
    /// Corners of compensated paths: 0 by angle, 1 sharp, 2 arc.
    pub corner: u8,
    /// Dynamic fixture compensation.
    pub dynamic: bool,
    /// Direction of the vector form.
    pub vector: [f64; 3],
}

impl CompensationModes {
    /// At the start of a job.
    pub fn of(machine: &Machine) -> Self {
        let corner = match machine.compensation.corner {
            OutsideCorner::Angle => 0,
            OutsideCorner::Linear => 1,
            OutsideCorner::Arc => 2,
        };
        Self { set: 1, direction: 0, corner, dynamic: false, vector: [0.0; 3] }
    }
}

/// Number of an extended work offset among all; 0 for none.
pub fn number_of(range: u32, register: u32) -> u32 {
    if register == 0 {
        return 0;
    }
    let before = range.max(1).saturating_sub(1).saturating_mul(RANGE);
    EXTENDED.saturating_add(before).saturating_add(register)
}
