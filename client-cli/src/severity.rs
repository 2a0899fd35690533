//! Words for the severities of diagnostics. *Invariant:* only this module has the bounds.

use anstyle::Style;

use crate::say::{BAD, DIM, WARN};

/// The least severity of a warning.
pub(crate) const WARNING: u32 = 4;

/// The least severity of an error.
pub(crate) const ERROR: u32 = 8;

const FATAL: u32 = 16;

/// The word for a severity, and how it looks.
pub(crate) fn word(severity: u32) -> (&'static str, Style) {
    match severity {
        0..WARNING => ("note", DIM),
        WARNING..ERROR => ("warning", WARN),
        ERROR..FATAL => ("error", BAD),
        _ => ("fatal", BAD),
    }
}
