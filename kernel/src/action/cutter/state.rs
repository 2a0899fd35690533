//! What compensation remembers between moves.

use std::sync::Arc;

use super::Step;
use crate::log::event::{FileId, Position};
use counterpoint_motion::contour::element::{Element, Spot};

/// Where compensation is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Stage {
    /// Switched on; the next move in the plane comes to the contour.
    Start,
    /// Beside the contour.
    On,
    /// Beside the end of a piece that did not know the next one: that end and its direction.
    Settled {
        /// Point of the contour.
        corner: Spot,
        /// Direction of the way there.
        along: Spot,
    },
    /// Side or radius have changed beside the contour.
    Turned,
    /// Switched off; the next move in the plane goes to its point.
    Ending,
}

/// A move that waits for the next one.
#[derive(Debug, Clone)]
pub(crate) struct Waiting {
    pub(super) step: Step,
    /// Its piece of the contour; none for a move beside the plane.
    pub(super) element: Option<Element>,
    pub(super) file: FileId,
    pub(super) line: u32,
    pub(super) block: u64,
    /// Held time when it came, ns.
    pub(super) clock: i64,
    pub(super) micro: u32,
    pub(super) exact: bool,
    pub(super) text: Option<Arc<[u8]>>,
    /// Events that were held back before it.
    pub(super) events: usize,
}

/// Active compensation.
#[derive(Debug, Clone)]
pub(crate) struct Cutter {
    /// +1 left of the way, −1 right.
    pub(super) side: f64,
    pub(super) radius: f64,
    /// From the imaginary tip to the centre of the nose.
    pub(super) tip: Spot,
    /// Channel axes of the plane.
    pub(super) axes: [usize; 2],
    /// End of the last programmed move, in the work frame.
    pub(crate) contour: Position,
    pub(super) stage: Stage,
    /// The move that waits, and moves beside the plane after it.
    pub(super) waiting: Vec<Waiting>,
    /// Blocks without motion in the plane since then.
    pub(super) idle: u32,
    /// Last block that was counted.
    pub(super) seen: u64,
    /// An action goes without compensation.
    pub(super) suspended: bool,
}

impl Cutter {
    /// A position with the plane's axes of another one.
    pub(super) fn lifted(&self, to: &Position, stands: &Position) -> Position {
        let mut lifted = *to;
        for axis in self.axes {
            if let (Some(slot), Some(at)) = (lifted.get_mut(axis), stands.get(axis)) {
                *slot = *at;
            }
        }
        lifted
    }
}
