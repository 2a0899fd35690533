//! The interface of an interpreter to its kernel.
//!
//! *Invariant:* an interpreter keeps the data that belong to its control alone; the kernel knows nothing of them.

use counterpoint_event::FileId;
use counterpoint_fault::Halt;
use counterpoint_lang::value::MacroValue;
use counterpoint_machine::index::{CodeRowId, RegisterId};
use counterpoint_program::key_words::WrittenNumber;

use super::host::{InterpreterHost, MadeWord};
use counterpoint_program::shape::ProgramRange;
use counterpoint_program::spot::BlockStart;

/// The interpreter of one kernel, with its variables.
pub trait Interpreter: Send {
    /// Executes a block that is more than plain words. The remaining words act after the interpreter has done its part,
    /// so the interpreter never runs while a block of its own acts.
    ///
    /// # Errors
    /// Faults that stop the channel; mistakes of the program are alarms by [`super::host::ReportHost::alarm`].
    fn block(&mut self, host: &mut dyn InterpreterHost, text: &[u8]) -> Result<Remaining, Halt>;

    /// Continues the block whose first words have acted, after [`super::host::FlowHost::continue_block`].
    ///
    /// # Errors
    /// As those of [`block`](Self::block).
    fn rest(&mut self, _host: &mut dyn InterpreterHost) -> Result<Remaining, Halt> {
        Ok(Remaining::Nothing)
    }

    /// Reads the words of the block as the arguments of a macro call; `own` is the word (register and value) that calls
    /// by itself. None if the block has no words.
    ///
    /// # Errors
    /// The reason why the channel stops.
    fn arguments(
        &mut self,
        _host: &mut dyn InterpreterHost,
        _text: &[u8],
        _own: Option<(RegisterId, f64)>,
    ) -> Result<Option<MacroArguments>, Halt> {
        Ok(None)
    }

    /// Whether the interpreter also processes plain words of the program that starts.
    fn watches(&self) -> bool {
        false
    }

    /// The program starts again with another file, with or without a reset (reference control-emulator.md 5.8).
    fn restart(&mut self, reset: bool);

    /// The main program is about to run; its file is loaded.
    fn on_start(&mut self, _host: &mut dyn InterpreterHost) {}

    /// Makes the blocks of a resident program that is a cycle of the control, which a block calls by
    /// [`super::host::FlowHost::call`]; false: the program is an ordinary one, whose blocks run.
    ///
    /// # Errors
    /// The reason why the channel stops: an argument of the cycle is wrong.
    fn cycle(
        &mut self,
        _: &mut dyn InterpreterHost,
        _: (FileId, ProgramRange),
        _: &mut MadeBlocks,
    ) -> Result<bool, Halt> {
        Ok(false)
    }

    /// A subprogram begins: one that [`super::host::FlowHost::call`] asked for, or another that words called.
    fn on_call(&mut self, _host: &mut dyn InterpreterHost) {}

    /// A further pass of the subprogram begins.
    fn on_repeat(&mut self) {}

    /// A subprogram has returned.
    fn on_return(&mut self, _host: &mut dyn InterpreterHost) {}

    /// A block has moved, and modal calls are on ([`super::host::FlowHost::calls_modally`]).
    fn on_move(&mut self, _host: &mut dyn InterpreterHost) {}

    /// Called when the program ends with its end code while modal calls are active.
    fn on_end(&mut self, _host: &mut dyn InterpreterHost) {}

    /// A word of the machine jumps within the program while the program is in loops.
    fn on_jump(&mut self, _host: &mut dyn InterpreterHost, _target: BlockStart) {}

    /// Discards the lines read so far, because lines or levels of optional skip have changed.
    fn forget_lines(&mut self) {}

    /// `$FCEGNCV`: value of a variable in native spelling; none if it does not exist or has no value.
    ///
    /// # Errors
    /// The job was stopped.
    fn variable(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
        indices: &[f64],
    ) -> Result<Option<MacroValue>, Halt>;

    /// `$FCESNCV`: sets a variable that exists; whether it was set.
    ///
    /// # Errors
    /// The job was stopped.
    fn set_variable(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
        indices: &[f64],
        value: &MacroValue,
    ) -> Result<bool, Halt>;

