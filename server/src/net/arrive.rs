//! The request of a call, before the call takes a turn: a request that has not come needs no processor time.
//!
//! *Invariants:* no more than one message of the largest size is held, and beyond its first [`FREE`] bytes it counts in
//! the memory budget until the service reads it; the service reads the data that follow it. A client that sends nothing
//! for the time of `upload_stall_s` holds the call no longer.

use std::collections::VecDeque;
use std::future::poll_fn;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;

use bytes::Bytes;
use http_body::{Body as _, Frame, SizeHint};
use tokio::time::{Instant, timeout_at};
use tonic::Status;
use tonic::body::Body;

use crate::access::fair::LongCall;
use crate::memory::{MemoryBudget, MemoryReservation};
use crate::reason::Refusal;

/// Bytes before a message: a flag, and its length.
const HEAD: usize = 5;

/// Bytes of a request that need no place in the memory budget: requests that only look are smaller.
const FREE: usize = 64 * 1024;

/// The body of a request of which a part has come.
pub(super) struct BufferedBody {
    /// Each frame with its part of the memory budget.
    come: VecDeque<(Bytes, Option<MemoryReservation>)>,
    rest: Body,
    /// The call that lasts, whose data these are.
    stay: Option<LongCall>,
}

/// Waits for the first message of a request, or for the end of the request.
///
/// # Errors
/// The client sends nothing, or there is no memory for the message.
pub(super) async fn first_message(
    mut rest: Body,
    most: usize,
    stall: Duration,
    memory: &Arc<MemoryBudget>,
) -> Result<BufferedBody, Refusal> {
    let (mut come, mut head, mut bytes) = (VecDeque::new(), Vec::new(), 0);
    let mut until = Instant::now() + stall;
    loop {
        let length = head.first_chunk::<HEAD>().map(|[_, a, b, c, d]| u32::from_be_bytes([*a, *b, *c, *d]));
        let wanted = length.map_or(HEAD, |length| HEAD.saturating_add(usize::try_from(length).unwrap_or(usize::MAX)));
        // A message that is too large is refused by the service.
        if length.is_some() && (bytes >= wanted || wanted > most) {
            break;
        }
        let frame = poll_fn(|cx| Pin::new(&mut rest).poll_frame(cx));
        let frame = timeout_at(until, frame).await.map_err(|_| Refusal::CallStalled(stall.as_secs()))?;
        let Some(data) = frame.and_then(|frame| frame.ok()?.into_data().ok()) else { break };
        if !data.is_empty() {
            until = Instant::now() + stall;
            head.extend(data.iter().take(HEAD - head.len()));
            bytes += data.len();
            let taken = if bytes > FREE { Some(memory.take(data.len() as u64)?) } else { None };
            come.push_back((data, taken));
        }
    }
    Ok(BufferedBody { come, rest, stay: None })
}

impl BufferedBody {
    /// A request whose messages the service reads as they come.
    pub(super) fn open(rest: Body) -> Self {
        Self { come: VecDeque::new(), rest, stay: None }
    }

    /// The request of a call that lasts.
    pub(super) fn of(self, stay: Option<LongCall>) -> Self {
        Self { stay, ..self }
    }
}

impl http_body::Body for BufferedBody {
    type Data = Bytes;
    type Error = Status;

    fn poll_frame(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<Option<Result<Frame<Bytes>, Status>>> {
        if let Some((data, _)) = self.come.pop_front() {
            return Poll::Ready(Some(Ok(Frame::data(data))));
        }
        let polled = Pin::new(&mut self.rest).poll_frame(cx);
        if let (Some(stay), Poll::Ready(Some(Ok(frame)))) = (&self.stay, &polled) {
            stay.flows(frame.data_ref().map_or(0, Bytes::len), std::time::Instant::now());
        }
        polled
    }

    fn is_end_stream(&self) -> bool {
        self.come.is_empty() && self.rest.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        if self.come.is_empty() { self.rest.size_hint() } else { SizeHint::default() }
    }
}

#[cfg(test)]
mod tests;
