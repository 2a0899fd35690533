//! How a kernel waits for another one: spinning, giving the core away, sleeping.
//!
//! Invariant: signals are given under the coordinator's lock, so none is lost between the last look and the sleep.

use std::sync::PoisonError;
use std::sync::atomic::Ordering::{Relaxed, SeqCst};
use std::time::{Duration, Instant};

use super::switch::{Pause, Switch};
use super::{Coordinator, Guard, Slot};

/// Turns of the core given away before a waiting thread is put to sleep.
const YIELDS: u32 = 300;

/// A turn given away that takes longer was used by another program.
const SLICE: Duration = Duration::from_micros(200);

/// Waits after such a turn that sleep at once.
const CROWDED_WAITS: u32 = 256;

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

    /// Waits for a signal: on a thread of its own spinning for a short while first, else while other kernels run.
    pub(super) fn sleep<'a>(&'a self, rank: u16, inner: Guard<'a>, switch: Switch<'_>) -> Guard<'a> {
        let Some(slot) = self.slot(rank) else { return inner };
        if let Switch::Coroutine(yielder) = switch {
            slot.asleep.store(true, SeqCst);
            drop(inner);
            yielder.suspend(Pause::Sleep);
            return self.lock();
        }
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

    /// The kernel waits for a signal that has not come yet.
    pub(crate) fn sleeps(&self, rank: u16) -> bool {
        self.slot(rank).is_some_and(|slot| slot.asleep.load(SeqCst))
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
        self.give_way(signalled);
    }

    /// Gives the core to whoever has work (the merger, most of all) for a while, until `over`, before the thread is put to
    /// sleep. Where others want the processors too, a thread that gives way loses a whole time slice, and one that sleeps
    /// is woken at once: then it sleeps.
    pub(super) fn give_way(&self, over: impl Fn() -> bool) {
        let crowded = self.crowded.load(Relaxed);
        if crowded > 0 {
            self.crowded.store(crowded - 1, Relaxed);
            return;
        }
        for _ in 0..YIELDS {
            if over() {
                return;
            }
            let before = Instant::now();
            std::thread::yield_now();
            if before.elapsed() > SLICE {
                self.crowded.store(CROWDED_WAITS, Relaxed);
                return;
            }
        }
    }
}
