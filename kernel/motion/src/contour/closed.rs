//! Closed contours: paths beside and between them, and straight cuts that clear their inside.
//!
//! Decisions: a path beside a contour goes around its corners on arcs; cuts run along the first axis. *Invariant:* a
//! path that comes too near to any contour is none, so doubtful cases are refused, not guessed.

use super::area::{backwards, size};
use super::blend::{CornerBlend, blend_reduced};
use super::crossing::{crossings, heights};
use super::element::{Element, NOISE, Spot, direction, distance};
use super::near::{at, nearest};
use super::shifted;
use crate::arc::{PlaneArc, by_center};

/// How much nearer than it should a path may come.
const NEAR: f64 = 1e-5;

/// Most lines of cuts.
const MOST: usize = 10_000;

/// A closed contour.
#[derive(Debug, Clone, PartialEq)]
pub struct ClosedContour {
    elements: Vec<Element>,
}

impl ClosedContour {
    /// Of elements that follow each other; a gap between the end and the start is closed by a line. None for fewer than
    /// two.
    #[must_use]
    pub fn new(mut elements: Vec<Element>) -> Option<Self> {
        let (first, last) = (elements.first()?.from, elements.last()?.to);
        if distance(first, last) > 1e-3 {
            elements.push(Element { from: last, to: first, arc: None });
        }
        let whole = elements.len() > 1 || elements.first().is_some_and(|element| element.arc.is_some());
        whole.then_some(Self { elements })
    }

    /// Elements that need not close.
    #[must_use]
    pub fn open(elements: Vec<Element>) -> Self {
        Self { elements }
    }

    /// Its elements.
    #[must_use]
    pub fn elements(&self) -> &[Element] {
        &self.elements
    }

    /// Whether it runs clockwise.
    #[must_use]
    pub fn is_clockwise(&self) -> bool {
        size(&self.elements) < 0.0
    }

    /// The same in the opposite direction.
    #[must_use]
    pub fn reversed(&self) -> Self {
        Self { elements: backwards(&self.elements) }
    }

    /// The same, turned about the origin by degrees.
    #[must_use]
    pub fn turned(&self, degrees: f64) -> Self {
        if degrees == 0.0 {
            return self.clone();
        }
        let of = |element: &Element| {
            let (from, to) = (turned_by(element.from, degrees), turned_by(element.to, degrees));
            let arc = element.arc.map(|arc| PlaneArc {
                center: turned_by(arc.center, degrees),
                start_angle: arc.start_angle + degrees.to_radians(),
                ..arc
            });
            Element { from, to, arc }
        };
        Self { elements: self.elements.iter().map(of).collect() }
    }

    /// It begins in the middle of its longest element, the first of several.
    #[must_use]
    pub fn from_longest(&self) -> Self {
        let longest = self.elements.iter().map(Element::length).fold(0.0, f64::max);
        // Lengths that differ by rounding are the same.
        let is_longest = |(_, element): &(usize, &Element)| element.length() > longest - NOISE;
        let Some((place, element)) = self.elements.iter().enumerate().find(is_longest) else { return self.clone() };
        let middle = at(element, 0.5);
        let mut elements = vec![piece(element, middle, element.to)];
        let rest = self.elements.iter().cycle().skip(place + 1).take(self.elements.len() - 1);
        elements.extend(rest.copied());
        elements.push(piece(element, element.from, middle));
        Self { elements }
    }

    /// The same with its corners rounded, by less where the pieces are too short.
    #[must_use]
    pub fn rounded(&self, radius: f64) -> Self {
        let mut pieces = self.elements.clone();
        let count = pieces.len();
        if radius < NOISE || count < 2 {
            return self.clone();
        }
        let mut between = vec![None; count];
        for place in 0..count {
            let next = (place + 1) % count;
            if let (Some(mut one), Some(mut other)) = (pieces.get(place).copied(), pieces.get(next).copied()) {
                let (made, _) = blend_reduced(&mut one, &mut other, CornerBlend::Round(radius));
                for (slot, piece) in [(place, one), (next, other)] {
                    pieces.splice(slot..=slot, [piece]);
                }
                between.splice(place..=place, [made]);
            }
        }
        let all = pieces.into_iter().zip(between).flat_map(|(piece, made)| std::iter::once(piece).chain(made));
        Self { elements: all.filter(|piece| piece.length() > NOISE).collect() }
    }

    /// The path beside it, to the left with a side of +1, to the right with −1; none where it does not fit.
    #[must_use]
    pub fn beside(&self, side: f64, amount: f64) -> Option<Self> {
        if amount < NOISE {
            return Some(self.clone());
        }
        shifted::rounded(&self.from_longest().elements, side, amount).map(|elements| Self { elements })
    }

    /// Whether every spot of it keeps away from contours by an amount.
    #[must_use]
    pub fn keeps_away(&self, contours: &[Self], amount: f64) -> bool {
        self.elements.iter().all(|element| is_clear(element, contours, amount))
    }

    /// Whether a spot lies inside.
    #[must_use]
    pub fn holds(&self, [along, across]: Spot) -> bool {
        crossings(self.elements.iter(), across).iter().filter(|place| **place < along).count() % 2 == 1
    }
}

/// A spot turned about the origin by degrees.
#[must_use]
pub fn turned_by([x, y]: Spot, degrees: f64) -> Spot {
    let [cosine, sine] = direction(degrees);
    [x * cosine - y * sine, x * sine + y * cosine]
}

