//! Polar and cylindrical interpolation: points of the part that one linear and one rotary axis reach together.
//!
//! The part has coordinates of its own. On its face (polar) the first one is along the linear axis when the
//! interpolation begins, the second one across, both as geometry (radii). On a cylinder one is along its axis, the
//! other is the travel around its surface. Positions stay those of the real axes; the program says coordinates
//! (Cartesian), or the words of the axes, and moves are straight or round on the part. Facts: reference
//! control-emulator.md 6.8, turning-cycles.md 10. *Invariant:* on the face the rotary axis never turns further than the
//! move goes around the centre.

use counterpoint_event::event::Position;
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_motion::frame::affine::turn;

use super::{FrameTransforms, NOISE, clean};
use crate::channel_context::ChannelContext;
use crate::frame_transforms::{InterpolationSurface, PolarInterpolation};
use crate::position::MotionState;

/// Distances from the centre below this have no direction.
const CENTRE: f64 = 1e-9;

/// A position of an axis without the noise of its computation; finer than a coordinate, which is computed from it
/// again.
fn fine(value: f64, old: f64) -> f64 {
    const PER_UNIT: f64 = 1e12;
    if (value - old).abs() < NOISE {
        old
    } else if value.abs() < 1e3 {
        (value * PER_UNIT).round() / PER_UNIT
    } else {
        value
    }
}

/// Degrees from one direction to another, −180 to 180; 0 if one of them is none.
pub fn between([ax, ay]: [f64; 2], [bx, by]: [f64; 2]) -> f64 {
    if ax.hypot(ay) < CENTRE || bx.hypot(by) < CENTRE {
        return 0.0;
    }
    libm::atan2(ax * by - ay * bx, ax * bx + ay * by).to_degrees()
}

/// Degrees that a path of short steps goes around the centre.
pub fn round_the_centre(points: impl Iterator<Item = [f64; 2]>) -> f64 {
    let mut sum = 0.0;
    let mut last: Option<[f64; 2]> = None;
    for point in points {
        sum += last.map_or(0.0, |last| between(last, point));
        last = Some(point);
    }
    sum
}

impl PolarInterpolation {
    /// Interpolation on the face that begins where the axes are.
    pub fn new(place: &MotionState, linear: AxisSlot, rotary: AxisSlot, cartesian: bool) -> Self {
        let at = |of: &Position, axis: AxisSlot| of.at(axis);
        let zero = at(&place.position, rotary) + at(&place.shift, rotary);
        let side = if at(&place.position, linear) < 0.0 { -1.0 } else { 1.0 };
        Self { linear, rotary, cartesian, shape: InterpolationSurface::Face { zero, side } }
    }

    /// Interpolation on a cylinder of this radius about the rotary axis; its linear axis goes along it.
    pub fn cylinder([linear, rotary]: [AxisSlot; 2], radius: f64, round_first: bool, cartesian: bool) -> Self {
        let shape = InterpolationSurface::Cylinder { per_degree: radius.to_radians(), round_first };
        Self { linear, rotary, cartesian, shape }
    }

    /// Whether it is that of a cylinder.
    pub fn is_cylinder(&self) -> bool {
        matches!(self.shape, InterpolationSurface::Cylinder { .. })
    }

    /// Its axes in the order of the coordinates of its plane.
    pub fn axes(&self) -> [AxisSlot; 2] {
        match self.shape {
            InterpolationSurface::Cylinder { round_first: true, .. } => [self.rotary, self.linear],
            _ => [self.linear, self.rotary],
        }
    }

    /// Distance on the surface of a cylinder per degree.
    pub fn per_degree(&self) -> Option<f64> {
        match self.shape {
            InterpolationSurface::Cylinder { per_degree, .. } => Some(per_degree),
            InterpolationSurface::Face { .. } => None,
        }
    }

    /// The angle of the rotary axis in the work frame where the first coordinate points along the linear axis.
    fn zero(&self, place: &MotionState, zero: f64) -> f64 {
        if self.cartesian { zero - place.shift.at(self.rotary) } else { 0.0 }
    }

    fn scale(&self, place: &MotionState) -> f64 {
        place.layout.axes[self.linear].scale
    }

    /// The point of the part that the axes reach.
    pub fn part(&self, place: &MotionState, real: &Position) -> [f64; 2] {
        let along = real.at(self.linear) * self.scale(place);
        match self.shape {
            InterpolationSurface::Face { zero, .. } => {
                let (sine, cosine) = turn(real.at(self.rotary) - self.zero(place, zero));
                [along * cosine, along * sine]
            }
            InterpolationSurface::Cylinder { per_degree, round_first } => {
                in_order(round_first, [along, real.at(self.rotary) * per_degree])
            }
        }
    }

    /// A point of the part by X at C0 and the direction at right angles to it, on a face.
    pub fn on_face(&self, place: &MotionState, [along, across]: [f64; 2]) -> Option<[f64; 2]> {
        let InterpolationSurface::Face { zero, .. } = self.shape else { return None };
        let (sine, cosine) = turn(self.zero(place, zero));
        Some([along * cosine - across * sine, along * sine + across * cosine])
    }

