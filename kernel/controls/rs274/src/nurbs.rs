//! NURBS: G5.2 collects control points, G5.3 moves along their curve.
//!
//! Facts: LinuxCNC documentation, "G5.2 G5.3 NURBS Block": the current point is the first control point, P is the
//! weight of a point, L the order of the curve, 3 or more. The knots are uniform between clamped ends. Decision: the
//! curve becomes lines that deviate from it by at most 0.002 mm. *Invariant:* nothing moves before G5.3.

use counterpoint_fault as diag;
use counterpoint_machine::ident::codes as ids;

use super::block::{AXES, BlockWords};
use super::codes::NO_MOTION;
use super::motion::{SPLINE, push_axis, work};
use super::run::{push_code, push_value};
use super::text::Rs274Mistake;
use super::{Outcome, Rs274};
use counterpoint_control_api::host::InterpreterHost;

/// Largest number of control points.
const POINTS: usize = 1000;

/// Largest order of a curve.
const ORDER: f64 = 16.0;

/// Maximum depth to which a part of a curve is divided.
const DEEPEST: u32 = 10;

/// The control points of an open block.
#[derive(Debug, Clone, Default)]
pub(super) struct Nurbs {
    /// X, Y and weight.
    points: Vec<[f64; 3]>,
    order: usize,
    feed: Option<f64>,
}

fn refused(error: u8, text: impl Into<String>) -> Rs274Mistake {
    Rs274Mistake::new(&diag::REFUSED, error, text)
}

impl Rs274 {
    /// G5.2, or a block under it: adds a control point.
    pub(super) fn nurbs_point(
        &mut self,
        host: &mut dyn InterpreterHost,
        words: &BlockWords,
        begins: bool,
    ) -> Outcome<()> {
        if !host.is_active(ids::PLANE_XY) {
            return Err(refused(20, "a NURBS is possible in the plane of G17 only").into());
        }
        if host.is_active(ids::FEED_1T) {
            return Err(refused(20, "a NURBS is not possible under G93: write G94 before it").into());
        }
        if words.words.iter().any(|word| AXES.contains(&word.letter) && !matches!(word.letter, b'x' | b'y')) {
            return Err(refused(20, "a NURBS moves X and Y only: write other axes in another block").into());
        }
        let places = host.axes();
        let start = [work(&places, 0), work(&places, 1)];
        let weight = words.get(b'p');
        let nurbs = &mut self.modes.nurbs;
        if begins {
            *nurbs = Nurbs { order: 3, ..Nurbs::default() };
        }
        let point = match (words.get(b'x'), words.get(b'y')) {
            (Some(x), Some(y)) => Some([x, y]),
            (None, None) => None,
            _ => return Err(refused(28, "a control point needs both X and Y").into()),
        };
        if nurbs.points.is_empty() {
            let first = weight.filter(|weight| point.is_none() && *weight > 0.0).unwrap_or(1.0);
            let [x, y] = start;
            nurbs.points.push([x, y, first]);
        } else if point.is_none() && weight.is_some() {
            return Err(refused(28, "P without X and Y is possible for the first control point only").into());
        }
        if let Some(order) = words.get(b'l').filter(|order| *order > 3.0) {
            if order.fract() != 0.0 || order > ORDER {
                return Err(refused(20, format!("L of G5.2 is a whole number from 3 to {ORDER}")).into());
            }
            nurbs.order = order as usize;
        }
        nurbs.feed = words.get(b'f').or(nurbs.feed);
        let Some([x, y]) = point else { return Ok(()) };
        let Some(weight) = weight.filter(|weight| *weight > 0.0) else {
            return Err(refused(28, "each control point needs P, its weight, above 0").into());
        };
        if nurbs.points.len() >= POINTS {
            return Err(refused(20, format!("a NURBS has at most {POINTS} control points")).into());
        }
        let base = if host.relative() { start } else { [0.0; 2] };
        nurbs.points.push([base[0] + x, base[1] + y, weight]);
        Ok(())
    }

    /// G5.3: moves along the curve.
    pub(super) fn nurbs_end(
        &mut self,
        host: &mut dyn InterpreterHost,
        words: &BlockWords,
        opened: bool,
    ) -> Outcome<()> {
        let nurbs = std::mem::take(&mut self.modes.nurbs);
        self.modes.motion = NO_MOTION;
        if !opened {
            return Err(refused(20, "G5.3 ends a NURBS, but no G5.2 is before it").into());
        }
        if nurbs.points.len() < nurbs.order {
            let text =
                format!("the NURBS has {} control points, and its order needs {}", nurbs.points.len(), nurbs.order);
            return Err(refused(20, text).into());
        }
        let (lines, relative, span) = (nurbs.lines(SPLINE / host.length_factor()), host.relative(), words.whole);
        host.work(lines.len())?;
        let places = host.axes();
        let mut here = [work(&places, 0), work(&places, 1)];
        for (at, to) in lines.iter().enumerate() {
            if at > 0 {
                host.end_block();
            }
            push_code(host, b'G', 1.0, span);
            if let Some(feed) = nurbs.feed.filter(|_| at == 0) {
                push_value(host, b'F', feed, span)?;
            }
            for (axis, (to, here)) in to.iter().zip(here).enumerate() {
                push_axis(host, axis, if relative { to - here } else { *to }, span)?;
            }
            here = *to;
        }
        Ok(())
    }
}

