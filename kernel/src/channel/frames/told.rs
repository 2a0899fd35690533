//! What the local frame tells of itself: all parts of a kind taken together, in programmed units.
//!
//! Facts: reference system-variables.md 12. Decision: translations add up, scales multiply, a mirror takes the one
//! before away again; of rotations and centres the newest counts.

use crate::channel::Kernel;
use counterpoint_motion::frame::affine::Point;
use counterpoint_motion::frame::local::Part;

/// The values of the frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Told {
    pub(crate) translation: Point,
    pub(crate) rotation: Point,
    pub(crate) order: &'static str,
    pub(crate) angle: f64,
    pub(crate) scale: Point,
    pub(crate) mirror: Point,
    pub(crate) center: Point,
}

impl Kernel<'_> {
    /// The values of the local frame.
    pub(crate) fn frame_values(&self) -> Told {
        let mut told = Told {
            translation: [0.0; 3],
            rotation: [0.0; 3],
            order: "",
            angle: 0.0,
            scale: [1.0; 3],
            mirror: [0.0; 3],
            center: [0.0; 3],
        };
        let Some(local) = self.channel.state.place.frames.as_deref().map(|frames| &frames.local) else { return told };
        for given in local.parts(Part::Translate) {
            each(&mut told.translation, given.values, |all, one| all + one);
        }
        for given in local.parts(Part::Scale) {
            each(&mut told.scale, given.values, |all, one| all * one);
        }
        for given in local.parts(Part::Mirror) {
            each(&mut told.mirror, given.values, |all, one| f64::from(u8::from(all != one)));
        }
        if let Some(given) = local.parts(Part::Rotate).last() {
            (told.rotation, told.order, told.angle) = (given.values, given.order, given.angle);
        }
        told.center = local.center().unwrap_or_default();
        for (role, (shift, center)) in told.translation.iter_mut().zip(&mut told.center).enumerate() {
            let scale = self.channel.state.place.scale_of(role);
            (*shift, *center) = (*shift / scale, *center / scale);
        }
        told
    }
}

fn each(all: &mut Point, one: Point, with: impl Fn(f64, f64) -> f64) {
    for (slot, value) in all.iter_mut().zip(one) {
        *slot = with(*slot, value);
    }
}
