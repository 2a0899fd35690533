//! The ordered event log of a job and what is read off it.

pub mod event;
pub mod info;
