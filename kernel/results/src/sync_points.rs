//! The sync points of a job: the arrivals with place and time, and the release.
//!
//! Joined from the waits of the channels on request. *Invariant:* satisfied waits come in order of their number, then
//! those that never were in order of their first arrival; arrivals ascend by channel.

use std::sync::Arc;

use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};

use crate::late::Late;
use counterpoint_event::event::{FileId, Primitive, Release, WaitArrival};
use counterpoint_event::info::{BLOCK_TEXT, Info};

/// Channels that waited for each other, whether the wait was satisfied or not.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SyncPoint {
    /// Mark as shown to people.
    pub key: Arc<str>,
    /// Primitive.
    pub kind: Primitive,
    /// When all continued, ns; `None`: never.
    pub release_ns: Option<i64>,
    /// Channel whose operation let them continue: the last to come, or the one that set the flag or sent the signal; 0
    /// if none did.
    #[serde(default, skip_serializing_if = "is_none")]
    pub by: u16,
    /// The code does more than wait: it begins or ends balance cutting or a coupling of axes.
    #[serde(default, skip_serializing_if = "is_plain")]
    pub acts: bool,
    /// Channels that arrived, ascending channel.
    pub arrivals: Vec<ChannelArrival>,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde wants a reference")]
fn is_none(channel: &u16) -> bool {
    *channel == 0
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde wants a reference")]
fn is_plain(acts: &bool) -> bool {
    !acts
}

/// Arrival of one channel.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ChannelArrival {
    /// Channel number.
    pub channel: u16,
    /// When, ns.
    pub t_ns: i64,
    /// File name.
    pub file: Arc<str>,
    /// Line.
    pub line: u32,
    /// Text of the block.
    pub block: Arc<str>,
}

/// All sync points of a job.
pub type Waits = Late<Vec<SyncPoint>>;

/// A stay of a channel at a wait.
#[derive(Debug)]
pub struct WaitStay {
    wait: Arc<WaitArrival>,
    pub(super) since_ns: i64,
    pub(super) file: FileId,
    pub(super) line: u32,
    /// Number of the sync point that ended it and when it did; both 0: none yet.
    met: (u64, i64),
    /// Channel that ended it.
    by: u16,
}

impl WaitStay {
    /// A channel arrives.
    pub(super) fn new(wait: &Arc<WaitArrival>, since_ns: i64, (file, line): (FileId, u32)) -> Self {
        Self { wait: wait.clone(), since_ns, file, line, met: (0, 0), by: 0 }
    }

    /// Of a release whose wait is not in the log.
    pub(super) fn unseen(release: &Release, place: (FileId, u32)) -> Self {
        let (key, mark) = (release.key.clone(), release.mark.clone());
        let wait = WaitArrival { key, primitive: release.primitive, participants: [].into(), mark, acts: false };
        Self::new(&Arc::new(wait), release.since_ns, place)
    }

    /// The channel continues.
    pub(super) fn ended(self, release: &Release, t_ns: i64) -> Self {
        Self { since_ns: release.since_ns, met: (release.meeting, t_ns), by: release.by, ..self }
    }

    /// How long it was, once it has ended.
    pub(super) fn ns(&self) -> i64 {
        self.met.1.saturating_sub(self.since_ns)
    }

    /// Mark as shown to people.
    pub(super) fn key(&self) -> Arc<str> {
        self.wait.key.clone()
    }
}

/// A sync point after which at least one channel has continued.
#[derive(Debug)]
struct ReleasedSyncPoint {
    number: u64,
    release_ns: i64,
    /// Ascending channel.
    stays: Vec<(u16, WaitStay)>,
}

impl ReleasedSyncPoint {
    /// Whether a channel that waits takes part, but has not continued.
    fn misses(&self, channel: u16, stay: &WaitStay) -> bool {
        let wait = &stay.wait;
        self.stays.first().is_some_and(|(_, first)| {
            self.stays.len() < first.wait.participants.len()
                && (&first.wait.key, first.wait.primitive) == (&wait.key, wait.primitive)
        }) && self.release_ns >= stay.since_ns
            && self.stays.iter().all(|(other, _)| *other != channel && wait.participants.contains(other))
    }
}

/// Collects the sync points of a log.
#[derive(Debug)]
pub(crate) struct SyncPoints {
    info: Arc<Info>,
    /// Stays that have ended.
    ended: Vec<(u16, Vec<WaitStay>)>,
    /// Stays without an end.
    open: Vec<(u16, WaitStay)>,
    /// For a log that was cut: the fate of the channels that have ended.
    met: Vec<ReleasedSyncPoint>,
}

impl SyncPoints {
    pub(crate) fn new(info: &Arc<Info>) -> Self {
        Self { info: info.clone(), ended: Vec::new(), open: Vec::new(), met: Vec::new() }
    }

