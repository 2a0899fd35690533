//! Areas that are put together from the insides of closed contours: unions, differences, common parts, anything that is
//! asked of where a point lies.
//!
//! All contours are cut where they meet. Both sides of each piece are tested, and the pieces with the area on one side
//! alone are its rim. *Invariant:* rings have the area on their left, so outer rings run counter-clockwise, and no two
//! rings cross; pieces that do not close give none.

use std::f64::consts::{PI, TAU};

use super::area::size;
use super::closed::ClosedContour;
use super::element::{Element, NOISE, Spot, angle, cross, distance, dot, plus};
use super::meet::{SAME, meetings};
use super::near::{at, to_piece, turned};
use crate::arc::PlaneArc;

/// Most pieces of a rim.
const MOST_PIECES: usize = 10_000;

/// A piece between two points where contours meet, by their numbers.
#[derive(Debug, Clone, Copy)]
struct SplitElement {
    element: Element,
    from: usize,
    to: usize,
}

/// Spots, each once.
#[derive(Debug, Default)]
struct Spots(Vec<Spot>);

impl Spots {
    fn number(&mut self, spot: Spot) -> usize {
        let known = self.0.iter().position(|known| distance(*known, spot) < 2.0 * SAME);
        known.unwrap_or_else(|| {
            self.0.push(spot);
            self.0.len() - 1
        })
    }
}

/// Whether two contours have a point in common.
#[must_use]
pub fn touch(a: &ClosedContour, b: &ClosedContour) -> bool {
    a.elements().iter().any(|one| b.elements().iter().any(|other| !meetings(one, other).is_empty()))
}

/// The area where `inside` says so of the contours that hold a point; none if its rim does not close.
#[must_use]
pub fn combined(contours: &[ClosedContour], inside: impl Fn(&[bool]) -> bool) -> Option<Vec<ClosedContour>> {
    let mut rim: Vec<SplitElement> = Vec::new();
    let against: Vec<bool> = contours.iter().map(|contour| size(contour.elements()) < 0.0).collect();
    let reaches: Vec<ContourBounds> = contours.iter().map(ContourBounds::of).collect();
    for piece in pieces(contours)? {
        let middle = at(&piece.element, 0.5);
        let along = heading(&piece.element, middle);
        let mut sides = [vec![false; contours.len()], vec![false; contours.len()]];
        for (number, (contour, reach)) in contours.iter().zip(&reaches).enumerate() {
            if !reach.has(middle) {
                continue;
            }
            let beside = contour.elements().iter().find(|element| to_piece(element, middle) < 2.0 * SAME);
            let [left, right] = match beside {
                // On the contour: its inside is on its left, on its right where it runs clockwise.
                Some(element) => {
                    let same = dot(heading(element, middle), along) > 0.0;
                    let left = same != against.get(number).copied().unwrap_or(false);
                    [left, !left]
                }
                None => [contour.holds(middle); 2],
            };
            for (side, held) in sides.iter_mut().zip([left, right]) {
                if let Some(slot) = side.get_mut(number) {
                    *slot = held;
                }
            }
        }
        let [left, right] = sides.map(|side| inside(&side));
        if left == right {
            continue;
        }
        let piece =
            if left { piece } else { SplitElement { element: turned(&piece.element), from: piece.to, to: piece.from } };
        // Contours on top of each other give a piece of the rim once.
        let is_there = |other: &SplitElement| {
            (other.from, other.to) == (piece.from, piece.to) && distance(at(&other.element, 0.5), middle) < 4.0 * SAME
        };
        if !rim.iter().any(is_there) {
            rim.push(piece);
        }
    }
    rings(rim)
}

/// All elements, cut where they meet elements of any contour.
fn pieces(contours: &[ClosedContour]) -> Option<Vec<SplitElement>> {
    let elements: Vec<Element> = contours.iter().flat_map(ClosedContour::elements).copied().collect();
    let mut spots = Spots::default();
    let mut pieces = Vec::new();
    for (number, element) in elements.iter().enumerate() {
        let others = elements.iter().enumerate().filter(|(other, of)| *other != number && may_meet(element, of));
        let mut cuts: Vec<Spot> = others.flat_map(|(_, other)| meetings(element, other)).collect();
        cuts.retain(|spot| distance(*spot, element.from) > SAME && distance(*spot, element.to) > SAME);
        cuts.sort_by(|a, b| element.share(*a).total_cmp(&element.share(*b)));
        cuts.dedup_by(|a, b| distance(*a, *b) < 2.0 * SAME);
        let mut here = element.from;
        for to in cuts.into_iter().chain([element.to]) {
            let part = if here == element.from && to == element.to { *element } else { element.between(here, to) };
            if part.arc.is_some() || distance(here, to) > NOISE {
                pieces.push(SplitElement { element: part, from: spots.number(here), to: spots.number(to) });
            }
            here = to;
        }
        if pieces.len() > MOST_PIECES {
            return None;
        }
    }
    Some(pieces)
}

