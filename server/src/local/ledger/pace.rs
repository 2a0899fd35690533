//! Pauses between commits that hold operations of a busy tenant only, while another tenant has operations, too.
//!
//! An operation that comes during a commit waits for the end of that commit, so a tenant that keeps the ledger busy all
//! the time would delay all tenants. Its operations are gathered instead and written together. *Invariants:* a tenant
//! alone is never paced; neither is one that has no more than twice as many operations as another; a pause ends at once
//! when an operation of such a tenant comes.

use std::collections::HashMap;
use std::time::{Duration, Instant};

/// Time after which operations count half.
const HALF: Duration = Duration::from_millis(100);
/// Fewer recent operations than this are not many.
const MANY: f64 = 16.0;
/// A tenant with fewer recent operations than this is not there.
const THERE: f64 = 0.2;
/// A pause: as many times the commit before it, and its longest time.
const TIMES: u32 = 3;
const LONGEST: Duration = Duration::from_millis(10);

/// Operations of tenants, by a number of each; those of the server itself, 0, do not count.
#[derive(Debug, Default)]
pub(super) struct Paces {
    recent: HashMap<u64, f64>,
    at: Option<Instant>,
    /// When the next commit of busy tenants may begin.
    next: Option<Instant>,
}

impl Paces {
    /// Notes an operation.
    pub(super) fn came(&mut self, tenant: u64, now: Instant) {
        if tenant == 0 {
            return;
        }
        let passed = self.at.map_or(Duration::ZERO, |at| now.saturating_duration_since(at));
        self.at = Some(now);
        let left = 0.5_f64.powf(passed.as_secs_f64() / HALF.as_secs_f64());
        self.recent.values_mut().for_each(|count| *count *= left);
        *self.recent.entry(tenant).or_default() += 1.0;
        self.recent.retain(|_, count| *count >= THERE);
    }

    /// Whether a tenant has this many more operations than another that they wait for a common commit.
    pub(super) fn busy(&self, tenant: u64) -> bool {
        let own = self.recent.get(&tenant).copied().unwrap_or(0.0);
        let others = self.recent.iter().filter(|(other, _)| **other != tenant).map(|(_, count)| *count);
        own > MANY && others.reduce(f64::min).is_some_and(|least| own > 2.0 * least)
    }

    /// Notes a commit.
    pub(super) fn committed(&mut self, took: Duration, now: Instant) {
        self.next = Some(now + (took * TIMES).min(LONGEST));
    }

    /// Time until the next commit of busy tenants.
    pub(super) fn pause(&self, now: Instant) -> Duration {
        self.next.map_or(Duration::ZERO, |next| next.saturating_duration_since(now))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_busy_one_of_several_waits_and_for_a_bounded_time() {
        let (mut paces, begin) = (Paces::default(), Instant::now());
        (0..1000).for_each(|_| paces.came(1, begin));
        paces.came(0, begin);
        assert!(!paces.busy(1) && !paces.busy(0), "nobody else is there");
        paces.came(2, begin);
        assert!(paces.busy(1) && !paces.busy(2));
        (0..600).for_each(|_| paces.came(2, begin));
        assert!(!paces.busy(1) && !paces.busy(2), "they are about equally busy");
        paces.came(3, begin);
        assert!(paces.busy(1) && paces.busy(2) && !paces.busy(3));
        let later = begin + Duration::from_secs(10);
        (0..1000).for_each(|_| paces.came(1, later));
        assert!(!paces.busy(1), "the others have left");
        assert_eq!(paces.pause(later), Duration::ZERO);
        paces.committed(Duration::from_millis(2), later);
        assert_eq!(paces.pause(later), Duration::from_millis(6));
        paces.committed(Duration::from_secs(2), later);
        assert_eq!(paces.pause(later), LONGEST);
        assert_eq!(paces.pause(later + LONGEST), Duration::ZERO);
    }
}
