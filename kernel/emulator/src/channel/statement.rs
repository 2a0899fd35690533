//! Statements: blocks for the interpreter of the control.
//!
//! Facts: reference control-emulator.md 2.2, 4.3, 5.4, 5.7. *Invariant:* an interpreter leaves words in the block, never
//! a text. On a kernel with macros they continue to Pre-Processor Shutdown.

use std::sync::Arc;

use counterpoint_channel::callee::Callee;
use counterpoint_channel::flow::RunningProgram;
use counterpoint_control_api::{Interpreter, Remaining, SubprogramCall};
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_program::source::ProgramSource;
use counterpoint_program::spot::BlockStart;

use super::Kernel;
use crate::channel::dialect_state::DialectState;
use crate::channel::macro_queries::call_record;
use counterpoint_channel::trace::trace_left;

impl Kernel<'_> {
    /// A block that is more than plain words.
    pub(crate) fn statement_line(&mut self, text: &[u8]) -> Acted {
        if self.channel.env.trace.is_some() {
            self.trace_deleted(text);
        }
        self.channel.block.clear();
        let done = self.with_interpreter(|interpreter, kernel| {
            kernel.dialect.left.clear(kernel.asks_left_text());
            interpreter.block(kernel, text)
        });
        match done {
            Some(remaining) => parts(self, remaining?, text),
            None => {
                let text = format!(
                    "'{}' is issued while the pre-processor waits for a macro; ignored",
                    self.channel.block_text()
                );
                self.diagnose(&diag::PREPROCESSOR_ASKS, text);
                Ok(())
            }
        }
    }

    /// A line that the interpreter is known to execute, on a kernel without macros.
    #[inline(always)]
    pub(crate) fn known_statement(&mut self, source: &ProgramSource) -> Acted {
        let line = (self.channel.at.file, self.channel.at.line);
        let Some(mut interpreter) = self.dialect.interpreter.take() else { return Ok(()) };
        self.channel.block.clear();
        let made = interpreter.known_block(self, line);
        self.dialect.interpreter = Some(interpreter);
        if std::mem::take(&mut self.dialect.is_stale) {
            forget_lines(&mut self.dialect);
        }
        match made {
            Some(Ok(Remaining::Nothing)) => Ok(()),
            Some(Ok(Remaining::Words)) => self.made_words(),
            Some(Err(halt)) => Err(halt),
            None => self.statement_line(source.line(line.1)),
        }
    }

    /// Executes the words that an interpreter has left of a block.
    fn remains(&mut self, remaining: Remaining, text: &[u8]) -> Acted {
        match remaining {
            Remaining::Nothing => Ok(()),
            Remaining::Words => self.remaining_words(text),
        }
    }

    /// Executes the words that the interpreter has added to the block, after the blocks that it has ended.
    fn remaining_words(&mut self, whole: &[u8]) -> Acted {
        let joined = self.dialect.left.joined.take();
        let read = joined.map(|joined| self.channel.text.edited.replace(joined));
        let acted =
            if self.dialect.left.blocks.is_empty() { remaining_block(self, whole) } else { blocks(self, whole) };
        // The next block has a text of its own.
        if let Some(read) = read {
            self.channel.text.edited = read;
        }
        acted
    }

    /// Lets the interpreter work. While it does, blocks within its block get another one, if the dialect allows that.
    pub fn with_interpreter<R>(&mut self, work: impl FnOnce(&mut dyn Interpreter, &mut Self) -> R) -> Option<R> {
        let Some(mut interpreter) = self.dialect.interpreter.take() else {
            let mut nested = self.dialect.kind.nested()?;
            return Some(work(&mut *nested, self));
        };
        let done = work(&mut *interpreter, self);
        if std::mem::take(&mut self.dialect.is_stale) {
            interpreter.forget_lines();
        }
        self.dialect.interpreter = Some(interpreter);
        Some(done)
    }

    /// A word jumps within the program.
    pub(crate) fn interpreter_jump(&mut self, target: BlockStart) {
        if !self.flow.loops.is_empty() {
            self.with_interpreter(|interpreter, kernel| interpreter.on_jump(kernel, target));
        }
    }

    /// Tells the interpreter that a program starts.
    pub fn interpreter_start(&mut self) {
        if self.dialect.interpreter.is_some() {
            self.with_interpreter(|interpreter, kernel| interpreter.on_start(kernel));
        }
    }

    /// Tells the interpreter that a subprogram starts.
    #[inline]
    pub fn interpreter_call(&mut self) {
        if self.dialect.interpreter.is_some() {
            self.with_interpreter(|interpreter, kernel| interpreter.on_call(kernel));
        }
    }

    /// Tells the interpreter that a subprogram has returned.
    #[inline]
    pub fn interpreter_return(&mut self) {
        if self.dialect.interpreter.is_some() {
            self.with_interpreter(|interpreter, kernel| interpreter.on_return(kernel));
        }
    }

    /// Calls a text that the interpreter has found, or that a startup macro may find.
    pub(crate) fn call_text(&mut self, call: SubprogramCall) -> Acted {
        let SubprogramCall { name, place, passes, closes } = call;
        self.check_nesting(|| name.to_string())?;
        let called = call_record(self.plan, &self.channel, Callee::Named(Arc::clone(&name)), passes);
        let mut found = place;
        if let Some(hooks) = self.plan.hooks {
            match (hooks.program.call)(self, &called, found)? {
                None => return Ok(()),
                Some(place) => found = place,
            }
        }
        let Some((file, range)) = found else {
            let text = format!("subprogram {name} not found, called in '{}'", self.channel.block_text());
            return self.program_missing(text);
        };
        if !self.channel.env.info.is_resident(file) {
            self.check_levels(false, &called.what)?;
        }
        if self.cycle_at_once((file, range), &called, &name)? {
            return Ok(());
        }
        let repeats = passes.saturating_sub(1);
        self.enter(RunningProgram { repeats, closes, called, ..RunningProgram::main(file, range, (*name).into()) });
        Ok(())
    }
}