fn piece(element: &Element, from: Spot, to: Spot) -> Element {
    let arc = element.arc.and_then(|arc| by_center(from, to, arc.center, arc.sweep < 0.0).ok());
    Element { from, to, arc }
}

/// Whether every spot of an element keeps away from contours by an amount.
#[must_use]
pub fn is_clear(element: &Element, contours: &[ClosedContour], amount: f64) -> bool {
    contours.iter().flat_map(|contour| &contour.elements).all(|other| nearest(element, other) >= amount - NEAR)
}

/// A straight cut.
pub type Cut = (Spot, Spot);

/// Cuts between closed paths, to and fro, at most `apart`; cuts that follow each other through room that is free make
/// one row. The paths are those of the middle of a tool. None where there would be too many.
#[must_use]
pub fn cuts(ways: &[ClosedContour], apart: f64, is_free: impl Fn(&Element) -> bool) -> Option<Vec<Vec<Cut>>> {
    let elements = || ways.iter().flat_map(|way| &way.elements);
    let (low, high) = heights(elements());
    let count = ((high - low) / apart).ceil();
    if !(count.is_finite() && apart > NOISE && count < MOST as f64) {
        return None;
    }
    let mut rows = Vec::<Vec<Cut>>::new();
    let count = count.max(1.0);
    for line in 1..count as usize {
        let height = low + (high - low) / count * line as f64;
        let mut open: Vec<Cut> = crossings(elements(), height)
            .as_chunks::<2>()
            .0
            .iter()
            .map(|[from, to]| ([*from, height], [*to, height]))
            .filter(|(from, to)| distance(*from, *to) > NOISE)
            .collect();
        // Rows that the cuts of this line continue.
        for row in &mut rows {
            let Some(&(_, last)) = row.last().filter(|(_, last)| (height - last[1]) <= (high - low) / count * 1.5)
            else {
                continue;
            };
            // To the end of a cut that is nearer, if nothing lies between.
            let ends = |&(from, to): &Cut| {
                let (near, far) = ((from, to), (to, from));
                if distance(last, from) <= distance(last, to) { [near, far] } else { [far, near] }
            };
            let joined = open.iter().enumerate().find_map(|(at, cut)| {
                let cut = ends(cut).into_iter().find(|(to, _)| is_free(&Element { from: last, to: *to, arc: None }))?;
                Some((at, cut))
            });
            if let Some((at, cut)) = joined {
                open.remove(at);
                row.push(cut);
            }
        }
        rows.extend(open.into_iter().map(|cut| vec![cut]));
    }
    Some(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(size: f64) -> ClosedContour {
        let spots = [[0.0, 0.0], [size, 0.0], [size, size], [0.0, size]];
        let sides = (0..4).map(|at| Element { from: spots[at], to: spots[(at + 1) % 4], arc: None });
        ClosedContour::new(sides.collect()).unwrap()
    }

    #[test]
    fn inside_and_outside_of_a_square() {
        let square = square(10.0);
        assert!(
            square.holds([5.0, 5.0])
                && square.holds([5.0, 0.0])
                && !square.holds([11.0, 5.0])
                && !square.holds([5.0, 10.0])
        );
        assert!(!square.is_clockwise() && square.reversed().is_clockwise());
        let inside = square.beside(1.0, 2.0).unwrap();
        assert!(inside.keeps_away(std::slice::from_ref(&square), 2.0));
        assert_eq!(inside.elements()[0].from, [5.0, 2.0]);
        assert_eq!(square.beside(1.0, 6.0), None);
        let outside = square.beside(-1.0, 2.0).unwrap();
        assert_eq!(outside.elements().iter().filter(|element| element.arc.is_some()).count(), 4);
        assert!(outside.keeps_away(&[square], 2.0));
    }

    #[test]
    fn a_small_island_beside_a_long_way_is_seen() {
        let way = Element { from: [0.0, 5.0], to: [500.0, 5.0], arc: None };
        let spots = [[7.2, 9.0], [8.4, 9.0], [8.4, 10.0], [7.2, 10.0]];
        let sides = (0..4).map(|at| Element { from: spots[at], to: spots[(at + 1) % 4], arc: None });
        let island = [ClosedContour::new(sides.collect()).unwrap()];
        assert!(is_clear(&way, &island, 4.0) && !is_clear(&way, &island, 4.1));
    }

    #[test]
    fn cuts_go_to_and_fro_and_round_an_island() {
        let rows = cuts(&[square(10.0)], 4.0, |_| true).unwrap();
        assert_eq!(rows.len(), 1);
        assert_eq!(rows[0].len(), 2);
        let island = ClosedContour::new(vec![
            Element { from: [4.0, 4.0], to: [6.0, 4.0], arc: None },
            Element { from: [6.0, 4.0], to: [6.0, 6.0], arc: None },
            Element { from: [6.0, 6.0], to: [4.0, 6.0], arc: None },
            Element { from: [4.0, 6.0], to: [4.0, 4.0], arc: None },
        ]);
        let rows = cuts(&[square(10.0), island.unwrap()], 1.0, |_| true).unwrap();
        assert_eq!(cuts(&[square(10.0)], 1e-4, |_| true), None);
        assert_eq!(rows.iter().map(Vec::len).sum::<usize>(), 9 + 2);
        // Without room between them every cut is a row of its own.
        assert_eq!(cuts(&[square(10.0)], 4.0, |_| false).unwrap().len(), 2);
    }
}
