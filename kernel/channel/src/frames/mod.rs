//! From the programmed point to the machine point and back.
//!
//! | point | is | here |
//! |---|---|---|
//! | programmed | the values of the words, in the local frame | [`MotionState::programmed`] |
//! | work | after scale, mirror, rotation, translation: `MotionState::position` | [`MotionState::work_point`] |
//! | machine | after offsets, presets and lengths: `MotionState::shift` | [`MotionState::machine_point`] |
//!
//! Events have work points. Lengths, feeds and arcs are those of the work frame. Transformations that couple axes to
//! each other between the work frame and the axes of the machine (tool tip control, tilted planes) are in
//! [`MotionState::machine_point`] and its inverse [`MotionState::point_of_machine`]. Travel limits, `G53`,
//! reference points, changes of frames, joint positions and rates of rapids all use these two. Changes of programmed
//! words before they are points are in [`MotionState::work_point`] and [`MotionState::programmed`]. Polar
//! interpolation is there, since events name the axes.
//!
//! Under compensation of the cutter radius `MotionState::position` is where the tool is. [`MotionState::contour`]
//! is the point of the work frame that the program has reached.
//!
//! *Invariant:* `MotionState::frames` is `None` unless one of these is active. A point that has come from the program
//! goes back to it unchanged. Facts: reference control-emulator.md 6.7.

mod compensated;
mod distance;
pub mod feeds;
pub mod levels;
pub mod offsets;
pub mod polar;
pub mod shift;
pub mod tilt;
pub mod tip;
mod travel;
mod values;
pub mod words;

use counterpoint_event::event::Position;
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_motion::frame::affine::{Affine, Point};
use counterpoint_motion::frame::beside::{AuxiliaryFrame, AxisMap, SAME};
use counterpoint_motion::frame::local::FrameError;

use super::channel_context::ChannelContext;
use super::position::MotionState;
use crate::frame_transforms::PolarInterpolation;
use crate::frame_transforms::{Feeds, FrameTransforms};

/// Differences below this are none.
const NOISE: f64 = 1e-9;
const PER_UNIT: f64 = 1e9;

/// Largest coordinate whose noise is removed.
const FINE: f64 = 1e6;

impl FrameTransforms {
    /// Whether nothing is active any more.
    fn is_idle(&self) -> bool {
        self.local.is_empty()
            && self.beside.is_none()
            && self.polar.is_none()
            && self.words.is_none()
            && self.tilt.is_none()
            && self.parts.is_none()
            && self.tip.is_none()
            && self.cutter.is_none()
            && self.rounding.is_none()
            && self.feeds == Feeds::default()
            && self.ways.is_none()
            && self.shifts.is_none()
    }

    /// Whether a local frame is programmed and not switched off.
    pub fn is_on(&self) -> bool {
        self.local.is_on() || self.beside.as_deref().is_some_and(AuxiliaryFrame::is_on)
    }

    /// Switches the programmed parts of the local frame off, or on again. `has`: the channel has an X, Y, Z axis.
    pub fn switch(&mut self, on: bool, has: [bool; 3]) -> Result<(), FrameError> {
        self.local.switch(on, has)?;
        if let Some(beside) = &mut self.beside {
            **beside = beside.switched(on);
        }
        Ok(())
    }

    /// Work points differ from programmed ones by the local frame.
    pub fn changes_points(&self) -> bool {
        *self.local.map() != Affine::SAME || self.beside.as_deref().is_some_and(|beside| *beside.map() != SAME)
    }

    /// Linear axes do not follow the work frame one by one.
    #[inline(always)]
    pub fn couples(&self) -> bool {
        self.tip.is_some() || self.tilt.is_some()
    }

    /// The linear axes at a point of the work frame; `machine` has the rotary axes already.
    #[cold]
    fn to_linear(&self, place: &MotionState, work: &Position, machine: &mut Position) {
        let point = place.geometry(work);
        let point = self.tilt.as_deref().map_or(point, |tilt| tilt.outwards(point));
        let linear = match (&self.tip, &self.tilt) {
            (Some(tip), _) => tip.to_linear(place, point, machine),
            (None, Some(tilt)) => tilt.to_linear(place, point),
            (None, None) => return,
        };
        place.put(machine, linear);
    }

    /// The point of the work frame where the axes are; `work` has the rotary axes already.
    #[cold]
    fn to_part(&self, place: &MotionState, machine: &Position, work: &mut Position) {
        let linear = place.geometry(machine);
        let point = match (&self.tip, &self.tilt) {
            (Some(tip), _) => tip.to_part(place, linear, machine),
            (None, Some(tilt)) => Some(tilt.to_part(place, linear)),
            (None, None) => return,
        };
        if let Some(point) = point {
            place.put(work, self.tilt.as_deref().map_or(point, |tilt| tilt.inwards(point)));
        }
    }

