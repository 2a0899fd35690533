//! Arcs of the log as geometry.
//!
//! Events give arcs by start, end and centre in programmed units; here radius values take the place of diameters.
//! *Invariant:* angles are in the plane of the arc, counter-clockwise positive from its first axis to its second.

use std::f64::consts::{FRAC_PI_2, TAU};

use counterpoint_motion::space::SpaceArc;

use counterpoint_event::event::{Motion, MotionKind, Position};
use counterpoint_event::info::JobAxis;

/// An arc in its plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sweep {
    /// Indices of the plane's axes in the channel.
    pub axes: [usize; 2],
    /// Centre, radius values.
    pub center: [f64; 2],
    /// Radius at the start.
    pub radius: f64,
    /// Angle of the start.
    pub start: f64,
    /// Angle gone through, negative = clockwise, full turns included.
    pub angle: f64,
}

/// Factor from programmed value to radius value.
pub fn scale(axis: &JobAxis) -> f64 {
    if axis.diameter { 0.5 } else { 1.0 }
}

impl Sweep {
    /// The arc of a motion; `None` for straight ones and for arcs without a plane.
    pub fn of(motion: &Motion, axes: &[JobAxis]) -> Option<Self> {
        let clockwise = match motion.kind {
            MotionKind::ArcCw => true,
            MotionKind::ArcCcw => false,
            _ => return None,
        };
        let plane = motion.plane_axes.map(usize::from);
        let scales = [scale(axes.get(plane[0])?), scale(axes.get(plane[1])?)];
        let center = [motion.center[0] * scales[0], motion.center[1] * scales[1]];
        let around =
            |p: &[f64]| Some([p.get(plane[0])? * scales[0] - center[0], p.get(plane[1])? * scales[1] - center[1]]);
        let (from, to) = (around(&motion.from)?, around(&motion.to)?);
        let start = from[1].atan2(from[0]);
        let mut angle = to[1].atan2(to[0]) - start;
        let closed = (from[0] - to[0]).hypot(from[1] - to[1]) < 1e-9;
        if closed {
            angle = if clockwise { -TAU } else { TAU };
        } else if clockwise && angle >= 0.0 {
            angle -= TAU;
        } else if !clockwise && angle <= 0.0 {
            angle += TAU;
        }
        angle += f64::from(motion.turns) * if clockwise { -TAU } else { TAU };
        Some(Self { axes: plane, center, radius: from[0].hypot(from[1]), start, angle })
    }

    /// Point at a share (0 to 1) of the arc, radius values.
    pub fn at(&self, share: f64) -> [f64; 2] {
        let (sin, cos) = (self.start + self.angle * share).sin_cos();
        [self.center[0] + self.radius * cos, self.center[1] + self.radius * sin]
    }

    /// Shares (ascending, both ends excluded) at which one of the axes turns back.
    pub fn turning_points(&self) -> impl Iterator<Item = f64> + use<> {
        let (start, angle) = (self.start, self.angle);
        let sign = if angle < 0.0 { -1.0 } else { 1.0 };
        // Quarter turns between start and end, in the direction of travel.
        let first = (start * sign / FRAC_PI_2).floor() + 1.0;
        // A thousand turns at most: more of them change no extreme.
        (0..4000_u32)
            .map(move |n| ((first + f64::from(n)) * FRAC_PI_2 - start * sign) / angle.abs())
            .take_while(|share| *share < 1.0 - 1e-12)
            .filter(|share| *share > 1e-12)
    }
}

/// The axes of a channel that make up space, and their factors to radius values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spatial {
    axes: [Option<(usize, f64)>; 3],
}

/// X, Y and Z of a channel.
pub fn spatial(axes: &[JobAxis]) -> Spatial {
    let find = |letter: &str| {
        let at = axes.iter().position(|axis| axis.name == letter)?;
        Some((at, scale(axes.get(at)?)))
    };
    Spatial { axes: ["X", "Y", "Z"].map(find) }
}

impl Spatial {
    /// A position as a point: radius values, 0 for an axis that is not there.
    pub fn point(&self, position: &Position) -> [f64; 3] {
        self.axes.map(|axis| axis.and_then(|(at, scale)| Some(position.get(at)? * scale)).unwrap_or(0.0))
    }

    /// Axis of a coordinate.
    pub fn axis(&self, coordinate: usize) -> Option<usize> {
        self.axes.get(coordinate).copied().flatten().map(|(at, _)| at)
    }

    /// Coordinate of an axis.
    pub fn coordinate(&self, axis: usize) -> Option<usize> {
        self.axes.iter().position(|of| of.is_some_and(|(at, _)| at == axis))
    }

    /// Whether the axis is one of them.
    pub fn has(&self, axis: usize) -> bool {
        self.coordinate(axis).is_some()
    }

    /// A point by axes, as programmed; each with its axis.
    pub fn values(&self, point: [f64; 3]) -> impl Iterator<Item = (usize, f64)> {
        self.axes.into_iter().zip(point).filter_map(|(axis, value)| axis.map(|(at, scale)| (at, value / scale)))
    }
}

/// A circle in space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Loop {
    /// The circle.
    pub circle: SpaceArc,
    /// Its axes in the view.
    pub seen: Spatial,
}

