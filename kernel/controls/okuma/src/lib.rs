//! Okuma user task.
//!
//! Facts: reference control-emulator.md 4.3, 5.4, 5.7. A block is made ready (`text`), read (`line`, `expr`) and
//! executed (`run`, `eval`) with the variables of the kernel (`store`); `programs` knows where programs and sequence
//! names are. Invariant: a line that runs again is not read again.

mod control;
mod cursor;
mod drawing;
mod eval;
mod expr;
mod lap;
mod line;
mod loops;
mod math;
mod names;
mod outline;
mod programs;
mod quick_look;
mod run;
mod store;
mod text;
mod unread;

use counterpoint_fault::Halt;
use std::sync::Arc;

use counterpoint_lang::value::MacroValue;
use rustc_hash::FxHashMap;

pub use control::OkumaDialect;

use counterpoint_control_api::host::{InterpreterHost, ProgramHost};
use counterpoint_control_api::interpreter::{Interpreter, Remaining, SettingOutcome};
use counterpoint_control_api::words::span;
use counterpoint_event::FileId;
use counterpoint_fault as diag;
use counterpoint_program::kept::{LineCache, TableCache};
use counterpoint_program::shape::ProgramRange;
use cursor::OkumaCursor;
use expr::{Expr, OkumaExpressionReader, OkumaVariable};
use programs::Index;
use store::Arguments;

/// Most lines of a block.
const CONTINUED: u32 = 100;

/// Most texts of alarms.
const ALARM_TEXTS: usize = 1000;

/// The pre-processor with its variables.
#[derive(Debug)]
pub(crate) struct Okuma {
    store: store::OkumaVariableStore,
    /// Modal calls, the active one last.
    modal: Vec<run::OkumaModalCall>,
    /// Arguments of the call that the block at a place has made.
    arguments: Option<(FileId, u32, Arguments)>,
    /// A line may run again, so its compiled form is worth keeping.
    caching: bool,
    lines: LineCache<line::OkumaLine>,
    indices: TableCache<FileId, Index>,
    /// Texts of the alarms of the user, `VUACM[n]`.
    alarm_texts: FxHashMap<u32, String>,
    names: KnownNames,
    /// Calls are executed; otherwise they stay in the block.
    takes_calls: bool,
    /// Sequence names are removed from the block.
    takes_names: bool,
    /// Messages are removed from the block.
    takes_messages: bool,
    /// Q of a call counts executions, not repeats.
    counts_executions: bool,
    /// G81 to G88 are contours with a name and cycles along them.
    has_contours: bool,
    /// HA to DC without a value are offsets of the tool in the spindle.
    takes_offsets: bool,
    drawing: DrawingStatements,
}

/// Names that blocks have had.
#[derive(Debug, Default)]
struct KnownNames {
    /// Names and whether a register of the machine has them.
    words: FxHashMap<Box<str>, bool>,
    /// Local variables set next to words, and whether their file reads them; the others have been reported.
    read: FxHashMap<(FileId, names::LocalVariableName), bool>,
}

/// Statements for the screen.
#[derive(Debug, Default)]
struct DrawingStatements {
    /// They are ignored.
    ignored: bool,
    /// That has been reported.
    reported: bool,
}

impl Okuma {
    /// With sequence names removed from the block, or left on it for the macros of a machine (`$FCEPP` says otherwise).
    pub(crate) fn new(takes_names: bool) -> Self {
        Self {
            store: store::OkumaVariableStore::default(),
            modal: Vec::new(),
            arguments: None,
            caching: false,
            lines: LineCache::default(),
            indices: TableCache::default(),
            alarm_texts: FxHashMap::default(),
            names: KnownNames::default(),
            takes_calls: true,
            takes_names,
            takes_messages: true,
            counts_executions: false,
            has_contours: false,
            takes_offsets: false,
            drawing: DrawingStatements::default(),
        }
    }
}

impl Okuma {
    /// The content of the block.
    fn line(&mut self, host: &mut dyn InterpreterHost, text: &[u8]) -> Result<Arc<line::OkumaLine>, Halt> {
        let place = host.place();
        let key = (place.file, place.line);
        if place.as_read
            && let Some(line) = self.lines.get(key)
        {
            return Ok(Arc::clone(line));
        }
        let wanted = line::LineReadOptions {
            subprograms: self.takes_calls,
            drawing: self.drawing.ignored,
            offsets: self.takes_offsets,
        };
        let mut block = text::prepare(text);
        let lap = if self.has_contours { lap::find(&mut block) } else { None };
        match line::read(block, wanted) {
            Ok(line) => {
                let marked = line.head.iter().any(|head| matches!(head, line::BlockPrefix::Mark(_)));
                let executes = !marked && quick_look::needs_interpreter(text);
                let alone = self.needs_no_text(host, &line) && lap.is_none();
                let line = Arc::new(line::OkumaLine { lap, executes, alone, ..line });
                if self.caching && place.as_read {
                    self.lines.insert(key, &line, text.len());
                }
                Ok(line)
            }
            Err(mistake) => {
                let text = format!("{mistake} in '{}'", host.block_text());
                Err(host.alarm(&diag::MACRO_SYNTAX, text))
            }
        }
    }

