//! Parts of a program that a condition skips or repeats: whether other channels could notice them.
//!
//! *Invariant:* a part is searched line by line, regardless of its jumps; if they lead beyond it, the part grows. An
//! effect that cannot be known counts as one that others notice.

use std::sync::Arc;

use counterpoint_channel::at::BlockPlace;
use counterpoint_channel::callee::Callee;
use counterpoint_channel::flow::RunningProgram;
use counterpoint_channel::program_places::find_range;
use counterpoint_control_api::Coordination as _;
use counterpoint_control_api::outline::{CallOutline, JumpDestination, OutlineStep};
use counterpoint_event::event::FileId;
use counterpoint_fault::Halt;
use counterpoint_program::shape::ProgramRange;

use super::region::{Looked, Meant, ProgramRegion, before};
use super::statements::computed;
use super::{Linter, MOST, Outline};

/// Most calls within each other that are looked through.
const DEEP: usize = 32;

/// Meaning of a block for its part.
enum RegionEffect {
    Nothing,
    /// Other channels could notice it, or this is unknown.
    Meets,
    /// It ends the program that it is in.
    Ends,
    /// It jumps; the skipped lines start at the first of these lines or end at the second.
    Jumps(Vec<(u32, u32)>),
}

impl Linter<'_, '_> {
    /// Looks through a part of the running program, and the lines that its jumps add to it. A channel that enters a
    /// clear part leaves it after its last line.
    pub(super) fn look_through(&mut self, mut part: ProgramRegion) -> Result<Looked, Halt> {
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
            _ => find_range(&self.kernel.channel, &mut self.kernel.flow, what)
                .map(|range| (self.kernel.channel.at.file, range)),
        };
        match found {
            Some((file, range)) => self.meets_in_program(file, range),
            // Its call is an alarm, which no condition needs to lead to.
            None => Ok(None),
        }
    }

    /// The first line of a program that others could notice.
    pub(super) fn meets_in_program(&mut self, file: FileId, range: ProgramRange) -> Result<Option<u32>, Halt> {
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
        self.kernel.flow.frames.push(RunningProgram::main(file, range, Arc::default()));
        let looked = self.look(ProgramRegion { first: range.first, last: range.last }, false);
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
    fn look(&mut self, part: ProgramRegion, own: bool) -> Result<Looked, Halt> {
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
                RegionEffect::Nothing => {}
                RegionEffect::Ends if !own => {}
                RegionEffect::Ends | RegionEffect::Meets => return Ok(Looked::At(line)),
                RegionEffect::Jumps(lines) => {
                    for (first, last) in lines {
                        (grown.first, grown.last) = (grown.first.min(first), grown.last.max(last));
                    }
                }
            }
        }
    }

    /// Whether other channels could notice one of these steps, or this is unknown.
    pub(super) fn meets_among(&mut self, steps: &[OutlineStep]) -> Result<bool, Halt> {
        Ok(!matches!(self.found_among(steps)?, RegionEffect::Nothing))
    }

    fn found(&mut self, meant: Meant) -> Result<RegionEffect, Halt> {
        Ok(match meant {
            Meant::Nothing => RegionEffect::Nothing,
            Meant::Meet => RegionEffect::Meets,
            Meant::End => RegionEffect::Ends,
            Meant::Call(what) => self.meets_in(&what)?.map_or(RegionEffect::Nothing, |_| RegionEffect::Meets),
        })
    }

    fn found_among(&mut self, steps: &[OutlineStep]) -> Result<RegionEffect, Halt> {
        let names = computed(steps);
        let mut jumps = Vec::new();
        for step in steps {
            let found = match step {
                OutlineStep::Words(text) => {
                    let meant = self.meant(Some(text), &names)?;
                    self.found(meant)?
                }
                OutlineStep::Computed(name) if self.decides(name) => RegionEffect::Meets,
                OutlineStep::Computed(_) | OutlineStep::Block { .. } | OutlineStep::Alarm => RegionEffect::Nothing,
                OutlineStep::Named(named) if self.kernel.coordinates(&named.name).is_some() => RegionEffect::Meets,
                OutlineStep::Named(named) => match named.program {
                    Some((file, range)) => self.meets(file, range)?,
                    None => RegionEffect::Nothing,
                },
                OutlineStep::Call(CallOutline { place: Some((file, range)), .. }) => self.meets(*file, *range)?,
                OutlineStep::Call(_) => RegionEffect::Nothing,
                OutlineStep::Jump(JumpDestination::At(target)) | OutlineStep::Branch(JumpDestination::At(target)) => {
                    RegionEffect::Jumps(vec![(target.line, before(*target))])
                }
                OutlineStep::Jump(JumpDestination::Missing(what))
                | OutlineStep::Branch(JumpDestination::Missing(what)) => {
                    self.report_missing(what);
                    RegionEffect::Nothing
                }
                OutlineStep::Return => RegionEffect::Ends,
                OutlineStep::If(steps) | OutlineStep::Modal(steps) => self.found_among(steps)?,
                OutlineStep::Jump(JumpDestination::Computed) | OutlineStep::Branch(JumpDestination::Computed) => {
                    RegionEffect::Meets
                }
                OutlineStep::Signal(_) | OutlineStep::Hidden(_) | OutlineStep::Mistake(_) => RegionEffect::Meets,
            };
            match found {
                RegionEffect::Nothing => {}
                RegionEffect::Jumps(lines) => jumps.extend(lines),
                other => return Ok(other),
            }
        }
        Ok(if jumps.is_empty() { RegionEffect::Nothing } else { RegionEffect::Jumps(jumps) })
    }

    fn meets(&mut self, file: FileId, range: ProgramRange) -> Result<RegionEffect, Halt> {
        Ok(self.meets_in_program(file, range)?.map_or(RegionEffect::Nothing, |_| RegionEffect::Meets))
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

/// Where a channel is.
pub(super) struct Stands {
    place: BlockPlace,
    offset: u32,
    next: Option<(u32, u32)>,
    edited: Option<std::sync::Arc<[u8]>>,
}
