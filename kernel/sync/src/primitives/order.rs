//! Order: a channel passes a number when all the others have reached it or a larger one.
//!
//! *Invariant:* numbers of a channel never descend, so channels cannot wait for each other in a circle. Facts:
//! reference channel-synchronisation.md 1.5 (P of a turret).

use std::collections::BTreeMap;

use super::Scene;
use crate::wait::{MarkSpace, MissingChannels, Wait};

/// By family of marks and channel: the number that it has reached.
#[derive(Debug, Clone, Default)]
pub(super) struct ReachedNumbers(BTreeMap<(MarkSpace, u16), u32>);

impl ReachedNumbers {
    fn of(&self, channel: u16, wait: &Wait) -> Option<u32> {
        self.0.get(&(wait.key.space, channel)).copied()
    }

    /// The number is below one that the channel has reached.
    pub(super) fn illegal(&self, channel: u16, wait: &Wait) -> Option<String> {
        let (reached, number) = (self.of(channel, wait)?, wait.key.number);
        (number < reached).then(|| format!("order number {number} comes after {reached}, but the numbers must ascend"))
    }

    pub(super) fn arrive(&mut self, channel: u16, wait: &Wait) {
        self.0.insert((wait.key.space, channel), wait.key.number);
    }

    /// Participants that have not come so far.
    pub(super) fn missing(&self, channel: u16, wait: &Wait, scene: Scene<'_>) -> MissingChannels {
        let there = |other: u16| self.of(other, wait) >= Some(wait.key.number) || scene.is_excused(other, wait);
        MissingChannels::all(wait.parts.without(channel).iter().filter(|&other| !there(other)).collect())
    }
}
