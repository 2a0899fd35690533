//! Parts of a program that a condition skips or repeats: whether other channels could notice them.
//!
//! *Invariant:* a part is searched line by line, regardless of its jumps; if they lead beyond it, the part grows. An
//! effect that cannot be known counts as one that others notice.

use crate::state::at::BlockPlace;
use std::sync::Arc;

use counterpoint_dialect::outline::{Called, Goal, Step};
use counterpoint_event::event::FileId;
use counterpoint_fault::Halt;
use counterpoint_program::shape::Range;
use counterpoint_program::spot::Spot;

use super::statements::computed;
use super::words::Meant;
use super::{MOST, Outline, Walk};
use crate::channel::flow::{Callee, Frame};
use counterpoint_dialect::Coordination as _;

/// Most calls within each other that are looked through.
const DEEP: usize = 32;

/// Lines of the running program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Part {
    pub(super) first: u32,
    pub(super) last: u32,
}

/// Meaning of a block for its part.
enum Found {
    Nothing,
    /// Other channels could notice it, or this is unknown.
    Meets,
    /// It ends the program that it is in.
    Ends,
    /// It jumps; the skipped lines start at the first of these lines or end at the second.
    Jumps(Vec<(u32, u32)>),
}

impl Walk<'_, '_> {
    /// Looks through a part of the running program, and the lines that its jumps add to it. A channel that enters a
    /// clear part leaves it after its last line.
    pub(super) fn look_through(&mut self, mut part: Part) -> Result<Looked, Halt> {
        let stands = self.stand();
        let looked = loop {
            match self.look(part, true) {
                Ok(Looked::Clear(grown)) if grown != part => part = grown,
                other => break other,
            }
        };
        self.back_to(stands);
        looked
    }

    /// The first line of the called text that other channels could notice.
    pub(super) fn meets_in(&mut self, what: &Callee) -> Result<Option<u32>, Halt> {
        let found = match what {
            Callee::Program(_) | Callee::ProgramFrom(..) | Callee::Named(_) => self.kernel.find_program(what)?,
            _ => self.kernel.find_range(what).map(|range| (self.kernel.channel.at.file, range)),
        };
        match found {
            Some((file, range)) => self.meets_in_program(file, range),
            // Its call is an alarm, which no condition needs to lead to.
            None => Ok(None),
        }
    }

    /// The first line of a program that others could notice.
    pub(super) fn meets_in_program(&mut self, file: FileId, range: Range) -> Result<Option<u32>, Halt> {
        let key = (file, range.first, range.last);
        if let Some(known) = self.looked.get(&key) {
            return Ok(*known);
        }
        if self.kernel.flow.frames.len() > DEEP {
            return Ok(Some(range.first));
        }
        // A program that calls itself says nothing new.
        self.looked.insert(key, None);
        let stands = self.stand();
        self.kernel.flow.frames.push(Frame::main(file, range, Arc::default()));
        let looked = self.look(Part { first: range.first, last: range.last }, false);
        self.kernel.flow.frames.pop();
        self.back_to(stands);
        let found = match looked? {
            Looked::Clear(_) => None,
            Looked::At(line) => Some(line),
        };
        self.looked.insert(key, found);
        Ok(found)
    }

    /// Looks through lines of the running program. `own`: ending it matters, and jumps beyond the part make it grow.
    fn look(&mut self, part: Part, own: bool) -> Result<Looked, Halt> {
        let last = part.last;
        let mut grown = part;
        if let Some(frame) = self.kernel.flow.frame() {
            (frame.next, frame.offset) = (part.first, 0);
        }
        loop {
            let next = self.kernel.flow.frame().filter(|frame| frame.next <= last && frame.next <= frame.range.last);
            let Some(line) = next.map(|frame| frame.next) else { return Ok(Looked::Clear(grown)) };
            if self.read > MOST {
                return Ok(Looked::At(line));
            }
            let Some(text) = self.text()? else { return Ok(Looked::Clear(grown)) };
            if text.is_empty() {
                continue;
            }
            if self.kernel.ports.control.cancelled_once_resumed() {
                return Err(Halt::Stopped);
            }
            let outline = self.outline(&text);
            let found = match outline {
                Outline::Words => {
                    let meant = self.meant(None, &[])?;
                    self.found(meant)?
                }
                Outline::Steps(steps) => self.found_among(&steps)?,
            };
            match found {
                Found::Nothing => {}
                Found::Ends if !own => {}
                Found::Ends | Found::Meets => return Ok(Looked::At(line)),
                Found::Jumps(lines) => {
                    for (first, last) in lines {
                        (grown.first, grown.last) = (grown.first.min(first), grown.last.max(last));
                    }
                }
            }
        }
    }

