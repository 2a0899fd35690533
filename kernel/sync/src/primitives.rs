//! The primitives that every wait of a control is made of, one file each.
//!
//! Each defines the effect of an arrival on other channels (`arrive`), the missing channels (`missing`), the channels
//! that continue together (`together`), the resources that they use up (`depart`), and the acts of a channel for others
//! without waiting (`act`). *Invariant:* `missing` changes nothing; a wait is over exactly when no channel is missing.
//! Facts: reference channel-synchronisation.md 0, 1.1.

mod barrier;
mod count;
mod flag;
mod join;
mod lease;
mod order;
mod signal;

use crate::wait::{ChannelPlaces, ChannelSet, MissingChannels, Wait, WaitMark, WaitOp, WaitRules, WaitingChannel};

use counterpoint_event::event::Primitive;
pub use lease::LastAxisMove;
pub use signal::Letter;

/// Most marks that are set, signals that are kept or leases that are held at one time.
const MOST: usize = 10_000;

/// View that a primitive has of the channels.
#[derive(Clone, Copy)]
struct Scene<'a> {
    places: &'a ChannelPlaces,
    rules: &'a WaitRules,
}

impl Scene<'_> {
    /// Whether the channel is absent, and the control counts that as an arrival.
    fn is_excused(self, channel: u16, wait: &Wait) -> bool {
        self.places.is_absent(channel) && self.rules.counts_absent(wait)
    }
}

/// The memory of the primitives between arrivals.
#[derive(Debug, Clone, Default)]
pub(crate) struct PrimitiveState {
    flags: flag::FlagTable,
    reached: order::ReachedNumbers,
    signals: signal::PendingSignals,
    leases: lease::Leases,
}

impl PrimitiveState {
    /// Why a channel cannot arrive here, regardless of the others.
    pub(crate) fn illegal(&self, waiting: &WaitingChannel) -> Option<String> {
        let channel = waiting.tag.channel;
        match waiting.wait.primitive {
            Primitive::Flag => self.flags.illegal(waiting.wait.key),
            Primitive::Order => self.reached.illegal(channel, &waiting.wait),
            Primitive::Lease => self.leases.illegal(waiting.wait.key),
            Primitive::Barrier | Primitive::Count | Primitive::Signal | Primitive::Join => None,
        }
    }

    /// A channel arrives; true if that may end the waits of others, too, which wait for something else.
    pub(crate) fn arrive(&mut self, waiting: &WaitingChannel) -> bool {
        let (channel, wait) = (waiting.tag.channel, &waiting.wait);
        match wait.primitive {
            Primitive::Flag => self.flags.set(channel, wait.key),
            Primitive::Order => self.reached.arrive(channel, wait),
            Primitive::Lease => self.leases.arrive(channel, wait.key),
            Primitive::Signal => self.signals.arrive(channel, wait),
            Primitive::Barrier | Primitive::Count | Primitive::Join => {}
        }
        matches!(wait.primitive, Primitive::Flag | Primitive::Order)
    }

    /// Channels that are missing for a channel at this wait, which need not be at it yet.
    #[inline]
    pub(crate) fn missing(
        &self,
        channel: u16,
        wait: &Wait,
        places: &ChannelPlaces,
        rules: &WaitRules,
    ) -> MissingChannels {
        let scene = Scene { places, rules };
        match wait.primitive {
            Primitive::Barrier => barrier::missing(channel, wait, scene),
            Primitive::Flag => self.flags.missing(channel, wait, scene),
            Primitive::Order => self.reached.missing(channel, wait, scene),
            Primitive::Count => count::missing(channel, wait, scene, |other, own| {
                own.primitive != Primitive::Count && !self.missing(other, own, places, rules).is_none()
            }),
            Primitive::Signal => self.signals.missing(channel, wait, rules.is_to_itself(wait)),
            Primitive::Join => join::missing(channel, wait, scene),
            Primitive::Lease => self.leases.missing(channel, wait, scene),
        }
    }

    /// The channels that continue when the wait of one of them is over.
    pub(crate) fn together(&self, channel: u16, wait: &Wait, places: &ChannelPlaces) -> ChannelSet {
        match wait.primitive {
            Primitive::Barrier => barrier::together(wait, places),
            Primitive::Count => count::together(wait, places),
            Primitive::Flag | Primitive::Order | Primitive::Signal | Primitive::Join | Primitive::Lease => {
                ChannelSet::default().with(channel)
            }
        }
    }

    /// Lets a channel continue and use up its resources.
    pub(crate) fn depart(&mut self, channel: u16, wait: &Wait, rules: &WaitRules) {
        match wait.primitive {
            Primitive::Flag => self.flags.clear(channel, wait.key),
            Primitive::Signal => self.signals.depart(channel, wait, rules.is_to_itself(wait)),
            Primitive::Lease => self.leases.depart(channel, wait.key),
            Primitive::Barrier | Primitive::Order | Primitive::Count | Primitive::Join => {}
        }
    }

    /// A channel gives its wait up.
    pub(crate) fn abandon(&mut self, channel: u16, wait: &Wait) {
        match wait.primitive {
            Primitive::Lease => self.leases.abandon(channel, wait.key),
            Primitive::Signal => self.signals.abandon(channel, wait.key),
            Primitive::Barrier | Primitive::Flag | Primitive::Order | Primitive::Count | Primitive::Join => {}
        }
    }

    /// The number of a signal that a sender of this wait sent before, if the control minds.
    pub(crate) fn older_signal(&self, channel: u16, wait: &Wait, rules: &WaitRules) -> Option<u32> {
        let minds = rules.of(wait).is_some_and(|rule| rule.signals.in_order);
        if minds && wait.primitive == Primitive::Signal { self.signals.older(channel, wait) } else { None }
    }

    /// Values that came with the signals of the last wait of a channel.
    pub(crate) fn letters(&mut self, channel: u16) -> Vec<Letter> {
        self.signals.letters(channel)
    }

    /// A channel does something for others; a signal may have values with it.
    ///
    /// # Errors
    /// Why it cannot.
    pub(crate) fn act(
        &mut self,
        channel: u16,
        (act, letter): (WaitOp, Option<Letter>),
        rules: &WaitRules,
    ) -> Result<(), String> {
        match act {
            WaitOp::Set(key) => {
                if let Some(reason) = self.flags.illegal(key) {
                    return Err(reason);
                }
                self.flags.set(channel, key);
                Ok(())
            }
            WaitOp::Clear(key) => {
                self.flags.clear(channel, key);
                Ok(())
            }
            WaitOp::Signal(send) => self.signals.send(channel, send, letter, rules.most_signals()),
            WaitOp::Remove { range, to } => {
                self.signals.remove(range, to);
                Ok(())
            }
            WaitOp::Release(key) => self.leases.release(channel, key),
            WaitOp::Take(key) => {
                self.leases.take(channel, key);
                Ok(())
            }
            WaitOp::Give { key, to } => self.leases.give(channel, key, to),
        }
    }

    /// A channel moves an axis that channels exchange.
    ///
    /// # Errors
    /// Another channel holds it, or no channel does.
    pub(crate) fn moves(&mut self, channel: u16, key: WaitMark, moved: LastAxisMove) -> Result<(), Option<u16>> {
        self.leases.moves(channel, key, moved)
    }

    /// The holder of a resource, and the last move of it.
    pub(crate) fn lease(&self, key: WaitMark) -> (Option<u16>, Option<LastAxisMove>) {
        self.leases.state(key)
    }
}
