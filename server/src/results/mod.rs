//! Results: what is read off the event log, while the job runs or later from its file.
//!
//! A thin layer over the renderers of the kernel: [`Folds`] is fed live and stored at the end; whatever is not stored is made
//! again from the log ([`render`]). Invariant: both ways give the same bytes.

use std::io::{self, Write};
use std::sync::Arc;

use counterpoint_kernel::job::Outcome;
use counterpoint_kernel::log::digest::Digest;
use counterpoint_kernel::log::event::Event;
use counterpoint_kernel::log::info::Info;
use counterpoint_kernel::log::{jsonl, listing, summary, timeline, toolpath};
use serde::Serialize;

use crate::log::reader::{Events, Reader};

/// A result that has a file of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Document {
    Summary,
    TimelineJson,
    TimelineSvg,
    ToolpathJson,
    ToolpathSvg,
}

impl Document {
    /// Name of its file in the job's folder.
    pub(crate) fn file(self) -> &'static str {
        match self {
            Self::Summary => "summary.json",
            Self::TimelineJson => "timeline.json",
            Self::TimelineSvg => "timeline.svg",
            Self::ToolpathJson => "toolpath.json",
            Self::ToolpathSvg => "toolpath.svg",
        }
    }
}

/// Results in the making.
pub(crate) struct Folds {
    digest: Digest,
    summary: summary::Builder,
    timeline: Option<timeline::Builder>,
    toolpath: Option<toolpath::Builder>,
}

/// Finished results, not yet text.
pub(crate) struct Finished {
    summary: summary::Summary,
    timeline: Option<timeline::Timeline>,
    toolpath: Option<toolpath::Toolpath>,
}

impl std::fmt::Debug for Finished {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Finished").finish_non_exhaustive()
    }
}

/// What the server itself needs of a summary.
#[derive(Debug, Default, serde::Deserialize)]
#[serde(default)]
pub(crate) struct Key {
    pub(crate) makespan_ns: i64,
    pub(crate) log_digest: String,
}

impl Folds {
    pub(crate) fn new(info: &Arc<Info>, timeline: bool, toolpath: bool) -> Self {
        Self {
            digest: Digest::new(),
            summary: summary::Builder::new(info),
            timeline: timeline.then(|| timeline::Builder::new(info)),
            toolpath: toolpath.then(|| toolpath::Builder::new(info)),
        }
    }

    pub(crate) fn event(&mut self, seq: u64, event: &Event) {
        self.digest.event(event);
        self.summary.event(seq, event);
        if let Some(timeline) = &mut self.timeline {
            timeline.event(seq, event);
        }
        if let Some(toolpath) = &mut self.toolpath {
            toolpath.event(seq, event);
        }
    }

    pub(crate) fn finish(self, outcome: &Outcome) -> Finished {
        Finished {
            summary: self.summary.finish(outcome, self.digest.hex()),
            timeline: self.timeline.map(timeline::Builder::finish),
            toolpath: self.toolpath.map(toolpath::Builder::finish),
        }
    }
}

impl Finished {
    /// A document as text; `None` when it was not made.
    pub(crate) fn document(&self, document: Document) -> Option<Vec<u8>> {
        match document {
            Document::Summary => json(&self.summary),
            Document::TimelineJson => json(self.timeline.as_ref()?),
            Document::TimelineSvg => Some(self.timeline.as_ref()?.svg().into_bytes()),
            Document::ToolpathJson => json(self.toolpath.as_ref()?),
            Document::ToolpathSvg => Some(self.toolpath.as_ref()?.svg().into_bytes()),
        }
    }
}

fn json(value: &impl Serialize) -> Option<Vec<u8>> {
    let mut text = serde_json::to_vec(value).ok()?;
    text.push(b'\n');
    Some(text)
}

/// An ended job to make results of.
#[derive(Debug)]
pub(crate) struct Source<'a> {
    pub(crate) info: &'a Arc<Info>,
    pub(crate) outcome: Outcome,
    pub(crate) log: &'a std::path::Path,
}

impl Source<'_> {
    fn events(&self) -> io::Result<Events> {
        Ok(Events::new(Reader::open_ended(self.log, 0)?))
    }

    /// Makes results from the log.
    pub(crate) fn fold(&self, timeline: bool, toolpath: bool) -> io::Result<Finished> {
        let mut folds = Folds::new(self.info, timeline, toolpath);
        let mut events = self.events()?;
        for (seq, event) in &mut events {
            folds.event(seq, &event);
        }
        events.error().map_or_else(|| Ok(folds.finish(&self.outcome)), Err)
    }

    /// One document made from the log.
    pub(crate) fn document(&self, document: Document) -> io::Result<Vec<u8>> {
        let timeline = matches!(document, Document::TimelineJson | Document::TimelineSvg);
        let toolpath = matches!(document, Document::ToolpathJson | Document::ToolpathSvg);
        Ok(self.fold(timeline, toolpath)?.document(document).unwrap_or_default())
    }

    /// Listing of one channel.
    pub(crate) fn listing(&self, finished: &Finished, channel: u16, out: &mut dyn Write) -> io::Result<()> {
        let mut events = self.events()?;
        listing::render(self.info, channel, &finished.summary, &mut events, out)?;
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
