//! Lease: an axis or a spindle belongs to one channel at a time; the first request is served first.
//!
//! A channel may also take a resource that another channel holds, or pass on its own. An axis comes with the position
//! to which its last holder has moved it. *Invariant:* a queue is in the order of tags; a free lease has no queue once
//! waits are settled. Facts: reference channel-synchronisation.md 1.4, 1.9, scenario M11.

use std::collections::BTreeMap;

use super::{MOST, Scene};
use crate::wait::{ChannelSet, MissingChannels, Wait, WaitMark};

/// An item that can be held.
#[derive(Debug, Clone, Default)]
struct Lease {
    holder: Option<u16>,
    /// Channels that wait for it, in the order of arrival.
    queue: Vec<u16>,
    /// Where an axis has been moved; none while it is where the job found it.
    moved: Option<LastAxisMove>,
}

/// The last move of an axis that channels exchange.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LastAxisMove {
    /// Where it ends, machine frame.
    pub to: f64,
    /// When it ends, ns.
    pub end_ns: i64,
    /// Who has moved it.
    pub by: u16,
}

/// Leases that a channel holds or waits for.
#[derive(Debug, Clone, Default)]
pub(super) struct Leases(BTreeMap<WaitMark, Lease>);

impl Leases {
    /// Why a channel cannot ask for this.
    pub(super) fn illegal(&self, key: WaitMark) -> Option<String> {
        (self.0.len() >= MOST && !self.0.contains_key(&key)).then(|| format!("more than {MOST} leases are held"))
    }

    pub(super) fn arrive(&mut self, channel: u16, key: WaitMark) {
        self.0.entry(key).or_default().queue.push(channel);
    }

    /// The holder, and all who asked before.
    pub(super) fn missing(&self, channel: u16, wait: &Wait, scene: Scene<'_>) -> MissingChannels {
        let Some(lease) = self.0.get(&wait.key) else { return MissingChannels::default() };
        if lease.holder == Some(channel) {
            return MissingChannels::default();
        }
        let before: ChannelSet = lease.queue.iter().copied().take_while(|&other| other != channel).collect();
        let holder = lease.holder.filter(|&holder| !scene.is_excused(holder, wait));
        MissingChannels::all(holder.map_or(before, |holder| before.with(holder)))
    }

    pub(super) fn depart(&mut self, channel: u16, key: WaitMark) {
        let lease = self.0.entry(key).or_default();
        lease.holder = Some(channel);
        lease.queue.retain(|&other| other != channel);
    }

    pub(super) fn abandon(&mut self, channel: u16, key: WaitMark) {
        if let Some(lease) = self.0.get_mut(&key) {
            lease.queue.retain(|&other| other != channel);
            self.forget_if_free(key);
        }
    }

    /// Releases the resource that the channel holds.
    pub(super) fn release(&mut self, channel: u16, key: WaitMark) -> Result<(), String> {
        match self.0.get_mut(&key) {
            Some(lease) if lease.holder == Some(channel) => lease.holder = None,
            Some(Lease { holder: Some(holder), .. }) => return Err(format!("channel {holder} holds it")),
            _ => return Err("nobody holds it".to_owned()),
        }
        self.forget_if_free(key);
        Ok(())
    }

    /// Takes it from its holder, before all channels that request it.
    pub(super) fn take(&mut self, channel: u16, key: WaitMark) {
        self.0.entry(key).or_default().holder = Some(channel);
    }

    /// Passes on a lease that the channel holds, or a free lease.
    pub(super) fn give(&mut self, channel: u16, key: WaitMark, to: u16) -> Result<(), String> {
        let lease = self.0.entry(key).or_default();
        match lease.holder {
            Some(holder) if holder != channel => Err(format!("channel {holder} holds it")),
            _ => {
                lease.holder = Some(to);
                Ok(())
            }
        }
    }

    /// The holder moves it; otherwise who holds it.
    pub(super) fn moves(&mut self, channel: u16, key: WaitMark, moved: LastAxisMove) -> Result<(), Option<u16>> {
        match self.0.get_mut(&key) {
            Some(lease) if lease.holder == Some(channel) => {
                lease.moved = Some(moved);
                Ok(())
            }
            lease => Err(lease.and_then(|lease| lease.holder)),
        }
    }

    /// Who holds it, and where it has been moved.
    pub(super) fn state(&self, key: WaitMark) -> (Option<u16>, Option<LastAxisMove>) {
        self.0.get(&key).map_or((None, None), |lease| (lease.holder, lease.moved))
    }

    fn forget_if_free(&mut self, key: WaitMark) {
        let free = |lease: &Lease| lease.holder.is_none() && lease.queue.is_empty() && lease.moved.is_none();
        if self.0.get(&key).is_some_and(free) {
            self.0.remove(&key);
        }
    }
}
