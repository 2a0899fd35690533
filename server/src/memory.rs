//! The memory budget of the server: jobs in memory, submits in progress, and answers that have not been sent.
//!
//! Runs are not part of it; each of them has its own limit. Invariants: bytes that are taken are given back when their
//! [`Taken`] is dropped; a request that does not fit is refused and takes nothing; a job that has been accepted always
//! fits.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::reason::Refusal;

/// The budget.
#[derive(Debug)]
pub(crate) struct Memory {
    most: u64,
    used: AtomicU64,
}

/// A part of the budget.
#[derive(Debug)]
pub(crate) struct Taken {
    memory: Arc<Memory>,
    bytes: u64,
}

impl Memory {
    /// A budget of so many bytes; 0 = without limit.
    pub(crate) fn new(most: u64) -> Arc<Self> {
        Arc::new(Self { most: if most == 0 { u64::MAX } else { most }, used: AtomicU64::new(0) })
    }

    /// Takes a part for a request, or refuses it.
    pub(crate) fn take(self: &Arc<Self>, bytes: u64) -> Result<Taken, Refusal> {
        let add = |used: u64| used.checked_add(bytes).filter(|sum| *sum <= self.most);
        match self.used.fetch_update(Ordering::Relaxed, Ordering::Relaxed, add) {
            Ok(_) => Ok(Taken { memory: self.clone(), bytes }),
            Err(_) if bytes > self.most => Err(Refusal::BeyondMemory { bytes, budget: self.most }),
            Err(_) => Err(Refusal::MemoryFull(self.most)),
        }
    }

    /// Counts memory that is needed in any case.
    pub(crate) fn count(self: &Arc<Self>, bytes: u64) -> Taken {
        self.used.fetch_add(bytes, Ordering::Relaxed);
        Taken { memory: self.clone(), bytes }
    }

    /// Bytes in use.
    #[cfg(test)]
    pub(crate) fn used(&self) -> u64 {
        self.used.load(Ordering::Relaxed)
    }
}

impl Drop for Taken {
    fn drop(&mut self) {
        self.memory.used.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_that_does_not_fit_is_refused_and_one_that_is_dropped_is_free_again() {
        let memory = Memory::new(100);
        let first = memory.take(60).unwrap();
        assert_eq!(memory.take(41).unwrap_err(), Refusal::MemoryFull(100));
        assert_eq!(memory.take(101).unwrap_err(), Refusal::BeyondMemory { bytes: 101, budget: 100 });
        let job = memory.count(50);
        assert_eq!(memory.used(), 110, "a job that has been accepted fits");
        drop(first);
        assert!(memory.take(51).is_err());
        drop((memory.take(50).unwrap(), job));
        assert_eq!(memory.used(), 0);
        assert!(Memory::new(0).take(u64::MAX).is_ok(), "without limit");
    }
}
