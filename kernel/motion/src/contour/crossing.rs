//! Where lines along the first axis cross pieces of contours.
//!
//! Invariant: a line crosses a closed contour an even number of times, corners on the line included.

use std::f64::consts::PI;

use super::element::{Element, Spot};
use super::near::on;

/// A part of a piece that only rises or only falls.
#[derive(Debug, Clone, Copy)]
struct Monotone {
    low: Spot,
    high: Spot,
    /// Centre, radius, and the side of the centre on which it lies.
    round: Option<(Spot, f64, f64)>,
}

fn monotone(piece: &Element) -> Vec<Monotone> {
    let part = |from: Spot, to: Spot, round| {
        let (low, high) = if from[1] <= to[1] { (from, to) } else { (to, from) };
        Monotone { low, high, round }
    };
    let Some(arc) = &piece.arc else { return vec![part(piece.from, piece.to, None)] };
    let (begin, end) = (arc.start_angle, arc.start_angle + arc.sweep);
    let (least, most) = (begin.min(end), begin.max(end));
    let mut angles = vec![least];
    let mut turn = ((least - PI / 2.0) / PI).ceil() * PI + PI / 2.0;
    while turn < most {
        if turn > least {
            angles.push(turn);
        }
        turn += PI;
    }
    angles.push(most);
    let spot = |angle: f64| match angle {
        angle if angle == begin => piece.from,
        angle if angle == end => piece.to,
        angle => on(arc, angle),
    };
    let pairs = angles.windows(2).filter_map(|pair| Some((*pair.first()?, *pair.get(1)?)));
    pairs
        .map(|(from, to)| {
            let side = libm::cos(f64::midpoint(from, to)).signum();
            part(spot(from), spot(to), Some((arc.center, arc.radius, side)))
        })
        .collect()
}

/// Where pieces cross a line along the first axis, in order.
pub(super) fn crossings<'e>(pieces: impl Iterator<Item = &'e Element>, across: f64) -> Vec<f64> {
    let mut places: Vec<f64> = pieces
        .flat_map(monotone)
        // A corner on the line belongs to the piece above it.
        .filter(|part| part.low[1] <= across && across < part.high[1])
        .map(|part| match part.round {
            None => {
                let share = (across - part.low[1]) / (part.high[1] - part.low[1]);
                part.low[0] + (part.high[0] - part.low[0]) * share
            }
            Some((center, radius, side)) => {
                let off = across - center[1];
                center[0] + side * (radius * radius - off * off).max(0.0).sqrt()
            }
        })
        .collect();
    places.sort_by(f64::total_cmp);
    places
}

/// The lowest and the highest second coordinate of pieces.
pub(super) fn heights<'e>(pieces: impl Iterator<Item = &'e Element>) -> (f64, f64) {
    let parts = pieces.flat_map(monotone);
    parts.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), part| (low.min(part.low[1]), high.max(part.high[1])))
}
