//! Signal: each wait uses up one signal of each sender that it names, or one that any channel sent to all channels.
//!
//! A signal that comes before its wait is kept, separately for each receiver, with the values that were sent along. One
//! signal may also be for all channels together: any channel can use it, a given number of times, or until it is
//! removed. *Invariants:* if only some waiting channels can use a signal, they get it in the order of arrival; kept
//! signals stay within the limit of the control. Facts: reference channel-synchronisation.md 1.0 (starts by one head),
//! 1.7.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use super::MOST;
use crate::wait::{ChannelSet, Lasts, MarkRange, MissingChannels, Send, Wait, WaitMark};

/// Sender of a signal to all channels.
const ANYBODY: u16 = 0;

/// Values that come with a signal, by their index.
pub type Letter = Arc<[(u8, f64)]>;

/// A signal of one sender for one receiver.
#[derive(Debug, Clone)]
struct PendingSignal {
    /// Which one of all that were sent.
    sent: u64,
    /// Waits that can still use it.
    left: u32,
    letter: Option<Letter>,
}

/// A signal that all receivers share.
#[derive(Debug, Clone)]
struct BroadcastSignal {
    /// Waits that can still use it; none if it stays.
    left: Option<u32>,
    letter: Option<Letter>,
}

/// By mark, receiver and sender, or by mark alone: unused signals.
#[derive(Debug, Clone, Default)]
pub(super) struct PendingSignals {
    kept: BTreeMap<(WaitMark, u16, u16), VecDeque<PendingSignal>>,
    open: BTreeMap<WaitMark, VecDeque<BroadcastSignal>>,
    /// Channels at waits for any sender, by mark and in the order of their arrival.
    queues: BTreeMap<WaitMark, Vec<u16>>,
    /// Channels at waits for signals.
    waiting: ChannelSet,
    /// Signals that were sent so far.
    sent: u64,
    /// Signals that are kept, if their number is limited.
    count: usize,
    /// By receiver: values of the signals that its last wait has used.
    letters: BTreeMap<u16, Vec<Letter>>,
}

/// Whether any sender will do.
fn takes_any(wait: &Wait) -> bool {
    wait.need != 0
}

/// The channels whose signal a wait needs; a control may let a channel send one to itself.
fn senders(channel: u16, wait: &Wait, to_itself: bool) -> ChannelSet {
    let others = wait.parts.without(channel);
    match wait.named {
        Some(named) if to_itself && named.has(channel) => others.with(channel),
        _ => others,
    }
}

impl PendingSignals {
    /// Sends one to each of these channels, or one to all channels; `limit` is the number of signals and waits that
    /// the control can keep.
    pub(super) fn send(
        &mut self,
        channel: u16,
        send: Send,
        letter: Option<Letter>,
        limit: Option<usize>,
    ) -> Result<(), String> {
        let Send { key, to, broadcast, lasts } = send;
        let shared = broadcast && lasts != Lasts::Each;
        let more = if shared { 1 } else { usize::from(to.count()) };
        if let Some(limit) = limit {
            let kept = self.count + usize::from(self.waiting.count());
            if kept + more > limit {
                return Err(format!(
                    "{kept} signals and waits are kept, and {more} more would be over the limit of {limit}"
                ));
            }
            self.count += more;
        } else {
            let sender = if broadcast { ANYBODY } else { channel };
            let is_new = to.iter().any(|receiver| !self.kept.contains_key(&(key, receiver, sender)));
            let shared_ones = self.open.get(&key).map_or(0, VecDeque::len);
            if shared && shared_ones >= MOST || is_new && self.kept.len() + self.open.len() >= MOST {
                return Err(format!("more than {MOST} different signals wait to be used"));
            }
        }
        self.sent += 1;
        let left = match lasts {
            Lasts::Each | Lasts::Always => 1,
            Lasts::Times(times) => times,
        };
        if shared {
            let left = (lasts != Lasts::Always).then_some(left);
            self.open.entry(key).or_default().push_back(BroadcastSignal { left, letter });
            return Ok(());
        }
        let sender = if broadcast { ANYBODY } else { channel };
        for receiver in to.iter() {
            let kept = self.kept.entry((key, receiver, sender)).or_default();
            match kept.back_mut().filter(|_| limit.is_none()) {
                // Without a limit equal signals are only counted.
                Some(last) => last.left = last.left.saturating_add(left),
                None => kept.push_back(PendingSignal { sent: self.sent, left, letter: letter.clone() }),
            }
        }
        Ok(())
    }

