//! The one switch that says: the server is going down.
//!
//! Invariant: once begun it never ends.

use tokio::sync::watch;

/// Whether the server drains.
#[derive(Debug)]
pub(crate) struct Drain(watch::Sender<bool>);

impl Drain {
    pub(crate) fn new() -> Self {
        Self(watch::Sender::new(false))
    }

    pub(crate) fn begin(&self) {
        self.0.send_replace(true);
    }

    pub(crate) fn begun(&self) -> bool {
        *self.0.borrow()
    }

    pub(crate) fn follow(&self) -> watch::Receiver<bool> {
        self.0.subscribe()
    }
}
