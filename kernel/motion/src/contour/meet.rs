//! Where two pieces of contours meet: crossings, touches, and ends of one on the other.
//!
//! Invariant: returned points lie on both pieces; pieces on top of each other give the ends of their common part.

use std::f64::consts::TAU;

use super::element::{Element, NOISE, Spot, angle, distance, dot, plus};
use super::near::to_piece;
use crate::arc::PlaneArc;

/// Spots that are nearer than this are one.
pub(super) const SAME: f64 = 1e-6;

/// Spots of both pieces.
pub(super) fn meetings(a: &Element, b: &Element) -> Vec<Spot> {
    let ends = [(b.from, a), (b.to, a), (a.from, b), (a.to, b)];
    let mut spots: Vec<Spot> =
        ends.into_iter().filter(|(spot, piece)| to_piece(piece, *spot) < SAME).map(|(spot, _)| spot).collect();
    let crossings = match (&a.arc, &b.arc) {
        (None, None) => lines(a, b),
        (None, Some(arc)) => line_and_circle(a, arc),
        (Some(arc), None) => line_and_circle(b, arc),
        (Some(one), Some(other)) => circles(one, other),
    };
    spots.extend(crossings.into_iter().filter(|spot| on(a, *spot) && on(b, *spot)));
    spots
}

/// Whether a spot of the line or circle is one of the piece.
fn on(piece: &Element, spot: Spot) -> bool {
    match &piece.arc {
        None => (0.0..=1.0).contains(&piece.share(spot)),
        Some(arc) => {
            ((angle(arc.center, spot) - arc.start_angle) * arc.sweep.signum()).rem_euclid(TAU) <= arc.sweep.abs()
        }
    }
}

fn lines(a: &Element, b: &Element) -> Vec<Spot> {
    let (along, other) = (a.start(), b.start());
    let by = super::element::cross(along, other);
    if by.abs() < 1e-12 {
        return Vec::new();
    }
    vec![plus(a.from, along, super::element::cross(plus(b.from, a.from, -1.0), other) / by)]
}

fn line_and_circle(line: &Element, arc: &PlaneArc) -> Vec<Spot> {
    let along = line.start();
    let foot = plus(line.from, along, dot(plus(arc.center, line.from, -1.0), along));
    let off = distance(foot, arc.center);
    let half = arc.radius * arc.radius - off * off;
    // A tangent touches once.
    if (off - arc.radius).abs() < NOISE {
        return vec![foot];
    }
    if half < 0.0 {
        return Vec::new();
    }
    vec![plus(foot, along, half.sqrt()), plus(foot, along, -half.sqrt())]
}

fn circles(a: &PlaneArc, b: &PlaneArc) -> Vec<Spot> {
    let way = plus(b.center, a.center, -1.0);
    let off = distance(way, [0.0; 2]);
    if off < NOISE {
        return Vec::new();
    }
    let along = way.map(|part| part / off);
    let foot = (off * off + a.radius * a.radius - b.radius * b.radius) / (2.0 * off);
    let spot = plus(a.center, along, foot);
    let touches = |sum: f64| (off - sum).abs() < NOISE;
    if touches(a.radius + b.radius) || touches((a.radius - b.radius).abs()) {
        return vec![spot];
    }
    let half = a.radius * a.radius - foot * foot;
    if half < 0.0 {
        return Vec::new();
    }
    let across = [-along[1], along[0]];
    vec![plus(spot, across, half.sqrt()), plus(spot, across, -half.sqrt())]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(from: Spot, to: Spot) -> Element {
        Element { from, to, arc: None }
    }

    fn circle(center: Spot, radius: f64) -> Element {
        let from = plus(center, [radius, 0.0], 1.0);
        Element { from, to: from, arc: Some(PlaneArc { center, radius, start_angle: 0.0, sweep: TAU }) }
    }

    #[test]
    fn lines_and_circles_meet() {
        assert_eq!(meetings(&line([0.0, 0.0], [10.0, 0.0]), &line([4.0, -1.0], [4.0, 1.0])), [[4.0, 0.0]]);
        assert!(meetings(&line([0.0, 0.0], [10.0, 0.0]), &line([4.0, 1.0], [4.0, 2.0])).is_empty());
        assert_eq!(meetings(&line([-9.0, 3.0], [9.0, 3.0]), &circle([0.0, 0.0], 5.0)), [[4.0, 3.0], [-4.0, 3.0]]);
        assert_eq!(meetings(&circle([0.0, 0.0], 5.0), &circle([8.0, 0.0], 5.0)), [[4.0, 3.0], [4.0, -3.0]]);
        // Touching from outside, and on top of each other.
        assert_eq!(meetings(&circle([0.0, 0.0], 5.0), &circle([0.0, 8.0], 3.0)), [[0.0, 5.0]]);
        let common = meetings(&line([0.0, 0.0], [10.0, 0.0]), &line([12.0, 0.0], [4.0, 0.0]));
        assert_eq!(common, [[4.0, 0.0], [10.0, 0.0]]);
    }
}
