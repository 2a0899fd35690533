//! Repeated patterns: the contour several times, each time nearer to its final place.
//!
//! *Invariant:* the last pass leaves the allowance alone.

use super::{CycleMove, MoveSink, ProgrammedContour, along, moved};
use crate::contour::element::Spot;

/// Settings of the cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PatternRepeatSettings {
    /// How far the first pass is from the last one, along Z and X.
    pub relief: Spot,
    /// The allowance of the last pass along Z and X.
    pub allowance: Spot,
    /// Number of passes, at least 1.
    pub passes: u32,
}

/// Gives the moves.
///
/// # Errors
/// The sink takes no more.
pub fn run<S: MoveSink>(
    contour: &ProgrammedContour,
    settings: &PatternRepeatSettings,
    sink: &mut S,
) -> Result<(), S::Stop> {
    for pass in 0..settings.passes {
        sink.pass()?;
        let last = settings.passes.saturating_sub(1);
        let share = if last == 0 { 0.0 } else { 1.0 - f64::from(pass) / f64::from(last) };
        let by = [0, 1].map(|side: usize| {
            let of = |spot: &Spot| spot.get(side).copied().unwrap_or(0.0);
            of(&settings.allowance) + of(&settings.relief) * share
        });
        let [z, x] = contour.start;
        sink.go(CycleMove::Rapid([z + by[0], x + by[1]]))?;
        let mut elements = contour.elements.iter().map(|element| moved(element, by)).peekable();
        if let Some(first) = elements.peek() {
            sink.go(contour.infeed(first.from))?;
        }
        for element in elements {
            sink.go(along(&element))?;
        }
    }
    sink.go(CycleMove::Rapid(contour.start))
}
