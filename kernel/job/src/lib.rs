//! Counterpoint's control emulator: runs NC programs block by block, one kernel per channel; kernels wait for each
//! other at the sync codes of the programs.
//!
//! Knows no gRPC, no wall clock, no environment and no real file system (see [`files::JobFiles`]). Public entry:
//! [`job::Job::prepare`] and [`job::Job::run`]; everything a user sees is read off the events it emits
//! ([`log`]).

pub use counterpoint_event as event;
pub use counterpoint_fault as diag;
pub use counterpoint_machine as machine;
pub use counterpoint_ports::{control, dialog, files, options, step as operator, system};
pub use counterpoint_program as mcd;
pub use counterpoint_results as log;
pub mod job;
mod multi;
pub mod plans;
mod prepared;
mod step;
pub mod tape;
