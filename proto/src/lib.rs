//! The wire contract of Counterpoint: messages and services of `counterpoint.v1`.
//!
//! Invariant: nothing here knows how a job is run; the `.proto` files are the one source, and every message
//! documented there with units.

pub mod batch;

/// Messages, clients and servers of package `counterpoint.v1`.
#[allow(missing_docs, unreachable_pub, clippy::all, clippy::pedantic)]
pub mod v1 {
    pub use crate::batch::EventBatch;
    tonic::include_proto!("counterpoint.v1");
}

/// Encoded `FileDescriptorSet` of the package, for reflection.
pub const DESCRIPTORS: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/counterpoint.v1.bin"));
