//! Words that the machine does not have.
//!
//! *Invariant:* each word is reported once per channel, at the first block that has it, and never ends the walk: one
//! look at a program shows all of them.

use counterpoint_control_api::outline::OutlineStep;
use counterpoint_fault::{Acted, Halt};
use counterpoint_machine::macros::model::Hook;

use super::region::{Certain, ProgramRegion};
use super::{Linter, Outline};

/// Macros of these see the text of blocks and may change it.
const BLOCK_HOOKS: [Hook; 4] =
    [Hook::PreprocessorStartup, Hook::PreprocessorShutdown, Hook::BlockStartup, Hook::BlockShutdown];

impl Linter<'_, '_> {
    /// Reports the unknown words of all blocks of the main program, those that no walk can reach included.
    pub(super) fn report_unknown_of_program(&mut self) -> Acted {
        let Some(frame) = self.kernel.flow.frame() else { return Ok(()) };
        let part = ProgramRegion { first: frame.next, last: frame.range.last };
        let read = self.read;
        let stands = self.stand();
        let reported = self.report_unknown_in(part);
        self.back_to(stands);
        self.read = read;
        reported
    }

    fn report_unknown_in(&mut self, part: ProgramRegion) -> Acted {
        loop {
            let next = self.kernel.flow.frame().map(|frame| frame.next).filter(|next| *next <= part.last);
            if next.is_none() || self.read > super::MOST {
                return Ok(());
            }
            let Some(text) = self.text()? else { return Ok(()) };
            if self.kernel.ports.control.cancelled_once_resumed() {
                return Err(Halt::Stopped);
            }
            if text.is_empty() {
                continue;
            }
            match self.outline(&text) {
                Outline::Words => {
                    let calls = self.kernel.categorise();
                    self.report_unknown(Certain { calls, computed: false });
                }
                Outline::Steps(steps) => self.report_unknown_among(&steps),
            }
            // Words that call have requested it.
            self.kernel.flow.pending = None;
        }
    }

    fn report_unknown_among(&mut self, steps: &[OutlineStep]) {
        let texts = steps.iter().filter(|step| matches!(step, OutlineStep::Words(_))).count();
        let computed = texts > 1 || steps.iter().any(|step| matches!(step, OutlineStep::Computed(_)));
        for step in steps {
            match step {
                OutlineStep::Words(text) => {
                    let read = self.scan(text);
                    let calls = self.kernel.categorise();
                    self.report_unknown(Certain { calls, computed });
                    self.kernel.channel.text.edited = read;
                }
                OutlineStep::If(steps) | OutlineStep::Modal(steps) => self.report_unknown_among(steps),
                _ => {}
            }
        }
    }

    /// Reports the unknown words of the block whose words have been categorised. Macros of the machine that see whole
    /// blocks may know more words than its tables, and so may another component of a composite machine.
    pub(super) fn report_unknown(&mut self, certain: Certain) {
        let kernel = &mut *self.kernel;
        let has = |hook| kernel.channel.env.machine.macros.as_ref().is_some_and(|macros| macros.hook(hook).is_some());
        let edited = BLOCK_HOOKS.into_iter().any(has);
        let composite = kernel.channel.env.whole.components.len() > 1;
        if !edited && !composite && !certain.calls && !kernel.channel.block.unrecognised.is_empty() {
            kernel.report_unknown_parts(&mut self.unknown, certain.computed);
        }
    }
}
