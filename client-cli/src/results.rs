//! Reads results: to memory, a file or standard output.

use std::fmt::Write as _;
use std::future::Future;
use std::io::IsTerminal as _;
use std::path::{Component, Path};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use counterpoint_client::{DrawingFormat, ResultDocument};
use counterpoint_proto::v1;

use crate::arguments::{OutputFormat, ResultKind};
use crate::client::ServerSession;
use crate::draft::Draft;
use crate::error::Error;
use crate::progress::ResultProgress;

/// Time between two looks at a result that is being read.
const SHOW_EVERY: Duration = Duration::from_secs(1);

/// Form of a result, as far as it has several.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ResultFormat {
    /// Of drawings.
    pub(crate) format: OutputFormat,
    /// Lines of listings end with CR and LF.
    pub(crate) crlf: bool,
}

impl From<OutputFormat> for ResultFormat {
    fn from(format: OutputFormat) -> Self {
        Self { format, crlf: false }
    }
}

/// Result of a kind; `None` for the files that macros have written, which are many.
fn document(what: ResultKind, channel: u32, ResultFormat { format, crlf }: ResultFormat) -> Option<ResultDocument> {
    let drawing = match format {
        OutputFormat::Svg => DrawingFormat::Svg,
        OutputFormat::Json => DrawingFormat::Json,
    };
    Some(match what {
        ResultKind::Summary => ResultDocument::Summary,
        ResultKind::Listing => ResultDocument::Listing { channel, crlf },
        ResultKind::Log => ResultDocument::Log { channel, crlf },
        ResultKind::Console => ResultDocument::Console { channel, crlf },
        ResultKind::Trace => ResultDocument::Trace { channel },
        ResultKind::Timeline => ResultDocument::Timeline(drawing),
        ResultKind::Toolpath => ResultDocument::Toolpath(drawing),
        ResultKind::Events => ResultDocument::Events,
        ResultKind::Files | ResultKind::Report | ResultKind::All => return None,
    })
}

/// Hands every chunk of a result to `put`.
pub(crate) async fn each(
    client: &ServerSession,
    job: &str,
    what: ResultKind,
    channel: u32,
    form: ResultFormat,
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
    client: &ServerSession,
    job: &str,
    document: &ResultDocument,
    put: &mut (dyn FnMut(&[u8]) -> Result<(), Error> + Send),
) -> Result<(), Error> {
    let mut chunks = client.document(job, document).await?;
    while let Some(chunk) = chunks.next().await? {
        put(&chunk)?;
    }
    Ok(())
}

/// Writes the files that macros have written below a folder.
pub(crate) async fn files(client: &ServerSession, job: &str, folder: &Path) -> Result<(), Error> {
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
        drain(client, job, &ResultDocument::File(path), &mut |data| draft.write(data)).await?;
        draft.finish()?;
    }
    Ok(())
}

/// A whole result.
pub(crate) async fn whole(
    client: &ServerSession,
    job: &str,
    what: ResultKind,
    channel: u32,
    form: ResultFormat,
) -> Result<Vec<u8>, Error> {
    let mut whole = Vec::new();
    let mut put = |data: &[u8]| {
        whole.extend_from_slice(data);
        Ok(())
    };
    each(client, job, what, channel, form, &mut put).await?;
    Ok(whole)
}

/// The step of a result that is being read.
fn step(path: &Path, received: u64) -> String {
    let path = path.display();
    match received / 1_000_000 {
        0 => format!("reading {path}"),
        megabytes => format!("reading {path}: {megabytes} MB"),
    }
}

/// Shows the step of some work on a terminal until the work is done.
async fn in_steps<T>(every: Duration, work: impl Future<Output = T>, step: impl Fn() -> String) -> T {
    let mut work = std::pin::pin!(work);
    let mut steps = ResultProgress::new(!std::io::stderr().is_terminal());
    let done = loop {
        match tokio::time::timeout(every, &mut work).await {
            Ok(done) => break done,
            Err(_) => steps.say(step()),
        }
    };
    steps.clear();
    done
}

/// A result into a file.
pub(crate) async fn file(
    client: &ServerSession,
    job: &str,
    what: ResultKind,
    channel: u32,
    form: ResultFormat,
    path: &Path,
) -> Result<(), Error> {
    if what == ResultKind::Files {
        return files(client, job, path).await;
    }
    let mut draft = Draft::new(path)?;
    let received = AtomicU64::new(0);
    let mut put = |data: &[u8]| {
        received.fetch_add(data.len() as u64, Ordering::Relaxed);
        draft.write(data)
    };
    let reading = each(client, job, what, channel, form, &mut put);
    in_steps(SHOW_EVERY, reading, || step(path, received.load(Ordering::Relaxed))).await?;
    draft.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_has_the_bytes_so_far() {
        let path = Path::new("part.lce");
        assert_eq!(step(path, 999_999), "reading part.lce");
        assert_eq!(step(path, 12_345_678), "reading part.lce: 12 MB");
    }

    #[tokio::test]
    async fn the_steps_of_work_that_takes_long_are_shown() {
        let work = async {
            tokio::time::sleep(Duration::from_millis(200)).await;
            7
        };
        let shown = std::cell::Cell::new(0);
        let step = || {
            shown.set(shown.get() + 1);
            String::new()
        };
        assert_eq!(in_steps(Duration::from_millis(20), work, step).await, 7);
        assert!(shown.get() > 0);
    }
}
