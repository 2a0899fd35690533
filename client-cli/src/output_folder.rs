//! The folder with all results of a job.
//!
//! *Invariant:* a run and a job of a server leave the same files under the same names.

use std::path::Path;

use crate::arguments::{Format, ResultKind};
use crate::client::Client;
use crate::error::Error;
use crate::progress::Steps;
use crate::report::report;
use crate::results;
use crate::say::{self, DIM, styled};
use crate::standard_input;
use crate::summary::Summary;
use crate::timeline::{Timeline, draw};

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
    /// Writes the results of a job whose summary has been read; a line of status names the current file.
    pub(crate) async fn write(
        &self,
        client: &Client,
        job: &str,
        (summary, text): (&Summary, &[u8]),
        quiet: bool,
    ) -> Result<(), Error> {
        let mut steps = Steps::new(quiet);
        self.write_all(client, job, (summary, text), &mut steps).await?;
        steps.clear();
        if !quiet {
            say::status_line(styled(DIM, format!("results written to {}", self.folder.display())));
        }
        Ok(())
    }

    async fn write_all(
        &self,
        client: &Client,
        job: &str,
        (summary, text): (&Summary, &[u8]),
        steps: &mut Steps,
    ) -> Result<(), Error> {
        let (folder, wanted) = (self.folder, self.wanted);
        std::fs::create_dir_all(folder).map_err(Error::file(folder))?;
        if wanted(ResultKind::Summary) {
            let path = folder.join("summary.json");
            std::fs::write(&path, text).map_err(Error::file(&path))?;
        }
        let program = if self.program == standard_input::NAME { "stdin" } else { self.program };
        let stem = Path::new(program).file_stem().unwrap_or_default().to_string_lossy();
        let channels: Vec<u32> = summary.channels.iter().filter(|c| !c.program.is_empty()).map(|c| c.channel).collect();
        let form = results::Form { format: Format::Svg, crlf: self.crlf };
        for (what, extension) in [(ResultKind::Listing, "lce"), (ResultKind::Log, "log")] {
            for &channel in channels.iter().filter(|_| wanted(what)) {
                let of = if channels.len() == 1 { String::new() } else { format!(".{channel}") };
                let path = folder.join(format!("{stem}{of}.{extension}"));
                steps.show(&path);
                results::file(client, job, what, channel, form, &path).await?;
            }
        }
        if channels.len() > 1 && wanted(ResultKind::Listing) {
            let path = folder.join(format!("{stem}.lce"));
            steps.show(&path);
            results::file(client, job, ResultKind::Listing, 0, form, &path).await?;
        }
        if wanted(ResultKind::Report) {
            let path = folder.join("report.txt");
            let text =
                self.heading.clone() + &report(summary, true) + &drawn_timeline(client, job, REPORT_WIDTH).await?;
            std::fs::write(&path, say::plain(&text)).map_err(Error::file(&path))?;
        }
        if wanted(ResultKind::Console) {
            results::file(client, job, ResultKind::Console, 0, form, &folder.join("console.txt")).await?;
        }
        for &channel in channels.iter().filter(|_| wanted(ResultKind::Trace)) {
            let path = folder.join(format!("{channel}.trace"));
            steps.show(&path);
            results::file(client, job, ResultKind::Trace, channel, Format::Svg.into(), &path).await?;
        }
        let files = [
            (ResultKind::Events, Format::Json, "events.jsonl"),
            (ResultKind::Timeline, Format::Svg, "timeline.svg"),
            (ResultKind::Timeline, Format::Json, "timeline.json"),
            (ResultKind::Toolpath, Format::Svg, "toolpath.svg"),
            (ResultKind::Toolpath, Format::Json, "toolpath.json"),
        ];
        for (what, format, name) in files {
            if wanted(what) {
                let path = folder.join(name);
                steps.show(&path);
                results::file(client, job, what, 0, format.into(), &path).await?;
            }
        }
        if wanted(ResultKind::Files) {
            results::files(client, job, &folder.join("files")).await?;
        }
        Ok(())
    }
}

/// The timeline of a job as text of this many columns.
pub(crate) async fn drawn_timeline(client: &Client, job: &str, width: usize) -> Result<String, Error> {
    let json = results::whole(client, job, ResultKind::Timeline, 0, Format::Json.into()).await?;
    let timeline: Timeline = serde_json::from_slice(&json).unwrap_or_default();
    Ok(draw(&timeline, width))
}
