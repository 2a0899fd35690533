//! Whether a kernel that waits holds up those it waits for.
//!
//! On a machine with other work the system may put all kernels of a job on one processor. Then a kernel that spins only
//! keeps the other kernels from running. Invariant: this changes how a kernel waits, never the result.

use super::locks::atomic::Ordering::Relaxed;
use super::{Coordinator, Slot};

/// Processor of a kernel that has not waited yet, or where the system does not tell.
pub(super) const UNKNOWN: u32 = u32::MAX;

/// The processor that this thread runs on.
#[cfg(all(target_os = "linux", not(all(test, feature = "shuttle"))))]
fn current() -> u32 {
    u32::try_from(rustix::thread::sched_getcpu()).unwrap_or(UNKNOWN)
}

/// Where the system does not tell, every kernel is taken for one with a processor of its own.
#[cfg(not(all(target_os = "linux", not(all(test, feature = "shuttle")))))]
fn current() -> u32 {
    UNKNOWN
}

impl Coordinator {
    /// Notes where this kernel runs, and whether all others were last seen on the same processor.
    pub(super) fn holds_up_others(&self, slot: &Slot) -> bool {
        let own = current();
        slot.processor.store(own, Relaxed);
        own != UNKNOWN && self.slots.iter().all(|other| other.processor.load(Relaxed) == own)
    }
}

impl Slot {
    /// Notes where this kernel continues.
    pub(super) fn note_processor(&self) {
        self.processor.store(current(), Relaxed);
    }
}