/// Marks data that the interpreter has read of programs as invalid.
pub fn forget_lines(dialect: &mut DialectState) {
    match dialect.interpreter.as_deref_mut() {
        Some(interpreter) => interpreter.forget_lines(),
        None => dialect.is_stale = true,
    }
}

#[inline]
pub(crate) fn interpreter_repeat(dialect: &mut DialectState) {
    if let Some(interpreter) = dialect.interpreter.as_deref_mut() {
        interpreter.on_repeat();
    }
}

/// Executes the words that an interpreter left of a block, part by part while the interpreter continues the block.
fn parts(kernel: &mut Kernel<'_>, first: Remaining, text: &[u8]) -> Acted {
    let mut remaining = first;
    loop {
        let continues = std::mem::take(&mut kernel.dialect.left.continues);
        kernel.remains(remaining, text)?;
        if !continues {
            return Ok(());
        }
        kernel.channel.block.clear();
        let next = kernel.with_interpreter(|interpreter, kernel| {
            kernel.dialect.left.clear(kernel.asks_left_text());
            interpreter.rest(kernel)
        });
        match next {
            Some(next) => remaining = next?,
            None => return Ok(()),
        }
    }
}

/// Executes several blocks, one after another.
#[inline(never)]
fn blocks(kernel: &mut Kernel<'_>, whole: &[u8]) -> Acted {
    kernel.dialect.left.end_block(&mut kernel.channel.block);
    // Blocks within a block may leave others.
    let blocks = std::mem::take(&mut kernel.dialect.left.blocks);
    let acted = (0..blocks.len()).try_for_each(|at| {
        blocks.fill(at, &mut kernel.channel.block, &mut kernel.dialect.left.text);
        remaining_block(kernel, whole)
    });
    kernel.dialect.left.blocks = blocks.emptied();
    acted
}

fn remaining_block(kernel: &mut Kernel<'_>, whole: &[u8]) -> Acted {
    let left = &kernel.dialect.left.text;
    if kernel.channel.env.trace.is_some() && !left.is_empty() && left.trim().as_bytes() != whole.trim_ascii() {
        let left = left.clone();
        trace_left(&mut kernel.channel, &left);
    }
    kernel.made_words()
}
