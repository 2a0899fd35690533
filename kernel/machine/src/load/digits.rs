//! Numbers that no word of their register can have.
//!
//! Invariant: only warnings, since a word with too many digits is still read. Facts: reference control-emulator.md 1.4.

use crate::rows::{NumberFormat, Register};

/// Whether a number has more digits before the point than both formats of the register, or digits after a point that
/// neither format has.
pub(super) fn beyond(value: f64, register: &Register) -> bool {
    let fits = |format: &NumberFormat| reaches(value, format) && (value.fract() == 0.0 || format.frac > 0);
    value.is_finite() && !fits(&register.format) && !fits(&register.secondary)
}

/// Whether no number of the register is as far from zero as this one.
pub(super) fn out_of_reach(value: f64, register: &Register) -> bool {
    !reaches(value, &register.format) && !reaches(value, &register.secondary)
}

fn reaches(value: f64, format: &NumberFormat) -> bool {
    value.abs() < 10_f64.powi(i32::from(format.whole))
}

/// The format for people.
pub(super) fn shown(register: &Register) -> String {
    let NumberFormat { whole, frac, .. } = register.format;
    format!("numbers of register {} have {whole} digits before the point and {frac} after it", register.name)
}

/// Complaint about a word that the format of its register cannot write, if it is one. A range may go further than the
/// register, as long as it starts within.
pub(super) fn complaint(written: &str, first: f64, register: &Register) -> Option<String> {
    if !beyond(first, register) {
        return None;
    }
    let written = written.escape_debug();
    Some(format!("\"{written}\" does not fit: {}; more digits in [[registers]] are expected", shown(register)))
}
