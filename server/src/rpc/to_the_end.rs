//! Changes that must not stop halfway.
//!
//! *Invariant:* a change that has been handed over is completed, even if the client ends the call or its deadline
//! passes. While the client waits, the change runs within the call, because a separate task costs a wake-up.

use std::pin::Pin;
use std::task::{Context, Poll};

use tokio::runtime::Handle;
use tracing::Instrument as _;

use crate::access::Caller;
use crate::reason::Refusal;

/// The rest of a change.
type Work<T> = Pin<Box<dyn Future<Output = Result<T, Refusal>> + Send>>;

/// A change in progress. If it is dropped, the rest of the change becomes a separate task.
pub(super) struct ToTheEnd<T: Send + 'static> {
    runtime: Handle,
    /// Dropped after the work; the audit log then gets the line of the call.
    caller: Caller,
    /// `None` after the end.
    work: Option<Work<T>>,
}

/// Completes a change. The audit log gets the line of the call after the change.
pub(super) fn to_the_end<T: Send + 'static>(
    caller: &Caller,
    work: impl Future<Output = Result<T, Refusal>> + Send + 'static,
) -> ToTheEnd<T> {
    caller.begins();
    let work: Work<T> = Box::pin(work.in_current_span());
    ToTheEnd { runtime: Handle::current(), caller: caller.clone(), work: Some(work) }
}

impl<T: Send + 'static> Future for ToTheEnd<T> {
    type Output = Result<T, Refusal>;

    fn poll(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Self::Output> {
        // Work that panics is not continued.
        let Some(mut work) = self.work.take() else { return Poll::Pending };
        let polled = work.as_mut().poll(context);
        if polled.is_pending() {
            self.work = Some(work);
        }
        polled
    }
}

impl<T: Send + 'static> Drop for ToTheEnd<T> {
    fn drop(&mut self) {
        if let Some(work) = self.work.take() {
            let caller = self.caller.clone();
            self.runtime.spawn(async move {
                let _ = work.await;
                drop(caller);
            });
        }
    }
}
