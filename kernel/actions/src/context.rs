//! The context of an action, and the steps that motions, circles, threads and compensation ask of one another.
//!
//! *Invariant:* a step is made where its idea is; the others know only its name.

use counterpoint_channel::circular_move::CircularMove;
use counterpoint_channel::cutter::WaitingMove;
use counterpoint_channel::smooth::Smooth;
use counterpoint_channel::thread::Screw;
pub(crate) use counterpoint_emulator::action_context::ActionContext;
use counterpoint_event::event::{FeedUnit, Position};
use counterpoint_fault::{Acted, Halt};
use counterpoint_machine::index::AxisSlot;
use counterpoint_motion::arc::PlaneArc;
use counterpoint_motion::contour::corner::CornerPath;
use counterpoint_motion::contour::element::Element;

/// Straight moves.
pub(crate) trait StraightSteps {
    /// Takes the axis words: bits of coded axes, and the target in the work frame.
    fn targets(&mut self) -> (u8, Position);

    /// A straight feed move to a target in the work frame.
    fn feed_to(&mut self, coded: u8, target: Position, feed: Option<f64>, unit: FeedUnit) -> Acted;

    /// A rapid move to a target in the work frame, at most at a feed per minute along the path.
    fn rapid_within(&mut self, coded: u8, target: Position, feed: Option<f64>) -> Acted;
}

/// Circles.
pub(crate) trait CircleSteps {
    /// A circle in the work frame.
    fn circle_to(&mut self, circle: &CircularMove) -> Acted;
}

/// Threads along circles.
pub(crate) trait ThreadSteps {
    /// Seconds of a thread along a circle between two axes of its plane.
    fn arc_thread_seconds(
        &mut self,
        to: &Position,
        arc: (&PlaneArc, [AxisSlot; 2]),
        screw: &Screw,
    ) -> Result<f64, Halt>;
}

/// Ways to a contour.
pub(crate) trait ApproachSteps {
    /// Makes the path to a contour whose first piece is known now.
    fn smooth_approach(&mut self, waits: &WaitingMove, smooth: &Smooth, next: Option<&Element>) -> Acted;
}

/// Ways around the ends of a contour.
pub(crate) trait AroundSteps {
    /// The way around the beginning of a contour from a point behind it (KONT).
    fn around_start(&mut self, element: &Element, next: &Element) -> Result<Option<CornerPath>, Halt>;
}

/// Lets the kernel run an action that has `execute`.
macro_rules! run_in_context {
    ($action:ty) => {
        impl counterpoint_emulator::channel::actions::Action for $action {
            #[inline]
            fn run(
                &self,
                kernel: &mut counterpoint_emulator::channel::Kernel<'_>,
                row: &counterpoint_machine::rows::CodeRow,
                code: &counterpoint_program::block::PendingCode,
            ) -> counterpoint_fault::Acted {
                self.execute(&mut $crate::context::ActionContext::new(kernel), row, code)
            }
        }
    };
}
pub(crate) use run_in_context;
