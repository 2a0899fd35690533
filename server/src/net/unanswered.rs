//! Calls that end without an answer.
//!
//! *Invariant:* a call that may have changed something has a line in the audit log, even if its client ended the call
//! or its deadline passed. The line is written when the work of the call is done.

use std::sync::Arc;
use std::time::Duration;

use http::Response;
use tonic::body::Body;

use super::Peer;
use crate::access::Caller;

/// A call that has not been answered yet. If its client ends it or its deadline passes, its future is dropped, and the
/// audit log gets a line.
pub(super) struct Unanswered {
    peer: Arc<Peer>,
    caller: Option<Caller>,
    /// Empty once the call has an answer.
    path: String,
    end: CallEnd,
}

/// The reason why a call has no answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum CallEnd {
    /// The client has ended it.
    Client,
    /// Its deadline has passed.
    Deadline,
}

impl Unanswered {
    pub(super) fn new(peer: Arc<Peer>, caller: Option<Caller>, path: String) -> Self {
        Self { peer, caller, path, end: CallEnd::Client }
    }

    /// Records that the call was answered.
    pub(super) fn answered(mut self, response: &Response<Body>, time: Duration) {
        let path = std::mem::take(&mut self.path);
        self.peer.gate.answered(self.peer.address, self.caller.as_ref(), &path, response, time);
    }

    /// Records that the deadline of the call has passed; `response` reports it.
    pub(super) fn late(mut self, response: &Response<Body>, time: Duration) {
        self.end = CallEnd::Deadline;
        self.peer.gate.counted(&self.path, response, time);
    }
}

impl Drop for Unanswered {
    fn drop(&mut self) {
        if self.path.is_empty() {
            return;
        }
        let (peer, path, end) = (self.peer.clone(), std::mem::take(&mut self.path), self.end);
        match &self.caller {
            None => peer.gate.unanswered(peer.address, None, &path, (&[], end)),
            Some(caller) => {
                let identity = caller.identity.clone();
                caller.note_at_the_end(move |targets| {
                    peer.gate.unanswered(peer.address, Some(&identity), &path, (&targets, end));
                });
            }
        }
    }
}
