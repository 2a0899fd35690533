//! Free contours: elements whose end follows from what the block says.
//!
//! Facts: programming manuals of the control (FL, FLT, FC, FCT: end, length, angle, centre, radius, angle of the arc, direction
//! of rotation), reference heidenhain-cycles.md 1. Decisions: only elements that have one solution at once, with the tangent of
//! the element before and, behind a tangential arc, the angle of the line after it; closed contours, relative data and choices
//! of a solution are not made. Invariant: an element that is not determined is reported and moves nothing.

use super::path::{Position, Shape, Step, Walk};
use crate::contour::{Point, Polar, along, angle_between, direction, left, minus, pieces, times, towards};

/// Largest piece of an arc that is made by its radius, degrees.
const PIECE: f64 = 170.0;

/// Words that elements of free contours use up; R of a line is that of the compensation.
const LINE: [&str; 6] = ["AN", "LEN", "PR", "PA", "IPR", "IPA"];
const ARC: [&str; 11] = ["AN", "LEN", "PR", "PA", "IPR", "IPA", "R", "DR", "CCX", "CCY", "CCA"];

/// Words that ask for more than one element.
const MORE: [&str; 14] =
    ["CLSD", "RX", "RY", "RPR", "RPA", "RAN", "RCCX", "RCCY", "PDX", "PDY", "PAR", "DP", "CCPR", "CCPA"];

/// An arc to be made.
struct Arc {
    center: Point,
    radius: f64,
    /// Degrees.
    sweep: f64,
    /// The end, where the block says it.
    end: Option<Position>,
}

