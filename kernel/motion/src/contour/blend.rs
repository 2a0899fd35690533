//! Chamfers and roundings between two pieces of a contour.
//!
//! A blend shortens both pieces and puts a line or an arc between them. The legs of a chamfer are measured straight
//! from the corner, also on an arc. *Invariant:* a blend takes no more of a piece than there is of it, and the end of
//! each element is the start of the next. Facts: reference turning-cycles.md 7, siemens-cycles.md (RND, CHF, CHR).

use std::f64::consts::TAU;

use super::corner::Offset;
use super::element::{Element, NOISE, Spot, angle, cross, distance, dot, plus};
use crate::arc::PlaneArc;

/// Shape of a corner, in length units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CornerBlend {
    /// A chamfer that takes this much of each piece.
    Legs(f64),
    /// A chamfer of this length.
    Face(f64),
    /// An arc of this radius that touches both pieces.
    Round(f64),
}

impl CornerBlend {
    /// Its length or radius.
    #[must_use]
    pub fn size(self) -> f64 {
        match self {
            Self::Legs(size) | Self::Face(size) | Self::Round(size) => size,
        }
    }

    fn times(self, factor: f64) -> Self {
        match self {
            Self::Legs(size) => Self::Legs(size * factor),
            Self::Face(size) => Self::Face(size * factor),
            Self::Round(size) => Self::Round(size * factor),
        }
    }
}

/// The cut takes more of a piece than there is of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the corner is larger than its pieces")]
pub struct TooLong;

/// Shortens two pieces that meet and gives the element between them; none where they continue in one direction.
///
/// # Errors
/// [`TooLong`]: the pieces remain as they were.
pub fn blend(first: &mut Element, second: &mut Element, cut: CornerBlend) -> Result<Option<Element>, TooLong> {
    if !has_corner(first, second) {
        return Ok(None);
    }
    let between = element(first, second, cut).ok_or(TooLong)?;
    shorten(first, second, &between);
    Ok(Some(between))
}

/// The same, with a smaller cut where the pieces are too short for it; whether it is smaller.
pub fn blend_reduced(first: &mut Element, second: &mut Element, cut: CornerBlend) -> (Option<Element>, bool) {
    if let Ok(made) = blend(first, second, cut) {
        return (made, false);
    }
    let (mut fits, mut large) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = (fits + large) / 2.0;
        let place = if element(first, second, cut.times(middle)).is_some() { &mut fits } else { &mut large };
        *place = middle;
    }
    let made = element(first, second, cut.times(fits)).filter(|made| made.length() > NOISE);
    if let Some(made) = &made {
        shorten(first, second, made);
    }
    (made, true)
}

/// The elements of a contour whose pieces may have a cut at their end.
///
/// # Errors
/// The piece whose cut does not fit, or has no piece after it.
pub fn resolve(pieces: &[(Element, Option<CornerBlend>)]) -> Result<Vec<Element>, usize> {
    let mut made: Vec<Element> = Vec::with_capacity(pieces.len());
    let mut due = None;
    for (at, (piece, cut)) in pieces.iter().enumerate() {
        let mut next = *piece;
        if let (Some(cut), Some(last)) = (due, made.last_mut()) {
            let between = blend(last, &mut next, cut).map_err(|TooLong| at - 1)?;
            if last.length() < NOISE {
                made.pop();
            }
            made.extend(between);
        }
        made.push(next);
        due = *cut;
    }
    if due.is_some() {
        return Err(pieces.len().saturating_sub(1));
    }
    made.retain(|element| element.length() >= NOISE);
    Ok(made)
}

/// Whether two pieces meet at an angle.
fn has_corner(first: &Element, second: &Element) -> bool {
    let (before, after) = (first.end(), second.start());
    cross(before, after).abs() > 1e-9 || dot(before, after) < 0.0
}

