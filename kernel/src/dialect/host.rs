//! What a pre-processor is to its kernel, and its kernel to it.
//!
//! Facts: reference control-emulator.md 4.3 (identification), 5.4, 5.7. Invariants: what other channels can see goes
//! through [`Host::shared`] and [`Host::set_shared`], in order of simulated time; a jump back and a call are counted by
//! the kernel, so that endless loops come to a limit; nothing here reads a clock or a file system.

use counterpoint_fault::{Acted, Halt};
use std::sync::Arc;

use counterpoint_lang::value::Value;

use crate::diag::Facts;
use crate::log::event::FileId;
use crate::machine::ident::CodeId;
use crate::mcd::program::Range;
use crate::mcd::source::Source;

/// The pre-processor of one kernel, with its variables.
pub(crate) trait Interpreter: Send {
    /// Carries out a block that is not plain words: the text of the words that are left of it, none behind a statement;
    /// several blocks stand in lines of their own.
    /// The words act when the interpreter has done its part, so nothing of it runs while a block of its own is worked.
    ///
    /// # Errors
    /// What stops the channel; mistakes of the program are alarms by [`Host::alarm`].
    fn block(&mut self, host: &mut dyn Host, text: &[u8]) -> Result<Option<String>, Halt>;

    /// The program begins again with another file, as if it were the first one or not (reference control-emulator.md
    /// 5.8).
    fn begin(&mut self, reset: bool);

    /// The main program is about to run; its file is loaded.
    fn started(&mut self, _host: &mut dyn Host) {}

    /// A subprogram begins: one that [`Host::call`] asked for, or another that words called.
    fn entered(&mut self, host: &mut dyn Host);

    /// A further pass of the subprogram begins.
    fn again(&mut self) {}

    /// A subprogram has returned.
    fn left(&mut self, host: &mut dyn Host);

    /// A block has moved, and modal calls are on ([`Host::calls_modally`]).
    fn moved(&mut self, _host: &mut dyn Host) {}

    /// `$FCEGNCV`: value of a variable in native spelling; none if it does not exist or has no value.
    ///
    /// # Errors
    /// The job was stopped.
    fn variable(&mut self, host: &mut dyn Host, name: &str, indices: &[f64]) -> Result<Option<Value>, Halt>;

    /// `$FCESNCV`: sets a variable that exists; whether it was set.
    ///
    /// # Errors
    /// The job was stopped.
    fn set_variable(&mut self, host: &mut dyn Host, name: &str, indices: &[f64], value: &Value) -> Result<bool, Halt>;

    /// `$FCEPP`: a setting by its name, words joined by commas as in `PROCESS,SUBPROGRAMS`, with the values behind it.
    fn setting(&mut self, name: &str, values: &[Value]) -> Setting;

    /// Bytes that its variables and what it remembers of programs take, about.
    fn memory(&self) -> u64 {
        0
    }
}

/// What became of a setting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Setting {
    /// It holds from now on.
    Made,
    /// The value is none that it can have.
    Wrong,
    /// This pre-processor has no such setting.
    Unknown,
}

/// Where a kernel stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Place {
    /// File of the block.
    pub(crate) file: FileId,
    /// Its line, from 1.
    pub(crate) line: u32,
    /// Lines of the program, or of the called text, that the block belongs to.
    pub(crate) range: Range,
    /// Subprograms that are running.
    pub(crate) level: usize,
    /// The text of the block is its line of the file, and was not changed: what was compiled for the line holds.
    pub(crate) as_read: bool,
}

/// A subprogram that the pre-processor calls.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Call {
    /// Name for events, messages and the subprogram macros.
    pub(crate) name: Arc<str>,
    /// Where it is; a startup macro of the machine may know what the pre-processor does not.
    pub(crate) place: Option<(FileId, Range)>,
    /// Passes, at least 1.
    pub(crate) passes: u32,
    /// The end of its text is its return, without a return code.
    pub(crate) closes: bool,
}

/// What the identification macro says of a variable, function or text that nobody knows.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Answer {
    /// There is no macro, or it leaves the matter to the control, which diagnoses it.
    Unknown,
    /// Nothing is to happen and nothing to be said; inside an expression the value is 0.
    Drop,
    /// This text is to be evaluated instead.
    Instead(String),
    /// The text stays on the block as it is.
    Keep,
}

/// An axis of the channel.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct AxisPlace {
    /// Name on the machine.
    pub(crate) name: String,
    /// Name in the programs of the channel.
    pub(crate) letter: String,
    /// Programmed as a diameter.
    pub(crate) diameter: bool,
    /// Where it is in the frame of the program, as the program counts now.
    pub(crate) work: f64,
    /// What incremental words count from: where it is, or where it was before a change of frames that is to be travelled.
    pub(crate) from: f64,
    /// Where it is in the machine frame, as the program counts now.
    pub(crate) machine: f64,
}

/// The active codes of all groups.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Modes(pub(crate) Vec<(u16, CodeId, u16)>);

/// What an interpreter can ask of its kernel.
pub(crate) trait Host {
    /// Where the kernel stands.
    fn place(&self) -> Place;

