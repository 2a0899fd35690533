//! The timeline of a job: the activity of every channel, and the sync points.
//!
//! Invariants: bars of a channel ascend and do not overlap; neighbours of one kind are one bar (waits stay apart); a
//! channel has [`bars::MOST`] bars at most. The open wait of a blocked channel is not a bar: it has no end and shows in
//! `waits` without a release.

pub mod bars;
mod svg;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use serde::ser::SerializeStruct as _;
use serde::{Serialize, Serializer};

use crate::spans::ToolSpan;
use crate::summary::{ChannelState, Waits};
use bars::ActivityBar;
use counterpoint_event::FileId;
use counterpoint_event::info::{self, Info};

/// Timeline of a job.
#[derive(Debug, Clone, Serialize)]
pub struct Timeline {
    /// Unit of all times: `ns`.
    pub unit: &'static str,
    /// When the last channel came to its end.
    pub makespan_ns: i64,
    /// Channels, ascending.
    pub channels: Vec<ChannelTimeline>,
    /// Sync points as in the summary.
    pub waits: Waits,
    /// Machine, for the title of the picture.
    #[serde(skip)]
    pub machine: String,
    /// The job has failed or was cancelled, for the title of the picture.
    #[serde(skip)]
    pub failed: bool,
}

/// A channel in the timeline.
#[derive(Debug, Clone)]
pub struct ChannelTimeline {
    /// Number.
    pub channel: u16,
    /// Name.
    pub name: String,
    /// Its activity.
    pub bars: Vec<ActivityBar>,
    /// Its tools in work, left out without any.
    pub tools: Vec<ToolSpan>,
    /// Program, for the title of the picture.
    pub program: String,
    /// How it ended, for the marks of the picture.
    pub state: ChannelState,
    /// When it ended, ns.
    pub end_ns: i64,
    /// Time spent waiting, ns.
    pub wait_ns: i64,
    /// The job, for the names of files.
    info: Arc<Info>,
}

/// A bar with the name of its file.
#[derive(Serialize)]
struct NamedBar<'a> {
    #[serde(flatten)]
    bar: &'a ActivityBar,
    #[serde(skip_serializing_if = "str::is_empty")]
    file: &'a str,
}

/// The bars of a channel with the names of their files.
struct NamedBars<'a>(&'a ChannelTimeline);

impl Serialize for NamedBars<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer
            .collect_seq(self.0.bars.iter().map(|bar| NamedBar { bar, file: self.0.file_name(bar.file, bar.line) }))
    }
}

impl Serialize for ChannelTimeline {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("Channel", 3 + usize::from(!self.tools.is_empty()))?;
        fields.serialize_field("channel", &self.channel)?;
        fields.serialize_field("name", &self.name)?;
        fields.serialize_field("bars", &NamedBars(self))?;
        if !self.tools.is_empty() {
            fields.serialize_field("tools", &self.tools)?;
        }
        fields.end()
    }
}

impl ChannelTimeline {
    /// From the bars and tools of a channel, its state, where it ended and how long it waited.
    pub fn new(
        (info, channel): (&Arc<Info>, &info::JobChannel),
        (bars, tools): (Vec<ActivityBar>, Vec<ToolSpan>),
        (state, end_ns): (ChannelState, i64),
        wait_ns: i64,
    ) -> Self {
        let (name, program) = (channel.name.clone(), channel.program.clone());
        let info = Arc::clone(info);
        Self { channel: channel.number, name, bars, tools, program, state, end_ns, wait_ns, info }
    }

    /// Name of the file of a line; empty for line 0.
    #[must_use]
    pub fn file_name(&self, file: FileId, line: u32) -> &str {
        if line == 0 { "" } else { self.info.file_name(file) }
    }
}

impl Timeline {
    /// From its rows and sync points.
    pub fn new(info: &Info, channels: Vec<ChannelTimeline>, waits: Waits, failed: bool) -> Self {
        let makespan_ns = channels.iter().map(|c| c.end_ns).max().unwrap_or(0);
        Self { unit: "ns", makespan_ns, channels, waits, machine: info.machine.clone(), failed }
    }

    /// The timeline as a picture of 1200 px width.
    #[must_use]
    pub fn svg(&self) -> String {
        svg::draw(self)
    }
}
