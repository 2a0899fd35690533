//! Cycles along contour blocks: the blocks are read without acting, then the cycle cuts along the contour.
//!
//! The blocks take the usual path through edit, pre-process, split and codes, but by a plan whose actions only record.
//! So variables, expressions and corners count as the control counts them. *Invariant:* reading changes neither the
//! position nor modal codes and data, and no event comes from it but diagnostics, and the blocks, calls and returns of
//! a contour that is a subprogram. Facts: reference turning-cycles.md 1.3. Decision: macros of the machine do not see
//! blocks that are read.

use std::sync::Arc;

use counterpoint_channel::at::BlockPlace;
use counterpoint_channel::block_places::{block_after, is_reshaped};
use counterpoint_channel::callee::Callee;
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::flow::{CallRecord, ProgramFlow, RunningProgram};
use counterpoint_channel::modal::group;
use counterpoint_channel::program_places::find_range;
use counterpoint_channel::turning::{ContourBlocks, ContourCycle, ContourTask, LathePlane, RecordedContour};
use counterpoint_control_api::SubprogramCall;
use counterpoint_event::event::Position;
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_machine::ident::{codes, data};
use counterpoint_motion::contour::element::Element;
use counterpoint_program::shape::ProgramRange;
use counterpoint_program::spot::BlockStart;

use crate::channel::Kernel;

/// Feed while blocks are only read: their times count for nothing.
const READING_FEED: f64 = 1000.0;

