//! Count: so many of the channels stand at the mark, whichever they are.

use super::Scene;
use crate::wait::{Missing, Places, Set, Wait};

fn stands(channel: u16, wait: &Wait, places: &Places) -> bool {
    places.at(channel).is_some_and(|other| other.wait.primitive == wait.primitive && other.wait.key == wait.key)
}

/// As many of the others as the count still needs.
pub(super) fn missing(channel: u16, wait: &Wait, scene: Scene<'_>) -> Missing {
    let others = wait.parts.without(channel);
    let there = |&other: &u16| stands(other, wait, scene.places) || scene.is_excused(other, wait);
    let arrived: Set = others.iter().filter(there).collect();
    let need = if wait.need == 0 { wait.parts.count() } else { wait.need };
    Missing { channels: Set(others.0 & !arrived.0), need: need.saturating_sub(arrived.count() + 1) }
}

/// All that stand at it.
pub(super) fn together(wait: &Wait, places: &Places) -> Set {
    wait.parts.iter().filter(|&channel| stands(channel, wait, places)).collect()
}
