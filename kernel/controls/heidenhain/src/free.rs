//! Free contours: elements whose end follows from the words of the block and from the elements after it.
//!
//! Facts: programming manuals of the control (FL, FLT, FC, FCT: end, length, angle, centre, radius, angle of the arc,
//! direction of rotation; FPOL; CLSD; data relative to another block), reference heidenhain-cycles.md 1. Decisions:
//! only elements that have one solution: at once, with the tangent of the element before, with auxiliary points, or
//! with one or two elements after it, and those of which FSELECT selects one. Invariant: an element that is not
//! determined stops the program, as on the control.

use counterpoint_control_api::contour::{
    Point, PolarPoint, along, angle_between, center_by_radius, direction, left, length, line, minus, pieces, times,
    touch, towards, turn, turned,
};
use counterpoint_fault as diag;
use counterpoint_fault::Halt;

use super::path_state::{PathBlock, PathBlockKind, PathBuilder, Position, exit_angle, of_step, sense_of};
use super::words::LeftBlock;

/// Largest piece of an arc that is made by its radius, degrees.
const PIECE: f64 = 170.0;

/// Words that elements of free contours use up; R of a line is that of the compensation.
const LINE: [&str; 22] = [
    "AN", "IAN", "LEN", "PR", "PA", "IPR", "IPA", "CLSD", "RX", "RY", "RPR", "RPA", "RAN", "P1X", "P1Y", "P2X", "P2Y",
    "PAR", "DP", "PDX", "PDY", "D",
];
const ARC: [&str; 30] = [
    "P1X", "P1Y", "P2X", "P2Y", "P3X", "P3Y", "AN", "IAN", "LEN", "PR", "PA", "IPR", "IPA", "CLSD", "RX", "RY", "RPR",
    "RPA", "RAN", "R", "DR", "CCX", "CCY", "CCA", "ICCX", "ICCY", "CCPR", "CCPA", "RCCX", "RCCY",
];

/// Words of lines that arcs do not have here.
const MORE: [&str; 5] = ["PDX", "PDY", "PAR", "DP", "D"];

/// Elements that are remembered for data relative to them.
const REMEMBERED: usize = 100;

/// Differences below this are none, millimetres or inches.
const NEAR: f64 = 1e-3;

/// How far the start of an arc may lie off its circle; the same as for its end.
const OFF: f64 = 0.016;

/// An arc to be made.
struct FreeContourArc {
    center: Point,
    radius: f64,
    /// Degrees.
    sweep: f64,
    /// The end, where the block says it.
    end: Option<Position>,
}

/// Where a ray meets a line through a point; none behind its start.
fn meets(from: Point, way: Point, at: Point, other: Point) -> Option<Point> {
    let by = turn(way, other);
    let share = turn(minus(at, from), other) / by;
    (by.abs() > 1e-9 && share > 1e-9).then(|| along(from, way, share))
}

