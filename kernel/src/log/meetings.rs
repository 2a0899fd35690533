//! The meetings of a job: who arrived where and when, and when all went on.
//!
//! Read off `Wait` and `Release` events. Invariant: completed meetings come in order of their number, then the waits
//! that never came true in order of their first arrival; arrivals ascend by channel.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::log::event::{FileId, Primitive, Release, Wait};
use crate::log::info::{BLOCK_TEXT, Info};
use crate::log::told::{Place, Told, What};

/// One meeting, or a wait that never came true.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Meeting {
    /// Mark as shown to people.
    pub key: Arc<str>,
    /// Primitive.
    pub kind: Primitive,
    /// When everybody went on, ns; `None`: never.
    pub release_ns: Option<i64>,
    /// Who arrived, ascending channel.
    pub arrivals: Vec<Arrival>,
}

/// Arrival of one channel.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Arrival {
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

/// A wait that is not yet released.
#[derive(Debug)]
struct Pending {
    wait: Arc<Wait>,
    channel: u16,
    t_ns: i64,
    line: u32,
    place: Place,
}

/// A meeting of which at least one channel has gone on.
#[derive(Debug)]
struct Met {
    number: u64,
    participants: usize,
    meeting: Meeting,
}

/// Collects the meetings of a log.
#[derive(Debug)]
pub(crate) struct Meetings {
    info: Arc<Info>,
    pending: Vec<Pending>,
    met: Vec<Met>,
}

impl Meetings {
    pub(crate) fn new(info: &Arc<Info>) -> Self {
        Self { info: info.clone(), pending: Vec::new(), met: Vec::new() }
    }

    /// Takes note of waits and releases; nothing else is of interest.
    pub(crate) fn take(&mut self, told: Told) {
        let Told { t_ns, channel, file, line, what, .. } = told;
        match what {
            What::Wait(wait, place) => self.pending.push(Pending { wait, channel, t_ns, line, place }),
            What::Release(release) => self.release((t_ns, channel, file, line), &release),
            What::Diagnostic(_) | What::Verdict(_) => {}
        }
    }

    /// Since when a channel stands at a wait.
    pub(crate) fn waiting_since(&self, channel: u16) -> Option<i64> {
        self.pending.iter().find(|p| p.channel == channel).map(|p| p.t_ns)
    }

    fn release(&mut self, (t_ns, channel, file, line): (i64, u16, FileId, u32), release: &Release) {
        let at = self.pending.iter().position(|p| p.channel == channel);
        let pending = at.map(|at| self.pending.swap_remove(at));
        let participants = pending.as_ref().map_or(0, |p| p.wait.participants.len());
        let (line, place) = pending.map_or_else(|| (line, self.place(file, line)), |p| (p.line, p.place));
        let arrival = arrival(channel, release.since_ns, line, place);
        let place = self.met.iter().rposition(|m| m.number <= release.meeting).map_or(0, |i| i + 1);
        if let Some(met) = place.checked_sub(1).and_then(|i| self.met.get_mut(i))
            && met.number == release.meeting
        {
            let arrivals = &mut met.meeting.arrivals;
            let slot = arrivals.iter().position(|a| a.channel > arrival.channel).unwrap_or(arrivals.len());
            arrivals.insert(slot, arrival);
            return;
        }
        let mut arrivals = Vec::with_capacity(participants);
        arrivals.push(arrival);
        let key = release.key.clone();
        let meeting = Meeting { key, kind: release.primitive, release_ns: Some(t_ns), arrivals };
        self.met.insert(place, Met { number: release.meeting, participants, meeting });
    }

    /// Takes waits whose partner has already been seen going on into its meeting: the log was cut between their
    /// releases. Returns the channels with the time they stood.
    pub(crate) fn complete_cut(&mut self) -> Vec<(u16, i64)> {
        let mut stood = Vec::new();
        let mut index = 0;
        while let Some(pending) = self.pending.get(index) {
            let mark = (&*pending.wait.key, pending.wait.primitive);
            let place = self.met.iter().rposition(|m| {
                m.meeting.arrivals.len() < m.participants
                    && (&*m.meeting.key, m.meeting.kind) == mark
                    && m.meeting.release_ns >= Some(pending.t_ns)
                    && m.meeting.arrivals.iter().all(|a| a.channel != pending.channel)
                    && m.meeting.arrivals.iter().all(|a| pending.wait.participants.contains(&a.channel))
            });
            match place {
                Some(place) => {
                    let pending = self.pending.swap_remove(index);
                    let arrival = arrival(pending.channel, pending.t_ns, pending.line, pending.place);
                    if let Some(met) = self.met.get_mut(place) {
                        stood.push((pending.channel, met.meeting.release_ns.unwrap_or(pending.t_ns) - pending.t_ns));
                        met.meeting.arrivals.push(arrival);
                        met.meeting.arrivals.sort_by_key(|a| a.channel);
                    }
                }
                None => index += 1,
            }
        }
        stood
    }

    /// Completed meetings, then waits that never came true.
    pub(crate) fn finish(mut self) -> Vec<Meeting> {
        self.complete_cut();
        let mut pending = std::mem::take(&mut self.pending);
        pending.sort_by_key(|p| (p.t_ns, p.channel));
        let mut open: Vec<(Arc<Wait>, Meeting)> = Vec::new();
        for p in pending {
            let arrival = arrival(p.channel, p.t_ns, p.line, p.place);
            let key = p.wait.key.clone();
            let same = open.iter_mut().find(|(parts, m)| {
                m.key == key && m.kind == p.wait.primitive && parts.participants == p.wait.participants
            });
            match same {
                Some((_, meeting)) => {
                    meeting.arrivals.push(arrival);
                    meeting.arrivals.sort_by_key(|a| a.channel);
                }
                None => {
                    let meeting = Meeting { key, kind: p.wait.primitive, release_ns: None, arrivals: vec![arrival] };
                    open.push((p.wait, meeting));
                }
            }
        }
        self.met.into_iter().map(|m| m.meeting).chain(open.into_iter().map(|(_, m)| m)).collect()
    }

    /// Of a release whose wait is not in the log.
    fn place(&self, file: FileId, line: u32) -> Place {
        let name = if line == 0 { "" } else { self.info.file_name(file) };
        (name.into(), self.info.block_text(file, line, BLOCK_TEXT).into())
    }
}

fn arrival(channel: u16, t_ns: i64, line: u32, (file, block): Place) -> Arrival {
    Arrival { channel, t_ns, file, line, block }
}
