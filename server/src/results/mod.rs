//! Results, made from the event log while the job runs or later from its file.
//!
//! A thin layer over the kernel's [`ResultsBuilder`], which are fed live and stored at the end; results that are not
//! stored are made again from the log. Invariant: both ways give the same bytes.

use std::io::{self, Write};
use std::sync::Arc;

use bytes::Bytes;
use counterpoint_kernel::job::{RunEnd, WrittenFiles};
use counterpoint_kernel::log::builder::{JobResults, ResultsBuilder};
use counterpoint_kernel::log::event::VerdictKind;
use counterpoint_kernel::log::info::Info;
use counterpoint_kernel::log::{jsonl, listing, summary};
use serde::Serialize;

use crate::log::kept::StoredLog;
use crate::log::reader::{Events, Gone, LogReader};

/// A result that has a file of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum StoredResult {
    Summary,
    TimelineJson,
    TimelineSvg,
    ToolpathJson,
    ToolpathSvg,
    Files,
}

impl StoredResult {
    /// All of them.
    pub(crate) const ALL: [Self; 6] =
        [Self::Summary, Self::TimelineJson, Self::TimelineSvg, Self::ToolpathJson, Self::ToolpathSvg, Self::Files];

    /// Name of its file in the job's folder.
    pub(crate) fn file(self) -> &'static str {
        match self {
            Self::Summary => "summary.json",
            Self::TimelineJson => "timeline.json",
            Self::TimelineSvg => "timeline.svg",
            Self::ToolpathJson => "toolpath.json",
            Self::ToolpathSvg => "toolpath.svg",
            Self::Files => "files.json",
        }
    }
}

/// Forms of a listing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ListingForm {
    /// Blocks, trace, diagnostics, summaries.
    Listing,
    /// Diagnostics and summaries.
    Log,
    /// Messages and diagnostics, a line each.
    Console,
}

/// Finished results, not yet text.
pub(crate) struct Finished {
    pub(crate) results: JobResults,
    /// The files of macros; they are not in the log.
    pub(crate) files: WrittenFiles,
    /// Bytes of all documents, as far as known.
    pub(crate) bytes: u64,
    /// The log, if it is small.
    pub(crate) log: Option<Bytes>,
}

impl std::fmt::Debug for Finished {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Finished").finish_non_exhaustive()
    }
}

impl Finished {
    /// Results of a run. A `limit` of the server that stopped the run (empty = none) is a verdict that the log does not
    /// have, because it is not caused by the program.
    pub(crate) fn new(mut results: JobResults, files: WrittenFiles, limit: &str) -> Self {
        if !limit.is_empty() {
            let at_ns = results.summary.makespan_ns;
            let verdict = summary::VerdictSummary {
                kind: VerdictKind::Limit,
                at_ns,
                text: limit.to_owned(),
                members: Vec::new(),
            };
            results.summary.state = summary::JobOutcome::Failed;
            results.summary.verdict.get_or_insert(verdict);
        }
        Self { results, files, bytes: 0, log: None }
    }

    /// A document as text; `None` when it cannot be written as such.
    pub(crate) fn document(&self, document: StoredResult) -> Option<Vec<u8>> {
        match document {
            StoredResult::Summary => pretty(&self.results.summary),
            StoredResult::TimelineJson => json(&self.results.timeline),
            StoredResult::TimelineSvg => Some(self.results.timeline.svg().into_bytes()),
            StoredResult::ToolpathJson => json(&self.results.toolpath),
            StoredResult::ToolpathSvg => Some(self.results.toolpath.svg().into_bytes()),
            StoredResult::Files => json(&self.files),
        }
    }
}

/// JSON for people, over lines.
fn pretty(value: &impl Serialize) -> Option<Vec<u8>> {
    let mut text = serde_json::to_vec_pretty(value).ok()?;
    text.push(b'\n');
    Some(text)
}

fn json(value: &impl Serialize) -> Option<Vec<u8>> {
    let mut text = serde_json::to_vec(value).ok()?;
    text.push(b'\n');
    Some(text)
}

/// An ended job to make results of.
pub(crate) struct ResultSource<'a> {
    pub(crate) info: &'a Arc<Info>,
    pub(crate) outcome: RunEnd,
    pub(crate) log: &'a StoredLog,
    /// Limit of the server that stopped the run; empty = none.
    pub(crate) limit: &'a str,
    /// Making the result stops soon after the client has disconnected.
    pub(crate) gone: Gone,
}

impl ResultSource<'_> {
    fn events(&self) -> io::Result<Events> {
        Ok(Events::new(LogReader::open_ended(self.log, 0)?, self.outcome.events).until(self.gone.clone()))
    }

    /// Makes results from the log.
    pub(crate) fn fold(&self) -> io::Result<Finished> {
        let mut builder = ResultsBuilder::new(self.info);
        let mut events = self.events()?;
        for (_, event) in &mut events {
            builder.event(&event);
        }
        let finished = || Finished::new(builder.finish(&self.outcome), WrittenFiles::new(), self.limit);
        events.error().map_or_else(|| Ok(finished()), Err)
    }

    /// One document made from the log.
    pub(crate) fn document(&self, document: StoredResult) -> io::Result<Vec<u8>> {
        Ok(self.fold()?.document(document).unwrap_or_default())
    }

    /// Listing of one channel in one of its forms; of all channels for 0.
    pub(crate) fn listing(
        &self,
        finished: &Finished,
        channel: u16,
        form: ListingForm,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        let mut events = self.events()?;
        let (info, summary) = (self.info, &finished.results.summary);
        match form {
            ListingForm::Console => listing::render_console(info, channel, &mut events, out)?,
            ListingForm::Log => listing::render_log(info, channel, summary, &mut events, out)?,
            ListingForm::Listing if channel == 0 => listing::render_merged(info, summary, &mut events, out)?,
            ListingForm::Listing => listing::render(info, channel, summary, &mut events, out)?,
        }
        events.error().map_or(Ok(()), Err)
    }

    /// Trace of one channel.
    pub(crate) fn trace(&self, channel: u16, out: &mut dyn Write) -> io::Result<()> {
        let mut events = self.events()?;
        listing::render_trace(self.info, channel, &mut events, out)?;
        events.error().map_or(Ok(()), Err)
    }

    /// The whole log, one JSON object per line.
    pub(crate) fn jsonl(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut events = self.events()?;
        let mut lines = Vec::with_capacity(72 * 1024);
        for (seq, event) in &mut events {
            jsonl::write_event(self.info, seq, &event, &mut lines);
            if lines.len() >= 64 * 1024 {
                out.write_all(&lines)?;
                lines.clear();
            }
        }
        out.write_all(&lines)?;
        events.error().map_or(Ok(()), Err)
    }
}
