//! Paths to a contour and from it on lines and parts of circles, as a block asks for them.
//!
//! *Invariant:* a path is made by one move, or refused.

use counterpoint_event::event::FeedUnit;
use counterpoint_motion::contour::element::Spot;

/// Form of the part that touches the contour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ApproachForm {
    /// A line.
    Line,
    /// A quarter of a circle.
    Quarter,
    /// Half a circle.
    Half,
}

/// On which side of the contour circles lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lies {
    /// Left of the contour.
    Left,
    /// Right of the contour.
    Right,
    /// On that of the compensated tool.
    WithTool,
    /// On that of the point from where the tool comes, or where it goes.
    WithPoint,
}

/// A height along the tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ToolHeight {
    /// Distance from the contour.
    Above(f64),
    /// Position, in the frame of the program.
    At(f64),
}

/// A speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ApproachSpeed {
    /// Rapid.
    Rapid,
    /// A feed with its unit; `None` is the active one.
    Feed(Option<f64>, FeedUnit),
}

/// A path to a contour, or from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Smooth {
    /// It leaves the contour.
    pub leaves: bool,
    /// Its form.
    pub form: ApproachForm,
    /// Side on which its circles lie.
    pub lies: Lies,
    /// Heights change on the line or circle, not beside it.
    pub in_space: bool,
    /// Length of the line from the edge of the tool, radius of the circle of its centre.
    pub size: f64,
    /// Where the quick part along the tool ends.
    pub level: Option<ToolHeight>,
    /// Where the first part of the path ends.
    pub retraction: Option<ToolHeight>,
    /// Of the slow part along the tool.
    pub slow: Option<ApproachSpeed>,
    /// Of the blocks before.
    pub before: ApproachSpeed,
    /// Feed that the block itself gives.
    pub own: Option<ApproachSpeed>,
    /// Active feed, for circles without another one.
    pub feed: ApproachSpeed,
    /// Direction of the contour at its end, where the tool leaves it.
    pub heading: Option<Spot>,
}
