//! Lines by their direction: a missing coordinate, or the crossing of two lines.
//!
//! Points are those of the program, in its own frame. *Invariant:* a coordinate that the angle does not determine is
//! reported, never guessed. Facts: reference turning-cycles.md 7.2, siemens-cycles.md (ANG).

use counterpoint_event::event::Position;
use counterpoint_fault as diag;
use counterpoint_machine::ident::codes;
use counterpoint_machine::index::{AxisSlot, BySlot as _};
use counterpoint_motion::contour::element::{Element, Spot, cross, direction, plus};

use super::words::polar;
use super::{ProgrammedMove, compensated_plane};
use crate::context::ActionContext;
use counterpoint_channel::corner::OpenLine;
use counterpoint_channel::modal::group;

/// Sine of the angle below which lines count as parallel: one degree.
const PARALLEL: f64 = 0.017_452;

/// Largest distance of a programmed end from the line of its angle.
const OFF: f64 = 0.01;

impl ActionContext<'_, '_> {
    /// Whether the line of this block gets its end from the next one.
    pub(crate) fn opens_line(&mut self) -> bool {
        self.channel_mut().state.place.cutter().is_some_and(|cutter| cutter.asked.open.is_some())
    }

    /// The programmed end of a line with an angle: coded axes and target.
    pub(crate) fn by_angle(&mut self, coded: u8, mut target: Position) -> (u8, Position) {
        let Some(cutter) = self.channel_mut().state.place.cutter() else { return (coded, target) };
        let (axes, angle) = (cutter.axes, cutter.asked.angle.take());
        let open = cutter.waiting.last().and_then(|waiting| waiting.open);
        if angle.is_none() && open.is_none() {
            return (coded, target);
        }
        let bits = axes.map(AxisSlot::bit);
        let [first, second] = bits.map(|bit| coded & bit != 0);
        let from = self.channel().state.place.programmed();
        let (start, end) = (self.flat(&from, axes), self.flat(&target, axes));
        match (open, angle) {
            (Some(open), Some(angle)) if first && second => {
                self.cross(open, (end, direction(angle)), axes);
            }
            (Some(_), _) => {
                let text = format!(
                    "the line before '{}' has no end: this block needs an angle and both coordinates of its end",
                    self.channel().block_text()
                );
                self.diagnose(&diag::LINE_WITHOUT_END, text);
                self.forget_corners();
            }
            (None, Some(angle)) => {
                let along = direction(angle);
                let way = plus(end, start, -1.0);
                let solved = match (first, second) {
                    (false, false) => {
                        let open = OpenLine { from, along };
                        if let Some(cutter) = self.channel_mut().state.place.cutter() {
                            cutter.asked.open = Some(open);
                        }
                        return (coded, target);
                    }
                    (true, true) => (cross(along, way).abs() <= OFF).then_some(end),
                    (true, false) => (along[0].abs() > PARALLEL).then(|| plus(start, along, way[0] / along[0])),
                    (false, true) => (along[1].abs() > PARALLEL).then(|| plus(start, along, way[1] / along[1])),
                };
                match solved {
                    Some(_) if first && second => {}
                    Some(spot) => {
                        let missing = usize::from(first);
                        self.put_flat(&mut target, (axes, missing), spot);
                        return (coded | bits[0] | bits[1], target);
                    }
                    None => self.not_computed("the angle and the coordinates do not give its end"),
                }
            }
            (None, None) => {}
        }
        (coded, target)
    }

    /// Whether the end of the block's move is given by its distance and angle from the pole, which is the centre of a
    /// circle without another centre.
    pub(crate) fn ends_by_pole(&mut self) -> bool {
        self.channel_mut().state.place.cutter().is_some_and(|cutter| cutter.asked.polar.is_some())
    }

