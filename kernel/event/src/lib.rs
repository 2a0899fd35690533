//! The log of a job, and the fixed facts of a job before it runs.
//!
//! Invariant: plain data that knows no machine, no program and no kernel.

pub mod event;
pub mod info;
pub mod letters;
mod outcome;
mod place;
pub mod text;
mod units;

pub use letters::Letters;
pub use outcome::RunEnd;
pub use place::SourcePlace;
pub use text::Text;
pub use units::{MAX_AXES, MachineUnit, Position};

/// Index of a file of the job.
pub type FileId = u16;
