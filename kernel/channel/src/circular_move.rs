//! Description of a circular move, shared by all actions that make circles.
//!
//! *Invariant:* plain data.

use counterpoint_event::event::{FeedUnit, Position};
use counterpoint_machine::index::AxisSlot;
use counterpoint_motion::arc::PlaneArc;

use crate::thread::Screw;

/// A circle to be made, in the frame of its points.
#[derive(Debug, Clone, Copy)]
pub struct CircularMove {
    /// Geometry, with full turns.
    pub made: PlaneArc,
    /// Axes with words.
    pub coded: u8,
    /// Start.
    pub from: Position,
    /// End.
    pub to: Position,
    /// Channel axes of its plane.
    pub axes: [AxisSlot; 2],
    /// Full turns.
    pub turns: u16,
    /// Feed in its unit.
    pub feed: Option<f64>,
    /// Unit of the feed.
    pub unit: FeedUnit,
    /// The thread that is cut along it.
    pub screw: Option<Screw>,
}
