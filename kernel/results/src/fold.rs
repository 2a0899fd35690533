//! All results of a job in one pass over its events.
//!
//! Two ways lead to the same results: the ordered log, event by event ([`Folds::event`]), or every channel's own stream
//! into its lane, on any thread, when nobody needs the order between channels.

use std::sync::Arc;

use crate::digest::{self, Digest};
use crate::lane::Lane;
use crate::meetings::Meetings;
use crate::summary::{self, ChannelState, Summary};
use crate::timeline::{self, Timeline};
use crate::told::Told;
use crate::toolpath::{self, Toolpath};
use counterpoint_event::Outcome;
use counterpoint_event::event::Event;
use counterpoint_event::event::Work;
use counterpoint_event::info::Info;

/// Results in the making.
#[derive(Debug)]
pub struct Folds {
    info: Arc<Info>,
    lanes: Vec<Lane>,
    /// Fingerprint of the master's events.
    master: Digest,
    told: Vec<Told>,
    last_ns: i64,
}

/// Results of a job.
#[derive(Debug)]
pub struct Results {
    /// How it ended and how long everything took.
    pub summary: Summary,
    /// What every channel did when.
    pub timeline: Timeline,
    /// Where the tools went.
    pub toolpath: Toolpath,
}

impl Folds {
    /// For a job that has not logged anything yet.
    #[must_use]
    pub fn new(info: &Arc<Info>) -> Self {
        let lanes = info.channels.iter().map(|channel| Lane::new(info, channel)).collect();
        Self { info: info.clone(), lanes, master: Digest::new(), told: Vec::new(), last_ns: 0 }
    }

    /// The next event of the ordered log.
    #[inline]
    pub fn event(&mut self, event: &Event) {
        self.told.extend(Told::of(event));
        match self.info.channel_index(event.channel).and_then(|index| self.lanes.get_mut(index)) {
            Some(lane) => lane.event(event),
            None => self.of_master(event),
        }
    }

    fn of_master(&mut self, event: &Event) {
        self.last_ns = self.last_ns.max(event.t_ns);
        self.master.event(event);
    }

    /// Gives the lanes away, in the order of the channels, to be fed each on its own; [`join`](Self::join) takes them
    /// back.
    pub fn lanes(&mut self) -> Vec<Lane> {
        std::mem::take(&mut self.lanes)
    }

    /// Takes all lanes back and brings together what they were told.
    pub fn join(&mut self, lanes: Vec<Lane>) {
        self.lanes = lanes;
        // Each lane's are in order; of those at the same tag the lower channel's come first.
        let told: Vec<Vec<Told>> = self.lanes.iter_mut().map(|lane| std::mem::take(&mut lane.told)).collect();
        self.told.reserve(told.iter().map(Vec::len).sum());
        let mut told: Vec<_> = told.into_iter().map(|told| told.into_iter().peekable()).collect();
        loop {
            let heads = told.iter_mut().filter_map(|lane| Some((lane.peek().map(|t| (t.t_ns, t.micro))?, lane)));
            let Some(next) = heads.min_by_key(|(tag, _)| *tag).and_then(|(_, lane)| lane.next()) else { break };
            if next.channel == 0 {
                self.of_master(&next.event());
            }
            self.told.push(next);
        }
    }

    /// The log is complete.
    #[must_use]
    pub fn finish(self, outcome: &Outcome) -> Results {
        let Self { info, mut lanes, master, told, last_ns } = self;
        let last_ns = lanes.iter().map(|lane| lane.last_ns).fold(last_ns, i64::max);
        let mut findings = summary::Findings::new(&info);
        told.iter().for_each(|told| findings.take(told));
        let mut meetings = Meetings::new(&info);
        for lane in &mut lanes {
            meetings.take(lane.number, std::mem::take(&mut lane.stays), lane.wait.take());
        }
        meetings.complete_cut(|channel, stay| {
            let Some(lane) = lanes.iter_mut().find(|lane| lane.number == channel) else { return };
            let ns = stay.ns();
            lane.tally.add(Work::Wait, ns);
            lane.bars.wait(last_ns - ns, last_ns, stay);
        });
        let (mut ends, mut rows, mut tracks, mut digests) = (Vec::new(), Vec::new(), Vec::new(), vec![(0, master)]);
        let mut cut_short = false;
        for (lane, channel) in lanes.into_iter().zip(&info.channels) {
            let Lane { number, digest, mut tally, mut bars, track, program, tools, spans, .. } = lane;
            let stay = meetings.standing(number);
            let since = stay.map(|stay| stay.since_ns);
            let (state, end_ns) = tally.close(since, last_ns, outcome.cancelled);
            cut_short |= tally.is_cut_short(state);
            if let (Some(stay), true) = (stay, state != ChannelState::Blocked) {
                bars.wait(stay.since_ns, end_ns, stay);
            }
            let tools = tools.finish();
            let spans = spans.finish(&info, &tools, end_ns);
            let bars = (bars.finish(end_ns), spans);
            rows.push(timeline::Channel::new(channel, bars, (state, end_ns), tally.wait_ns));
            let mut end = summary::Channel::new(channel, &tally, (state, end_ns));
            if let Some(file) = program {
                info.file_name(file).clone_into(&mut end.program);
            }
            end.tools = tools;
            ends.push(end);
            tracks.push(track);
            digests.push((number, digest));
        }
        let meetings = meetings.finish();
        let digest = digest::log(digests.into_iter());
        let tracks = tracks.into_iter().zip(&rows).map(|(track, row)| (track, row.tools.as_slice())).collect();
        let toolpath = toolpath::Toolpath::new(&info, tracks);
        Results {
            summary: findings.finish(ends, meetings.clone(), (outcome.cancelled, cut_short), digest),
            timeline: Timeline::new(&info, rows, meetings),
            toolpath,
        }
    }
}
