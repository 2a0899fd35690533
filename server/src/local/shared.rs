//! Work that many ask for at the same time and that is done once for all of them.
//!
//! Invariant: every request gets the result of work that began after it.

use std::io;
use std::sync::{Condvar, Mutex, PoisonError};

/// How far the work is.
#[derive(Debug, Default)]
struct Rounds {
    begun: u64,
    done: u64,
    /// Work is in progress.
    under_way: bool,
    /// The error of the last round.
    failed: Option<(io::ErrorKind, String)>,
}

/// The work.
#[derive(Debug, Default)]
pub(crate) struct CoalescedWork {
    rounds: Mutex<Rounds>,
    changed: Condvar,
}

impl CoalescedWork {
    /// Does `work`, or waits for another task that begins it now or later.
    pub(crate) fn sync(&self, work: impl FnOnce() -> io::Result<()>) -> io::Result<()> {
        let mut rounds = self.rounds.lock().unwrap_or_else(PoisonError::into_inner);
        let needed = rounds.begun + 1;
        while rounds.under_way && rounds.done < needed {
            rounds = self.changed.wait(rounds).unwrap_or_else(PoisonError::into_inner);
        }
        if rounds.done >= needed {
            return match &rounds.failed {
                None => Ok(()),
                Some((kind, text)) => Err(io::Error::new(*kind, text.clone())),
            };
        }
        rounds.begun += 1;
        rounds.under_way = true;
        let round = rounds.begun;
        drop(rounds);
        let result = work();
        let mut rounds = self.rounds.lock().unwrap_or_else(PoisonError::into_inner);
        (rounds.done, rounds.under_way) = (round, false);
        rounds.failed = result.as_ref().err().map(|error| (error.kind(), error.to_string()));
        self.changed.notify_all();
        result
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::sync::mpsc::channel;

    use super::*;

    #[test]
    fn those_who_ask_while_others_work_share_the_next_round() {
        let (shared, rounds) = (Arc::new(CoalescedWork::default()), Arc::new(AtomicUsize::new(0)));
        let (go, wait) = channel::<()>();
        let first = {
            let (shared, rounds) = (shared.clone(), rounds.clone());
            std::thread::spawn(move || {
                shared.sync(|| {
                    rounds.fetch_add(1, Ordering::SeqCst);
                    wait.recv().unwrap();
                    Err(io::Error::other("first"))
                })
            })
        };
        while rounds.load(Ordering::SeqCst) == 0 {
            std::thread::yield_now();
        }
        let others: Vec<_> = (0..8)
            .map(|_| {
                let (shared, rounds) = (shared.clone(), rounds.clone());
                std::thread::spawn(move || {
                    shared.sync(|| {
                        rounds.fetch_add(1, Ordering::SeqCst);
                        Ok(())
                    })
                })
            })
            .collect();
        // All of them wait, as far as is known.
        while Arc::strong_count(&shared) < 10 {
            std::thread::yield_now();
        }
        go.send(()).unwrap();
        assert!(first.join().unwrap().is_err());
        for other in others {
            other.join().unwrap().expect("the round that failed began before they asked");
        }
        assert!((2..=9).contains(&rounds.load(Ordering::SeqCst)));
    }
}
