//! Areas that are put together from the insides of closed contours: unions, differences, common parts, anything that is asked of
//! where a spot lies.
//!
//! All contours are cut where they meet; of each piece both sides are asked, and the pieces with the area on one side alone are its
//! rim. *Invariant:* rings have the area on their left, so outer ones run counter-clockwise, and no two rings cross; what does not
//! close is none.

use std::f64::consts::{PI, TAU};

use super::area::size;
use super::closed::Closed;
use super::element::{Element, NOISE, Spot, angle, beside, cross, distance, dot, plus};
use super::meet::{SAME, meetings};
use super::near::{at, to_piece, turned};
use crate::arc::Arc;

/// Most elements of contours from which a tool keeps away, and most pieces of a rim.
const MOST_ELEMENTS: usize = 300;
const MOST_PIECES: usize = 10_000;

/// A piece between two spots where contours meet, by their numbers.
#[derive(Debug, Clone, Copy)]
struct Piece {
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

/// Whether two contours have a spot in common.
#[must_use]
pub fn touch(a: &Closed, b: &Closed) -> bool {
    a.elements().iter().any(|one| b.elements().iter().any(|other| !meetings(one, other).is_empty()))
}

/// The area where `inside` says so of the contours that hold a spot; none if its rim does not close.
#[must_use]
pub fn combined(contours: &[Closed], inside: impl Fn(&[bool]) -> bool) -> Option<Vec<Closed>> {
    let mut rim: Vec<Piece> = Vec::new();
    let against: Vec<bool> = contours.iter().map(|contour| size(contour.elements()) < 0.0).collect();
    for piece in pieces(contours)? {
        let middle = at(&piece.element, 0.5);
        let along = heading(&piece.element, middle);
        let mut sides = [vec![false; contours.len()], vec![false; contours.len()]];
        for (number, contour) in contours.iter().enumerate() {
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
            if left { piece } else { Piece { element: turned(&piece.element), from: piece.to, to: piece.from } };
        // Contours on top of each other give a piece of the rim once.
        let is_there = |other: &Piece| {
            (other.from, other.to) == (piece.from, piece.to) && distance(at(&other.element, 0.5), middle) < 4.0 * SAME
        };
        if !rim.iter().any(is_there) {
            rim.push(piece);
        }
    }
    rings(rim)
}

/// Where the middle of a tool may be that keeps away from contours by an amount, inside of an odd number of them; none where they have
/// too many elements.
#[must_use]
pub fn eroded(contours: &[Closed], amount: f64) -> Option<Vec<Closed>> {
    beside_of(contours, amount, |inside, near| inside && !near)
}

/// What contours hold an odd number of times, and what lies nearer to it than an amount; none where they have too many elements.
#[must_use]
pub fn grown(contours: &[Closed], amount: f64) -> Option<Vec<Closed>> {
    beside_of(contours, amount, |inside, near| inside || near)
}

/// The area of two areas, by whether a spot lies in the one and in the other.
#[must_use]
pub fn of_two(one: &[Closed], other: &[Closed], inside: impl Fn(bool, bool) -> bool) -> Option<Vec<Closed>> {
    let all: Vec<Closed> = one.iter().chain(other).cloned().collect();
    let odd = |held: &[bool]| held.iter().filter(|held| **held).count() % 2 == 1;
    combined(&all, |held| {
        let (first, second) = held.split_at_checked(one.len()).unwrap_or_default();
        inside(odd(first), odd(second))
    })
}

/// Where the middle of a tool reaches what an earlier one with a larger radius has left; both keep away from the contours by a distance
/// besides their radii.
#[must_use]
pub fn remaining(contours: &[Closed], away: f64, radius: f64, earlier: f64) -> Option<Vec<Closed>> {
    let wanted = if away > NOISE { eroded(contours, away)? } else { contours.to_vec() };
    let cleared = grown(&eroded(contours, away + earlier)?, earlier)?;
    let left = of_two(&wanted, &cleared, |wanted, cleared| wanted && !cleared)?;
    let near = grown(&left, radius)?;
    of_two(&near, &eroded(contours, away + radius)?, |near, reached| near && reached)
}

/// The area by what lies inside of an odd number of contours, and nearer to one than an amount.
fn beside_of(contours: &[Closed], amount: f64, of: impl Fn(bool, bool) -> bool) -> Option<Vec<Closed>> {
    let elements = || contours.iter().flat_map(Closed::elements);
    if elements().count() > MOST_ELEMENTS {
        return None;
    }
    let rims = contours.len();
    let discs = elements().map(|element| disc(element.from, amount));
    let bands = elements().flat_map(halves).filter_map(|element| band(&element, amount));
    let all: Vec<Closed> = contours.iter().cloned().chain(discs).chain(bands).collect();
    combined(&all, |held| {
        let (inside, near) = held.split_at_checked(rims).unwrap_or_default();
        of(inside.iter().filter(|held| **held).count() % 2 == 1, near.contains(&true))
    })
}

/// What lies nearer to a spot than an amount.
fn disc(center: Spot, radius: f64) -> Closed {
    let from = plus(center, [radius, 0.0], 1.0);
    Closed::open(vec![Element { from, to: from, arc: Some(Arc { center, radius, start_angle: 0.0, sweep: TAU }) }])
}

/// An element, or both halves of an arc that is longer than half a turn.
fn halves(element: &Element) -> Vec<Element> {
    match element.arc {
        Some(arc) if arc.sweep.abs() > PI => {
            let middle = at(element, 0.5);
            let half = Arc { sweep: arc.sweep / 2.0, ..arc };
            let rest = Arc { start_angle: arc.start_angle + half.sweep, ..half };
            vec![
                Element { from: element.from, to: middle, arc: Some(half) },
                Element { from: middle, to: element.to, arc: Some(rest) },
            ]
        }
        _ => vec![*element],
    }
}

/// What lies beside an element, nearer than an amount.
fn band(element: &Element, amount: f64) -> Option<Closed> {
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
        return Closed::new(vec![line(a, b), line(b, c), line(c, d), line(d, a)]);
    };
    // The outer side of an arc is on its right where it turns to the left.
    let outside = -arc.sweep.signum();
    let (a, b) = (side(element.from, begin, outside), side(element.to, end, outside));
    let outer = Element { from: a, to: b, arc: Some(Arc { radius: arc.radius + amount, ..arc }) };
    let inner = arc.radius - amount;
    if inner < NOISE {
        return Closed::new(vec![outer, line(b, arc.center), line(arc.center, a)]);
    }
    let (c, d) = (side(element.to, end, -outside), side(element.from, begin, -outside));
    let back = Arc { radius: inner, start_angle: arc.start_angle + arc.sweep, sweep: -arc.sweep, ..arc };
    Closed::new(vec![outer, line(b, c), Element { from: c, to: d, arc: Some(back) }, line(d, a)])
}

/// All elements, cut where they meet elements of any contour.
fn pieces(contours: &[Closed]) -> Option<Vec<Piece>> {
    let elements: Vec<Element> = contours.iter().flat_map(Closed::elements).copied().collect();
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
                pieces.push(Piece { element: part, from: spots.number(here), to: spots.number(to) });
            }
            here = to;
        }
        if pieces.len() > MOST_PIECES {
            return None;
        }
    }
    Some(pieces)
}

