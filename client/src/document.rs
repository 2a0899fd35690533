//! Results of an ended job, as chunks to be put together.

use std::pin::Pin;

use bytes::Bytes;
use tokio_stream::{Stream, StreamExt as _};
use tonic::{Response, Status, Streaming};

use crate::connection::Connection;
use crate::error::Error;
use crate::v1;

/// Form of a drawing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DrawingFormat {
    /// Scalable vector graphics.
    Svg,
    /// JSON.
    Json,
}

impl DrawingFormat {
    fn wire(self) -> i32 {
        match self {
            Self::Svg => v1::DrawingFormat::Svg.into(),
            Self::Json => v1::DrawingFormat::Json.into(),
        }
    }
}

/// A result.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ResultDocument {
    /// Summary, JSON.
    Summary,
    /// Listing of a channel, of all for channel 0.
    Listing {
        /// The channel.
        channel: u32,
        /// Lines end with CR and LF.
        crlf: bool,
    },
    /// Log file of a channel.
    Log {
        /// The channel.
        channel: u32,
        /// Lines end with CR and LF.
        crlf: bool,
    },
    /// Messages and diagnostics of a channel, of all for channel 0.
    Console {
        /// The channel.
        channel: u32,
        /// Lines end with CR and LF.
        crlf: bool,
    },
    /// Trace of a channel.
    Trace {
        /// The channel.
        channel: u32,
    },
    /// Bars of each channel over simulated time.
    Timeline(DrawingFormat),
    /// Tool paths.
    Toolpath(DrawingFormat),
    /// The whole log, one JSON object a line.
    Events,
    /// A file that macros have written.
    File(
        /// Its path.
        String,
    ),
}

type Stored = Pin<Box<dyn Stream<Item = Result<Bytes, Status>> + Send>>;

/// Chunks of a result.
pub struct ResultChunks(Stored);

impl std::fmt::Debug for ResultChunks {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Chunks")
    }
}

impl ResultChunks {
    fn of<T: ChunkSource>(answer: Response<Streaming<T>>) -> Self {
        Self(Box::pin(answer.into_inner().map(|chunk| chunk.map(ChunkSource::data))))
    }

    /// The next chunk; `None` after the last one.
    ///
    /// # Errors
    /// When the result cannot be read to its end.
    pub async fn next(&mut self) -> Result<Option<Bytes>, Error> {
        Ok(self.0.next().await.transpose()?)
    }

    /// All chunks in one piece.
    ///
    /// # Errors
    /// When the result cannot be read to its end.
    pub async fn whole(mut self) -> Result<Vec<u8>, Error> {
        let mut whole = Vec::new();
        while let Some(chunk) = self.next().await? {
            whole.extend_from_slice(&chunk);
        }
        Ok(whole)
    }
}

/// Something with a chunk in it.
trait ChunkSource: Send + 'static {
    fn data(self) -> Bytes;
}

macro_rules! chunks {
    ($($type:ident),*) => { $(
        impl ChunkSource for v1::$type {
            fn data(self) -> Bytes {
                self.data
            }
        }
    )* };
}

chunks!(
    GetTraceResponse,
    GetListingResponse,
    GetTimelineResponse,
    GetToolpathResponse,
    GetSummaryResponse,
    GetEventsResponse,
    GetFileResponse
);

/// Asks for a result.
pub(crate) async fn read(connection: &Connection, job: &str, document: &ResultDocument) -> Result<ResultChunks, Error> {
    let job_id = job.to_owned();
    let mut results = connection.results();
    let listing = |channel: u32, crlf: bool| v1::GetListingRequest {
        job_id: job.to_owned(),
        channel,
        crlf,
        ..v1::GetListingRequest::default()
    };
    Ok(match document {
        ResultDocument::Summary => ResultChunks::of(results.get_summary(v1::GetSummaryRequest { job_id }).await?),
        ResultDocument::Listing { channel, crlf } => {
            ResultChunks::of(results.get_listing(listing(*channel, *crlf)).await?)
        }
        ResultDocument::Log { channel, crlf } => {
            let request = v1::GetListingRequest { log: true, ..listing(*channel, *crlf) };
            ResultChunks::of(results.get_listing(request).await?)
        }
        ResultDocument::Console { channel, crlf } => {
            let request = v1::GetListingRequest { console: true, ..listing(*channel, *crlf) };
            ResultChunks::of(results.get_listing(request).await?)
        }
        ResultDocument::Trace { channel } => {
            ResultChunks::of(results.get_trace(v1::GetTraceRequest { job_id, channel: *channel }).await?)
        }
        ResultDocument::Timeline(form) => {
            ResultChunks::of(results.get_timeline(v1::GetTimelineRequest { job_id, format: form.wire() }).await?)
        }
        ResultDocument::Toolpath(form) => {
            ResultChunks::of(results.get_toolpath(v1::GetToolpathRequest { job_id, format: form.wire() }).await?)
        }
        ResultDocument::Events => ResultChunks::of(results.get_events(v1::GetEventsRequest { job_id }).await?),
        ResultDocument::File(path) => {
            ResultChunks::of(results.get_file(v1::GetFileRequest { job_id, path: path.clone() }).await?)
        }
    })
}
