//! The folder with all results of a job.
//!
//! *Invariant:* a run and a job of a server leave the same files under the same names.

use std::path::Path;

use crate::arguments::{OutputFormat, ResultKind};
use crate::client::ServerSession;
use crate::draft;
use crate::error::Error;
use crate::progress::ResultProgress;
use crate::report::report;
use crate::results;
use crate::say::{self, DIM, styled};
use crate::standard_input;
use crate::summary::ReportSummary;
use crate::timeline::{TextTimeline, draw};

/// Columns of the timeline in a report that is written to a file.
const REPORT_WIDTH: usize = 100;

/// Where results are written, and which ones.
pub(crate) struct OutputFolder<'a> {
    pub(crate) folder: &'a Path,
    /// First program: names the listings.
    pub(crate) program: &'a str,
    /// The start of the report.
    pub(crate) heading: String,
    /// Whether a result is to be written.
    pub(crate) wanted: &'a (dyn Fn(ResultKind) -> bool + Sync),
    /// Lines of listings, logs and consoles end with CR and LF.
    pub(crate) crlf: bool,
}

impl OutputFolder<'_> {
    /// Writes the results of a job whose summary has been read; a status line names the current file. If the server
    /// refuses a result, the others are still written.
    pub(crate) async fn write(
        &self,
        client: &ServerSession,
        job: &str,
        (summary, text): (&ReportSummary, &[u8]),
        quiet: bool,
    ) -> Result<(), Error> {
        let mut writing =
            Writing { client, job, folder: self.folder, steps: ResultProgress::new(quiet), failed: Vec::new() };
        self.write_all(&mut writing, (summary, text)).await?;
        let Writing { steps, failed, .. } = writing;
        steps.clear();
        if !quiet {
            say::status_line(styled(DIM, format!("results written to {}", self.folder.display())));
        }
        if failed.is_empty() { Ok(()) } else { Err(Error::NotWritten(failed)) }
    }

    async fn write_all(
        &self,
        writing: &mut Writing<'_>,
        (summary, text): (&ReportSummary, &[u8]),
    ) -> Result<(), Error> {
        let (folder, wanted) = (self.folder, self.wanted);
        std::fs::create_dir_all(folder).map_err(Error::file(folder))?;
        if wanted(ResultKind::Summary) {
            draft::write(&folder.join("summary.json"), text)?;
        }
        let channels: Vec<u32> = summary.channels.iter().filter(|c| !c.program.is_empty()).map(|c| c.channel).collect();
        for (name, what, channel, format) in self.files(&channels) {
            let form = results::ResultFormat { format, crlf: self.crlf };
            writing.result(&name, what, channel, form).await?;
        }
        if wanted(ResultKind::Report) {
            let written = self.report(writing, summary).await;
            writing.note("report.txt", written)?;
        }
        if wanted(ResultKind::Files) {
            let written = results::files(writing.client, writing.job, &folder.join("files")).await;
            writing.note("files", written)?;
        }
        Ok(())
    }

    async fn report(&self, writing: &Writing<'_>, summary: &ReportSummary) -> Result<(), Error> {
        let timeline = drawn_timeline(writing.client, writing.job, REPORT_WIDTH).await?;
        let text = self.heading.clone() + &report(summary, true) + &timeline;
        draft::write(&self.folder.join("report.txt"), say::plain(&text).as_bytes())
    }

    /// Files that are read from the server unchanged: their names and results.
    fn files(&self, channels: &[u32]) -> Vec<(String, ResultKind, u32, OutputFormat)> {
        use ResultKind::{Console, Events, Listing, Log, Timeline, Toolpath, Trace};
        let program = if self.program == standard_input::NAME { "stdin" } else { self.program };
        let stem = Path::new(program).file_stem().unwrap_or_default().to_string_lossy();
        let mut files = Vec::new();
        for (what, extension) in [(Listing, "lce"), (Log, "log")] {
            for &channel in channels {
                let of = if channels.len() == 1 { String::new() } else { format!(".{channel}") };
                files.push((format!("{stem}{of}.{extension}"), what, channel, OutputFormat::Svg));
            }
        }
        if channels.len() > 1 {
            files.push((format!("{stem}.lce"), Listing, 0, OutputFormat::Svg));
        }
        files.push(("console.txt".to_owned(), Console, 0, OutputFormat::Svg));
        files.extend(channels.iter().map(|&channel| (format!("{channel}.trace"), Trace, channel, OutputFormat::Svg)));
        let drawings = [
            (Events, OutputFormat::Json, "events.jsonl"),
            (Timeline, OutputFormat::Svg, "timeline.svg"),
            (Timeline, OutputFormat::Json, "timeline.json"),
            (Toolpath, OutputFormat::Svg, "toolpath.svg"),
            (Toolpath, OutputFormat::Json, "toolpath.json"),
        ];
        files.extend(drawings.map(|(what, format, name)| (name.to_owned(), what, 0, format)));
        files.retain(|(_, what, ..)| (self.wanted)(*what));
        files
    }
}

/// The results being written.
struct Writing<'a> {
    client: &'a ServerSession,
    job: &'a str,
    folder: &'a Path,
    steps: ResultProgress,
    /// Files that the server refused, with its refusals.
    failed: Vec<(String, Error)>,
}

impl Writing<'_> {
    async fn result(
        &mut self,
        name: &str,
        what: ResultKind,
        channel: u32,
        form: results::ResultFormat,
    ) -> Result<(), Error> {
        let path = self.folder.join(name);
        self.steps.show(&path);
        let written = results::file(self.client, self.job, what, channel, form, &path).await;
        self.note(name, written)
    }

    /// Keeps a refusal for the end. Any other error would also affect the next file.
    fn note(&mut self, name: &str, written: Result<(), Error>) -> Result<(), Error> {
        match written {
            Err(error @ Error::Refused(_)) => self.failed.push((self.folder.join(name).display().to_string(), error)),
            other => return other,
        }
        Ok(())
    }
}

/// The timeline of a job as text of this many columns.
pub(crate) async fn drawn_timeline(client: &ServerSession, job: &str, width: usize) -> Result<String, Error> {
    let json = results::whole(client, job, ResultKind::Timeline, 0, OutputFormat::Json.into()).await?;
    let timeline: TextTimeline = serde_json::from_slice(&json).unwrap_or_default();
    Ok(draw(&timeline, width))
}
