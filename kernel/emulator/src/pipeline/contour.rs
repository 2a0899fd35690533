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
use crate::pipeline::edit::reshape;
use crate::pipeline::long_comments::pass_long_comment;
use crate::pipeline::process_block;

/// Feed while blocks are only read; their times have no effect.
const READING_FEED: f64 = 1000.0;

/// Executes a cycle along contour blocks.
pub(crate) fn contour_cycle(kernel: &mut Kernel<'_>, cycle: &ContourCycle) -> Acted {
    let (named, first, last) = match &cycle.blocks {
        ContourBlocks::Program(number) => return cycle_along_program(kernel, cycle, *number),
        ContourBlocks::Numbers(first, last) => (None, *first, *last),
        ContourBlocks::Named { name, first, last, .. } => (Some(name), *first, *last),
    };
    let numbers = (first, last);
    let found = match named {
        Some(_) => Some((BlockStart::line(first), BlockStart::line(last))),
        None => contour_blocks(&kernel.channel, &mut kernel.flow, (first, last)),
    };
    let Some((first_block, last_block)) = found else {
        let text = format!("blocks N{first} to N{last} are not in the program of '{}'", kernel.channel.block_text());
        return Err(kernel.alarm(&diag::CONTOUR_BLOCKS, text));
    };
    let (first, last) = (first_block, last_block);
    if let ContourTask::Finish { stays, off } = cycle.task {
        let what = match named {
            Some(name) => Callee::Named(Arc::clone(name)),
            None => Callee::Blocks(numbers.0, numbers.1),
        };
        return run_contour(kernel, first, last, what, (!stays).then_some(off));
    }
    let mut reading = read_contour(kernel, first, last)?;
    if let ContourBlocks::Named { blank: Some((first, last)), .. } = cycle.blocks {
        reading.blank = read_blank(kernel, first, last)?;
    }
    (kernel.plan.actions.cut_contour)(kernel, cycle, reading)?;
    if named.is_none() && comes_next(&kernel.channel, &mut kernel.flow, first) {
        let after = block_after(&kernel.channel, &kernel.flow, last);
        if let Some(frame) = kernel.flow.frame() {
            (frame.next, frame.offset) = (after.line, after.offset);
        }
    }
    Ok(())
}

/// Executes a cycle along the moves of a subprogram: of the blocks from a sequence number on, or of a program.
fn cycle_along_program(kernel: &mut Kernel<'_>, cycle: &ContourCycle, number: u32) -> Acted {
    let file = kernel.channel.at.file;
    let blocks = find_range(&kernel.channel, &mut kernel.flow, &Callee::From(number)).map(|range| (file, range));
    let place = match blocks {
        Some(blocks) => Some(blocks),
        None => kernel.find_program(&Callee::Program(number))?,
    };
    let name = if blocks.is_some() { format!("N{number}") } else { format!("O{number:04}") };
    read_subprogram(kernel, SubprogramCall { name: name.into(), place, passes: 1, closes: false })?;
    let reading = std::mem::take(&mut kernel.channel.state.others.turning.kept);
    (kernel.plan.actions.cut_contour)(kernel, cycle, reading)
}

/// Runs the contour as blocks of the program; at the end the tool returns to its current position.
fn run_contour(kernel: &mut Kernel<'_>, first: BlockStart, last: BlockStart, what: Callee, back: Option<u8>) -> Acted {
    kernel.check_nesting(|| what.to_string())?;
    let here = kernel.channel.at.file;
    let file = kernel.flow.frame().map_or(here, |frame| frame.file);
    let back = back.map(|off| Box::new((kernel.channel.state.place.programmed(), off)));
    let range = ProgramRange { number: None, first: first.line, last: last.line };
    let name = match &what {
        Callee::Named(name) => Arc::clone(name),
        Callee::Blocks(from, to) => format!("N{from}-N{to}").into(),
        _ => Arc::default(),
    };
    let called = CallRecord { what, passes: 1, block: None };
    let text = RunningProgram::main(file, range, name);
    kernel.enter(RunningProgram { offset: first.offset, closes: true, called, back, ..text });
    Ok(())
}

/// Returns the tool after the contour, by moves of the cycle. Axes that leave the part move first.
pub(crate) fn end_contour(kernel: &mut Kernel<'_>, (back, off): &(Position, u8)) -> Acted {
    if let Some(place) = kernel.flow.frame().map(|frame| {
        let line = if frame.offset == 0 { frame.next.saturating_sub(1) } else { frame.next };
        BlockPlace { file: frame.file, line, caller: frame.caller }
    }) {
        kernel.channel.at.go_to(place);
        kernel.channel.text.edited = None;
    }
    if *off != 0 {
        let mut first = kernel.channel.state.place.programmed();
        for (index, (slot, back)) in first.iter_mut().zip(*back).enumerate() {
            *slot = if off & 1 << index == 0 { *slot } else { back };
        }
        (kernel.plan.actions.straight.back)(kernel, &first)?;
    }
    (kernel.plan.actions.straight.back)(kernel, back)
}

/// Reads the contour.
fn read_contour(kernel: &mut Kernel<'_>, first: BlockStart, last: BlockStart) -> Result<RecordedContour, Halt> {
    let next = kernel.flow.frame().map(|frame| (frame.next, frame.offset));
    read_as_contour(kernel, None, |kernel| {
        let done = read_blocks(kernel, first, last);
        if let (Some(frame), Some(next)) = (kernel.flow.frame(), next) {
            (frame.next, frame.offset) = next;
        }
        done
    })
}

