//! RS274/NGC: LinuxCNC, grblHAL, and GRBL, which has only the words of the language.
//!
//! Facts: LinuxCNC documentation (G code chapters), Grbl 1.1 README and list of errors. A block is read once (`line`,
//! kept by file and line). Its values are evaluated, and then its assignments take effect. Then it is checked as a
//! whole (`block`), and its parts act in the documented order (`run`). *Invariants:* the interpreter gets every block
//! and knows the active motion; text that is not part of the language is an alarm and never goes unreported.

mod block;
mod codes;
mod comments;
mod control;
mod cycles;
mod evaluate;
mod expr;
mod flow;
mod line;
mod motion;
mod nurbs;
mod offsets;
mod outline;
mod parameters;
mod places;
mod polar;
mod run;
mod system;
mod text;
mod threading;

use std::collections::VecDeque;
use std::sync::Arc;

use counterpoint_event::FileId;
use counterpoint_fault::Halt;
use counterpoint_lang::value::MacroValue;
use counterpoint_program::kept::{LineCache, TableCache};

pub use control::{GRBL, GRBL_HAL, LINUX_CNC, Rs274Dialect};

use block::BlockWords;
use counterpoint_control_api::host::InterpreterHost;
use counterpoint_control_api::interpreter::{Interpreter, Remaining, SettingOutcome};
use line::Rs274Line;
use run::BlockPart;
use text::Rs274Mistake;

/// Why executing a block failed.
#[derive(Debug)]
enum Rs274Stop {
    /// The channel stops.
    Halt(Halt),
    /// An alarm that has not been reported yet.
    Alarm(Rs274Mistake),
}

impl From<Halt> for Rs274Stop {
    fn from(halt: Halt) -> Self {
        Self::Halt(halt)
    }
}

impl From<Rs274Mistake> for Rs274Stop {
    fn from(mistake: Rs274Mistake) -> Self {
        Self::Alarm(mistake)
    }
}

type Outcome<T> = Result<T, Rs274Stop>;

/// Modes that the interpreter keeps itself.
#[derive(Debug, Clone, Default)]
struct Rs274Modes {
    /// The active motion, in tenths.
    motion: u16,
    /// Arc centres are absolute positions (G90.1).
    absolute_centers: bool,
    /// The tool that the last T word has selected.
    selected: Option<u32>,
    /// Words of the active cycle.
    cycle: cycles::StickyWords,
    /// Control points since G5.2.
    nurbs: nurbs::Nurbs,
}

/// A block whose first parts have acted.
#[derive(Debug, Default)]
struct PendingBlock {
    words: BlockWords,
    parts: VecDeque<BlockPart>,
}

/// The interpreter.
#[derive(Debug)]
pub struct Rs274 {
    kind: codes::Rs274Kind,
    parameters: parameters::Rs274Parameters,
    offsets: offsets::Rs274Offsets,
    modes: Rs274Modes,
    saved: Vec<run::SavedModes>,
    files: comments::CommentFiles,
    read: LineCache<Result<Rs274Line, Rs274Mistake>>,
    /// A line may run again, so its compiled form is worth keeping.
    caching: bool,
    places: TableCache<FileId, places::OCodeIndex>,
    pending: PendingBlock,
    /// Probing moves touch at their ends.
    touches: bool,
}

impl Rs274 {
    /// Creates the interpreter with the machine's initial values of parameters.
    pub(crate) fn new(kind: codes::Rs274Kind, initial: impl Iterator<Item = (u32, f64)>) -> Self {
        let parameters = parameters::Rs274Parameters::new(initial);
        let mut made = Self {
            kind,
            touches: parameters.number(5070) != 0.0,
            parameters,
            offsets: offsets::Rs274Offsets::default(),
            modes: Rs274Modes::default(),
            saved: Vec::new(),
            files: comments::CommentFiles::default(),
            read: LineCache::default(),
            caching: false,
            places: TableCache::default(),
            pending: PendingBlock::default(),
        };
        made.begin();
        made
    }

