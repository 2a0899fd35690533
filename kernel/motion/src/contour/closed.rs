//! Closed contours: beside them, between them, and straight cuts that clear what lies inside.
//!
//! Decisions: a way beside a contour goes round its corners on arcs; cuts run along the first axis. *Invariant:* a way that comes
//! nearer to any contour than it should is none, so what is not plain is refused, not guessed.

use super::element::{Element, NOISE, Spot, cross, direction, distance, dot, plus};
use super::shifted;
use crate::arc::{Arc, by_center};

/// Spots of an element that are looked at.
const LOOKS: u32 = 32;

/// How much nearer than it should a way may come.
const NEAR: f64 = 1e-5;

/// Most lines of cuts.
const MOST: usize = 10_000;

/// A closed contour.
#[derive(Debug, Clone, PartialEq)]
pub struct Closed {
    elements: Vec<Element>,
}

impl Closed {
    /// Of elements that follow each other; a gap between the end and the start is closed by a line. None for fewer than two.
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

    /// It runs clockwise.
    #[must_use]
    pub fn is_clockwise(&self) -> bool {
        let area = |element: &Element| {
            let chord = cross(element.from, element.to);
            let bow = element.arc.map_or(0.0, |arc| arc.radius * arc.radius * (arc.sweep - libm::sin(arc.sweep)));
            chord + bow
        };
        self.elements.iter().map(area).sum::<f64>() < 0.0
    }

    /// The same the other way round.
    #[must_use]
    pub fn reversed(&self) -> Self {
        Self { elements: self.elements.iter().rev().map(turned).collect() }
    }

    /// The same, turned about the origin by degrees.
    #[must_use]
    pub fn turned(&self, degrees: f64) -> Self {
        if degrees == 0.0 {
            return self.clone();
        }
        let of = |element: &Element| {
            let (from, to) = (turned_by(element.from, degrees), turned_by(element.to, degrees));
            let arc = element.arc.map(|arc| Arc {
                center: turned_by(arc.center, degrees),
                start_angle: arc.start_angle + degrees.to_radians(),
                ..arc
            });
            Element { from, to, arc }
        };
        Self { elements: self.elements.iter().map(of).collect() }
    }

    /// It begins in the middle of its longest element.
    #[must_use]
    pub fn from_longest(&self) -> Self {
        let longest = self.elements.iter().enumerate().rev().max_by(|a, b| a.1.length().total_cmp(&b.1.length()));
        let Some((at, element)) = longest else { return self.clone() };
        let middle = spot(element, 0.5);
        let mut elements = vec![piece(element, middle, element.to)];
        let rest = self.elements.iter().cycle().skip(at + 1).take(self.elements.len() - 1);
        elements.extend(rest.copied());
        elements.push(piece(element, element.from, middle));
        Self { elements }
    }

    /// The way beside it, to the left with a side of +1, to the right with −1; none where it does not fit.
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

    /// Where a line along the first axis crosses it.
    fn crossings(&self, height: f64, into: &mut Vec<f64>) {
        for element in &self.elements {
            match &element.arc {
                None => {
                    let (a, b) = (element.from[1], element.to[1]);
                    if (a > height) != (b > height) {
                        into.push(element.from[0] + (element.to[0] - element.from[0]) * (height - a) / (b - a));
                    }
                }
                Some(arc) => {
                    let off = height - arc.center[1];
                    let half = arc.radius * arc.radius - off * off;
                    if half <= 0.0 {
                        continue;
                    }
                    for way in [half.sqrt(), -half.sqrt()] {
                        let share = element.share([arc.center[0] + way, height]);
                        if (0.0..1.0).contains(&share) {
                            into.push(arc.center[0] + way);
                        }
                    }
                }
            }
        }
    }

    fn heights(&self) -> (f64, f64) {
        let mut range = (f64::INFINITY, f64::NEG_INFINITY);
        let mut note = |height: f64| range = (range.0.min(height), range.1.max(height));
        for element in &self.elements {
            note(element.from[1]);
            if let Some(arc) = &element.arc {
                for way in [arc.radius, -arc.radius] {
                    let share = element.share([arc.center[0], arc.center[1] + way]);
                    if (0.0..=1.0).contains(&share) {
                        note(arc.center[1] + way);
                    }
                }
            }
        }
        range
    }
}

/// A spot turned about the origin by degrees.
#[must_use]
pub fn turned_by([x, y]: Spot, degrees: f64) -> Spot {
    let [cosine, sine] = direction(degrees);
    [x * cosine - y * sine, x * sine + y * cosine]
}

fn turned(element: &Element) -> Element {
    let arc = element.arc.map(|arc| Arc { start_angle: arc.start_angle + arc.sweep, sweep: -arc.sweep, ..arc });
    Element { from: element.to, to: element.from, arc }
}

