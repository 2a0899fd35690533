//! The inputs of a job: its files, options and limits, the answers to its dialogs and its operator, the console of
//! the operator who steps through it, commands of the operating system, and the request to end.
//!
//! Invariant: traits and plain data only; nothing here opens a file, starts a command or waits.

pub mod control;
pub mod dialog;
pub mod files;
pub mod options;
mod shares;
mod state;
pub mod step;
mod stop;
pub mod system;

pub use shares::MemoryShares;
pub use stop::StopSignal;