    /// Records that a channel is at a wait.
    pub(super) fn arrive(&mut self, channel: u16, wait: &Wait) {
        self.waiting = self.waiting.with(channel);
        if takes_any(wait) {
            self.queues.entry(wait.key).or_default().push(channel);
        }
    }

    /// Senders whose signal has not come.
    pub(super) fn missing(&self, channel: u16, wait: &Wait, to_itself: bool) -> MissingChannels {
        let has = |sender: u16| self.kept.contains_key(&(wait.key, channel, sender));
        if takes_any(wait) {
            let is_there = has(ANYBODY) || self.is_open(channel, wait.key);
            return if is_there {
                MissingChannels::default()
            } else {
                MissingChannels::any(wait.parts.without(channel))
            };
        }
        MissingChannels::all(senders(channel, wait, to_itself).iter().filter(|&sender| !has(sender)).collect())
    }

    /// Whether a signal that all share is left for this channel, after those that have waited longer.
    fn is_open(&self, channel: u16, key: WaitMark) -> bool {
        let Some(open) = self.open.get(&key) else { return false };
        let queue = self.queues.get(&key).map_or(&[][..], Vec::as_slice);
        let before = queue.iter().take_while(|other| **other != channel).count() as u64;
        open.iter().any(|signal| signal.left.is_none())
            || open.iter().map(|signal| u64::from(signal.left.unwrap_or(0))).sum::<u64>() > before
    }

    /// The number of a signal that one of the senders sent before the one that is waited for, if there is one.
    pub(super) fn older(&self, channel: u16, wait: &Wait) -> Option<u32> {
        if takes_any(wait) {
            return None;
        }
        let first = |key: WaitMark, sender| Some(self.kept.get(&(key, channel, sender))?.front()?.sent);
        senders(channel, wait, true).iter().find_map(|sender| {
            let awaited = first(wait.key, sender).unwrap_or(u64::MAX);
            let own = |&&(key, to, from): &&(WaitMark, u16, u16)| {
                to == channel && from == sender && key.space == wait.key.space && key != wait.key
            };
            let older = self.kept.keys().filter(own).find(|(key, ..)| first(*key, sender) < Some(awaited));
            older.map(|(key, ..)| key.number)
        })
    }

    pub(super) fn depart(&mut self, channel: u16, wait: &Wait, to_itself: bool) {
        self.abandon(channel, wait.key);
        let mut letters = Vec::new();
        if takes_any(wait) {
            if self.kept.contains_key(&(wait.key, channel, ANYBODY)) {
                letters.extend(self.use_kept((wait.key, channel, ANYBODY)));
            } else {
                letters.extend(self.use_open(wait.key));
            }
        } else {
            for sender in senders(channel, wait, to_itself).iter() {
                letters.extend(self.use_kept((wait.key, channel, sender)));
            }
        }
        if !letters.is_empty() {
            self.letters.insert(channel, letters);
        }
    }

    /// A channel waits no longer.
    pub(super) fn abandon(&mut self, channel: u16, key: WaitMark) {
        self.waiting = self.waiting.without(channel);
        if let Some(queue) = self.queues.get_mut(&key) {
            queue.retain(|other| *other != channel);
            if queue.is_empty() {
                self.queues.remove(&key);
            }
        }
    }

    /// Values that came with the signals that the last wait of a channel used.
    pub(super) fn letters(&mut self, channel: u16) -> Vec<Letter> {
        self.letters.remove(&channel).unwrap_or_default()
    }

    /// Uses the oldest signal of a sender once.
    fn use_kept(&mut self, place: (WaitMark, u16, u16)) -> Option<Letter> {
        let kept = self.kept.get_mut(&place)?;
        let first = kept.front_mut()?;
        first.left = first.left.saturating_sub(1);
        let letter = first.letter.clone();
        if first.left == 0 {
            kept.pop_front();
            self.count = self.count.saturating_sub(1);
        }
        if kept.is_empty() {
            self.kept.remove(&place);
        }
        letter
    }

    /// Uses the oldest signal that all share once.
    fn use_open(&mut self, key: WaitMark) -> Option<Letter> {
        let open = self.open.get_mut(&key)?;
        let first = open.front_mut()?;
        let letter = first.letter.clone();
        if let Some(left) = &mut first.left {
            *left = left.saturating_sub(1);
            if *left == 0 {
                open.pop_front();
                self.count = self.count.saturating_sub(1);
            }
        }
        if open.is_empty() {
            self.open.remove(&key);
        }
        letter
    }

