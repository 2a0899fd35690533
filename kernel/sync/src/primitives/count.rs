//! Count: a given number of any channels wait at the mark.

use super::Scene;
use crate::wait::{ChannelPlaces, ChannelSet, MissingChannels, Wait};

fn stands(channel: u16, wait: &Wait, places: &ChannelPlaces) -> bool {
    places.at(channel).is_some_and(|other| other.wait.primitive == wait.primitive && other.wait.key == wait.key)
}

/// As many of the others as the count still needs.
///
/// One that stays at a wait of the primitive that the rule names counts, too; `stays` says whether a wait is not over.
pub(super) fn missing(
    channel: u16,
    wait: &Wait,
    scene: Scene<'_>,
    stays: impl Fn(u16, &Wait) -> bool,
) -> MissingChannels {
    let others = wait.parts.without(channel);
    let met_by = scene.rules.met_by(wait);
    let is_elsewhere = |other: u16| {
        let own = scene.places.at(other).filter(|own| Some(own.wait.primitive) == met_by);
        own.is_some_and(|own| stays(other, &own.wait))
    };
    let there =
        |&other: &u16| stands(other, wait, scene.places) || scene.is_excused(other, wait) || is_elsewhere(other);
    let arrived: ChannelSet = others.iter().filter(there).collect();
    let need = if wait.need == 0 { wait.parts.count() } else { wait.need };
    MissingChannels { channels: ChannelSet(others.0 & !arrived.0), need: need.saturating_sub(arrived.count() + 1) }
}

/// All that stand at it.
pub(super) fn together(wait: &Wait, places: &ChannelPlaces) -> ChannelSet {
    wait.parts.iter().filter(|&channel| stands(channel, wait, places)).collect()
}
