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

use crate::access::fair::Stay;
use crate::memory::{Memory, Taken};
use crate::reason::Refusal;

/// Bytes before a message: a flag, and its length.
const HEAD: usize = 5;

/// Bytes of a request that need no place in the memory budget: requests that only look are smaller.
const FREE: usize = 64 * 1024;

/// The body of a request of which a part has come.
pub(super) struct Arrived {
    /// Each frame with its part of the memory budget.
    come: VecDeque<(Bytes, Option<Taken>)>,
    rest: Body,
    /// The call that lasts, whose data these are.
    stay: Option<Stay>,
}

/// Waits for the first message of a request, or for the end of the request.
///
/// # Errors
/// The client sends nothing, or there is no memory for the message.
pub(super) async fn first_message(
    mut rest: Body,
    most: usize,
    stall: Duration,
    memory: &Arc<Memory>,
) -> Result<Arrived, Refusal> {
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
    Ok(Arrived { come, rest, stay: None })
}

impl Arrived {
    /// A request whose messages the service reads as they come.
    pub(super) fn open(rest: Body) -> Self {
        Self { come: VecDeque::new(), rest, stay: None }
    }

    /// The request of a call that lasts.
    pub(super) fn of(self, stay: Option<Stay>) -> Self {
        Self { stay, ..self }
    }
}

impl http_body::Body for Arrived {
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
mod tests {
    use tokio::sync::mpsc;

    use super::*;

    const MOST: usize = 100;
    const HOUR: Duration = Duration::from_secs(3600);

    /// A body whose frames a test sends.
    struct Sent(mpsc::UnboundedReceiver<&'static [u8]>);

    impl http_body::Body for Sent {
        type Data = Bytes;
        type Error = Status;

        fn poll_frame(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<Option<Result<Frame<Bytes>, Status>>> {
            self.0.poll_recv(cx).map(|data| data.map(|data| Ok(Frame::data(Bytes::from_static(data)))))
        }
    }

    fn body() -> (mpsc::UnboundedSender<&'static [u8]>, Body) {
        let (send, receive) = mpsc::unbounded_channel();
        (send, Body::new(Sent(receive)))
    }

    async fn all(mut arrived: Arrived) -> Vec<u8> {
        let mut all = Vec::new();
        while let Some(frame) = poll_fn(|cx| Pin::new(&mut arrived).poll_frame(cx)).await {
            all.extend(frame.unwrap().into_data().unwrap());
        }
        all
    }

    #[tokio::test]
    async fn a_message_in_parts_is_waited_for_and_what_follows_is_not() {
        let (send, body) = body();
        for part in [&[0, 0, 0][..], &[], &[0, 3, b'a', b'b'], b"c"] {
            send.send(part).unwrap();
        }
        let arrived = first_message(body, MOST, HOUR, &Memory::new(0)).await.unwrap();
        send.send(b"next").unwrap();
        drop(send);
        assert_eq!(all(arrived).await, b"\0\0\0\0\x03abcnext");
    }

    #[tokio::test]
    async fn a_request_that_ends_early_or_is_too_large_is_left_to_the_service() {
        for part in [&b""[..], b"\0\0", b"\0\0\0\0\x09abc"] {
            let (send, body) = body();
            send.send(part).unwrap();
            drop(send);
            assert_eq!(all(first_message(body, MOST, HOUR, &Memory::new(0)).await.unwrap()).await, part);
        }
        let (send, body) = body();
        send.send(b"\0\xff\xff\xff\xff").unwrap();
        assert!(first_message(body, MOST, HOUR, &Memory::new(0)).await.is_ok(), "it is refused before it has come");
        drop(send);
    }

    #[tokio::test]
    async fn a_client_that_sends_nothing_is_refused() {
        let (send, body) = body();
        send.send(&[0, 0]).unwrap();
        send.send(&[]).unwrap();
        let refused = first_message(body, MOST, Duration::from_millis(20), &Memory::new(0)).await.err();
        assert_eq!(refused, Some(Refusal::CallStalled(0)));
        drop(send);
    }

    #[tokio::test]
    async fn a_large_request_counts_in_the_memory_budget_until_it_is_read() {
        static PART: [u8; 20_000] = [0; 20_000];
        let memory = Memory::new(64_000);
        let length = 5 * PART.len() as u32;
        let request = || {
            let (send, body) = body();
            send.send(Box::leak(Box::new([&[0][..], &length.to_be_bytes()].concat()))).unwrap();
            (0..5).for_each(|_| send.send(&PART).unwrap());
            body
        };
        // 20,005 of its bytes are beyond the free ones of each request; jobs may have 56,000.
        let first = first_message(request(), 1 << 20, HOUR, &memory).await.unwrap();
        let second = first_message(request(), 1 << 20, HOUR, &memory).await.err();
        assert_eq!(second, Some(Refusal::MemoryFull(64_000)));
        assert_eq!(all(first).await.len(), 5 + 5 * PART.len());
        assert!(first_message(request(), 1 << 20, HOUR, &memory).await.is_ok());
    }
}