impl PathBuilder<'_> {
    fn free(&self, name: &str) -> Option<f64> {
        of_step(self.step, name)
    }

    fn not_determined(&mut self) -> Halt {
        let text = format!(
            "the words do not determine this element of a free contour, with those behind it and FSELECT, in '{}'",
            self.host.block_text()
        );
        self.host.alarm(&diag::FREE_CONTOUR, text)
    }

    /// FPOL.
    pub(super) fn free_pole(&mut self) -> Vec<LeftBlock> {
        let to = self.flat(&self.target());
        self.path.free.pole = Some(to);
        Vec::new()
    }

    /// The element of the block ends here.
    pub(super) fn ends_at(&mut self, end: Point) {
        self.path.free.end = Some(end);
    }

    /// Remembers where an element with a number ends.
    pub(super) fn remember(&mut self) {
        let Some(number) = self.step.number else { return };
        let Some(end) = self.path.free.end.take() else { return };
        let heading = self.path.heading;
        let known = &mut self.path.free.known;
        known.retain(|(of, ..)| *of != number);
        if known.len() >= REMEMBERED {
            known.remove(0);
        }
        known.push((number, end, heading));
    }

    /// The element that a word names by the number of its block: its end, and the direction there.
    fn relative(&self, name: &str) -> Option<(Point, Option<Point>)> {
        self.relative_in(self.step, name)
    }

    pub(super) fn relative_in(&self, step: &PathBlock, name: &str) -> Option<(Point, Option<Point>)> {
        let number = of_step(step, name)?;
        let known = self.path.free.known.iter().find(|(of, ..)| f64::from(*of) == number);
        known.map(|(_, end, heading)| (*end, *heading))
    }

    /// Whether every element that words name is known.
    fn relations_hold(&self) -> bool {
        let words = ["RX", "RY", "RPR", "RPA", "RAN", "RCCX", "RCCY", "PAR"];
        words.iter().all(|name| self.free(name).is_none() || self.relative(name).is_some())
    }

    /// Which coordinates of the plane the block says, and where they are.
    pub(super) fn said(&self) -> [Option<f64>; 2] {
        let (coded, end) = (self.coded(), self.flat(&self.target()));
        let here = self.flat(&self.start);
        let of = |side: usize, name: &str| {
            let axis = self.path.plane.get(side)?;
            let value = *end.get(side)?;
            // An incremental value counts from the end of the element that it is relative to.
            let moved = self.relative(name).and_then(|(other, _)| Some(value - here.get(side)? + other.get(side)?));
            (coded.get(*axis) == Some(&true)).then_some(moved.unwrap_or(value))
        };
        [of(0, "RX"), of(1, "RY")]
    }

    /// The end that the block says by coordinates, about the pole, or by closing the contour.
    fn free_end(&mut self) -> Option<Position> {
        if self.step.seen.iter().any(|word| word.reads("CLSD-"))
            && let Some(begin) = self.path.free.begins
        {
            let mut end = self.start;
            self.put(&mut end, begin);
            return Some(end);
        }
        let polar = ["PR", "PA", "IPR", "IPA"].iter().any(|name| self.free(name).is_some());
        if polar {
            return self.free_polar();
        }
        let [Some(first), Some(second)] = self.said() else { return None };
        let mut end = self.target();
        self.put(&mut end, [first, second]);
        Some(end)
    }

    /// An end about the pole of FPOL, otherwise about that of CC; both coordinates have to stand.
    fn free_polar(&mut self) -> Option<Position> {
        let Some(pole) = self.path.free.pole else { return self.polar_end().map(|(end, _)| end) };
        let here = PolarPoint::of(pole, self.flat(&self.start));
        let of = |name: &str| self.relative(name).map_or(here, |(end, _)| PolarPoint::of(pole, end));
        let radius = self.free("PR").or_else(|| Some(of("RPR").radius + self.free("IPR")?))?;
        let angle = self.free("PA").or_else(|| Some(of("RPA").angle + self.free("IPA")?))?;
        let mut end = self.target();
        self.put(&mut end, PolarPoint { radius, angle }.point(pole));
        Some(end)
    }

    /// Direction in which the element begins: by its angle, relative to the element before or another one, or that of
    /// the element before.
    fn begins(&self, tangent: bool) -> Option<Point> {
        if let Some(angle) = self.free("AN") {
            return Some(towards(angle));
        }
        let before = match self.free("RAN") {
            Some(_) => self.relative("RAN")?.1,
            None => self.path.heading,
        };
        match self.free("IAN") {
            Some(by) => direction(before?).map(|way| turned(way, by)),
            None => before.filter(|_| tangent).and_then(direction),
        }
    }

    fn asks_more(&self) -> bool {
        let more = self.step.seen.iter().any(|word| MORE.iter().any(|name| word.is(name)));
        more && matches!(self.step.shape, PathBlockKind::FreeArc { .. }) || !self.relations_hold()
    }

    /// CLSD+ begins a contour that CLSD- closes.
    fn note_begin(&mut self) {
        if self.step.seen.iter().any(|word| word.reads("CLSD+")) {
            self.path.free.begins = Some(self.flat(&self.start));
        }
    }

    /// The centre that a step says, in coordinates of the plane.
    pub(super) fn center_of(&self, step: &PathBlock) -> Option<Point> {
        Some([of_step(step, "CCX")?, of_step(step, "CCY")?])
    }

    /// The end of a following step, if its coordinates give it.
    pub(super) fn end_behind(&self, step: &PathBlock) -> Option<Point> {
        let letters = self.path.plane.map(|axis| super::path_state::AXES.get(axis).copied().unwrap_or_default());
        Some([of_step(step, letters[0])?, of_step(step, letters[1])?])
    }

    /// The end of a line, determined by the elements after it.
    fn line_end(&mut self, way: Option<Point>) -> Option<Point> {
        let start = self.flat(&self.start);
        let next = self.ahead.first()?;
        if next.shape == (PathBlockKind::FreeLine { tangent: false }) {
            // It meets the next line.
            let lines = self.lines_behind(next);
            let way = way?;
            let found: Vec<Point> = lines.into_iter().filter_map(|(at, other)| meets(start, way, at, other)).collect();
            return self.pick(&found, 1);
        }
        let for_arc = self.line_for_arc(way);
        if !for_arc.is_empty() {
            return self.pick(&for_arc, 2);
        }
        self.line_to_arc(way)
    }

    /// The end of a line before an arc.
    fn line_to_arc(&self, way: Option<Point>) -> Option<Point> {
        let start = self.flat(&self.start);
        let next = self.ahead.first()?;
        match next.shape {
            PathBlockKind::FreeArc { tangent: true } => {
                let clockwise = sense_of(next);
                if let Some(center) = self.center_of(next) {
                    return match way {
                        // It touches the circle, which lies on the side to which it turns.
                        Some(way) => {
                            let by = minus(center, start);
                            let foot = along(start, way, by[0] * way[0] + by[1] * way[1]);
                            let turns = turn(way, by) < 0.0;
                            let fits = of_step(next, "R")
                                .is_none_or(|radius| (length(minus(center, foot)) - radius.abs()).abs() < NEAR);
                            let ahead = by[0] * way[0] + by[1] * way[1] > 1e-9;
                            (ahead && fits && clockwise.is_none_or(|own| own == turns)).then_some(foot)
                        }
                        None => touch(start, center, of_step(next, "R")?.abs(), clockwise?),
                    };
                }
                // An arc of a radius leads to the line after it.
                let lines = self.lines_behind(self.ahead.get(1)?);
                let [(at, other)] = *lines else { return None };
                let (radius, way, clockwise) = (of_step(next, "R")?.abs(), way?, clockwise?);
                let side = if clockwise { -radius } else { radius };
                let from = along(start, left(way), side);
                let center = meets_line(from, way, along(at, left(other), side), other)?;
                let foot = along(center, left(way), -side);
                let by = minus(foot, start);
                (by[0] * way[0] + by[1] * way[1] > 1e-9).then_some(foot)
            }
            _ => None,
        }
    }

    /// The end of an arc about a centre, determined by the element after it.
    fn arc_end(&mut self, center: Point, radius: f64, clockwise: bool) -> Option<Point> {
        let for_arc = self.leaves_for_arc((center, radius, clockwise));
        if !for_arc.is_empty() {
            return self.pick(&for_arc, 2);
        }
        if let Some(end) = self.leaves_for_circle((center, radius, clockwise)) {
            return Some(end);
        }
        let next = self.ahead.first()?;
        match next.shape {
            // A tangent leads to the end of the line.
            PathBlockKind::FreeLine { tangent: true } => touch(self.end_behind(next)?, center, radius, !clockwise),
            // It touches the next circle.
            PathBlockKind::FreeArc { tangent: true } => {
                let (other, size) = (self.center_of(next)?, of_step(next, "R")?.abs());
                let by = minus(other, center);
                let way = direction(by)?;
                let apart = length(by);
                let same = sense_of(next)? == clockwise;
                match same {
                    false if (apart - radius - size).abs() < NEAR => Some(along(center, way, radius)),
                    true if (apart - (radius - size).abs()).abs() < NEAR => {
                        Some(along(center, way, if radius > size { radius } else { -radius }))
                    }
                    _ => None,
                }
            }
            _ => None,
        }
    }

    /// The end of a line through an auxiliary point, by one coordinate; where that is a choice of two ways there is
    /// none.
    fn through_point(&self) -> Option<Point> {
        let start = self.flat(&self.start);
        let points = super::auxiliary::points(self.step, self.path.plane);
        let way = direction(minus(*points.first()?, start))?;
        if points.iter().any(|point| turn(way, minus(*point, start)).abs() > NEAR) {
            return None;
        }
        let said = self.said();
        let side = said.iter().position(Option::is_some)?;
        let (from, part) = (start.get(side)?, way.get(side)?);
        let share = (said.get(side).copied().flatten()? - from) / part;
        (part.abs() > 1e-9 && share.abs() > 1e-9).then(|| along(start, way, share))
    }

    /// The centre of a circle through auxiliary points: by three points with its ends, or by the direction in which it
    /// begins and one.
    fn center_through(&self, end: Option<Point>, begins: Option<Point>, clockwise: bool) -> Option<Point> {
        let start = self.flat(&self.start);
        let points = super::auxiliary::points(self.step, self.path.plane);
        let first = *points.first()?;
        if let Some(way) = begins {
            return super::auxiliary::center_along(start, way, first, clockwise);
        }
        let others: Vec<Point> = points.into_iter().chain(end).collect();
        super::auxiliary::center_of([start, first, *others.get(1)?])
    }

    /// FL and FLT.
    pub(super) fn free_line(&mut self, tangent: bool) -> Result<Vec<LeftBlock>, Halt> {
        self.note_begin();
        let start = self.flat(&self.start);
        let way = match self.begins(tangent) {
            Some(way) => Some(way),
            None => {
                let ways = self.ways_beside();
                self.pick(&ways, 0)
            }
        };
        let ray = || {
            let way = way?;
            if let Some(length) = self.free("LEN") {
                return Some(along(start, way, length));
            }
            let said = self.said();
            let side = said.iter().position(Option::is_some)?;
            let to = said.get(side).copied().flatten()?;
            let (from, part) = (start.get(side)?, way.get(side)?);
            let length = (to - from) / part;
            (part.abs() > 1e-9 && length > 0.0).then(|| along(start, way, length))
        };
        let ray = ray().or_else(|| self.line_end(way)).or_else(|| self.through_point());
        let end = self.free_end().or_else(|| {
            let mut end = self.target();
            self.put(&mut end, ray?);
            Some(end)
        });
        let Some(end) = end.filter(|_| !self.asks_more()) else { return Err(self.not_determined()) };
        self.path.base = None;
        let mut stop = end;
        let own = line(self.flat(&self.actual), self.flat(&end));
        if let Some(corner) = self.corner_ahead(own, &end) {
            self.put(&mut stop, corner);
            self.path.base = Some(end);
        }
        let line = self.straight(&stop, self.others(&LINE));
        self.head_for(minus(self.flat(&end), start));
        self.ends_at(self.flat(&end));
        self.path.round = false;
        Ok(vec![line])
    }

    /// The centre that the block says, relative to another one or to the start by I.
    fn free_center(&self) -> Option<Point> {
        let here = self.flat(&self.start);
        if let (Some(radius), Some(angle)) = (self.free("CCPR"), self.free("CCPA")) {
            return Some(PolarPoint { radius, angle }.point(self.path.free.pole.or(self.path.poles.flat)?));
        }
        let of = |side: usize, [name, by, relative]: [&str; 3]| {
            let from = self.relative(relative).map_or(here, |(end, _)| end);
            self.free(name).or_else(|| Some(from.get(side)? + self.free(by)?))
        };
        Some([of(0, ["CCX", "ICCX", "RCCX"])?, of(1, ["CCY", "ICCY", "RCCY"])?])
    }

    /// FC and FCT.
    pub(super) fn free_arc(&mut self, tangent: bool) -> Result<Vec<LeftBlock>, Halt> {
        if self.asks_more() {
            return Err(self.not_determined());
        }
        self.note_begin();
        let end = self.free_end();
        let center = self.free_center();
        let has_points = !super::auxiliary::points(self.step, self.path.plane).is_empty();
        if let Some(end) = end.filter(|_| tangent && center.is_none() && self.free("R").is_none() && !has_points) {
            return Ok(self.tangent(end));
        }
        let (Some(clockwise), start) = (self.path.clockwise, self.flat(&self.start)) else {
            return Err(self.not_determined());
        };
        let radius = self.free("R").map(f64::abs);
        let begins = self.begins(tangent);
        let square = begins.map(|way| times(left(way), if clockwise { -1.0 } else { 1.0 }));
        let center = center.or_else(|| Some(along(start, square?, radius?)));
        let flat_end = end.map(|end| self.flat(&end));
        let center = center.or_else(|| self.center_through(flat_end, begins, clockwise).filter(|_| radius.is_none()));
        self.path.base = None;
        let Some(center) = center else {
            // By its ends and its radius, the shorter path.
            let (Some(end), Some(radius)) = (end, radius) else { return Err(self.not_determined()) };
            let to = self.flat(&end);
            // The shorter path, unless FSELECT says otherwise.
            let ways = [radius, -radius];
            let signed = if self.path.free.selected(0).is_some() { self.pick(&ways, 0) } else { Some(radius) };
            let center = signed.and_then(|signed| center_by_radius(start, to, signed, clockwise));
            let Some(center) = center else { return Err(self.not_determined()) };
            let angle = PolarPoint::of(center, start).angle;
            let sweep = angle_between(angle, PolarPoint::of(center, to).angle, clockwise);
            return Ok(self.arc_about(&FreeContourArc { center, radius, sweep, end: Some(end) }, angle, clockwise));
        };
        let said = radius;
        let PolarPoint { radius, angle } = PolarPoint::of(center, start);
        if said.is_some_and(|said| (said - radius).abs() > OFF) {
            return Err(self.not_determined());
        }
        let turn = if clockwise { -90.0 } else { 90.0 };
        let chord = self.free("LEN").map(|chord| 2.0 * libm::asin(chord / (2.0 * radius)).to_degrees());
        let sweep = match end {
            Some(end) => Some(angle_between(angle, PolarPoint::of(center, self.flat(&end)).angle, clockwise)),
            // The direction of the line after it is perpendicular to the radius at the end.
            None => self.free("CCA").map(f64::abs).or(chord).or_else(|| {
                let exit = self.ahead.first().and_then(exit_angle).filter(|_| begins.is_some());
                let by_exit = exit.map(|exit| angle_between(angle, exit - turn, clockwise));
                let by_one = || {
                    let found = self.sweeps_to_coordinate((center, radius), angle, clockwise);
                    self.pick(&found, 0)
                };
                by_exit.or_else(by_one).or_else(|| {
                    let end = self.arc_end(center, radius, clockwise)?;
                    Some(angle_between(angle, PolarPoint::of(center, end).angle, clockwise))
                })
            }),
        };
        let sweep = sweep.filter(|sweep| (1e-9..=360.0).contains(sweep) && radius > 1e-9);
        match sweep {
            Some(sweep) => Ok(self.arc_about(&FreeContourArc { center, radius, sweep, end }, angle, clockwise)),
            None => Err(self.not_determined()),
        }
    }

    /// An arc about a centre in pieces by their radius.
    fn arc_about(&mut self, arc: &FreeContourArc, from: f64, clockwise: bool) -> Vec<LeftBlock> {
        let signed = |turn: f64| if clockwise { -turn } else { turn };
        let mut end = arc.end.unwrap_or(self.target());
        if arc.end.is_none() {
            self.put(&mut end, PolarPoint { radius: arc.radius, angle: from + signed(arc.sweep) }.point(arc.center));
        }
        let to = self.flat(&end);
        // A corner ends the arc earlier.
        let whole = counterpoint_control_api::contour::arc(self.flat(&self.actual), to, arc.center, clockwise);
        let corner = self.corner_ahead(whole, &end);
        let (mut stop, mut sweep) = (end, arc.sweep);
        if let Some(corner) = corner {
            sweep = angle_between(from, PolarPoint::of(arc.center, corner).angle, clockwise);
            self.put(&mut stop, corner);
        }
        let (mut lines, mut last) = (Vec::new(), self.start);
        for part in pieces(sweep, PIECE) {
            let angle = from + signed(sweep * part);
            self.put(&mut last, PolarPoint { radius: arc.radius, angle }.point(arc.center));
            if part >= 1.0 {
                last = stop;
            }
            let others = if lines.is_empty() { self.others(&ARC) } else { Vec::new() };
            lines.push(self.by_radius(&last, arc.radius, clockwise, others));
        }
        self.path.base = corner.map(|_| end);
        self.leave_circle(arc.center, to, clockwise);
        lines
    }
}

/// Where two lines meet.
fn meets_line(from: Point, way: Point, at: Point, other: Point) -> Option<Point> {
    let by = turn(way, other);
    (by.abs() > 1e-9).then(|| along(from, way, turn(minus(at, from), other) / by))
}
