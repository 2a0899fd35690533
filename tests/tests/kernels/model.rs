//! A model of the primitives that shares nothing with the kernel: one list of steps per channel, and the channel with
//! the earliest time always continues.

use std::collections::BTreeMap;

use super::machine::TICK;
use super::programs::{Set, Step};

/// How a channel ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// At this time, ns.
    At(i64),
    /// Stopped by an alarm.
    Alarm,
    /// It waits or polls indefinitely.
    Never,
}

#[derive(Default)]
struct Channel {
    steps: Vec<Step>,
    at: usize,
    t: i64,
    waits: bool,
    ended: bool,
    /// Stopped by an alarm.
    stopped: bool,
    /// It has jumped back in a poll.
    polls: bool,
}

#[derive(Default)]
struct Model {
    channels: Vec<Channel>,
    flags: BTreeMap<u32, Set>,
    ranks: Vec<u32>,
    /// Signals of a sender to a receiver with a mark; sender 0: to all channels.
    signals: BTreeMap<(usize, usize, u32), u32>,
    leases: BTreeMap<u32, (Option<usize>, Vec<usize>)>,
    variables: Set,
    /// The last time at which a channel acted for others, and that channel.
    last: Option<(i64, usize)>,
    /// Two channels did something for others at one instant: who came first is not for this model.
    tie: bool,
}

const MS: i64 = 1_000_000;

fn has(set: Set, channel: usize) -> bool {
    set & (1 << channel) != 0
}

/// Loops and calls written out.
fn unrolled(steps: &[Step], out: &mut Vec<Step>) {
    for step in steps {
        match step {
            Step::Loop(times, body) | Step::Call(times, body) => (0..*times).for_each(|_| unrolled(body, out)),
            other => out.push(other.clone()),
        }
    }
}

/// How channels end; none if two do something for others at one instant.
pub fn ends(programs: &[Vec<Step>]) -> Option<Vec<End>> {
    let channel = |program: &Vec<Step>| {
        let mut steps = Vec::new();
        unrolled(program, &mut steps);
        Channel { steps, ..Channel::default() }
    };
    let mut model =
        Model { channels: programs.iter().map(channel).collect(), ranks: vec![0; programs.len()], ..Model::default() };
    while let Some(own) = model.next() {
        model.step(own);
        if model.tie {
            return None;
        }
    }
    let end = |channel: &Channel| match channel {
        Channel { ended: true, t, .. } => End::At(*t),
        Channel { stopped: true, .. } => End::Alarm,
        _ => End::Never,
    };
    Some(model.channels.iter().map(end).collect())
}

impl Model {
    /// The channel that is furthest behind; none when no channel can change anything any more.
    fn next(&self) -> Option<usize> {
        let runs = |channel: &&Channel| !channel.ended && !channel.waits && !channel.stopped;
        let polls_in_vain = |channel: &Channel| matches!(channel.steps.get(channel.at), Some(Step::Poll(mark, _)) if !has(self.variables, *mark as usize));
        if self.channels.iter().filter(runs).all(polls_in_vain) {
            return None;
        }
        (0..self.channels.len()).filter(|&own| runs(&&self.channels[own])).min_by_key(|&own| self.channels[own].t)
    }