    /// Text of a file that is loaded, as the file of the block is.
    fn source(&self, file: FileId) -> Option<Arc<Source>>;

    /// Names of the files of the job and of those stored with the machine (`//ICAMFS/…`), in order of their ids.
    fn files(&self) -> Vec<String>;

    /// Loads a file.
    ///
    /// # Errors
    /// It cannot be read: an alarm.
    fn load(&mut self, file: FileId) -> Acted;

    /// File of the main program.
    fn main_file(&self) -> FileId;

    /// Counts work on so many elements within a block.
    ///
    /// # Errors
    /// The job is to end, or a limit is reached.
    fn work(&mut self, elements: usize) -> Acted;

    /// Whether blocks behind an optional-skip mark of this level are skipped; `None` for a mark without number.
    fn skips(&self, level: Option<u8>) -> bool;

    /// The block goes on at a line of its program.
    ///
    /// # Errors
    /// A loop that nothing can end any more.
    fn go_to(&mut self, line: u32) -> Acted;

    /// Calls a subprogram at the end of the block.
    fn call(&mut self, call: Call);

    /// Behind every block that moves, [`Interpreter::moved`] is asked for a call.
    fn calls_modally(&mut self, on: bool);

    /// Returns from the subprogram at the end of the block, or ends the main program.
    fn give_back(&mut self);

    /// A message to the operator.
    fn show(&mut self, text: &str);

    /// The kernel itself has seen to a message of this block.
    fn tells_messages(&self, text: &[u8]) -> bool;

    /// Something about the block is worth saying.
    fn diagnose(&mut self, facts: &'static Facts, text: String);

    /// What stops the channel.
    fn alarm(&mut self, facts: &'static Facts, text: String) -> Halt;

    /// Text of the block for messages.
    fn block_text(&self) -> String;

    /// A variable that all channels share, if it has a value.
    ///
    /// # Errors
    /// The job was stopped.
    fn shared(&mut self, name: &str) -> Result<Option<Value>, Halt>;

    /// Sets a variable that all channels share; none takes its value away.
    ///
    /// # Errors
    /// The job was stopped.
    fn set_shared(&mut self, name: &str, value: Option<Value>) -> Acted;

    /// The machine gives common variables to each channel instead of sharing them.
    fn has_own_common(&self) -> bool;

    /// A variable of this channel has changed, or something else that the next pass of a loop could see.
    fn effect(&mut self);

    /// Asks the identification macro about a text, with the value that is being assigned to it.
    ///
    /// # Errors
    /// The macro stopped the channel.
    fn identify(&mut self, text: &str, assigned: Option<&Value>) -> Result<Answer, Halt>;

    /// Words may begin with this text: a register of the machine has the name.
    fn is_register(&self, name: &str) -> bool;

    /// The word of a register with a value: as it is spelled, else so that the register reads this value, rounded to its
    /// digits. None if no register has the name, with or without `=` at its end.
    fn word(&self, name: &str, value: f64, spelled: Option<&str>) -> Option<String>;

    /// Lengths are in inches.
    fn is_inch(&self) -> bool;

    /// A literal text of the machine's code table, letter case ignored.
    fn is_code_text(&self, text: &str) -> bool;

    /// The machine has a code for the word of a letter with this value.
    fn knows_code(&self, letter: u8, value: f64) -> bool;

    /// Positions of the channel's axes by name: in the work frame as programmed, in the machine frame.
    fn positions(&self) -> Vec<(String, f64, f64)>;

    /// Units of positions in one unit of the program's lengths.
    fn length_factor(&self) -> f64;

    /// Simulated time, ns.
    fn clock(&self) -> i64;

    /// Channel number.
    fn channel(&self) -> u16;

    /// Plain words are for the interpreter too, or no longer.
    fn watch(&mut self, on: bool);

    /// Axes of the channel, in its order.
    fn axes(&self) -> Vec<AxisPlace>;

    /// Positions count from where the axes stand.
    fn relative(&self) -> bool;

    /// Moves are rapid or straight unless a block says otherwise.
    fn moves_straight(&self) -> bool;

    /// Name of the incremental form of a register.
    fn second(&self, register: &str) -> Option<String>;

    /// From the program to the work frame: three rows of a linear part and a shift, in the order X, Y, Z; shifts as the
    /// program counts now.
    fn local_frame(&self) -> [f64; 12];

    /// Number of the work offset in force, 0 for none.
    fn work_offset(&self) -> u32;

    /// Values of a work offset by axis, as the program counts now; 0 is the base.
    fn offset(&self, number: u32) -> Vec<f64>;

    /// Sets a work offset, which acts at once; whether it was set.
    fn set_offset(&mut self, number: u32, values: &[f64]) -> bool;

    /// Number of the tool that is loaded.
    fn tool(&self) -> u32;

    /// The active codes, to be restored later.
    fn modes(&self) -> Modes;

    /// Makes such codes active again.
    fn restore_modes(&mut self, modes: &Modes);

    /// Something is worth saying with a severity of its own.
    fn report(&mut self, facts: &'static Facts, severity: u8, text: String);
}
