//! Circles and polar coordinates outside the working plane: `CC` with the tool axis, then `C`, `LP` or `CP`.
//!
//! Facts: programming manual of the control (circles that do not lie in the working plane; the axes of the pole select
//! the plane of polar coordinates); the angle of a plane counts from its first axis: X to Y, Y to Z, Z to X.
//! *Invariant:* the working plane and its pole are the same after the block as before it.

use counterpoint_control_api::contour::Point;

use super::path_state::{PathBlockKind, PathBuilder, Poles, axis};
use super::words::{EvaluatedWord, LeftBlock};

/// Axes of a plane.
type Plane = [usize; 2];

/// The planes, each with the first and the second axis of its angles.
const PLANES: [Plane; 3] = [[0, 1], [1, 2], [2, 0]];

/// The axis of a tool that works in each plane, as it selects the plane.
const TOOL_AXES: [&str; 3] = ["Z", "X", "Y"];

impl PathBuilder<'_> {
    /// The pole of a `CC` with two axes that are not those of the working plane.
    pub(super) fn upright_pole(&self) -> Option<(Plane, Point)> {
        let said = |at: usize| {
            let of = |name: &str| axis(name).is_some_and(|(own, _)| own == at);
            self.step.seen.iter().any(|word| word.value.is_some() && of(&word.name))
        };
        let is_said = |plane: &&Plane| said(plane[0]) && said(plane[1]);
        if self.step.iso || said(0) && said(1) && said(2) {
            return None;
        }
        let plane = PLANES.iter().find(is_said).copied().filter(|plane| *plane != self.path.plane)?;
        let position = self.target_of(&self.step.seen, &self.start);
        Some((plane, plane.map(|at| position.get(at).copied().unwrap_or(0.0))))
    }

    /// Keeps such a pole. Along the axis that both planes have it is that of the working plane, too.
    pub(super) fn stand_pole(&mut self, (plane, pole): (Plane, Point)) -> Vec<LeftBlock> {
        self.path.poles.upright = Some((plane, pole));
        let mut flat = self.path.poles.flat.unwrap_or_else(|| self.flat(&self.start));
        for (slot, own) in flat.iter_mut().zip(self.path.plane) {
            if let Some((_, value)) = plane.into_iter().zip(pole).find(|(axis, _)| *axis == own) {
                *slot = value;
            }
        }
        self.path.poles.flat = Some(flat);
        if self.keeps_center() { vec![self.pole_line(flat)] } else { Vec::new() }
    }

    /// The pole of a circle outside the working plane: the last one is there, and so are all axes of the block.
    pub(super) fn upright_of_circle(&self) -> Option<(Plane, Point)> {
        let (plane, pole) = self.path.poles.upright?;
        let mut axes = self.step.seen.iter().filter(|word| word.value.is_some()).filter_map(|word| axis(&word.name));
        axes.all(|(own, _)| plane.contains(&own)).then_some((plane, pole))
    }

    /// A circle about such a pole: its plane is selected for this block alone.
    pub(super) fn upright_circle(&mut self, upright: (Plane, Point)) -> Vec<LeftBlock> {
        self.upright_arc(upright, |walk| walk.circle(PathBlockKind::Arc))
    }

    /// A line, or a circle, to a point in polar coordinates about such a pole.
    pub(super) fn upright_polar(&mut self, upright: (Plane, Point), shape: PathBlockKind) -> Vec<LeftBlock> {
        match shape {
            PathBlockKind::PolarLine if self.path.side.is_left.is_none() => self.upright(upright, Self::polar_line),
            PathBlockKind::PolarArc => self.upright_arc(upright, Self::polar_arc),
            _ => {
                self.refuse(
                    "polar coordinates outside the working plane (CC with the tool axis) need LP or CP without radius \
                     compensation",
                );
                Vec::new()
            }
        }
    }

    fn upright_arc(
        &mut self,
        (plane, pole): (Plane, Point),
        make: impl FnOnce(&mut Self) -> Vec<LeftBlock>,
    ) -> Vec<LeftBlock> {
        let tool_axis =
            |of: Plane| PLANES.iter().zip(TOOL_AXES).find(|(known, _)| **known == of).map(|(_, letter)| letter);
        let (Some(there), Some(back)) = (tool_axis(plane), tool_axis(self.path.plane)) else { return Vec::new() };
        if self.path.side.is_left.is_some() || !self.host.is_code_text(there) {
            self.refuse("a circle outside the working plane cannot be made here");
            return Vec::new();
        }
        let mut lines = vec![vec![EvaluatedWord::text(there)]];
        if self.keeps_center() {
            let working = std::mem::replace(&mut self.path.plane, plane);
            lines.push(self.pole_line(pole));
            self.path.plane = working;
        }
        lines.extend(self.upright((plane, pole), make));
        lines.push(vec![EvaluatedWord::text(back)]);
        if let Some(flat) = self.path.poles.flat.filter(|_| self.keeps_center()) {
            lines.push(self.pole_line(flat));
        }
        lines
    }

    /// Makes blocks in another plane about the pole of that plane.
    fn upright(
        &mut self,
        (plane, pole): (Plane, Point),
        make: impl FnOnce(&mut Self) -> Vec<LeftBlock>,
    ) -> Vec<LeftBlock> {
        let (working, poles) = (self.path.plane, self.path.poles);
        self.path.plane = plane;
        self.path.poles = Poles { flat: Some(pole), upright: None };
        let lines = make(self);
        (self.path.plane, self.path.poles) = (working, poles);
        // The next element in the working plane has no direction to continue from.
        self.path.heading = None;
        lines
    }
}
