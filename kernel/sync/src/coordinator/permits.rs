//! How many kernels may run at once.
//!
//! Invariant: a free permit goes to the waiting kernel that is furthest behind in simulated time.

use super::locks::atomic::Ordering::SeqCst;
use super::wait_method::WaitMethod;
use super::{Coordinator, CoordinatorState, Guard};

impl Coordinator {
    /// Whether some other kernel waits for a permit and is before `t`.
    pub fn should_yield(&self) -> bool {
        self.limited && self.waiting_permits.load(SeqCst) > 0
    }

    /// Gives the permit to the kernel that is furthest behind, if that is not this one.
    pub fn yield_permit(&self, channel: u16) {
        let mut inner = self.lock();
        let own = self.bound(channel);
        if inner.queue.iter().any(|&(bound, _)| bound < own) {
            self.release_permit(&mut inner);
            drop(self.acquire_permit(channel, inner));
        }
    }

    /// Takes the first permit of a kernel.
    pub fn begin(&self, channel: u16) {
        let inner = self.lock();
        drop(self.acquire_permit(channel, inner));
    }

    pub(super) fn release_permit(&self, inner: &mut CoordinatorState) {
        inner.permits += 1;
        if let Some(&(_, channel)) = inner.queue.iter().min() {
            self.signal(channel);
        }
    }

    pub(super) fn acquire_permit<'a>(&'a self, channel: u16, mut inner: Guard<'a>) -> Guard<'a> {
        if !self.limited {
            return inner;
        }
        let own = (self.bound(channel), channel);
        inner.queue.push(own);
        self.waiting_permits.fetch_add(1, SeqCst);
        while inner.permits == 0 || inner.queue.iter().min() != Some(&own) {
            inner = self.sleep(channel, inner, WaitMethod::Thread);
        }
        inner.permits -= 1;
        inner.queue.retain(|entry| *entry != own);
        self.waiting_permits.fetch_sub(1, SeqCst);
        if inner.permits > 0
            && let Some(&(_, next)) = inner.queue.iter().min()
        {
            self.signal(next);
        }
        inner
    }
}
