//! Paths to a contour and from it on lines and parts of circles, as a block asks for them.
//!
//! *Invariant:* a path is made by one move, or refused.

use counterpoint_event::event::FeedUnit;
use counterpoint_motion::contour::element::Spot;

/// Form of the part that touches the contour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ApproachForm {
    Line,
    Quarter,
    Half,
}

/// On which side of the contour circles lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Lies {
    Left,
    Right,
    /// On that of the compensated tool.
    WithTool,
    /// On that of the point from where the tool comes, or where it goes.
    WithPoint,
}

/// A height along the tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ToolHeight {
    /// Distance from the contour.
    Above(f64),
    /// Position, in the frame of the program.
    At(f64),
}

/// A speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ApproachSpeed {
    Rapid,
    Feed(Option<f64>, FeedUnit),
}

/// A path to a contour, or from it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Smooth {
    pub(crate) leaves: bool,
    pub(crate) form: ApproachForm,
    pub(crate) lies: Lies,
    /// Heights change on the line or circle, not beside it.
    pub(crate) in_space: bool,
    /// Length of the line from the edge of the tool, radius of the circle of its centre.
    pub(crate) size: f64,
    /// Where the quick part along the tool ends.
    pub(crate) level: Option<ToolHeight>,
    /// Where the first part of the path ends.
    pub(crate) retraction: Option<ToolHeight>,
    /// Of the slow part along the tool.
    pub(crate) slow: Option<ApproachSpeed>,
    /// Of the blocks before.
    pub(crate) before: ApproachSpeed,
    /// Feed that the block itself gives.
    pub(crate) own: Option<ApproachSpeed>,
    /// Active feed, for circles without another one.
    pub(crate) feed: ApproachSpeed,
    /// Direction of the contour at its end, where the tool leaves it.
    pub(crate) heading: Option<Spot>,
}
