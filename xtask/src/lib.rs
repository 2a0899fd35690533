//! What the chores of the repository share with their tests.

mod code;
pub mod deny;
mod floors;
mod graph;
mod modules;
pub mod tidy;