    /// Puts the axes to a point of the part. `round`: degrees of the way around the centre of a face from where they
    /// are.
    pub fn reach(&self, place: &MotionState, real: &mut Position, to: [f64; 2], round: f64) {
        let stands = place.position.at(self.rotary);
        match self.shape {
            InterpolationSurface::Cylinder { per_degree, round_first } => {
                let [along, way] = in_order(round_first, to);
                *real.at_mut(self.linear) = fine(along / self.scale(place), real.at(self.linear));
                *real.at_mut(self.rotary) = fine(way / per_degree, stands);
            }
            InterpolationSurface::Face { zero, side } => {
                let [x, y] = to;
                let distance = x.hypot(y);
                *real.at_mut(self.linear) = fine(side * distance / self.scale(place), real.at(self.linear));
                let slot = real.at_mut(self.rotary);
                if distance < CENTRE {
                    *slot = stands;
                    return;
                }
                let angle = libm::atan2(side * y, side * x).to_degrees() + self.zero(place, zero);
                let turns = ((stands + round - angle) / 360.0).round();
                *slot = fine(angle + 360.0 * turns, stands);
            }
        }
    }

    /// Puts the axes to a point of the part, straight from where they are.
    pub fn reach_straight(&self, place: &MotionState, real: &mut Position, to: [f64; 2]) {
        let round = if self.is_cylinder() { 0.0 } else { between(self.part(place, &place.position), to) };
        self.reach(place, real, to, round);
    }

    /// Coordinates instead of the axes.
    pub fn to_program(self, place: &MotionState, point: &mut Position) {
        if !self.cartesian {
            return;
        }
        if let Some(per_degree) = self.per_degree() {
            *point.at_mut(self.rotary) = clean(point.at(self.rotary) * per_degree, 0.0);
            return;
        }
        let [x, y] = self.part(place, point);
        *point.at_mut(self.linear) = clean(x / self.scale(place), point.at(self.linear));
        *point.at_mut(self.rotary) = clean(y, 0.0);
    }

    /// The axes instead of coordinates.
    pub fn to_axes(self, place: &MotionState, point: &mut Position) {
        if !self.cartesian {
            return;
        }
        if let Some(per_degree) = self.per_degree() {
            *point.at_mut(self.rotary) = fine(point.at(self.rotary) / per_degree, place.position.at(self.rotary));
            return;
        }
        let at = |axis: AxisSlot| point.at(axis);
        let to = [at(self.linear) * self.scale(place), at(self.rotary)];
        self.reach_straight(place, point, to);
    }
}

/// Both coordinates of a cylinder, which change places if the way round is the first one of the plane.
fn in_order(round_first: bool, [one, other]: [f64; 2]) -> [f64; 2] {
    if round_first { [other, one] } else { [one, other] }
}

impl ChannelContext<'_> {
    /// Change of each coordinate that the feed counts: under polar and cylindrical interpolation those of the
    /// part.
    #[inline(always)]
    pub fn feed_changes(&self, from: &Position, to: &Position) -> Position {
        let changes = self.state.place.changes(from, to);
        if self.state.place.frames.is_none() { changes } else { self.part_changes(changes, from, to) }
    }

    #[cold]
    fn part_changes(&self, mut changes: Position, from: &Position, to: &Position) -> Position {
        if self.state.place.tip().is_some() {
            // The feed is that of the tip; where the tip does not move, that of the rotary axes.
            let linear =
                changes.iter().zip(&self.state.place.layout.axes).any(|(change, axis)| !axis.rotary && *change != 0.0);
            for (slot, _) in
                changes.iter_mut().zip(&self.state.place.layout.axes).filter(|(_, axis)| axis.rotary && linear)
            {
                *slot = 0.0;
            }
        } else if self.state.place.frames.as_deref().is_some_and(|frames| frames.feeds.rotary_length) {
            self.as_ways(&mut changes, from);
        }
        let Some(polar) = self.state.place.polar() else { return changes };
        let [before, after] = [from, to].map(|point| polar.part(&self.state.place, point));
        for (axis, (a, b)) in polar.axes().into_iter().zip(before.into_iter().zip(after)) {
            *changes.at_mut(axis) = b - a;
        }
        changes
    }
}

impl MotionState {
    /// Polar or cylindrical interpolation, if it is active.
    pub fn polar(&self) -> Option<PolarInterpolation> {
        self.frames.as_deref().and_then(|frames: &FrameTransforms| frames.polar)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_way_round_the_centre() {
        assert_eq!(between([1.0, 0.0], [0.0, 2.0]), 90.0);
        assert_eq!(between([1.0, 0.0], [0.0, 0.0]), 0.0);
        let circle = (0..=36).map(|at| {
            let (sine, cosine) = turn(f64::from(at) * 15.0);
            [cosine, sine]
        });
        assert!((round_the_centre(circle) - 540.0).abs() < 1e-9);
        assert_eq!(round_the_centre(std::iter::empty()), 0.0);
        assert!(between([f64::NAN, 0.0], [1.0, 0.0]).is_nan());
    }
}
