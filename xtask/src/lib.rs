//! The parts of the repository chores that their tests share.

mod code;
pub mod deny;
mod floors;
mod graph;
mod modules;
pub mod package;
pub mod tidy;