    /// Axis that says the distance across while words are coordinates of the part.
    fn across(&self, place: &MotionState) -> Option<AxisSlot> {
        let x = place.layout.cartesian.first().copied().flatten();
        let across = |polar: &PolarInterpolation| polar.cartesian && (polar.is_cylinder() || Some(polar.linear) == x);
        self.polar.filter(across).map(|polar| polar.rotary)
    }

    /// A programmed point as the local frame sees it; the distance across counts as Y.
    pub fn seen(&self, place: &MotionState, programmed: &Position) -> Point {
        let mut point = place.geometry(programmed);
        if let Some(across) = self.across(place) {
            point[1] = programmed.at(across);
        }
        point
    }

    /// Transforms the axes other than X, Y and Z. Polar and cylindrical interpolation count the rotary axis in the
    /// work frame (Siemens MD24905 and MD24805 = 0).
    fn beside(&self, place: &MotionState, position: &mut Position, lead: impl Fn(AxisMap, f64) -> f64) {
        let Some(beside) = &self.beside else { return };
        let polar = self.polar.map(|polar| polar.rotary);
        for axis in place.layout.axes.ids().filter(|axis| place.layout.is_beside(*axis) && polar != Some(*axis)) {
            let slot = position.at_mut(axis);
            *slot = clean(lead(beside.map().at(axis), *slot), *slot);
        }
    }

    /// Puts a point transformed by the local frame back.
    fn put(&self, place: &MotionState, position: &mut Position, mut point: Point) {
        if let Some(across) = self.across(place) {
            *position.at_mut(across) = clean(point[1], position.at(across));
            point[1] = place.geometry(position)[1];
        }
        place.put(position, point);
    }
}

impl MotionState {
    /// X, Y, Z of a position as geometry; 0 for an axis that the channel does not have.
    pub fn geometry(&self, position: &Position) -> Point {
        self.layout.cartesian.map(|axis| axis.map_or(0.0, |axis| position.at(axis) * self.layout.axes[axis].scale))
    }

    /// Which of the X, Y and Z axes the channel has.
    pub fn has_axes(&self) -> [bool; 3] {
        self.layout.cartesian.map(|axis| axis.is_some())
    }

    /// Factor from programmed values to geometry of the X, Y or Z axis.
    pub fn scale_of(&self, role: usize) -> f64 {
        let axis = self.layout.cartesian.get(role).copied().flatten();
        axis.map_or(1.0, |axis| self.layout.axes[axis].scale)
    }

    /// Puts geometry into a position.
    fn put(&self, position: &mut Position, point: Point) {
        for (axis, value) in self.layout.cartesian.iter().zip(point) {
            if let Some(axis) = *axis {
                *position.at_mut(axis) = clean(value / self.layout.axes[axis].scale, position.at(axis));
            }
        }
    }
}

/// A coordinate without the noise of its computation; `old` if it has not changed.
pub fn clean(value: f64, old: f64) -> f64 {
    if (value - old).abs() < NOISE {
        old
    } else if value.abs() < FINE {
        (value * PER_UNIT).round() / PER_UNIT
    } else {
        value
    }
}

impl ChannelContext<'_> {
    /// Changes the transformation from the work frame to the axes: the axes and the contour keep their positions.
    pub fn standing(&mut self, change: impl FnOnce(&mut Self)) {
        let machine = self.state.place.machine_point(&self.state.place.position);
        let contour = self
            .state
            .place
            .cutter()
            .map(|cutter| cutter.contour)
            .map(|contour| self.state.place.machine_point(&contour));
        change(self);
        self.state.place.position = self.state.place.point_of_machine(&machine);
        let contour = contour.map(|contour| self.state.place.point_of_machine(&contour));
        if let (Some(cutter), Some(contour)) = (self.state.place.cutter(), contour) {
            cutter.contour = contour;
        }
        self.state.place.frames_changed();
    }
}

impl MotionState {
    /// Linear axes do not follow the work frame one by one.
    #[inline(always)]
    pub fn couples(&self) -> bool {
        self.frames.as_deref().is_some_and(FrameTransforms::couples)
    }

    /// The programmed point where the channel is.
    #[inline(always)]
    pub fn programmed(&self) -> Position {
        match &self.frames {
            None => self.position,
            Some(frames) => self.programmed_point(frames, &self.contour()),
        }
    }

