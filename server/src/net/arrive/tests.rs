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

async fn all(mut arrived: BufferedBody) -> Vec<u8> {
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
    let arrived = first_message(body, MOST, HOUR, &MemoryBudget::new(0)).await.unwrap();
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
        assert_eq!(all(first_message(body, MOST, HOUR, &MemoryBudget::new(0)).await.unwrap()).await, part);
    }
    let (send, body) = body();
    send.send(b"\0\xff\xff\xff\xff").unwrap();
    assert!(first_message(body, MOST, HOUR, &MemoryBudget::new(0)).await.is_ok(), "it is refused before it has come");
    drop(send);
}

#[tokio::test]
async fn a_client_that_sends_nothing_is_refused() {
    let (send, body) = body();
    send.send(&[0, 0]).unwrap();
    send.send(&[]).unwrap();
    let refused = first_message(body, MOST, Duration::from_millis(20), &MemoryBudget::new(0)).await.err();
    assert_eq!(refused, Some(Refusal::CallStalled(0)));
    drop(send);
}

#[tokio::test]
async fn a_large_request_counts_in_the_memory_budget_until_it_is_read() {
    static PART: [u8; 20_000] = [0; 20_000];
    let memory = MemoryBudget::new(64_000);
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
