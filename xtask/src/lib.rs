//! The parts of the repository chores that their tests share.

mod code;
mod counts;
pub mod deny;
mod floors;
mod graph;
mod modules;
pub mod package;
mod repeats;
pub mod tidy;
mod wording;
