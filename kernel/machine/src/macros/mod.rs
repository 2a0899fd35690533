//! Macros of a machine: what they see of the control (system variables, identifiers), and what a machine declares.
//!
//! Invariant: the language knows none of these names; the compiler and the runner of macros pass them from here.

pub mod condition;
pub mod environment;
pub mod identifiers;
pub mod model;
mod pattern;
pub mod system;
pub mod without;
