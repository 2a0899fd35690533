//! Streams of contents in chunks, made by blocking work.
//!
//! *Invariants:* while the client does not read, the work waits and passes its turn to other work. The work fails soon
//! after the client has disconnected.

use std::io::{self, Write};
use std::sync::Arc;

use bytes::{Bytes, BytesMut};
use tokio::runtime::Handle;
use tokio::sync::mpsc::error::TrySendError;
use tokio::sync::mpsc::{self, Sender};
use tokio_stream::wrappers::ReceiverStream;
use tonic::{Response, Status};

use super::blocking;
use crate::jobs::turns::OwnTurn;
use crate::log::reader::Gone;
use crate::reason::Refusal;

/// Maximum bytes of a chunk in streams from the server.
pub(super) const CHUNK: usize = 64 * 1024;

/// A response with one chunk of the content.
pub(super) trait ChunkResponse: Send + 'static {
    fn chunk(data: Bytes) -> Self;
}

/// Streams the output of `make` in chunks. `make` can check whether the client has disconnected.
pub(super) fn stream<T: ChunkResponse>(
    turn: OwnTurn,
    make: impl FnOnce(&mut dyn Write, &Gone) -> Result<(), Refusal> + Send + 'static,
) -> Response<ReceiverStream<Result<T, Status>>> {
    let (send, receive) = mpsc::channel(4);
    tokio::task::spawn_blocking(move || {
        let client = send.clone();
        let gone: Gone = Arc::new(move || client.is_closed());
        let mut writer = ChunkWriter { buffer: BytesMut::with_capacity(CHUNK), send, turn };
        let result = make(&mut writer, &gone).and_then(|()| Ok(writer.flush()?));
        if let Err(refusal) = result {
            let _ = writer.send(Err(refusal.into()));
        }
    });
    Response::new(ReceiverStream::new(receive))
}

/// Makes a value before the stream begins, and returns the turn with it. `make` can check whether the client has
/// disconnected.
pub(super) async fn making<T: Send + 'static>(
    turn: OwnTurn,
    make: impl FnOnce(&Gone) -> Result<T, Refusal> + Send + 'static,
) -> Result<(T, OwnTurn), Refusal> {
    // The call is dropped when its client disconnects.
    let call = Arc::new(());
    let gone = Arc::downgrade(&call);
    let gone: Gone = Arc::new(move || gone.strong_count() == 0);
    let made = blocking(move || Ok((make(&gone)?, turn))).await;
    drop(call);
    made
}

struct ChunkWriter<T> {
    buffer: BytesMut,
    send: Sender<Result<T, Status>>,
    turn: OwnTurn,
}

impl<T: ChunkResponse> ChunkWriter<T> {
    /// Sends a message; gives up the turn while the client does not read.
    fn send(&mut self, message: Result<T, Status>) -> io::Result<()> {
        let message = match self.send.try_send(message) {
            Ok(()) => return Ok(()),
            Err(TrySendError::Closed(_)) => return Err(io::ErrorKind::BrokenPipe.into()),
            Err(TrySendError::Full(message)) => message,
        };
        self.turn.pause();
        self.send.blocking_send(message).map_err(|_| io::Error::from(io::ErrorKind::BrokenPipe))?;
        Handle::current().block_on(self.turn.resume());
        Ok(())
    }
}

impl<T: ChunkResponse> Write for ChunkWriter<T> {
    fn write(&mut self, data: &[u8]) -> io::Result<usize> {
        let take = data.len().min(CHUNK.saturating_sub(self.buffer.len())).max(1).min(data.len());
        self.buffer.extend_from_slice(data.get(..take).unwrap_or_default());
        if self.buffer.len() >= CHUNK {
            self.flush()?;
        }
        Ok(take)
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.buffer.is_empty() {
            return Ok(());
        }
        let data = std::mem::replace(&mut self.buffer, BytesMut::with_capacity(CHUNK)).freeze();
        self.send(Ok(T::chunk(data)))
    }
}