/// The element that cuts the corner off, if it fits.
fn element(first: &Element, second: &Element, cut: CornerBlend) -> Option<Element> {
    let (before, after) = (first.end(), second.start());
    let legs = match cut {
        CornerBlend::Round(radius) => return round(first, second, radius),
        CornerBlend::Legs(legs) => legs,
        // The angle between the pieces is 180 degrees less the turn.
        CornerBlend::Face(face) => face / (2.0 * ((1.0 + dot(before, after)) / 2.0).max(0.0).sqrt()),
    };
    let made = Element { from: back(first, legs)?, to: ahead(second, legs)?, arc: None };
    (made.length() > NOISE).then_some(made)
}

/// The arc whose centre is inside of the corner at a distance of its radius from both pieces.
fn round(first: &Element, second: &Element, radius: f64) -> Option<Element> {
    let side = cross(first.end(), second.start()).signum();
    let offset = Offset { side, radius, corner: 0, limit: 0.0, shape: None };
    let touches = |center: Spot| Some((foot(first, center)?, foot(second, center)?));
    let centers = offset.crossings(first, second).into_iter().flatten();
    let near = |a: &Spot, b: &Spot| distance(*a, first.to).total_cmp(&distance(*b, first.to));
    let center = centers.filter(|spot| touches(*spot).is_some()).min_by(near)?;
    let (from, to) = touches(center)?;
    let start_angle = angle(center, from);
    let sweep = ((angle(center, to) - start_angle) * side).rem_euclid(TAU) * side;
    let arc = PlaneArc { center, radius, start_angle, sweep };
    (sweep.abs() > 1e-9).then_some(Element { from, to, arc: Some(arc) })
}

/// Where a piece is touched by a circle about a centre; none beyond its ends.
fn foot(element: &Element, center: Spot) -> Option<Spot> {
    let spot = match &element.arc {
        None => {
            let along = element.start();
            plus(element.from, along, dot(plus(center, element.from, -1.0), along))
        }
        Some(arc) => {
            let by = plus(center, arc.center, -1.0);
            let length = distance(center, arc.center);
            if length < NOISE {
                return None;
            }
            plus(arc.center, by, arc.radius / length)
        }
    };
    let slack = 1e-9 / element.length();
    let share = element.share(spot);
    (share >= -slack && share <= 1.0 + slack).then_some(spot)
}

/// The spot of a piece that is this far from its end.
fn back(element: &Element, by: f64) -> Option<Spot> {
    match &element.arc {
        None => (by <= element.length() + 1e-9).then(|| plus(element.to, element.end(), -by)),
        Some(arc) => chord(arc, arc.start_angle + arc.sweep, by, -1.0),
    }
}

/// The spot of a piece that is this far from its start.
fn ahead(element: &Element, by: f64) -> Option<Spot> {
    match &element.arc {
        None => (by <= element.length() + 1e-9).then(|| plus(element.from, element.start(), by)),
        Some(arc) => chord(arc, arc.start_angle, by, 1.0),
    }
}

/// The spot of an arc whose chord from an angle has this length.
fn chord(arc: &PlaneArc, from: f64, length: f64, way: f64) -> Option<Spot> {
    let half = length / (2.0 * arc.radius);
    if half > 1.0 {
        return None;
    }
    let turn = 2.0 * libm::asin(half);
    if turn > arc.sweep.abs() + 1e-9 {
        return None;
    }
    let at = from + way * arc.sweep.signum() * turn;
    Some(plus(arc.center, [libm::cos(at), libm::sin(at)], arc.radius))
}

