//! The memory budget of the server: jobs in memory, submits in progress, and answers that have not been sent.
//!
//! Runs are not part of it; each of them has its own limit. Invariants: bytes that are taken are given back when their
//! [`MemoryReservation`] is dropped; a request that does not fit is refused and takes nothing; a job that has been accepted always
//! fits; jobs and submits leave a part of the budget to answers, so jobs can be looked at however many of them wait.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::reason::Refusal;

/// One part of so many is for answers only.
const ANSWERS: u64 = 8;

/// The budget.
#[derive(Debug)]
pub(crate) struct MemoryBudget {
    most: u64,
    used: Mutex<MemoryUse>,
}

/// Bytes in use.
#[derive(Debug, Default)]
struct MemoryUse {
    work: u64,
    answers: u64,
}

/// The purpose of memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Purpose {
    /// Jobs and submits.
    Work,
    /// Answers to calls that change nothing.
    Answer,
}

/// A part of the budget.
#[derive(Debug)]
pub(crate) struct MemoryReservation {
    memory: Arc<MemoryBudget>,
    purpose: Purpose,
    bytes: u64,
}

impl MemoryBudget {
    /// A budget of so many bytes; 0 = without limit.
    pub(crate) fn new(most: u64) -> Arc<Self> {
        Arc::new(Self { most: if most == 0 { u64::MAX } else { most }, used: Mutex::default() })
    }

    /// The part that only answers can have.
    pub(crate) fn of_answers(&self) -> u64 {
        self.most / ANSWERS
    }

    /// Takes a part for a submit, or refuses it.
    pub(crate) fn take(self: &Arc<Self>, bytes: u64) -> Result<MemoryReservation, Refusal> {
        let most = self.most - self.of_answers();
        let fits = |used: &MemoryUse| {
            let work = used.work.saturating_add(bytes);
            work <= most && work.saturating_add(used.answers) <= self.most
        };
        self.take_if(fits, most, Purpose::Work, bytes)
    }

    /// Takes a part for an answer, or refuses it.
    pub(crate) fn take_for_answer(self: &Arc<Self>, bytes: u64) -> Result<MemoryReservation, Refusal> {
        let fits = |used: &MemoryUse| {
            let answers = used.answers.saturating_add(bytes);
            answers <= self.of_answers() || answers.saturating_add(used.work) <= self.most
        };
        self.take_if(fits, self.most, Purpose::Answer, bytes)
    }

    fn take_if(
        self: &Arc<Self>,
        fits: impl FnOnce(&MemoryUse) -> bool,
        most: u64,
        purpose: Purpose,
        bytes: u64,
    ) -> Result<MemoryReservation, Refusal> {
        let mut used = self.used();
        if bytes > most {
            return Err(Refusal::BeyondMemory { bytes, budget: most });
        }
        if !fits(&used) {
            return Err(Refusal::MemoryFull(self.most));
        }
        let part = used.of(purpose);
        *part = part.saturating_add(bytes);
        Ok(MemoryReservation { memory: self.clone(), purpose, bytes })
    }

    /// Counts memory of a job, which is needed in any case.
    pub(crate) fn count(self: &Arc<Self>, bytes: u64) -> MemoryReservation {
        let mut used = self.used();
        used.work = used.work.saturating_add(bytes);
        MemoryReservation { memory: self.clone(), purpose: Purpose::Work, bytes }
    }

    fn used(&self) -> MutexGuard<'_, MemoryUse> {
        self.used.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl MemoryUse {
    fn of(&mut self, purpose: Purpose) -> &mut u64 {
        match purpose {
            Purpose::Work => &mut self.work,
            Purpose::Answer => &mut self.answers,
        }
    }
}

impl Drop for MemoryReservation {
    fn drop(&mut self) {
        let mut used = self.memory.used();
        let part = used.of(self.purpose);
        *part = part.saturating_sub(self.bytes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn used(memory: &MemoryBudget) -> (u64, u64) {
        let used = memory.used();
        (used.work, used.answers)
    }

    #[test]
    fn a_part_that_does_not_fit_is_refused_and_one_that_is_dropped_is_free_again() {
        let memory = MemoryBudget::new(160);
        let first = memory.take(100).unwrap();
        assert_eq!(memory.take(41).unwrap_err(), Refusal::MemoryFull(160));
        assert_eq!(memory.take(141).unwrap_err(), Refusal::BeyondMemory { bytes: 141, budget: 140 });
        let job = memory.count(90);
        assert_eq!(used(&memory), (190, 0), "a job that has been accepted fits");
        drop(first);
        assert!(memory.take(51).is_err());
        drop((memory.take(50).unwrap(), job));
        assert_eq!(used(&memory), (0, 0));
        assert!(MemoryBudget::new(0).take(u64::MAX / 2).is_ok(), "without limit");
    }

    #[test]
    fn jobs_leave_a_part_to_answers() {
        let memory = MemoryBudget::new(160);
        let jobs = memory.count(1000);
        let answer = memory.take_for_answer(20).unwrap();
        assert_eq!(memory.take_for_answer(1).unwrap_err(), Refusal::MemoryFull(160));
        drop((jobs, answer));
        let answer = memory.take_for_answer(100).unwrap();
        assert_eq!(memory.take(61).unwrap_err(), Refusal::MemoryFull(160), "memory that answers have is not free");
        drop((memory.take(60).unwrap(), answer));
        assert_eq!(memory.take_for_answer(161).unwrap_err(), Refusal::BeyondMemory { bytes: 161, budget: 160 });
        assert_eq!(used(&memory), (0, 0));
    }
}