/// A rectangle around a contour; a point outside is neither on the contour nor in it.
#[derive(Debug, Clone, Copy)]
struct ContourBounds {
    low: Spot,
    high: Spot,
}

impl ContourBounds {
    fn of(contour: &ClosedContour) -> Self {
        let none = Self { low: [f64::INFINITY; 2], high: [f64::NEG_INFINITY; 2] };
        contour.elements().iter().fold(none, |mut reach, element| {
            let spots = match &element.arc {
                Some(arc) => [plus(arc.center, [-1.0; 2], arc.radius), plus(arc.center, [1.0; 2], arc.radius)],
                None => [element.from, element.to],
            };
            for spot in spots {
                for (side, at) in spot.into_iter().enumerate() {
                    if let (Some(low), Some(high)) = (reach.low.get_mut(side), reach.high.get_mut(side)) {
                        (*low, *high) = (low.min(at), high.max(at));
                    }
                }
            }
            reach
        })
    }

    fn has(&self, [x, y]: Spot) -> bool {
        let within = |at: f64, low: f64, high: f64| at > low - 4.0 * SAME && at < high + 4.0 * SAME;
        within(x, self.low[0], self.high[0]) && within(y, self.low[1], self.high[1])
    }
}

/// Whether two elements are near enough to meet, seen as circles.
fn may_meet(a: &Element, b: &Element) -> bool {
    let circle = |element: &Element| match &element.arc {
        Some(arc) => (arc.center, arc.radius),
        None => (at(element, 0.5), distance(element.from, element.to) / 2.0),
    };
    let ((one, radius), (other, more)) = (circle(a), circle(b));
    distance(one, other) <= radius + more + 2.0 * SAME
}

/// Direction of a piece at one of its points.
fn heading(piece: &Element, spot: Spot) -> Spot {
    match &piece.arc {
        None => piece.start(),
        Some(arc) => {
            let spoke = angle(arc.center, spot);
            let turn = arc.sweep.signum();
            [-libm::sin(spoke) * turn, libm::cos(spoke) * turn]
        }
    }
}

/// Pieces one after the other, at each spot the one that leaves the least of the area between.
fn rings(mut rim: Vec<SplitElement>) -> Option<Vec<ClosedContour>> {
    let mut rings = Vec::new();
    while !rim.is_empty() {
        let first = rim.remove(0);
        let mut ring = vec![first.element];
        let (start, mut here, mut along) = (first.from, first.to, first.element.end());
        while here != start {
            let turn = |piece: &SplitElement| {
                let next = piece.element.start();
                let turn = libm::atan2(cross(along, next), dot(along, next));
                // Straight back is the sharpest turn to the right.
                if turn > PI - 1e-9 { -turn } else { turn }
            };
            let next = rim
                .iter()
                .enumerate()
                .filter(|(_, piece)| piece.from == here)
                .max_by(|a, b| turn(a.1).total_cmp(&turn(b.1)).then(b.0.cmp(&a.0)))
                .map(|(number, _)| number)?;
            let piece = rim.remove(next);
            ring.push(piece.element);
            (here, along) = (piece.to, piece.element.end());
        }
        rings.push(ClosedContour::new(joined(ring))?);
    }
    Some(rings)
}

/// Pieces that continue each other as one.
fn joined(ring: Vec<Element>) -> Vec<Element> {
    let mut out: Vec<Element> = Vec::new();
    for piece in ring {
        match out.last_mut().and_then(|last| Some((one(last, &piece)?, last))) {
            Some((whole, last)) => *last = whole,
            None => out.push(piece),
        }
    }
    if out.len() > 2
        && let (Some(last), Some(first)) = (out.last().copied(), out.first().copied())
        && let Some(whole) = one(&last, &first)
    {
        out.pop();
        if let Some(slot) = out.first_mut() {
            *slot = whole;
        }
    }
    out
}

