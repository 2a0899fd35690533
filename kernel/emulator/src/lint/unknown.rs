//! Words that the machine does not have.
//!
//! *Invariant:* each word is reported once per channel, at the first block that has it, and never ends the walk: one look at a
//! program shows all of them.

use counterpoint_fault::{Acted, Halt};
use counterpoint_machine::macros::model::Hook;

use super::regions::Part;
use super::{Outline, Walk};
use counterpoint_dialect::outline::Step;

impl Walk<'_, '_> {
    /// Reports the unknown words of all blocks of the main program, those that no walk can reach included.
    pub(super) fn report_unknown_of_program(&mut self) -> Acted {
        let Some(frame) = self.kernel.frame() else { return Ok(()) };
        let part = Part { first: frame.next, last: frame.range.last };
        let read = self.read;
        let stands = self.stand();
        let reported = self.report_unknown_in(part);
        self.back_to(stands);
        self.read = read;
        reported
    }

    fn report_unknown_in(&mut self, part: Part) -> Acted {
        loop {
            let next = self.kernel.frame().map(|frame| frame.next).filter(|next| *next <= part.last);
            if next.is_none() || self.read > super::MOST {
                return Ok(());
            }
            let Some(text) = self.text()? else { return Ok(()) };
            if self.kernel.ports.control.cancelled() {
                return Err(Halt::Stopped);
            }
            if text.is_empty() {
                continue;
            }
            match self.outline(&text) {
                Outline::Words => {
                    self.kernel.categorise();
                    self.report_unknown();
                }
                Outline::Steps(steps) => self.report_unknown_among(&steps),
            }
        }
    }

    fn report_unknown_among(&mut self, steps: &[Step]) {
        for step in steps {
            match step {
                Step::Words(text) => {
                    let read = self.scan(text);
                    self.kernel.categorise();
                    self.report_unknown();
                    self.kernel.channel.text.edited = read;
                }
                Step::If(steps) => self.report_unknown_among(steps),
                _ => {}
            }
        }
    }

    /// Reports the unknown words of the block whose words have been categorised. Macros of the machine that see whole blocks
    /// may know more words than its tables.
    pub(super) fn report_unknown(&mut self) {
        let kernel = &mut *self.kernel;
        let edited = kernel.hook(Hook::BlockStartup).is_some() || kernel.hook(Hook::BlockShutdown).is_some();
        if !edited && !kernel.channel.block.unrecognised.is_empty() {
            kernel.report_unknown_parts(&mut self.unknown);
        }
    }
}
