//! Moves of turning cycles: pure geometry, from a contour and a few lengths to rapid moves, feed moves and arcs.
//!
//! Points are `[along Z, along X]` in length units, X as a radius. *Invariant:* a cycle gives its moves one by one and
//! asks before every pass, so that it can be stopped at any time and needs no memory for its passes; every move is
//! finite.

mod allowance;
mod blank;
mod cut;
pub mod lap;
mod levels;
mod parts;
pub mod pattern;
pub mod peck;
pub mod rough;
pub mod strip;
mod view;

#[cfg(test)]
mod tests;

use crate::contour::element::{Element, Spot};

/// Lengths below this are none.
const NOISE: f64 = 1e-7;

/// How far a contour may turn back along the cut, length units.
const BACK: f64 = 1e-3;

/// A move of a cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CycleMove {
    /// Rapid to a point.
    Rapid(Spot),
    /// Feed to a point.
    Feed(Spot),
    /// Feed along an arc.
    Arc {
        /// End.
        to: Spot,
        /// Centre.
        center: Spot,
        /// Clockwise in the plane of Z and X.
        clockwise: bool,
    },
}

/// The receiver of the moves of a cycle.
pub trait MoveSink {
    /// Why it takes no more.
    type Stop;

    /// A pass begins.
    ///
    /// # Errors
    /// The cycle is to end.
    fn pass(&mut self) -> Result<(), Self::Stop>;

    /// The feed moves that follow have a feed of the cycle: 0 its own, 1 and 2 those of changes.
    fn use_feed(&mut self, _number: usize) {}

    /// The feed moves that follow have the feed that the contour gives for one of its pieces, if it gives one.
    fn piece(&mut self, _index: usize) {}

    /// The tool stands for a time, seconds.
    ///
    /// # Errors
    /// The cycle is to end.
    fn pause(&mut self, _seconds: f64) -> Result<(), Self::Stop> {
        Ok(())
    }

    /// The nose of the tool goes beside the moves that follow, on a side: +1 left of the path, −1 right; or on them
    /// again.
    ///
    /// # Errors
    /// The cycle is to end.
    fn beside(&mut self, _side: Option<f64>) -> Result<(), Self::Stop> {
        Ok(())
    }

    /// Executes a move.
    ///
    /// # Errors
    /// The cycle is to end.
    fn go(&mut self, to: CycleMove) -> Result<(), Self::Stop>;
}

/// The contour of a cycle as it was programmed.
#[derive(Debug, Clone, PartialEq)]
pub struct ProgrammedContour {
    /// Where the tool is when the cycle is called.
    pub start: Spot,
    /// Pieces from the end of the first move on.
    pub elements: Vec<Element>,
    /// Pieces of the shape of the blank; none if it is not known.
    pub blank: Vec<Element>,
    /// The first move, from the start of the cycle to the contour, is a rapid move.
    pub rapid: bool,
}

impl ProgrammedContour {
    /// Where the contour begins; the start of the cycle if it has no piece.
    #[must_use]
    pub fn first(&self) -> Spot {
        self.elements.first().map_or(self.start, |element| element.from)
    }

    /// Where the contour ends.
    #[must_use]
    pub fn last(&self) -> Spot {
        self.elements.last().map_or(self.start, |element| element.to)
    }

    /// The move from where the tool is to the contour.
    fn infeed(&self, to: Spot) -> CycleMove {
        if self.rapid { CycleMove::Rapid(to) } else { CycleMove::Feed(to) }
    }
}

/// The move along a piece.
fn along(element: &Element) -> CycleMove {
    match &element.arc {
        Some(arc) => CycleMove::Arc { to: element.to, center: arc.center, clockwise: arc.sweep < 0.0 },
        None => CycleMove::Feed(element.to),
    }
}

/// A piece moved by a vector.
fn moved(element: &Element, by: Spot) -> Element {
    let at = |[z, x]: Spot| [z + by[0], x + by[1]];
    let arc = element.arc.map(|arc| crate::arc::PlaneArc { center: at(arc.center), ..arc });
    Element { from: at(element.from), to: at(element.to), arc }
}

/// Why a contour cannot be cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContourError {
    /// It turns back along the cut.
    TurnsBack,
    /// It reaches beyond the start of the cycle.
    BeyondStart,
    /// It has no piece, or no extent across the cut.
    Nothing,
}
