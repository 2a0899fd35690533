//! Corners, and paths to and from a contour.
//!
//! Facts: programming manuals of the control (CHF, RND, APPR, DEP; G24, G25). Decisions: corners are made between lines
//! and circles whose blocks say where they end, before G2 and G3 of ISO programs only between lines; a path to the
//! contour takes the direction of the path block after it; radius compensation begins on the first line of an approach
//! and ends on the last line of a departure, after an arc on the next straight line. Invariant: a corner that cannot be
//! made is left sharp and reported.

use super::path::{Corner, Position, Shape, Step, Walk, axis};
use super::words::Seen;
use counterpoint_motion::contour::element::Element;

use crate::contour::{self, Approach, Departure, PathShape, Point, Polar, Side, direction, minus};

impl Walk<'_> {
    /// Whether the next block is a corner.
    pub(super) fn corner_follows(&self) -> bool {
        self.ahead.first().is_some_and(|first| match first.shape {
            Shape::Chamfer | Shape::Round => true,
            Shape::Iso => is_g(&first.seen, 24.0) || is_g(&first.seen, 25.0),
            _ => false,
        })
    }

    /// Where an element has to end, if the next block makes a corner at its end.
    pub(super) fn corner_ahead(&mut self, own: Element, end: &Position) -> Option<Point> {
        let first = self.ahead.first()?;
        let chamfer = match first.shape {
            Shape::Chamfer => true,
            Shape::Round => false,
            Shape::Iso if is_g(&first.seen, 24.0) => true,
            Shape::Iso if is_g(&first.seen, 25.0) => false,
            _ => return None,
        };
        let size = first
            .seen
            .iter()
            .find(|word| (word.is("R") || word.is("") || word.is("RND") || word.is("CHF")) && word.value.is_some());
        let size = size.and_then(|word| word.value).unwrap_or(0.0);
        let Some(after) = self.element_behind(end) else {
            self.refuse("a corner needs a line or circle after it whose block gives the end point");
            return None;
        };
        match contour::corner(own, after, chamfer, size) {
            Ok(contour::Corner { from, to, heading, clockwise }) => {
                let radius = if chamfer { None } else { Some(size) };
                self.path.corner = Some(Corner { line: first.line, to, heading, radius, clockwise });
                Some(from)
            }
            Err(why) => {
                self.refuse(why);
                None
            }
        }
    }

    /// The element after the corner that follows, with the pole that may be before it.
    fn element_behind(&self, end: &Position) -> Option<Element> {
        let mut steps = self.ahead.iter().skip(1);
        let mut step = steps.next()?;
        let mut pole = self.path.poles.flat;
        if step.shape == Shape::Pole {
            pole = self.pole_of(&step.seen, end);
            step = steps.next()?;
        }
        let from = self.flat(end);
        let to = |polar: bool| self.end_of(&step.seen, end, pole.filter(|_| polar), polar);
        let clockwise = || {
            let own =
                step.seen.iter().find(|word| word.is("DR") && word.value.is_none()).map(|word| word.text == "DR-");
            own.or(self.path.clockwise)
        };
        Some(match step.shape {
            Shape::Line => contour::line(from, to(false)?),
            Shape::PolarLine => contour::line(from, to(true)?),
            Shape::Iso if step.seen.iter().all(|word| !is_arc(word)) && self.is_straight_mode(&step.seen) => {
                contour::line(from, to(false)?)
            }
            Shape::Arc => contour::arc(from, to(false)?, pole?, clockwise()?),
            Shape::PolarArc => contour::arc(from, to(true)?, pole?, clockwise()?),
            Shape::Radius => {
                let radius = step.seen.iter().find(|word| word.is("R") && word.text != "R0")?.value?;
                let to = to(false)?;
                contour::arc(from, to, contour::center_by_radius(from, to, radius, clockwise()?)?, clockwise()?)
            }
            // An element of a free contour that says its end, and of an arc its centre.
            Shape::FreeLine { .. } => contour::line(from, self.end_behind(step)?),
            Shape::FreeArc { .. } => contour::arc(from, self.end_behind(step)?, self.center_of(step)?, clockwise()?),
            _ => return None,
        })
    }

    /// Whether a block without a motion word goes straight on.
    fn is_straight_mode(&self, seen: &[Seen]) -> bool {
        let own = seen.iter().any(|word| word.is("G") && word.value.is_some_and(|value| value < 2.0));
        own || matches!(self.path.mode, None | Some(0 | 1 | 7 | 10 | 11))
    }

    /// End of another block in the plane.
    fn end_of(&self, seen: &[Seen], start: &Position, pole: Option<Point>, polar: bool) -> Option<Point> {
        if !polar {
            return Some(self.flat(&self.target_of(seen, start)));
        }
        let pole = pole?;
        let Polar { mut radius, mut angle } = Polar::of(pole, self.flat(start));
        for word in seen {
            match (&*word.name, word.value) {
                ("PR", Some(value)) => radius = value,
                ("IPR", Some(value)) => radius += value,
                ("PA", Some(value)) => angle = value,
                ("IPA", Some(value)) => angle += value,
                _ => {}
            }
        }
        Some(Polar { radius, angle }.point(pole))
    }

    /// A corner, for which the line before has made room.
    pub(super) fn corner(&mut self, corner: Option<Corner>) -> Vec<String> {
        let Some(corner) = corner.filter(|corner| corner.line == self.step.line) else {
            self.refuse(match self.path.heading {
                None => "a corner needs an element before it",
                Some(_) => "a corner needs its element before it, with nothing but blocks without motion between them",
            });
            return Vec::new();
        };
        let mut end = self.actual;
        self.put(&mut end, corner.to);
        let others = self.others(&["R", "", "CHF", "RND"]);
        let line = match corner.radius {
            Some(radius) => self.by_radius(&end, radius, corner.clockwise, &others),
            None => self.straight(&end, &others),
        };
        self.head_for(corner.heading);
        vec![line]
    }

    fn word(&self, name: &str) -> Option<f64> {
        self.step.seen.iter().find(|word| word.is(name) && word.text != "R0").and_then(|word| word.value)
    }

    /// Length or radius of a path, the side on which the tool goes, and its distance from the contour. Without
    /// compensation the tool centre moves on the contour; a positive value counts as the left side.
    fn side(&self, way: PathShape) -> Side {
        let angle = self.word("CCA").unwrap_or(90.0).abs();
        let is_straight = matches!(way, PathShape::Straight | PathShape::Normal);
        let size = self.word(if is_straight { "LEN" } else { "R" }).unwrap_or(0.0);
        let Some(on_left) = self.path.side.is_left else {
            return Side { size: size.abs(), on_left: size >= 0.0, beside: 0.0, angle };
        };
        let [_, radius] = self.host.tool_in_force();
        let beside = (radius / self.host.length_factor()).max(0.0);
        Side { size: if is_straight { size.abs() } else { size }, on_left, beside, angle }
    }

    pub(super) fn approach(&mut self, way: PathShape) -> Vec<String> {
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
            return vec![self.straight(&end, &others)];
        };
        let side = self.side(way);
        let made = contour::approach(way, from, (to, heading), side);
        let others = self.others(&USED);
        let Some(Approach { begin, arc, begins_plain, heading }) = made else {
            self.refuse("the approach has no length or radius that fits");
            return vec![self.straight(&end, &others)];
        };
        let mut first = self.actual;
        for ((slot, to), start) in first.iter_mut().zip(&end).zip(&self.start) {
            *slot = if to == start { *slot } else { *to };
        }
        self.put(&mut first, begin);
        let (to_begin, to_contour) = self.words_of_approach(way, begins_plain, others);
        let lines = vec![self.straight(&first, &to_begin)];
        let from = std::mem::replace(&mut self.actual, first);
        let last = match arc {
            None => self.straight(&end, &to_contour),
            Some(arc) => self.by_radius(&end, arc.radius, arc.clockwise, &to_contour),
        };
        self.actual = from;
        self.path.heading = Some(heading);
        lines.into_iter().chain([last]).collect()
    }

    /// The words of both parts of an approach. The first part has the feed of the previous block, also at rapid, except
    /// beside LCT. Compensation that starts with the second part is a word of that part.
    fn words_of_approach(&self, way: PathShape, begins_plain: bool, words: Vec<Seen>) -> (Vec<Seen>, Vec<Seen>) {
        let (mut first, mut second) = (words, Vec::new());
        if way != PathShape::LineAndCircle {
            second.extend(first.extract_if(.., |word| word.is_rate() || word.is("FAUTO")));
            if self.path.rates.rapid_before {
                first.push(Seen::text("FMAX"));
            }
        }
        if begins_plain {
            let compensation = first.extract_if(.., |word| word.is("RL") || word.is("RR")).collect::<Vec<_>>();
            if !compensation.is_empty() {
                first.insert(0, Seen::text("R0"));
            }
            second.splice(0..0, compensation);
        }
        (first, second)
    }

    /// Direction in which the first path block ahead that moves in the plane leaves a point; poles may be before it.
    fn heading_ahead(&self, from: &Position, point: Point) -> Option<Point> {
        let mut pole = self.path.poles.flat;
        for step in self.ahead {
            match step.shape {
                Shape::Pole => pole = self.pole_of(&step.seen, from),
                _ if goes_in_plane(step, self.path.plane) => return self.heading_of(step, from, (point, pole)),
                _ => {}
            }
        }
        None
    }

    /// Direction in which a block leaves a point.
    fn heading_of(&self, step: &Step, from: &Position, (point, pole): (Point, Option<Point>)) -> Option<Point> {
        match step.shape {
            Shape::Line | Shape::Tangent => direction(minus(self.end_of(&step.seen, from, None, false)?, point)),
            Shape::PolarLine => direction(minus(self.end_of(&step.seen, from, pole, true)?, point)),
            Shape::Arc | Shape::PolarArc => {
                let clockwise = step.seen.iter().any(|word| word.text == "DR-");
                direction(contour::heading_on(pole?, point, clockwise))
            }
            Shape::Radius => {
                let to = self.end_of(&step.seen, from, None, false)?;
                let clockwise = step.seen.iter().any(|word| word.text == "DR-");
                let radius = step.seen.iter().find(|word| word.is("R") && word.text != "R0")?.value?;
                let center = contour::center_by_radius(point, to, radius, clockwise)?;
                direction(contour::heading_on(center, point, clockwise))
            }
            _ => None,
        }
    }

    pub(super) fn depart(&mut self, way: PathShape) -> Vec<String> {
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
        if !with_end.iter().any(|word| word.text == "R0") {
            with_end.insert(0, Seen::text("R0"));
        }
        match contour::depart(way, (from, heading), self.flat(&end), side) {
            Some(Departure::Line { to, heading }) => {
                self.put(&mut end, to);
                self.path.heading = Some(heading);
                vec![self.straight(&end, &with_end)]
            }
            Some(Departure::Arc { to, arc, heading }) => {
                self.put(&mut end, to);
                self.path.heading = Some(heading);
                self.path.side.ends = true;
                with_end.retain(|word| word.text != "R0");
                vec![self.by_radius(&end, arc.radius, arc.clockwise, &with_end)]
            }
            Some(Departure::ArcAndLine { leave, arc, to }) => {
                let mut middle = self.actual;
                self.put(&mut middle, leave);
                let feed: Vec<Seen> = with_end.iter().filter(|word| word.is("F")).cloned().collect();
                let first = self.by_radius(&middle, arc.radius, arc.clockwise, &feed);
                with_end.retain(|word| !word.is("F"));
                let start = std::mem::replace(&mut self.actual, middle);
                let last = self.straight(&end, &with_end);
                self.actual = start;
                self.head_for(minus(to, leave));
                vec![first, last]
            }
            None => {
                self.refuse("the departure has no radius that fits, or ends inside its circle");
                vec![self.straight(&end, &with_end)]
            }
        }
    }
}

/// Words that paths to and from a contour use.
const USED: [&str; 8] = ["PR", "PA", "IPR", "IPA", "LEN", "CCA", "CCA=", "R"];

/// Whether a block moves axes of the plane.
pub(super) fn goes_in_plane(step: &Step, plane: [usize; 2]) -> bool {
    let in_plane = |name: &str| axis(name).is_some_and(|(own, _)| plane.contains(&own));
    let is_polar = |name: &str| matches!(name, "PR" | "PA" | "IPR" | "IPA");
    let moves = |word: &Seen| word.value.is_some() && (in_plane(&word.name) || is_polar(&word.name));
    !matches!(step.shape, Shape::Pole | Shape::FreePole | Shape::FreeSelect) && step.seen.iter().any(moves)
}

fn is_g(seen: &[Seen], number: f64) -> bool {
    seen.iter().any(|word| word.is("G") && word.value == Some(number))
}

fn is_arc(word: &Seen) -> bool {
    word.is("G") && word.value.is_some_and(|value| matches!(value as u32, 2 | 3 | 5 | 6 | 12 | 13 | 15 | 16))
}
