//! Counterpoint's control emulator: runs NC programs block by block, one kernel per channel, kernels meeting at
//! the sync codes of the programs.
//!
//! Knows no gRPC, no wall clock, no environment and no real file system (see [`files::Files`]). Public entry:
//! [`job::Job::prepare`] and [`job::Job::run`]; everything a user sees is read off the events it emits
//! ([`log`]).

mod action;
mod channel;
pub mod control;
pub use counterpoint_fault as diag;
mod dialect;
pub mod dialog;
pub mod files;
pub mod job;
pub mod log;
pub mod machine;
mod macros;
pub mod mcd;
mod multi;
pub mod options;
pub mod system;
pub mod trace;
