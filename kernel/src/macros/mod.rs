//! What macros see of the control: its system variables and identifiers.
//!
//! Invariant: the language knows none of these names; whoever compiles or runs macros hands them over from here.

mod double;
pub mod identifiers;
mod pattern;
pub mod system;

pub use double::double;