fn piece(element: &Element, from: Spot, to: Spot) -> Element {
    let arc = element.arc.and_then(|arc| by_center(from, to, arc.center, arc.sweep < 0.0).ok());
    Element { from, to, arc }
}

/// The spot of an element at a share of its way.
fn spot(element: &Element, share: f64) -> Spot {
    match &element.arc {
        None => plus(element.from, plus(element.to, element.from, -1.0), share),
        Some(arc) => {
            let angle = arc.start_angle + arc.sweep * share;
            plus(arc.center, [libm::cos(angle), libm::sin(angle)], arc.radius)
        }
    }
}

/// How far a spot is from an element.
fn away(element: &Element, at: Spot) -> f64 {
    let ends = distance(element.from, at).min(distance(element.to, at));
    let share = match &element.arc {
        None => {
            let along = plus(element.to, element.from, -1.0);
            dot(plus(at, element.from, -1.0), along) / dot(along, along)
        }
        Some(_) => element.share(at),
    };
    if !(0.0..=1.0).contains(&share) {
        return ends;
    }
    match &element.arc {
        None => distance(spot(element, share), at),
        Some(arc) => (distance(arc.center, at) - arc.radius).abs(),
    }
}

/// Whether every spot of an element keeps away from contours by an amount.
#[must_use]
pub fn is_clear(element: &Element, contours: &[Closed], amount: f64) -> bool {
    (0..=LOOKS).all(|look| is_away(spot(element, f64::from(look) / f64::from(LOOKS)), contours, amount))
}

fn is_away(at: Spot, contours: &[Closed], amount: f64) -> bool {
    contours.iter().all(|contour| contour.elements.iter().all(|element| away(element, at) >= amount - NEAR))
}

/// A straight cut.
pub type Cut = (Spot, Spot);

/// Cuts between closed ways, to and fro, at most `apart`; cuts that follow each other through free room make one row. The ways are
/// those of the middle of a tool. None where there would be too many.
#[must_use]
pub fn cuts(ways: &[Closed], apart: f64) -> Option<Vec<Vec<Cut>>> {
    let ranges = ways.iter().map(Closed::heights);
    let (low, high) = ranges.fold((f64::INFINITY, f64::NEG_INFINITY), |all, own| (all.0.min(own.0), all.1.max(own.1)));
    let count = ((high - low) / apart).ceil();
    if !(count.is_finite() && apart > NOISE && count < MOST as f64) {
        return None;
    }
    let (mut rows, mut crossings) = (Vec::<Vec<Cut>>::new(), Vec::new());
    let count = count.max(1.0);
    for line in 1..count as usize {
        let height = low + (high - low) / count * line as f64;
        crossings.clear();
        for way in ways {
            way.crossings(height, &mut crossings);
        }
        crossings.sort_by(f64::total_cmp);
        let mut open: Vec<Cut> = crossings
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
                let cut = ends(cut).into_iter().find(|(from, _)| is_free(last, *from, ways))?;
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

/// Nothing of the ways lies between two spots on them.
fn is_free(from: Spot, to: Spot, ways: &[Closed]) -> bool {
    let looks = (1..LOOKS).map(|look| plus(from, plus(to, from, -1.0), f64::from(look) / f64::from(LOOKS)));
    looks.into_iter().all(|at| {
        let mut crossings = Vec::new();
        for way in ways {
            way.crossings(at[1], &mut crossings);
        }
        let near = ways.iter().any(|way| way.elements.iter().any(|element| away(element, at) < NEAR));
        near || !crossings.iter().filter(|crossing| **crossing > at[0]).count().is_multiple_of(2)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(size: f64) -> Closed {
        let spots = [[0.0, 0.0], [size, 0.0], [size, size], [0.0, size]];
        let sides = (0..4).map(|at| Element { from: spots[at], to: spots[(at + 1) % 4], arc: None });
        Closed::new(sides.collect()).unwrap()
    }

    #[test]
    fn inside_and_outside_of_a_square() {
        let square = square(10.0);
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
    fn cuts_go_to_and_fro_and_round_an_island() {
        let rows = cuts(&[square(10.0)], 4.0).unwrap();
        assert_eq!(rows.len(), 1);
        assert_eq!(rows[0].len(), 2);
        let island = Closed::new(vec![
            Element { from: [4.0, 4.0], to: [6.0, 4.0], arc: None },
            Element { from: [6.0, 4.0], to: [6.0, 6.0], arc: None },
            Element { from: [6.0, 6.0], to: [4.0, 6.0], arc: None },
            Element { from: [4.0, 6.0], to: [4.0, 4.0], arc: None },
        ]);
        let rows = cuts(&[square(10.0), island.unwrap()], 1.0).unwrap();
        assert_eq!(cuts(&[square(10.0)], 1e-4), None);
        assert_eq!(rows.iter().map(Vec::len).sum::<usize>(), 9 + 2);
    }
}