    /// Removes unused signals: the oldest one, or all of a range of numbers; those of any sender to these channels,
    /// or those to all channels.
    pub(super) fn remove(&mut self, range: MarkRange, to: Option<ChannelSet>) {
        let MarkRange { space, first, last } = range;
        let keys = WaitMark { space, number: first }..=WaitMark { space, number: last };
        let (mut kept, mut open) = (0, 0);
        if let Some(to) = to {
            for receiver in to.iter() {
                kept += self.remove_kept(range, |place| place.1 == receiver && place.2 != ANYBODY);
            }
        } else {
            kept += self.remove_kept(range, |place| place.2 == ANYBODY);
            for (_, signals) in self.open.range_mut(keys) {
                let some = if first == last { 1 } else { signals.len() };
                open += signals.drain(..some.min(signals.len())).count();
            }
            self.open.retain(|_, signals| !signals.is_empty());
        }
        self.count = self.count.saturating_sub(kept + open);
    }

    /// Removes the oldest signal of those at these places, or all of them if they have several numbers; how many.
    fn remove_kept(&mut self, range: MarkRange, wanted: impl Fn(&(WaitMark, u16, u16)) -> bool) -> usize {
        let of_range = |key: &WaitMark| key.space == range.space && (range.first..=range.last).contains(&key.number);
        let places: Vec<_> = self.kept.keys().filter(|place| of_range(&place.0) && wanted(place)).copied().collect();
        let first = |place| self.kept.get(place).and_then(VecDeque::front).map(|kept| kept.sent);
        // A signal to all channels counts as one, although each receiver has its own.
        let oldest = places.iter().filter_map(first).min().filter(|_| range.first == range.last);
        let mut removed = 0;
        for place in places {
            let Some(kept) = self.kept.get_mut(&place) else { continue };
            let before = kept.len();
            kept.retain(|kept| oldest.is_some_and(|oldest| kept.sent != oldest));
            removed += before - kept.len();
            if kept.is_empty() {
                self.kept.remove(&place);
            }
        }
        removed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wait::{MarkSpace, RuleId};
    use counterpoint_event::event::Primitive;

    fn key(number: u32) -> WaitMark {
        WaitMark { space: MarkSpace::Statements, number }
    }

    fn wait(number: u32, from: Option<&[u16]>) -> Wait {
        let named = from.map(|from| from.iter().copied().collect());
        let need = u16::from(from.is_none());
        let parts = named.unwrap_or(ChannelSet::up_to(3));
        Wait { primitive: Primitive::Signal, key: key(number), named, parts, need, rule: RuleId::Start }
    }

    fn send(number: u32, to: Option<&[u16]>, lasts: Lasts) -> Send {
        let broadcast = to.is_none();
        let to = to.map_or(ChannelSet::up_to(3), |to| to.iter().copied().collect());
        Send { key: key(number), to, broadcast, lasts }
    }

    /// Whether a wait is over at once; uses its signals.
    fn takes(signals: &mut PendingSignals, channel: u16, wait: &Wait) -> bool {
        let is = signals.missing(channel, wait, true).is_none();
        if is {
            signals.depart(channel, wait, true);
        }
        is
    }

    #[test]
    fn each_receiver_uses_its_own() {
        let mut signals = PendingSignals::default();
        assert_eq!(signals.send(1, send(7, Some(&[2, 3]), Lasts::Each), None, Some(10)), Ok(()));
        assert_eq!(signals.send(1, send(7, None, Lasts::Each), None, Some(10)), Ok(()));
        assert_eq!(signals.count, 5, "two to named channels, three to everybody");
        for channel in [2, 3] {
            assert!(takes(&mut signals, channel, &wait(7, Some(&[1]))));
            assert!(!takes(&mut signals, channel, &wait(7, Some(&[1]))));
            assert!(takes(&mut signals, channel, &wait(7, None)));
            assert!(!takes(&mut signals, channel, &wait(7, None)));
        }
        assert_eq!((signals.count, signals.kept.len()), (1, 1), "the sender has not waited for its own");
    }

    #[test]
    fn signals_last_so_many_times_or_always() {
        let mut signals = PendingSignals::default();
        assert_eq!(signals.send(1, send(7, Some(&[2]), Lasts::Times(2)), None, Some(10)), Ok(()));
        let own = wait(7, Some(&[1]));
        assert_eq!([0; 3].map(|_| takes(&mut signals, 2, &own)), [true, true, false]);
        assert_eq!(signals.send(1, send(8, None, Lasts::Times(2)), None, Some(10)), Ok(()));
        let any = wait(8, None);
        assert_eq!([2, 3, 2].map(|channel| takes(&mut signals, channel, &any)), [true, true, false]);
        assert_eq!(signals.send(1, send(8, None, Lasts::Always), None, Some(10)), Ok(()));
        assert_eq!([2, 2, 1, 3].map(|channel| takes(&mut signals, channel, &any)), [true; 4]);
        assert_eq!(signals.count, 1);
    }

    #[test]
    fn who_waits_longest_comes_first() {
        let (mut signals, any) = (PendingSignals::default(), wait(7, None));
        signals.arrive(3, &any);
        signals.arrive(2, &any);
        assert_eq!(signals.send(1, send(7, None, Lasts::Times(1)), None, None), Ok(()));
        assert_eq!([1, 2, 3].map(|channel| signals.missing(channel, &any, true).is_none()), [false, false, true]);
        signals.depart(3, &any, true);
        assert!(!signals.missing(2, &any, true).is_none() && signals.open.is_empty());
        signals.abandon(2, any.key);
        assert!(signals.queues.is_empty() && signals.waiting.is_empty());
    }

    #[test]
    fn what_is_kept_is_limited() {
        let mut signals = PendingSignals::default();
        signals.arrive(3, &wait(9, Some(&[1])));
        for number in 0..3 {
            assert_eq!(signals.send(1, send(number, Some(&[2]), Lasts::Each), None, Some(4)), Ok(()));
        }
        let full = signals.send(1, send(3, Some(&[2]), Lasts::Each), None, Some(4));
        assert!(full.unwrap_err().contains("over the limit of 4"), "three signals and a wait");
        assert!(takes(&mut signals, 2, &wait(1, Some(&[1]))));
        assert_eq!(signals.send(1, send(3, Some(&[2]), Lasts::Each), None, Some(4)), Ok(()));
    }

    #[test]
    fn an_older_signal_of_the_sender_is_found() {
        let mut signals = PendingSignals::default();
        for number in [4711, 9999] {
            assert_eq!(signals.send(1, send(number, Some(&[2]), Lasts::Each), None, Some(9)), Ok(()));
        }
        assert_eq!(signals.older(2, &wait(9999, Some(&[1]))), Some(4711));
        assert_eq!(signals.older(2, &wait(4711, Some(&[1]))), None);
        assert_eq!(signals.older(2, &wait(5, Some(&[1]))), Some(4711));
        assert_eq!((signals.older(2, &wait(9999, Some(&[3]))), signals.older(2, &wait(9999, None))), (None, None));
    }

    #[test]
    fn one_signal_or_a_range_is_removed() {
        let mut signals = PendingSignals::default();
        for _ in 0..2 {
            assert_eq!(signals.send(1, send(7, Some(&[2]), Lasts::Each), None, Some(99)), Ok(()));
            assert_eq!(signals.send(1, send(8, None, Lasts::Each), None, Some(99)), Ok(()));
            assert_eq!(signals.send(1, send(9, None, Lasts::Always), None, Some(99)), Ok(()));
        }
        let range = |first, last| MarkRange { space: MarkSpace::Statements, first, last };
        signals.remove(range(7, 7), Some(ChannelSet::up_to(2)));
        assert_eq!([0; 2].map(|_| takes(&mut signals, 2, &wait(7, Some(&[1])))), [true, false]);
        signals.remove(range(8, 8), None);
        assert_eq!([0; 2].map(|_| takes(&mut signals, 3, &wait(8, None))), [true, false]);
        signals.remove(range(9, 9), None);
        assert!(takes(&mut signals, 3, &wait(9, None)), "there are two");
        signals.remove(range(1, 9), None);
        assert!(!takes(&mut signals, 3, &wait(9, None)) && !takes(&mut signals, 2, &wait(8, None)));
        assert_eq!(signals.count, 0);
    }

    #[test]
    fn values_come_with_their_signal() {
        let mut signals = PendingSignals::default();
        let letter: Letter = [(0, 1000.0), (3, 2.5)].into();
        assert_eq!(signals.send(1, send(7, Some(&[2]), Lasts::Each), Some(letter.clone()), Some(9)), Ok(()));
        assert!(takes(&mut signals, 2, &wait(7, Some(&[1]))));
        assert_eq!((signals.letters(2), signals.letters(2)), (vec![letter], Vec::new()));
    }

    #[test]
    fn a_channel_may_signal_itself_where_the_control_says_so() {
        let mut signals = PendingSignals::default();
        let own = wait(7, Some(&[2]));
        assert!(signals.missing(2, &own, false).is_none() && !signals.missing(2, &own, true).is_none());
        assert_eq!(signals.send(2, send(7, Some(&[2]), Lasts::Each), None, Some(9)), Ok(()));
        assert!(takes(&mut signals, 2, &own));
    }
}