impl Kernel<'_> {
    /// Executes a cycle along contour blocks.
    pub(crate) fn contour_cycle(&mut self, cycle: &ContourCycle) -> Acted {
        let (named, first, last) = match &cycle.blocks {
            ContourBlocks::Program(number) => return self.cycle_along_program(cycle, *number),
            ContourBlocks::Numbers(first, last) => (None, *first, *last),
            ContourBlocks::Named { name, first, last, .. } => (Some(name), *first, *last),
        };
        let numbers = (first, last);
        let found = match named {
            Some(_) => Some((BlockStart::line(first), BlockStart::line(last))),
            None => contour_blocks(&self.channel, &mut self.flow, (first, last)),
        };
        let Some((first_block, last_block)) = found else {
            let text = format!("blocks N{first} to N{last} are not in the program of '{}'", self.channel.block_text());
            return Err(self.alarm(&diag::CONTOUR_BLOCKS, text));
        };
        let (first, last) = (first_block, last_block);
        if let ContourTask::Finish { stays, off } = cycle.task {
            let what = match named {
                Some(name) => Callee::Named(Arc::clone(name)),
                None => Callee::Blocks(numbers.0, numbers.1),
            };
            return self.run_contour(first, last, what, (!stays).then_some(off));
        }
        let mut reading = self.read_contour(first, last)?;
        if let ContourBlocks::Named { blank: Some((first, last)), .. } = cycle.blocks {
            reading.blank = self.read_blank(first, last)?;
        }
        (self.plan.actions.cut_contour)(self, cycle, reading)?;
        if named.is_none() && comes_next(&self.channel, &mut self.flow, first) {
            let after = block_after(&self.channel, &self.flow, last);
            if let Some(frame) = self.flow.frame() {
                (frame.next, frame.offset) = (after.line, after.offset);
            }
        }
        Ok(())
    }

    /// Executes a cycle along the moves of a subprogram: of the blocks from a sequence number on, or of a program.
    fn cycle_along_program(&mut self, cycle: &ContourCycle, number: u32) -> Acted {
        let file = self.channel.at.file;
        let blocks = find_range(&self.channel, &mut self.flow, &Callee::From(number)).map(|range| (file, range));
        let place = match blocks {
            Some(blocks) => Some(blocks),
            None => self.find_program(&Callee::Program(number))?,
        };
        let name = if blocks.is_some() { format!("N{number}") } else { format!("O{number:04}") };
        self.read_subprogram(SubprogramCall { name: name.into(), place, passes: 1, closes: false })?;
        let reading = std::mem::take(&mut self.channel.state.others.turning.kept);
        (self.plan.actions.cut_contour)(self, cycle, reading)
    }

    /// Runs the contour as blocks of the program; at its end the tool goes back to where it is now.
    fn run_contour(&mut self, first: BlockStart, last: BlockStart, what: Callee, back: Option<u8>) -> Acted {
        self.check_nesting(|| what.to_string())?;
        let here = self.channel.at.file;
        let file = self.flow.frame().map_or(here, |frame| frame.file);
        let back = back.map(|off| Box::new((self.channel.state.place.programmed(), off)));
        let range = ProgramRange { number: None, first: first.line, last: last.line };
        let name = match &what {
            Callee::Named(name) => Arc::clone(name),
            Callee::Blocks(from, to) => format!("N{from}-N{to}").into(),
            _ => Arc::default(),
        };
        let called = CallRecord { what, passes: 1, block: None };
        let text = RunningProgram::main(file, range, name);
        self.enter(RunningProgram { offset: first.offset, closes: true, called, back, ..text });
        Ok(())
    }

    /// The contour has been run: the tool goes back, as moves of the cycle. Axes that go off the part are first.
    pub(crate) fn end_contour(&mut self, (back, off): &(Position, u8)) -> Acted {
        if let Some(place) = self.flow.frame().map(|frame| {
            let line = if frame.offset == 0 { frame.next.saturating_sub(1) } else { frame.next };
            BlockPlace { file: frame.file, line, caller: frame.caller }
        }) {
            self.channel.at.go_to(place);
            self.channel.text.edited = None;
        }
        if *off != 0 {
            let mut first = self.channel.state.place.programmed();
            for (index, (slot, back)) in first.iter_mut().zip(*back).enumerate() {
                *slot = if off & 1 << index == 0 { *slot } else { back };
            }
            (self.plan.actions.straight.back)(self, &first)?;
        }
        (self.plan.actions.straight.back)(self, back)
    }

    /// Reads the contour.
    fn read_contour(&mut self, first: BlockStart, last: BlockStart) -> Result<RecordedContour, Halt> {
        let next = self.flow.frame().map(|frame| (frame.next, frame.offset));
        self.reading(None, |kernel| {
            let done = kernel.read_blocks(first, last);
            if let (Some(frame), Some(next)) = (kernel.flow.frame(), next) {
                (frame.next, frame.offset) = next;
            }
            done
        })
    }

    /// Reads the shape of a blank, which has no rapid move.
    fn read_blank(&mut self, first: u32, last: u32) -> Result<Vec<Element>, Halt> {
        let blank = self.read_contour(BlockStart::line(first), BlockStart::line(last))?;
        if blank.first.is_some_and(|first| !first.rapid) && !blank.elements.is_empty() {
            return Ok(blank.elements);
        }
        let text = format!(
            "the shape of the blank of '{}' has a straight move at a feed first, and pieces",
            self.channel.block_text()
        );
        Err(self.alarm(&diag::CONTOUR_FIRST, text))
    }

    /// Runs a subprogram whose moves are the contour of cycles to come (Siemens).
    pub(crate) fn read_subprogram(&mut self, call: SubprogramCall) -> Acted {
        let plane = self.channel.active_plane();
        let place = self.channel.at.block_place();
        self.channel.state.others.turning.reads = true;
        let read = self.reading(plane, |kernel| {
            let level = kernel.flow.frames.len();
            kernel.call_text(call)?;
            while kernel.flow.frames.len() > level {
                kernel.step()?;
            }
            Ok(())
        });
        self.channel.state.others.turning.reads = false;
        self.channel.at.go_to(place);
        self.channel.state.others.turning.kept = read?;
        Ok(())
    }

    /// Lets blocks be read: their moves are recorded in a plane, and none of their changes remain.
    fn reading(
        &mut self,
        plane: Option<LathePlane>,
        blocks: impl FnOnce(&mut Self) -> Acted,
    ) -> Result<RecordedContour, Halt> {
        let Some(plan) = self.plan.reading.as_deref() else { return Ok(RecordedContour::default()) };
        let outer_plan = std::mem::replace(&mut self.plan, plan);
        let start = self.channel.state.place.programmed();
        let place = &mut self.channel.state.place;
        let place = (std::mem::replace(&mut place.position, start), place.frames.take());
        let (modal, remembered) = (self.channel.state.modal.clone(), self.channel.state.remembered.clone());
        let (cycle, arcs) = (self.channel.state.cycle, std::mem::take(&mut self.channel.state.arcs));
        let secondary = self.channel.state.secondary;
        let text = (self.channel.at.line, self.channel.text.edited.take(), self.flow.offset);
        let block = self.channel.context.enter();

        self.channel.state.threads.recorded = None;
        let own = RecordedContour { start: self.channel.flat(&start), plane, ..RecordedContour::default() };
        self.channel.state.others.turning.reading = own;
        // A feed per minute needs no spindle; moves are only recorded.
        self.channel.state.modal.activate(group::FEED, codes::FEED_UPM, None);
        self.channel.state.remembered.remember(data::FEED_UPM, READING_FEED);
        // Feeds per revolution of the contour are read as feeds per minute.
        let long_move = std::mem::replace(&mut self.channel.reports.plausible.long_move, true);
        let done = blocks(self).and_then(|()| self.flush_lookahead());
        self.channel.reports.plausible.long_move = long_move;
        let done = done.map_err(|halt| self.end_compensation(halt));

        self.channel.context = block;
        (self.channel.at.line, self.channel.text.edited, self.flow.offset) = text;
        self.channel.state.secondary = secondary;
        (self.channel.state.cycle, self.channel.state.arcs) = (cycle, arcs);
        (self.channel.state.modal, self.channel.state.remembered) = (modal, remembered);
        (self.channel.state.place.position, self.channel.state.place.frames) = place;
        self.plan = outer_plan;
        done?;
        Ok(std::mem::take(&mut self.channel.state.others.turning.reading))
    }

    /// Reads the blocks from the first to the last one.
    fn read_blocks(&mut self, first: BlockStart, last: BlockStart) -> Acted {
        if let Some(frame) = self.flow.frame() {
            (frame.next, frame.offset) = (first.line, first.offset);
        }
        let sources = self.channel.env.sources;
        loop {
            let Some((file, here)) = self.flow.frame().map(|frame| (frame.file, frame.next_block())) else {
                return Ok(());
            };
            let Some(source) = sources.get(file).filter(|_| (first..=last).contains(&here)) else { return Ok(()) };
            self.count_as_block()?;
            if let Some(frame) = self.flow.frame() {
                frame.next = here.line + 1;
            }
            let text = source.line(here.line);
            self.channel.at.line = here.line;
            let held;
            let text = if self.channel.tables.edits.reshapes && is_reshaped(&mut self.channel, &self.flow, source) {
                held = self.reshape(text, here.line)?;
                held.text()
            } else {
                text
            };
            if text.trim_ascii().is_empty() {
                continue;
            }
            if self.channel.tables.edits.long_comments {
                self.pass_long_comment(source, here.line, text)?;
            }
            (self.channel.context.text, self.channel.context.left) = (None, None);
            let next = self.flow.frame().map(|frame| frame.next_block());
            self.block(text)?;
            self.channel.check_stop()?;
            if self.flow.pending.take().is_some() || self.flow.frame().map(|frame| frame.next_block()) != next {
                let text = format!("a contour has no call, return, end or jump: '{}'", self.channel.block_text());
                return Err(self.alarm(&diag::CONTOUR_CODE, text));
            }
        }
    }
}

/// Where the blocks are: the first ones of these numbers in the program, the last one not before the first.
fn contour_blocks(
    channel: &ChannelContext<'_>,
    flow: &mut ProgramFlow,
    (first, last): (u32, u32),
) -> Option<(BlockStart, BlockStart)> {
    let sources = channel.env.sources;
    let (file, range) = flow.frame().map(|frame| (frame.file, frame.range))?;
    let source = sources.get(file)?;
    let from = |number, after: BlockStart| {
        let spots = source.sequences(number).iter();
        spots.copied().find(|spot| *spot >= after && spot.line <= range.last)
    };
    let first = from(first, BlockStart::line(range.first))?;
    Some((first, from(last, first)?))
}

/// Whether nothing but blank lines and comments is between this block and the contour.
fn comes_next(channel: &ChannelContext<'_>, flow: &mut ProgramFlow, first: BlockStart) -> bool {
    let sources = channel.env.sources;
    let Some((file, next)) = flow.frame().map(|frame| (frame.file, frame.next_block())) else { return false };
    let Some(source) = sources.get(file) else { return false };
    first >= next && (next.line..first.line).all(|line| !source.has_text(line))
}