/// Two pieces as one, where the second continues the first.
fn one(a: &Element, b: &Element) -> Option<Element> {
    let arc = match (&a.arc, &b.arc) {
        (None, None) => {
            let straight = cross(a.start(), b.start()).abs() < 1e-9 && dot(a.start(), b.start()) > 0.0;
            return straight.then_some(Element { from: a.from, to: b.to, arc: None });
        }
        (Some(one), Some(other)) => {
            let same = distance(one.center, other.center) < SAME
                && (one.radius - other.radius).abs() < SAME
                && (one.sweep > 0.0) == (other.sweep > 0.0)
                && (one.sweep + other.sweep).abs() < TAU + 1e-9;
            same.then_some(PlaneArc { sweep: one.sweep + other.sweep, ..*one })?
        }
        _ => return None,
    };
    Some(Element { from: a.from, to: b.to, arc: Some(arc) })
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(in crate::contour) fn square(x: f64, y: f64, size: f64) -> ClosedContour {
        let corners = [[x, y], [x + size, y], [x + size, y + size], [x, y + size]];
        let sides = (0..4).map(|at| Element { from: corners[at], to: corners[(at + 1) % 4], arc: None });
        ClosedContour::new(sides.collect()).unwrap()
    }

    pub(in crate::contour) fn circle(center: Spot, radius: f64) -> ClosedContour {
        let from = [center[0] + radius, center[1]];
        let arc = PlaneArc { center, radius, start_angle: 0.0, sweep: -TAU };
        ClosedContour::new(vec![Element { from, to: from, arc: Some(arc) }]).unwrap()
    }

    fn sizes(contours: &[ClosedContour], inside: impl Fn(&[bool]) -> bool) -> Vec<f64> {
        let rings = combined(contours, inside).unwrap();
        rings.iter().map(|ring| (size(ring.elements()) * 1e6).round() / 1e6).collect()
    }

    #[test]
    fn squares_that_overlap() {
        let both = [square(0.0, 0.0, 10.0), square(5.0, 5.0, 10.0).reversed()];
        assert_eq!(sizes(&both, |held| held[0] || held[1]), [175.0]);
        assert_eq!(sizes(&both, |held| held[0] && held[1]), [25.0]);
        assert_eq!(sizes(&both, |held| held[0] && !held[1]), [75.0]);
        assert_eq!(sizes(&both, |held| held[0] != held[1]), [75.0, 75.0]);
        let union = combined(&both, |held| held[0] || held[1]).unwrap();
        assert_eq!(union[0].elements().len(), 8);
    }

    #[test]
    fn circles_and_holes() {
        // Two of radius 5, 6 apart: each segment beyond the common chord has 25 acos(0.6) − 12.
        let both = [circle([0.0, 0.0], 5.0), circle([6.0, 0.0], 5.0)];
        let lens = 2.0 * (25.0 * 0.6_f64.acos() - 12.0);
        let whole = 50.0 * PI - lens;
        let near = |found: Vec<f64>, wanted: f64| assert!(found.len() == 1 && (found[0] - wanted).abs() < 1e-5);
        near(sizes(&both, |held| held[0] || held[1]), whole);
        near(sizes(&both, |held| held[0] && held[1]), lens);
        // A hole runs clockwise.
        let holed = [square(-10.0, -10.0, 20.0), circle([0.0, 0.0], 5.0)];
        let found = sizes(&holed, |held| held[0] && !held[1]);
        assert!((found[0] - 400.0).abs() < 1e-9 && (found[1] + 25.0 * PI).abs() < 1e-5, "{found:?}");
    }

    #[test]
    fn sides_on_top_of_each_other() {
        let pair = [square(0.0, 0.0, 10.0), square(10.0, 0.0, 10.0)];
        let union = combined(&pair, |held| held[0] || held[1]).unwrap();
        assert_eq!((union.len(), union[0].elements().len()), (1, 4));
        assert_eq!(sizes(&pair, |held| held[0] && held[1]), Vec::<f64>::new());
        let same = [square(0.0, 0.0, 10.0), square(0.0, 0.0, 10.0)];
        assert_eq!(sizes(&same, |held| held[0] || held[1]), [100.0]);
        assert_eq!(sizes(&same, |held| held[0] && !held[1]), Vec::<f64>::new());
        // Corner to corner they stay two.
        let corner = [square(0.0, 0.0, 10.0), square(10.0, 10.0, 10.0)];
        assert_eq!(sizes(&corner, |held| held[0] || held[1]), [100.0, 100.0]);
    }

    /// Numbers between 0 and 1 that are the same each time.
    pub(in crate::contour) struct Dice(pub(in crate::contour) u64);

    impl Dice {
        pub(in crate::contour) fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1_u64 << 53) as f64
        }
    }

    #[test]
    fn a_spot_is_in_the_rings_where_it_should_be() {
        let mut dice = Dice(3);
        for _ in 0..300 {
            let count = 2 + (dice.next() * 4.0) as usize;
            // Coordinates on a grid make sides that lie on each other and corners that touch.
            let mut whole = |most: f64| (dice.next() * most).floor();
            let contours: Vec<ClosedContour> = (0..count)
                .map(|_| {
                    let (x, y, size) = (whole(8.0), whole(8.0), 1.0 + whole(6.0));
                    if whole(2.0) == 0.0 { square(x, y, size) } else { circle([x, y], size) }
                })
                .collect();
            let inside = |held: &[bool]| (held[0] || held[1]) && !held.iter().skip(2).any(|held| *held);
            let rings = combined(&contours, inside).expect("rings close");
            for _ in 0..50 {
                let spot = [dice.next() * 20.0 - 5.0, dice.next() * 20.0 - 5.0];
                let held: Vec<bool> = contours.iter().map(|contour| contour.holds(spot)).collect();
                let found = rings.iter().filter(|ring| ring.holds(spot)).count() % 2 == 1;
                assert_eq!(found, inside(&held), "{spot:?} of {contours:?}");
            }
        }
    }
}
