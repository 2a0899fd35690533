//! Barrier: all participating channels wait at the same mark, the k-th time with the k-th.

use super::Scene;
use crate::wait::{ChannelPlaces, ChannelSet, MissingChannels, Wait};

/// Whether both belong to one sync point.
fn matches(one: &Wait, other: &Wait) -> bool {
    one.primitive == other.primitive && one.key == other.key && one.parts == other.parts
}

fn stands(channel: u16, wait: &Wait, places: &ChannelPlaces) -> bool {
    places.at(channel).is_some_and(|other| matches(&other.wait, wait))
}

/// Participants that do not stand at it.
#[inline]
pub(super) fn missing(channel: u16, wait: &Wait, scene: Scene<'_>) -> MissingChannels {
    let mut missing = ChannelSet::default();
    for other in wait.parts.iter() {
        if other != channel && !stands(other, wait, scene.places) && !scene.is_excused(other, wait) {
            missing = missing.with(other);
        }
    }
    MissingChannels::all(missing)
}

/// All that stand at it.
pub(super) fn together(wait: &Wait, places: &ChannelPlaces) -> ChannelSet {
    wait.parts.iter().filter(|&channel| stands(channel, wait, places)).collect()
}
