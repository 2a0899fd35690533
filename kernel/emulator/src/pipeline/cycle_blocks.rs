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
        let done = passes_at_once(self, (file, range), called, name, &mut blocks);
        self.dialect.cycle_blocks = blocks;
        done
    }
}

fn passes_at_once(
    kernel: &mut Kernel<'_>,
    program: (FileId, ProgramRange),
    called: &CallRecord,
    name: &Arc<str>,
    blocks: &mut MadeBlocks,
) -> Result<bool, Halt> {
    let mut modes = None;
    for pass in 0..called.passes {
        blocks.clear();
        let made = kernel.with_interpreter(|interpreter, kernel| interpreter.cycle(kernel, program, blocks));
        if !made.unwrap_or(Ok(false))? {
            return Ok(false);
        }
        if pass == 0 {
            modes = blocks.restores_codes.then(|| kernel.channel.state.modal.saved());
            cycle_begins(kernel, name)?;
        }
        let span = (0, u32::try_from(text::current_text(&kernel.channel).len()).unwrap_or(u32::MAX));
        let mut direct = cycle_moves::may_move(kernel);
        for words in blocks.iter() {
            cycle_block(kernel, words, span, &mut direct)?;
        }
    }
    if let Some(modes) = modes.filter(|modes| *modes != kernel.channel.state.modal.saved()) {
        counterpoint_channel::units::put_modes_back(&mut kernel.channel, &modes);
    }
    let level = kernel.flow.frames.len() as u16;
    kernel.channel.emitter.emit_as(&kernel.channel.at, 0, |kind| *kind = Kind::Return(Return { level }));
    if let Some(hooks) = kernel.plan.hooks {
        (hooks.program.returned)(kernel, called, program)?;
    }
    Ok(true)
}

fn cycle_begins(kernel: &mut Kernel<'_>, name: &Arc<str>) -> Acted {
    let level = kernel.flow.frames.len() as u16;
    kernel.channel.emitter.emit_as(&kernel.channel.at, 0, |kind| {
        *kind = Kind::Call(SubprogramEntry { program: Arc::clone(name), level })
    });
    kernel.channel.emitter.carries(&kernel.channel.at, name.len());
    kernel.flow.pass.changes = true;
    // A hole is at the end of the move before it: no corner leads past it.
    (kernel.plan.actions.flush_due)(kernel, true)
}

/// Executes a block of a cycle. `span` is the whole calling block, to which each word belongs. `direct`: the words
/// of straight moves need no sorting.
fn cycle_block(kernel: &mut Kernel<'_>, words: &[CycleWord], span: (u32, u32), direct: &mut bool) -> Acted {
    kernel.channel.keep_pace();
    kernel.channel.at.blocks += 1;
    kernel.channel.at.made_blocks += 1;
    kernel.count_as_block()?;
    kernel.channel.block.clear();
    kernel.flow.pass.effects = true;
    if !(*direct && cycle_moves::make(kernel, words)?) {
        for word in words {
            match *word {
                CycleWord::Register(word) => kernel.push(MadeWord { span, ..word }),
                CycleWord::Text(row) => kernel.push_text(row),
            }
        }
        kernel.made_words()?;
        *direct = cycle_moves::may_move(kernel);
    }
    kernel.channel.check_stop()?;
    if kernel.channel.tables.rules.overlaps {
        end_functions(&mut kernel.channel);
    }
    match kernel.flow.pending {
        Some(Pending::End(stop)) => Err(Halt::ProgramEnd(Some(stop))),
        _ => Ok(()),
    }
}
