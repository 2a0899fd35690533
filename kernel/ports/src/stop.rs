//! The request that a job ends, and that its operator is asked before every block.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

/// The job is to end.
const END: u8 = 1;

/// Somebody steps through the job.
const STEPPED: u8 = 2;

/// The request that a job ends. It may exist before the job does, and whatever takes long for the job looks at it. Kernels look
/// at it before every block, so a job that somebody steps through is marked here, too: a job that nobody steps through pays
/// nothing for that.
#[derive(Debug, Clone, Default)]
pub struct Stop(Arc<AtomicU8>);

impl Stop {
    /// Asks for the end; it is never taken back.
    pub fn ask(&self) {
        self.0.fetch_or(END, Ordering::Relaxed);
    }

    /// Whether the end was asked for.
    #[must_use]
    #[inline(always)]
    pub fn asked(&self) -> bool {
        self.0.load(Ordering::Relaxed) & END != 0
    }

    /// Somebody steps through the job, or no longer does.
    pub(crate) fn set_stepped(&self, stepped: bool) {
        if stepped {
            self.0.fetch_or(STEPPED, Ordering::Relaxed);
        } else {
            self.0.fetch_and(!STEPPED, Ordering::Relaxed);
        }
    }

    /// The end was asked for, or somebody steps through the job.
    #[inline(always)]
    pub(crate) fn interferes(&self) -> bool {
        self.0.load(Ordering::Relaxed) != 0
    }
}
