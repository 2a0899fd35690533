//! How a kernel waits for another one: spinning, giving the core away, sleeping.
//!
//! Invariant: signals are given under the coordinator's lock, so none is lost between the last look and the sleep.

use std::sync::PoisonError;
use std::sync::atomic::Ordering::SeqCst;

use super::{Coordinator, Guard, Slot};

/// Turns of the core given away before a waiting thread is put to sleep.
pub(super) const YIELDS: u32 = 300;

/// Turns after which a kernel that waits looks again how far the others are: looking slows them down.
pub(super) const LOOK_EVERY: u32 = 64;

impl Slot {
    fn sleep<'a>(&'a self, inner: Guard<'a>) -> Guard<'a> {
        self.asleep.store(true, SeqCst);
        self.condvar.wait(inner).unwrap_or_else(PoisonError::into_inner)
    }
}

impl Coordinator {
    pub(super) fn signal(&self, rank: u16) {
        if let Some(slot) = self.slot(rank) {
            slot.signal.fetch_add(1, SeqCst);
            if slot.asleep.swap(false, SeqCst) {
                slot.condvar.notify_one();
            }
        }
    }

    /// Waits for a signal, spinning for a short while first.
    pub(super) fn sleep<'a>(&'a self, rank: u16, inner: Guard<'a>) -> Guard<'a> {
        let Some(slot) = self.slot(rank) else { return inner };
        let seen = slot.signal.load(SeqCst);
        if self.spin > 0 {
            drop(inner);
            self.spin_for_signal(rank, seen, |_| false);
            let inner = self.lock();
            if slot.signal.load(SeqCst) != seen {
                return inner;
            }
            return slot.sleep(inner);
        }
        slot.sleep(inner)
    }

    /// Does what there is to do (`work(true)`: with a look at how far the others are) and spins, until the slot is signalled or the patience is over.
    pub(super) fn spin_for_signal(&self, rank: u16, seen: u32, mut work: impl FnMut(bool) -> bool) {
        let Some(slot) = self.slot(rank) else { return };
        let signalled = || slot.signal.load(SeqCst) != seen;
        for turn in 0..self.spin {
            while !signalled() && work(turn % LOOK_EVERY == LOOK_EVERY - 1) {}
            if signalled() {
                return;
            }
            std::hint::spin_loop();
        }
        // Then the core goes to whoever has work (the merger, most of all) before the thread is put to sleep.
        for _ in 0..YIELDS {
            if signalled() {
                return;
            }
            std::thread::yield_now();
        }
    }
}
