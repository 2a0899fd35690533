//! Values as numbers, bits and frames.

use counterpoint_fault as diag;

use super::frame::SiemensFrame;
use super::value::Data;
use super::{Outcome, SiemensBlockError, wrong_type};

/// A number that comes out of a calculation.
pub(super) fn real(value: f64) -> Outcome<Data> {
    if value.is_finite() {
        Ok(Data::Real(value))
    } else {
        Err(SiemensBlockError::Alarm(&diag::MACRO_DOMAIN, "the result is out of range".to_owned()))
    }
}

/// A number that an operand has to be.
pub(super) fn number(value: &Data) -> Outcome<f64> {
    match value.number() {
        Some(number) => Ok(number),
        None => wrong_type(format!("{} is not a valid number", value.described())),
    }
}

pub(super) fn bits(value: &Data) -> Outcome<i32> {
    let number = number(value)?.round();
    if number.abs() <= f64::from(u32::MAX) {
        Ok(number as i64 as i32)
    } else {
        wrong_type(format!("{} has more than 32 bits", value.described()))
    }
}

/// Whether numbers that differ by no more than rounding are equal.
pub(super) fn same(left: f64, right: f64) -> bool {
    left == right || (left - right).abs() <= 1e-12 * left.abs().max(right.abs())
}

/// A frame that a value has to be.
pub(super) fn as_frame(value: Data) -> Outcome<SiemensFrame> {
    match value {
        Data::Frame(frame) => Ok(*frame),
        other => wrong_type(format!("{} is not a frame", other.described())),
    }
}
