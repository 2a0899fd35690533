//! Reads results: to memory, a file or standard output.

use std::fmt::Write as _;
use std::path::{Component, Path};

use counterpoint_client::{Document, Drawing};
use counterpoint_proto::v1;

use crate::arguments::{Format, ResultKind};
use crate::client::Client;
use crate::draft::Draft;
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

/// Result of a kind; `None` for the files that macros have written, which are many.
fn document(what: ResultKind, channel: u32, Form { format, crlf }: Form) -> Option<Document> {
    let drawing = match format {
        Format::Svg => Drawing::Svg,
        Format::Json => Drawing::Json,
    };
    Some(match what {
        ResultKind::Summary => Document::Summary,
        ResultKind::Listing => Document::Listing { channel, crlf },
        ResultKind::Log => Document::Log { channel, crlf },
        ResultKind::Console => Document::Console { channel, crlf },
        ResultKind::Trace => Document::Trace { channel },
        ResultKind::Timeline => Document::Timeline(drawing),
        ResultKind::Toolpath => Document::Toolpath(drawing),
        ResultKind::Events => Document::Events,
        ResultKind::Files | ResultKind::Report | ResultKind::All => return None,
    })
}

/// Hands every chunk of a result to `put`.
pub(crate) async fn each(
    client: &Client,
    job: &str,
    what: ResultKind,
    channel: u32,
    form: Form,
    put: &mut (dyn FnMut(&[u8]) -> Result<(), Error> + Send),
) -> Result<(), Error> {
    match document(what, channel, form) {
        Some(document) => drain(client, job, &document, put).await,
        None => {
            let mut out = String::new();
            for v1::WrittenFile { path, size } in client.files(job).await? {
                let _ = writeln!(out, "{size:>10} {path}");
            }
            put(out.as_bytes())
        }
    }
}

async fn drain(
    client: &Client,
    job: &str,
    document: &Document,
    put: &mut (dyn FnMut(&[u8]) -> Result<(), Error> + Send),
) -> Result<(), Error> {
    let mut chunks = client.document(job, document).await?;
    while let Some(chunk) = chunks.next().await? {
        put(&chunk)?;
    }
    Ok(())
}

/// Writes the files that macros have written below a folder.
pub(crate) async fn files(client: &Client, job: &str, folder: &Path) -> Result<(), Error> {
    for v1::WrittenFile { path, .. } in client.files(job).await? {
        let inside = Path::new(&path).components().all(|part| matches!(part, Component::Normal(_)));
        if !inside || path.contains([':', '\\']) {
            return Err(Error::Connection(format!(
                "the server sent the file name '{path}', which is outside the output folder"
            )));
        }
        let place = folder.join(&path);
        if let Some(parent) = place.parent() {
            std::fs::create_dir_all(parent).map_err(Error::file(parent))?;
        }
        let mut draft = Draft::new(&place)?;
        drain(client, job, &Document::File(path), &mut |data| draft.write(data)).await?;
        draft.finish()?;
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
    let mut draft = Draft::new(path)?;
    each(client, job, what, channel, form, &mut |data| draft.write(data)).await?;
    draft.finish()
}
