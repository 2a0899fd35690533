//! A figure that a program draws several times, each time at another place (Fanuc G72.1, G72.2).
//!
//! *Invariant:* the frame of a copy is made of the frame before all copies, so errors do not add up.

use counterpoint_motion::frame::affine::Point;
use counterpoint_motion::frame::local::LocalFrame;

/// The position of a copy relative to the previous copy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Copy {
    /// Turned by an angle in degrees about a point, in the active plane.
    Turned(f64, Point),
    /// Shifted.
    Shifted(Point),
}

impl Copy {
    /// Whether both are of the same kind.
    pub fn is_like(self, other: Self) -> bool {
        matches!((self, other), (Self::Turned(..), Self::Turned(..)) | (Self::Shifted(_), Self::Shifted(_)))
    }

    /// The alarm for a copy nested in a copy of the same kind.
    pub fn alarm(self) -> &'static str {
        match self {
            Self::Turned(..) => "PS0900",
            Self::Shifted(_) => "PS0901",
        }
    }
}

/// A figure that is being copied.
#[derive(Debug, Clone)]
pub struct CopiedFigure {
    /// How each copy differs from the one before.
    pub copy: Copy,
    /// Copies made before the running one.
    pub made: u32,
    /// The local frame before the first one.
    pub base: LocalFrame,
}

impl PartialEq for CopiedFigure {
    fn eq(&self, other: &Self) -> bool {
        (self.copy, self.made) == (other.copy, other.made)
    }
}
