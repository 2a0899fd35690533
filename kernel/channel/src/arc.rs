//! Definitions of codes for later circles: centre, radius, direction.
//!
//! *Invariant:* a defined centre is a point and stays until another definition.

use counterpoint_event::event::{FeedUnit, Position};
use counterpoint_machine::ident::kind::arc::ArcDefinition;
use counterpoint_machine::index::AxisSlot;

/// The last move along the contour, on machines whose circles may continue its direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LastMove {
    /// A straight move by this, in the work frame.
    By(Position),
    /// An arc in the plane of these axes.
    Round {
        /// Channel axes.
        axes: [AxisSlot; 2],
        /// Centre, as coordinates of the axes.
        center: [f64; 2],
        /// +1 counter-clockwise, −1 clockwise.
        turn: f64,
    },
}

/// Data of the circles of a channel.
#[derive(Debug, Clone, Copy, Default)]
pub struct ArcState {
    /// Defined centre by X, Y and Z: radius values in the work frame.
    pub center: [Option<f64>; 3],
    /// Defined radius.
    pub radius: Option<f64>,
    /// The last move along the contour.
    pub last: Option<LastMove>,
    /// Its feed with its unit.
    pub feed: Option<(f64, FeedUnit)>,
    /// Pole of polar coordinates in the frame of the program, by axis of the channel.
    pub pole: Position,
    /// Clockwise, by the last circle or code of direction.
    pub clockwise: Option<bool>,
    /// Form of the corner at the end of the move of a block (a rounding), and that block.
    pub corner: Option<(bool, u64)>,
    /// Form defined last, and on which block.
    pub by: ArcDefinition,
    /// Number of that block.
    pub block: u64,
}
