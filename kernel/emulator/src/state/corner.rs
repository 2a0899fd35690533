//! Requests of corner words and angle words for the contour.
//!
//! *Invariant:* a word is asked once: by the move of its block, or it is reported as one that cannot act.

use counterpoint_event::event::Position;
use counterpoint_machine::index::AxisSlot;
use counterpoint_motion::contour::blend::CornerBlend;
use counterpoint_motion::contour::element::Spot;

/// A corner at the end of a move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CornerRequest {
    pub(crate) cut: CornerBlend,
    /// Direction of the move after it, where both are parallel to axes.
    pub(crate) side: Option<CornerDirection>,
    /// Feed of its own.
    pub(crate) feed: Option<f64>,
    /// All corners are rounded: where there is none, nothing is missing.
    pub(crate) modal: bool,
}

/// Where a corner of axis-parallel lines goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CornerDirection {
    /// Channel axis of the second line, where the word says it.
    pub(crate) axis: Option<AxisSlot>,
    /// The second line goes to larger coordinates.
    pub(crate) positive: bool,
}

/// A line whose end the next one gives: both in the frame of the program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct OpenLine {
    pub(crate) from: Position,
    /// Direction in the plane, of length one.
    pub(crate) along: Spot,
}

/// The requests of the words of a block.
#[derive(Debug, Clone, Default)]
pub(crate) struct ContourRequest {
    pub(crate) corner: Option<CornerRequest>,
    /// Feed of the corner, where all corners are rounded.
    pub(crate) feed: Option<f64>,
    /// Direction of the line, degrees from the first axis of the plane.
    pub(crate) angle: Option<f64>,
    /// The end by its distance from the pole and its angle, degrees.
    pub(crate) polar: Option<[f64; 2]>,
    /// The line has no end of its own.
    pub(crate) open: Option<OpenLine>,
}

impl ContourRequest {
    /// Whether nothing is asked.
    pub(crate) fn is_empty(&self) -> bool {
        self.corner.is_none() && self.angle.is_none() && self.polar.is_none() && self.open.is_none()
    }
}
