//! The ordered event log of a job and its results.
//!
//! Every result is read off the events in one pass ([`builder`]): nothing here runs a job, and nothing holds the log.

pub use counterpoint_event::{event, info};

pub mod analysis;
pub mod builder;
pub mod channel_results;
pub mod coordinates;
pub mod digest;
pub mod executions;
pub mod geometry;
pub mod instant;
pub mod jsonl;
pub mod late;
pub mod listing;
mod reported;
pub mod spans;
pub mod summary;
mod svg;
mod sync_points;
pub mod timeline;
pub mod toolpath;
pub mod tools;
pub mod trace_lines;

#[cfg(test)]
pub mod testing;
