//! The memory of compensation between moves.

use crate::at::BlockPlace;
use counterpoint_machine::index::{AxisSlot, BySlot};
use std::sync::Arc;

use counterpoint_motion::arc::PlaneArc as MotionArc;

use counterpoint_event::event::{FeedUnit, Position};
use counterpoint_motion::contour::element::{Element, Spot};

use super::corner::{ContourRequest, CornerRequest, OpenLine};
use super::smooth::Smooth;
use super::spindle::SpindleState;
use counterpoint_program::block::ContourEnd;

/// Where compensation is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CompensationStage {
    /// Switched on; the next move in the plane comes to the contour.
    Start,
    /// Beside the contour.
    On,
    /// Beside the end of a piece that did not know the next one: that end and its direction.
    Settled {
        /// Corner of the contour.
        corner: Spot,
        /// Direction of the path at the corner.
        along: Spot,
    },
    /// Beside the end of a piece; the circle around that end belongs to the next move.
    Around {
        /// Corner of the contour.
        corner: Spot,
        /// Direction of the path at the corner.
        along: Spot,
    },
    /// Side or radius have changed beside the contour.
    Turned,
    /// Switched off; the next move in the plane goes to its point. The end of the contour and the direction of the path
    /// there, where they are known.
    Ending(Option<(Spot, Spot)>),
}

/// A move as programmed, in the work frame.
#[derive(Debug, Clone)]
pub struct ProgrammedMove {
    /// How the move goes.
    pub shape: MoveShape,
    /// Axes that the block names, a bit each.
    pub coded: u8,
    /// Its end.
    pub to: Position,
    /// Its feed, `None` before the first one.
    pub feed: Option<f64>,
    /// The unit of the feed.
    pub unit: FeedUnit,
}

/// How a move goes.
#[derive(Debug, Clone, Copy)]
pub enum MoveShape {
    /// At rapid.
    Rapid,
    /// On a line, at feed.
    Linear,
    /// On a circle, at feed.
    Circle {
        /// With full turns.
        made: MotionArc,
        /// The axes of its plane.
        axes: [AxisSlot; 2],
        /// Full turns in addition to the arc.
        turns: u16,
    },
}

/// A move that waits for the next one.
#[derive(Debug, Clone)]
pub struct WaitingMove {
    /// The move as programmed.
    pub step: ProgrammedMove,
    /// Its piece of the contour; none for a move beside the plane.
    pub element: Option<Element>,
    /// The corner at its end, until the next piece is known.
    pub corner: Option<CornerRequest>,
    /// A line whose end the next one gives.
    pub open: Option<OpenLine>,
    /// It is the path to the contour, whose beginning is the end of this move.
    pub smooth: Option<Box<Smooth>>,
    /// The place of its block.
    pub place: BlockPlace,
    /// The number of its block.
    pub block: u64,
    /// Held time when it came, ns.
    pub clock: i64,
    /// Microstep within its block.
    pub micro: u32,
    /// The axes stop at its end.
    pub exact: bool,
    /// How it approaches the next move.
    pub end: ContourEnd,
    /// The text of its block, where it differs from its line.
    pub text: Option<Arc<[u8]>>,
    /// Events that were held back before it.
    pub events: usize,
    /// The spindle at its beginning.
    pub spindle: SpindleState,
}

/// Active compensation.
#[derive(Debug, Clone)]
pub struct CutterCompensation {
    /// +1 left of the path, −1 right.
    pub side: f64,
    /// Radius of the tool, geometry units.
    pub radius: f64,
    /// From the imaginary tip to the centre of the nose.
    pub tip: Spot,
    /// Channel axes of the plane.
    pub axes: [AxisSlot; 2],
    /// End of the last programmed move, in the work frame.
    pub contour: Position,
    /// Progress of the compensation.
    pub stage: CompensationStage,
    /// The move that waits, and moves beside the plane after it.
    pub waiting: Vec<WaitingMove>,
    /// Blocks without motion in the plane since then.
    pub idle: u32,
    /// Last block that was counted.
    pub seen: u64,
    /// Line of the move that ended without knowing the next one.
    pub ended: u32,
    /// An action goes without compensation.
    pub suspended: bool,
    /// The tool stays on the contour: only corners make moves wait.
    pub plain: bool,
    /// Requests of the words of the block for the contour, until its move is known.
    pub asked: ContourRequest,
    /// A path to the contour or from it that no move has made yet.
    pub smooth: Option<Box<Smooth>>,
    /// A new radius that takes effect at the end of the next move in the plane, with the vector from the tip to the
    /// nose centre.
    pub resized: Option<(f64, Spot)>,
}

impl CompensationStage {
    /// Compensation has been switched off.
    pub fn is_ending(&self) -> bool {
        matches!(self, Self::Ending(_))
    }
}

impl CutterCompensation {
    /// Whether a corner or the end of a line waits for the next move.
    pub fn is_due(&self) -> bool {
        self.waiting.iter().any(|waiting| waiting.corner.is_some() || waiting.open.is_some())
    }
}

impl CutterCompensation {
    /// A position with the plane's axes of another one.
    pub fn lifted(&self, to: &Position, stands: &Position) -> Position {
        let mut lifted = *to;
        for axis in self.axes {
            *lifted.at_mut(axis) = stands.at(axis);
        }
        lifted
    }
}