impl Nurbs {
    /// Whether no control point has been given.
    pub(super) fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// The knot at a place in the knot vector.
    fn knot(&self, at: usize) -> f64 {
        let spans = self.points.len() + 1 - self.order;
        at.saturating_sub(self.order - 1).min(spans) as f64
    }

    /// The point of the curve at a parameter, by de Boor's algorithm with weights.
    fn point(&self, at: f64) -> [f64; 2] {
        let degree = self.order - 1;
        let spans = self.points.len() - degree;
        let span = (at as usize).min(spans - 1) + degree;
        let weighted = |[x, y, weight]: &[f64; 3]| [x * weight, y * weight, *weight];
        let mut part: Vec<[f64; 3]> = self.points.iter().skip(span - degree).take(self.order).map(weighted).collect();
        for level in 1..=degree {
            for place in (level..=degree).rev() {
                let first = self.knot(span + place - degree);
                let last = self.knot(span + 1 + place - level);
                let share = if last > first { (at - first) / (last - first) } else { 0.0 };
                let (Some(left), Some(right)) = (part.get(place - 1).copied(), part.get(place).copied()) else {
                    continue;
                };
                let mixed = std::array::from_fn(|of| {
                    left.get(of).unwrap_or(&0.0) * (1.0 - share) + right.get(of).unwrap_or(&0.0) * share
                });
                if let Some(slot) = part.get_mut(place) {
                    *slot = mixed;
                }
            }
        }
        let [x, y, weight] = part.last().copied().unwrap_or_default();
        [x / weight, y / weight]
    }

    /// Ends of lines that stay within `near` of the curve.
    fn lines(&self, near: f64) -> Vec<[f64; 2]> {
        let spans = self.points.len() + 1 - self.order;
        let mut ends = Vec::new();
        for span in 0..spans {
            // Begin with halves: a curve that crosses its chord in the middle would look straight.
            for half in [0.0, 0.5] {
                let first = span as f64 + half;
                self.divide(first, first + 0.5, near, DEEPEST, &mut ends);
            }
        }
        ends
    }

    fn divide(&self, first: f64, last: f64, near: f64, depth: u32, ends: &mut Vec<[f64; 2]>) {
        let (from, to) = (self.point(first), self.point(last));
        let is_near = [0.25, 0.5, 0.75].iter().all(|share| {
            let point = self.point(first + (last - first) * share);
            distance(point, from, to) < near
        });
        if depth == 0 || is_near {
            ends.push(to);
            return;
        }
        let middle = f64::midpoint(first, last);
        self.divide(first, middle, near, depth - 1, ends);
        self.divide(middle, last, near, depth - 1, ends);
    }
}

/// Distance of a point from a line between two points.
fn distance([x, y]: [f64; 2], [a, b]: [f64; 2], [c, d]: [f64; 2]) -> f64 {
    let length = libm::hypot(c - a, d - b);
    if length == 0.0 {
        return libm::hypot(x - a, y - b);
    }
    ((c - a) * (y - b) - (d - b) * (x - a)).abs() / length
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_circle_is_exact() {
        let weight = 0.5_f64.sqrt();
        let points = vec![[1.0, 0.0, 1.0], [1.0, 1.0, weight], [0.0, 1.0, 1.0]];
        let nurbs = Nurbs { points, order: 3, feed: None };
        for at in [0.0, 0.1, 0.5, 0.9, 1.0] {
            let [x, y] = nurbs.point(at);
            assert!((libm::hypot(x, y) - 1.0).abs() < 1e-12, "{at}: {x} {y}");
        }
        let lines = nurbs.lines(0.001);
        assert_eq!(lines.last(), Some(&[0.0, 1.0]));
        assert!((10..40).contains(&lines.len()), "{}", lines.len());
    }

    #[test]
    fn knots_are_uniform_between_clamped_ends() {
        let nurbs = Nurbs { points: vec![[0.0, 0.0, 1.0]; 5], order: 3, feed: None };
        assert_eq!([0, 1, 2, 3, 4, 5, 6, 7].map(|at| nurbs.knot(at)), [0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 3.0, 3.0]);
    }
}
