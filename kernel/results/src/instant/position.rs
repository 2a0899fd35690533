//! The position of a motion after a fraction of its time, by its law.

use counterpoint_event::event::{Motion, MotionLaw, Position};
use counterpoint_event::info::JobAxis;

use crate::geometry::ArcGeometry;

/// The position after this fraction of the time of a motion, from 0 to 1, as programmed; `None` if the law does not
/// determine the position.
#[must_use]
pub fn position(motion: &Motion, law: &MotionLaw, axes: &[JobAxis], time: f64) -> Option<Position> {
    if time <= 0.0 {
        return Some(motion.from);
    }
    if time >= 1.0 {
        return Some(motion.to);
    }
    match law {
        MotionLaw::Unknown(_) => None,
        MotionLaw::Axes(law) => {
            let whole = law.axes().map(|axis| axis.arrives).fold(0.0, f64::max);
            let mut place = motion.from;
            for ((slot, to), axis) in place.iter_mut().zip(&motion.to).zip(law.axes()) {
                *slot += (to - *slot) * axis.way(time * whole);
            }
            Some(place)
        }
        MotionLaw::Path(law) => {
            let share = law.path(time);
            Some(match ArcGeometry::of(motion, axes) {
                Some(arc) => arc.position(motion, axes, share),
                None => between(motion, share),
            })
        }
    }
}

/// The point on the straight line at this fraction of its length.
fn between(motion: &Motion, share: f64) -> Position {
    let mut place = motion.from;
    for (slot, to) in place.iter_mut().zip(&motion.to) {
        *slot += (to - *slot) * share;
    }
    place
}

#[cfg(test)]
mod tests {
    use counterpoint_event::event::{AxesLaw, MotionKind, UnknownLaw};
    use counterpoint_motion::law::{AxisRamp, FeedSchedule, PathLaw, SpeedRamp, SpindleRotation};
    use counterpoint_motion::surface_speed::SurfaceSpeed;
    use counterpoint_motion::thread::Lead;

    use super::*;
    use crate::testing::{lathe, motion};

    fn at(motion: &Motion, law: MotionLaw, time: f64) -> Option<[f64; 2]> {
        let job = lathe(&["x"]);
        let place = position(motion, &law, &job.channels[0].axes, time)?;
        Some([place[0], place[1]])
    }

    #[test]
    fn facing_under_constant_surface_speed() {
        // From diameter 50 to 14 the square of the radius is linear in time: at half the time X is 36.715 and not 32.
        let facing = motion(MotionKind::Linear, &[50.0, 0.0], &[14.0, 0.0]);
        let speed = SurfaceSpeed { surface: 200_000.0, max: f64::INFINITY, min: 0.0 };
        let (lead, spindle) = (Lead { start: 0.2, change: 0.0 }, SpindleRotation::Surface(speed));
        let schedule = FeedSchedule::Turning { lead, way: 18.0, radii: [25.0, 7.0], spindle };
        let [x, z] = at(&facing, MotionLaw::Path(PathLaw { ramp: None, schedule }), 0.5).unwrap();
        assert!((x - 36.715).abs() < 1e-3 && z == 0.0, "{x} {z}");
    }

    #[test]
    fn a_rapid_bends_where_an_axis_has_arrived() {
        // X needs 0.3 s, Z 1.1 s.
        let rapid = motion(MotionKind::Rapid, &[40.0, 0.0], &[0.0, 100.0]);
        let axes = [AxisRamp::new(-20.0, 100.0, 1000.0), AxisRamp::new(100.0, 100.0, 1000.0)];
        let law = MotionLaw::Axes(AxesLaw::new(axes.into_iter()));
        let [x, z] = at(&rapid, law, 0.15 / 1.1).unwrap();
        assert!((x - 20.0).abs() < 1e-9 && (z - 10.0).abs() < 1e-9, "{x} {z}");
        let [x, z] = at(&rapid, law, 0.5).unwrap();
        assert!(x.abs() < 1e-12 && (z - 50.0).abs() < 1e-9, "{x} {z}");
    }

    #[test]
    fn an_arc_stays_on_its_circle_and_ends_are_exact() {
        // A quarter about Z-10 X20 with radius 10: from Z0 X20 to Z-10 X40.
        let arc = Motion {
            center: [-10.0, 20.0],
            plane_axes: [1, 0],
            ..motion(MotionKind::ArcCcw, &[20.0, 0.0], &[40.0, -10.0])
        };
        let ramp = Some(SpeedRamp::alone(15.7, 10.0, 100.0));
        let law = MotionLaw::Path(PathLaw { ramp, schedule: FeedSchedule::Steady });
        assert_eq!(at(&arc, law, 0.0), Some([20.0, 0.0]));
        assert_eq!(at(&arc, law, 1.0), Some([40.0, -10.0]));
        let [x, z] = at(&arc, law, 0.5).unwrap();
        let half = 10.0 * 0.5_f64.sqrt();
        assert!((x / 2.0 - 10.0 - half).abs() < 1e-9 && (z + 10.0 - half).abs() < 1e-9, "{x} {z}");
        assert_eq!(at(&arc, MotionLaw::Unknown(UnknownLaw::Jerk), 0.5), None);
    }
}
