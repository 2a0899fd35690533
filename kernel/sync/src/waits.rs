//! All waits of a job: the waiting channels, those that continue, and those that never can.
//!
//! *Invariant:* arrivals, acts and ends come in tag order, so the outcome depends on simulated time alone. All waits
//! that an operation ends are found before anything that they use up is removed. Facts: reference
//! channel-synchronisation.md 1.1, 1.4 (two phases), 2.3 (fix-point).

#[cfg(test)]
mod search;
#[cfg(test)]
mod tests;

use crate::channels::Channels;
use crate::primitives::{LastAxisMove, Letter, PrimitiveState};
use crate::tag::Tag;
use crate::wait::{
    ChannelPlaces, ChannelSet, Finish, MissingChannels, Reaction, Terminal, Wait, WaitMark, WaitOp, WaitRule,
    WaitRules, WaitingChannel,
};
use counterpoint_event::event::Primitive;
use std::collections::BTreeMap;

/// Channels that continue together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Released {
    /// The channels.
    pub channels: ChannelSet,
    /// When, ns.
    pub t: i64,
    /// Their order at that time.
    pub micro: u32,
    /// The channel whose operation let them continue.
    pub by: u16,
    /// Why a partner of a count did not come.
    pub short: Option<ShortfallReason>,
}

/// Why a partner of a count does not come to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShortfallReason {
    /// Its program has ended.
    Ended,
    /// It waits at a wait of the primitive that the rule of the count names.
    Elsewhere,
}

/// Result of an arrival.
#[derive(Debug, Clone, PartialEq)]
pub enum ArrivalOutcome {
    /// The wait is over: these channels continue, the arriving one among them.
    Released(Released),
    /// The channel waits.
    Blocked,
    /// The control refuses: all of these channels alarm.
    Mismatch(RefusedPairs),
    /// The channel cannot arrive here, regardless of the others.
    Illegal {
        /// Why.
        text: String,
    },
}

/// Waits that the control does not accept at the same time.
#[derive(Debug, Clone, PartialEq)]
pub struct RefusedPairs {
    /// Its name on the control.
    pub title: &'static str,
    /// The wait of the channel that came last.
    pub arriving: WaitingChannel,
    /// The waits that do not match it, each with the case.
    pub standing: Vec<(WaitingChannel, &'static str)>,
}

impl RefusedPairs {
    /// All channels of the pairs.
    pub fn channels(&self) -> ChannelSet {
        let standing: ChannelSet = self.standing.iter().map(|(other, _)| other.tag.channel).collect();
        standing.with(self.arriving.tag.channel)
    }
}

/// An arrival, and its further consequences.
#[derive(Debug, Clone, PartialEq)]
pub struct ArrivalConsequences {
    /// Its effect on the channel and those that continue with it.
    pub arrival: ArrivalOutcome,
    /// Others whose own waits are over by it.
    pub others: Vec<Released>,
    /// Waits that do not match and that the control only warns of.
    pub warning: Option<RefusedPairs>,
}

impl From<ArrivalOutcome> for ArrivalConsequences {
    fn from(arrival: ArrivalOutcome) -> Self {
        Self { arrival, others: Vec::new(), warning: None }
    }
}

/// All waits of the job.
#[derive(Debug, Clone)]
pub struct JobWaits {
    /// Where all channels are.
    pub places: ChannelPlaces,
    /// The rules of the machine.
    pub rules: WaitRules,
    /// Blocks take no time, so that times say nothing.
    pub timeless: bool,
    /// Channels that have done something whose outcome depends on which channel comes first, where nothing takes time.
    pub order_matters: ChannelSet,
    /// The first list of channels that came to each mark, kept where blocks take no time.
    lists: BTreeMap<WaitMark, ChannelSet>,
    memory: PrimitiveState,
    release_ns: i64,
}

impl JobWaits {
    /// No channel waits yet; a release takes `release_ns`.
    pub fn new(channels: Channels, rules: WaitRules, release_ns: i64) -> Self {
        Self {
            places: ChannelPlaces::new(channels),
            rules,
            timeless: false,
            order_matters: ChannelSet::default(),
            lists: BTreeMap::new(),
            memory: PrimitiveState::default(),
            release_ns,
        }
    }

    /// Whether another wait at this mark was for other channels, and the control pairs them: the result depends on the
    /// order of arrival. Only known where blocks take no time.
    pub fn lists_differ(&mut self, wait: &Wait) -> bool {
        let refused = |rule: &WaitRule| rule.mismatch.is_some_and(|mismatch| mismatch.reaction == Reaction::Alarm);
        if !self.timeless || self.rules.of(wait).is_some_and(refused) {
            return false;
        }
        *self.lists.entry(wait.key).or_insert(wait.parts) != wait.parts
    }

    /// Records that a channel has ended.
    pub fn finish(&mut self, channel: u16, finish: Finish) {
        self.places.finish(channel, finish);
        self.give_up(channel);
    }