    /// The programmed end of a move with polar coordinates: coded axes and target.
    pub(crate) fn polar_end(&mut self, coded: u8, mut target: Position) -> (u8, Position) {
        let Some(cutter) = self.channel_mut().state.place.cutter() else { return (coded, target) };
        let (axes, Some([radius, angle])) = (cutter.axes, cutter.asked.polar.take()) else { return (coded, target) };
        let spot = plus(self.flat(&self.channel().state.arcs.pole, axes), direction(angle), radius);
        for at in [0, 1] {
            self.put_flat(&mut target, (axes, at), spot);
        }
        (coded | axes.iter().fold(0, |bits, axis| bits | axis.bit()), target)
    }

    /// Moves the pole of polar coordinates from a point, by the words of the block.
    pub(crate) fn set_pole(&mut self, from: Position) {
        let Some((_, axes)) = compensated_plane(self) else {
            let text = format!("no plane with both axes is active for the pole of '{}'", self.channel().block_text());
            self.diagnose(&diag::CORNER_REFUSED, text);
            return;
        };
        let mut pole = from;
        for axis in axes {
            let id = self.channel().state.place.layout.axes[axis].data;
            *pole.at_mut(axis) += self.take(id).map_or(0.0, |datum| datum.value);
        }
        if let Some([radius, angle]) = polar(self) {
            let spot = plus(self.flat(&pole, axes), direction(angle), radius);
            for at in [0, 1] {
                self.put_flat(&mut pole, (axes, at), spot);
            }
        }
        self.channel_mut().state.arcs.pole = pole;
    }

    fn not_computed(&mut self, why: &str) {
        let text = format!("the line of '{}' is not computed: {why}", self.channel().block_text());
        self.diagnose(&diag::LINE_NOT_COMPUTED, text);
    }

    /// Ends the line that waits where it meets another one.
    fn cross(&mut self, open: OpenLine, (end, along): (Spot, Spot), axes: [AxisSlot; 2]) {
        let relative = self.channel().state.modal.code(group::POSITION) == Some(codes::POSITION_RELATIVE)
            || self.channel().block.words.iter().any(|word| word.incremental);
        let start = self.flat(&open.from, axes);
        let by = cross(open.along, along);
        if relative || by.abs() < PARALLEL {
            let why = if relative { "its end is incremental" } else { "it is parallel to the line before it" };
            self.not_computed(why);
            self.forget_corners();
            return;
        }
        let meets = plus(start, open.along, cross(plus(end, start, -1.0), along) / by);
        let mut point = open.from;
        for at in [0, 1] {
            self.put_flat(&mut point, (axes, at), meets);
        }
        let [from, to] = [open.from, point].map(|programmed| self.channel_mut().state.place.work_point(&programmed));
        let [first, last] = [from, to].map(|work| self.plane_spot(&work, axes));
        let Some(cutter) = self.channel_mut().state.place.cutter() else { return };
        let Some(waiting) = cutter.waiting.last_mut() else { return };
        waiting.open = None;
        for (slot, value) in waiting.step.to.iter_mut().zip(&to) {
            *slot = *value;
        }
        let element = Element { from: first, to: last, arc: None };
        waiting.element = Some(element).filter(|element| element.length() > 1e-7);
        cutter.contour = to;
    }

    /// A programmed point in the plane, as geometry.
    fn flat(&self, of: &Position, axes: [AxisSlot; 2]) -> Spot {
        axes.map(|axis| self.radial(of, axis))
    }

    /// Sets one coordinate of a programmed point to that of a point.
    fn put_flat(&self, position: &mut Position, (axes, at): ([AxisSlot; 2], usize), spot: Spot) {
        let (Some(axis), Some(value)) = (axes.get(at).copied(), spot.get(at)) else { return };
        let scale = self.channel().state.place.layout.axes[axis].scale;
        let slot = position.at_mut(axis);
        *slot = counterpoint_channel::frames::clean(value / scale, *slot);
    }

    /// A line without an end waits for the next one.
    pub(crate) fn wait_for_end(&mut self, step: ProgrammedMove) {
        let corner = self.channel_mut().state.place.cutter().and_then(|cutter| cutter.asked.corner.take());
        self.wait(step, None, corner);
    }
}
