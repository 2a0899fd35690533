//! An area inside a closed rim and outside islands, as a tool with a radius can clear it.
//!
//! The area lies on the left of all rings: the rim turns counter-clockwise, islands clockwise. *Invariant:* every way of the tool's
//! centre keeps its distance from all rings; where a passage is narrower than that, there is no way.

use super::crossing::{crossings, heights};
use super::element::{Element, NOISE, cross, distance};
use super::near::{at, nearest, turned};
use super::shifted::shifted;
use crate::arc::Arc;

/// A ring that is no closed contour with an area.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Open;

/// Rim and islands.
#[derive(Debug, Clone, Default)]
pub struct Area {
    rings: Vec<Vec<Element>>,
}

impl Area {
    /// Takes a ring more, the rim first; how many there are.
    ///
    /// # Errors
    /// It is not closed, or has no area.
    pub fn add(&mut self, contour: &[Element]) -> Result<usize, Open> {
        let (Some(first), Some(last)) = (contour.first(), contour.last()) else { return Err(Open) };
        let size = size(contour);
        if distance(first.from, last.to) > 1e-4 || size.abs() < NOISE {
            return Err(Open);
        }
        let rim = self.rings.is_empty();
        let turned = if (size > 0.0) == rim { contour.to_vec() } else { backwards(contour) };
        self.rings.push(begun_within(turned));
        Ok(self.rings.len())
    }

    /// Ways of the tool's centre along all rings, at a distance; none if it does not fit everywhere.
    #[must_use]
    pub fn ways(&self, by: f64) -> Option<Vec<Vec<Element>>> {
        let ways: Option<Vec<_>> = self.rings.iter().map(|ring| shifted(ring, 1.0, by)).collect();
        let ways = ways?;
        let all = || self.rings.iter().flatten();
        let clear = |piece: &Element| all().all(|ring| nearest(piece, ring) > by - 1e-5);
        // A way that keeps its distance does not leave the area it begins in.
        let within = |way: &Vec<Element>| {
            let Some([along, across]) = way.first().map(|first| first.from) else { return false };
            crossings(all(), across).iter().filter(|place| **place < along).count() % 2 == 1
        };
        let fit = ways.iter().all(within) && ways.iter().flatten().all(clear);
        fit.then_some(ways)
    }
}

/// Lines along the first axis that clear what lies between ways, not further apart than a step, but for a number of them: second coordinate,
/// first coordinate of both ends, alternately to and fro.
#[must_use]
pub fn lines(ways: &[Vec<Element>], step: f64, most: u32) -> Vec<[f64; 3]> {
    let (low, high) = heights(ways.iter().flatten());
    if !(high > low && step > 0.0) {
        return Vec::new();
    }
    let count = ((high - low) / step - 1e-6).ceil().clamp(1.0, f64::from(most)) as u32;
    let mut made = Vec::new();
    for number in 1..count {
        let across = low + (high - low) * f64::from(number) / f64::from(count);
        let places = crossings(ways.iter().flatten(), across);
        let mut row: Vec<[f64; 3]> = Vec::new();
        let mut ends = places.into_iter();
        while let (Some(from), Some(to)) = (ends.next(), ends.next()) {
            row.push([across, from, to]);
        }
        if number % 2 == 0 {
            row.reverse();
            row.iter_mut().for_each(|[_, from, to]| std::mem::swap(from, to));
        }
        made.extend(row);
    }
    made
}

/// Size of what a ring surrounds, positive if it turns counter-clockwise.
pub(super) fn size(ring: &[Element]) -> f64 {
    let piece = |piece: &Element| {
        let bow = piece.arc.map_or(0.0, |arc| arc.radius * arc.radius * (arc.sweep - libm::sin(arc.sweep)) / 2.0);
        cross(piece.from, piece.to) / 2.0 + bow
    };
    ring.iter().map(piece).sum()
}

/// A way or ring the other way round.
#[must_use]
pub fn backwards(ring: &[Element]) -> Vec<Element> {
    ring.iter().rev().map(turned).collect()
}

