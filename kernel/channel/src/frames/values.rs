//! The values of the local frame: all parts of a kind taken together, in programmed units.
//!
//! Facts: reference system-variables.md 12. Decision: translations add up, scales multiply, a mirror cancels the
//! previous one; of rotations and centres the newest counts.

use crate::position::MotionState;
use counterpoint_event::event::{MAX_AXES, Position};
use counterpoint_motion::frame::affine::Point;
use counterpoint_motion::frame::local::LocalFramePart;

/// The values of the frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameValues {
    pub translation: Point,
    pub rotation: Point,
    pub order: &'static str,
    pub angle: f64,
    pub scale: Point,
    pub mirror: Point,
    pub center: Point,
}

impl MotionState {
    /// The sum of all translations of axes other than X, Y and Z.
    pub fn beside_shift(&self) -> Position {
        let mut shift = [0.0; MAX_AXES];
        let frames = self.frames.as_deref().and_then(|frames| frames.beside.as_deref());
        for lines in frames.into_iter().flat_map(|beside| beside.parts(LocalFramePart::Translate)) {
            for (slot, line) in shift.iter_mut().zip(lines) {
                *slot += line.shift;
            }
        }
        shift
    }

    /// Mirrored axes other than X, Y and Z, one bit each.
    pub fn beside_mirrors(&self) -> u8 {
        let frames = self.frames.as_deref().and_then(|frames| frames.beside.as_deref());
        let mirrors = frames.into_iter().flat_map(|beside| beside.parts(LocalFramePart::Mirror));
        mirrors.fold(0, |bits, lines| {
            let mirrored = lines.iter().enumerate().filter(|(_, line)| line.factor < 0.0);
            mirrored.fold(bits, |bits, (at, _)| bits ^ 1 << at)
        })
    }

    /// The values of the local frame.
    pub fn frame_values(&self) -> FrameValues {
        let mut values = FrameValues {
            translation: [0.0; 3],
            rotation: [0.0; 3],
            order: "",
            angle: 0.0,
            scale: [1.0; 3],
            mirror: [0.0; 3],
            center: [0.0; 3],
        };
        let Some(local) = self.frames.as_deref().map(|frames| &frames.local) else { return values };
        for given in local.parts(LocalFramePart::Translate) {
            each(&mut values.translation, given.values, |all, one| all + one);
        }
        for given in local.parts(LocalFramePart::Scale) {
            each(&mut values.scale, given.values, |all, one| all * one);
        }
        for given in local.parts(LocalFramePart::Mirror) {
            each(&mut values.mirror, given.values, |all, one| f64::from(u8::from(all != one)));
        }
        if let Some(given) = local.parts(LocalFramePart::Rotate).last() {
            (values.rotation, values.order, values.angle) = (given.values, given.order, given.angle);
        }
        values.center = local.center().unwrap_or_default();
        for (role, (shift, center)) in values.translation.iter_mut().zip(&mut values.center).enumerate() {
            let scale = self.scale_of(role);
            (*shift, *center) = (*shift / scale, *center / scale);
        }
        values
    }
}

fn each(all: &mut Point, one: Point, with: impl Fn(f64, f64) -> f64) {
    for (slot, value) in all.iter_mut().zip(one) {
        *slot = with(*slot, value);
    }
}
