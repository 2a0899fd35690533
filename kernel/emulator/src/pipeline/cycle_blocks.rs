//! Control cycles whose blocks the interpreter generates all at once.
//!
//! Facts: reference control-emulator.md 5.7, 6.4. The calling block represents all blocks of the cycle: events and
//! messages name the calling block, and a step executes the whole cycle.
//! *Invariant:* every block is executed like a block of the program, with the same limits, code macros and times.

use std::sync::Arc;

use counterpoint_channel::callee::Pending;
use counterpoint_channel::code_time::end_functions;
use counterpoint_channel::flow::CallRecord;
use counterpoint_channel::text;
use counterpoint_control_api::{CycleWord, MadeBlocks, MadeWord, WordHost};
use counterpoint_event::FileId;
use counterpoint_event::event::{Kind, Return, SubprogramEntry};
use counterpoint_fault::{Acted, Halt};
use counterpoint_program::shape::ProgramRange;

use crate::channel::{Kernel, cycle_moves};

impl Kernel<'_> {
    /// Executes a resident program that is a cycle of the control; false if the program is ordinary.
    pub(crate) fn cycle_at_once(
        &mut self,
        (file, range): (FileId, ProgramRange),
        called: &CallRecord,
        name: &Arc<str>,
    ) -> Result<bool, Halt> {
        if !self.channel.env.info.is_resident(file) {
            return Ok(false);
        }
        let mut blocks = std::mem::take(&mut self.dialect.cycle_blocks);
        let done = self.passes_at_once((file, range), called, name, &mut blocks);
        self.dialect.cycle_blocks = blocks;
        done
    }

    fn passes_at_once(
        &mut self,
        program: (FileId, ProgramRange),
        called: &CallRecord,
        name: &Arc<str>,
        blocks: &mut MadeBlocks,
    ) -> Result<bool, Halt> {
        let mut modes = None;
        for pass in 0..called.passes {
            blocks.clear();
            let made = self.with_interpreter(|interpreter, kernel| interpreter.cycle(kernel, program, blocks));
            if !made.unwrap_or(Ok(false))? {
                return Ok(false);
            }
            if pass == 0 {
                modes = blocks.restores_codes.then(|| self.channel.state.modal.saved());
                self.cycle_begins(name)?;
            }
            let span = (0, u32::try_from(text::current_text(&self.channel).len()).unwrap_or(u32::MAX));
            let mut direct = cycle_moves::may_move(self);
            for words in blocks.iter() {
                self.cycle_block(words, span, &mut direct)?;
            }
        }
        if let Some(modes) = modes.filter(|modes| *modes != self.channel.state.modal.saved()) {
            counterpoint_channel::units::put_modes_back(&mut self.channel, &modes);
        }
        let level = self.flow.frames.len() as u16;
        self.channel.emitter.emit_as(&self.channel.at, 0, |kind| *kind = Kind::Return(Return { level }));
        if let Some(hooks) = self.plan.hooks {
            (hooks.program.returned)(self, called, program)?;
        }
        Ok(true)
    }

    fn cycle_begins(&mut self, name: &Arc<str>) -> Acted {
        let level = self.flow.frames.len() as u16;
        self.channel.emitter.emit_as(&self.channel.at, 0, |kind| {
            *kind = Kind::Call(SubprogramEntry { program: Arc::clone(name), level })
        });
        self.channel.emitter.carries(&self.channel.at, name.len());
        self.flow.pass.changes = true;
        // A hole is at the end of the move before it: no corner leads past it.
        (self.plan.actions.flush_due)(self, true)
    }

    /// Executes a block of a cycle. `span` is the whole calling block, to which each word belongs. `direct`: the words
    /// of straight moves need no sorting.
    fn cycle_block(&mut self, words: &[CycleWord], span: (u32, u32), direct: &mut bool) -> Acted {
        self.channel.keep_pace();
        self.channel.at.blocks += 1;
        self.channel.at.made_blocks += 1;
        self.count_as_block()?;
        self.channel.block.clear();
        self.flow.pass.effects = true;
        if !(*direct && cycle_moves::make(self, words)?) {
            for word in words {
                match *word {
                    CycleWord::Register(word) => self.push(MadeWord { span, ..word }),
                    CycleWord::Text(row) => self.push_text(row),
                }
            }
            self.made_words()?;
            *direct = cycle_moves::may_move(self);
        }
        self.channel.check_stop()?;
        if self.channel.tables.rules.overlaps {
            end_functions(&mut self.channel);
        }
        match self.flow.pending {
            Some(Pending::End(stop)) => Err(Halt::ProgramEnd(Some(stop))),
            _ => Ok(()),
        }
    }
}