    /// `$FCEPP`: a setting by its name, words joined by commas as in `PROCESS,SUBPROGRAMS`, with its values.
    fn setting(&mut self, host: &mut dyn InterpreterHost, name: &str, values: &[MacroValue]) -> SettingOutcome;

    /// Whether the line of the file is known as a statement: its text need not be split to find that out.
    ///
    /// *Invariant:* the scanner takes the text of such a line for a statement, too.
    fn executes(&mut self, _: (FileId, u32)) -> bool {
        false
    }

    /// Executes a line that it is known to execute ([`executes`](Self::executes)) without its text; none: it needs the
    /// text.
    ///
    /// # Errors
    /// As those of [`block`](Self::block).
    fn known_block(&mut self, _: &mut dyn InterpreterHost, _: (FileId, u32)) -> Option<Result<Remaining, Halt>> {
        None
    }

    /// Whether a block shows or hides, for an operator who steps, the blocks from it to the return of its program; none
    /// if the block does neither.
    fn shows_blocks(&self, _: &[u8]) -> Option<bool> {
        None
    }

    /// Approximate bytes of its variables and of its memory of programs.
    fn memory(&self) -> u64 {
        0
    }

    /// Bytes that compiled lines and tables take, about, if they are counted apart.
    fn tables(&self) -> u64 {
        0
    }
}

/// Blocks of words that a cycle of the control makes, one after another.
///
/// *Invariant:* `ends` rises, and its last element is the number of words when all blocks are complete.
#[derive(Debug, Default)]
pub struct MadeBlocks {
    words: Vec<CycleWord>,
    /// Where each block ends among the words.
    ends: Vec<usize>,
    /// Codes that were active before the cycle are active after it.
    pub restores_codes: bool,
}

/// A word of a block that a cycle makes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CycleWord {
    /// A register with a value.
    Register(MadeWord),
    /// A literal text, by its row in the code table.
    Text(CodeRowId),
}

impl MadeBlocks {
    /// Forgets all blocks.
    pub fn clear(&mut self) {
        self.words.clear();
        self.ends.clear();
        self.restores_codes = false;
    }

    /// Adds a word to the block that is being made.
    pub fn push(&mut self, word: MadeWord) {
        self.words.push(CycleWord::Register(word));
    }

    /// Adds a literal text of the machine.
    pub fn push_text(&mut self, row: CodeRowId) {
        self.words.push(CycleWord::Text(row));
    }

    /// Ends the block.
    pub fn end(&mut self) {
        self.ends.push(self.words.len());
    }

    /// The words of each block.
    pub fn iter(&self) -> impl Iterator<Item = &[CycleWord]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, &end)| self.words.get(start..end).unwrap_or_default())
    }
}

/// The rest of a block after its interpreter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Remaining {
    /// Nothing.
    Nothing,
    /// The words that the interpreter has put in the block, or in several blocks
    /// ([`super::host::WordHost::end_block`]).
    Words,
}

/// Outcome of a setting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SettingOutcome {
    /// It holds from now on.
    Made,
    /// It cannot have the value.
    Wrong,
    /// It is true or false.
    NotLogical,
    /// This interpreter has no such setting.
    Unknown,
}

/// How a G word of the control calls a macro by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MacroCall {
    /// Once.
    Once,
    /// After blocks that move.
    AfterMoves,
    /// With the words of every block.
    EachBlock,
    /// Ends modal calls.
    End,
}

/// The words of a macro call.
#[derive(Debug, Default)]
pub struct MacroArguments {
    /// Number of the program.
    pub program: Option<f64>,
    /// Number of the program as written; none if it is computed.
    pub program_number: Option<(RegisterId, WrittenNumber)>,
    /// Passes.
    pub count: Option<f64>,
    /// Passes as written; none if they are computed.
    pub count_number: Option<(RegisterId, WrittenNumber)>,
    /// How the block calls, if one of its words says so.
    pub call: Option<MacroCall>,
    /// Values by number of the local variable.
    pub values: Vec<(u8, f64)>,
}
