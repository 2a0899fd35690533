//! Siemens 840D.
//!
//! Facts: reference control-emulator.md 5.4, functions.md 9. A block is read once (`line`, kept by file and line) and
//! executed item by item (`run`): statements act at once, words are gathered as text. Invariants: a mistake of the
//! program is an alarm with a text and never goes unreported; text that is not a statement, variable or subprogram
//! remains for the tables of the machine.

mod actions;
mod aims;
mod along;
mod archive;
mod beside;
mod beside_words;
mod block_text;
mod branches;
mod calls;
mod compiled;
mod contours;
mod control;
mod conversions;
mod coordination;
mod coupled_spindles;
mod cursor;
mod declaration;
mod declare;
mod define;
mod defines;
mod drilling;
mod evaluate;
mod expression;
mod files;
mod fixed_stop;
mod frame;
mod frame_component;
mod frames;
mod functions;
mod groups;
mod held;
mod item;
mod jumps;
mod left;
mod line;
mod meanings;
mod messages;
mod modal;
mod moves;
mod number_text;
mod orientation;
mod outline;
mod own_block;
mod places;
mod positioning;
mod preparation;
mod records;
mod run;
mod settings;
mod single_block;
mod spindles;
mod statement;
mod stored;
mod system;
#[cfg(test)]
mod tests;
mod texts;
mod tools;
mod unknown_names;
mod value;
mod variable_store;
mod variables;
mod words;

use counterpoint_fault::Halt;

use counterpoint_lang::value::MacroValue;
use rustc_hash::FxHashMap;

use counterpoint_control_api::host::InterpreterHost;
use counterpoint_control_api::interpreter::{Interpreter, MadeBlocks, Remaining, SettingOutcome};
use counterpoint_event::FileId;
use counterpoint_fault as diag;
use counterpoint_fault::DiagnosticFacts;
use counterpoint_program::kept::{LineCache, TableCache};
use counterpoint_program::shape::ProgramRange;

pub use control::SiemensDialect;

/// Why executing a block failed.
#[derive(Debug)]
enum SiemensBlockError {
    /// The channel stops.
    Halt(Halt),
    /// An alarm that is still to be reported.
    Alarm(&'static DiagnosticFacts, String),
}

impl From<Halt> for SiemensBlockError {
    fn from(halt: Halt) -> Self {
        Self::Halt(halt)
    }
}

type Outcome<T> = Result<T, SiemensBlockError>;

/// A mistake in the text of a block.
fn syntax<T>(text: impl Into<String>) -> Outcome<T> {
    Err(SiemensBlockError::Alarm(&diag::MACRO_SYNTAX, text.into()))
}

/// A value of the wrong type or beyond its type.
fn wrong_type<T>(text: impl Into<String>) -> Outcome<T> {
    Err(SiemensBlockError::Alarm(&diag::SIEMENS_TYPE, text.into()))
}

/// Number and title of the control's alarm, where the text does not tell it already.
fn number_of(facts: &DiagnosticFacts, text: &str) -> &'static str {
    if text.contains("(alarm ") {
        return "";
    }
    match facts.number {
        number if number == diag::MACRO_SYNTAX.number => "12080 syntax error: ",
        number if number == diag::MACRO_VARIABLE.number && text.ends_with(" does not exist") => {
            "12550 name not defined: "
        }
        _ => "",
    }
}

/// The pre-processor with its variables.
#[derive(Debug, Default)]
pub(crate) struct Siemens {
    variables: variable_store::SiemensVariableStore,
    /// System variables that keep the written values.
    stored: stored::StoredVariables,
    /// Frames that the program has assigned.
    frames: frames::AssignedFrames,
    /// DEFINE: texts for names.
    defines: defines::Defines,
    /// Blocks that were read.
    read: LineCache<Result<item::SiemensLine, String>>,
    /// Labels and loops of files.
    places: TableCache<FileId, jumps::SiemensFileIndex>,
    /// Where subprograms are, by calling file and name.
    found: FxHashMap<(FileId, String), Option<(FileId, ProgramRange)>>,
    /// Words of the machine.
    known: words::MachineWords,
    /// Subprogram that the block calls.
    calling: Option<calls::Calling>,
    /// Subprogram that blocks with motion call.
    modal: Option<modal::SiemensModalCall>,
    /// Subprograms that were running where it was called; it runs, or has run.
    modal_from: Option<usize>,
    settings: settings::SiemensSettings,
    /// State that statements keep for later blocks.
    held: held::StatementState,
    /// The reason why the channel stopped where nothing could be returned.
    halted: Option<Halt>,
    /// Whether macros are not asked about unknown names.
    quiet: bool,
}

/// Whether a block is anything but plain words: a name, a call by L, M17, or a sign that plain words do not have.
fn needs_interpreter(text: &[u8]) -> bool {
    let mut before = b' ';
    for (at, &byte) in text.iter().enumerate() {
        match byte {
            b';' => return false,
            b'=' | b'(' | b'[' | b'"' | b'\'' | b'$' | b':' | b'_' | b'<' | b'>' | b'%' => return true,
            b'L' | b'l' if text.get(at + 1).is_some_and(u8::is_ascii_digit) => return true,
            b'G' | b'g' if meanings::is_rewritten(text.get(at + 1..).unwrap_or_default()) => return true,
            b'M' | b'm' if returns(text.get(at + 1..).unwrap_or_default()) => return true,
            _ if byte.is_ascii_alphabetic() && before.is_ascii_alphabetic() => return true,
            _ => {}
        }
        before = byte;
    }
    false
}

