//! The timeline of a job: the activity of every channel, and the sync points.
//!
//! Invariants: bars of a channel ascend and do not overlap; neighbours of one kind are one bar (waits stay apart); a
//! channel has [`bars::MOST`] bars at most. The open wait of a blocked channel is not a bar: it has no end and shows in
//! `waits` without a release.

pub mod bars;
mod svg;
#[cfg(test)]
mod tests;

use serde::Serialize;

use crate::spans::Span;
use crate::summary::{ChannelState, Waits};
use bars::Bar;
use counterpoint_event::info::{self, Info};

/// Timeline of a job.
#[derive(Debug, Clone, Serialize)]
pub struct Timeline {
    /// Unit of all times: `ns`.
    pub unit: &'static str,
    /// When the last channel came to its end.
    pub makespan_ns: i64,
    /// Channels, ascending.
    pub channels: Vec<Channel>,
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
#[derive(Debug, Clone, Serialize)]
pub struct Channel {
    /// Number.
    pub channel: u16,
    /// Name.
    pub name: String,
    /// Its activity.
    pub bars: Vec<Bar>,
    /// Its tools in work, left out without any.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tools: Vec<Span>,
    /// Program, for the title of the picture.
    #[serde(skip)]
    pub program: String,
    /// How it ended, for the marks of the picture.
    #[serde(skip)]
    pub state: ChannelState,
    /// When it ended, ns.
    #[serde(skip)]
    pub end_ns: i64,
    /// Time spent waiting, ns.
    #[serde(skip)]
    pub wait_ns: i64,
}

impl Channel {
    /// From the bars and tools of a channel, its state, where it ended and how long it waited.
    pub fn new(
        channel: &info::Channel,
        (bars, tools): (Vec<Bar>, Vec<Span>),
        (state, end_ns): (ChannelState, i64),
        wait_ns: i64,
    ) -> Self {
        let (name, program) = (channel.name.clone(), channel.program.clone());
        Self { channel: channel.number, name, bars, tools, program, state, end_ns, wait_ns }
    }
}

impl Timeline {
    /// From its rows and sync points.
    pub fn new(info: &Info, channels: Vec<Channel>, waits: Waits, failed: bool) -> Self {
        let makespan_ns = channels.iter().map(|c| c.end_ns).max().unwrap_or(0);
        Self { unit: "ns", makespan_ns, channels, waits, machine: info.machine.clone(), failed }
    }

    /// The timeline as a picture of 1200 px width.
    #[must_use]
    pub fn svg(&self) -> String {
        svg::draw(self)
    }
}
