//! How a tool clears an area: cuts along the first axis that follow each other along the rim, then paths along all
//! walls.
//!
//! Decisions: a cut continues with the next one above it where the rim leads there without going down; where it does
//! not, the tool begins again. A blank is cut from outside of it. *Invariant:* every element lies on a rim of the room
//! of the tool's centre, or within it.

use super::area::ClearingArea;
use super::closed::{ClosedContour, is_clear};
use super::crossing::{crossings, heights};
use super::element::{Element, Spot, distance};
use super::meet::meetings;
use super::near::{to_piece, turned};
use super::reach::{eroded, grown, near_left, of_two, remaining};
use super::shifted::shifted;

/// Spots that are the same.
const SAME: f64 = 1e-6;

/// Paths of a tool in an area.
#[derive(Debug, Clone, Default)]
pub struct Clearing {
    /// Along the walls, with the area on the left.
    ways: Vec<Vec<Element>>,
    /// Rims of where the middle of the tool may be.
    room: Vec<ClosedContour>,
    /// The blank that the tool enters from outside.
    blank: Option<ClosedContour>,
}

impl Clearing {
    /// With a tool whose middle keeps away from walls by an amount; none if it fits nowhere, or the walls have too many
    /// elements.
    #[must_use]
    pub fn of(area: &ClearingArea, by: f64) -> Option<Self> {
        let rings: Vec<ClosedContour> = area.rings.iter().map(|ring| ClosedContour::open(ring.clone())).collect();
        match area.beyond {
            Some(beyond) => Self::of_blank(area, (&rings, by), beyond),
            None => Self::of_pocket(area, &rings, by),
        }
    }

    fn of_pocket(area: &ClearingArea, rings: &[ClosedContour], by: f64) -> Option<Self> {
        if let Some((radius, away)) = area.earlier {
            let left = remaining(rings, away, by - away, radius)?;
            return Some(Self::round(left, None));
        }
        if let Some(ways) = plain(&area.rings, rings, by).filter(|ways| are_inside(ways, rings)) {
            let room = ways.iter().cloned().map(ClosedContour::open).collect();
            return Some(Self { ways, room, blank: None });
        }
        let room = eroded(rings, by).filter(|room| !room.is_empty())?;
        Some(Self::round(room, None))
    }

    fn of_blank(area: &ClearingArea, (rings, by): (&[ClosedContour], f64), beyond: f64) -> Option<Self> {
        let (blank, spigots) = rings.split_at_checked(1)?;
        let walls = area.rings.get(1..)?;
        let outside =
            |outer: &[ClosedContour], held: &[ClosedContour]| of_two(outer, held, |outer, held| outer && !held);
        let ways = match plain(walls, spigots, by) {
            Some(ways) => ways,
            None => grown(spigots, by)?.iter().map(|way| way.reversed().from_longest().elements().to_vec()).collect(),
        };
        let held: Vec<ClosedContour> = ways.iter().cloned().map(ClosedContour::open).collect();
        let room = outside(&grown(blank, beyond)?, &held)?;
        let blank_rim = blank.first().cloned();
        let Some((radius, away)) = area.earlier else { return Some(Self { ways, room, blank: blank_rim }) };
        let wanted = outside(blank, &if away > SAME { grown(spigots, away)? } else { spigots.to_vec() })?;
        let reached = outside(&grown(blank, beyond + 2.0 * radius)?, &grown(spigots, away + radius)?)?;
        let left = near_left(&wanted, (&reached, radius), (&room, by - away))?;
        Some(Self::round(left, blank_rim))
    }

    /// All around a room.
    fn round(room: Vec<ClosedContour>, blank: Option<ClosedContour>) -> Self {
        let ways = room.iter().map(|ring| ring.from_longest().elements().to_vec()).collect();
        Self { ways, room, blank }
    }

    /// Cuts that follow each other, not further apart than a step, of a number of lines at most.
    #[must_use]
    pub fn rows(&self, step: f64, most: u32) -> Vec<Vec<Element>> {
        let elements = || self.room.iter().flat_map(ClosedContour::elements);
        let (low, high) = heights(elements());
        if !(high > low && step > 0.0) {
            return Vec::new();
        }
        let count = ((high - low) / step - 1e-6).ceil().clamp(1.0, f64::from(most)) as u32;
        let mut rows: Vec<Vec<Element>> = Vec::new();
        // Rows that may continue, with the height of their last line.
        let mut going: Vec<usize> = Vec::new();
        let mut last = low;
        for number in 1..count {
            let height = low + (high - low) * f64::from(number) / f64::from(count);
            let places = crossings(elements(), height);
            let mut open: Vec<[Spot; 2]> =
                places.as_chunks::<2>().0.iter().map(|[from, to]| [[*from, height], [*to, height]]).collect();
            open.retain(|[from, to]| distance(*from, *to) > SAME);
            going.retain(|&at| rows.get_mut(at).is_some_and(|row| self.goes_on(row, &mut open, [last, height])));
            for [from, to] in open {
                let from_outside = self.is_outside(from) || !self.is_outside(to);
                let (from, to) = if from_outside { (from, to) } else { (to, from) };
                going.push(rows.len());
                rows.push(vec![Element { from, to, arc: None }]);
            }
            last = height;
        }
        rows
    }

