//! Faults of a running macro.
//!
//! *Invariant:* a fault carries a number of the table and one sentence; place and macro are added by the machine that
//! runs the code.

use crate::diag::DiagnosticNumber;

/// A run-time error before its place is known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MacroFault {
    /// Stable number.
    pub number: DiagnosticNumber,
    /// The error.
    pub message: String,
}

impl MacroFault {
    /// A fault.
    #[must_use]
    pub fn new(number: DiagnosticNumber, message: impl Into<String>) -> MacroFault {
        MacroFault { number, message: message.into() }
    }

    /// A value of the wrong type.
    #[must_use]
    pub fn kind(wanted: &str, found: &crate::value::MacroValue) -> MacroFault {
        MacroFault::new(DiagnosticNumber::TYPE_MISMATCH, format!("expected {wanted}, found {}", found.kind_name()))
    }
}

/// Result of run-time work.
pub type Outcome<T> = Result<T, MacroFault>;
