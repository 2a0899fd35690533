//! Parts of a frame for axes other than X, Y and Z, mainly rotary axes: each axis has its own linear map.
//!
//! Facts: the control's frames have translation, scale and mirror for every axis of the channel, rotations for geometry
//! axes only. Invariant: all numbers are finite and no scale is 0.

use super::frame_component::FrameComponent;

/// Most axes of a channel.
const AXES: usize = 8;

/// Largest number of a frame.
const BOUND: f64 = 1e12;

/// The parts along one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AxisFrame {
    pub(super) shift: f64,
    pub(super) fine: f64,
    pub(super) scale: f64,
    pub(super) mirror: bool,
}

/// The parts along all axes of the channel; those of X, Y and Z are not used.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct AxisFrames([AxisFrame; AXES]);

impl Default for AxisFrame {
    fn default() -> Self {
        Self { shift: 0.0, fine: 0.0, scale: 1.0, mirror: false }
    }
}

impl AxisFrame {
    /// An axis whose values are multiplied, then shifted.
    pub(super) fn of_line([factor, shift]: [f64; 2]) -> Self {
        Self { shift, scale: factor.abs(), mirror: factor < 0.0, ..Self::default() }
    }

    fn factor(self) -> f64 {
        if self.mirror { -self.scale } else { self.scale }
    }

    fn after(self, inner: Self) -> Self {
        Self {
            shift: self.shift + self.factor() * inner.shift,
            fine: self.fine + self.factor() * inner.fine,
            scale: self.scale * inner.scale,
            mirror: self.mirror != inner.mirror,
        }
    }

    fn is_sound(self) -> bool {
        let numbers = [self.shift, self.fine, self.scale, 1.0 / self.scale];
        numbers.iter().all(|number| number.abs() <= BOUND)
    }
}

impl AxisFrames {
    /// The parts along the axis of a place in the channel.
    pub(super) fn of(&self, axis: usize) -> AxisFrame {
        self.0.get(axis).copied().unwrap_or_default()
    }

    /// Replaces them.
    pub(super) fn put(&mut self, axis: usize, own: AxisFrame) {
        if let Some(slot) = self.0.get_mut(axis) {
            *slot = own;
        }
    }

    /// Number of a part along an axis.
    pub(super) fn get(&self, axis: usize, part: FrameComponent) -> f64 {
        let own = self.of(axis);
        match part {
            FrameComponent::Translation => own.shift,
            FrameComponent::Fine => own.fine,
            FrameComponent::Rotation => 0.0,
            FrameComponent::Scale => own.scale,
            FrameComponent::Mirror => f64::from(u8::from(own.mirror)),
        }
    }

    /// Sets a part along an axis.
    pub(super) fn set(&mut self, axis: usize, part: FrameComponent, value: f64) {
        let mut own = self.of(axis);
        match part {
            FrameComponent::Translation => own.shift = value,
            FrameComponent::Fine => own.fine = value,
            FrameComponent::Rotation => {}
            FrameComponent::Scale => own.scale = value,
            FrameComponent::Mirror => own.mirror = value != 0.0,
        }
        self.put(axis, own);
    }

    /// `self : inner`.
    pub(super) fn after(&self, inner: &Self) -> Self {
        let mut made = *self;
        for (slot, inner) in made.0.iter_mut().zip(inner.0) {
            *slot = slot.after(inner);
        }
        made
    }

    /// Whether all numbers are within bounds.
    pub(super) fn is_sound(&self) -> bool {
        self.0.iter().all(|own| own.is_sound())
    }

    /// Whether the frame has nothing but translations.
    pub(super) fn is_shift(&self) -> bool {
        self.0.iter().all(|own| own.scale == 1.0 && !own.mirror)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chains_act_from_the_right() {
        let (mut outer, mut inner) = (AxisFrames::default(), AxisFrames::default());
        outer.put(4, AxisFrame { shift: 30.0, fine: 1.0, scale: 2.0, mirror: true });
        inner.put(4, AxisFrame { shift: 10.0, fine: 0.5, scale: 3.0, mirror: true });
        // 30 − 2 · 10, 1 − 2 · 0.5; two mirrors are none.
        let both = outer.after(&inner).of(4);
        assert_eq!(both, AxisFrame { shift: 10.0, fine: 0.0, scale: 6.0, mirror: false });
        inner.set(4, FrameComponent::Scale, 0.0);
        assert!(!inner.is_sound() && outer.is_sound() && !outer.is_shift());
    }
}
