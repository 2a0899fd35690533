//! Places for things that are limited in all and per owner.
//!
//! Invariant: a place is given back when it is dropped, and owners without places take no memory.

use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Arc, Mutex, PoisonError};

/// Places of a kind.
#[derive(Debug)]
pub(crate) struct SlotLimiter<K> {
    most: usize,
    most_each: usize,
    taken: Mutex<(usize, HashMap<K, usize>)>,
}

/// A place that is taken.
#[derive(Debug)]
pub(crate) struct LimitedSlot<K: Eq + Hash> {
    places: Arc<SlotLimiter<K>>,
    owner: K,
}

impl<K: Eq + Hash + Clone> SlotLimiter<K> {
    /// `most` in all and `most_each` per owner.
    pub(crate) fn new(most: usize, most_each: usize) -> Self {
        Self { most, most_each, taken: Mutex::default() }
    }

    /// A place, if there is one for this owner.
    pub(crate) fn take(self: &Arc<Self>, owner: K) -> Option<LimitedSlot<K>> {
        self.take_of(owner, self.most_each)
    }

    /// A place, if this owner has fewer than so many.
    pub(crate) fn take_of(self: &Arc<Self>, owner: K, most_each: usize) -> Option<LimitedSlot<K>> {
        let mut taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        let own = taken.1.get(&owner).copied().unwrap_or(0);
        if taken.0 >= self.most || own >= most_each {
            return None;
        }
        taken.0 += 1;
        taken.1.insert(owner.clone(), own + 1);
        Some(LimitedSlot { places: self.clone(), owner })
    }
}

impl<K: Eq + Hash> Drop for LimitedSlot<K> {
    fn drop(&mut self) {
        let mut taken = self.places.taken.lock().unwrap_or_else(PoisonError::into_inner);
        taken.0 -= 1;
        let left = taken.1.get_mut(&self.owner).map(|own| {
            *own -= 1;
            *own
        });
        if left == Some(0) {
            taken.1.remove(&self.owner);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_limited_in_all_and_each_and_come_back() {
        let places = Arc::new(SlotLimiter::new(3, 2));
        let (first, second) = (places.take(1), places.take(1));
        assert!(first.is_some() && second.is_some() && places.take(1).is_none());
        let third = places.take(2);
        assert!(third.is_some() && places.take(3).is_none());
        drop(first);
        assert!(places.take(3).is_some());
        drop((second, third));
        assert_eq!(*places.taken.lock().unwrap(), (0, HashMap::new()));
    }
}
