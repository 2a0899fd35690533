//! What the chores of the repository share with their tests.

mod code;
mod modules;
pub mod tidy;
