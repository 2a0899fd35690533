//! Causes of the cycle time of a job: the cost of each channel for the others, the chain of work that ends last, and
//! possible savings elsewhere.
//!
//! All results are computed from the times at which channels arrived at sync points and continued, and from the
//! channels that let them continue, as the summary has them. The work between is fixed; a wait ends when its partner
//! comes, acts or ends. If an act (a flag that was set before) let a channel through without a wait, the act counts as
//! made at the arrival of the channel, because the log does not give its time. So slack and savings are never too
//! large. *Invariant:* sync points are in causal order, so one pass backwards finds the latest times, one forwards the
//! new ones.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::sync_points::SyncPoint;
use counterpoint_event::event::Primitive;

/// Most marks that are listed by their costs, and most that are listed as redundant.
const MOST_KEYS: usize = 1000;

/// A part of the critical path: a channel from one time to another, ns.
pub type Stretch = (u16, i64, i64);

/// The causes of the cycle time.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Analysis {
    /// By mark: time that channels waited there for the last one, ns, all channels and passes together; most first.
    pub wait_cost: Vec<(Arc<str>, i64)>,
    /// The chain of work that decides the cycle time, from 0 to its end: to shorten the job, shorten one of these.
    pub critical: Vec<Stretch>,
    /// By channel: how much longer it may take anywhere without a later end of the job, ns.
    pub slack: BTreeMap<u16, i64>,
    /// Marks at which, in every pass, all channels had just continued from one sync point that they shared.
    pub redundant: Vec<Arc<str>>,
    /// Variables whose value only timing decides: the line of each of the two accesses, by channel, in the order of the
    /// log.
    #[serde(default)]
    pub races: Vec<Race>,
}

/// Two accesses that race: the variable, and by channel the line.
pub type Race = (Arc<str>, BTreeMap<u16, u32>);

/// Saving by a faster channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct WhatIf {
    /// Channel.
    pub channel: u16,
    /// How much faster its work is, ns; negative: slower.
    pub faster_ns: i64,
    /// How much earlier the job ends, ns; negative: later.
    pub saves_ns: i64,
}

/// A channel on its way through the sync points.
#[derive(Debug, Clone, Copy)]
struct RetimedChannel {
    channel: u16,
    end_ns: i64,
    /// Time of the log up to which it has been followed.
    at_ns: i64,
    /// The latest or the new time for that.
    new_ns: i64,
}

/// A sync point that was passed: when, by whose doing, and who arrived when.
struct PassedSyncPoint<'a> {
    point: &'a SyncPoint,
    release_ns: i64,
}

impl PassedSyncPoint<'_> {
    /// Whether all channels are needed, so none continues before the last arrival.
    fn is_mutual(&self) -> bool {
        matches!(self.point.kind, Primitive::Barrier | Primitive::Count)
    }

    /// Channel that let others continue without arriving itself.
    fn actor(&self) -> Option<u16> {
        let by = Some(self.point.by).filter(|by| *by != 0);
        by.filter(|by| self.point.arrivals.iter().all(|arrival| arrival.channel != *by))
    }
}

fn passed(waits: &[SyncPoint]) -> impl DoubleEndedIterator<Item = PassedSyncPoint<'_>> {
    waits.iter().filter_map(|point| Some(PassedSyncPoint { point, release_ns: point.release_ns? }))
}

fn course(courses: &mut [RetimedChannel], channel: u16) -> Option<&mut RetimedChannel> {
    courses.iter_mut().find(|course| course.channel == channel)
}

impl Analysis {
    /// From the ends of the channels (number, ns) and the sync points of a job; these do not include races.
    #[must_use]
    pub fn of(ends: &[(u16, i64)], waits: &[SyncPoint]) -> Self {
        Self {
            wait_cost: wait_cost(waits),
            critical: critical(ends, waits),
            slack: slack(ends, waits),
            redundant: redundant(waits),
            races: Vec::new(),
        }
    }
}

fn wait_cost(waits: &[SyncPoint]) -> Vec<(Arc<str>, i64)> {
    let mut costs: BTreeMap<&Arc<str>, i64> = BTreeMap::new();
    for PassedSyncPoint { point, release_ns } in passed(waits) {
        let cost = costs.entry(&point.key).or_default();
        for arrival in &point.arrivals {
            *cost = cost.saturating_add(release_ns.saturating_sub(arrival.t_ns));
        }
    }
    let mut costs: Vec<(Arc<str>, i64)> =
        costs.into_iter().filter(|(_, ns)| *ns > 0).map(|(key, ns)| (key.clone(), ns)).collect();
    costs.sort_by_key(|(_, ns)| std::cmp::Reverse(*ns));
    costs.truncate(MOST_KEYS);
    costs
}

/// From the end backwards: to the last wait of the channel, then on in the channel that ended it.
fn critical(ends: &[(u16, i64)], waits: &[SyncPoint]) -> Vec<Stretch> {
    let Some(&(mut channel, mut until)) = ends.iter().rev().max_by_key(|(_, end_ns)| *end_ns) else {
        return Vec::new();
    };
    let mut path = Vec::new();
    for PassedSyncPoint { point, release_ns } in passed(waits).rev() {
        let waited = point.arrivals.iter().any(|arrival| arrival.channel == channel && arrival.t_ns < release_ns);
        if !waited || point.by == channel || point.by == 0 || release_ns > until {
            continue;
        }
        if release_ns < until {
            path.push((channel, release_ns, until));
        }
        (channel, until) = (point.by, release_ns);
    }
    if until > 0 {
        path.push((channel, 0, until));
    }
    path.reverse();
    path
}

