//! The requests of the pipeline to the actions: it knows none of them, the plan holds the functions that it calls.
//!
//! *Invariant:* an action is found once, when the plan is made.

use std::fmt::Debug;

use counterpoint_fault::{Acted, Halt};

use super::Kernel;
use counterpoint_channel::cycle::CycleHole;
use counterpoint_channel::figure::CopiedFigure;
use counterpoint_channel::turning::{ContourCycle, RecordedContour};
use counterpoint_event::event::{Motion, Position};
use counterpoint_machine::ident::CodeId;
use counterpoint_machine::rows::CodeRow;
use counterpoint_motion::turning::strip::Strip;
use counterpoint_program::block::PendingCode;

/// The effect of a code.
pub trait Action: Debug + Sync {
    /// Executes the code.
    fn run(&self, kernel: &mut Kernel<'_>, row: &CodeRow, code: &PendingCode) -> Acted;
}

/// Compensation that a macro changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CompensationChange {
    /// Another code is active.
    Code,
    /// Another offset is active on the same side.
    Number,
}

/// Function that gives a straight feed move a new end; it returns the time in seconds, and the move.
pub type ShortenMove = fn(&mut Kernel<'_>, &Motion, Position) -> Result<(f64, Motion), Halt>;

/// Straight moves that no code makes.
#[derive(Debug)]
pub struct StraightMoves {
    /// Goes to a programmed point at rapid.
    pub back: fn(&mut Kernel<'_>, &Position) -> Acted,
    /// Moves these axes to a point of the work frame: at rapid, or at the feed of the active mode.
    pub along: fn(&mut Kernel<'_>, bool, u8, &Position) -> Acted,
    /// Repeats a straight move that a macro has changed: at rapid or at feed, to a new end.
    pub change: fn(&mut Kernel<'_>, &Motion, bool, Position) -> Acted,
    /// Gives a straight feed move a new end; returns its time in seconds, and the move.
    pub shorten: ShortenMove,
}

/// The built-in actions: those of codes, and those that other stages of the pipeline need.
#[derive(Debug)]
pub struct ActionTable {
    /// Action of a code; `None` for a code without a built-in action.
    pub of: fn(CodeId) -> Option<&'static dyn Action>,
    /// Finishes a move that compensation keeps back, without knowing the next one.
    pub flush_lookahead: fn(&mut Kernel<'_>) -> Acted,
    /// Finishes a move that compensation has kept back too long, or, at a hole, one with a corner at its end.
    pub flush_due: fn(&mut Kernel<'_>, bool) -> Acted,
    /// The program has ended, and compensation with it.
    pub end_compensation: fn(&mut Kernel<'_>, Halt) -> Halt,
    /// A macro has changed compensation.
    pub change_compensation: fn(&mut Kernel<'_>, CompensationChange) -> Acted,
    /// A speed that no code took.
    pub speed_word: fn(&mut Kernel<'_>) -> Acted,
    /// Numbers of offsets without their codes; the registers whose words no code of the block takes, bit by register.
    pub offset_words: fn(&mut Kernel<'_>, u128) -> Acted,
    /// Makes a hole of a cycle.
    pub make_hole: fn(&mut Kernel<'_>, &CycleHole) -> Acted,
    /// Actions by which contour blocks are read; none among them.
    pub reading: Option<&'static ActionTable>,
    /// Records a motion in place of making it; none where motions are made.
    pub record: Option<fn(&mut Kernel<'_>, f64, &Motion) -> Acted>,
    /// Cuts along a contour that was read.
    pub cut_contour: fn(&mut Kernel<'_>, &ContourCycle, RecordedContour) -> Acted,
    /// Removes stock along a contour that was read.
    pub strip: fn(&mut Kernel<'_>, &Strip) -> Acted,
    /// Puts the frame of a further copy of a figure into force, or the frame before the copies.
    pub copy_figure: fn(&mut Kernel<'_>, &CopiedFigure, bool) -> Acted,
    /// Straight moves that no code makes.
    pub straight: StraightMoves,
}

impl ActionTable {
    /// Whether these actions read the blocks of a contour.
    pub fn reads_contour(&self) -> bool {
        self.reading.is_none()
    }
}

impl Kernel<'_> {
    /// Finishes the move that compensation keeps back, without knowing the next one.
    pub fn flush_lookahead(&mut self) -> Acted {
        if self.channel.state.place.is_compensated() { (self.plan.actions.flush_lookahead)(self) } else { Ok(()) }
    }

    /// Finishes a move that compensation has kept back too long, or, at a hole, one with a corner at its end.
    pub fn flush_old(&mut self) -> Acted {
        if self.channel.state.place.is_compensated() { (self.plan.actions.flush_due)(self, false) } else { Ok(()) }
    }

    /// The program has ended: the move that is kept back is made, unless the job has been stopped.
    pub fn end_compensation(&mut self, halt: Halt) -> Halt {
        if self.channel.state.place.is_compensated() { (self.plan.actions.end_compensation)(self, halt) } else { halt }
    }

    /// A macro has made another code of compensation active.
    pub fn switch_compensation(&mut self) {
        self.change_compensation(CompensationChange::Code);
    }

    /// Called when a macro has selected another offset of the radius.
    pub fn resize_compensation(&mut self) {
        self.change_compensation(CompensationChange::Number);
    }

    fn change_compensation(&mut self, change: CompensationChange) {
        if let Err(halt) = (self.plan.actions.change_compensation)(self, change) {
            self.macros.calls.stop(halt);
        }
    }

    /// Makes a hole, through the macro of cycles if there is one.
    pub fn cycle_event(&mut self, hole: &CycleHole) -> Acted {
        match self.plan.hooks {
            Some(hooks) => (hooks.cycle)(self, hole),
            None => (self.plan.actions.make_hole)(self, hole),
        }
    }

    /// A macro is about to change offsets: the move that is kept back is made before.
    pub fn flush_for_macro(&mut self) {
        if let Err(halt) = self.flush_lookahead() {
            self.macros.calls.stop(halt);
        }
    }
}