    /// A channel waits no longer, although no partner arrived.
    fn give_up(&mut self, channel: u16) {
        if let Some(waiting) = self.places.leave(channel) {
            self.memory.abandon(channel, &waiting.wait);
        }
    }

    fn missing_at(&self, channel: u16, wait: &Wait) -> MissingChannels {
        self.memory.missing(channel, wait, &self.places, &self.rules)
    }

    /// Channels that are missing for the wait of a channel.
    pub fn missing(&self, channel: u16) -> MissingChannels {
        self.places.at(channel).map_or_else(MissingChannels::default, |own| self.missing_at(channel, &own.wait))
    }

    /// Enough of the missing ones execute blocks.
    fn can_come(&self, missing: MissingChannels) -> bool {
        missing.need == 0 || missing.is_met_by(missing.channels.iter().filter(|&c| self.places.runs(c)).collect())
    }

    /// Why the control refuses two waits that stand at the same time.
    fn refused(&self, wait: &Wait, other: &Wait) -> Option<&'static str> {
        self.rules.of(wait)?.mismatch.and_then(|mismatch| (mismatch.refuses)(wait, other))
    }

    /// Executes an arrival that raises no alarm and leaves no channel hopeless: it ends the wait, or missing channels
    /// can still come by themselves. `None`: the arrival is of another kind, and nothing has changed.
    pub fn arrive_plainly(&mut self, arriving: WaitingChannel) -> Option<ArrivalConsequences> {
        let refused = self.places.waiting().any(|other| self.refused(&arriving.wait, &other.wait).is_some());
        if refused || self.memory.illegal(&arriving).is_some() {
            return None;
        }
        let missing = self.missing_at(arriving.tag.channel, &arriving.wait);
        self.can_come(missing).then(|| self.stand(arriving, Some(missing)))
    }

    /// Whether the missing partners of a waiting channel can still come by themselves: no need to look further.
    pub fn hopeful(&self, channel: u16) -> bool {
        self.can_come(self.missing(channel))
    }

    /// Ends the wait at once if no channel is missing, without a release.
    pub fn pass(&mut self, arriving: &WaitingChannel) -> bool {
        let (channel, wait) = (arriving.tag.channel, &arriving.wait);
        let passes = self.missing_at(channel, wait).is_none() && self.memory.illegal(arriving).is_none();
        if passes {
            self.memory.depart(channel, wait, &self.rules);
            self.places.pass(*arriving, arriving.tag.t);
        }
        passes
    }

    /// A channel arrives.
    pub fn arrive(&mut self, arriving: WaitingChannel) -> ArrivalConsequences {
        let tag = arriving.tag;
        if let Some(text) = self.memory.illegal(&arriving) {
            return ArrivalOutcome::Illegal { text }.into();
        }
        let mut warning = None;
        if let Some((reaction, refused)) = self.mismatch(&arriving) {
            if reaction == Reaction::Alarm {
                for channel in refused.channels().without(tag.channel).iter() {
                    self.give_up(channel);
                }
                return ArrivalOutcome::Mismatch(refused).into();
            }
            warning = Some(refused);
        }
        ArrivalConsequences { warning, ..self.stand(arriving, None) }
    }

    /// A channel is at a wait that the control accepts. `missing`: who was missing before, if that is known.
    fn stand(&mut self, arriving: WaitingChannel, missing: Option<MissingChannels>) -> ArrivalConsequences {
        let (wait, tag) = (arriving.wait, arriving.tag);
        let concerns_others = self.memory.arrive(&arriving);
        self.places.stand(arriving);
        if concerns_others {
            let mut others = self.settle(tag);
            let own = others.iter().position(|released| released.channels.has(tag.channel));
            let arrival = own.map_or(ArrivalOutcome::Blocked, |own| ArrivalOutcome::Released(others.swap_remove(own)));
            others.sort_by_key(|released| released.channels.0.trailing_zeros());
            return ArrivalConsequences { arrival, others, warning: None };
        }
        // Others are missing at a barrier whether the own channel stands there or not.
        let before = missing.filter(|_| wait.primitive == Primitive::Barrier);
        if !before.unwrap_or_else(|| self.missing_at(tag.channel, &wait)).is_none() {
            return ArrivalOutcome::Blocked.into();
        }
        let together = self.memory.together(tag.channel, &wait, &self.places);
        ArrivalOutcome::Released(self.let_go(together, tag)).into()
    }

    /// Waits that do not match the arriving one, and the reaction.
    fn mismatch(&self, arriving: &WaitingChannel) -> Option<(Reaction, RefusedPairs)> {
        let mismatch = self.rules.of(&arriving.wait)?.mismatch?;
        let pair = |other: &WaitingChannel| Some((*other, self.refused(&arriving.wait, &other.wait)?));
        let standing: Vec<_> = self.places.waiting().filter_map(pair).collect();
        let refused = RefusedPairs { title: mismatch.title, arriving: *arriving, standing };
        (!refused.standing.is_empty()).then_some((mismatch.reaction, refused))
    }

    /// A channel does something for others; returns the channels that continue by that.
    ///
    /// # Errors
    /// Why it cannot.
    pub fn act(&mut self, tag: Tag, act: WaitOp) -> Result<Vec<Released>, String> {
        self.act_with(tag, act, None)
    }

