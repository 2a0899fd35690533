//! The timeline of a job: what every channel did when, and where they met.
//!
//! Invariants: bars of a channel ascend and do not overlap; neighbours of one kind are one bar (waits stay apart);
//! a channel has [`bars::MOST`] bars at most. The stand of a blocked channel is no bar: it has no end and shows in
//! `waits` without a release.

pub mod bars;
mod svg;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use serde::Serialize;

use crate::log::event::{Event, Kind};
use crate::log::info::Info;
use crate::log::meetings::Meetings;
use crate::log::summary::tally::Tally;
use crate::log::summary::{ChannelState, Meeting};
use crate::log::work::Work;
use bars::{Bar, Bars};

/// Timeline of a job.
#[derive(Debug, Clone, Serialize)]
pub struct Timeline {
    /// Unit of all times: `ns`.
    pub unit: &'static str,
    /// When the last channel came to its end.
    pub makespan_ns: i64,
    /// Channels, ascending.
    pub channels: Vec<Channel>,
    /// Meetings as in the summary.
    pub waits: Vec<Meeting>,
    /// Machine, for the title of the picture.
    #[serde(skip)]
    pub machine: String,
}

/// A channel in the timeline.
#[derive(Debug, Clone, Serialize)]
pub struct Channel {
    /// Number.
    pub channel: u16,
    /// Name.
    pub name: String,
    /// What it did.
    pub bars: Vec<Bar>,
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

#[derive(Debug, Default)]
struct Row {
    bars: Bars,
    tally: Tally,
    /// The wait it stands at: line and mark.
    wait: Option<(u32, Arc<str>)>,
}

/// Builds the timeline while the log goes by.
#[derive(Debug)]
pub struct Builder {
    info: Arc<Info>,
    rows: Vec<Row>,
    meetings: Meetings,
    last_ns: i64,
}

impl Builder {
    /// For a job that has not logged anything yet.
    #[must_use]
    pub fn new(info: &Arc<Info>) -> Self {
        let rows = info.channels.iter().map(|_| Row::default()).collect();
        Self { info: info.clone(), rows, meetings: Meetings::new(info), last_ns: 0 }
    }

    /// The next event of the log.
    pub fn event(&mut self, _seq: u64, event: &Event) {
        self.last_ns = self.last_ns.max(event.t_ns);
        self.meetings.event(event);
        let Some(index) = self.info.channel_index(event.channel) else { return };
        let Some(row) = self.rows.get_mut(index) else { return };
        row.tally.event(event);
        match &event.kind {
            Kind::Wait(wait) => row.wait = Some((event.line, (&*wait.key).into())),
            Kind::Release(release) => {
                let line = row.wait.take().map_or(event.line, |(line, _)| line);
                row.bars.wait(release.since_ns, event.t_ns, line, (&*release.key).into());
            }
            kind if event.dur_ns > 0 => {
                if let Some(work) = Work::of(kind) {
                    row.bars.push(work, event.t_ns, event.dur_ns, event.line);
                }
            }
            _ => {}
        }
    }

    /// The log is complete.
    #[must_use]
    pub fn finish(mut self) -> Timeline {
        for (channel, ns) in self.meetings.complete_cut() {
            let row = self.info.channel_index(channel).and_then(|i| self.rows.get_mut(i));
            if let Some(row) = row
                && let Some((line, key)) = row.wait.take()
            {
                row.tally.add(Work::Wait, ns);
                row.bars.wait(self.last_ns - ns, self.last_ns, line, key);
            }
        }
        let (meetings, last_ns) = (&self.meetings, self.last_ns);
        let channels: Vec<Channel> = self
            .info
            .channels
            .iter()
            .zip(self.rows)
            .map(|(channel, mut row)| {
                let since = meetings.waiting_since(channel.number);
                let (state, end_ns) = row.tally.close(since, last_ns, false);
                if let (Some(since), Some((line, key)), true) = (since, row.wait, state != ChannelState::Blocked) {
                    row.bars.wait(since, end_ns, line, key);
                }
                Channel {
                    channel: channel.number,
                    name: channel.name.clone(),
                    bars: row.bars.finish(end_ns),
                    program: channel.program.clone(),
                    state,
                    end_ns,
                    wait_ns: row.tally.wait_ns,
                }
            })
            .collect();
        Timeline {
            unit: "ns",
            makespan_ns: channels.iter().map(|c| c.end_ns).max().unwrap_or(0),
            channels,
            waits: self.meetings.finish(),
            machine: self.info.machine.clone(),
        }
    }
}

impl Timeline {
    /// The timeline as a picture of 1200 px width.
    #[must_use]
    pub fn svg(&self) -> String {
        svg::draw(self)
    }
}