    /// Whether other channels could notice one of these steps, or this is unknown.
    pub(super) fn meets_among(&mut self, steps: &[Step]) -> Result<bool, Halt> {
        Ok(!matches!(self.found_among(steps)?, Found::Nothing))
    }

    fn found(&mut self, meant: Meant) -> Result<Found, Halt> {
        Ok(match meant {
            Meant::Nothing => Found::Nothing,
            Meant::Meet => Found::Meets,
            Meant::End => Found::Ends,
            Meant::Call(what) => self.meets_in(&what)?.map_or(Found::Nothing, |_| Found::Meets),
        })
    }

    fn found_among(&mut self, steps: &[Step]) -> Result<Found, Halt> {
        let names = computed(steps);
        let mut jumps = Vec::new();
        for step in steps {
            let found = match step {
                Step::Words(text) => {
                    let meant = self.meant(Some(text), &names)?;
                    self.found(meant)?
                }
                Step::Computed(name) if self.decides(name) => Found::Meets,
                Step::Computed(_) | Step::Block { .. } | Step::Alarm => Found::Nothing,
                Step::Named(named) if self.kernel.coordinates(&named.name).is_some() => Found::Meets,
                Step::Named(named) => match named.program {
                    Some((file, range)) => self.meets(file, range)?,
                    None => Found::Nothing,
                },
                Step::Call(Called { place: Some((file, range)), .. }) => self.meets(*file, *range)?,
                Step::Call(_) => Found::Nothing,
                Step::Jump(Goal::At(target)) | Step::Branch(Goal::At(target)) => {
                    Found::Jumps(vec![(target.line, before(*target))])
                }
                Step::Jump(Goal::Missing(what)) | Step::Branch(Goal::Missing(what)) => {
                    self.report_missing(what);
                    Found::Nothing
                }
                Step::Return => Found::Ends,
                Step::If(steps) | Step::Modal(steps) => self.found_among(steps)?,
                Step::Jump(Goal::Computed) | Step::Branch(Goal::Computed) => Found::Meets,
                Step::Signal(_) | Step::Hidden(_) | Step::Mistake(_) => Found::Meets,
            };
            match found {
                Found::Nothing => {}
                Found::Jumps(lines) => jumps.extend(lines),
                other => return Ok(other),
            }
        }
        Ok(if jumps.is_empty() { Found::Nothing } else { Found::Jumps(jumps) })
    }

    fn meets(&mut self, file: FileId, range: Range) -> Result<Found, Halt> {
        Ok(self.meets_in_program(file, range)?.map_or(Found::Nothing, |_| Found::Meets))
    }

    /// Where the channel is, to come back to.
    pub(super) fn stand(&self) -> Stands {
        let kernel = &*self.kernel;
        let frame = kernel.flow.frames.last();
        Stands {
            place: kernel.channel.at.block_place(),
            offset: kernel.flow.offset,
            next: frame.map(|frame| (frame.next, frame.offset)),
            edited: kernel.channel.text.edited.clone(),
        }
    }

    pub(super) fn back_to(&mut self, stands: Stands) {
        let kernel = &mut *self.kernel;
        kernel.channel.at.go_to(stands.place);
        kernel.flow.offset = stands.offset;
        kernel.channel.text.edited = stands.edited;
        if let (Some(frame), Some(next)) = (kernel.flow.frames.last_mut(), stands.next) {
            (frame.next, frame.offset) = next;
        }
    }
}

/// The last line before a block; its own where others are before it in the line.
pub(super) fn before(target: Spot) -> u32 {
    if target.offset > 0 { target.line } else { target.line.saturating_sub(1) }
}

/// The findings in a part.
pub(super) enum Looked {
    /// The part is clear; with the lines that its jumps add to it.
    Clear(Part),
    /// Something is in this line.
    At(u32),
}

/// Where a channel is.
pub(super) struct Stands {
    place: BlockPlace,
    offset: u32,
    next: Option<(u32, u32)>,
    edited: Option<std::sync::Arc<[u8]>>,
}
