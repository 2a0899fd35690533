//! How often calls without a known identity are answered: so many a second of each address.
//!
//! An address has a bucket that fills at the rate and holds a second's worth. *Invariants:* a call with a known identity
//! is never counted, whatever others of its address do; the memory is bounded, however many addresses there are.

use std::collections::HashMap;
use std::net::{IpAddr, Ipv6Addr};
use std::time::{Duration, Instant};

/// Most addresses; beyond that those with full buckets are forgotten, and all others share a bucket.
const ADDRESSES: usize = 4096;

/// The calls that an address may still make.
#[derive(Debug, Clone, Copy)]
struct AddressBucket {
    at: Instant,
    calls: f64,
}

/// The buckets.
#[derive(Debug)]
pub(super) struct AddressRateLimiter {
    /// 0 = without limit.
    per_s: u32,
    buckets: HashMap<Option<IpAddr>, AddressBucket>,
}

/// The address by which a caller is known: of IPv6 the network, since a host has any number of addresses in it.
pub(super) fn known_by(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(address) => IpAddr::V6(Ipv6Addr::from_bits(address.to_bits() >> 64 << 64)),
        address => address,
    }
}

impl AddressRateLimiter {
    pub(super) fn new(per_s: u32) -> Self {
        Self { per_s, buckets: HashMap::new() }
    }

    /// Counts a refused call; the time until the next one is answered, if it comes too often.
    pub(super) fn count(&mut self, address: IpAddr, now: Instant) -> Option<Duration> {
        if self.per_s == 0 {
            return None;
        }
        let rate = f64::from(self.per_s);
        let mut key = Some(known_by(address));
        if !self.buckets.contains_key(&key) && self.buckets.len() >= ADDRESSES {
            self.buckets.retain(|_, bucket| now.saturating_duration_since(bucket.at) < Duration::from_secs(1));
            if self.buckets.len() >= ADDRESSES {
                key = None;
            }
        }
        let bucket = self.buckets.entry(key).or_insert(AddressBucket { at: now, calls: rate });
        let gained = now.saturating_duration_since(bucket.at).as_secs_f64() * rate;
        (bucket.at, bucket.calls) = (bucket.at.max(now), (bucket.calls + gained).min(rate));
        if bucket.calls >= 1.0 {
            bucket.calls -= 1.0;
            return None;
        }
        Some(Duration::from_secs_f64((1.0 - bucket.calls) / rate))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_has_its_rate_and_no_other_pays_for_it() {
        let (mut refused, now) = (AddressRateLimiter::new(5), Instant::now());
        let one: IpAddr = "10.0.0.1".parse().unwrap();
        assert!((0..5).all(|_| refused.count(one, now).is_none()));
        assert_eq!(refused.count(one, now), Some(Duration::from_millis(200)));
        assert_eq!(refused.count("::ffff:10.0.0.1".parse().unwrap(), now), Some(Duration::from_millis(200)));
        assert_eq!(refused.count("10.0.0.2".parse().unwrap(), now), None);
        let later = now + Duration::from_millis(400);
        assert_eq!([0; 3].map(|_| refused.count(one, later).is_none()), [true, true, false]);
        let network = |host: u64| IpAddr::from(Ipv6Addr::from_bits((0x2001_0db8 << 96) | u128::from(host)));
        assert_eq!((0..100).filter(|host| refused.count(network(*host), now).is_none()).count(), 5);
        let mut unlimited = AddressRateLimiter::new(0);
        assert!((0..1000).all(|_| unlimited.count(one, now).is_none()));
    }

    #[test]
    fn many_addresses_take_bounded_memory() {
        let (mut refused, now) = (AddressRateLimiter::new(1), Instant::now());
        let answered =
            (0..50_000u32).filter(|number| refused.count(number.to_be_bytes().into(), now).is_none()).count();
        assert_eq!((refused.buckets.len(), answered), (ADDRESSES + 1, ADDRESSES + 1));
        assert_eq!(refused.count(70_000u32.to_be_bytes().into(), now + Duration::from_secs(1)), None);
        assert_eq!(refused.buckets.len(), 1, "those of the last second are forgotten");
    }
}
