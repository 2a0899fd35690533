//! The request that a job ends, that it is suspended for a while, and that its operator is asked before every block.

use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};

/// The job is to end.
const END: u8 = 1;

/// The job is stepped through.
const STEPPED: u8 = 2;

/// The job lets others have the processor.
const SUSPENDED: u8 = 4;

/// The request that a job ends. It may exist before the job does, and all long work for the job checks it. Kernels
/// check it before every block. So a stepped job and a suspended job are also marked here, at no cost for other jobs.
/// *Invariant:* the end takes precedence: a kernel that is to end never waits.
#[derive(Debug, Clone, Default)]
pub struct StopSignal(Arc<StopFlags>);

#[derive(Debug, Default)]
struct StopFlags {
    bits: AtomicU8,
    /// Held while the end is requested and while a suspension ends, so that no new waiter misses it.
    changing: Mutex<()>,
    changed: Condvar,
}

impl StopSignal {
    /// Asks for the end; it is never taken back.
    pub fn ask(&self) {
        self.0.bits.fetch_or(END, Ordering::Relaxed);
        self.wake();
    }

    /// Whether the end was requested.
    #[must_use]
    #[inline(always)]
    pub fn asked(&self) -> bool {
        self.bits() & END != 0
    }

    /// Lets the threads of the job wait before their next block, or at the next look of long work, until
    /// [`resume`](Self::resume). The events of the job stay the same.
    pub fn suspend(&self) {
        self.0.bits.fetch_or(SUSPENDED, Ordering::Relaxed);
    }

    /// Lets the threads of the job continue.
    pub fn resume(&self) {
        self.0.bits.fetch_and(!SUSPENDED, Ordering::Relaxed);
        self.wake();
    }

    /// Waits while the job is suspended and is not to end.
    #[inline(always)]
    pub(crate) fn wait_while_suspended(&self) {
        if self.bits() & SUSPENDED != 0 {
            self.sleep();
        }
    }

    /// Waits while the job is suspended, then tells whether its end was requested. For long work between blocks, on a
    /// thread of the job.
    #[must_use]
    #[inline(always)]
    pub fn asked_once_resumed(&self) -> bool {
        self.bits() != 0 && self.ends_once_resumed()
    }

    #[cold]
    #[inline(never)]
    fn ends_once_resumed(&self) -> bool {
        self.wait_while_suspended();
        self.asked()
    }

    #[cold]
    #[inline(never)]
    fn sleep(&self) {
        let mut changing = self.0.changing.lock().unwrap_or_else(PoisonError::into_inner);
        while self.bits() & (SUSPENDED | END) == SUSPENDED {
            changing = self.0.changed.wait(changing).unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn wake(&self) {
        drop(self.0.changing.lock().unwrap_or_else(PoisonError::into_inner));
        self.0.changed.notify_all();
    }

    fn bits(&self) -> u8 {
        self.0.bits.load(Ordering::Relaxed)
    }

    /// Starts or ends stepping through the job.
    pub(crate) fn set_stepped(&self, stepped: bool) {
        if stepped {
            self.0.bits.fetch_or(STEPPED, Ordering::Relaxed);
        } else {
            self.0.bits.fetch_and(!STEPPED, Ordering::Relaxed);
        }
    }

    /// Whether the end was requested, the job is suspended, or is stepped through.
    #[inline(always)]
    pub(crate) fn interferes(&self) -> bool {
        self.bits() != 0
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{RecvTimeoutError, channel};
    use std::time::Duration;

    use super::*;

    /// A thread that waits while the job is suspended, and whether it was to end when it came through.
    fn waiting(stop: &StopSignal) -> std::sync::mpsc::Receiver<bool> {
        let (through, came) = channel();
        let stop = stop.clone();
        std::thread::spawn(move || {
            let _ = through.send(stop.asked_once_resumed());
        });
        came
    }

    #[test]
    fn a_suspended_job_waits_until_it_is_resumed_or_to_end() {
        for (end, asked) in [(StopSignal::resume as fn(&StopSignal), false), (StopSignal::ask, true)] {
            let stop = StopSignal::default();
            stop.suspend();
            let came = waiting(&stop);
            assert_eq!(came.recv_timeout(Duration::from_millis(20)), Err(RecvTimeoutError::Timeout));
            end(&stop);
            assert_eq!(came.recv_timeout(Duration::from_secs(60)), Ok(asked));
            assert_eq!(waiting(&stop).recv_timeout(Duration::from_secs(60)), Ok(asked));
        }
    }

    #[test]
    fn a_job_that_is_to_end_is_never_kept() {
        let stop = StopSignal::default();
        stop.ask();
        stop.suspend();
        assert_eq!(waiting(&stop).recv_timeout(Duration::from_secs(60)), Ok(true));
        assert!(stop.asked());
    }
}
