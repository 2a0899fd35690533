//! Elements of free contours with several solutions: parallels, points beside a line, an arc between two circles;
//! FSELECT.
//!
//! Facts: programming manuals of the control (PAR and DP: a line parallel to that of another block, and its distance;
//! PDX, PDY and D: a point beside a line, and its distance; FSELECT after the blocks that leave a choice selects one of
//! their solutions by its number). No available manual gives the numbering of the solutions. Decisions: an arc reaches
//! a coordinate at the nearer point first. Of two other solutions the first lies to the right, seen along the path or
//! from the centre of the element to that of the next known circle. A line parallel to another line first goes in the
//! direction of that line. Each use of FSELECT that decides something is reported. *Invariant:* without FSELECT only a
//! unique solution is accepted.

use counterpoint_control_api::contour::{Point, along, angle_between, direction, left, length, minus, touch, turn};
use counterpoint_fault as diag;

use super::path_state::{FreeContour, PathBlock, PathBlockKind, PathBuilder, of_step};

/// Lines of FSELECT that are remembered.
const DECIDED: usize = 20;

/// A line through a point, with its direction.
pub(super) type Line = (Point, Point);

impl FreeContour {
    /// The FSELECT after this number of elements.
    pub(super) fn selected(&self, behind: usize) -> Option<(usize, u32)> {
        self.selects.iter().find(|(at, ..)| *at == behind).map(|(_, number, line)| (*number, *line))
    }

    /// FSELECT of a line has selected something.
    fn decides(&mut self, line: u32) {
        if self.decided.len() >= DECIDED {
            self.decided.remove(0);
        }
        self.decided.push(line);
    }
}

