//! Functions without support here: they need a machine model, a composite or a screen.
//!
//! Invariant: each of them reports once in a run that nothing is there for it (2910070), and returns as if it had
//! failed.

use counterpoint_lang::host::{AbsentFn, Need};

/// Why a function has nothing to work on.
#[must_use]
pub fn why(function: AbsentFn) -> &'static str {
    match function.needs() {
        Need::Model => "needs a machine model, and there is none here",
        Need::ModelTime => "needs a machine model, and there is none here: channels always run in one time",
        Need::Composite => "needs a composite machine, and there is none here",
        Need::Screen => "needs a screen, and a job runs in the background",
        Need::WordProcessor => "needs a word processor, and there is none here",
    }
}