/// Behind an M: 17.
fn returns(text: &[u8]) -> bool {
    let zeros = text.iter().take_while(|byte| **byte == b'0').count();
    let digits = text.get(zeros..).unwrap_or_default();
    digits.starts_with(b"17") && !digits.get(2).is_some_and(|byte| byte.is_ascii_digit() || *byte == b'.')
}

impl Siemens {
    /// A fault becomes an alarm.
    fn reported<T>(&self, host: &mut dyn InterpreterHost, outcome: Outcome<T>) -> Result<T, Halt> {
        match outcome {
            Ok(done) => Ok(done),
            Err(SiemensBlockError::Halt(halt)) => Err(halt),
            Err(SiemensBlockError::Alarm(facts, text)) => {
                let text = format!("{}{text} in '{}'", number_of(facts, &text), host.block_text());
                Err(host.alarm(facts, text))
            }
        }
    }

    /// Executes work without asking macros; none if that is not possible.
    fn quietly<T>(&mut self, work: impl FnOnce(&mut Self) -> Outcome<T>) -> Result<Option<T>, Halt> {
        let before = std::mem::replace(&mut self.quiet, true);
        let done = work(self);
        self.quiet = before;
        match done {
            Ok(done) => Ok(Some(done)),
            Err(SiemensBlockError::Halt(halt)) => Err(halt),
            Err(SiemensBlockError::Alarm(..)) => Ok(None),
        }
    }

    /// Sends all blocks to the pre-processor while a name may stand for something else, motion may call, an action
    /// waits or the tool turns along the path.
    fn watch(&self, host: &mut dyn InterpreterHost) {
        host.watch(self.must_watch());
    }

    fn must_watch(&self) -> bool {
        let held = &self.held;
        let waits = self.modal.is_some() || !held.actions.is_empty() || held.turning.acts() || self.frames.wait();
        !self.defines.is_empty() || waits
    }
}

impl Interpreter for Siemens {
    fn block(&mut self, host: &mut dyn InterpreterHost, text: &[u8]) -> Result<Remaining, Halt> {
        if let Some(halt) = self.halted.take() {
            return Err(halt);
        }
        self.calling = None;
        if let Some(line) = self.read_before(host).filter(|_| self.settings.definitions.is_empty())
            && let Ok(line) = &*line
        {
            let outcome = self.run(host, line, text);
            return self.reported(host, outcome);
        }
        let outcome = match self.definition_files(host) {
            Ok(()) => match std::str::from_utf8(text) {
                Ok(whole) => self.carry_out(host, whole, text),
                Err(_) => self.carry_out(host, &String::from_utf8_lossy(text), &[]),
            },
            Err(fault) => Err(fault),
        };
        self.reported(host, outcome)
    }

    fn restart(&mut self, reset: bool) {
        let before = std::mem::take(self);
        if !reset {
            self.variables = before.variables.for_next_program();
            self.stored = before.stored;
            self.defines = before.defines;
            self.settings = before.settings;
            self.frames.keep(before.frames);
            self.held.actions = before.held.actions.into_iter().filter(actions::ArmedAction::stays).collect();
        }
    }

    fn watches(&self) -> bool {
        self.must_watch()
    }

    fn cycle(
        &mut self,
        host: &mut dyn InterpreterHost,
        program: (FileId, ProgramRange),
        blocks: &mut MadeBlocks,
    ) -> Result<bool, Halt> {
        let outcome = self.hole(host, program, blocks);
        self.reported(host, outcome)
    }

    fn on_call(&mut self, host: &mut dyn InterpreterHost) {
        self.enter(host);
    }

    fn on_repeat(&mut self) {
        self.variables.again();
    }

    fn on_return(&mut self, host: &mut dyn InterpreterHost) {
        let outcome = self.leave(host);
        if let Err(halt) = self.reported(host, outcome) {
            self.halted = Some(halt);
        }
    }

    fn variable(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
        indices: &[f64],
    ) -> Result<Option<MacroValue>, Halt> {
        let outcome = self.definition_files(host);
        self.reported(host, outcome)?;
        let Some(name) = settings::named(name, indices) else { return Ok(None) };
        let read = self.quietly(|this| this.read_for_macro(host, &name))?;
        Ok(read.flatten().map(|data| data.value()))
    }

    fn set_variable(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
        indices: &[f64],
        value: &MacroValue,
    ) -> Result<bool, Halt> {
        let outcome = self.definition_files(host);
        self.reported(host, outcome)?;
        let Some(name) = settings::named(name, indices) else { return Ok(false) };
        let set = self.quietly(|this| this.set_for_macro(host, &name, value))?;
        Ok(set.unwrap_or(false))
    }

    fn setting(&mut self, _: &mut dyn InterpreterHost, name: &str, values: &[MacroValue]) -> SettingOutcome {
        self.settings.set(name, values)
    }

    #[inline]
    fn executes(&mut self, line: (FileId, u32)) -> bool {
        let line = self.read.get(line).map(|line| line.as_ref().as_ref());
        line.is_some_and(|line| line.is_ok_and(|line| line.is_statement))
    }

    fn shows_blocks(&self, text: &[u8]) -> Option<bool> {
        single_block::shows_blocks(text)
    }

    fn memory(&self) -> u64 {
        let names = self.held.externals.len() + self.found.len() + self.stored.len() + self.known.spellings.len();
        (self.variables.bytes() + names * 100 + self.defines.bytes() + self.places.bytes() + self.read.bytes()) as u64
    }
}
