//! How the kernels of a job run beside each other: the order of their shared operations, waits and the verdict on those
//! that never end, what they share, and the streams of their events merged into one log.
//!
//! *Invariant:* nothing here knows a code, a word or a control; what happens depends on tags alone, not on threads.

pub mod backlog;
pub mod coordinator;
pub mod files;
mod hoard;
pub mod merge;
pub mod order;
mod primitives;
pub mod ranks;
pub mod shared;
pub mod sink;
pub mod stream;
pub mod tag;
pub mod verdict;
pub mod waits;

pub use hoard::weight;
