//! Calls per second of each identity: a bucket that fills at the rate and holds one second's worth.
//!
//! Invariant: one identity's calls never delay another's.

use std::time::{Duration, Instant};

use dashmap::DashMap;

use super::Identity;

/// Most identities that are remembered; beyond that those with full buckets are forgotten.
const MOST: usize = 10_000;

/// The buckets.
#[derive(Debug)]
pub(super) struct Rates {
    /// 0 = without limit.
    per_s: u32,
    buckets: DashMap<(String, String), (Instant, f64)>,
}

impl Rates {
    pub(super) fn new(per_s: u32) -> Self {
        Self { per_s, buckets: DashMap::new() }
    }

    /// Takes a call, or says how long to wait for the next.
    pub(super) fn take(&self, identity: &Identity, now: Instant) -> Result<(), Duration> {
        if self.per_s == 0 {
            return Ok(());
        }
        let rate = f64::from(self.per_s);
        if self.buckets.len() >= MOST {
            self.buckets.retain(|_, (at, _)| now.saturating_duration_since(*at) < Duration::from_secs(1));
        }
        let key = (identity.tenant.clone(), identity.name.clone());
        let mut bucket = self.buckets.entry(key).or_insert((now, rate));
        let (at, calls) = *bucket;
        let calls = (calls + now.saturating_duration_since(at).as_secs_f64() * rate).min(rate);
        if calls < 1.0 {
            *bucket = (now, calls);
            return Err(Duration::from_secs_f64((1.0 - calls) / rate));
        }
        *bucket = (now, calls - 1.0);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::Role;
    use super::*;

    #[test]
    fn an_identity_gets_its_rate_and_no_other_pays_for_it() {
        let identity = |name: &str| Identity { name: name.into(), tenant: "t".into(), role: Role::Read };
        let (one, other) = (identity("one"), identity("other"));
        let rates = Rates::new(10);
        let begin = Instant::now();
        assert!((0..10).all(|_| rates.take(&one, begin).is_ok()));
        let wait = rates.take(&one, begin).unwrap_err();
        assert_eq!(wait, Duration::from_millis(100));
        assert!(rates.take(&other, begin).is_ok());
        assert!(rates.take(&one, begin + wait).is_ok() && rates.take(&one, begin + wait).is_err());
        let later = begin + Duration::from_secs(60);
        assert_eq!((0..20).filter(|_| rates.take(&one, later).is_ok()).count(), 10, "no more than a second is saved");
        assert!((0..1000).all(|_| Rates::new(0).take(&one, begin).is_ok()));
    }
}
