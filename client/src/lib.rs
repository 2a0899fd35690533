//! A client of a Counterpoint server: [`Client::connect`], [`Client::submit`], [`Client::watch`], [`Client::document`].
//!
//! *Invariants:* a call is repeated only if repeating it cannot change its effect; a watch delivers every event of its
//! level exactly once and in order, even if connections break.
#![doc = include_str!("../README.md")]

mod backoff;
mod blob;
mod client;
mod connection;
mod document;
mod error;
mod reach;
mod settings;
mod watch;
mod watch_jobs;

pub use blob::Blob;
pub use client::{Client, request_id};
pub use connection::Through;
pub use counterpoint_proto::v1;
pub use document::{DrawingFormat, ResultChunks, ResultDocument};
pub use error::Error;
pub use reach::{AddressedChannel, Misfit};
pub use settings::{CallMetadata, ClientSettings, Notice};
pub use watch::{Update, Watch};
pub use watch_jobs::{JobUpdate, WatchJobs};

/// Largest message in either direction, bytes.
pub const MAX_MESSAGE: usize = 4 << 20;