    /// The same; values go with a signal.
    ///
    /// # Errors
    /// Why it cannot.
    pub fn act_with(&mut self, tag: Tag, act: WaitOp, letter: Option<Letter>) -> Result<Vec<Released>, String> {
        self.memory.act(tag.channel, (act, letter), &self.rules)?;
        Ok(self.settle(tag))
    }

    /// The number of a signal that a sender of this wait sent before the one that is waited for, if the control minds.
    pub fn older_signal(&self, channel: u16, wait: &Wait) -> Option<u32> {
        self.memory.older_signal(channel, wait, &self.rules)
    }

    /// Values that came with the signals of the last wait of a channel; they are given once.
    pub fn letters(&mut self, channel: u16) -> Vec<Letter> {
        self.memory.letters(channel)
    }

    /// Records that a channel holds this from the start of the job on.
    pub fn hold(&mut self, channel: u16, key: WaitMark) {
        // A free lease can be given to any channel.
        let _ = self.memory.act(channel, (WaitOp::Take(key), None), &self.rules);
    }

    /// A channel moves an axis that channels exchange.
    ///
    /// # Errors
    /// The channel that holds it, if any does: it is not this one.
    pub fn moves(&mut self, channel: u16, key: WaitMark, moved: LastAxisMove) -> Result<(), Option<u16>> {
        self.memory.moves(channel, key, moved)
    }

    /// The holder of a resource, and the last move of it; none while it is where the job found it.
    pub fn lease(&self, key: WaitMark) -> (Option<u16>, Option<LastAxisMove>) {
        self.memory.lease(key)
    }

    /// All waits that are over after the operation at this tag: first all of them are found, then they end.
    pub fn settle(&mut self, tag: Tag) -> Vec<Released> {
        let over = |waiting: &&WaitingChannel| self.missing_at(waiting.tag.channel, &waiting.wait).is_none();
        let mut points: Vec<(Wait, ChannelSet)> = Vec::new();
        for waiting in self.places.waiting().filter(over) {
            let channel = waiting.tag.channel;
            match points.iter_mut().find(|(wait, _)| is_one_point(wait, &waiting.wait)) {
                Some((_, channels)) => *channels = channels.with(channel),
                None => points.push((waiting.wait, ChannelSet::default().with(channel))),
            }
        }
        points.into_iter().map(|(_, channels)| self.let_go(channels, tag)).collect()
    }

    /// These channels continue after the operation at this tag.
    fn let_go(&mut self, channels: ChannelSet, tag: Tag) -> Released {
        let short = channels.iter().find_map(|channel| self.short(channel, channels));
        let after = tag.t + self.release_ns;
        for channel in channels.iter() {
            if let Some(waiting) = self.places.leave(channel) {
                self.memory.depart(channel, &waiting.wait, &self.rules);
                self.places.pass(waiting, after);
            }
        }
        let (t, micro) = if self.release_ns > 0 { (tag.t + self.release_ns, 0) } else { (tag.t, tag.micro + 1) };
        Released { channels, t, micro, by: tag.channel, short }
    }

    /// Why a partner of the count that a channel waits for does not continue `together` with it.
    fn short(&self, channel: u16, together: ChannelSet) -> Option<ShortfallReason> {
        let wait = self.places.at(channel).map(|own| own.wait)?;
        if wait.primitive != Primitive::Count || wait.need != 0 {
            return None;
        }
        let met_by = self.rules.met_by(&wait);
        let is_elsewhere = |partner| self.places.at(partner).is_some_and(|own| Some(own.wait.primitive) == met_by);
        wait.parts.without(channel).iter().filter(|&partner| !together.has(partner)).find_map(|partner| {
            if self.places.end(partner).is_some_and(|end| end.how == Terminal::Ended) {
                return Some(ShortfallReason::Ended);
            }
            is_elsewhere(partner).then_some(ShortfallReason::Elsewhere)
        })
    }

    /// Channels that wait and can never continue: the complement of the fix-point over possible future acts.
    pub fn dead(&self) -> ChannelSet {
        let mut live: ChannelSet = self.places.channels().filter(|&channel| self.places.runs(channel)).collect();
        if !live.is_empty() {
            // A running channel may start idle ones.
            live = ChannelSet(live.0 | self.places.idle().0);
        }
        let waiting: ChannelSet = self.places.waiting().map(|waiting| waiting.tag.channel).collect();
        loop {
            let before = live;
            for channel in waiting.iter().filter(|&channel| !before.has(channel)) {
                if self.missing(channel).is_met_by(live) {
                    live = live.with(channel);
                }
            }
            if live == before {
                return ChannelSet(waiting.0 & !live.0);
            }
        }
    }
}

/// Whether channels at both continue as one sync point.
fn is_one_point(one: &Wait, other: &Wait) -> bool {
    one.primitive == other.primitive
        && one.key == other.key
        && (one.primitive != Primitive::Barrier || one.parts == other.parts)
}
