//! An area that the program sets and that the tool must not enter, or must not leave.
//!
//! Facts: Fanuc operator's manuals, stored stroke check 2 (G22, G23; parameter 1300#0 says which side is forbidden);
//! Okuma programmable stroke limits. *Invariant:* a point on the border violates no limit.

/// Rounding tolerance at the border.
const NOISE: f64 = 1e-6;

/// Number of segments in which a circle is checked.
const PIECES: u32 = 180;

/// The area, in the machine frame, by the axes X, Y and Z as programmed.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct StoredArea {
    /// Whether the area is switched on.
    pub on: bool,
    /// Its lower and its upper end along each axis, as far as they are set.
    pub ends: [[Option<f64>; 2]; 3],
    /// The tool must stay outside of it; otherwise it must stay inside.
    pub keep_out: bool,
}

/// A place by the axes X, Y and Z; an axis that the channel does not have is not there.
pub type At = [Option<f64>; 3];

impl StoredArea {
    /// The axis, 0 to 2, along which a straight move violates the limit.
    pub fn breaks(&self, from: &At, to: &At) -> Option<usize> {
        if self.keep_out { self.enters(from, to) } else { self.leaves(to) }
    }

    /// The same for a circle, by its places from 0 to 1.
    pub fn breaks_round(&self, place: impl Fn(f64) -> At) -> Option<usize> {
        let at = |piece: u32| place(f64::from(piece) / f64::from(PIECES));
        (0..PIECES).find_map(|piece| self.breaks(&at(piece), &at(piece + 1)))
    }

    /// The first axis along which a place is outside.
    fn leaves(&self, to: &At) -> Option<usize> {
        self.ends.iter().zip(to).position(|([low, high], at)| {
            at.is_some_and(|at| low.is_some_and(|low| at < low - NOISE) || high.is_some_and(|high| at > high + NOISE))
        })
    }

    /// A part of the straight line is inside; the axis along which it moves in there.
    fn enters(&self, from: &At, to: &At) -> Option<usize> {
        let (mut first, mut last, mut axis, mut bounded) = (0.0_f64, 1.0_f64, 0, false);
        for (index, (([low, high], from), to)) in self.ends.iter().zip(from).zip(to).enumerate() {
            let (Some(from), Some(to)) = (from, to) else { continue };
            bounded |= low.is_some() || high.is_some();
            let low = low.map_or(f64::NEG_INFINITY, |low| low + NOISE);
            let high = high.map_or(f64::INFINITY, |high| high - NOISE);
            let way = to - from;
            if way == 0.0 {
                if *from < low || *from > high {
                    return None;
                }
                continue;
            }
            let (a, b) = ((low - from) / way, (high - from) / way);
            if a.min(b) > first {
                (first, axis) = (a.min(b), index);
            }
            last = last.min(a.max(b));
        }
        (bounded && first <= last).then_some(axis)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(keep_out: bool) -> StoredArea {
        let ends = [[Some(-10.0), Some(10.0)], [Some(0.0), Some(20.0)], [None, None]];
        StoredArea { on: true, ends, keep_out }
    }

    fn at(x: f64, y: f64) -> At {
        [Some(x), Some(y), Some(0.0)]
    }

    #[test]
    fn a_line_that_crosses_the_area_enters_it_though_both_ends_are_outside() {
        let area = area(true);
        assert_eq!(area.breaks(&at(-20.0, 5.0), &at(20.0, 5.0)), Some(0));
        assert_eq!(area.breaks(&at(0.0, 30.0), &at(0.0, 10.0)), Some(1));
        assert_eq!(area.breaks(&at(-20.0, -5.0), &at(20.0, -5.0)), None);
        // Along the border and across a corner.
        assert_eq!(area.breaks(&at(-20.0, 0.0), &at(20.0, 0.0)), None);
        assert_eq!(area.breaks(&at(0.0, 30.0), &at(20.0, 10.0)), None);
        // A move out of the area is in it at first.
        assert!(area.breaks(&at(0.0, 5.0), &at(50.0, 5.0)).is_some());
    }

    #[test]
    fn a_place_outside_leaves_the_area() {
        let area = area(false);
        assert_eq!(area.breaks(&at(0.0, 0.0), &at(10.0, 20.0)), None);
        assert_eq!(area.breaks(&at(0.0, 0.0), &at(10.1, 20.0)), Some(0));
        assert_eq!(area.breaks(&at(0.0, 0.0), &at(0.0, -0.1)), Some(1));
        assert_eq!(area.breaks(&at(0.0, 0.0), &[Some(0.0), None, None]), None);
    }

    #[test]
    fn a_circle_swings_out_of_the_area_and_into_it() {
        let turn = std::f64::consts::TAU;
        let round = |share: f64| at(10.0 * (share * turn).cos(), 10.0 + 10.1 * (share * turn).sin());
        assert_eq!(area(false).breaks_round(round), Some(1));
        let round = |share: f64| at(-14.0 + 5.0 * (share * turn).cos(), 10.0 + 5.0 * (share * turn).sin());
        assert!(area(true).breaks_round(round).is_some());
        let round = |share: f64| at(-16.0 + 5.0 * (share * turn).cos(), 10.0 + 5.0 * (share * turn).sin());
        assert_eq!(area(true).breaks_round(round), None);
    }
}
