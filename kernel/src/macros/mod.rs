//! What macros see of the control: its system variables and identifiers.
//!
//! Invariant: the language knows none of these names; whoever compiles or runs macros hands them over from here.

pub mod condition;
mod double;
pub mod environment;
pub mod identifiers;
pub mod model;
mod pattern;
pub(crate) mod reused;
pub(crate) mod runtime;
pub mod system;
pub mod without;

pub use double::double;
pub(crate) use runtime::STACK;
