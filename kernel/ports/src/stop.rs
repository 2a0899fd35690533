//! The request that a job ends.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The request that a job ends. It may exist before the job does, and whatever takes long for the job looks at it.
#[derive(Debug, Clone, Default)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Asks for the end; it is never taken back.
    pub fn ask(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether the end was asked for.
    #[must_use]
    #[inline(always)]
    pub fn asked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
