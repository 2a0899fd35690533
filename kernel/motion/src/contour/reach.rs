//! The region of a tool centre inside contours, the area cleared from there, and the rest for a smaller tool.
//!
//! A spot is too near to a contour if it lies in the band beside one of its elements, or in the disc about one of its
//! corners. *Invariant:* the paths are exact lines and arcs; contours with too many elements have none.

use std::f64::consts::{PI, TAU};

use super::closed::ClosedContour;
use super::combine::combined;
use super::element::{Element, NOISE, Spot, beside, plus};
use super::near::at;
use crate::arc::PlaneArc;

/// Most elements of contours from which a tool keeps away.
const MOST_ELEMENTS: usize = 300;

/// Where the middle of a tool may be that keeps away from contours by an amount, inside of an odd number of them; none
/// where they have too many elements.
#[must_use]
pub fn eroded(contours: &[ClosedContour], amount: f64) -> Option<Vec<ClosedContour>> {
    beside_of(contours, amount, |inside, near| inside && !near)
}

/// The area that contours enclose an odd number of times, and points nearer to it than an amount; none if the contours
/// have too many elements.
#[must_use]
pub fn grown(contours: &[ClosedContour], amount: f64) -> Option<Vec<ClosedContour>> {
    beside_of(contours, amount, |inside, near| inside || near)
}

/// The area of two areas, by whether a point lies in the one and in the other.
#[must_use]
pub fn of_two(
    one: &[ClosedContour],
    other: &[ClosedContour],
    inside: impl Fn(bool, bool) -> bool,
) -> Option<Vec<ClosedContour>> {
    let all: Vec<ClosedContour> = one.iter().chain(other).cloned().collect();
    let odd = |held: &[bool]| held.iter().filter(|held| **held).count() % 2 == 1;
    combined(&all, |held| {
        let (first, second) = held.split_at_checked(one.len()).unwrap_or_default();
        inside(odd(first), odd(second))
    })
}

/// Places where the centre of a tool reaches material that an earlier tool with a larger radius has left; both keep
/// away from the contours by a distance besides their radii.
#[must_use]
pub fn remaining(contours: &[ClosedContour], away: f64, radius: f64, earlier: f64) -> Option<Vec<ClosedContour>> {
    let wanted = if away > NOISE { eroded(contours, away)? } else { contours.to_vec() };
    let reached = eroded(contours, away + earlier)?;
    near_left(&wanted, (&reached, earlier), (&eroded(contours, away + radius)?, radius))
}

/// Places where a tool, with its centre in the room that it reaches, touches the parts of an area that an earlier tool
/// has left; each tool with its radius.
pub(super) fn near_left(
    wanted: &[ClosedContour],
    (earlier, size): (&[ClosedContour], f64),
    (reached, radius): (&[ClosedContour], f64),
) -> Option<Vec<ClosedContour>> {
    let cleared = grown(earlier, size)?;
    let left = of_two(wanted, &cleared, |wanted, cleared| wanted && !cleared)?;
    of_two(&grown(&left, radius)?, reached, |near, reached| near && reached)
}

/// The area from the inside of an odd number of contours, and from points nearer to one than an amount.
fn beside_of(contours: &[ClosedContour], amount: f64, of: impl Fn(bool, bool) -> bool) -> Option<Vec<ClosedContour>> {
    let elements = || contours.iter().flat_map(ClosedContour::elements);
    if elements().count() > MOST_ELEMENTS {
        return None;
    }
    let rims = contours.len();
    let discs = elements().map(|element| disc(element.from, amount));
    let bands = elements().flat_map(halves).filter_map(|element| band(&element, amount));
    let all: Vec<ClosedContour> = contours.iter().cloned().chain(discs).chain(bands).collect();
    combined(&all, |held| {
        let (inside, near) = held.split_at_checked(rims).unwrap_or_default();
        of(inside.iter().filter(|held| **held).count() % 2 == 1, near.contains(&true))
    })
}

/// Elements nearer to a point than a distance.
fn disc(center: Spot, radius: f64) -> ClosedContour {
    let from = plus(center, [radius, 0.0], 1.0);
    ClosedContour::open(vec![Element {
        from,
        to: from,
        arc: Some(PlaneArc { center, radius, start_angle: 0.0, sweep: TAU }),
    }])
}

/// An element, or both halves of an arc that is longer than half a turn.
fn halves(element: &Element) -> Vec<Element> {
    match element.arc {
        Some(arc) if arc.sweep.abs() > PI => {
            let middle = at(element, 0.5);
            let half = PlaneArc { sweep: arc.sweep / 2.0, ..arc };
            let rest = PlaneArc { start_angle: arc.start_angle + half.sweep, ..half };
            vec![
                Element { from: element.from, to: middle, arc: Some(half) },
                Element { from: middle, to: element.to, arc: Some(rest) },
            ]
        }
        _ => vec![*element],
    }
}

