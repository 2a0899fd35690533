//! The server of Counterpoint: accepts jobs over gRPC, keeps them durably, runs them on the control emulator and
//! serves their event logs and results.
//!
//! Shape: [`options::ServerOptions`] → [`service::build`] → [`service::Service::run`] with a cheap [`service::Handle`].
//! Invariants: a submit answers only after the job is on stable storage; a watcher reads the log and never is between a
//! kernel and its log; nothing here knows how a block is processed.

pub mod access;
pub mod backup;
mod blobs;
mod certificates;
mod clock;
mod connections;
mod cpu;
pub mod doctor;
mod drain;
pub mod environment;
mod host;
mod jobs;
mod ledger;
pub mod local;
pub mod log;
pub mod logging;
mod machines;
pub mod man;
mod memory;
mod metrics;
mod net;
pub mod notify;
mod option_file;
pub mod options;
pub mod output;
mod pace;
mod places;
mod process;
mod queue;
pub mod reason;
mod results;
mod rpc;
pub mod runner;
pub mod service;
mod spans;
pub mod start_threads;
mod tenant;
mod trace;
pub mod utc;
mod webhooks;

pub use ledger::record::JobRecord;
