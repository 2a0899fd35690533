//! The body of an answer that keeps its call counted until it has been sent.

use std::pin::Pin;
use std::task::{Context, Poll};

use bytes::Bytes;
use http_body::{Frame, SizeHint};
use tonic::Status;
use tonic::body::Body;

use crate::access::fair::Stay;
use crate::connections::Call;

/// A body and its call.
pub(super) struct Held {
    body: Body,
    _call: Call,
    _stay: Option<Stay>,
}

impl Held {
    pub(super) fn new(body: Body, call: Call, stay: Option<Stay>) -> Self {
        Self { body, _call: call, _stay: stay }
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
