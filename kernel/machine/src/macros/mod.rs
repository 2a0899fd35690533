//! Macros of a machine: the parts of the control that they see (system variables, identifiers), and the declarations
//! of a machine.
//!
//! Invariant: the language knows none of these names; the compiler and the runner of macros pass them from here.

pub mod condition;
pub mod environment;
pub mod identifiers;
pub mod model;
mod pattern;
pub mod system;
pub mod without;
