//! Distances of pieces of contours from points and from each other, exact for lines and arcs.
//!
//! Invariant: nothing is sampled, so thin or short parts are not overlooked.

use std::f64::consts::TAU;

use super::element::{Element, NOISE, Spot, angle, cross, distance, plus};
use crate::arc::PlaneArc;

/// A spot of a piece by its share.
pub(super) fn at(piece: &Element, share: f64) -> Spot {
    match &piece.arc {
        None => plus(piece.from, plus(piece.to, piece.from, -1.0), share),
        Some(arc) => on(arc, arc.start_angle + arc.sweep * share),
    }
}

/// A spot of the circle of an arc.
pub(super) fn on(arc: &PlaneArc, angle: f64) -> Spot {
    plus(arc.center, [libm::cos(angle), libm::sin(angle)], arc.radius)
}

/// Distance of a point from a piece.
pub(super) fn to_piece(piece: &Element, spot: Spot) -> f64 {
    let ends = distance(piece.from, spot).min(distance(piece.to, spot));
    let beside = match &piece.arc {
        None => {
            let share = piece.share(spot);
            (0.0..=1.0).contains(&share).then(|| distance(at(piece, share), spot))
        }
        Some(arc) => {
            let way = ((angle(arc.center, spot) - arc.start_angle) * arc.sweep.signum()).rem_euclid(TAU);
            (way <= arc.sweep.abs()).then(|| (distance(arc.center, spot) - arc.radius).abs())
        }
    };
    beside.map_or(ends, |beside| beside.min(ends))
}

/// Whether a direction from the centre of an arc is one of the arc.
fn has(arc: &PlaneArc, direction: Spot) -> bool {
    let way = ((angle([0.0; 2], direction) - arc.start_angle) * arc.sweep.signum()).rem_euclid(TAU);
    way <= arc.sweep.abs() + 1e-12
}

/// A piece in the opposite direction.
pub(super) fn turned(piece: &Element) -> Element {
    let arc = piece.arc.map(|arc| PlaneArc { start_angle: arc.start_angle + arc.sweep, sweep: -arc.sweep, ..arc });
    Element { from: piece.to, to: piece.from, arc }
}

/// Distance of two pieces, 0 if they cross.
pub(super) fn nearest(a: &Element, b: &Element) -> f64 {
    let ends = [to_piece(a, b.from), to_piece(a, b.to), to_piece(b, a.from), to_piece(b, a.to)];
    let ends = ends.into_iter().fold(f64::INFINITY, f64::min);
    let between = match (&a.arc, &b.arc) {
        (None, None) => {
            let side = |of: &Element, spot: Spot| cross(plus(of.to, of.from, -1.0), plus(spot, of.from, -1.0));
            let parts = |of: &Element, other: &Element| side(of, other.from) * side(of, other.to) < 0.0;
            if parts(a, b) && parts(b, a) { 0.0 } else { f64::INFINITY }
        }
        (None, Some(arc)) => line_and_arc(a, arc),
        (Some(arc), None) => line_and_arc(b, arc),
        (Some(one), Some(other)) => arcs(one, other),
    };
    ends.min(between)
}

/// Distance of a line and an arc between the ends of both.
fn line_and_arc(line: &Element, arc: &PlaneArc) -> f64 {
    let share = line.share(arc.center);
    let foot = at(line, share);
    let way = plus(foot, arc.center, -1.0);
    let off = distance(way, [0.0; 2]);
    let mut least = f64::INFINITY;
    if (0.0..=1.0).contains(&share) && off > NOISE && has(arc, way) {
        least = (off - arc.radius).abs();
    }
    let half = arc.radius * arc.radius - off * off;
    if half > 0.0 {
        let along = line.start();
        for half in [half.sqrt(), -half.sqrt()] {
            let spot = plus(foot, along, half);
            if (0.0..=1.0).contains(&line.share(spot)) && has(arc, plus(spot, arc.center, -1.0)) {
                least = 0.0;
            }
        }
    }
    least
}

/// Distance of two arcs between the ends of both.
fn arcs(a: &PlaneArc, b: &PlaneArc) -> f64 {
    let way = plus(b.center, a.center, -1.0);
    let off = distance(way, [0.0; 2]);
    if off < NOISE {
        return f64::INFINITY;
    }
    let along = way.map(|part| part / off);
    let mut least = f64::INFINITY;
    for (first, second) in [(1.0, -1.0), (1.0, 1.0), (-1.0, -1.0), (-1.0, 1.0)] {
        let [one, other] = [first, second].map(|side| along.map(|part| part * side));
        if has(a, one) && has(b, other) {
            let spots = (plus(a.center, one, a.radius), plus(b.center, other, b.radius));
            least = least.min(distance(spots.0, spots.1));
        }
    }
    // Where the circles meet.
    let foot = (off * off + a.radius * a.radius - b.radius * b.radius) / (2.0 * off);
    let half = a.radius * a.radius - foot * foot;
    if half > 0.0 {
        let [x, y] = along;
        for half in [half.sqrt(), -half.sqrt()] {
            let spot = plus(plus(a.center, along, foot), [-y, x], half);
            if has(a, plus(spot, a.center, -1.0)) && has(b, plus(spot, b.center, -1.0)) {
                least = 0.0;
            }
        }
    }
    least
}
