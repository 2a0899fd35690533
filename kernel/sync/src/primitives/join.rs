//! Join: waits until the programs of other channels have ended.

use super::Scene;
use crate::wait::{MissingChannels, Terminal, Wait};

/// Participants whose program has not ended.
pub(super) fn missing(channel: u16, wait: &Wait, scene: Scene<'_>) -> MissingChannels {
    let ended = |other: u16| {
        scene.places.end(other).is_some_and(|end| end.how == Terminal::Ended) || scene.is_excused(other, wait)
    };
    MissingChannels::all(wait.parts.without(channel).iter().filter(|&other| !ended(other)).collect())
}
