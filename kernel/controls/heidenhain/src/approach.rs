//! Paths to and from a contour.
//!
//! Facts: programming manuals of the control (APPR, DEP). Decisions: a path to the contour takes the direction of the
//! first block after it that moves in the plane; radius compensation begins on the first line of an approach and ends on
//! the last line of a departure, after an arc on the next straight line. Invariant: a path that cannot be made is a
//! straight line to its end, and is reported.

use counterpoint_control_api::contour;
use counterpoint_control_api::contour::{
    ApproachPath, Departure, PathDimensions, PathShape, Point, PolarPoint, direction, minus,
};

use super::path_state::{PathBlock, PathBlockKind, PathBuilder, Position, axis, of_step, sense_of};
use super::words::{EvaluatedWord, LeftBlock};

impl PathBuilder<'_> {
    fn word(&self, name: &str) -> Option<f64> {
        self.step.seen.iter().find(|word| word.is(name) && !word.is_off()).and_then(|word| word.value)
    }

    /// Length or radius of a path, the side on which the tool goes, and its distance from the contour. Without
    /// compensation the tool centre moves on the contour; a positive value counts as the left side.
    fn side(&self, way: PathShape) -> PathDimensions {
        let angle = self.word("CCA").unwrap_or(90.0).abs();
        let is_straight = matches!(way, PathShape::Straight | PathShape::Normal);
        let size = self.word(if is_straight { "LEN" } else { "R" }).unwrap_or(0.0);
        let Some(on_left) = self.path.side.is_left else {
            return PathDimensions { size: size.abs(), on_left: size >= 0.0, beside: 0.0, angle };
        };
        let [_, radius] = self.host.tool_in_force();
        let beside = (radius / self.host.length_factor()).max(0.0);
        PathDimensions { size: if is_straight { size.abs() } else { size }, on_left, beside, angle }
    }

    pub(super) fn approach(&mut self, way: PathShape) -> Vec<LeftBlock> {
        let polar = self.step.seen.iter().any(|word| matches!(&*word.name, "PR" | "PA" | "IPR" | "IPA"));
        let end = match polar {
            true => match self.polar_end() {
                Some((end, _)) => end,
                None => return Vec::new(),
            },
            false => self.target(),
        };
        let (from, to) = (self.flat(&self.start), self.flat(&end));
        self.path.base = None;
        let heading = self.heading_ahead(&end, to);
        let Some(heading) = heading else {
            self.refuse("the approach needs a path block after it for its direction");
            let others = self.others(&USED);
            return vec![self.straight(&end, others)];
        };
        let side = self.side(way);
        let made = contour::approach(way, from, (to, heading), side);
        let others = self.others(&USED);
        let Some(ApproachPath { begin, arc, begins_plain, heading }) = made else {
            self.refuse("the approach has no length or radius that fits");
            return vec![self.straight(&end, others)];
        };
        let mut first = self.actual;
        for ((slot, to), start) in first.iter_mut().zip(&end).zip(&self.start) {
            *slot = if to == start { *slot } else { *to };
        }
        self.put(&mut first, begin);
        let (to_begin, to_contour) = self.words_of_approach(way, begins_plain, others);
        let lines = vec![self.straight(&first, to_begin)];
        let from = std::mem::replace(&mut self.actual, first);
        let last = match arc {
            None => self.straight(&end, to_contour),
            Some(arc) => self.by_radius(&end, arc.radius, arc.clockwise, to_contour),
        };
        self.actual = from;
        self.path.heading = Some(heading);
        lines.into_iter().chain([last]).collect()
    }

    /// The words of both parts of an approach. The first part has the feed of the previous block, also at rapid, except
    /// beside LCT. Compensation that starts with the second part is a word of that part.
    fn words_of_approach(
        &self,
        way: PathShape,
        begins_plain: bool,
        words: Vec<EvaluatedWord>,
    ) -> (Vec<EvaluatedWord>, Vec<EvaluatedWord>) {
        let (mut first, mut second) = (words, Vec::new());
        if way != PathShape::LineAndCircle {
            second.extend(first.extract_if(.., |word| word.is_rate() || word.is("FAUTO")));
            if self.path.rates.rapid_before {
                first.push(EvaluatedWord::text("FMAX"));
            }
        }
        if begins_plain {
            let compensation = first.extract_if(.., |word| word.is("RL") || word.is("RR")).collect::<Vec<_>>();
            if !compensation.is_empty() {
                first.insert(0, EvaluatedWord::text("R0"));
            }
            second.splice(0..0, compensation);
        }
        (first, second)
    }

    /// Direction in which the first path block ahead that moves in the plane leaves a point; poles may be before it.
    fn heading_ahead(&self, from: &Position, point: Point) -> Option<Point> {
        let (mut pole, mut free_pole) = (self.path.poles.flat, self.path.free.pole);
        for step in self.ahead {
            match step.shape {
                PathBlockKind::Pole => pole = self.pole_of(&step.seen, from),
                PathBlockKind::FreePole => free_pole = Some(self.flat(&self.target_of(&step.seen, from))),
                shape if shape.is_free() => return self.free_heading(step, point, free_pole.or(pole)),
                _ if goes_in_plane(step, self.path.plane) => return self.heading_of(step, from, (point, pole)),
                _ => {}
            }
        }
        None
    }

    /// Direction in which a block leaves a point.
    fn heading_of(&self, step: &PathBlock, from: &Position, (point, pole): (Point, Option<Point>)) -> Option<Point> {
        match step.shape {
            PathBlockKind::Line | PathBlockKind::Tangent | PathBlockKind::Space => {
                direction(minus(self.end_of(&step.seen, from, None, false)?, point))
            }
            PathBlockKind::PolarLine => direction(minus(self.end_of(&step.seen, from, pole, true)?, point)),
            PathBlockKind::Arc | PathBlockKind::PolarArc => {
                let clockwise = step.seen.iter().any(|word| word.turns() == Some(true));
                direction(contour::heading_on(pole?, point, clockwise))
            }
            PathBlockKind::Radius => {
                let to = self.end_of(&step.seen, from, None, false)?;
                let clockwise = step.seen.iter().any(|word| word.turns() == Some(true));
                let radius = step.seen.iter().find(|word| word.is("R") && !word.is_off())?.value?;
                let center = contour::center_by_radius(point, to, radius, clockwise)?;
                direction(contour::heading_on(center, point, clockwise))
            }
            _ => None,
        }
    }

    /// Direction in which an element of a free contour leaves a point: by its angle, its end or its centre.
    fn free_heading(&self, step: &PathBlock, point: Point, pole: Option<Point>) -> Option<Point> {
        if matches!(step.shape, PathBlockKind::FreeLine { tangent: true } | PathBlockKind::FreeArc { tangent: true }) {
            return None;
        }
        if let Some(angle) = of_step(step, "AN") {
            return Some(contour::towards(angle));
        }
        let polar = |radius: &str, angle: &str| {
            let (radius, angle) = (of_step(step, radius)?, of_step(step, angle)?);
            Some(PolarPoint { radius, angle }.point(pole?))
        };
        let end = self.end_behind(step).or_else(|| polar("PR", "PA"));
        if matches!(step.shape, PathBlockKind::FreeLine { .. }) {
            return direction(minus(end?, point));
        }
        let clockwise = sense_of(step).or(self.path.clockwise)?;
        let by_end = || contour::center_by_radius(point, end?, of_step(step, "R")?, clockwise);
        let center = self.center_of(step).or_else(|| polar("CCPR", "CCPA")).or_else(by_end)?;
        direction(contour::heading_on(center, point, clockwise))
    }

    pub(super) fn depart(&mut self, way: PathShape) -> Vec<LeftBlock> {
        let from = self.flat(&self.start);
        let polar = self.step.seen.iter().any(|word| matches!(&*word.name, "PR" | "PA" | "IPR" | "IPA"));
        let mut end = match polar {
            true => self.polar_end().map_or(self.start, |(end, _)| end),
            false => self.target(),
        };
        self.path.base = None;
        let others = self.others(&USED);
        let Some(heading) = self.path.heading else {
            self.refuse("a departure needs a path block before it");
            return Vec::new();
        };
        let side = self.side(way);
        if side.size == 0.0 {
            self.refuse("a departure has no length or radius");
            return Vec::new();
        }
        self.path.side.is_left = None;
        let mut with_end = others;
        if !with_end.iter().any(EvaluatedWord::is_off) {
            with_end.insert(0, EvaluatedWord::text("R0"));
        }
        match contour::depart(way, (from, heading), self.flat(&end), side) {
            Some(Departure::Line { to, heading }) => {
                self.put(&mut end, to);
                self.path.heading = Some(heading);
                vec![self.straight(&end, with_end)]
            }
            Some(Departure::Arc { to, arc, heading }) => {
                self.put(&mut end, to);
                self.path.heading = Some(heading);
                self.path.side.ends = true;
                with_end.retain(|word| !word.is_off());
                vec![self.by_radius(&end, arc.radius, arc.clockwise, with_end)]
            }
            Some(Departure::ArcAndLine { leave, arc, to }) => {
                let mut middle = self.actual;
                self.put(&mut middle, leave);
                let feed: Vec<EvaluatedWord> = with_end.iter().filter(|word| word.is("F")).cloned().collect();
                let first = self.by_radius(&middle, arc.radius, arc.clockwise, feed);
                with_end.retain(|word| !word.is("F"));
                let start = std::mem::replace(&mut self.actual, middle);
                let last = self.straight(&end, with_end);
                self.actual = start;
                self.head_for(minus(to, leave));
                vec![first, last]
            }
            None => {
                self.refuse("the departure has no radius that fits, or ends inside its circle");
                vec![self.straight(&end, with_end)]
            }
        }
    }
}

/// Words that paths to and from a contour use.
const USED: [&str; 8] = ["PR", "PA", "IPR", "IPA", "LEN", "CCA", "CCA=", "R"];

/// Whether a block moves axes of the plane.
pub(super) fn goes_in_plane(step: &PathBlock, plane: [usize; 2]) -> bool {
    let in_plane = |name: &str| axis(name).is_some_and(|(own, _)| plane.contains(&own));
    let is_polar = |name: &str| matches!(name, "PR" | "PA" | "IPR" | "IPA");
    let moves = |word: &EvaluatedWord| word.value.is_some() && (in_plane(&word.name) || is_polar(&word.name));
    match step.shape {
        PathBlockKind::Pole | PathBlockKind::FreePole | PathBlockKind::FreeSelect => false,
        shape => shape.is_free() || step.seen.iter().any(moves),
    }
}