    fn step(&mut self, own: usize) {
        let (t, at) = (self.channels[own].t, self.channels[own].at);
        let Some(step) = self.channels[own].steps.get(at).cloned() else {
            self.channels[own].ended = true;
            self.touches(own, t);
            return self.settle(t);
        };
        if let Step::Dwell(ms) = step {
            self.channels[own].t += ms as i64 * MS;
            self.channels[own].at += 1;
            return;
        }
        self.touches(own, t);
        let bit: Set = 1 << own;
        match step {
            Step::Sync(..) | Step::Meet(_) | Step::Take(..) | Step::Join(_) => self.channels[own].waits = true,
            Step::Flag(mark, _) => {
                *self.flags.entry(mark).or_default() |= bit;
                self.channels[own].waits = true;
            }
            Step::Raise(mark) => *self.flags.entry(mark).or_default() |= bit,
            Step::Lower(mark) => *self.flags.entry(mark).or_default() &= !bit,
            Step::Rank(number) if number < self.ranks[own] => self.channels[own].stopped = true,
            Step::Rank(number) => {
                self.ranks[own] = number;
                self.channels[own].waits = true;
            }
            Step::Send(mark, to) => {
                for to_whom in (0..self.channels.len()).filter(|&other| other != own) {
                    let from = match to {
                        Some(to) if has(to, to_whom) => own + 1,
                        Some(_) => continue,
                        None => 0,
                    };
                    *self.signals.entry((from, to_whom, mark)).or_default() += 1;
                }
            }
            Step::Get(mark) => {
                self.leases.entry(mark).or_default().1.push(own);
                self.channels[own].waits = true;
            }
            Step::Put(mark) if self.leases.get(&mark).is_none_or(|(holder, _)| *holder != Some(own)) => {
                self.channels[own].stopped = true;
            }
            Step::Put(mark) => self.leases.entry(mark).or_default().0 = None,
            Step::Write(mark) => self.variables |= 1 << mark,
            Step::Poll(mark, ms) if !has(self.variables, mark as usize) => {
                let channel = &mut self.channels[own];
                // The first jump back makes the loop known, each later one takes a tick.
                channel.t += match ms {
                    0 if std::mem::replace(&mut channel.polls, true) => TICK,
                    _ => ms as i64 * MS,
                };
                return;
            }
            Step::Poll(..) => self.channels[own].polls = false,
            Step::Dwell(_) | Step::Loop(..) | Step::Call(..) | Step::Other(_) => unreachable!(),
        }
        if !self.channels[own].waits {
            self.channels[own].at += 1;
        }
        self.settle(t);
    }

    /// A channel does something that others may see.
    fn touches(&mut self, own: usize, t: i64) {
        self.tie |= self.last.is_some_and(|(when, who)| when == t && who != own);
        self.last = Some((t, own));
    }

    /// Lets channels continue until none can.
    fn settle(&mut self, t: i64) {
        loop {
            let free: Vec<usize> = (0..self.channels.len()).filter(|&own| self.is_free(own)).collect();
            if free.is_empty() {
                return;
            }
            for &own in &free {
                self.leave(own);
                let channel = &mut self.channels[own];
                channel.waits = false;
                channel.at += 1;
                channel.t = t;
            }
        }
    }

    fn waits_at(&self, own: usize) -> Option<&Step> {
        let channel = &self.channels[own];
        if channel.waits { channel.steps.get(channel.at) } else { None }
    }

    fn is_free(&self, own: usize) -> bool {
        let all = 0..self.channels.len();
        let others = || (0..self.channels.len()).filter(|&other| other != own);
        match self.waits_at(own) {
            Some(Step::Sync(mark, list)) => all
                .filter(|&other| has(*list, other))
                .all(|other| matches!(self.waits_at(other), Some(Step::Sync(its, _)) if its == mark)),
            Some(Step::Meet(mark)) => {
                others().any(|other| matches!(self.waits_at(other), Some(Step::Meet(its)) if its == mark))
            }
            Some(Step::Flag(mark, list)) => {
                let flags = self.flags.get(mark).copied().unwrap_or(0);
                flags & list == *list
            }
            Some(Step::Rank(number)) => {
                others().all(|other| self.channels[other].ended || self.ranks[other] >= *number)
            }
            Some(Step::Take(mark, None)) => self.signals.get(&(0, own, *mark)).is_some_and(|count| *count > 0),
            Some(Step::Take(mark, Some(from))) => all
                .filter(|&other| has(*from, other))
                .all(|other| self.signals.get(&(other + 1, own, *mark)).is_some_and(|count| *count > 0)),
            Some(Step::Get(mark)) => {
                let (holder, queue) = &self.leases[mark];
                *holder == Some(own) || holder.is_none() && queue.first() == Some(&own)
            }
            Some(Step::Join(list)) => all.filter(|&other| has(*list, other)).all(|other| self.channels[other].ended),
            _ => false,
        }
    }

    /// Changes at the end of a wait.
    fn leave(&mut self, own: usize) {
        match self.waits_at(own).cloned() {
            Some(Step::Flag(mark, _)) => *self.flags.entry(mark).or_default() &= !(1 << own),
            Some(Step::Take(mark, from)) => {
                let senders = (0..=self.channels.len()).filter(|&sender| match from {
                    None => sender == 0,
                    Some(from) => sender > 0 && has(from, sender - 1),
                });
                for sender in senders.collect::<Vec<_>>() {
                    *self.signals.entry((sender, own, mark)).or_default() -= 1;
                }
            }
            Some(Step::Get(mark)) => {
                let (holder, queue) = self.leases.entry(mark).or_default();
                *holder = Some(own);
                queue.retain(|&other| other != own);
            }
            _ => {}
        }
    }
}
