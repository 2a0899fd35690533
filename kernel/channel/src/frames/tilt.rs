//! Tilted planes: the program counts in a plane that lies on the part as it likes.
//!
//! While one is active the work frame is that of the plane: its zero and its axes lie in the frame that the program has
//! without it (`Tilted::map`), which is the part with the tables at zero. Once the rotary axes have turned into the
//! plane, or count as if they had, the linear axes follow the part and the tool to where they then are, as under tool
//! tip control; words of rotary axes move nothing else. *Invariant:* making, turning and ending a plane never moves the
//! linear axes, except for a turn that keeps the tool on the part. Facts: reference heidenhain-cycles.md 6,
//! siemens-cycles.md 2; Fanuc user's manual B-63944EN 21.2 (the plane turns with the table at G53.1). Decisions:
//! docs/emulation.md, "Tilted planes".

use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_machine::model::paths::Tilting;
use counterpoint_motion::frame::affine::{Affine, Point};
use counterpoint_motion::frame::beside::AxisMap;
use counterpoint_motion::frame::kinematics::unit;
use counterpoint_motion::frame::local::LocalFrame;
use counterpoint_motion::frame::orient::{FreeAxisPolicy, OrientationError, PairRule, RotaryAxisState, TiltRequest};
use counterpoint_motion::frame::plane::UNITS;

use super::FrameTransforms;
use crate::channel_context::ChannelContext;
use crate::frame_transforms::{Tilted, Turned};
use crate::position::MotionState;

impl Tilted {
    /// A point of the plane in the frame without it.
    pub(super) fn outwards(&self, point: Point) -> Point {
        self.map.point(point)
    }

    /// The way back.
    pub(super) fn inwards(&self, point: Point) -> Point {
        self.back.point(point)
    }

    /// From the plane to the frame without it.
    pub fn map(&self) -> &Affine {
        &self.map
    }

    fn length(&self, place: &MotionState) -> (Point, Point) {
        let fixture = place.geometry(&place.less(&place.shift, &self.tool));
        (fixture, place.geometry(&self.tool))
    }

    /// The linear axes at a point of the frame without the plane.
    pub(super) fn to_linear(&self, place: &MotionState, point: Point) -> Point {
        let (fixture, tool) = self.length(place);
        let part = plus(point, fixture);
        match &self.bring {
            Some([part_map, _, head]) => {
                plus(part_map.point(part), head.point(tool.map(|value| -value)).map(|value| -value))
            }
            None => plus(part, tool),
        }
    }

    /// The point of the frame without the plane where the linear axes are.
    pub(super) fn to_part(&self, place: &MotionState, linear: Point) -> Point {
        let (fixture, tool) = self.length(place);
        let back = |value: f64| -value;
        let part = match &self.bring {
            Some([_, part_back, head]) => part_back.point(plus(linear, head.point(tool.map(back)))),
            None => plus(linear, tool.map(back)),
        };
        plus(part, fixture.map(back))
    }
}

fn plus([a, b, c]: Point, [x, y, z]: Point) -> Point {
    [a + x, b + y, c + z]
}

impl FrameTransforms {
    /// A direction of the program on the part.
    pub fn direction(&self, of: Point) -> Point {
        let work = self.local.map().direction(of);
        self.tilt.as_deref().map_or(work, |tilt| tilt.map.direction(work))
    }

    /// A direction of the part as programmed.
    pub fn direction_back(&self, of: Point) -> Option<Point> {
        let work = self.tilt.as_deref().map_or(of, |tilt| tilt.back.direction(of));
        self.local.map().inverse().map(|back| back.direction(work))
    }
}

