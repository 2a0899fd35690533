//! All results of a job in one pass over its events.
//!
//! Two ways lead to the same results: the ordered log, event by event ([`ResultsBuilder::event`]), or the stream of
//! every channel into the results of that channel, on the thread of its kernel. A run goes the second way; results from
//! a stored log go the first.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use counterpoint_event::RunEnd;

use crate::channel_results::ChannelResults;
use crate::coordinates;
use crate::digest::{self, Digest};
use crate::reported::Reported;
use crate::summary::{self, ChannelState, JobOutcome, Summary};
use crate::sync_points::SyncPoints;
use crate::timeline::{self, Timeline};
use crate::toolpath::{self, StopPlace, Toolpath, Track};
use counterpoint_event::event::{Event, FileId, WorkClass};
use counterpoint_event::info::Info;

/// Least severity of an error.
const ERROR: u8 = 8;

/// Results in the making.
#[derive(Debug)]
pub struct ResultsBuilder {
    info: Arc<Info>,
    channels: Vec<ChannelResults>,
    /// Fingerprint of the master's events.
    master: Digest,
    /// Diagnostics and verdicts, in the order of the log.
    reported: Vec<Reported>,
    last_ns: i64,
}

/// Results of a job.
#[derive(Debug)]
pub struct JobResults {
    /// How it ended and how long everything took.
    pub summary: Summary,
    /// The activity of every channel over time.
    pub timeline: Timeline,
    /// Where the tools went.
    pub toolpath: Toolpath,
}

impl ResultsBuilder {
    /// For a job that has not logged anything yet.
    #[must_use]
    pub fn new(info: &Arc<Info>) -> Self {
        let channels = info.channels.iter().map(|channel| ChannelResults::new(info, channel)).collect();
        Self { info: info.clone(), channels, master: Digest::new(), reported: Vec::new(), last_ns: 0 }
    }

    /// For a job whose toolpath is not requested: it stays empty, which saves the memory of a long path.
    #[must_use]
    pub fn without_toolpath(mut self) -> Self {
        self.channels.iter_mut().for_each(|channel| channel.track = None);
        self
    }

    /// The next event of the ordered log.
    #[inline]
    pub fn event(&mut self, event: &Event) {
        self.reported.extend(Reported::of(event));
        match self.info.channel_index(event.channel).and_then(|index| self.channels.get_mut(index)) {
            Some(channel) => channel.event(event),
            None => self.of_master(event),
        }
    }

    fn of_master(&mut self, event: &Event) {
        self.last_ns = self.last_ns.max(event.t_ns);
        self.master.event(event);
    }

    /// Gives the results of the channels away, in the order of the channels, to be made each on its own;
    /// [`join`](Self::join) takes them back.
    pub fn split(&mut self) -> Vec<ChannelResults> {
        std::mem::take(&mut self.channels)
    }

    /// Takes the results of all channels back and puts their diagnostics and verdicts in order.
    pub fn join(&mut self, channels: Vec<ChannelResults>) {
        self.channels = channels;
        // Those of a channel are in order; of those at the same tag the lower channel's come first.
        let of_channels = self.channels.iter_mut().map(|channel| std::mem::take(&mut channel.reported));
        let mut streams: Vec<_> = of_channels.map(|reported| reported.into_iter().peekable()).collect();
        self.reported.reserve(streams.iter().map(ExactSizeIterator::len).sum());
        loop {
            let heads =
                streams.iter_mut().filter_map(|stream| Some((stream.peek().map(|r| (r.t_ns, r.micro))?, stream)));
            let Some(next) = heads.min_by_key(|(tag, _)| *tag).and_then(|(_, stream)| stream.next()) else { break };
            if next.channel == 0 {
                self.of_master(&next.event());
            }
            self.reported.push(next);
        }
    }

