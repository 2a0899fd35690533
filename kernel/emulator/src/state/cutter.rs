//! The memory of compensation between moves.

use crate::state::at::BlockPlace;
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
pub(crate) enum CompensationStage {
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
pub(crate) struct ProgrammedMove {
    pub(crate) shape: MoveShape,
    pub(crate) coded: u8,
    pub(crate) to: Position,
    pub(crate) feed: Option<f64>,
    pub(crate) unit: FeedUnit,
}

/// How a move goes.
#[derive(Debug, Clone, Copy)]
pub(crate) enum MoveShape {
    Rapid,
    Linear,
    Circle {
        /// With full turns.
        made: MotionArc,
        axes: [AxisSlot; 2],
        turns: u16,
    },
}

/// A move that waits for the next one.
#[derive(Debug, Clone)]
pub(crate) struct WaitingMove {
    pub(crate) step: ProgrammedMove,
    /// Its piece of the contour; none for a move beside the plane.
    pub(crate) element: Option<Element>,
    /// The corner at its end, until the next piece is known.
    pub(crate) corner: Option<CornerRequest>,
    /// A line whose end the next one gives.
    pub(crate) open: Option<OpenLine>,
    /// It is the path to the contour, whose beginning is the end of this move.
    pub(crate) smooth: Option<Box<Smooth>>,
    pub(crate) place: BlockPlace,
    pub(crate) block: u64,
    /// Held time when it came, ns.
    pub(crate) clock: i64,
    pub(crate) micro: u32,
    pub(crate) exact: bool,
    /// How it approaches the next move.
    pub(crate) end: ContourEnd,
    pub(crate) text: Option<Arc<[u8]>>,
    /// Events that were held back before it.
    pub(crate) events: usize,
    /// The spindle at its beginning.
    pub(crate) spindle: SpindleState,
}

/// Active compensation.
#[derive(Debug, Clone)]
pub(crate) struct CutterCompensation {
    /// +1 left of the path, −1 right.
    pub(crate) side: f64,
    pub(crate) radius: f64,
    /// From the imaginary tip to the centre of the nose.
    pub(crate) tip: Spot,
    /// Channel axes of the plane.
    pub(crate) axes: [AxisSlot; 2],
    /// End of the last programmed move, in the work frame.
    pub(crate) contour: Position,
    pub(crate) stage: CompensationStage,
    /// The move that waits, and moves beside the plane after it.
    pub(crate) waiting: Vec<WaitingMove>,
    /// Blocks without motion in the plane since then.
    pub(crate) idle: u32,
    /// Last block that was counted.
    pub(crate) seen: u64,
    /// Line of the move that ended without knowing the next one.
    pub(crate) ended: u32,
    /// An action goes without compensation.
    pub(crate) suspended: bool,
    /// The tool stays on the contour: only corners make moves wait.
    pub(crate) plain: bool,
    /// Requests of the words of the block for the contour, until its move is known.
    pub(crate) asked: ContourRequest,
    /// A path to the contour or from it that no move has made yet.
    pub(crate) smooth: Option<Box<Smooth>>,
    /// A new radius that takes effect at the end of the next move in the plane, with the vector from the tip to the
    /// nose centre.
    pub(crate) resized: Option<(f64, Spot)>,
}

impl CompensationStage {
    /// Compensation has been switched off.
    pub(crate) fn is_ending(&self) -> bool {
        matches!(self, Self::Ending(_))
    }
}

impl CutterCompensation {
    /// Whether a corner or the end of a line waits for the next move.
    pub(crate) fn is_due(&self) -> bool {
        self.waiting.iter().any(|waiting| waiting.corner.is_some() || waiting.open.is_some())
    }
}

impl CutterCompensation {
    /// A position with the plane's axes of another one.
    pub(crate) fn lifted(&self, to: &Position, stands: &Position) -> Position {
        let mut lifted = *to;
        for axis in self.axes {
            *lifted.at_mut(axis) = stands.at(axis);
        }
        lifted
    }
}
