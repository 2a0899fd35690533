//! The tool of a cycle: where it is in the view of the cycle, and its moves in the plane.
//!
//! *Invariant:* `at` is where the last move has ended.

use super::parts::Part;
use super::view::View;
use super::{Move, NOISE, Sink};
use crate::contour::element::Spot;

/// Position of the tool in the view, and the sink of its moves.
pub(super) struct Cut<'s, S: Sink> {
    pub(super) sink: &'s mut S,
    pub(super) view: View,
    pub(super) at: Spot,
}

impl<S: Sink> Cut<'_, S> {
    pub(super) fn rapid(&mut self, to: Spot) -> Result<(), S::Stop> {
        self.at = to;
        self.sink.go(Move::Rapid(self.view.place(to)))
    }

    pub(super) fn feed(&mut self, to: Spot) -> Result<(), S::Stop> {
        self.at = to;
        self.sink.go(Move::Feed(self.view.place(to)))
    }

    /// Along a part of the contour to one of its points.
    pub(super) fn part(&mut self, part: &Part, to: Spot) -> Result<(), S::Stop> {
        let Some((center, clockwise)) = part.arc else { return self.feed(to) };
        if (to[0] - self.at[0]).abs() + (to[1] - self.at[1]).abs() <= NOISE {
            return Ok(());
        }
        let clockwise = clockwise != self.view.turns_over();
        let (place, center) = (self.view.place(to), self.view.place(center));
        self.at = to;
        self.sink.go(Move::Arc { to: place, center, clockwise })
    }
}
