//! Calls per second of each identity: a bucket that fills at the rate and holds one second's worth.
//!
//! A call that finds no token takes the next free token and waits for it: callers that never pause are slowed down to
//! the rate, and most of their calls are still answered. *Invariants:* one identity's calls never delay another's; an
//! identity has no more than [`MOST_HELD`] calls waiting, none of them for longer than [`LONGEST`].

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use dashmap::DashMap;

use super::Identity;

/// Most identities that are remembered; beyond that those with full buckets are forgotten.
const MOST: usize = 10_000;
/// Most calls of an identity that wait: as many as one connection may have in progress.
const MOST_HELD: usize = 256;
/// Longest time that a call waits for its token.
pub(crate) const LONGEST: Duration = Duration::from_secs(1);

/// The buckets.
#[derive(Debug)]
pub(super) struct IdentityRateLimiter {
    /// 0 = without limit.
    per_s: u32,
    buckets: DashMap<(String, String), IdentityBucket>,
}

/// The tokens of an identity.
#[derive(Debug)]
struct IdentityBucket {
    at: Instant,
    /// Below zero: tokens that waiting calls have taken in advance.
    calls: f64,
    held: Arc<AtomicUsize>,
}

/// When a call may continue.
#[derive(Debug)]
pub(crate) enum RateDecision {
    Now,
    /// After this time, for which it counts among the waiting calls of its identity.
    After(Duration, DeferredCall),
    /// Not at all; a call after this time may.
    Never(Duration),
}

/// A waiting call: it counts until this is dropped.
#[derive(Debug)]
pub(crate) struct DeferredCall(Arc<AtomicUsize>);

impl Drop for DeferredCall {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

impl IdentityRateLimiter {
    pub(super) fn new(per_s: u32) -> Self {
        Self { per_s, buckets: DashMap::new() }
    }

    /// Takes a token for a call. The token of a call that does not wait for it is lost.
    pub(super) fn take(&self, identity: &Identity, now: Instant) -> RateDecision {
        if self.per_s == 0 {
            return RateDecision::Now;
        }
        let rate = f64::from(self.per_s);
        if self.buckets.len() >= MOST {
            // From the deepest debt to a full bucket.
            let fills = LONGEST + Duration::from_secs(1);
            self.buckets.retain(|_, bucket| now.saturating_duration_since(bucket.at) < fills);
        }
        let key = (identity.tenant.clone(), identity.name.clone());
        let new = || IdentityBucket { at: now, calls: rate, held: Arc::default() };
        let mut bucket = self.buckets.entry(key).or_insert_with(new);
        let gained = now.saturating_duration_since(bucket.at).as_secs_f64() * rate;
        bucket.calls = (bucket.calls + gained).min(rate);
        bucket.at = bucket.at.max(now);
        if bucket.calls >= 1.0 {
            bucket.calls -= 1.0;
            return RateDecision::Now;
        }
        let wait = Duration::from_secs_f64((1.0 - bucket.calls) / rate);
        if wait > LONGEST || bucket.held.load(Ordering::Relaxed) >= MOST_HELD {
            return RateDecision::Never(wait);
        }
        bucket.calls -= 1.0;
        bucket.held.fetch_add(1, Ordering::Relaxed);
        RateDecision::After(wait, DeferredCall(bucket.held.clone()))
    }
}

#[cfg(test)]
mod tests {
    use super::super::Role;
    use super::*;

    fn identity(name: &str) -> Identity {
        Identity { name: name.into(), tenant: "t".into(), role: Role::Read }
    }

    #[test]
    fn an_identity_gets_its_rate_and_no_other_pays_for_it() {
        let (one, other) = (identity("one"), identity("other"));
        let rates = IdentityRateLimiter::new(10);
        let begin = Instant::now();
        assert!((0..10).all(|_| matches!(rates.take(&one, begin), RateDecision::Now)));
        // The next ten tokens are those of the next second, each for one call.
        let mut held = Vec::new();
        for number in 1..=10 {
            let RateDecision::After(wait, call) = rates.take(&one, begin) else { panic!("call {number} is not held") };
            assert_eq!(wait, Duration::from_millis(100 * number));
            held.push(call);
        }
        let RateDecision::Never(wait) = rates.take(&one, begin) else {
            panic!("nobody waits for longer than a second")
        };
        assert_eq!(wait, Duration::from_millis(1100));
        assert!(matches!(rates.take(&other, begin), RateDecision::Now));
        let soon = begin + Duration::from_millis(100);
        assert!(
            matches!(rates.take(&one, soon), RateDecision::After(LONGEST, _)),
            "a token has come and is taken in advance"
        );
        assert!(matches!(rates.take(&one, soon), RateDecision::Never(_)));
        let later = begin + Duration::from_secs(60);
        let passed = (0..20).filter(|_| matches!(rates.take(&one, later), RateDecision::Now)).count();
        assert_eq!(passed, 10, "no more than a second is saved");
        let unlimited = IdentityRateLimiter::new(0);
        assert!((0..1000).all(|_| matches!(unlimited.take(&one, begin), RateDecision::Now)));
    }

    /// A clock that stops for a while, callers without pauses: the calls that pass match the rate in any case.
    #[test]
    fn what_passes_in_a_time_is_the_rate_however_often_it_is_asked_for() {
        let (rates, one, begin) = (IdentityRateLimiter::new(100), identity("one"), Instant::now());
        let mut due: Vec<Duration> = Vec::new();
        for ms in 0..5000 {
            let now = begin + Duration::from_millis(ms);
            for _ in 0..17 {
                match rates.take(&one, now) {
                    RateDecision::Now => due.push(Duration::from_millis(ms)),
                    RateDecision::After(wait, _) => due.push(Duration::from_millis(ms) + wait),
                    RateDecision::Never(_) => {}
                }
            }
        }
        due.sort();
        for (number, at) in due.iter().enumerate() {
            let most = 100.0 + at.as_secs_f64() * 100.0 + 1.0;
            assert!((number as f64) < most, "call {number} passes after {at:?}");
        }
        assert!(due.len() >= 599, "the rate is used: {}", due.len());
    }

    #[test]
    fn a_bounded_number_of_calls_waits_and_one_that_leaves_makes_room() {
        let (rates, one, begin) = (IdentityRateLimiter::new(10_000), identity("one"), Instant::now());
        assert!((0..10_000).all(|_| matches!(rates.take(&one, begin), RateDecision::Now)));
        let mut held: Vec<RateDecision> = (0..MOST_HELD).map(|_| rates.take(&one, begin)).collect();
        assert!(held.iter().all(|turn| matches!(turn, RateDecision::After(..))));
        assert!(matches!(rates.take(&one, begin), RateDecision::Never(_)), "though its token is there soon");
        assert!(matches!(rates.take(&identity("other"), begin), RateDecision::Now));
        held.pop();
        assert!(matches!(rates.take(&one, begin), RateDecision::After(..)));
    }
}
