//! How a kernel waits for another kernel: spinning, giving the processor away, sleeping.
//!
//! Invariant: signals are given under the coordinator's lock, so none is lost between the last look and the sleep.

use std::time::{Duration, Instant};

use super::locks::atomic::Ordering::{Relaxed, SeqCst};
use super::locks::{PoisonError, spin_loop, yield_now};
use super::wait_method::{WaitMethod, YieldReason};
use super::{Coordinator, Guard, Slot};

/// Checks of the signal before the processor is given away, if every kernel has a processor: the partner runs, or
/// continues after its time slice, and a kernel that still spins then loses nothing. Below 500, a machine with other
/// work occasionally separates the kernels of a job, so that they no longer run at the same time.
pub(super) const TURNS: u32 = if cfg!(all(test, feature = "shuttle")) { 2 } else { 1200 };

/// The same, if there are more kernels than may run at once: a spinning kernel keeps another kernel from running.
pub(super) const FEW_TURNS: u32 = if cfg!(all(test, feature = "shuttle")) { 2 } else { 150 };

/// Turns of the processor given away before a waiting thread is put to sleep.
const YIELDS: u32 = if cfg!(all(test, feature = "shuttle")) { 1 } else { 300 };

/// A turn given away that takes longer was used by another program.
const SLICE: Duration = Duration::from_micros(200);

/// Waits that sleep at once after the first such turn.
pub(super) const CROWDED_WAITS: u32 = 256;

/// Waits that sleep at once after many such turns: each of them costs a time slice of another program.
const MOST_CROWDED_WAITS: u32 = 1 << 16;

/// Turns after which a kernel that waits looks again how far the others are: looking slows them down.
const LOOK_EVERY: u32 = 64;

impl Coordinator {
    pub(super) fn signal(&self, channel: u16) {
        let Some(slot) = self.slot(channel) else { return };
        if self.one_thread {
            // No kernel spins or sleeps at the condition: the master runs the kernels that are awake.
            slot.asleep.store(false, Relaxed);
            return;
        }
        slot.signal.fetch_add(1, SeqCst);
        if slot.asleep.swap(false, SeqCst) {
            slot.condvar.notify_one();
        }
    }

    /// Sleeps until a signal, or runs other kernels meanwhile.
    pub(super) fn sleep<'a>(&'a self, channel: u16, inner: Guard<'a>, switch: WaitMethod<'_>) -> Guard<'a> {
        let Some(slot) = self.slot(channel) else { return inner };
        match switch {
            WaitMethod::Thread => {
                slot.asleep.store(true, SeqCst);
                let inner = slot.condvar.wait(inner).unwrap_or_else(PoisonError::into_inner);
                slot.note_processor();
                inner
            }
            WaitMethod::Coroutine(yielder) => {
                slot.asleep.store(true, Relaxed);
                drop(inner);
                yielder.suspend(YieldReason::Sleep);
                self.lock()
            }
        }
    }

    /// Whether the kernel waits for a signal that has not come yet.
    pub fn sleeps(&self, channel: u16) -> bool {
        self.slot(channel).is_some_and(|slot| slot.asleep.load(SeqCst))
    }

    /// Does pending work (`true`: with a look at the progress of the other kernels) and spins, until the signal comes
    /// or the patience is over.
    pub(super) fn spin_for_signal(&self, slot: &Slot, seen: u32, mut work: impl FnMut(bool) -> bool) {
        let signalled = || slot.signal.load(SeqCst) != seen;
        for turn in 0..self.spin {
            while !signalled() && work(turn % LOOK_EVERY == LOOK_EVERY - 1) {}
            if signalled() {
                return;
            }
            spin_loop();
        }
        self.give_way(signalled);
    }

    /// Gives the processor to threads with work (most of all the merger) for a while, until `over`, before the thread
    /// is put to sleep. If other programs also want the processors, a thread that yields loses a whole time slice, and
    /// one that sleeps is woken at once: then it sleeps.
    fn give_way(&self, over: impl Fn() -> bool) {
        let crowded = self.crowded.load(Relaxed);
        if crowded > 0 {
            self.crowded.store(crowded - 1, Relaxed);
            return;
        }
        for _ in 0..YIELDS {
            if over() {
                let waits = self.crowded_waits.load(Relaxed);
                if waits > CROWDED_WAITS {
                    self.crowded_waits.store(waits / 2, Relaxed);
                }
                return;
            }
            let before = Instant::now();
            yield_now();
            if before.elapsed() > SLICE {
                let waits = self.crowded_waits.load(Relaxed);
                self.crowded.store(waits, Relaxed);
                self.crowded_waits.store(waits.saturating_mul(4).min(MOST_CROWDED_WAITS), Relaxed);
                return;
            }
        }
    }
}