impl ChannelContext<'_> {
    /// Makes a plane the active one; `false` if it has no way back. The machine does not move.
    pub fn tilt(&mut self, map: Affine, angles: Option<Turned>) -> bool {
        let Some(back) = map.inverse() else { return false };
        let outer = match self.state.place.frames.as_deref() {
            Some(FrameTransforms { tilt: Some(tilt), .. }) => tilt.outer.clone(),
            Some(frames) => frames.local.clone(),
            None => LocalFrame::default(),
        };
        let assumed = self.env.machine.kinematics.tilting.assumed;
        let bring = angles.as_ref().filter(|_| assumed).map(|angles| self.brought(angles));
        let tool = self.tool_shift();
        self.put_plane(Some(Box::new(Tilted { map, back, outer, angles, bring, tool })), LocalFrame::default());
        true
    }

    /// Ends the plane; `false` if there was none. The machine does not move.
    pub fn end_tilt(&mut self) -> bool {
        let keeps = self.env.machine.kinematics.tilting.keeps_local;
        let Some(frames) = self.state.place.frames.as_deref_mut() else { return false };
        let Some(tilt) = frames.tilt.as_deref_mut() else { return false };
        let outer = std::mem::take(&mut tilt.outer);
        let local = if keeps && outer.is_empty() { frames.local.clone() } else { outer };
        self.put_plane(None, local);
        true
    }

    /// Takes the plane off for a while.
    pub fn lift_plane(&mut self) -> Option<(Box<Tilted>, LocalFrame)> {
        let frames = self.state.place.frames.as_deref()?;
        let lifted = (frames.tilt.clone()?, frames.local.clone());
        self.put_plane(None, LocalFrame::default());
        Some(lifted)
    }

    /// Puts it back, turned into with these angles.
    pub fn turned_into(&mut self, (mut tilt, local): (Box<Tilted>, LocalFrame), angles: Turned) {
        tilt.bring = Some(self.brought(&angles));
        tilt.angles = Some(angles);
        self.put_plane(Some(tilt), local);
    }

    fn put_plane(&mut self, tilt: Option<Box<Tilted>>, local: LocalFrame) {
        let levels = self.state.cycle_levels();
        let before = self.counts_from();
        self.standing(|channel| {
            let frames = channel.state.place.frames();
            (frames.tilt, frames.local, frames.parts) = (tilt, local, None);
        });
        self.state.place.keep_ways(before);
        self.state.keep_levels(levels);
    }

    /// Where tables bring the part and heads the tool at these angles.
    fn brought(&self, angles: &Turned) -> [Affine; 3] {
        let machine = self.state.place.machine_point(&self.state.place.position);
        let chain = self.chain();
        let angle = |axis: AxisSlot| {
            angles.iter().find(|(at, _)| *at == axis).map_or_else(|| machine.at(axis), |(_, angle)| *angle)
        };
        let part = chain.part(angle);
        [part, part.inverse().unwrap_or(Affine::SAME), chain.head(angle)]
    }

    /// Takes over new offsets of the tool; the point of the program is found again by the caller.
    pub fn refresh_tilt(&mut self) {
        let tool = self.tool_shift();
        if let Some(tilt) = self.state.place.frames.as_deref_mut().and_then(|frames| frames.tilt.as_deref_mut()) {
            tilt.tool = tool;
        }
    }

    /// The angles that turn into a plane.
    ///
    /// # Errors
    /// The rotary axes cannot go there.
    pub fn angles_into(&self, map: &Affine) -> Result<Turned, OrientationError> {
        let Tilting { turns, way, larger, zero, .. } = self.env.machine.kinematics.tilting;
        let wishes = &self.state.others.tilt;
        let side = wishes
            .side
            .map(|positive| if larger { TiltRequest::Larger(positive) } else { TiltRequest::Sign(positive) });
        let chain = self.chain();
        let [x, _, z] = UNITS;
        let free = match (wishes.table, chain.tables.last()) {
            // The plane turned about the axis of the table.
            (true, Some(table)) => FreeAxisPolicy::At(angle_about(table.vector, x, map.direction(x))),
            _ if zero => FreeAxisPolicy::At(0.0),
            _ => FreeAxisPolicy::Stays,
        };
        let rule = PairRule { turns, way, side, free };
        chain.reach(map.direction(z), &rule, |axis| self.state.place.stand(axis))
    }

    /// The rotary axis of the table that carries the part, with its direction as the program sees it; none without one
    /// or under control of the tip.
    pub fn part_table(&self) -> Option<(AxisSlot, Point)> {
        let machine = self.state.place.machine_point(&self.state.place.position);
        let chain = self.chain();
        let table = chain.tables.last().filter(|_| self.state.place.tip().is_none())?;
        let stands = unit(chain.part(|axis| machine.at(axis)).direction(table.vector))?;
        let back = self
            .state
            .place
            .tilted()
            .and_then(|tilt| tilt.bring.as_ref())
            .map_or(stands, |[_, back, _]| back.direction(stands));
        let frames = self.state.place.frames.as_deref();
        Some((table.axis, frames.map_or(Some(back), |frames| frames.direction_back(back))?))
    }

    /// The plane to which the tool is square at angles of the rotary axes, its axes along those of the machine.
    pub fn plane_at(&self, angles: &Turned) -> Option<Affine> {
        let [_, back, head] = self.brought(angles);
        let [x, z] = [UNITS[0], UNITS[2]].map(|unit| back.direction(head.direction(unit)));
        counterpoint_motion::frame::plane::of_directions(x, z)
    }
}

impl MotionState {
    /// The active plane.
    pub fn tilted(&self) -> Option<&Tilted> {
        self.frames.as_deref().and_then(|frames| frames.tilt.as_deref())
    }

    /// From the program to the part without the new plane: the transformations outside it.
    pub fn around_plane(&self, add: bool) -> Affine {
        let Some(frames) = self.frames.as_deref() else { return Affine::SAME };
        match &frames.tilt {
            Some(tilt) if add => tilt.map.after(frames.local.map()),
            Some(tilt) => *tilt.outer.map(),
            None => *frames.local.map(),
        }
    }

    /// The word that brings a rotary axis to an angle of the machine frame.
    pub fn programmed_angle(&self, axis: AxisSlot, angle: f64) -> f64 {
        let work = angle - self.shift.at(axis);
        self.line_of(axis).map_or(work, |line| line.to_program(work))
    }

    /// The angle of the machine frame that a word of a rotary axis means.
    pub fn machine_angle(&self, axis: AxisSlot, word: f64) -> f64 {
        self.line_of(axis).map_or(word, |line| line.to_work(word)) + self.shift.at(axis)
    }

    /// The linear map of an axis other than X, Y and Z in the local frame.
    pub fn line_of(&self, axis: AxisSlot) -> Option<AxisMap> {
        let beside = self.frames.as_deref()?.beside.as_deref()?;
        Some(beside.map().at(axis))
    }

    /// Position and travel limits of a rotary axis.
    pub fn stand(&self, axis: AxisSlot) -> RotaryAxisState {
        let at = self.position.at(axis) + self.shift.at(axis);
        RotaryAxisState { at, travel: self.layout.axes[axis].limits }
    }
}

/// Degrees that turn a direction to another one about an axis.
fn angle_about(axis: Point, from: Point, to: Point) -> f64 {
    let [axis, from, to] = [axis, from, to].map(nalgebra::Vector3::from);
    let axis = axis.normalize();
    libm::atan2(axis.dot(&from.cross(&to)), from.dot(&to) - axis.dot(&from) * axis.dot(&to)).to_degrees()
}
