//! Heights of the levels of a rough cycle.
//!
//! *Invariant:* levels fall; a level is found by its number without those before it.

use super::NOISE;
use super::lap::LapSettings;
use super::view::CutView;

/// Levels with one depth.
#[derive(Debug, Clone, Copy, PartialEq)]
struct LevelStage {
    /// Number of its first level.
    first: u64,
    /// Height above that level.
    top: f64,
    depth: f64,
    /// Number of its feed.
    feed: usize,
}

/// The levels of a cycle, as seen.
#[derive(Debug)]
pub(super) struct CutLevels {
    stages: Vec<LevelStage>,
    /// The lowest place of the contour.
    low: f64,
    /// The last level is that place; otherwise all are above it.
    reaches_low: bool,
}

impl CutLevels {
    /// Levels with one depth, down to the lowest place.
    pub(super) fn even(top: f64, depth: f64, low: f64) -> Self {
        Self { stages: vec![LevelStage { first: 1, top, depth, feed: 0 }], low, reaches_low: true }
    }

    /// Levels above the lowest place, whose depth changes.
    pub(super) fn of_lap(top: f64, depth: f64, low: f64, lap: &LapSettings, view: &CutView) -> Self {
        let mut changes: Vec<_> = lap.changes.iter().enumerate().collect();
        let height = |from: f64| view.height(from);
        changes.retain(|(_, change)| change.is_some());
        changes.sort_by(|(_, a), (_, b)| {
            let of = |change: &Option<super::lap::DepthChange>| {
                change.map_or(f64::NEG_INFINITY, |change| height(change.from))
            };
            of(b).total_cmp(&of(a))
        });
        let mut here = LevelStage { first: 1, top, depth, feed: 0 };
        let mut stages = vec![here];
        for (index, change) in changes {
            let Some(change) = change else { continue };
            let passes = ((here.top - height(change.from)) / here.depth - NOISE).ceil().max(0.0);
            here = LevelStage {
                first: here.first.saturating_add(passes as u64),
                top: here.top - passes * here.depth,
                depth: change.depth.unwrap_or(here.depth),
                feed: index + 1,
            };
            stages.push(here);
        }
        Self { stages, low, reaches_low: false }
    }

    fn stage(&self, number: u64) -> Option<&LevelStage> {
        self.stages.iter().rev().find(|stage| stage.first <= number)
    }

    /// Height of a level; none below the last one.
    pub(super) fn height(&self, number: u64) -> Option<f64> {
        let stage = self.stage(number)?;
        let above = stage.top - (number - stage.first) as f64 * stage.depth;
        if above <= self.low + NOISE {
            return None;
        }
        let height = above - stage.depth;
        if self.reaches_low {
            Some(height.max(self.low))
        } else {
            Some(height).filter(|height| *height > self.low + NOISE)
        }
    }

    /// Number of the feed of a level.
    pub(super) fn feed(&self, number: u64) -> usize {
        self.stage(number).map_or(0, |stage| stage.feed)
    }

    /// The lowest place of the contour.
    pub(super) fn low(&self) -> f64 {
        self.low
    }
}
