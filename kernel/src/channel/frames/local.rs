//! The local frame: scale, mirror, rotation and translation of the program.
//!
//! Invariant: the map has a way back. Facts: reference control-emulator.md 6.7: from the program to the machine the
//! parts act in the order scale, mirror, rotation, translation.

use super::affine::{Affine, Point};

/// The local frame of a channel.
#[derive(Debug, Clone)]
pub(crate) struct Local {
    /// Translation in force.
    translation: Point,
    /// From the program to the work frame.
    map: Affine,
    /// The way back.
    back: Affine,
}

impl Default for Local {
    fn default() -> Self {
        Self { translation: [0.0; 3], map: Affine::SAME, back: Affine::SAME }
    }
}

impl Local {
    /// Nothing is active.
    pub(crate) fn is_off(&self) -> bool {
        self.map == Affine::SAME
    }

    /// A programmed point in the work frame.
    pub(crate) fn to_work(&self, point: Point) -> Point {
        self.map.point(point)
    }

    /// A point of the work frame as programmed.
    pub(crate) fn to_program(&self, point: Point) -> Point {
        self.back.point(point)
    }

    pub(crate) fn translation(&self) -> Point {
        self.translation
    }

    /// Sets the translation; nothing changes if there would be no way back.
    pub(crate) fn translate(&mut self, translation: Point) {
        let map = Affine::translation(translation);
        if let Some(back) = map.inverse() {
            (self.translation, self.map, self.back) = (translation, map, back);
        }
    }
}
