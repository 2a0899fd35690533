//! Arcs of the log as geometry.
//!
//! Events give arcs by start, end and centre in programmed units; here radius values take the place of diameters.
//! Invariant: angles are in the plane of the arc, counter-clockwise positive from its first axis to its second.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::log::event::{Motion, MotionKind};
use crate::log::info::Axis;

/// An arc in its plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sweep {
    /// Indices of the plane's axes in the channel.
    pub(crate) axes: [usize; 2],
    /// Centre, radius values.
    pub(crate) center: [f64; 2],
    /// Radius at the start.
    pub(crate) radius: f64,
    /// Angle of the start.
    pub(crate) start: f64,
    /// Angle gone through, negative = clockwise, full turns included.
    pub(crate) angle: f64,
}

/// Factor from programmed value to radius value.
pub(crate) fn scale(axis: &Axis) -> f64 {
    if axis.diameter { 0.5 } else { 1.0 }
}

impl Sweep {
    /// The arc of a motion; `None` for straight ones and for arcs without a plane.
    pub(crate) fn of(motion: &Motion, axes: &[Axis]) -> Option<Self> {
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
    pub(crate) fn at(&self, share: f64) -> [f64; 2] {
        let (sin, cos) = (self.start + self.angle * share).sin_cos();
        [self.center[0] + self.radius * cos, self.center[1] + self.radius * sin]
    }

    /// Shares (ascending, both ends excluded) at which one of the axes turns back.
    pub(crate) fn turning_points(&self) -> impl Iterator<Item = f64> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::testing::{lathe, motion};

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
