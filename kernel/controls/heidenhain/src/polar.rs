//! Polar coordinates about the pole.
//!
//! Facts: programming manuals of the control (LP, CP, CTP; G10 to G16). Decision: circles of more than 270 degrees are
//! made in pieces, so that none of them is full. Invariant: without a pole there is a diagnostic, no position.

use counterpoint_control_api::contour::{Point, PolarPoint, angle_between, minus, pieces};

use super::path_state::{PathBuilder, Position};
use super::words::{LeftBlock, headed};

/// Largest arc of a circle about the pole that is made in one piece, degrees.
const LARGEST: f64 = 270.0;

impl PathBuilder<'_> {
    const POLAR: [&'static str; 6] = ["PR", "IPR", "PA", "IPA", "H", "R"];

    /// End of a block in polar coordinates, and the angle that the tool goes around the pole if the block gives it.
    pub(super) fn polar_end(&mut self) -> Option<(Position, Option<f64>)> {
        if self.path.poles.upright.is_some() {
            self.refuse("an approach or departure in polar coordinates needs a pole (CC) in the working plane");
            return None;
        }
        self.polar_end_about(self.path.poles.flat)
    }

    /// The same about another pole.
    pub(super) fn polar_end_about(&mut self, pole: Option<Point>) -> Option<(Position, Option<f64>)> {
        let Some(pole) = pole else {
            self.refuse("polar coordinates have no pole (CC)");
            return None;
        };
        let PolarPoint { mut radius, mut angle } = PolarPoint::of(pole, self.flat(&self.start));
        let mut sweep = None;
        for word in &self.step.seen {
            let Some(value) = word.value else { continue };
            let by = self.path.increments && self.step.iso;
            match &*word.name {
                "PR" => radius = value,
                "IPR" => radius += value,
                "R" if self.step.iso => radius = if by { radius + value } else { value },
                "H" if self.step.iso && !by => angle = value,
                "PA" => angle = value,
                "IPA" | "H" => {
                    angle += value;
                    sweep = Some(value);
                }
                _ => {}
            }
        }
        let mut end = self.target();
        self.put(&mut end, PolarPoint { radius, angle }.point(pole));
        Some((end, sweep))
    }

    /// Words that polar coordinates have used; R of a conversational block is that of something else.
    pub(super) fn polar_words(&self) -> &'static [&'static str] {
        if self.step.iso { &Self::POLAR } else { Self::POLAR.split_last().map_or(&[], |(_, rest)| rest) }
    }

    pub(super) fn polar_line(&mut self) -> Vec<LeftBlock> {
        let Some((end, _)) = self.polar_end() else { return Vec::new() };
        let start = self.flat(&self.start);
        self.path.base = None;
        let to = self.flat(&end);
        let mut stop = end;
        let own = counterpoint_control_api::contour::line(self.flat(&self.actual), self.flat(&end));
        if let Some(corner_start) = self.corner_ahead(own, &end) {
            self.put(&mut stop, corner_start);
            self.path.base = Some(end);
        }
        let line = self.straight(&stop, self.others(self.polar_words()));
        self.head_for(minus(to, start));
        self.ends_at(to);
        self.path.round = false;
        vec![line]
    }

    pub(super) fn polar_arc(&mut self) -> Vec<LeftBlock> {
        let Some((end, sweep)) = self.polar_end() else { return Vec::new() };
        let (Some(pole), start) = (self.path.poles.flat, self.flat(&self.start)) else { return Vec::new() };
        self.path.base = None;
        let clockwise = match (self.path.clockwise, sweep) {
            (None, Some(sweep)) => sweep < 0.0,
            (Some(clockwise), _) => clockwise,
            (None, None) => {
                self.refuse("the circle has no direction of rotation");
                return Vec::new();
            }
        };
        if sweep.is_some_and(|sweep| sweep != 0.0 && (sweep < 0.0) != clockwise) {
            self.refuse("the polar angle and the direction of rotation contradict each other");
        }
        let PolarPoint { radius, angle: from } = PolarPoint::of(pole, start);
        let turned = match sweep {
            Some(sweep) => sweep.abs(),
            None => angle_between(from, PolarPoint::of(pole, self.flat(&end)).angle, clockwise),
        };
        if !(0.0..=360.0 * 1000.0).contains(&turned) || radius == 0.0 {
            self.refuse("a circle has no radius or more than 1000 turns");
            return Vec::new();
        }
        let own = counterpoint_control_api::contour::arc(self.flat(&self.actual), self.flat(&end), pole, clockwise);
        let mut turned = turned;
        if let Some(corner) = self.corner_ahead(own, &end).filter(|_| turned <= 360.0) {
            turned = angle_between(from, PolarPoint::of(pole, corner).angle, clockwise);
            self.path.base = Some(end);
        }
        let (begin, mut lines, mut last) = (self.actual, Vec::new(), self.actual);
        for (piece, part) in pieces(turned, LARGEST).enumerate() {
            let angle = from + if clockwise { -turned * part } else { turned * part };
            let mut to = end;
            for ((slot, from), end) in to.iter_mut().zip(&begin).zip(&end) {
                *slot = if part == 1.0 { *end } else { from + (end - from) * part };
            }
            self.put(&mut to, PolarPoint { radius, angle }.point(pole));
            let (code, sign) = self.circle_code("C", clockwise);
            let mut words = self.positions(&last, &to);
            words.extend(sign);
            words.extend(self.center_words(pole));
            if piece == 0 {
                let mut used = self.polar_words().to_vec();
                used.push("DR");
                words.extend(self.others(&used));
            }
            lines.push(headed(code, words));
            last = to;
        }
        self.path.restate = true;
        let to = self.flat(self.path.base.as_ref().unwrap_or(&last));
        self.leave_circle(pole, to, clockwise);
        lines
    }
}
