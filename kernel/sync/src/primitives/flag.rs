//! Flag: a channel sets its own flag of a mark and waits until those of the others are set; it deletes its own when it
//! continues. A flag that is set without waiting stays until it is cleared.
//!
//! *Invariant:* all waits that are over at one instant are found before any of their flags is deleted. Facts: reference
//! channel-synchronisation.md 1.4 (two-phase release).

use std::collections::BTreeMap;

use super::{MOST, Scene};
use crate::wait::{ChannelSet, MissingChannels, Wait, WaitMark};

/// By mark: the channels whose flag is set.
#[derive(Debug, Clone, Default)]
pub(super) struct FlagTable(BTreeMap<WaitMark, ChannelSet>);

impl FlagTable {
    /// Why no flag of this mark can be set.
    pub(super) fn illegal(&self, key: WaitMark) -> Option<String> {
        (self.0.len() >= MOST && !self.0.contains_key(&key)).then(|| format!("more than {MOST} marks are set"))
    }

    pub(super) fn set(&mut self, channel: u16, key: WaitMark) {
        let flags = self.0.entry(key).or_default();
        *flags = flags.with(channel);
    }

    pub(super) fn clear(&mut self, channel: u16, key: WaitMark) {
        if let Some(flags) = self.0.get_mut(&key) {
            *flags = flags.without(channel);
            if flags.is_empty() {
                self.0.remove(&key);
            }
        }
    }

    /// Participants whose flag is not set.
    pub(super) fn missing(&self, channel: u16, wait: &Wait, scene: Scene<'_>) -> MissingChannels {
        let set = self.0.get(&wait.key).copied().unwrap_or_default();
        let there = |other: u16| set.has(other) || scene.is_excused(other, wait);
        MissingChannels::all(wait.parts.without(channel).iter().filter(|&other| !there(other)).collect())
    }
}