    /// Modes at the start of a program.
    fn begin(&mut self) {
        let motion = if self.kind.is_firmware() { 0 } else { codes::NO_MOTION };
        self.modes = Rs274Modes { motion, ..Rs274Modes::default() };
        self.saved.clear();
        self.pending = PendingBlock::default();
    }

    /// Reads a block of a file.
    fn line_of(&mut self, host: &dyn InterpreterHost, file: FileId, line: u32) -> Arc<Result<Rs274Line, Rs274Mistake>> {
        let source = host.source(file);
        let text = source.as_ref().map(|source| source.line(line)).unwrap_or_default();
        self.read_line((file, line), text, true)
    }

    /// Reads a block; keeps the result if the text is that of the file.
    fn read_line(&mut self, key: (FileId, u32), text: &[u8], as_read: bool) -> Arc<Result<Rs274Line, Rs274Mistake>> {
        if let Some(line) = self.read.get(key).filter(|_| as_read) {
            return Arc::clone(line);
        }
        let line = Arc::new(line::read(text, self.kind.has_language()));
        if as_read && self.caching {
            self.read.insert(key, &line, text.len());
        }
        line
    }

    /// Reports a mistake as an alarm.
    fn reported<T>(&mut self, host: &mut dyn InterpreterHost, outcome: Outcome<T>) -> Result<T, Halt> {
        match outcome {
            Ok(done) => Ok(done),
            Err(Rs274Stop::Halt(halt)) => Err(halt),
            Err(Rs274Stop::Alarm(mistake)) => {
                self.pending.parts.clear();
                let error = if self.kind.is_firmware() { format!("error:{} ", mistake.error) } else { String::new() };
                let (block, text) = (host.block_text(), &*mistake.text);
                let text = match text.rsplit_once(": ").filter(|_| !text.starts_with("column")) {
                    Some((what, remedy)) => format!("{error}{what} in '{block}': {remedy}"),
                    None => format!("{error}{text} in '{block}'"),
                };
                Err(host.alarm(mistake.facts, text))
            }
        }
    }
}

impl Interpreter for Rs274 {
    fn block(&mut self, host: &mut dyn InterpreterHost, text: &[u8]) -> Result<Remaining, Halt> {
        let done = self.carry_out(host, text);
        self.reported(host, done)
    }

    fn rest(&mut self, host: &mut dyn InterpreterHost) -> Result<Remaining, Halt> {
        let done = self.next_part(host);
        self.reported(host, done)
    }

    fn restart(&mut self, reset: bool) {
        self.parameters.restart();
        self.caching = false;
        if reset {
            self.begin();
        }
    }

    fn on_call(&mut self, _: &mut dyn InterpreterHost) {
        self.parameters.enter();
        self.caching = true;
    }

    fn on_return(&mut self, host: &mut dyn InterpreterHost) {
        self.restore_on_return(host);
        self.parameters.leave();
    }

    fn forget_lines(&mut self) {
        self.read.clear();
    }

    fn variable(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
        indices: &[f64],
    ) -> Result<Option<MacroValue>, Halt> {
        let value = match indices {
            [number] if name.trim() == "#" => expr::number_of(*number).map(|number| self.read_number(host, number)),
            [] => self.read_spelled(host, name),
            _ => None,
        };
        Ok(value.map(MacroValue::Real))
    }

    fn set_variable(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
        indices: &[f64],
        value: &MacroValue,
    ) -> Result<bool, Halt> {
        let Some(value) = value.as_real().filter(|value| value.is_finite()) else { return Ok(false) };
        let text = match indices {
            [number] => format!("{}{number}", name.trim()),
            _ => name.trim().to_owned(),
        };
        Ok(self.set_spelled(host, &text, value))
    }

    fn setting(&mut self, _: &mut dyn InterpreterHost, _: &str, _: &[MacroValue]) -> SettingOutcome {
        SettingOutcome::Unknown
    }

    fn memory(&self) -> u64 {
        (self.parameters.bytes() + self.read.bytes() + self.places.bytes()) as u64
    }
}