impl Walk<'_> {
    fn free(&self, name: &str) -> Option<f64> {
        self.step.seen.iter().find(|word| word.is(name) && word.text != "R0").and_then(|word| word.value)
    }

    fn not_determined(&mut self) -> Vec<String> {
        self.complain("the words do not determine this element of a free contour by itself; it is not made");
        Vec::new()
    }

    /// Which coordinates of the plane the block says, and where they are.
    fn said(&self) -> [Option<f64>; 2] {
        let (coded, end) = (self.coded(), self.flat(&self.target()));
        let said = self.path.plane.map(|axis| coded.get(axis) == Some(&true));
        [said[0].then_some(end[0]), said[1].then_some(end[1])]
    }

    /// The end that the block says by coordinates or about the pole.
    fn free_end(&mut self) -> Option<Position> {
        let polar = ["PR", "PA", "IPR", "IPA"].iter().any(|name| self.free(name).is_some());
        if polar {
            return self.polar_end().map(|(end, _)| end);
        }
        self.said().iter().all(Option::is_some).then(|| self.target())
    }

    /// Direction in which the element begins: by its angle, or that of the element before.
    fn begins(&self, tangent: bool) -> Option<Point> {
        let angle = self.free("AN").map(towards);
        angle.or_else(|| self.path.heading.filter(|_| tangent).and_then(direction))
    }

    fn asks_more(&self) -> bool {
        self.step.seen.iter().any(|word| MORE.iter().any(|name| word.is(name)))
    }

    /// FL and FLT.
    pub(super) fn free_line(&mut self, tangent: bool) -> Vec<String> {
        let start = self.flat(&self.start);
        let ray = || {
            let way = self.begins(tangent)?;
            if let Some(length) = self.free("LEN") {
                return Some(along(start, way, length));
            }
            let side = self.said().iter().position(Option::is_some)?;
            let to = self.said().get(side).copied().flatten()?;
            let (from, part) = (start.get(side)?, way.get(side)?);
            let length = (to - from) / part;
            (part.abs() > 1e-9 && length > 0.0).then(|| along(start, way, length))
        };
        let ray = ray();
        let end = self.free_end().or_else(|| {
            let mut end = self.start;
            self.put(&mut end, ray?);
            Some(end)
        });
        let Some(end) = end.filter(|_| !self.asks_more()) else { return self.not_determined() };
        self.path.base = None;
        let mut stop = end;
        let own = crate::contour::line(self.flat(&self.actual), self.flat(&end));
        if let Some(corner) = self.corner_ahead(own, &end) {
            self.put(&mut stop, corner);
            self.path.base = Some(end);
        }
        let line = self.straight(&stop, &self.others(&LINE));
        self.head_for(minus(self.flat(&end), start));
        self.path.round = false;
        vec![line]
    }

    /// FC and FCT.
    pub(super) fn free_arc(&mut self, tangent: bool) -> Vec<String> {
        if self.asks_more() {
            return self.not_determined();
        }
        let end = self.free_end();
        let center = self.free("CCX").zip(self.free("CCY")).map(|(x, y)| [x, y]);
        if let Some(end) = end.filter(|_| tangent && center.is_none() && self.free("R").is_none()) {
            return self.tangent(end);
        }
        let (Some(clockwise), start) = (self.path.clockwise, self.flat(&self.start)) else {
            self.complain("the circle has no direction of rotation");
            return Vec::new();
        };
        let radius = self.free("R").map(f64::abs);
        let begins = self.begins(tangent);
        let square = begins.map(|way| times(left(way), if clockwise { -1.0 } else { 1.0 }));
        let center = center.or_else(|| Some(along(start, square?, radius?)));
        self.path.base = None;
        let Some(center) = center else {
            // By its ends and its radius, the shorter way.
            let (Some(end), Some(radius)) = (end, radius) else { return self.not_determined() };
            let to = self.flat(&end);
            let Some(center) = crate::contour::center_by_radius(start, to, radius, clockwise) else {
                return self.not_determined();
            };
            let line = self.by_radius(&end, radius, clockwise, &self.others(&ARC));
            self.leave_circle(center, to, clockwise);
            return vec![line];
        };
        let Polar { radius, angle } = Polar::of(center, start);
        let turn = if clockwise { -90.0 } else { 90.0 };
        let chord = self.free("LEN").map(|chord| 2.0 * libm::asin(chord / (2.0 * radius)).to_degrees());
        let sweep = match end {
            Some(end) => Some(angle_between(angle, Polar::of(center, self.flat(&end)).angle, clockwise)),
            // The direction of the line behind is square to the radius at the end.
            None => self.free("CCA").map(f64::abs).or(chord).or_else(|| {
                let exit = self.ahead.first().and_then(exit_angle).filter(|_| begins.is_some())?;
                Some(angle_between(angle, exit - turn, clockwise))
            }),
        };
        let sweep = sweep.filter(|sweep| (1e-9..=360.0).contains(sweep) && radius > 1e-9);
        match sweep {
            Some(sweep) => self.arc_about(&Arc { center, radius, sweep, end }, angle, clockwise),
            None => self.not_determined(),
        }
    }

    /// An arc about a centre in pieces by their radius.
    fn arc_about(&mut self, arc: &Arc, from: f64, clockwise: bool) -> Vec<String> {
        let (mut lines, mut last) = (Vec::new(), self.start);
        for part in pieces(arc.sweep, PIECE) {
            let turn = arc.sweep * part;
            let angle = from + if clockwise { -turn } else { turn };
            self.put(&mut last, Polar { radius: arc.radius, angle }.point(arc.center));
            if let Some(end) = arc.end.filter(|_| part >= 1.0) {
                last = end;
            }
            let others = if lines.is_empty() { self.others(&ARC) } else { Vec::new() };
            lines.push(self.by_radius(&last, arc.radius, clockwise, &others));
        }
        self.leave_circle(arc.center, self.flat(&last), clockwise);
        lines
    }
}

/// Angle of a tangential line behind an arc.
fn exit_angle(step: &Step) -> Option<f64> {
    let own = step.seen.iter().find(|word| word.is("AN")).and_then(|word| word.value);
    own.filter(|_| step.shape == Shape::FreeLine { tangent: true })
}