    /// Goes on with a cut of the next line, if the rim leads there.
    fn goes_on(&self, row: &mut Vec<Element>, open: &mut Vec<[Spot; 2]>, heights: [f64; 2]) -> bool {
        let Some(here) = row.last().map(|cut| cut.to) else { return false };
        let Some(ring) = self.room.iter().find_map(|ring| begun_at(ring.elements(), here)) else { return false };
        let back: Vec<Element> = ring.iter().rev().map(turned).collect();
        for way in [ring, back] {
            let Some(link) = up_to(&way, heights) else { continue };
            let Some(arrived) = link.last().map(|element| element.to) else { continue };
            let cut = open.iter().position(|ends| ends.iter().any(|end| distance(*end, arrived) < SAME));
            if let Some([from, to]) = cut.map(|at| open.remove(at)) {
                let to = if distance(from, arrived) < SAME { to } else { from };
                row.extend(link);
                row.push(Element { from: arrived, to, arc: None });
                return true;
            }
        }
        false
    }

    fn is_outside(&self, spot: Spot) -> bool {
        self.blank.as_ref().is_some_and(|blank| !blank.holds(spot))
    }

    /// Paths along the walls; where cuts end at them, they begin there.
    #[must_use]
    pub fn ways(&self, rows: &[Vec<Element>]) -> Vec<Vec<Element>> {
        let begun = |way: &Vec<Element>| {
            let touched = ends(rows).find_map(|spot| begun_at(way, spot));
            touched.unwrap_or_else(|| way.clone())
        };
        self.ways.iter().map(begun).collect()
    }

    /// Where the tool goes down into the full.
    #[must_use]
    pub fn plunges(&self, rows: &[Vec<Element>]) -> Vec<Spot> {
        let untouched = self.ways.iter().filter(|way| !ends(rows).any(|spot| begun_at(way, spot).is_some()));
        let firsts = rows.iter().chain(untouched).filter_map(|row| row.first());
        firsts.map(|first| first.from).collect()
    }
}

/// A path from where a straight line to it meets it first; as it is where that does not.
#[must_use]
pub fn begun_where(way: &[Element], line: &Element) -> Vec<Element> {
    let spots = way.iter().flat_map(|piece| meetings(piece, line));
    let first = spots.min_by(|a, b| distance(line.from, *a).total_cmp(&distance(line.from, *b)));
    first.and_then(|spot| begun_at(way, spot)).unwrap_or_else(|| way.to_vec())
}

/// Ends of cuts.
fn ends(rows: &[Vec<Element>]) -> impl Iterator<Item = Spot> {
    rows.iter().flatten().flat_map(|cut| [cut.from, cut.to])
}

/// Paths beside all rings, if each keeps away from all walls.
fn plain(rings: &[Vec<Element>], walls: &[ClosedContour], by: f64) -> Option<Vec<Vec<Element>>> {
    let ways: Option<Vec<_>> = rings.iter().map(|ring| shifted(ring, 1.0, by)).collect();
    ways.filter(|ways| ways.iter().flatten().all(|piece| is_clear(piece, walls, by)))
}

/// Whether paths lie in the area: one that keeps its distance does not leave the area it begins in.
fn are_inside(ways: &[Vec<Element>], rings: &[ClosedContour]) -> bool {
    let inside = |spot: Spot| rings.iter().filter(|ring| ring.holds(spot)).count() % 2 == 1;
    ways.iter().all(|way| way.first().is_some_and(|first| inside(first.from)))
}

/// A ring from one of its points on.
fn begun_at(ring: &[Element], spot: Spot) -> Option<Vec<Element>> {
    let at = ring.iter().position(|piece| to_piece(piece, spot) < SAME)?;
    let piece = *ring.get(at)?;
    let others = ring.iter().cycle().skip(at + 1).take(ring.len() - 1).copied();
    if distance(piece.from, spot) < SAME {
        return Some(std::iter::once(piece).chain(others).collect());
    }
    if distance(piece.to, spot) < SAME {
        return Some(others.chain([piece]).collect());
    }
    let (first, rest) = (piece.between(spot, piece.to), piece.between(piece.from, spot));
    Some(std::iter::once(first).chain(others).chain([rest]).collect())
}

/// The first part of a path, up to where it reaches the second height; none if it goes below the first one before.
fn up_to(way: &[Element], [low, high]: [f64; 2]) -> Option<Vec<Element>> {
    let mut link = Vec::new();
    for element in way {
        let reached = crossings([element].into_iter(), high).into_iter().map(|place| [place, high]);
        let first = reached.min_by(|a, b| element.share(*a).total_cmp(&element.share(*b)));
        let part = first.map_or(*element, |spot| element.between(element.from, spot));
        if heights([&part].into_iter()).0 < low - SAME {
            return None;
        }
        if part.length() > SAME {
            link.push(part);
        }
        if first.is_some() {
            return Some(link);
        }
    }
    None
}

#[cfg(test)]
mod tests;
