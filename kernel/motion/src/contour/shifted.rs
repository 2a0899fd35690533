//! A contour moved perpendicular to itself.
//!
//! *Invariant:* the pieces of the result follow each other without gaps. Where a piece is too small for the amount, or
//! its neighbours would meet before it, there is none.

use std::f64::consts::TAU;

use super::corner::{Link, Offset};
use super::element::{Element, NOISE, Spot, distance};
use crate::arc::{PlaneArc, by_center};

/// The contour moved perpendicular to itself: to the left with a side of +1, to the right with −1. Outside corners stay
/// sharp.
#[must_use]
pub fn shifted(contour: &[Element], side: f64, amount: f64) -> Option<Vec<Element>> {
    beside(contour, Offset { side, radius: amount, corner: 1, limit: -1.0, shape: None })
}

/// The same with arcs around the corners outside.
#[must_use]
pub fn rounded(contour: &[Element], side: f64, amount: f64) -> Option<Vec<Element>> {
    beside(contour, Offset { side, radius: amount, corner: 2, limit: -1.0, shape: None })
}

/// A path between two pieces.
fn of_link(here: Spot, link: Link) -> Element {
    match link {
        Link::Line(to) => Element { from: here, to, arc: None },
        Link::Round { to, center, clockwise } => {
            Element { from: here, to, arc: by_center(here, to, center, clockwise).ok() }
        }
    }
}

fn beside(contour: &[Element], offset: Offset) -> Option<Vec<Element>> {
    let (side, amount) = (offset.side, offset.radius);
    let mut moved = Vec::with_capacity(contour.len());
    let mut here = offset.at_start(contour.first()?);
    let mut pieces = contour.iter().peekable();
    while let Some(piece) = pieces.next() {
        if piece.is_too_small(side, amount) {
            return None;
        }
        let (end, links) = match pieces.peek() {
            None => (offset.at_end(piece), Vec::new()),
            Some(next) => {
                let corner = offset.between(piece, next, here);
                if corner.hurts {
                    return None;
                }
                (corner.end, corner.links)
            }
        };
        let arc = piece.arc.map(|arc| {
            let radius = piece.offset_radius(side, amount).unwrap_or(arc.radius);
            PlaneArc { radius, ..Element { arc: Some(arc), ..*piece }.between(here, end).arc.unwrap_or(arc) }
        });
        // A whole circle ends where it begins.
        if distance(here, end) > NOISE || arc.is_some_and(|arc| arc.sweep.abs() > TAU - 1e-9) {
            moved.push(Element { from: here, to: end, arc });
        }
        here = end;
        for link in links {
            let way = of_link(here, link);
            if distance(here, way.to) > NOISE {
                moved.push(way);
            }
            here = way.to;
        }
    }
    Some(moved)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_whole_circle_stays_one() {
        let circle = by_center([20.0, 0.0], [20.0, 0.0], [0.0, 0.0], false).ok();
        let moved = rounded(&[Element { from: [20.0, 0.0], to: [20.0, 0.0], arc: circle }], 1.0, 4.0).unwrap();
        assert_eq!((moved.len(), moved[0].from), (1, [16.0, 0.0]));
        assert_eq!(moved[0].arc.unwrap().sweep, TAU);
    }
}
