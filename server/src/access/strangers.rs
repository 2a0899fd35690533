//! Refused calls without an identity, by address: the first ones of a minute are noted, the others are counted.
//!
//! Invariant: the memory is bounded, however many addresses there are; a call that is not noted is counted in the next
//! line of its address, or in a line of its own when the address is forgotten.

use std::collections::HashMap;
use std::net::IpAddr;
use std::time::{Duration, Instant};

use super::refused::known_by;

/// Lines of an address in one span of time.
const LINES: u32 = 10;
pub(crate) const SPAN: Duration = Duration::from_secs(60);
/// Most addresses; beyond that all others count together.
const ADDRESSES: usize = 4096;

/// The refused calls of an address.
#[derive(Debug, Clone, Copy)]
struct RefusedCalls {
    since: Instant,
    lines: u32,
    left_out: u64,
}

/// Refused calls of strangers; those of addresses without room have no address.
#[derive(Debug, Default)]
pub(super) struct Strangers(HashMap<Option<IpAddr>, RefusedCalls>);

/// Calls of an address that have no line.
pub(super) type LeftOut = (Option<IpAddr>, u64);

impl Strangers {
    /// Counts a call; the number of calls that were left out before it, if it is to be noted.
    pub(super) fn refused(&mut self, address: IpAddr, now: Instant) -> Option<LeftOut> {
        let key = Some(known_by(address));
        let key = key.filter(|_| self.0.contains_key(&key) || self.0.len() < ADDRESSES);
        let calls = self.0.entry(key).or_insert(RefusedCalls { since: now, lines: 0, left_out: 0 });
        if now.duration_since(calls.since) >= SPAN {
            (calls.since, calls.lines) = (now, 0);
        }
        if calls.lines >= LINES {
            calls.left_out += 1;
            return None;
        }
        calls.lines += 1;
        Some((key, std::mem::take(&mut calls.left_out)))
    }

    /// Forgets the addresses of earlier minutes, or all at an end; returns those whose calls have been left out, by
    /// address.
    pub(super) fn forget(&mut self, now: Instant, all: bool) -> Vec<LeftOut> {
        let gone = self.0.extract_if(|_, calls| all || now.duration_since(calls.since) >= SPAN);
        let left_out = gone.filter(|(_, calls)| calls.left_out > 0).map(|(address, calls)| (address, calls.left_out));
        let mut left_out: Vec<LeftOut> = left_out.collect();
        left_out.sort_unstable();
        left_out
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
        let mut refused = |number, now| strangers.refused(address(number), now).map(|(_, left_out)| left_out);
        let noted: Vec<_> = (0..25).map(|_| refused(1, now)).collect();
        assert!(noted.iter().take(10).all(|noted| *noted == Some(0)) && noted.iter().skip(10).all(Option::is_none));
        assert_eq!(refused(2, now), Some(0), "each address for itself");
        assert_eq!(refused(1, now + SPAN), Some(15));
        assert_eq!(refused(1, now + SPAN), Some(0));
    }

    #[test]
    fn every_refused_call_is_noted_or_counted_however_many_addresses_there_are() {
        let (mut strangers, now) = (Strangers::default(), Instant::now());
        let mut noted = 0;
        for number in 0..50_000 {
            noted += u64::from(strangers.refused(address(number), now).is_some());
        }
        assert_eq!((strangers.0.len(), noted), (ADDRESSES + 1, ADDRESSES as u64 + 10));
        // An address without room makes many guesses, and one with room.
        for number in [70_000, 7] {
            noted += (0..200).filter(|_| strangers.refused(address(number), now).is_some()).count() as u64;
        }
        assert_eq!(strangers.forget(now, false), [], "their minute is not over");
        let left_out = strangers.forget(now + SPAN, false);
        assert_eq!(left_out, [(None, 50_400 - noted - 191), (Some(address(7)), 191)]);
        assert!(strangers.0.is_empty());
    }

    #[test]
    fn the_addresses_of_a_network_count_as_one() {
        let (mut strangers, now) = (Strangers::default(), Instant::now());
        let network: u128 = 0x2001_0db8 << 96;
        let noted =
            (0..5000u128).filter(|host| strangers.refused(IpAddr::from((network | host).to_be_bytes()), now).is_some());
        assert_eq!(noted.count(), 10);
        assert_eq!(strangers.forget(now, true), [(Some(IpAddr::from(network.to_be_bytes())), 4990)]);
    }
}
