//! Where the program continues: jumps, loops, calls and returns.

use std::sync::Arc;

use counterpoint_fault::{Acted, Halt};

use counterpoint_event::FileId;
use counterpoint_motion::contour::element::Element;
use counterpoint_motion::turning::strip::Strip;
use counterpoint_program::shape::ProgramRange;
use counterpoint_program::spot::BlockStart;

/// A subprogram that the interpreter calls.
#[derive(Debug, Clone, PartialEq)]
pub struct SubprogramCall {
    /// Name for events, messages and the subprogram macros.
    pub name: Arc<str>,
    /// Its place; a startup macro of the machine may know a place that the interpreter does not.
    pub place: Option<(FileId, ProgramRange)>,
    /// Passes, at least 1.
    pub passes: u32,
    /// The end of its text is its return, without a return code.
    pub closes: bool,
}

/// Loops that the programs are in: level of the program, and the block that opens the loop.
///
/// *Invariant:* loops of outer levels come first.
#[derive(Debug, Default)]
pub struct LoopStack(Vec<(usize, BlockStart)>);

impl LoopStack {
    /// Enters a loop; false if the program is in it.
    pub fn enter(&mut self, level: usize, start: BlockStart) -> bool {
        let entered = !self.0.contains(&(level, start));
        if entered {
            self.0.push((level, start));
        }
        entered
    }

    /// Leaves a loop and those inside it, if the program is in it.
    pub fn leave(&mut self, level: usize, start: BlockStart) {
        if let Some(at) = self.position(level, start) {
            self.0.truncate(at);
        }
    }

    /// Leaves the loops inside a loop for its next pass; false if the program is not in it.
    pub fn repeat(&mut self, level: usize, start: BlockStart) -> bool {
        let found = self.position(level, start);
        if let Some(at) = found {
            self.0.truncate(at + 1);
        }
        found.is_some()
    }

    /// Leaves the loops of a level that do not hold the target of a jump.
    pub fn jump(&mut self, level: usize, holds: impl Fn(BlockStart) -> bool) {
        self.0.retain(|&(of, start)| of != level || holds(start));
    }

    /// Leaves the loops of this level and those inside it: the program of the level starts again.
    pub fn restart(&mut self, level: usize) {
        self.0.retain(|(of, _)| *of < level);
    }

    /// Leaves the loops inside this level: a program returns to it.
    pub fn return_to(&mut self, level: usize) {
        self.0.retain(|(of, _)| *of <= level);
    }

    /// Whether the programs are in no loop.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    fn position(&self, level: usize, start: BlockStart) -> Option<usize> {
        self.0.iter().position(|inside| *inside == (level, start))
    }
}

/// A contour with a name (Okuma LAP).
#[derive(Debug, Clone, PartialEq)]
pub struct NamedContour {
    /// Its name.
    pub name: Arc<str>,
    /// First line.
    pub first: u32,
    /// Last line.
    pub last: u32,
    /// Cuts run along X.
    pub face: bool,
    /// First and last line of the shape of the blank; none without one that counts.
    pub blank: Option<(u32, u32)>,
}

/// Program flow.
pub trait FlowHost {
    /// The block continues at a line of its program.
    ///
    /// # Errors
    /// A loop that can never end.
    fn go_to(&mut self, line: u32) -> Acted;

    /// The same at a block.
    ///
    /// # Errors
    /// Those of [`FlowHost::go_to`].
    fn go_to_block(&mut self, block: BlockStart) -> Acted;

    /// The block with a sequence number: from here on, otherwise from the top of the program.
    ///
    /// # Errors
    /// There is none: an alarm.
    fn sequence(&mut self, number: u32) -> Result<BlockStart, Halt>;

    /// The block after another one of the program.
    fn after(&self, block: BlockStart) -> BlockStart;

    /// All blocks programmed so far are executed before the following ones.
    ///
    /// # Errors
    /// The reason why the channel stops in the meantime.
    fn catch_up(&mut self) -> Acted;

    /// Loops that the programs are in.
    fn loops(&mut self) -> &mut LoopStack;

    /// Calls a subprogram at the end of the block.
    fn call(&mut self, call: SubprogramCall);

    /// After every block that moves, the interpreter is asked for a call, or no longer.
    fn calls_modally(&mut self, on: bool);

    /// The cycle of the block goes along this contour.
    fn cut_along(&mut self, shape: NamedContour);

    /// At the end of the block a subprogram runs whose moves are recorded, not made: they are the contour of cycles to
    /// come.
    fn read_contour(&mut self, call: SubprogramCall);

    /// Whether moves are recorded, not made.
    fn reads_contour(&self) -> bool;

    /// Pieces of the contour that was read last, in the plane of that time: geometry of the machine's unit, radii.
    fn contour(&self) -> &[Element];

    /// Heights of the ends of each piece across the plane, where its first move says one.
    fn contour_heights(&self) -> Option<&[[f64; 2]]>;

    /// Whether the first move of the contour that was read last, which leads to it, is rapid.
    fn contour_begins_rapid(&self) -> bool;

    /// At the end of the block stock is removed along the contour that was read last.
    fn remove_stock(&mut self, strip: Strip);

    /// Returns from the subprogram at the end of the block, or ends the main program.
    fn return_from(&mut self);

    /// The words that the interpreter leaves are the first part of its block. After they have acted, the interpreter
    /// continues the block ([`super::super::interpreter::Interpreter::rest`]).
    fn continue_block(&mut self);

    /// Plain words are for the interpreter too, or no longer.
    fn watch(&mut self, on: bool);

    /// A variable of this channel has changed, or something else that the next pass of a loop could see.
    fn effect(&mut self);

    /// The condition of a loop is evaluated, or no longer.
    fn tests_loop(&mut self, on: bool);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jump_out_and_a_return_leave_loops() {
        let [outer, inner, called] = [BlockStart::line(2), BlockStart::line(4), BlockStart::line(20)];
        let mut loops = LoopStack::default();
        assert!(loops.enter(0, outer) && loops.enter(0, inner) && loops.enter(1, called));
        assert!(!loops.enter(0, inner), "the next pass is no further loop");
        loops.return_to(0);
        assert!(!loops.repeat(1, called) && loops.repeat(0, outer));
        assert!(!loops.repeat(0, inner), "the next pass of a loop leaves those inside");
        loops.jump(0, |start| start == inner);
        assert!(loops.is_empty());
    }
}