    /// The log is complete.
    #[must_use]
    pub fn finish(self, outcome: &RunEnd) -> JobResults {
        let Self { info, mut channels, master, reported, last_ns } = self;
        let last_ns = channels.iter().map(|channel| channel.last_ns).fold(last_ns, i64::max);
        let mut findings = summary::Findings::new(&info);
        reported.iter().for_each(|reported| findings.take(reported));
        let mut sync_points = SyncPoints::new(&info);
        for channel in &mut channels {
            sync_points.take(channel.number, std::mem::take(&mut channel.stays), channel.wait.take());
        }
        sync_points.complete_cut(|number, stay| {
            let Some(channel) = channels.iter_mut().find(|channel| channel.number == number) else { return };
            let ns = stay.ns();
            channel.tally.add(WorkClass::Wait, ns);
            channel.bars.wait(last_ns - ns, last_ns, stay);
        });
        let (mut ends, mut rows, mut tracks, mut digests) = (Vec::new(), Vec::new(), Vec::new(), vec![(0, master)]);
        let mut units = Vec::new();
        let mut cut_short = false;
        for (results, channel) in channels.into_iter().zip(&info.channels) {
            let ChannelResults {
                number, digest, mut tally, mut bars, track, program, tools, spans, units: read, ..
            } = results;
            units.push((channel, read));
            let stay = sync_points.open_stay(number);
            let since = stay.map(|stay| stay.since_ns);
            let (state, end_ns) = tally.close(since, last_ns, outcome.cancelled);
            cut_short |= tally.is_cut_short(state);
            if let (Some(stay), true) = (stay, state != ChannelState::Blocked) {
                bars.wait(stay.since_ns, end_ns, stay);
            }
            let mut tools = tools.finish(tally.times());
            let spans = spans.finish(&info, &tools, end_ns);
            let mut operations: FxHashMap<u32, &str> = FxHashMap::default();
            spans.iter().for_each(|span| {
                operations.entry(span.tool).or_insert(&span.operation);
            });
            for tool in &mut tools {
                tool.operation = operations.get(&tool.tool).copied().unwrap_or_default().to_owned();
            }
            let bars = (bars.finish(end_ns), spans);
            rows.push(timeline::ChannelTimeline::new((&info, channel), bars, (state, end_ns), tally.wait_ns));
            let mut end = summary::ChannelSummary::new(channel, &tally, (state, end_ns));
            if let Some(file) = program {
                info.file_name(file).clone_into(&mut end.program);
            }
            end.tools = tools;
            ends.push(end);
            tracks.push(track.unwrap_or_else(|| Track::new(&info, channel)));
            digests.push((number, digest));
        }
        let sync_points = sync_points.finish();
        let digest = digest::log(digests.into_iter());
        let coordinates = coordinates::of(&info, units.into_iter());
        let summary = findings.finish(ends, sync_points.clone(), (outcome.cancelled, cut_short), (digest, coordinates));
        let failed = summary.state != JobOutcome::Succeeded;
        let stops: Vec<_> = rows
            .iter()
            .zip(&tracks)
            .map(|(row, track)| stop_place(&info, &summary, row.channel, track.last_place()))
            .collect();
        let spans = rows.iter().map(|row| row.tools.as_slice());
        let tracks =
            tracks.into_iter().zip(spans).zip(stops).map(|((track, spans), stop)| (track, spans, stop)).collect();
        let toolpath = toolpath::Toolpath::new(&info, tracks, failed);
        JobResults { summary, timeline: Timeline::new(&info, rows, sync_points, failed), toolpath }
    }
}

/// The place where a channel stopped before its end: at its last error, at its wait, otherwise after its last move.
fn stop_place(info: &Info, summary: &Summary, number: u16, last: Option<(FileId, u32)>) -> Option<StopPlace> {
    let state = summary.channels.iter().find(|channel| channel.channel == number)?.state;
    if matches!(state, ChannelState::Ended | ChannelState::NotStarted) {
        return None;
    }
    let own =
        |found: &&summary::DiagnosticSummary| found.channel == number && found.severity >= ERROR && found.line > 0;
    let error = || summary.diagnostics.iter().rfind(own).map(|found| (found.file.clone(), found.line));
    let wait = || {
        let open = summary.waits.iter().filter(|point| point.release_ns.is_none());
        let arrival = open.flat_map(|point| &point.arrivals).find(|arrival| arrival.channel == number)?;
        Some((arrival.file.to_string(), arrival.line))
    };
    let (file, line) = if state == ChannelState::Blocked { wait() } else { error() }
        .or_else(|| last.map(|(file, line)| (info.file_name(file).to_owned(), line)))
        .unwrap_or_default();
    Some(StopPlace { state, file, line })
}
