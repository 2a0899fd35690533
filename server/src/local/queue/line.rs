//! The line of one tenant: its jobs that wait, by urgency and age, and the worker time that it has used.
//!
//! Invariant: `held` counts every job of the tenant that waits anywhere in the queue, `running` those on workers; a
//! line without both is dropped once it has used no more than others.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use super::places::OrdinalTree;
use crate::ledger::record::Priority;

/// Time after which a job that waits counts as of the next priority.
const AGEING: Duration = Duration::from_secs(60);

/// Where a job is in a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct QueuePosition {
    pub(super) class: usize,
    pub(super) ordinal: u64,
}

/// Jobs of one priority, by ordinal, with the time of their acceptance.
#[derive(Debug, Default)]
struct PriorityClass {
    waiting: BTreeMap<u64, (String, Instant)>,
    places: OrdinalTree,
}

/// Jobs of one tenant.
#[derive(Debug, Default)]
pub(super) struct TenantQueue {
    classes: [PriorityClass; 3],
    /// Jobs of the tenant that wait, also those beside the line.
    pub(super) held: usize,
    /// Its jobs on workers.
    pub(super) running: usize,
    /// Account of the used worker time. A new tenant starts with the lowest account.
    pub(super) used: Duration,
    /// Number of the last turn that the tenant has had, 0 = none yet: of tenants that have used the same, the lowest is
    /// next.
    pub(super) turn: u64,
    /// Number of the arrival of the tenant.
    pub(super) came: u64,
}

/// Index of the class of a priority.
pub(super) fn class(priority: Priority) -> usize {
    match priority {
        Priority::High => 0,
        Priority::Normal => 1,
        Priority::Low => 2,
    }
}

impl TenantQueue {
    /// The line of a new tenant, with its initial account and the number of its arrival.
    pub(super) fn new(used: Duration, came: u64) -> Self {
        Self { used, came, ..Self::default() }
    }

    /// Whether it may be dropped. What its tenant has used more than others is remembered.
    pub(super) fn is_unneeded(&self, floor: Duration) -> bool {
        self.held == 0 && self.running == 0 && self.used <= floor
    }

    /// Jobs in the line.
    pub(super) fn len(&self) -> usize {
        self.classes.iter().map(|class| class.waiting.len()).sum()
    }

    pub(super) fn push(&mut self, spot: QueuePosition, id: String, since: Instant) {
        if let Some(class) = self.classes.get_mut(spot.class) {
            class.places.push(spot.ordinal, class.waiting.keys());
            class.waiting.insert(spot.ordinal, (id, since));
        }
    }

    pub(super) fn remove(&mut self, spot: QueuePosition) -> Option<String> {
        let class = self.classes.get_mut(spot.class)?;
        let (id, _) = class.waiting.remove(&spot.ordinal)?;
        class.places.remove(spot.ordinal);
        Some(id)
    }

    /// The job that goes first now.
    pub(super) fn first(&self, now: Instant) -> Option<QueuePosition> {
        let heads = self.classes.iter().enumerate().filter_map(|(class, jobs)| {
            let (ordinal, (_, since)) = jobs.waiting.first_key_value()?;
            let risen = now.saturating_duration_since(*since).as_secs() / AGEING.as_secs();
            let rank = class as i64 - i64::try_from(risen).unwrap_or(i64::MAX);
            Some((rank, QueuePosition { class, ordinal: *ordinal }))
        });
        heads.min_by_key(|(rank, spot)| (*rank, spot.ordinal)).map(|(_, spot)| spot)
    }

    /// Jobs of this line before one of its.
    pub(super) fn before(&self, spot: QueuePosition) -> usize {
        let urgent: usize = self.classes.iter().take(spot.class).map(|class| class.waiting.len()).sum();
        urgent + self.classes.get(spot.class).map_or(0, |class| class.places.before(spot.ordinal))
    }
}
