//! Changes of all jobs, in their order, for clients that follow many jobs.
//!
//! The feed remembers which job has changed, not how: who reads it gets the newest state. Its cursors ascend over
//! restarts of the server, whose number is their upper part. Invariants: a reader whose cursor the feed still has sees
//! every job that has changed since; the memory is bounded.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

use tokio::sync::watch;

use super::lock::lock;
use crate::reason::Refusal;

/// Most changes that are remembered, and most bytes of them.
const MOST: usize = 16 * 1024;
const MOST_BYTES: usize = 8 << 20;
/// Bits of a cursor that count the changes since the start of the server. Further changes overflow into the numbers of
/// later starts. Starts are numbered by milliseconds, so no start gets a number that changes have already reached.
const CHANGES: u32 = 20;

/// A job has changed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct JobChange {
    pub(crate) id: Arc<str>,
    tenant: Arc<str>,
    /// Keys by which a removed job was found.
    pub(crate) removed: Option<Arc<Removed>>,
}

impl JobChange {
    /// Memory that it takes about.
    fn bytes(&self) -> usize {
        let removed = self.removed.as_ref().map_or(0, |removed| {
            let labels = removed.labels.iter().map(|(key, value)| 96 + key.len() + value.len());
            64 + removed.machine.len() + labels.sum::<usize>()
        });
        128 + self.id.len() + self.tenant.len() + removed
    }
}

/// The remains of a removed job.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Removed {
    pub(crate) machine: String,
    pub(crate) labels: std::collections::BTreeMap<String, String>,
}

/// Changes after a cursor.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Changes {
    /// Of one tenant, oldest first; a job that has changed several times is at its last change.
    pub(crate) changes: Vec<JobChange>,
    pub(crate) cursor: u64,
}

/// Changes and their bytes.
#[derive(Debug, Default)]
struct RecentChanges {
    changes: VecDeque<JobChange>,
    bytes: usize,
}

/// The feed.
#[derive(Debug)]
pub(crate) struct Feed {
    changes: Mutex<RecentChanges>,
    /// Cursor of the newest change.
    last: watch::Sender<u64>,
    most: usize,
}

impl Feed {
    pub(super) fn new(epoch: u64) -> Self {
        Self { changes: Mutex::default(), last: watch::Sender::new(epoch << CHANGES), most: MOST }
    }

    fn push(&self, change: JobChange) {
        let mut remembered = lock(&self.changes);
        remembered.bytes += change.bytes();
        remembered.changes.push_back(change);
        while remembered.changes.len() > self.most || remembered.bytes > MOST_BYTES {
            let Some(oldest) = remembered.changes.pop_front() else { break };
            remembered.bytes -= oldest.bytes();
        }
        self.last.send_modify(|last| *last += 1);
    }

    /// A job has changed.
    pub(super) fn changed(&self, tenant: &str, id: &str) {
        self.push(JobChange { id: id.into(), tenant: tenant.into(), removed: None });
    }

    /// A job was removed.
    pub(super) fn removed(&self, tenant: &str, id: &str, removed: Removed) {
        self.push(JobChange { id: id.into(), tenant: tenant.into(), removed: Some(Arc::new(removed)) });
    }

    /// The cursor of the newest change, to be followed.
    pub(crate) fn follow(&self) -> watch::Receiver<u64> {
        self.last.subscribe()
    }

    /// Up to `most` changes of a tenant after a cursor.
    pub(crate) fn after(&self, tenant: &str, cursor: u64, most: usize) -> Result<Changes, Refusal> {
        let remembered = lock(&self.changes);
        let changes = &remembered.changes;
        let last = *self.last.borrow();
        let oldest = last - changes.len() as u64;
        if cursor < oldest {
            return Err(Refusal::CursorTooOld { after: cursor, oldest });
        }
        let Some(known) = usize::try_from(cursor - oldest).ok().filter(|_| cursor <= last) else {
            return Err(Refusal::CursorBeyondLog { after: cursor, last });
        };
        let mut found: Vec<JobChange> = Vec::new();
        let mut reached = last;
        for (change, at) in changes.iter().skip(known).zip(cursor + 1..) {
            if &*change.tenant != tenant {
                continue;
            }
            if found.len() >= most {
                reached = at - 1;
                break;
            }
            found.push(change.clone());
        }
        drop(remembered);
        let mut seen = std::collections::HashSet::new();
        found.reverse();
        found.retain(|change| seen.insert(change.id.clone()));
        found.reverse();
        Ok(Changes { changes: found, cursor: reached })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ids(changes: &Changes) -> String {
        changes.changes.iter().map(|change| &*change.id).collect()
    }

    #[test]
    fn changes_come_once_in_order_and_to_their_tenant_only() {
        let feed = Feed::new(3);
        let start = *feed.follow().borrow();
        assert_eq!(start, 3 << CHANGES);
        for (tenant, id) in [("t", "a"), ("t", "b"), ("u", "c"), ("t", "a"), ("t", "d")] {
            feed.changed(tenant, id);
        }
        let all = feed.after("t", start, 9).unwrap();
        assert_eq!((ids(&all).as_str(), all.cursor), ("bad", start + 5));
        let first = feed.after("t", start, 2).unwrap();
        assert_eq!((ids(&first).as_str(), first.cursor), ("ab", start + 3));
        let rest = feed.after("t", first.cursor, 9).unwrap();
        assert_eq!((ids(&rest).as_str(), rest.cursor), ("ad", start + 5));
        assert_eq!(ids(&feed.after("u", start, 9).unwrap()), "c");
        assert_eq!(feed.after("t", all.cursor, 9).unwrap(), Changes { changes: Vec::new(), cursor: all.cursor });
    }

    #[test]
    fn removed_jobs_with_many_labels_are_forgotten_earlier() {
        let feed = Feed::new(1);
        let start = *feed.follow().borrow();
        let labels = (0..32).map(|number| (format!("key-{number}"), "v".repeat(255))).collect();
        let removed = Removed { machine: "m".into(), labels };
        for _ in 0..2 * MOST {
            feed.removed("t", "a", Removed { machine: removed.machine.clone(), labels: removed.labels.clone() });
        }
        let kept = lock(&feed.changes);
        assert!(kept.bytes <= MOST_BYTES && kept.changes.len() > 500, "{}: {}", kept.changes.len(), kept.bytes);
        assert_eq!(kept.bytes, kept.changes.iter().map(JobChange::bytes).sum::<usize>());
        drop(kept);
        assert!(matches!(feed.after("t", start, 1), Err(Refusal::CursorTooOld { .. })));
    }

    #[test]
    fn a_cursor_that_is_too_old_or_not_yet_there_is_refused() {
        let feed = Feed { most: 2, ..Feed::new(7) };
        let start = *feed.follow().borrow();
        for id in ["a", "b", "c"] {
            feed.changed("t", id);
        }
        let old = feed.after("t", start, 9);
        assert_eq!(old, Err(Refusal::CursorTooOld { after: start, oldest: start + 1 }));
        assert_eq!(ids(&feed.after("t", start + 1, 9).unwrap()), "bc");
        let beyond = feed.after("t", start + 4, 9);
        assert_eq!(beyond, Err(Refusal::CursorBeyondLog { after: start + 4, last: start + 3 }));
        // Cursors of the server before this one.
        let earlier = (6 << CHANGES) + 5;
        assert_eq!(feed.after("t", earlier, 9), Err(Refusal::CursorTooOld { after: earlier, oldest: start + 1 }));
    }
}
