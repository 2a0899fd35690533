//! The body of an answer that keeps its call and its memory counted until it has been sent.

use std::net::IpAddr;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};

use bytes::Bytes;
use http_body::{Frame, SizeHint};
use tokio::time::{Instant, sleep_until};
use tonic::Status;
use tonic::body::Body;

use super::cut::CutStatus;
use crate::access::fair::LongCall;
use crate::connections::ActiveCall;
use crate::memory::MemoryReservation;
use crate::places::LimitedSlot;
use crate::reason::Refusal;

/// Ready when a call has lost its rights, with the status to end the call.
pub(super) type Ended = Pin<Box<dyn Future<Output = Status> + Send>>;

/// The end of a call whose rights end or whose deadline passes, whichever is first.
pub(super) fn ended(rights: Option<Ended>, deadline: Option<Instant>) -> Option<Ended> {
    let Some(deadline) = deadline else { return rights };
    Some(Box::pin(async move {
        let late = sleep_until(deadline);
        match rights {
            None => late.await,
            Some(rights) => tokio::select! {
                status = rights => return status,
                () = late => {}
            },
        }
        Status::from(Refusal::CallDeadline)
    }))
}

/// A body and its call.
pub(super) struct TrackedBody {
    body: Body,
    ended: Option<Ended>,
    /// Cuts the body of the service.
    cut: CutStatus,
    _call: ActiveCall,
    stay: Option<LongCall>,
    _taken: Option<Arc<MemoryReservation>>,
    _place: Option<LimitedSlot<IpAddr>>,
}

impl TrackedBody {
    pub(super) fn new(
        body: Body,
        call: ActiveCall,
        stay: Option<LongCall>,
        taken: Option<Arc<MemoryReservation>>,
    ) -> Self {
        Self { body, ended: None, cut: CutStatus::default(), _call: call, stay, _taken: taken, _place: None }
    }
}

impl TrackedBody {
    /// The body of a call that ends with its rights, and cuts the body of its service then.
    pub(super) fn until(self, ended: Option<Ended>, cut: CutStatus) -> Self {
        Self { ended, cut, ..self }
    }

    /// The body of a call that holds a place until its end.
    pub(super) fn keeping(self, place: Option<LimitedSlot<IpAddr>>) -> Self {
        Self { _place: place, ..self }
    }
}

impl http_body::Body for TrackedBody {
    type Data = Bytes;
    type Error = Status;

    fn poll_frame(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<Option<Result<Frame<Bytes>, Status>>> {
        if let Some(ended) = &mut self.ended
            && let Poll::Ready(status) = ended.as_mut().poll(cx)
        {
            self.ended = None;
            self.cut.with(status);
        }
        let polled = Pin::new(&mut self.body).poll_frame(cx);
        if let (Some(stay), Poll::Ready(Some(Ok(frame)))) = (&self.stay, &polled) {
            stay.flows(frame.data_ref().map_or(0, Bytes::len), Instant::now().into_std());
        }
        polled
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}
