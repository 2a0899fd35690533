//! Auxiliary points of free contours: P1X, P1Y to P3X, P3Y, through which a line or a circle goes.
//!
//! Facts: programming manuals of the control. *Invariant:* a point is one of the plane only with both coordinates, and
//! never the end of an element.

use counterpoint_control_api::contour::{Point, left, minus, turn};

use super::path_state::{AXES, PathBlock};
use super::words::{HeidenhainWord, Operand};

/// Points that a block may name.
const POINTS: [&str; 3] = ["P1", "P2", "P3"];

/// `P1X+5` is read as two words; it is one.
pub(super) fn point_words(words: Vec<HeidenhainWord>) -> Vec<HeidenhainWord> {
    let mut out: Vec<HeidenhainWord> = Vec::with_capacity(words.len());
    for word in words {
        let point = out.last().filter(|last| &*last.name == "P").and_then(|last| match last.operand {
            Operand::Number(_, value) => POINTS.get((value as usize).checked_sub(1)?),
            _ => None,
        });
        match point.filter(|_| AXES.contains(&&*word.name)) {
            Some(point) => {
                out.pop();
                out.push(HeidenhainWord { name: format!("{point}{}", word.name).into(), ..word });
            }
            None => out.push(word),
        }
    }
    out
}

/// The points of a block in the plane of two axes.
pub(super) fn points(step: &PathBlock, plane: [usize; 2]) -> Vec<Point> {
    let letters = plane.map(|axis| AXES.get(axis).copied().unwrap_or_default());
    let of = |point: &str, letter: &str| {
        let mut words = step.seen.iter();
        words.find(|word| word.name.strip_prefix(point) == Some(letter)).and_then(|word| word.value)
    };
    POINTS.iter().filter_map(|point| Some([of(point, letters[0])?, of(point, letters[1])?])).collect()
}

/// Centre of the circle through three points; none if they lie in a line.
pub(super) fn center_of([a, b, c]: [Point; 3]) -> Option<Point> {
    let (one, other) = (minus(b, a), minus(c, a));
    let by = 2.0 * turn(one, other);
    if by.abs() < 1e-9 {
        return None;
    }
    let square = |[x, y]: Point| x * x + y * y;
    let (first, second) = (square(one), square(other));
    Some([a[0] + (other[1] * first - one[1] * second) / by, a[1] + (one[0] * second - other[0] * first) / by])
}

/// Centre of the circle that leaves a point in a direction and goes through another one, on the side to which it turns.
pub(super) fn center_along(from: Point, way: Point, through: Point, clockwise: bool) -> Option<Point> {
    let by = minus(through, from);
    let [x, y] = left(way);
    let across = x * by[0] + y * by[1];
    let radius = (by[0] * by[0] + by[1] * by[1]) / (2.0 * across);
    (across.abs() > 1e-9 && (radius < 0.0) == clockwise).then(|| [from[0] + x * radius, from[1] + y * radius])
}
