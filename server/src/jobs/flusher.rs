//! Makes single events readable: a log is written in large pieces, and a watcher may wait for the last few.
//!
//! Invariant: an event of a watched job is readable [`DELAY`] after it was appended, regardless of later events; a
//! kernel never waits for that.

use std::io;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Weak};
use std::time::{Duration, Instant};

use super::live::LiveJob;

/// Longest time that an event of a watched job stays in memory only.
const DELAY: Duration = Duration::from_millis(5);

/// Jobs whose logs are to be written soon, in the order of their time.
#[derive(Debug, Clone)]
pub(crate) struct Flusher(Sender<(Instant, Weak<LiveJob>)>);

impl Flusher {
    /// Starts the thread; it ends with the last handle.
    pub(crate) fn start() -> io::Result<Self> {
        let (send, receive) = channel();
        std::thread::Builder::new().name("flush".to_owned()).spawn(move || flush(&receive))?;
        Ok(Self(send))
    }

    /// Has the log of a job written after the delay.
    pub(super) fn later(&self, live: &Arc<LiveJob>) {
        // Without the thread the server is ending.
        let _ = self.0.send((Instant::now() + DELAY, Arc::downgrade(live)));
    }
}

fn flush(jobs: &Receiver<(Instant, Weak<LiveJob>)>) {
    while let Ok((at, live)) = jobs.recv() {
        std::thread::sleep(at.saturating_duration_since(Instant::now()));
        if let Some(live) = live.upgrade() {
            live.flush();
        }
    }
}
