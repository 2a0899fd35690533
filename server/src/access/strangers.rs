//! Refused calls without an identity, by address: the first ones of a minute are noted, the others are counted.
//!
//! Invariant: the memory is bounded, however many addresses there are; a call that is not noted is counted in the next
//! line of its address.

use std::collections::HashMap;
use std::net::IpAddr;
use std::time::{Duration, Instant};

/// Lines of an address in one span of time.
const LINES: u32 = 10;
const SPAN: Duration = Duration::from_secs(60);
/// Most addresses; beyond that those of earlier spans are forgotten, and all others count together.
const ADDRESSES: usize = 4096;

/// The refused calls of an address.
#[derive(Debug, Clone, Copy)]
struct Calls {
    since: Instant,
    lines: u32,
    left_out: u64,
}

/// Refused calls of strangers.
#[derive(Debug, Default)]
pub(super) struct Strangers(HashMap<Option<IpAddr>, Calls>);

impl Strangers {
    /// Counts a call; the number of calls that were left out before it, if it is to be noted.
    pub(super) fn refused(&mut self, address: IpAddr, now: Instant) -> Option<u64> {
        let mut key = Some(address);
        if !self.0.contains_key(&key) && self.0.len() >= ADDRESSES {
            self.0.retain(|_, calls| now.duration_since(calls.since) < SPAN);
            if self.0.len() >= ADDRESSES {
                key = None;
            }
        }
        let calls = self.0.entry(key).or_insert(Calls { since: now, lines: 0, left_out: 0 });
        if now.duration_since(calls.since) >= SPAN {
            (calls.since, calls.lines) = (now, 0);
        }
        if calls.lines >= LINES {
            calls.left_out += 1;
            return None;
        }
        calls.lines += 1;
        Some(std::mem::take(&mut calls.left_out))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn address(number: u32) -> IpAddr {
        IpAddr::from(number.to_be_bytes())
    }

    #[test]
    fn the_first_calls_of_a_minute_are_noted_and_the_others_counted() {
        let (mut strangers, now) = (Strangers::default(), Instant::now());
        let noted: Vec<_> = (0..25).map(|_| strangers.refused(address(1), now)).collect();
        assert!(noted.iter().take(10).all(|noted| *noted == Some(0)) && noted.iter().skip(10).all(Option::is_none));
        assert_eq!(strangers.refused(address(2), now), Some(0), "each address for itself");
        assert_eq!(strangers.refused(address(1), now + SPAN), Some(15));
        assert_eq!(strangers.refused(address(1), now + SPAN), Some(0));
    }

    #[test]
    fn many_addresses_take_bounded_memory_and_lines() {
        let (mut strangers, now) = (Strangers::default(), Instant::now());
        let noted = (0..50_000).filter(|number| strangers.refused(address(*number), now).is_some()).count();
        assert_eq!((strangers.0.len(), noted), (ADDRESSES + 1, ADDRESSES + 10));
        assert_eq!(strangers.refused(address(70_000), now + SPAN), Some(0), "those of the last minute are forgotten");
        assert_eq!(strangers.0.len(), 1);
    }
}
