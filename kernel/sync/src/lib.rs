//! Parallel run of the kernels of a job: the order of their shared operations, waits and the verdict on those that
//! never end, shared data, and the streams of their events merged into one log.
//!
//! *Invariant:* nothing here knows a code, a word or a control: a wait comes with the rule of its control, as data.
//! Results depend on tags alone, not on threads.

pub mod backlog;
pub mod channels;
pub mod chucks;
pub mod coordinator;
pub mod files;
mod hoard;
mod locks;
pub mod mark;
pub mod merge;
pub mod order;
mod primitives;
pub mod races;
pub mod separate;
pub mod shared;
pub mod sink;
pub mod spindle_coupling;
pub mod stream;
pub mod tag;
#[cfg(test)]
mod testing;
pub mod verdict;
pub mod wait;
pub mod waits;

pub use hoard::weight;
pub use primitives::{LastAxisMove, Letter};
