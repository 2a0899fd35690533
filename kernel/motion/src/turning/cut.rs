//! The tool of a cycle: where it is in the view of the cycle, and its moves in the plane.
//!
//! *Invariant:* `at` is where the last move has ended.

use super::parts::ContourPart;
use super::view::CutView;
use super::{CycleMove, MoveSink, NOISE};
use crate::contour::element::Spot;

/// Position of the tool in the view, and the sink of its moves.
pub(super) struct ToolCursor<'s, S: MoveSink> {
    pub(super) sink: &'s mut S,
    pub(super) view: CutView,
    pub(super) at: Spot,
}

impl<S: MoveSink> ToolCursor<'_, S> {
    pub(super) fn rapid(&mut self, to: Spot) -> Result<(), S::Stop> {
        self.at = to;
        self.sink.go(CycleMove::Rapid(self.view.place(to)))
    }

    pub(super) fn feed(&mut self, to: Spot) -> Result<(), S::Stop> {
        self.at = to;
        self.sink.go(CycleMove::Feed(self.view.place(to)))
    }

    /// Along a part of the contour to one of its points.
    pub(super) fn part(&mut self, part: &ContourPart, to: Spot) -> Result<(), S::Stop> {
        let Some((center, clockwise)) = part.arc else { return self.feed(to) };
        if (to[0] - self.at[0]).abs() + (to[1] - self.at[1]).abs() <= NOISE {
            return Ok(());
        }
        let clockwise = clockwise != self.view.turns_over();
        let (place, center) = (self.view.place(to), self.view.place(center));
        self.at = to;
        self.sink.go(CycleMove::Arc { to: place, center, clockwise })
    }
}
