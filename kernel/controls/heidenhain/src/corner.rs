//! Corners.
//!
//! Facts: programming manuals of the control (CHF, RND; G24, G25). Decisions: corners are made between lines and circles
//! whose blocks say where they end, before G2 and G3 of ISO programs only between lines. Invariant: a corner that cannot
//! be made is left sharp and reported.

use counterpoint_control_api::contour;
use counterpoint_control_api::contour::{Point, PolarPoint};
use counterpoint_motion::contour::element::Element;

use super::path_state::{PathBlockKind, PathBuilder, PendingCorner, Position};
use super::words::{EvaluatedWord, LeftBlock};

impl PathBuilder<'_> {
    /// Whether the next block is a corner.
    pub(super) fn corner_follows(&self) -> bool {
        self.ahead.first().is_some_and(|first| match first.shape {
            PathBlockKind::Chamfer | PathBlockKind::Round => true,
            PathBlockKind::Iso => is_g(&first.seen, 24.0) || is_g(&first.seen, 25.0),
            _ => false,
        })
    }

    /// Where an element has to end, if the next block makes a corner at its end.
    pub(super) fn corner_ahead(&mut self, own: Element, end: &Position) -> Option<Point> {
        let first = self.ahead.first()?;
        let chamfer = match first.shape {
            PathBlockKind::Chamfer => true,
            PathBlockKind::Round => false,
            PathBlockKind::Iso if is_g(&first.seen, 24.0) => true,
            PathBlockKind::Iso if is_g(&first.seen, 25.0) => false,
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
            Ok(contour::CornerGeometry { from, to, heading, clockwise }) => {
                let radius = if chamfer { None } else { Some(size) };
                self.path.corner = Some(PendingCorner { line: first.line, to, heading, radius, clockwise });
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
        if step.shape == PathBlockKind::Pole {
            pole = self.pole_of(&step.seen, end);
            step = steps.next()?;
        }
        let from = self.flat(end);
        let to = |polar: bool| self.end_of(&step.seen, end, pole.filter(|_| polar), polar);
        let clockwise = || {
            let own = step
                .seen
                .iter()
                .find(|word| word.is("DR") && word.value.is_none())
                .map(|word| word.turns() == Some(true));
            own.or(self.path.clockwise)
        };
        Some(match step.shape {
            PathBlockKind::Line => contour::line(from, to(false)?),
            PathBlockKind::PolarLine => contour::line(from, to(true)?),
            PathBlockKind::Iso if step.seen.iter().all(|word| !is_arc(word)) && self.is_straight_mode(&step.seen) => {
                contour::line(from, to(false)?)
            }
            PathBlockKind::Arc => contour::arc(from, to(false)?, pole?, clockwise()?),
            PathBlockKind::PolarArc => contour::arc(from, to(true)?, pole?, clockwise()?),
            PathBlockKind::Radius => {
                let radius = step.seen.iter().find(|word| word.is("R") && !word.is_off())?.value?;
                let to = to(false)?;
                contour::arc(from, to, contour::center_by_radius(from, to, radius, clockwise()?)?, clockwise()?)
            }
            // An element of a free contour that says its end, and of an arc its centre.
            PathBlockKind::FreeLine { .. } => contour::line(from, self.end_behind(step)?),
            PathBlockKind::FreeArc { .. } => {
                contour::arc(from, self.end_behind(step)?, self.center_of(step)?, clockwise()?)
            }
            _ => return None,
        })
    }

    /// Whether a block without a motion word goes straight on.
    fn is_straight_mode(&self, seen: &[EvaluatedWord]) -> bool {
        let own = seen.iter().any(|word| word.is("G") && word.value.is_some_and(|value| value < 2.0));
        own || matches!(self.path.mode, None | Some(0 | 1 | 7 | 10 | 11))
    }

    /// End of another block in the plane.
    pub(super) fn end_of(
        &self,
        seen: &[EvaluatedWord],
        start: &Position,
        pole: Option<Point>,
        polar: bool,
    ) -> Option<Point> {
        if !polar {
            return Some(self.flat(&self.target_of(seen, start)));
        }
        let pole = pole?;
        let PolarPoint { mut radius, mut angle } = PolarPoint::of(pole, self.flat(start));
        for word in seen {
            match (&*word.name, word.value) {
                ("PR", Some(value)) => radius = value,
                ("IPR", Some(value)) => radius += value,
                ("PA", Some(value)) => angle = value,
                ("IPA", Some(value)) => angle += value,
                _ => {}
            }
        }
        Some(PolarPoint { radius, angle }.point(pole))
    }

    /// A corner, for which the line before has made room.
    pub(super) fn corner(&mut self, corner: Option<PendingCorner>) -> Vec<LeftBlock> {
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
            Some(radius) => self.by_radius(&end, radius, corner.clockwise, others),
            None => self.straight(&end, others),
        };
        self.head_for(corner.heading);
        vec![line]
    }
}

fn is_g(seen: &[EvaluatedWord], number: f64) -> bool {
    seen.iter().any(|word| word.is("G") && word.value == Some(number))
}

fn is_arc(word: &EvaluatedWord) -> bool {
    word.is("G") && word.value.is_some_and(|value| matches!(value as u32, 2 | 3 | 5 | 6 | 12 | 13 | 15 | 16))
}