/// Neighbours of an element nearer than a distance.
fn band(element: &Element, amount: f64) -> Option<ClosedContour> {
    let side = |spot: Spot, along: Spot, side: f64| beside(spot, along, side, amount);
    let line = |from: Spot, to: Spot| Element { from, to, arc: None };
    let (begin, end) = (element.start(), element.end());
    let Some(arc) = element.arc else {
        let corners = [
            side(element.from, begin, -1.0),
            side(element.to, end, -1.0),
            side(element.to, end, 1.0),
            side(element.from, begin, 1.0),
        ];
        let [a, b, c, d] = corners;
        return ClosedContour::new(vec![line(a, b), line(b, c), line(c, d), line(d, a)]);
    };
    // The outer side of an arc is on its right where it turns to the left.
    let outside = -arc.sweep.signum();
    let (a, b) = (side(element.from, begin, outside), side(element.to, end, outside));
    let outer = Element { from: a, to: b, arc: Some(PlaneArc { radius: arc.radius + amount, ..arc }) };
    let inner = arc.radius - amount;
    if inner < NOISE {
        return ClosedContour::new(vec![outer, line(b, arc.center), line(arc.center, a)]);
    }
    let (c, d) = (side(element.to, end, -outside), side(element.from, begin, -outside));
    let back = PlaneArc { radius: inner, start_angle: arc.start_angle + arc.sweep, sweep: -arc.sweep, ..arc };
    ClosedContour::new(vec![outer, line(b, c), Element { from: c, to: d, arc: Some(back) }, line(d, a)])
}

#[cfg(test)]
mod tests {
    use super::super::area::size;
    use super::super::combine::tests::{Dice, circle, square};
    use super::super::near::to_piece;
    use super::*;

    #[test]
    fn the_middle_of_a_tool_keeps_away() {
        // A square of 20 with a tool of 3: 14 wide. Two squares of 20 joined by a neck of 4: two areas.
        let ring = eroded(&[square(0.0, 0.0, 20.0)], 3.0).unwrap();
        assert_eq!((ring.len(), size(ring[0].elements())), (1, 196.0));
        // Grown by 1 it is 16 wide with round corners.
        let grown = grown(&ring, 1.0).unwrap();
        assert_eq!((grown.len(), grown[0].elements().len()), (1, 8));
        assert!((size(grown[0].elements()) - (256.0 - 4.0 + PI)).abs() < 1e-9);
        let neck = ClosedContour::new(
            [[20.0, 8.0], [30.0, 8.0], [30.0, 12.0], [20.0, 12.0], [20.0, 8.0]]
                .windows(2)
                .map(|pair| Element { from: pair[0], to: pair[1], arc: None })
                .collect(),
        );
        let parts = [square(0.0, 0.0, 20.0), square(30.0, 0.0, 20.0), neck.unwrap()];
        let whole = combined(&parts, |held| held.contains(&true)).unwrap();
        assert_eq!(whole.len(), 1);
        let rings = eroded(&whole, 3.0).unwrap();
        assert_eq!(rings.len(), 2);
        // The tool fits nowhere; an island is gone round.
        assert_eq!(eroded(&[square(0.0, 0.0, 5.0)], 3.0), Some(Vec::new()));
        let island = eroded(&[square(-20.0, -20.0, 40.0), circle([0.0, 0.0], 5.0)], 3.0).unwrap();
        assert!((size(island[1].elements()) + 64.0 * PI).abs() < 1e-5);
    }

    #[test]
    fn a_smaller_tool_reaches_the_corners() {
        let rings = remaining(&[square(0.0, 0.0, 40.0)], 0.0, 5.0, 10.0).unwrap();
        assert_eq!(rings.len(), 4);
        // A square of 5 without a quarter of a circle of 5, three elements each.
        for ring in &rings {
            assert_eq!(ring.elements().len(), 3, "{ring:?}");
            assert!((size(ring.elements()) - (25.0 - 25.0 * PI / 4.0)).abs() < 1e-6);
        }
        assert_eq!(remaining(&[square(0.0, 0.0, 40.0)], 1.0, 10.0, 10.0).map(|rings| rings.len()), Some(0));
    }

    #[test]
    fn a_spot_may_be_the_middle_of_a_tool_where_nothing_is_nearer() {
        let mut dice = Dice(11);
        for round in 0..60 {
            let mut whole = |most: f64| (dice.next() * most).floor();
            let mut parts = vec![square(0.0, 0.0, 12.0 + whole(8.0))];
            for _ in 0..3 {
                let (x, y, size) = (whole(20.0), whole(20.0), 1.0 + whole(4.0));
                parts.push(if whole(2.0) == 0.0 { square(x, y, size) } else { circle([x, y], size) });
            }
            let rim = combined(&parts, |held| (held[0] || held[1]) && !(held[2] || held[3])).unwrap();
            let amount = 0.3 + 3.0 * dice.next();
            let reached = eroded(&rim, amount).unwrap_or_else(|| panic!("{round} {rim:?} {amount}"));
            for _ in 0..60 {
                let spot = [dice.next() * 25.0 - 2.0, dice.next() * 25.0 - 2.0];
                let off = rim
                    .iter()
                    .flat_map(ClosedContour::elements)
                    .map(|piece| to_piece(piece, spot))
                    .fold(f64::MAX, f64::min);
                if (off - amount).abs() < 1e-4 {
                    continue;
                }
                let inside = rim.iter().filter(|ring| ring.holds(spot)).count() % 2 == 1;
                let found = reached.iter().filter(|ring| ring.holds(spot)).count() % 2 == 1;
                assert_eq!(found, inside && off > amount, "{round} {spot:?} {amount} {rim:?}");
            }
        }
    }
}
