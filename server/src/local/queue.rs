//! The queue in memory: a server that starts fills it from its ledger.
//!
//! Invariant: a question about a job's place costs the logarithm of the queue's length.

use std::collections::{BTreeMap, HashMap, VecDeque};
use std::time::Instant;

use crate::queue::{Entry, Queue};

/// Most jobs whose end is being stored while others have their workers.
const MOST_STORING: usize = 64;

/// Jobs that wait, and who has a place.
#[derive(Debug, Default)]
pub(crate) struct LocalQueue {
    /// Jobs that were running when the server before this one died: they run alone.
    suspects: VecDeque<String>,
    /// Jobs whose run the host failed, and when they may be run again.
    again: Vec<(Instant, String)>,
    /// The others, by ordinal, and the other way round.
    waiting: BTreeMap<u64, String>,
    ordinals: HashMap<String, u64>,
    places: Places,
    /// Jobs on worker threads.
    running: Vec<String>,
    /// Jobs whose run is over and whose end is being stored.
    storing: usize,
    /// The one running job is to have no company.
    alone: bool,
}

impl LocalQueue {
    /// Takes a job that has waited for its turn.
    fn take(&mut self, ordinal: u64) -> Option<String> {
        let id = self.waiting.remove(&ordinal)?;
        self.ordinals.remove(&id);
        self.places.remove(ordinal);
        Some(id)
    }
}

impl Queue for LocalQueue {
    fn len(&self) -> usize {
        self.suspects.len() + self.again.len() + self.waiting.len()
    }

    fn push(&mut self, id: &str, entry: Entry) {
        match entry {
            Entry::Suspect => self.suspects.push_back(id.to_owned()),
            Entry::Again(at) => self.again.push((at, id.to_owned())),
            Entry::Accepted => {
                let ordinal = self.places.push(self.waiting.keys());
                self.waiting.insert(ordinal, id.to_owned());
                self.ordinals.insert(id.to_owned(), ordinal);
            }
        }
    }

    fn next(&mut self, slots: usize, now: Instant) -> Option<String> {
        if self.alone || self.running.len() >= slots {
            return None;
        }
        let id = if self.suspects.is_empty() {
            match self.again.iter().position(|(at, _)| *at <= now) {
                Some(due) => self.again.remove(due).1,
                None => self.waiting.keys().next().copied().and_then(|first| self.take(first))?,
            }
        } else {
            if !self.running.is_empty() {
                return None;
            }
            self.alone = true;
            self.suspects.pop_front()?
        };
        self.running.push(id.clone());
        Some(id)
    }

    fn store(&mut self, id: &str) {
        if self.storing < MOST_STORING {
            self.free(id);
            self.storing += 1;
        }
    }

    fn free(&mut self, id: &str) {
        match self.running.iter().position(|running| running == id) {
            None => self.storing -= 1,
            Some(at) => {
                self.running.swap_remove(at);
                self.alone = false;
            }
        }
    }

    fn remove(&mut self, id: &str) -> bool {
        if let Some(ordinal) = self.ordinals.get(id).copied() {
            return self.take(ordinal).is_some();
        }
        let before = self.len();
        self.suspects.retain(|waiting| waiting != id);
        self.again.retain(|(_, waiting)| waiting != id);
        self.len() < before
    }

    fn before(&self, id: &str) -> usize {
        if let Some(ordinal) = self.ordinals.get(id) {
            return self.suspects.len() + self.again.len() + self.places.before(*ordinal);
        }
        let suspect = self.suspects.iter().position(|waiting| waiting == id);
        let again = || self.again.iter().position(|(_, waiting)| waiting == id);
        suspect.or_else(|| again().map(|at| self.suspects.len() + at)).unwrap_or(0)
    }

    fn running(&self) -> &[String] {
        &self.running
    }

    fn busy(&self) -> usize {
        self.running.len() + self.storing
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