/// Reads the shape of a blank, which has no rapid move.
fn read_blank(kernel: &mut Kernel<'_>, first: u32, last: u32) -> Result<Vec<Element>, Halt> {
    let blank = read_contour(kernel, BlockStart::line(first), BlockStart::line(last))?;
    if blank.first.is_some_and(|first| !first.rapid) && !blank.elements.is_empty() {
        return Ok(blank.elements);
    }
    let text = format!(
        "the shape of the blank of '{}' has a straight move at a feed first, and pieces",
        kernel.channel.block_text()
    );
    Err(kernel.alarm(&diag::CONTOUR_FIRST, text))
}

/// Runs a subprogram whose moves are the contour of cycles to come (Siemens).
pub(crate) fn read_subprogram(kernel: &mut Kernel<'_>, call: SubprogramCall) -> Acted {
    let plane = kernel.channel.state.active_plane();
    let place = kernel.channel.at.block_place();
    kernel.channel.state.others.turning.reads = true;
    let read = read_as_contour(kernel, plane, |kernel| {
        let level = kernel.flow.frames.len();
        kernel.call_text(call)?;
        while kernel.flow.frames.len() > level {
            kernel.step()?;
        }
        Ok(())
    });
    kernel.channel.state.others.turning.reads = false;
    kernel.channel.at.go_to(place);
    kernel.channel.state.others.turning.kept = read?;
    Ok(())
}

/// Reads blocks: their moves are recorded in a plane, and none of their changes remain.
fn read_as_contour(
    kernel: &mut Kernel<'_>,
    plane: Option<LathePlane>,
    blocks: impl FnOnce(&mut Kernel<'_>) -> Acted,
) -> Result<RecordedContour, Halt> {
    let Some(plan) = kernel.plan.reading.as_deref() else { return Ok(RecordedContour::default()) };
    let outer_plan = std::mem::replace(&mut kernel.plan, plan);
    let start = kernel.channel.state.place.programmed();
    let place = &mut kernel.channel.state.place;
    let place = (std::mem::replace(&mut place.position, start), place.frames.take());
    let (modal, remembered) = (kernel.channel.state.modal.clone(), kernel.channel.state.remembered.clone());
    let (cycle, arcs) = (kernel.channel.state.cycle, std::mem::take(&mut kernel.channel.state.arcs));
    let secondary = kernel.channel.state.secondary;
    let text = (kernel.channel.at.line, kernel.channel.text.edited.take(), kernel.flow.offset);
    let block = kernel.channel.context.enter();

    kernel.channel.state.threads.recorded = None;
    let own = RecordedContour { start: kernel.channel.state.flat(&start), plane, ..RecordedContour::default() };
    kernel.channel.state.others.turning.reading = own;
    // A feed per minute needs no spindle; moves are only recorded.
    kernel.channel.state.modal.activate(group::FEED, codes::FEED_UPM, None);
    kernel.channel.state.remembered.remember(data::FEED_UPM, READING_FEED);
    // Feeds per revolution of the contour are read as feeds per minute.
    let long_move = std::mem::replace(&mut kernel.channel.reports.plausible.long_move, true);
    let done = blocks(kernel).and_then(|()| kernel.flush_lookahead());
    kernel.channel.reports.plausible.long_move = long_move;
    let done = done.map_err(|halt| kernel.end_compensation(halt));

    kernel.channel.context = block;
    (kernel.channel.at.line, kernel.channel.text.edited, kernel.flow.offset) = text;
    kernel.channel.state.secondary = secondary;
    (kernel.channel.state.cycle, kernel.channel.state.arcs) = (cycle, arcs);
    (kernel.channel.state.modal, kernel.channel.state.remembered) = (modal, remembered);
    (kernel.channel.state.place.position, kernel.channel.state.place.frames) = place;
    kernel.plan = outer_plan;
    done?;
    Ok(std::mem::take(&mut kernel.channel.state.others.turning.reading))
}

/// Reads the blocks from the first to the last block.
fn read_blocks(kernel: &mut Kernel<'_>, first: BlockStart, last: BlockStart) -> Acted {
    if let Some(frame) = kernel.flow.frame() {
        (frame.next, frame.offset) = (first.line, first.offset);
    }
    let sources = kernel.channel.env.sources;
    loop {
        let Some((file, here)) = kernel.flow.frame().map(|frame| (frame.file, frame.next_block())) else {
            return Ok(());
        };
        let Some(source) = sources.get(file).filter(|_| (first..=last).contains(&here)) else { return Ok(()) };
        kernel.count_as_block()?;
        if let Some(frame) = kernel.flow.frame() {
            frame.next = here.line + 1;
        }
        let text = source.line(here.line);
        kernel.channel.at.line = here.line;
        let held;
        let text = if kernel.channel.tables.edits.reshapes && is_reshaped(&mut kernel.channel, &kernel.flow, source) {
            held = reshape(kernel, text, here.line)?;
            held.text()
        } else {
            text
        };
        if text.trim_ascii().is_empty() {
            continue;
        }
        if kernel.channel.tables.edits.long_comments {
            pass_long_comment(kernel, source, here.line, text)?;
        }
        (kernel.channel.context.text, kernel.channel.context.left) = (None, None);
        let next = kernel.flow.frame().map(|frame| frame.next_block());
        process_block(kernel, text)?;
        kernel.channel.check_stop()?;
        if kernel.flow.pending.take().is_some() || kernel.flow.frame().map(|frame| frame.next_block()) != next {
            let text = format!("a contour has no call, return, end or jump: '{}'", kernel.channel.block_text());
            return Err(kernel.alarm(&diag::CONTOUR_CODE, text));
        }
    }
}

/// Position of the blocks: the first blocks with these numbers in the program, the last block not before the first.
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