    /// Whether the line is a jump, a loop or values for variables, without words or messages; no line of its file
    /// continues another.
    fn needs_no_text(&mut self, host: &dyn InterpreterHost, line: &line::OkumaLine) -> bool {
        let quiet = line.messages.is_empty() && !line.open && self.takes_names;
        let named = line.head.iter().all(|head| matches!(head, line::BlockPrefix::Name(_)));
        if !quiet || !named || self.index(host, host.place().file).continues {
            return false;
        }
        match &line.statement {
            line::OkumaStatement::Goto(..) | line::OkumaStatement::Loop(..) | line::OkumaStatement::EndLoop(_) => true,
            line::OkumaStatement::Items(items) => items.iter().all(|item| match item {
                line::OkumaItem::Set {
                    name,
                    variable: Some(OkumaVariable::Local(_) | OkumaVariable::Common(..)),
                    ..
                } => !self.is_word(host, name),
                _ => false,
            }),
            _ => false,
        }
    }

    /// The text of a block with the lines that continue it, and the line after them.
    fn continued(&mut self, host: &mut dyn ProgramHost, text: &[u8]) -> Option<(Vec<u8>, u32)> {
        let place = host.place();
        let of_the_file = text.trim_ascii_start().first() == Some(&b'$');
        if !place.as_read || of_the_file || !self.index(host, place.file).continues {
            return None;
        }
        let source = host.source(place.file)?;
        let mut whole = text.to_vec();
        let mut next = place.line + 1;
        while next - place.line < CONTINUED && next <= source.lines() && line::is_continued(source.line(next)) {
            let more = source.line(next).trim_ascii_start();
            whole.push(b' ');
            whole.extend_from_slice(more.get(1..).unwrap_or_default());
            next += 1;
        }
        (next > place.line + 1).then_some((whole, next))
    }

    /// Plain words are also for the pre-processor where lines continue the lines above them.
    fn watch(&mut self, host: &mut dyn InterpreterHost, file: FileId) {
        if self.index(host, file).continues {
            host.watch(true);
        }
    }

    /// The definitions of a file that is loaded.
    fn index(&mut self, host: &dyn ProgramHost, file: FileId) -> Arc<Index> {
        self.indices.get(file, || host.source(file).map(|source| Index::of(&source)).unwrap_or_default())
    }

    /// Where a subprogram is; none if it is nowhere to be found.
    fn find(&mut self, host: &mut dyn ProgramHost, name: String) -> Result<Option<(FileId, ProgramRange)>, Halt> {
        let (here, main) = (host.place().file, host.main_file());
        for file in [here, main] {
            if let Some(range) = self.index(host, file).program(&name) {
                return Ok(Some((file, range)));
            }
        }
        let files = host.files();
        let main = files.get(usize::from(main)).map_or("", String::as_str);
        for (file, whole) in programs::places(&files, main, &name) {
            let file = file as FileId;
            host.load(file)?;
            let index = self.index(host, file);
            let all = || host.source(file).map(|source| ProgramRange { number: None, first: 1, last: source.lines() });
            let range = match index.program(&name) {
                None if whole && index.definitions.is_empty() => all(),
                found => found,
            };
            if let Some(range) = range {
                return Ok(Some((file, range)));
            }
        }
        Ok(None)
    }

    /// The variable of a name in native spelling, with its indices in it or apart.
    fn named(name: &str, indices: &[f64]) -> Option<OkumaVariable> {
        let upper = name.trim().to_ascii_uppercase();
        let mut cursor = OkumaCursor::new(upper.as_bytes());
        let name = expr::name_text(&mut cursor);
        let variable = OkumaExpressionReader::new(&mut cursor).variable(name).ok()?;
        cursor.end().ok()?;
        match (variable, indices) {
            (OkumaVariable::System(name, own), [index]) if own.is_empty() => match names::common(&name) {
                Some((family, None)) => Some(OkumaVariable::Common(family, Box::new(Expr::constant(*index)))),
                _ => Some(OkumaVariable::System(name, [Expr::constant(*index)].into())),
            },
            (variable, []) => Some(variable),
            _ => None,
        }
    }
}