impl PathBuilder<'_> {
    /// The only solution, or the solution that FSELECT selects after the elements that it needs.
    pub(super) fn pick<T: Copy>(&mut self, found: &[T], behind: usize) -> Option<T> {
        if found.len() < 2 {
            return found.first().copied();
        }
        let (number, line) = self.path.free.selected(behind)?;
        let one = number.checked_sub(1).and_then(|at| found.get(at)).copied()?;
        let text = format!(
            "FSELECT{number} of {} solutions in '{}': the numbers of the control are not known, look at the path",
            found.len(),
            self.host.block_text()
        );
        self.host.report(&diag::PATH_NOT_MADE, 4, text);
        self.path.free.decides(line);
        Some(one)
    }

    /// FSELECT itself: where the elements before it have one solution here, the control has others.
    pub(super) fn select(&mut self) {
        let line = self.step.line;
        if self.path.free.decided.contains(&line) {
            self.path.free.decided.retain(|known| *known != line);
            return;
        }
        let text = format!(
            "the elements before '{}' have one solution here, which may not be the one of the control: look at the path",
            self.host.block_text()
        );
        self.host.report(&diag::PATH_NOT_MADE, 4, text);
    }

    /// The point beside a line, and its distance.
    fn point_beside(step: &PathBlock) -> Option<(Point, f64)> {
        Some(([of_step(step, "PDX")?, of_step(step, "PDY")?], of_step(step, "D").unwrap_or(0.0).abs()))
    }

    /// Lines of a direction that a step says by a parallel or by a point beside it.
    fn lines_along(&self, step: &PathBlock, way: Point) -> Vec<Line> {
        let beside = |at: Point, apart: f64| {
            let sides = if apart > 0.0 { vec![-apart, apart] } else { vec![0.0] };
            sides.into_iter().map(|side| (along(at, left(way), side), way)).collect()
        };
        if let Some((at, apart)) = Self::point_beside(step) {
            // The point lies on the right of the line that is to the left of it.
            return beside(at, apart);
        }
        let Some((at, _)) = self.relative_in(step, "PAR") else { return Vec::new() };
        of_step(step, "DP").map_or_else(Vec::new, |apart| beside(at, apart.abs()))
    }

    /// Lines that a following step may be: through its end, beside a line or a point, each along its angle.
    pub(super) fn lines_behind(&self, step: &PathBlock) -> Vec<Line> {
        if !matches!(step.shape, PathBlockKind::FreeLine { .. }) {
            return Vec::new();
        }
        let angle = of_step(step, "AN").map(counterpoint_control_api::contour::towards);
        let parallel = self.relative_in(step, "PAR").and_then(|(_, way)| direction(way?));
        let Some(way) = angle.or(parallel) else { return Vec::new() };
        match self.end_behind(step) {
            Some(end) => vec![(end, way)],
            None => self.lines_along(step, way),
        }
    }

    /// Directions in which a line may begin that says none: parallel to another line, or beside a point.
    pub(super) fn ways_beside(&self) -> Vec<Point> {
        let start = self.flat(&self.start);
        if let Some((_, Some(way))) = self.relative_in(self.step, "PAR")
            && let Some(way) = direction(way)
        {
            return vec![way, way.map(|part| -part)];
        }
        let Some((at, apart)) = Self::point_beside(self.step) else { return Vec::new() };
        if apart == 0.0 {
            return direction(minus(at, start)).into_iter().collect();
        }
        // With the circle about the point on the right first.
        [true, false]
            .into_iter()
            .filter_map(|clockwise| direction(minus(touch(start, at, apart, clockwise)?, start)))
            .collect()
    }

    /// How far an arc turns to where it meets the only coordinate that its block says, the nearer spot first; degrees.
    pub(super) fn sweeps_to_coordinate(&self, (center, radius): (Point, f64), from: f64, clockwise: bool) -> Vec<f64> {
        let said = match self.said() {
            [Some(first), None] => Some((first - center[0], 0.0)),
            [None, Some(second)] => Some((second - center[1], 90.0)),
            _ => None,
        };
        let Some((off, axis)) = said.filter(|(off, _)| off.abs() <= radius + 1e-9) else { return Vec::new() };
        let half = libm::acos((off / radius).clamp(-1.0, 1.0)).to_degrees();
        let mut sweeps = [axis + half, axis - half].map(|angle| angle_between(from, angle, clockwise)).to_vec();
        sweeps.retain(|sweep| *sweep > 1e-6);
        sweeps.sort_by(f64::total_cmp);
        sweeps.dedup_by(|a, b| (*a - *b).abs() < 1e-4);
        sweeps
    }

    /// Where a circle leaves along a line that touches the next circle, each in its sense.
    pub(super) fn leaves_for_circle(&self, (center, radius, clockwise): (Point, f64, bool)) -> Option<Point> {
        let (line, behind) = (self.ahead.first()?, self.ahead.get(1)?);
        let is_line = line.shape == (PathBlockKind::FreeLine { tangent: true }) && self.end_behind(line).is_none();
        if !is_line || behind.shape != (PathBlockKind::FreeArc { tangent: true }) {
            return None;
        }
        // Centres lie to the left of a line that continues counter-clockwise.
        let signed = |radius: f64, clockwise: bool| if clockwise { -radius } else { radius };
        let own = signed(radius, clockwise);
        let next = signed(of_step(behind, "R")?.abs(), super::path_state::sense_of(behind)?);
        let by = minus(self.center_of(behind)?, center);
        let (way, apart) = (direction(by)?, (next - own) / length(by));
        let rest = (1.0 - apart * apart).max(0.0).sqrt();
        (apart.abs() <= 1.0).then(|| along(along(center, way, -own * apart), left(way), -own * rest))
    }

    /// The arc of a radius that follows, between the element and the one after it, which is tangential or a line: its
    /// radius and sense.
    fn arc_between(&self) -> Option<(f64, bool, &PathBlock)> {
        let (arc, behind) = (self.ahead.first()?, self.ahead.get(1)?);
        let is_arc = arc.shape == PathBlockKind::FreeArc { tangent: true };
        let is_open = is_arc && self.center_of(arc).is_none() && self.end_behind(arc).is_none();
        Some((of_step(arc, "R")?.abs(), super::path_state::sense_of(arc)?, behind)).filter(|_| is_open)
    }

    /// The circle of a tangential arc: its centre, radius and sense.
    fn circle_of(&self, step: &PathBlock) -> Option<(Point, f64, bool)> {
        let circle = (self.center_of(step)?, of_step(step, "R")?.abs(), super::path_state::sense_of(step)?);
        (step.shape == PathBlockKind::FreeArc { tangent: true }).then_some(circle)
    }

    /// Where a line in a direction ends for an arc of a radius that leads to a circle: the nearer spot first.
    pub(super) fn line_for_arc(&self, way: Option<Point>) -> Vec<Point> {
        let found = || {
            let (between, own, behind) = self.arc_between()?;
            let (to, size, next) = self.circle_of(behind)?;
            let (way, start) = (way?, self.flat(&self.start));
            let middle = along(start, left(way), if own { -between } else { between });
            let spots = on_line((middle, way), to, apart((between, own), (size, next)))?;
            Some(spots.into_iter().filter(|by| *by > 1e-9).map(|by| along(start, way, by)).collect())
        };
        found().unwrap_or_default()
    }

    /// Where a circle leaves for an arc of a radius that leads to another circle or to a line. To a circle, the
    /// solution to the right of the line between the centres comes first; to a line, the one that reaches it first.
    pub(super) fn leaves_for_arc(&self, (center, radius, clockwise): (Point, f64, bool)) -> Vec<Point> {
        let found = || {
            let (between, own, behind) = self.arc_between()?;
            let here = apart((between, own), (radius, clockwise));
            let middles = match self.circle_of(behind) {
                Some((to, size, next)) => {
                    let by = minus(to, center);
                    let (way, whole) = (direction(by)?, length(by));
                    let there = apart((between, own), (size, next));
                    let foot = (here * here - there * there + whole * whole) / (2.0 * whole);
                    let rise = here * here - foot * foot;
                    if rise < -1e-9 {
                        return None;
                    }
                    let rise = rise.max(0.0).sqrt();
                    let sides = if rise < 1e-6 { vec![0.0] } else { vec![-rise, rise] };
                    sides.into_iter().map(|side| along(along(center, way, foot), left(way), side)).collect()
                }
                None => {
                    let lines = self.lines_behind(behind);
                    let [(at, way)] = *lines else { return None };
                    let middle = along(at, left(way), if own { -between } else { between });
                    let spots = on_line((middle, way), center, here)?;
                    spots.into_iter().map(|by| along(middle, way, by)).collect::<Vec<Point>>()
                }
            };
            let leave = |middle: Point| {
                // Outside of each other, or one inside of the other.
                let out = direction(minus(middle, center))?;
                let inside = own == clockwise && between > radius;
                Some(along(center, out, if inside { -radius } else { radius }))
            };
            Some(middles.into_iter().filter_map(leave).collect())
        };
        found().unwrap_or_default()
    }
}

/// How far the centres of two circles that touch are apart, each with its sense.
fn apart((one, first): (f64, bool), (other, second): (f64, bool)) -> f64 {
    if first == second { (one - other).abs() } else { one + other }
}

/// How far along a line the points lie that have a distance from a point; none where it is too far.
fn on_line((from, way): Line, point: Point, distance: f64) -> Option<Vec<f64>> {
    let by = minus(point, from);
    let (foot, off) = (by[0] * way[0] + by[1] * way[1], turn(way, by));
    let rest = distance * distance - off * off;
    if rest < -1e-9 {
        return None;
    }
    let rest = rest.max(0.0).sqrt();
    Some(if rest < 1e-6 { vec![foot] } else { vec![foot - rest, foot + rest] })
}
