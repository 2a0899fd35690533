//! Comments over several lines, on machines that have them.
//!
//! Facts: programs of Citizen lathes put whole parts of a program in brackets. *Invariant:* nothing between the start
//! of a comment and its end acts.

use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_program::source::ProgramSource;

use crate::channel::Kernel;

/// Where a comment of this block, the last of its line, is not closed, reading continues after its end in a later
/// line; without an end all of the program that follows is comment.
///
/// # Errors
/// The job is to end.
pub(crate) fn pass_long_comment(kernel: &mut Kernel<'_>, source: &ProgramSource, line: u32, text: &[u8]) -> Acted {
    let Some(end) = kernel.channel.tables.scanner.open_comment(text) else { return Ok(()) };
    let Some(frame) = kernel.flow.frames.last_mut() else { return Ok(()) };
    let close = source.walk(line.saturating_add(1), frame.range.last).find_map(|number| {
        let at = memchr::memmem::find(source.line(number), end)?;
        Some((number, at + end.len()))
    });
    let Some((number, after)) = close else {
        frame.next = frame.range.last.saturating_add(1);
        let text =
            format!("the comment that begins in line {line} is not closed: all that follows in the program is comment");
        kernel.diagnose(&diag::COMMENT_OPEN, text);
        return Ok(());
    };
    let ended = source.line(number).get(after..).unwrap_or_default().trim_ascii().is_empty();
    (frame.next, frame.offset) = if ended { (number + 1, 0) } else { (number, after as u32) };
    // A skipped line is much less work than a block.
    kernel.work(number.saturating_sub(line) as usize / 16)
}