impl Interpreter for Okuma {
    fn block(&mut self, host: &mut dyn InterpreterHost, text: &[u8]) -> Result<Remaining, Halt> {
        self.arguments = None;
        let whole = self.continued(host, text);
        let text = match &whole {
            Some((whole, next)) => {
                host.go_to(*next)?;
                host.join_lines(whole);
                whole.as_slice()
            }
            None => text,
        };
        let line = self.line(host, text)?;
        if !line.messages.is_empty() && !self.takes_messages {
            host.push_plain(text, span(0, text.len()));
            return Ok(Remaining::Words);
        }
        self.run(host, &line, text)
    }

    fn restart(&mut self, reset: bool) {
        self.store.begin(reset);
        self.modal.clear();
        self.alarm_texts.clear();
        self.arguments = None;
        self.caching = false;
        self.names.read.clear();
    }

    fn on_start(&mut self, host: &mut dyn InterpreterHost) {
        let file = host.place().file;
        self.watch(host, file);
    }

    fn on_call(&mut self, host: &mut dyn InterpreterHost) {
        let place = host.place();
        let arguments = self.arguments.take().filter(|(file, line, _)| (*file, *line) == (place.file, place.line));
        self.store.enter(arguments.map(|(.., arguments)| arguments).unwrap_or_default());
        self.caching = true;
    }

    fn on_repeat(&mut self) {
        self.store.again();
    }

    fn on_return(&mut self, host: &mut dyn InterpreterHost) {
        self.store.leave();
        if !self.modal.is_empty() {
            self.end_modal(host);
        }
    }

    fn on_move(&mut self, host: &mut dyn InterpreterHost) {
        self.call_modally(host);
    }

    fn on_end(&mut self, host: &mut dyn InterpreterHost) {
        self.report_open_modal(host, None);
    }

    fn variable(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
        indices: &[f64],
    ) -> Result<Option<MacroValue>, Halt> {
        let value = match Self::named(name, indices) {
            Some(OkumaVariable::Local(name)) => self.store.local(name),
            Some(OkumaVariable::Common(family, index)) => {
                match index.as_constant().and_then(|index| family.common(*index)) {
                    Some(common) => self.store.common(host, common)?,
                    None => None,
                }
            }
            Some(OkumaVariable::System(name, own)) if own.is_empty() => eval::system(host, &name),
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
        match Self::named(name, indices) {
            Some(OkumaVariable::Local(name)) if self.store.local(name).is_some() => {
                if self.store.set_local(name, Some(value)) {
                    host.effect();
                }
                Ok(true)
            }
            Some(OkumaVariable::Common(family, index)) => {
                match index.as_constant().and_then(|index| family.common(*index)) {
                    Some(common) => self.store.set_common(host, common, Some(value)).map(|()| true),
                    None => Ok(false),
                }
            }
            _ => Ok(false),
        }
    }

    #[inline]
    fn executes(&mut self, line: (FileId, u32)) -> bool {
        self.lines.get(line).is_some_and(|line| line.executes)
    }

    fn known_block(&mut self, host: &mut dyn InterpreterHost, at: (FileId, u32)) -> Option<Result<Remaining, Halt>> {
        if !self.lines.get(at)?.alone {
            return None;
        }
        let line = self.lines.take(at)?;
        self.arguments = None;
        let done = self.run(host, &line, &[]);
        self.lines.give_back(at, line);
        debug_assert!(!matches!(done, Ok(Remaining::Words)), "a line that needs no text leaves no words");
        Some(done)
    }

    fn memory(&self) -> u64 {
        (self.store.bytes() + self.names.words.len() * 60 + self.lines.bytes() + self.indices.bytes()) as u64
    }

    fn setting(&mut self, _: &mut dyn InterpreterHost, name: &str, values: &[MacroValue]) -> SettingOutcome {
        let slot = match name {
            "PROCESS,SUBPROGRAMS" => &mut self.takes_calls,
            "PROCESS,SEQNAME" => &mut self.takes_names,
            "PROCESS,MESSAGES" => &mut self.takes_messages,
            "PROCESS,EXECUTIONS" => &mut self.counts_executions,
            "PROCESS,CONTOURS" => &mut self.has_contours,
            "PROCESS,DRAWING" => &mut self.drawing.ignored,
            "PROCESS,TOOLOFFSETS" => &mut self.takes_offsets,
            _ => return SettingOutcome::Unknown,
        };
        let [value] = values else { return SettingOutcome::Wrong };
        let Some(on) = value.as_logical() else { return SettingOutcome::Wrong };
        *slot = on;
        self.lines.clear();
        // Messages that the machine knows follow the same setting.
        if name == "PROCESS,MESSAGES" { SettingOutcome::Unknown } else { SettingOutcome::Made }
    }
}