impl Loop {
    /// The circle of a motion; `None` for every other kind.
    pub fn of(motion: &Motion, axes: &[JobAxis]) -> Option<Self> {
        if motion.kind != MotionKind::ArcSpace {
            return None;
        }
        let seen = spatial(axes);
        let circle = SpaceArc::bulging(seen.point(&motion.from), seen.point(&motion.to), motion.center).ok()?;
        Some(Self { circle, seen })
    }

    /// Position at a share of the path, axes beside the circle included.
    pub fn at(&self, motion: &Motion, share: f64) -> Position {
        let mut position = motion.from;
        for (slot, (a, b)) in position.iter_mut().zip(motion.from.iter().zip(&motion.to)) {
            *slot = a + (b - a) * share;
        }
        for (axis, value) in self.seen.values(self.circle.at(share)) {
            if let Some(slot) = position.get_mut(axis) {
                *slot = value;
            }
        }
        position
    }
}

/// The circle of a motion, in a plane or in space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ArcGeometry {
    /// In a plane of the machine.
    Flat(Sweep),
    /// In any plane.
    Space(Loop),
}

impl ArcGeometry {
    /// `None` for straight motions.
    pub fn of(motion: &Motion, axes: &[JobAxis]) -> Option<Self> {
        match motion.kind {
            MotionKind::ArcCw | MotionKind::ArcCcw => Sweep::of(motion, axes).map(Self::Flat),
            MotionKind::ArcSpace => Loop::of(motion, axes).map(Self::Space),
            MotionKind::Rapid | MotionKind::Linear | MotionKind::Thread => None,
        }
    }

    /// Position at a fraction (0 to 1) of the path, as programmed; axes outside the arc move evenly.
    #[must_use]
    pub fn position(self, motion: &Motion, axes: &[JobAxis], share: f64) -> Position {
        let sweep = match self {
            Self::Space(space) => return space.at(motion, share),
            Self::Flat(sweep) => sweep,
        };
        let mut position = motion.from;
        for (slot, to) in position.iter_mut().zip(&motion.to) {
            *slot += (to - *slot) * share;
        }
        // The end may be off the circle, by the tolerance of the control: the radius changes evenly up to it.
        let around = |end: &Position| {
            let value = |side: usize| {
                let at = sweep.axes.get(side).copied()?;
                Some(end.get(at)? * axes.get(at).map(scale)? - sweep.center.get(side)?)
            };
            Some(value(0)?.hypot(value(1)?))
        };
        let end = around(&motion.to).unwrap_or(sweep.radius);
        let spiral = Sweep { radius: sweep.radius + (end - sweep.radius) * share, ..sweep };
        for (axis, value) in spiral.axes.into_iter().zip(spiral.at(share)) {
            if let Some((slot, axis)) = position.get_mut(axis).zip(axes.get(axis)) {
                *slot = value / scale(axis);
            }
        }
        position
    }

    /// Where an axis turns back on its way along the circle, as programmed and in order; nothing for axes beside it.
    pub fn reversals(self, axes: &[JobAxis], axis: usize) -> impl Iterator<Item = f64> + use<> {
        let unit = axes.get(axis).map_or(1.0, scale);
        let (flat, space) = match self {
            Self::Flat(sweep) => (sweep.axes.iter().position(|of| *of == axis).map(|side| (sweep, side)), None),
            Self::Space(space) => (None, space.seen.coordinate(axis).map(|side| (space, side))),
        };
        let flat = flat.into_iter().flat_map(move |(sweep, side)| {
            sweep.turning_points().filter_map(move |share| sweep.at(share).get(side).map(|value| value / unit))
        });
        let space = space.into_iter().flat_map(move |(space, side)| {
            let shares = space.circle.turning_points(side).into_iter().flatten();
            shares.filter_map(move |share| space.circle.at(share).get(side).map(|value| value / unit))
        });
        flat.chain(space)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{lathe, motion};

    fn arc(kind: MotionKind, from: &[f64], to: &[f64], center: [f64; 2]) -> Sweep {
        let arc = Motion { center, plane_axes: [1, 0], ..motion(kind, from, to) };
        Sweep::of(&arc, &lathe(&["x"]).channels[0].axes).expect("an arc")
    }

    #[test]
    fn diameters_become_radii() {
        // From Z0 X20 to Z-10 X40 about Z-10 X20: a quarter, counter-clockwise with Z right and X up.
        let sweep = arc(MotionKind::ArcCcw, &[20.0, 0.0], &[40.0, -10.0], [-10.0, 20.0]);
        assert_eq!((sweep.center, sweep.radius, sweep.start), ([-10.0, 10.0], 10.0, 0.0));
        assert!((sweep.angle - FRAC_PI_2).abs() < 1e-12);
        assert_eq!(sweep.turning_points().count(), 0);
    }

    #[test]
    fn full_circles_turn_back_four_times() {
        let sweep = arc(MotionKind::ArcCw, &[20.0, 1.0], &[20.0, 1.0], [0.0, 20.0]);
        assert!((sweep.angle + TAU).abs() < 1e-12);
        assert_eq!(sweep.turning_points().count(), 3);
        let sweep = arc(MotionKind::ArcCw, &[21.0, 1.0], &[21.0, 1.0], [0.0, 20.0]);
        assert_eq!(sweep.turning_points().count(), 4);
        let top = sweep.turning_points().map(|s| sweep.at(s)[1]).fold(f64::MIN, f64::max);
        assert!((top - (10.0 + sweep.radius)).abs() < 1e-9);
    }
}