/// Both pieces end where the element between them has its ends.
fn shorten(first: &mut Element, second: &mut Element, between: &Element) {
    *first = first.between(first.from, between.from);
    *second = second.between(between.to, second.to);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arc::by_center;

    fn line(from: Spot, to: Spot) -> Element {
        Element { from, to, arc: None }
    }

    fn near(a: Spot, b: Spot) {
        assert!(distance(a, b) < 1e-9, "{a:?} {b:?}");
    }

    #[test]
    fn chamfers_and_roundings_between_lines() {
        let pieces = || (line([0.0, 0.0], [40.0, 0.0]), line([40.0, 0.0], [40.0, 30.0]));
        for (cut, from, to) in [
            (CornerBlend::Round(5.0), [35.0, 0.0], [40.0, 5.0]),
            (CornerBlend::Legs(4.0), [36.0, 0.0], [40.0, 4.0]),
            (CornerBlend::Face(4.0), [40.0 - 8.0_f64.sqrt(), 0.0], [40.0, 8.0_f64.sqrt()]),
        ] {
            let (mut first, mut second) = pieces();
            let between = blend(&mut first, &mut second, cut).unwrap().unwrap();
            near(between.from, from);
            near(between.to, to);
            assert_eq!((first.to, second.from), (between.from, between.to));
        }
        let (mut first, mut second) = pieces();
        let arc = blend(&mut first, &mut second, CornerBlend::Round(5.0)).unwrap().unwrap().arc.unwrap();
        near(arc.center, [35.0, 5.0]);
        assert!(arc.sweep > 0.0);
    }

    #[test]
    fn a_line_and_an_arc() {
        // Right along X into a clockwise half circle about (20,0) from (10,0): the corner turns left.
        let mut first = line([0.0, 0.0], [10.0, 0.0]);
        let arc = by_center([10.0, 0.0], [30.0, 0.0], [20.0, 0.0], true).unwrap();
        let mut second = Element { from: [10.0, 0.0], to: [30.0, 0.0], arc: Some(arc) };
        let between = blend(&mut first, &mut second, CornerBlend::Round(2.0)).unwrap().unwrap();
        // Two above the line and twelve from the centre of the half circle.
        near(between.arc.unwrap().center, [20.0 - 140.0_f64.sqrt(), 2.0]);
        near(first.to, [20.0 - 140.0_f64.sqrt(), 0.0]);
        assert!((distance(second.from, [20.0, 0.0]) - 10.0).abs() < 1e-9);
        assert!(second.length() < 10.0 * std::f64::consts::PI && (second.arc.unwrap().radius - 10.0).abs() < 1e-12);
    }

    #[test]
    fn no_more_than_there_is() {
        let (mut first, mut second) = (line([0.0, 0.0], [3.0, 0.0]), line([3.0, 0.0], [3.0, 30.0]));
        assert_eq!(blend(&mut first, &mut second, CornerBlend::Round(5.0)), Err(TooLong));
        let (made, reduced) = blend_reduced(&mut first, &mut second, CornerBlend::Round(5.0));
        assert!(reduced && (made.unwrap().arc.unwrap().radius - 3.0).abs() < 1e-8 && first.length() < 1e-7);
        let mut straight = (line([0.0, 0.0], [3.0, 0.0]), line([3.0, 0.0], [6.0, 0.0]));
        assert_eq!(blend(&mut straight.0, &mut straight.1, CornerBlend::Legs(1.0)), Ok(None));
        let mut back = (line([0.0, 0.0], [3.0, 0.0]), line([3.0, 0.0], [0.0, 0.0]));
        assert_eq!(blend(&mut back.0, &mut back.1, CornerBlend::Round(1.0)), Err(TooLong));
    }

    #[test]
    fn a_contour_is_resolved_to_plain_elements() {
        let square = [
            (line([0.0, 0.0], [10.0, 0.0]), Some(CornerBlend::Legs(10.0))),
            (line([10.0, 0.0], [10.0, 20.0]), Some(CornerBlend::Round(2.0))),
            (line([10.0, 20.0], [0.0, 20.0]), None),
        ];
        let made = resolve(&square).unwrap();
        // The chamfer takes the first line whole.
        assert_eq!(made.len(), 4);
        near(made[0].from, [0.0, 0.0]);
        made.windows(2).for_each(|pair| near(pair[0].to, pair[1].from));
        assert_eq!(resolve(&square[..1]), Err(0));
    }
}
