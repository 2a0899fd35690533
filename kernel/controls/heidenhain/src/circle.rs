//! Circles of path blocks, and their centres.
//!
//! Facts: programming manuals of the control (C, CR, CT, CC; G2, G3, G5, G6, I, J, K). Invariant: the centre of a
//! circle comes either from `CC` before it or by words of its own block, never by both.

use counterpoint_control_api::contour;
use counterpoint_control_api::contour::{Point, Tangent, center_by_radius, minus};

use super::path_state::{AXES, PathBlockKind, PathBuilder, Position, axis};
use super::words::{EvaluatedWord, LeftBlock, headed};

impl PathBuilder<'_> {
    /// Direction of a circle: before its words in ISO programs, after them in others.
    pub(super) fn circle_code(&self, code: &'static str, clockwise: bool) -> (&'static str, Option<EvaluatedWord>) {
        match self.step.iso && self.path.mode.is_some() {
            true => (if clockwise { "G2" } else { "G3" }, None),
            false => (code, Some(EvaluatedWord::turn(clockwise))),
        }
    }

    /// An arc of less than a circle by its radius; a negative one takes the longer path.
    pub(super) fn by_radius(
        &mut self,
        to: &Position,
        radius: f64,
        clockwise: bool,
        others: Vec<EvaluatedWord>,
    ) -> LeftBlock {
        let (code, sign) = self.circle_code("CR", clockwise);
        self.path.restate = true;
        let mut words = self.positions(&self.actual, to);
        words.push(EvaluatedWord::made("R", radius));
        words.extend(sign);
        headed(code, words.into_iter().chain(others))
    }

    /// Direction at the end of a circle.
    pub(super) fn leave_circle(&mut self, center: Point, end: Point, clockwise: bool) {
        self.head_for(contour::heading_on(center, end, clockwise));
        self.ends_at(end);
        (self.path.clockwise, self.path.round) = (Some(clockwise), true);
    }

    /// Whether the machine keeps the centre that `CC` defines.
    pub(super) fn keeps_center(&self) -> bool {
        self.host.is_code_text("CC")
    }

    /// Centre words of a circle, where the machine does not keep the centre.
    pub(super) fn center_words(&self, center: Point) -> Vec<EvaluatedWord> {
        if self.keeps_center() {
            return Vec::new();
        }
        let letters = self.path.plane.map(|axis| ["I", "J", "K"].get(axis).copied().unwrap_or("I"));
        letters.into_iter().zip(center).map(|(letter, value)| EvaluatedWord::made(letter, value)).collect()
    }

    pub(super) fn circle(&mut self, shape: PathBlockKind) -> Vec<LeftBlock> {
        if shape == PathBlockKind::Arc
            && let Some(pole) = self.upright_of_circle()
        {
            return self.upright_circle(pole);
        }
        let own = self.take_center();
        let end = self.target();
        let (start, to) = (self.flat(&self.start), self.flat(&end));
        let Some(clockwise) = self.path.clockwise else {
            self.path.base = None;
            self.refuse("the circle has no direction of rotation");
            return vec![self.verbatim(Vec::new())];
        };
        let radius = self.step.seen.iter().find(|word| word.is("R") && !word.is_off()).and_then(|word| word.value);
        let mut centre = Vec::new();
        let center = if shape == PathBlockKind::Arc {
            let Some(pole) = self.path.poles.flat else {
                self.path.base = None;
                self.refuse("the circle has no centre (CC)");
                return vec![self.verbatim(Vec::new())];
            };
            centre = self.center_words(pole);
            Some(pole)
        } else {
            radius.and_then(|radius| center_by_radius(start, to, radius, clockwise))
        };
        let base = self.path.base.take();
        let mut lines = Vec::new();
        if own && self.keeps_center() {
            lines.extend(center.filter(|_| shape == PathBlockKind::Arc).map(|pole| self.pole_line(pole)));
        }
        if let Some(center) = center {
            // After a corner the tool is on the circle already.
            let element = contour::arc(self.flat(&self.actual), to, center, clockwise);
            let shortened = if self.step.iso {
                if self.corner_follows() {
                    self.refuse("corners next to circles of ISO programs are not supported");
                }
                None
            } else {
                self.corner_ahead(element, &end)
            };
            self.leave_circle(center, to, clockwise);
            if shortened.is_some() || base.is_some() && shape == PathBlockKind::Radius {
                let mut stop = end;
                if let Some(corner) = shortened {
                    self.put(&mut stop, corner);
                    self.path.base = Some(end);
                }
                return vec![self.arc_to(&stop, center, clockwise, shape, radius)];
            }
        }
        let by_last = self.step.iso && self.path.mode == Some(5);
        // An end that is not programmed is where the tool is: a full circle.
        let full = shape == PathBlockKind::Arc && !self.step.iso && !self.coded().contains(&true);
        let rewritten = base.is_some() && self.has_increments() || own && self.keeps_center() || by_last || full;
        if !rewritten {
            lines.push(self.verbatim(if own { Vec::new() } else { centre }));
            return lines;
        }
        let (code, sign) = self.circle_code(self.step.shape.head(), clockwise);
        self.path.restate = true;
        let mut words = self.positions(&self.actual, &end);
        words.extend(self.others(&["I", "J", "K", "DR"]));
        words.extend(sign);
        words.extend(centre);
        lines.push(headed(code, words));
        lines
    }

    /// A circle whose start or end a corner has taken.
    fn arc_to(
        &mut self,
        to: &Position,
        center: Point,
        clockwise: bool,
        shape: PathBlockKind,
        radius: Option<f64>,
    ) -> LeftBlock {
        let others = self.others(&["I", "J", "K", "DR", "R"]);
        if shape == PathBlockKind::Arc {
            let (code, sign) = self.circle_code("C", clockwise);
            self.path.restate = true;
            let mut words = self.positions(&self.actual, to);
            words.extend(others);
            words.extend(sign);
            words.extend(self.center_words(center));
            return headed(code, words);
        }
        let radius = self.radius_to(to, center, clockwise, radius.unwrap_or(0.0));
        self.by_radius(to, radius, clockwise, others)
    }

    /// A radius for the path from the tool to a point of its circle: below zero for more than half a circle.
    fn radius_to(&self, to: &Position, center: Point, clockwise: bool, radius: f64) -> f64 {
        let element = contour::arc(self.flat(&self.actual), self.flat(to), center, clockwise);
        let longer = element.arc.is_some_and(|arc| arc.sweep.abs() > std::f64::consts::PI);
        if longer { -radius.abs() } else { radius.abs() }
    }

    /// Takes a centre from words of an ISO block.
    pub(super) fn take_center(&mut self) -> bool {
        let start = self.flat(&self.start);
        let mut pole = self.path.poles.flat.unwrap_or(start);
        let mut found = false;
        for word in &self.step.seen {
            let role = match &*word.name {
                "I" => 0,
                "J" => 1,
                "K" => 2,
                _ => continue,
            };
            let side = self.path.plane.iter().position(|axis| *axis == role);
            let (Some(value), Some(side)) = (word.value, side) else { continue };
            if let (Some(slot), Some(from)) = (pole.get_mut(side), start.get(side)) {
                *slot = if self.path.increments { from + value } else { value };
                found = true;
            }
        }
        if found {
            self.path.poles.flat = Some(pole);
        }
        found
    }

    pub(super) fn pole_line(&self, pole: Point) -> LeftBlock {
        let letters = self.path.plane.map(|axis| AXES.get(axis).copied().unwrap_or("X"));
        headed("CC", letters.into_iter().zip(pole).map(|(letter, value)| EvaluatedWord::made(letter, value)))
    }

    /// The pole that words define. Without a word it stays where it was along that axis; without any it is where the
    /// tool is.
    pub(super) fn pole_of(&self, seen: &[EvaluatedWord], start: &Position) -> Option<Point> {
        let here = self.flat(start);
        let new = self.flat(&self.target_of(seen, start));
        let said = self.path.plane.map(|at| {
            seen.iter().any(|word| word.value.is_some() && axis(&word.name).is_some_and(|(own, _)| own == at))
        });
        let old = if said.contains(&true) { self.path.poles.flat.unwrap_or(here) } else { here };
        Some([if said[0] { new[0] } else { old[0] }, if said[1] { new[1] } else { old[1] }])
    }

    pub(super) fn pole(&mut self) -> Vec<LeftBlock> {
        let upright = self.upright_pole();
        if let Some(upright) = upright {
            return self.stand_pole(upright);
        }
        self.path.poles.upright = None;
        if !self.take_center() {
            self.path.poles.flat = self.pole_of(&self.step.seen, &self.start);
        }
        let others = self.others(&["I", "J", "K"]);
        let mut lines = Vec::new();
        if let Some(pole) = self.path.poles.flat.filter(|_| self.keeps_center()) {
            lines.push(self.pole_line(pole));
        }
        if !others.is_empty() {
            lines.push(others);
        }
        lines
    }

    /// A circle that continues in the direction of the last element.
    pub(super) fn tangent(&mut self, end: Position) -> Vec<LeftBlock> {
        let (start, to) = (self.flat(&self.actual), self.flat(&end));
        self.path.base = None;
        let others = self.others(self.polar_words());
        let Some(heading) = self.path.heading else {
            self.refuse("a tangential circle needs a path block before it");
            return vec![self.straight(&end, others)];
        };
        match contour::tangent(start, heading, to) {
            Tangent::Arc { center, radius, clockwise } => {
                let element = contour::arc(start, to, center, clockwise);
                let (mut stop, mut radius) = (end, radius);
                if let Some(corner) = self.corner_ahead(element, &end) {
                    self.put(&mut stop, corner);
                    self.path.base = Some(end);
                    radius = self.radius_to(&stop, center, clockwise, radius);
                }
                let line = self.by_radius(&stop, radius, clockwise, others);
                self.leave_circle(center, to, clockwise);
                vec![line]
            }
            straight => {
                if straight == Tangent::Back {
                    self.refuse("a tangential circle cannot lead straight back");
                }
                self.head_for(minus(to, start));
                vec![self.straight(&end, others)]
            }
        }
    }
}