fn slack(ends: &[(u16, i64)], waits: &[SyncPoint]) -> BTreeMap<u16, i64> {
    let last = ends.iter().map(|(_, end_ns)| *end_ns).max().unwrap_or(0);
    let start = |&(channel, end_ns): &(u16, i64)| RetimedChannel { channel, end_ns, at_ns: end_ns, new_ns: last };
    let mut courses: Vec<RetimedChannel> = ends.iter().map(start).collect();
    let mut slack: BTreeMap<u16, i64> = ends.iter().map(|&(channel, end_ns)| (channel, last - end_ns)).collect();
    let mut less = |channel: u16, ns: i64| {
        slack.entry(channel).and_modify(|known| *known = ns.min(*known));
    };
    for passed in passed(waits).rev() {
        let PassedSyncPoint { point, release_ns } = passed;
        let mut latest = i64::MAX;
        for arrival in &point.arrivals {
            let Some(course) = course(&mut courses, arrival.channel) else { continue };
            let after = course.new_ns - (course.at_ns - release_ns).max(0);
            latest = latest.min(after);
            (course.at_ns, course.new_ns) = (arrival.t_ns, after);
        }
        for arrival in &point.arrivals {
            let Some(course) = course(&mut courses, arrival.channel) else { continue };
            if passed.is_mutual() {
                course.new_ns = latest;
            }
            less(arrival.channel, course.new_ns - course.at_ns);
        }
        if let Some(course) = passed.actor().and_then(|by| course(&mut courses, by)) {
            let at_ns = release_ns.min(course.at_ns);
            let new_ns = latest.min(course.new_ns - (course.at_ns - at_ns));
            (course.at_ns, course.new_ns) = (at_ns, new_ns);
            less(course.channel, new_ns - at_ns);
        }
    }
    slack
}

/// Redundant marks: their sync points always come for all their channels at the instant at which the same channels
/// passed another one, and only the wait happens there.
fn redundant(waits: &[SyncPoint]) -> Vec<Arc<str>> {
    let mut last: BTreeMap<u16, (usize, i64)> = BTreeMap::new();
    let mut keys: BTreeMap<&Arc<str>, bool> = BTreeMap::new();
    for (at, passed) in passed(waits).enumerate() {
        let PassedSyncPoint { point, release_ns } = passed;
        let before =
            |channel: &u16, t_ns: i64| last.get(channel).filter(|(_, until)| *until == t_ns).map(|(at, _)| *at);
        let first = point.arrivals.first().and_then(|arrival| before(&arrival.channel, arrival.t_ns));
        let same = first.is_some()
            && passed.is_mutual()
            && !point.acts
            && point.arrivals.iter().all(|arrival| before(&arrival.channel, arrival.t_ns) == first);
        keys.entry(&point.key).and_modify(|always| *always &= same).or_insert(same);
        for arrival in &point.arrivals {
            last.insert(arrival.channel, (at, release_ns));
        }
    }
    keys.into_iter().filter(|(_, always)| *always).map(|(key, _)| key.clone()).take(MOST_KEYS).collect()
}

impl WhatIf {
    /// The saving if the work of a channel takes `faster_ns` less in all, every part of it in proportion; none if there
    /// is no such channel or it has less work than that.
    #[must_use]
    pub fn of(ends: &[(u16, i64)], waits: &[SyncPoint], channel: u16, faster_ns: i64) -> Option<Self> {
        let &(_, end_ns) = ends.iter().find(|(known, _)| *known == channel)?;
        let waited: i64 = passed(waits)
            .flat_map(|passed| passed.point.arrivals.iter().map(move |arrival| (arrival, passed.release_ns)))
            .filter(|(arrival, _)| arrival.channel == channel)
            .map(|(arrival, release_ns)| release_ns - arrival.t_ns)
            .sum();
        let work = end_ns - waited;
        if work <= 0 || faster_ns > work {
            return None;
        }
        let scaled = |of: u16, ns: i64| {
            let ns = i128::from(ns.max(0));
            let part = if of == channel { ns * i128::from(work - faster_ns) / i128::from(work) } else { ns };
            i64::try_from(part).unwrap_or(i64::MAX)
        };
        let start = |&(channel, end_ns): &(u16, i64)| RetimedChannel { channel, end_ns, at_ns: 0, new_ns: 0 };
        let mut courses: Vec<RetimedChannel> = ends.iter().map(start).collect();
        for passed in passed(waits) {
            let PassedSyncPoint { point, release_ns } = passed;
            let mut from = 0;
            if let Some(course) = passed.actor().and_then(|by| course(&mut courses, by)) {
                course.new_ns += scaled(course.channel, release_ns.min(course.end_ns) - course.at_ns);
                course.at_ns = course.at_ns.max(release_ns.min(course.end_ns));
                from = course.new_ns;
            }
            for arrival in &point.arrivals {
                let Some(course) = course(&mut courses, arrival.channel) else { continue };
                course.new_ns += scaled(course.channel, arrival.t_ns - course.at_ns);
                if passed.is_mutual() {
                    from = from.max(course.new_ns);
                }
            }
            for arrival in &point.arrivals {
                let Some(course) = course(&mut courses, arrival.channel) else { continue };
                (course.at_ns, course.new_ns) = (release_ns, course.new_ns.max(from));
            }
        }
        let end = |course: &RetimedChannel| course.new_ns + scaled(course.channel, course.end_ns - course.at_ns);
        let now = courses.iter().map(end).max().unwrap_or(0);
        let before = ends.iter().map(|(_, end_ns)| *end_ns).max().unwrap_or(0);
        Some(Self { channel, faster_ns, saves_ns: before - now })
    }
}

#[cfg(test)]
mod tests;
