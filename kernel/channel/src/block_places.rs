//! Start and end of the blocks of a text.
//!
//! Facts: reference control-emulator.md 2.1. *Invariant:* the tape editor changes the text of a block, never its
//! position.

use counterpoint_program::source::ProgramSource;
use counterpoint_program::spot::BlockStart;

use crate::channel_context::ChannelContext;
use crate::flow::ProgramFlow;

/// Whether blocks of a file may differ from its lines: the tape editor changes them, or a character that ends
/// blocks is somewhere in the file.
#[inline(always)]
pub fn is_reshaped(channel: &mut ChannelContext<'_>, flow: &ProgramFlow, source: &ProgramSource) -> bool {
    let tape = channel.tables.edits.tape.as_ref();
    if tape.is_some_and(|tape| !tape.leaves_alone(source, &channel.text.tape.0))
        || channel.tables.scanner.eob().is_some_and(|eob| source.has(eob))
        || channel.tables.edits.long_comments && flow.frames.last().is_some_and(|frame| frame.offset > 0)
    {
        return true;
    }
    if channel.text.edited.is_some() {
        channel.text.edited = None;
    }
    false
}

/// The part of a line that is the next block, and whether it is the only one of the line.
pub fn part_of_line<'l>(
    channel: &ChannelContext<'_>,
    flow: &mut ProgramFlow,
    line: &'l [u8],
    number: u32,
) -> (&'l [u8], bool) {
    let Some(frame) = flow.frames.last_mut() else { return (line, true) };
    let from = std::mem::take(&mut frame.offset) as usize;
    flow.offset = from as u32;
    let rest = line.get(from..).unwrap_or_default();
    let Some(end) = channel.tables.scanner.block_end(rest) else { return (rest, from == 0) };
    let after = rest.get(end + 1..).unwrap_or_default();
    let last = after.trim_ascii().is_empty();
    if !last {
        (frame.next, frame.offset) = (number, (from + end + 1) as u32);
    }
    (rest.get(..end).unwrap_or_default(), from == 0 && last)
}

/// The blocks of a line that are not blank, each with the byte after its end.
pub fn blocks_of<'l>(channel: &ChannelContext<'_>, line: &'l [u8]) -> Vec<(&'l [u8], usize)> {
    let (mut from, mut found) = (0, Vec::new());
    while let Some(rest) = line.get(from..).filter(|rest| !rest.is_empty()) {
        let length = channel.tables.scanner.block_end(rest).unwrap_or(rest.len());
        let block = rest.get(..length).unwrap_or_default();
        from += length + 1;
        if !block.trim_ascii().is_empty() {
            found.push((block, from));
        }
    }
    found
}

/// Text of the block before or after the current one, none at the ends of the program. A line may have several.
pub fn neighbour_block(channel: &ChannelContext<'_>, flow: &ProgramFlow, behind: bool) -> Option<String> {
    let frame = flow.frames.last()?;
    let source = channel.env.sources.get(frame.file)?;
    let text = |block: &[u8]| String::from_utf8_lossy(block).into_owned();
    if behind {
        let rest =
            blocks_of(channel, source.line(frame.next)).into_iter().find(|(_, end)| *end > frame.offset as usize);
        let first = |line: u32| blocks_of(channel, source.line(line)).first().map(|(block, _)| text(block));
        return match rest.filter(|_| frame.next <= frame.range.last) {
            Some((block, _)) => Some(text(block)),
            None => (frame.next.saturating_add(1)..=frame.range.last).find_map(first),
        };
    }
    let spot = block_start(channel, flow);
    let own = blocks_of(channel, source.line(spot.line)).into_iter().rfind(|(_, end)| *end <= spot.offset as usize);
    let last = |line: u32| blocks_of(channel, source.line(line)).last().map(|(block, _)| text(block));
    own.map(|(block, _)| text(block)).or_else(|| (frame.range.first..channel.at.line).rev().find_map(last))
}

/// Start of the current block. Only a block with a text of its own can start within its line.
pub fn block_start(channel: &ChannelContext<'_>, flow: &ProgramFlow) -> BlockStart {
    BlockStart { line: channel.at.line, offset: if channel.text.edited.is_some() { flow.offset } else { 0 } }
}

/// Start of the block after another block of the current program.
pub fn block_after(channel: &ChannelContext<'_>, flow: &ProgramFlow, spot: BlockStart) -> BlockStart {
    let file = flow.frames.last().map_or(channel.at.file, |frame| frame.file);
    let line = channel.env.sources.get(file).map_or(&[][..], |source| source.line(spot.line));
    let next = channel.tables.scanner.block_starts(line).find(|&start| start > spot.offset as usize);
    next.map_or(BlockStart::line(spot.line + 1), |start| BlockStart { line: spot.line, offset: start as u32 })
}
