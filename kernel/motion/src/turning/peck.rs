//! Pecks along one axis, column by column along the other axis: deep drilling in a face and grooving.
//!
//! *Invariant:* the last peck ends at the depth and the last column at the end; both counts are finite.

use super::{CycleMove, MoveSink, NOISE};
use crate::contour::element::Spot;

/// Maximum number of columns, and of pecks of a column; the rest is done in one.
const MOST: f64 = 1e9;

/// Settings of the cycle; points and lengths are `[along the peck, from column to column]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PeckSettings {
    /// The pecks are along X.
    pub along_x: bool,
    /// Where the tool is.
    pub start: Spot,
    /// Depth and last column.
    pub end: Spot,
    /// One peck; 0 for one stroke.
    pub peck: f64,
    /// From column to column; 0 for one column, or the path to the last one in one go.
    pub shift: f64,
    /// Way back after a peck.
    pub back: f64,
    /// Relief at the depth, along the columns: against their direction, or signed if there is one column.
    pub relief: f64,
}

impl PeckSettings {
    fn place(&self, [peck, column]: Spot) -> Spot {
        if self.along_x { [column, peck] } else { [peck, column] }
    }

    fn counts(&self) -> [(f64, f64); 2] {
        let of = |from: f64, to: f64, step: f64| {
            let way = to - from;
            if step > NOISE && way.abs() > NOISE {
                (((way.abs() - NOISE) / step).ceil().clamp(1.0, MOST), way.signum() * step)
            } else {
                (if way.abs() > NOISE { 1.0 } else { 0.0 }, way)
            }
        };
        [of(self.start[0], self.end[0], self.peck), of(self.start[1], self.end[1], self.shift)]
    }

    /// Gives the moves.
    ///
    /// # Errors
    /// The sink takes no more.
    pub fn run<S: MoveSink>(&self, sink: &mut S) -> Result<(), S::Stop> {
        let [pecks, (columns, shift)] = self.counts();
        let relief =
            if columns > 0.0 { -(self.end[1] - self.start[1]).signum() * self.relief.abs() } else { self.relief };
        let mut number = 0.0;
        loop {
            let column = if number >= columns { self.end[1] } else { self.start[1] + number * shift };
            sink.go(CycleMove::Rapid(self.place([self.start[0], column])))?;
            self.column(sink, column, pecks)?;
            sink.go(CycleMove::Rapid(self.place([self.end[0], column + relief])))?;
            sink.go(CycleMove::Rapid(self.place([self.start[0], column + relief])))?;
            number += 1.0;
            if number > columns {
                break;
            }
        }
        sink.go(CycleMove::Rapid(self.place(self.start)))
    }

    fn column<S: MoveSink>(&self, sink: &mut S, column: f64, (pecks, step): (f64, f64)) -> Result<(), S::Stop> {
        let mut number = 1.0;
        while number < pecks {
            sink.pass()?;
            let depth = self.start[0] + number * step;
            sink.go(CycleMove::Feed(self.place([depth, column])))?;
            sink.go(CycleMove::Rapid(self.place([depth - step.signum() * self.back, column])))?;
            number += 1.0;
        }
        sink.pass()?;
        sink.go(CycleMove::Feed(self.place([self.end[0], column])))
    }
}
