//! Reads results: streams of chunks put together, to memory, a file or standard output.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Component, Path};

use bytes::Bytes;
use counterpoint_proto::v1;
use tonic::Streaming;

use crate::arguments::{Format, ResultKind};
use crate::client::Client;
use crate::error::Error;

/// Form of a result, as far as it has several.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Form {
    /// Of drawings.
    pub(crate) format: Format,
    /// Lines of listings end with CR and LF.
    pub(crate) crlf: bool,
}

impl From<Format> for Form {
    fn from(format: Format) -> Self {
        Self { format, crlf: false }
    }
}

/// Something with a chunk in it.
pub(crate) trait Chunk {
    fn data(self) -> Bytes;
}

macro_rules! chunks {
    ($($type:ident),*) => { $(
        impl Chunk for v1::$type {
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

/// Hands every chunk of a result to `put`.
pub(crate) async fn each(
    client: &Client,
    job: &str,
    what: ResultKind,
    channel: u32,
    form: Form,
    put: &mut (dyn FnMut(&[u8]) -> Result<(), Error> + Send),
) -> Result<(), Error> {
    let job_id = job.to_owned();
    let format = match form.format {
        Format::Svg => v1::DrawingFormat::Svg,
        Format::Json => v1::DrawingFormat::Json,
    };
    let format = format.into();
    let mut results = client.results();
    match what {
        ResultKind::Summary => {
            drain(results.get_summary(v1::GetSummaryRequest { job_id }).await?.into_inner(), put).await
        }
        ResultKind::Listing | ResultKind::Log | ResultKind::Console => {
            let (log, console) = (what == ResultKind::Log, what == ResultKind::Console);
            let request = v1::GetListingRequest { job_id, channel, log, console, crlf: form.crlf };
            drain(results.get_listing(request).await?.into_inner(), put).await
        }
        ResultKind::Trace => {
            drain(results.get_trace(v1::GetTraceRequest { job_id, channel }).await?.into_inner(), put).await
        }
        ResultKind::Timeline => {
            drain(results.get_timeline(v1::GetTimelineRequest { job_id, format }).await?.into_inner(), put).await
        }
        ResultKind::Toolpath => {
            drain(results.get_toolpath(v1::GetToolpathRequest { job_id, format }).await?.into_inner(), put).await
        }
        ResultKind::Events => drain(results.get_events(v1::GetEventsRequest { job_id }).await?.into_inner(), put).await,
        ResultKind::Files => {
            let mut out = String::new();
            for v1::WrittenFile { path, size } in written(client, job).await? {
                let _ = writeln!(out, "{size:>10} {path}");
            }
            put(out.as_bytes())
        }
    }
}

/// The files that macros have written.
pub(crate) async fn written(client: &Client, job: &str) -> Result<Vec<v1::WrittenFile>, Error> {
    let request = v1::ListFilesRequest { job_id: job.to_owned(), ..Default::default() };
    Ok(client.results().list_files(request).await?.into_inner().files)
}

/// Writes the files that macros have written below a folder.
pub(crate) async fn files(client: &Client, job: &str, folder: &Path) -> Result<(), Error> {
    for v1::WrittenFile { path, .. } in written(client, job).await? {
        let inside = Path::new(&path).components().all(|part| matches!(part, Component::Normal(_)));
        if !inside || path.contains([':', '\\']) {
            return Err(Error::Connection(format!("the server names a file '{path}', which leads out of its folder")));
        }
        let place = folder.join(&path);
        if let Some(parent) = place.parent() {
            std::fs::create_dir_all(parent).map_err(Error::file(parent))?;
        }
        let mut file = std::fs::File::create(&place).map_err(Error::file(&place))?;
        let request = v1::GetFileRequest { job_id: job.to_owned(), path };
        let mut put = |data: &[u8]| file.write_all(data).map_err(Error::file(&place));
        drain(client.results().get_file(request).await?.into_inner(), &mut put).await?;
    }
    Ok(())
}

async fn drain<T: Chunk>(
    mut stream: Streaming<T>,
    put: &mut (dyn FnMut(&[u8]) -> Result<(), Error> + Send),
) -> Result<(), Error> {
    while let Some(chunk) = stream.message().await? {
        put(&chunk.data())?;
    }
    Ok(())
}

/// A whole result.
pub(crate) async fn whole(
    client: &Client,
    job: &str,
    what: ResultKind,
    channel: u32,
    form: Form,
) -> Result<Vec<u8>, Error> {
    let mut whole = Vec::new();
    let mut put = |data: &[u8]| {
        whole.extend_from_slice(data);
        Ok(())
    };
    each(client, job, what, channel, form, &mut put).await?;
    Ok(whole)
}

/// A result into a file.
pub(crate) async fn file(
    client: &Client,
    job: &str,
    what: ResultKind,
    channel: u32,
    form: Form,
    path: &Path,
) -> Result<(), Error> {
    if what == ResultKind::Files {
        return files(client, job, path).await;
    }
    let mut file = std::fs::File::create(path).map_err(Error::file(path))?;
    let mut put = |data: &[u8]| file.write_all(data).map_err(Error::file(path));
    each(client, job, what, channel, form, &mut put).await
}
