//! Requests of corner words and angle words for the contour.
//!
//! *Invariant:* a word is asked once: by the move of its block, or it is reported as one that cannot act.

use counterpoint_event::event::Position;
use counterpoint_machine::index::AxisSlot;
use counterpoint_motion::contour::blend::CornerBlend;
use counterpoint_motion::contour::element::Spot;

/// A corner at the end of a move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CornerRequest {
    /// A chamfer or a rounding, with its size.
    pub cut: CornerBlend,
    /// Direction of the move after it, where both are parallel to axes.
    pub side: Option<CornerDirection>,
    /// Feed of its own.
    pub feed: Option<f64>,
    /// All corners are rounded: where there is none, nothing is missing.
    pub modal: bool,
}

/// Where a corner of axis-parallel lines goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CornerDirection {
    /// Channel axis of the second line, where the word says it.
    pub axis: Option<AxisSlot>,
    /// The second line goes to larger coordinates.
    pub positive: bool,
}

/// A line whose end the next one gives: both in the frame of the program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpenLine {
    /// Where the line begins.
    pub from: Position,
    /// Direction in the plane, of length one.
    pub along: Spot,
}

/// The requests of the words of a block.
#[derive(Debug, Clone, Default)]
pub struct ContourRequest {
    /// The corner at the end of the move.
    pub corner: Option<CornerRequest>,
    /// Feed of the corner, where all corners are rounded.
    pub feed: Option<f64>,
    /// Direction of the line, degrees from the first axis of the plane.
    pub angle: Option<f64>,
    /// The end by its distance from the pole and its angle, degrees.
    pub polar: Option<[f64; 2]>,
    /// The line has no end of its own.
    pub open: Option<OpenLine>,
}

impl ContourRequest {
    /// Whether nothing is asked.
    pub fn is_empty(&self) -> bool {
        self.corner.is_none() && self.angle.is_none() && self.polar.is_none() && self.open.is_none()
    }
}