/// Two elements are near enough to meet, seen as circles.
fn may_meet(a: &Element, b: &Element) -> bool {
    let circle = |element: &Element| match &element.arc {
        Some(arc) => (arc.center, arc.radius),
        None => (at(element, 0.5), distance(element.from, element.to) / 2.0),
    };
    let ((one, radius), (other, more)) = (circle(a), circle(b));
    distance(one, other) <= radius + more + 2.0 * SAME
}

/// Direction of a piece at one of its spots.
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
fn rings(mut rim: Vec<Piece>) -> Option<Vec<Closed>> {
    let mut rings = Vec::new();
    while !rim.is_empty() {
        let first = rim.remove(0);
        let mut ring = vec![first.element];
        let (start, mut here, mut along) = (first.from, first.to, first.element.end());
        while here != start {
            let turn = |piece: &Piece| {
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
        rings.push(Closed::new(joined(ring))?);
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
            same.then_some(Arc { sweep: one.sweep + other.sweep, ..*one })?
        }
        _ => return None,
    };
    Some(Element { from: a.from, to: b.to, arc: Some(arc) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, y: f64, size: f64) -> Closed {
        let corners = [[x, y], [x + size, y], [x + size, y + size], [x, y + size]];
        let sides = (0..4).map(|at| Element { from: corners[at], to: corners[(at + 1) % 4], arc: None });
        Closed::new(sides.collect()).unwrap()
    }

    fn circle(center: Spot, radius: f64) -> Closed {
        let from = [center[0] + radius, center[1]];
        let arc = Arc { center, radius, start_angle: 0.0, sweep: -TAU };
        Closed::new(vec![Element { from, to: from, arc: Some(arc) }]).unwrap()
    }

    fn sizes(contours: &[Closed], inside: impl Fn(&[bool]) -> bool) -> Vec<f64> {
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

    #[test]
    fn the_middle_of_a_tool_keeps_away() {
        // A square of 20 with a tool of 3: 14 wide. Two squares of 20 joined by a neck of 4: two areas.
        let ring = eroded(&[square(0.0, 0.0, 20.0)], 3.0).unwrap();
        assert_eq!((ring.len(), size(ring[0].elements())), (1, 196.0));
        // Grown by 1 it is 16 wide with round corners.
        let grown = grown(&ring, 1.0).unwrap();
        assert_eq!((grown.len(), grown[0].elements().len()), (1, 8));
        assert!((size(grown[0].elements()) - (256.0 - 4.0 + PI)).abs() < 1e-9);
        let neck = Closed::new(
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
                let off =
                    rim.iter().flat_map(Closed::elements).map(|piece| to_piece(piece, spot)).fold(f64::MAX, f64::min);
                if (off - amount).abs() < 1e-4 {
                    continue;
                }
                let inside = rim.iter().filter(|ring| ring.holds(spot)).count() % 2 == 1;
                let found = reached.iter().filter(|ring| ring.holds(spot)).count() % 2 == 1;
                assert_eq!(found, inside && off > amount, "{round} {spot:?} {amount} {rim:?}");
            }
        }
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
    fn a_spot_is_in_the_rings_where_it_should_be() {
        let mut dice = Dice(3);
        for _ in 0..300 {
            let count = 2 + (dice.next() * 4.0) as usize;
            // Coordinates on a grid make sides that lie on each other and corners that touch.
            let mut whole = |most: f64| (dice.next() * most).floor();
            let contours: Vec<Closed> = (0..count)
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
