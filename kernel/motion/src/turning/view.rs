//! The view of a rough cycle: the first coordinate runs along the cut, the second one points from the part to the
//! stock.
//!
//! *Invariant:* mapping there and back gives the same point; outside and inside, facing and turning, towards −Z and
//! towards +Z are one case in this view.

use crate::contour::element::Spot;

/// How the plane is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CutView {
    /// The cut runs along X.
    pub(super) face: bool,
    /// Signs of the direction along the cut, and of that to the stock.
    pub(super) signs: [f64; 2],
}

impl CutView {
    /// A point of the plane as seen.
    pub(super) fn see(&self, [z, x]: Spot) -> Spot {
        let [along, across] = if self.face { [x, z] } else { [z, x] };
        [along * self.signs[0], across * self.signs[1]]
    }

    /// The point of the plane that is seen here.
    pub(super) fn place(&self, [along, across]: Spot) -> Spot {
        let (along, across) = (along * self.signs[0], across * self.signs[1]);
        if self.face { [across, along] } else { [along, across] }
    }

    /// The height of a coordinate across the cut.
    pub(super) fn height(&self, across: f64) -> f64 {
        across * self.signs[1]
    }

    /// Amounts along Z and X as a vector of the plane, against the cut and towards the stock.
    pub(super) fn away(&self, [z, x]: Spot) -> Spot {
        let [along, across] = if self.face { [x, z] } else { [z, x] };
        self.place([-along, across])
    }

    /// Seen from the other side: a clockwise rotation in the plane is counter-clockwise here.
    pub(super) fn turns_over(&self) -> bool {
        let signs = self.signs[0] * self.signs[1] < 0.0;
        signs != self.face
    }
}