/// The ring from the middle of its first straight piece on, so that its end has no corner.
fn begun_within(mut ring: Vec<Element>) -> Vec<Element> {
    let first = ring.iter().position(|piece| piece.arc.is_none()).unwrap_or(0);
    ring.rotate_left(first);
    let Some(piece) = ring.first().copied() else { return ring };
    let middle = at(&piece, 0.5);
    let halves = match piece.arc {
        None => [Element { to: middle, ..piece }, Element { from: middle, ..piece }],
        Some(arc) => {
            let half = Arc { sweep: arc.sweep / 2.0, ..arc };
            let rest = Arc { start_angle: arc.start_angle + half.sweep, ..half };
            [Element { to: middle, arc: Some(half), ..piece }, Element { from: middle, arc: Some(rest), ..piece }]
        }
    };
    let [before, behind] = halves;
    if let Some(slot) = ring.first_mut() {
        *slot = behind;
    }
    ring.push(before);
    ring
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contour::element::{Spot, plus};
    use crate::contour::near::to_piece;
    use std::f64::consts::TAU;

    fn square(from: f64, to: f64) -> Vec<Element> {
        let corners = [[from, from], [to, from], [to, to], [from, to], [from, from]];
        corners.windows(2).map(|pair| Element { from: pair[0], to: pair[1], arc: None }).collect()
    }

    fn circle(center: Spot, radius: f64) -> Vec<Element> {
        let from = plus(center, [radius, 0.0], 1.0);
        vec![Element { from, to: from, arc: Some(Arc { center, radius, start_angle: 0.0, sweep: TAU }) }]
    }

    /// Numbers between 0 and 1 that are the same each time.
    struct Dice(u64);

    impl Dice {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1_u64 << 53) as f64
        }
    }

    #[test]
    fn no_way_and_no_line_comes_nearer_than_its_distance() {
        let mut dice = Dice(7);
        let mut fitted = 0;
        for _ in 0..1_000 {
            let count = 3 + (dice.next() * 8.0) as usize;
            let corner = |number: usize, dice: &mut Dice| {
                let turn = TAU * number as f64 / count as f64;
                plus([0.0; 2], [libm::cos(turn), libm::sin(turn)], 10.0 + 30.0 * dice.next())
            };
            let mut corners: Vec<Spot> = (0..count).map(|number| corner(number, &mut dice)).collect();
            corners.extend(corners.first().copied());
            if dice.next() < 0.5 {
                corners.reverse();
            }
            let rim: Vec<Element> =
                corners.windows(2).map(|pair| Element { from: pair[0], to: pair[1], arc: None }).collect();
            let mut area = Area::default();
            assert_eq!(area.add(&rim), Ok(1));
            if dice.next() < 0.7 {
                area.add(&circle([4.0 * dice.next(), 4.0 * dice.next()], 1.0 + 2.0 * dice.next())).unwrap();
            }
            let by = 0.5 + 4.0 * dice.next();
            let Some(ways) = area.ways(by) else { continue };
            fitted += 1;
            let free =
                |spot: Spot| area.rings.iter().flatten().map(|piece| to_piece(piece, spot)).fold(f64::MAX, f64::min);
            let spots = (0..=40).map(|number| f64::from(number) / 40.0);
            for piece in ways.iter().flatten() {
                for share in spots.clone() {
                    assert!(free(at(piece, share)) > by - 1e-3, "{piece:?} of {rim:?} by {by}");
                }
            }
            for [across, from, to] in lines(&ways, 1.5 * by, 1000) {
                for share in spots.clone() {
                    let spot = [from + (to - from) * share, across];
                    assert!(free(spot) > by - 1e-3, "{spot:?} of {rim:?} by {by}");
                }
            }
        }
        assert!(fitted > 100, "{fitted}");
    }

    #[test]
    fn a_square_with_a_round_island() {
        let mut area = Area::default();
        assert_eq!(area.add(&square(0.0, 40.0)), Ok(1));
        assert_eq!(area.add(&circle([20.0, 20.0], 5.0)), Ok(2));
        let ways = area.ways(3.0).unwrap();
        // Islands turn clockwise, with the radius and the distance.
        assert!(ways[1].iter().all(|piece| piece.arc.is_some_and(|arc| arc.radius == 8.0 && arc.sweep < 0.0)));
        assert_eq!(ways[0].first().map(|piece| piece.from), Some([20.0, 3.0]));
        // From Y3 to Y37 in steps of 17: the line through the middle is cut by the island.
        assert_eq!(lines(&ways, 17.0, 100), [[20.0, 3.0, 12.0], [20.0, 28.0, 37.0]]);
        // Between island and rim there is room for 15, not for more.
        assert!(area.ways(7.4).is_some() && area.ways(7.6).is_none());
        assert_eq!(area.add(&square(0.0, 1.0)[..3]), Err(Open));
    }
}
