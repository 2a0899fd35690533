//! The body of an answer that keeps its call and its memory counted until it has been sent.

use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};

use bytes::Bytes;
use http_body::{Frame, SizeHint};
use tonic::Status;
use tonic::body::Body;

use crate::access::fair::Stay;
use crate::connections::Call;
use crate::memory::Taken;

/// A body and its call.
pub(super) struct Held {
    body: Body,
    _call: Call,
    _stay: Option<Stay>,
    _taken: Option<Arc<Taken>>,
}

impl Held {
    pub(super) fn new(body: Body, call: Call, stay: Option<Stay>, taken: Option<Arc<Taken>>) -> Self {
        Self { body, _call: call, _stay: stay, _taken: taken }
    }
}

impl http_body::Body for Held {
    type Data = Bytes;
    type Error = Status;

    fn poll_frame(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<Option<Result<Frame<Bytes>, Status>>> {
        Pin::new(&mut self.body).poll_frame(cx)
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}