    /// Where the program is in the work frame: beside the tool's place under compensation of the cutter radius.
    pub fn contour(&self) -> Position {
        let cutter = self.frames.as_deref().and_then(|frames| frames.cutter.as_deref());
        cutter.map_or(self.position, |cutter| cutter.contour)
    }

    /// The programmed point of a point of the work frame.
    #[cold]
    fn programmed_point(&self, frames: &FrameTransforms, work: &Position) -> Position {
        if let Some([reached, programmed]) = &frames.reached
            && reached == work
        {
            return *programmed;
        }
        let mut point = *work;
        if let Some(polar) = frames.polar {
            polar.to_program(self, &mut point);
        }
        let seen = frames.seen(self, &point);
        frames.put(self, &mut point, frames.local.to_program(seen));
        frames.beside(self, &mut point, AxisMap::to_program);
        point
    }

    /// A programmed point as the local frame sees it.
    pub fn seen(&self, programmed: &Position) -> Point {
        let frames = self.frames.as_deref();
        frames.map_or_else(|| self.geometry(programmed), |frames| frames.seen(self, programmed))
    }

    /// A point of the work frame as the local frame sees it from outside.
    pub fn seen_from_work(&self, work: &Position) -> Point {
        let mut point = *work;
        if let Some(polar) = self.polar() {
            polar.to_program(self, &mut point);
        }
        self.seen(&point)
    }

    /// Any point of the work frame as it would be programmed.
    pub fn program_point(&self, work: &Position) -> Position {
        self.frames.as_deref().map_or(*work, |frames| self.programmed_point(frames, work))
    }

    /// The point of the work frame that the program means.
    #[inline(always)]
    pub fn work_point(&mut self, programmed: &Position) -> Position {
        if self.frames.is_none() { *programmed } else { self.reach(programmed) }
    }

    /// The same for a point to which the tool does not go.
    pub fn work_point_aside(&mut self, programmed: &Position) -> Position {
        let reached = self.frames.as_deref().and_then(|frames| frames.reached);
        let work = self.work_point(programmed);
        if let Some(frames) = self.frames.as_deref_mut() {
            frames.reached = reached;
        }
        work
    }

    #[cold]
    fn reach(&mut self, programmed: &Position) -> Position {
        let Some(frames) = self.frames.as_deref() else { return *programmed };
        let mut work = *programmed;
        frames.put(self, &mut work, frames.local.to_work(frames.seen(self, programmed)));
        frames.beside(self, &mut work, AxisMap::to_work);
        for (slot, stands) in work.iter_mut().zip(self.contour()) {
            *slot = clean(*slot, stands);
        }
        if let Some(polar) = frames.polar {
            polar.to_axes(self, &mut work);
        }
        if let Some(frames) = self.frames.as_deref_mut() {
            frames.reached = Some([work, *programmed]);
        }
        work
    }

    /// Where the axes are at a point of the work frame.
    #[inline(always)]
    pub fn machine_point(&self, work: &Position) -> Position {
        let mut machine = *work;
        for (slot, shift) in machine.iter_mut().zip(&self.shift) {
            *slot += shift;
        }
        if let Some(frames) = self.frames.as_deref()
            && frames.couples()
        {
            frames.to_linear(self, work, &mut machine);
        }
        machine
    }

    /// The point of the work frame where the axes are here.
    #[inline(always)]
    pub fn point_of_machine(&self, machine: &Position) -> Position {
        let mut work = *machine;
        for (slot, shift) in work.iter_mut().zip(&self.shift) {
            *slot -= shift;
        }
        if let Some(frames) = self.frames.as_deref()
            && frames.couples()
        {
            frames.to_part(self, machine, &mut work);
        }
        work
    }

    /// The same, with the axes that stay exactly where they are.
    pub fn way_of_machine(&self, machine: &Position) -> Position {
        let mut work = self.point_of_machine(machine);
        for (slot, stands) in work.iter_mut().zip(&self.position) {
            if (*slot - stands).abs() < NOISE {
                *slot = *stands;
            }
        }
        work
    }

    /// The frames, made if there are none.
    pub fn frames(&mut self) -> &mut FrameTransforms {
        self.frames.get_or_insert_default()
    }

    /// Called after a change of the frames: the machine does not move, only the programmed point changes.
    pub fn frames_changed(&mut self) {
        if let Some(frames) = self.frames.as_deref_mut() {
            frames.reached = None;
        }
        if self.frames.as_deref().is_some_and(FrameTransforms::is_idle) {
            self.frames = None;
        }
    }
}
