//! Connections from which nothing is read for a while: callers without a pause get one.
//!
//! Data from the other end wait in its own buffers and those of the system; answers are still sent. *Invariant:*
//! reading continues by itself at the time that was set last, or at once when the pause is ended.

use std::io;
use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::time::{Instant, Sleep, sleep_until};

/// The pause of a connection.
#[derive(Debug, Clone, Default)]
pub(super) struct ReadPause(Arc<Mutex<Option<Instant>>>);

impl ReadPause {
    fn set(&self, until: Option<Instant>) -> Option<Instant> {
        std::mem::replace(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner), until)
    }

    /// Stops reading for this time; `false` if it had stopped before.
    pub(super) fn begin(&self, time: Duration) -> bool {
        let now = Instant::now();
        self.set(Some(now + time)).is_none_or(|until| until <= now)
    }

    /// Continues to read; the driver of the connection polls it afterwards.
    pub(super) fn end(&self) {
        self.set(None);
    }

    /// When reading continues; `None` = it has not stopped.
    fn until(&self) -> Option<Instant> {
        let mut until = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        *until = until.filter(|until| *until > Instant::now());
        *until
    }
}

/// A stream that is not read while it has a pause.
pub(super) struct Paused<S> {
    stream: S,
    pause: ReadPause,
    /// Made at the first pause.
    timer: Option<Pin<Box<Sleep>>>,
}

impl<S> Paused<S> {
    pub(super) fn new(stream: S, pause: ReadPause) -> Self {
        Self { stream, pause, timer: None }
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for Paused<S> {
    fn poll_read(mut self: Pin<&mut Self>, cx: &mut Context<'_>, out: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        while let Some(until) = self.pause.until() {
            let timer = self.timer.get_or_insert_with(|| Box::pin(sleep_until(until)));
            if timer.deadline() != until {
                timer.as_mut().reset(until);
            }
            if timer.as_mut().poll(cx).is_pending() {
                return Poll::Pending;
            }
        }
        Pin::new(&mut self.stream).poll_read(cx, out)
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for Paused<S> {
    fn poll_write(mut self: Pin<&mut Self>, cx: &mut Context<'_>, data: &[u8]) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.stream).poll_write(cx, data)
    }

    fn poll_flush(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(cx)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(cx)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        parts: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.stream).poll_write_vectored(cx, parts)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }
}

#[cfg(test)]
mod tests {
    use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};

    use super::*;

    #[tokio::test]
    async fn nothing_is_read_during_a_pause_and_what_came_meanwhile_afterwards() {
        const SHORT: Duration = Duration::from_millis(60);
        let (mut client, server) = tokio::io::duplex(64);
        let pause = ReadPause::default();
        let mut server = Paused::new(server, pause.clone());
        client.write_all(b"abc").await.unwrap();
        assert_eq!(server.read_u8().await.unwrap(), b'a');
        let begin = Instant::now();
        assert!(pause.begin(SHORT / 2) && !pause.begin(SHORT), "the second one lasts on");
        server.write_all(b"answer").await.unwrap();
        assert_eq!(server.read_u8().await.unwrap(), b'b');
        assert!(begin.elapsed() >= SHORT, "{:?}", begin.elapsed());
        // One that is ended is over, however long it was to be.
        assert!(pause.begin(Duration::from_secs(3600)));
        pause.end();
        assert_eq!(server.read_u8().await.unwrap(), b'c');
    }

    /// A pause that begins during a read.
    #[tokio::test]
    async fn a_pause_also_stops_a_read_under_way() {
        let (mut client, server) = tokio::io::duplex(64);
        let pause = ReadPause::default();
        let mut server = Paused::new(server, pause.clone());
        let mut read = Box::pin(server.read_u8());
        assert!(is_pending_now(&mut read).await);
        pause.begin(Duration::from_secs(3600));
        client.write_all(b"a").await.unwrap();
        assert!(is_pending_now(&mut read).await);
        pause.end();
        assert_eq!(read.await.unwrap(), b'a');
    }

    /// Whether a future is not done when it is polled.
    async fn is_pending_now<F: Future + Unpin>(future: &mut F) -> bool {
        std::future::poll_fn(|cx| Poll::Ready(Pin::new(&mut *future).poll(cx).is_pending())).await
    }
}
