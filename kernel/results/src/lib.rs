//! The ordered event log of a job and what is read off it.
//!
//! Every result is a fold over the events ([`fold`]): nothing here runs a job, and nothing holds the log.

pub use counterpoint_event::{event, info};

pub mod digest;
pub mod fold;
pub mod geometry;
pub mod jsonl;
pub mod lane;
pub mod listing;
mod meetings;
pub mod spans;
pub mod summary;
mod svg;
pub mod timeline;
mod told;
pub mod toolpath;
pub mod tools;

#[cfg(test)]
pub mod testing;
