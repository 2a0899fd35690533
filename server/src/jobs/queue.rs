//! The queue: which job runs next, and how many are before a given one.
//!
//! Jobs run in the order of submission, but for two kinds: those whose run the host failed wait for their time and go
//! first then, and after an unclean stop the jobs that were running go first and one at a time. Invariant: a question
//! about a job's place costs the logarithm of the queue's length.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

use super::live::Live;

/// Most jobs whose end is being stored while others have their workers.
const MOST_STORING: usize = 64;

/// Jobs that wait, and who has a place.
#[derive(Debug, Default)]
pub(super) struct Queue {
    /// Jobs that were running when the server before this one died: they run alone.
    suspects: VecDeque<Arc<Live>>,
    /// Jobs whose run the host failed, and when they may be run again.
    again: Vec<(Instant, Arc<Live>)>,
    /// The others, by ordinal.
    waiting: BTreeMap<u64, Arc<Live>>,
    places: Places,
    /// Places given to submits whose ledger entry is under way.
    pub(super) reserved: usize,
    /// Jobs on worker threads.
    running: Vec<Arc<Live>>,
    /// Jobs whose run is over and whose end is being stored.
    storing: usize,
    /// The one running job is to have no company.
    alone: bool,
}

impl Queue {
    pub(super) fn running(&self) -> &[Arc<Live>] {
        &self.running
    }

    pub(super) fn len(&self) -> usize {
        self.suspects.len() + self.again.len() + self.waiting.len()
    }

    /// Puts a job at the end.
    pub(super) fn push(&mut self, live: Arc<Live>) {
        let ordinal = self.places.push(self.waiting.keys());
        live.ordinal.store(ordinal, Ordering::Relaxed);
        self.waiting.insert(ordinal, live);
    }

    /// Puts a job back to where it was before [`remove`](Self::remove).
    pub(super) fn put_back(&mut self, live: Arc<Live>) {
        self.again.push((Instant::now(), live));
    }

    pub(super) fn push_suspect(&mut self, live: Arc<Live>) {
        self.suspects.push_back(live);
    }

    /// Lets a job wait until `at`.
    pub(super) fn push_again(&mut self, at: Instant, live: Arc<Live>) {
        self.again.push((at, live));
    }

    /// Takes the next job if a worker is free for it.
    pub(super) fn next(&mut self, slots: usize, now: Instant) -> Option<Arc<Live>> {
        if self.alone || self.running.len() >= slots {
            return None;
        }
        let live = if self.suspects.is_empty() {
            match self.again.iter().position(|(at, _)| *at <= now) {
                Some(due) => self.again.remove(due).1,
                None => {
                    let (ordinal, live) = self.waiting.pop_first()?;
                    self.places.remove(ordinal);
                    live
                }
            }
        } else {
            if !self.running.is_empty() {
                return None;
            }
            self.alone = true;
            self.suspects.pop_front()?
        };
        self.running.push(live.clone());
        Some(live)
    }

    /// A worker is free again.
    pub(super) fn free(&mut self, live: &Live) {
        match self.running.iter().position(|running| running.id == live.id) {
            None => self.storing -= 1,
            Some(at) => {
                self.running.swap_remove(at);
                self.alone = false;
            }
        }
    }

    /// A run is over: its job gives its worker free before its end is stored, unless too many do that already.
    pub(super) fn store(&mut self, live: &Live) {
        if self.storing < MOST_STORING {
            self.free(live);
            self.storing += 1;
        }
    }

    /// Jobs that run or are being stored.
    pub(super) fn busy(&self) -> usize {
        self.running.len() + self.storing
    }

    /// Takes a job out; `false` if it does not wait.
    pub(super) fn remove(&mut self, live: &Live) -> bool {
        let ordinal = live.ordinal.load(Ordering::Relaxed);
        if self.waiting.get(&ordinal).is_some_and(|waiting| waiting.id == live.id) {
            self.waiting.remove(&ordinal);
            self.places.remove(ordinal);
            return true;
        }
        let before = self.len();
        self.suspects.retain(|waiting| waiting.id != live.id);
        self.again.retain(|(_, waiting)| waiting.id != live.id);
        self.len() < before
    }

    /// Jobs before this one; 0 if it does not wait.
    pub(super) fn before(&self, live: &Live) -> usize {
        let ordinal = live.ordinal.load(Ordering::Relaxed);
        if self.waiting.get(&ordinal).is_some_and(|waiting| waiting.id == live.id) {
            return self.suspects.len() + self.again.len() + self.places.before(ordinal);
        }
        let suspect = self.suspects.iter().position(|waiting| waiting.id == live.id);
        let again = || self.again.iter().position(|(_, waiting)| waiting.id == live.id);
        suspect.or_else(|| again().map(|at| self.suspects.len() + at)).unwrap_or(0)
    }
}

/// Counts of ordinals in a binary indexed tree. Ordinals begin at 1 and ascend.
#[derive(Debug, Default)]
struct Places {
    /// `tree[i]` counts the ordinals of a range that ends with `base + i`; `tree[0]` is not used.
    tree: Vec<u32>,
    base: u64,
    last: u64,
}

/// Smallest tree.
const SMALLEST: usize = 1024;

impl Places {
    /// The next ordinal; `kept` are those that have not been removed, ascending.
    fn push<'a>(&mut self, kept: impl Iterator<Item = &'a u64> + Clone) -> u64 {
        self.last += 1;
        if self.last - self.base >= self.tree.len() as u64 {
            self.base = kept.clone().next().map_or(self.last, |first| *first) - 1;
            let span = usize::try_from(self.last - self.base).unwrap_or(usize::MAX / 4);
            self.tree = vec![0; (2 * span).max(SMALLEST)];
            for ordinal in kept {
                self.add(*ordinal, 1);
            }
        }
        self.add(self.last, 1);
        self.last
    }

    fn remove(&mut self, ordinal: u64) {
        self.add(ordinal, -1);
    }

    fn index(&self, ordinal: u64) -> usize {
        usize::try_from(ordinal.saturating_sub(self.base)).unwrap_or(usize::MAX)
    }

    fn add(&mut self, ordinal: u64, count: i32) {
        let mut at = self.index(ordinal);
        while let Some(slot) = self.tree.get_mut(at).filter(|_| at > 0) {
            *slot = slot.wrapping_add_signed(count);
            at += at & at.wrapping_neg();
        }
    }

    /// Ordinals before this one.
    fn before(&self, ordinal: u64) -> usize {
        let (mut at, mut sum) = (self.index(ordinal).saturating_sub(1), 0);
        while at > 0 {
            sum += self.tree.get(at).map_or(0, |count| *count as usize);
            at &= at - 1;
        }
        sum
    }
}

#[cfg(test)]
#[path = "queue_tests.rs"]
mod tests;
