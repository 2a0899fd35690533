//! Faults of a running macro.
//!
//! *Invariant:* a fault carries a number of the table and one sentence; place and macro are added by the machine that
//! runs the code.

use crate::diag::Number;

/// A run-time error before its place is known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// Stable number.
    pub number: Number,
    /// The error.
    pub message: String,
}

impl Fault {
    /// A fault.
    #[must_use]
    pub fn new(number: Number, message: impl Into<String>) -> Fault {
        Fault { number, message: message.into() }
    }

    /// A value of the wrong type.
    #[must_use]
    pub fn kind(wanted: &str, found: &crate::value::Value) -> Fault {
        Fault::new(Number::TYPE_MISMATCH, format!("expected {wanted}, found {}", found.kind_name()))
    }
}

/// Result of run-time work.
pub type Outcome<T> = Result<T, Fault>;