    /// The stays of a channel, and the one without an end.
    pub(crate) fn take(&mut self, channel: u16, ended: Vec<WaitStay>, open: Option<WaitStay>) {
        self.ended.push((channel, ended));
        self.open.extend(open.map(|stay| (channel, stay)));
    }

    /// Ends stays whose partner has continued: the log was cut between their releases. Calls `ended` with each of them.
    pub(crate) fn complete_cut(&mut self, mut ended: impl FnMut(u16, &WaitStay)) {
        if self.open.is_empty() {
            return;
        }
        self.met = met(std::mem::take(&mut self.ended));
        for (channel, stay) in std::mem::take(&mut self.open) {
            match self.met.iter_mut().rfind(|met| met.misses(channel, &stay)) {
                Some(met) => {
                    let by = met.stays.first().map_or(0, |(_, first)| first.by);
                    let stay = WaitStay { met: (met.number, met.release_ns), by, ..stay };
                    ended(channel, &stay);
                    met.stays.push((channel, stay));
                    met.stays.sort_by_key(|(channel, _)| *channel);
                }
                None => self.open.push((channel, stay)),
            }
        }
    }

    /// The stay of a channel that has no end.
    pub(crate) fn open_stay(&self, channel: u16) -> Option<&WaitStay> {
        self.open.iter().find(|(c, _)| *c == channel).map(|(_, stay)| stay)
    }

    /// Satisfied waits, then those that never were.
    pub(crate) fn finish(self) -> Waits {
        Waits::new(move || self.all())
    }

    fn all(mut self) -> Vec<SyncPoint> {
        self.met.extend(met(self.ended));
        let mut places = BlockTextCache { info: &self.info, known: FxHashMap::default() };
        let mut all = Vec::with_capacity(self.met.len());
        for ReleasedSyncPoint { release_ns, stays, .. } in self.met {
            let Some((_, first)) = stays.first() else { continue };
            let (key, kind, release_ns, by) = (first.key(), first.wait.primitive, Some(release_ns), first.by);
            let arrivals = stays.iter().map(|(channel, stay)| places.arrival(*channel, stay)).collect();
            all.push(SyncPoint { key, kind, release_ns, by, acts: first.wait.acts, arrivals });
        }
        self.open.sort_by_key(|(channel, stay)| (stay.since_ns, *channel));
        let mut open: Vec<(Arc<WaitArrival>, SyncPoint)> = Vec::new();
        for (channel, stay) in self.open {
            let arrival = places.arrival(channel, &stay);
            match open.iter_mut().find(|(wait, _)| **wait == *stay.wait) {
                Some((_, point)) => {
                    point.arrivals.push(arrival);
                    point.arrivals.sort_by_key(|a| a.channel);
                }
                None => {
                    let (key, kind, acts) = (stay.key(), stay.wait.primitive, stay.wait.acts);
                    let point = SyncPoint { key, kind, release_ns: None, by: 0, acts, arrivals: vec![arrival] };
                    open.push((stay.wait, point));
                }
            }
        }
        all.extend(open.into_iter().map(|(_, point)| point));
        all
    }
}

/// Brings the stays of all channels together.
fn met(ended: Vec<(u16, Vec<WaitStay>)>) -> Vec<ReleasedSyncPoint> {
    let stays = ended.into_iter().flat_map(|(channel, stays)| stays.into_iter().map(move |stay| (channel, stay)));
    let mut stays: Vec<(u16, WaitStay)> = stays.collect();
    stays.sort_by_key(|(channel, stay)| (stay.met.0, *channel));
    let mut all: Vec<ReleasedSyncPoint> = Vec::new();
    for (channel, stay) in stays {
        let (number, release_ns) = stay.met;
        match all.last_mut().filter(|met| met.number == number) {
            Some(met) => met.stays.push((channel, stay)),
            None => all.push(ReleasedSyncPoint { number, release_ns, stays: vec![(channel, stay)] }),
        }
    }
    all
}

/// Names of files and texts of blocks: loops wait at the same lines again and again.
struct BlockTextCache<'a> {
    info: &'a Info,
    known: FxHashMap<(FileId, u32), (Arc<str>, Arc<str>)>,
}

impl BlockTextCache<'_> {
    fn arrival(&mut self, channel: u16, stay: &WaitStay) -> ChannelArrival {
        let (info, line) = (self.info, stay.line);
        let (file, block) = self.known.entry((stay.file, line)).or_insert_with(|| {
            let name = if line == 0 { "" } else { info.file_name(stay.file) };
            (name.into(), info.block_text(stay.file, line, BLOCK_TEXT).into())
        });
        ChannelArrival { channel, t_ns: stay.since_ns, file: file.clone(), line, block: block.clone() }
    }
}
