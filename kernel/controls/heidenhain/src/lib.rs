//! Heidenhain: conversational and ISO programs.
//!
//! Facts: reference control-emulator.md 5.4, the pages of the emulated system's Heidenhain pre-processor, programming
//! manuals of the control. Both forms of program are read block by block as they are written. The remainder of a block
//! consists of words for the tables of the machine: [docs/preprocessors.md] lists them. Invariants: a statement is
//! compiled once for each line that is unchanged since it was read; calls are those of the kernel, in the same order.

mod ahead;
mod approach;
mod areas;
mod auxiliary;
mod call_approach;
mod calls;
mod carry;
mod choices;
mod circle;
mod clearing;
mod contours;
mod control;
mod corner;
mod cycle_reader;
mod cycle_state;
mod cycles;
mod cylinder;
mod drilling;
mod engraving;
mod eval;
mod feeds;
mod flow;
mod foreign_axes;
mod formula;
mod free;
mod functions;
mod iso;
mod iso_blocks;
mod iso_cycles;
mod iso_ends;
mod left;
mod lex;
mod m_words;
mod models;
mod moves;
mod old;
mod path;
mod path_state;
mod patterns;
mod planes;
mod polar;
mod print;
mod q_parameter;
mod rates;
mod retract;
mod settings;
mod shifts;
mod sl_contours;
mod slot;
mod space;
mod statement;
mod statement_reader;
mod system;
mod tables;
mod tasks;
mod tool_call;
mod tools;
mod train;
mod trans;
mod upright;
mod variables;
mod words;

use std::sync::Arc;

use counterpoint_control_api::host::InterpreterHost;
use counterpoint_control_api::interpreter::{Interpreter, MadeBlocks, Remaining, SettingOutcome};
use counterpoint_control_api::words::{Meanings, Span, span};
use counterpoint_event::FileId;
use counterpoint_fault as diag;
use counterpoint_fault::Halt;
use counterpoint_lang::value::MacroValue;
use counterpoint_program::kept::{LineCache, TableCache};
use counterpoint_program::search::Labels;
use counterpoint_program::shape::ProgramRange;
use lex::HeidenhainCursor;
use path_state::PathState;
use settings::HeidenhainSettings;
use statement::HeidenhainStatement;
use variables::{HeidenhainCallLevel, QParameterStore};

pub use control::HeidenhainDialect;

/// Most lines that continue one another.
const CONTINUED: u32 = 1000;

/// A block that has been read.
#[derive(Debug)]
struct HeidenhainLine {
    number: Option<u32>,
    statement: HeidenhainStatement,
    /// Where its text is in the line, or in the text of its lines.
    place: Span,
    /// The text of a block of several lines.
    joined: Option<Box<str>>,
    /// Line after the last one of the block.
    next: u32,
}

/// A line with its place.
type PlacedLine = ((FileId, u32), Arc<HeidenhainLine>);

/// Lines that have been read.
#[derive(Debug, Default)]
struct ReadLines {
    /// A line may run again, so lines are worth keeping.
    keeping: bool,
    kept: LineCache<HeidenhainLine>,
    /// The last two lines: a path block reads the lines after it before they are executed.
    recent: [Option<PlacedLine>; 2],
    /// The text of the lines of the current statement, if it has consumed further blocks.
    taken: Option<String>,
}

impl ReadLines {
    fn get(&mut self, at: (FileId, u32)) -> Option<&Arc<HeidenhainLine>> {
        let recent = self.recent.iter().flatten().find(|(of, _)| *of == at).map(|(_, line)| line);
        recent.or_else(|| self.kept.get(at))
    }

    /// Adds a line whose text has this length.
    fn add(&mut self, at: (FileId, u32), line: &Arc<HeidenhainLine>, length: usize) {
        if self.keeping {
            self.kept.insert(at, line, length);
        }
        let [last, _] = std::mem::take(&mut self.recent);
        self.recent = [Some((at, Arc::clone(line))), last];
    }

    fn clear(&mut self) {
        self.kept.clear();
        self.recent = Default::default();
    }
}

/// The pre-processor with its variables.
#[derive(Debug, Default)]
pub(crate) struct Heidenhain {
    variables: QParameterStore,
    path: PathState,
    settings: HeidenhainSettings,
    /// Kind of the call that has been requested.
    calling: Option<flow::CalleeKind>,
    selected: Selected,
    cycles: cycle_state::HeidenhainCycles,
    shifts: shifts::Shifts,
    units: feeds::Units,
    tools: tools::ToolTableValues,
    modes: iso_blocks::IsoModes,
    space: space::Space,
    planes: planes::Planes,
    lines: ReadLines,
    labels: TableCache<FileId, Labels<statement::Label>>,
    meanings: Meanings,
}

/// Files that statements have selected for later ones.
#[derive(Debug, Default)]
struct Selected {
    /// Program that CALL SELECTED PGM calls.
    program: Option<Arc<str>>,
    /// Datum table that SEL TABLE has named.
    datums: Option<Arc<str>>,
}

impl Heidenhain {
    /// The block that begins at a line of the file being processed.
    fn line(&mut self, host: &mut dyn InterpreterHost, line: u32) -> Result<Arc<HeidenhainLine>, String> {
        let file = host.place().file;
        self.line_in(host, file, line)
    }

    /// A block of a file that is loaded.
    fn line_in(
        &mut self,
        host: &mut dyn InterpreterHost,
        file: FileId,
        line: u32,
    ) -> Result<Arc<HeidenhainLine>, String> {
        if let Some(known) = self.lines.get((file, line)) {
            return Ok(Arc::clone(known));
        }
        let source = host.source(file);
        let text = |line: u32| source.as_deref().map_or(&[][..], |source| source.line(line));
        let last = source.as_deref().map_or(0, |source| source.lines());
        let (read, marked) = self.compile(host, text(line), (line, last), &text)?;
        let read = Arc::new(read);
        if !marked {
            let length = (line..read.next).map(|line| text(line).len()).sum();
            self.lines.add((file, line), &read, length);
        }
        Ok(read)
    }

    /// Reads a block with the lines that belong to it; whether it has a mark of optional skip.
    fn compile<'s>(
        &self,
        host: &dyn InterpreterHost,
        first: &[u8],
        (line, last): (u32, u32),
        text: &dyn Fn(u32) -> &'s [u8],
    ) -> Result<(HeidenhainLine, bool), String> {
        let mut clean = lex::clean(first, &|level| host.skips(level));
        let mut next = line + 1;
        // Of a block that is skipped, or that is a comment alone, the lines that follow are part.
        let silent = clean.text.is_empty() && clean.silent;
        let joins = silent || self.settings.joins || clean.text.starts_with("CYCL") || clean.text.starts_with('G');
        while clean.continues && joins && next <= last && next - line < CONTINUED {
            let more = lex::clean(text(next), &|level| host.skips(level));
            if !silent {
                clean.text.push(' ');
                clean.text.push_str(&more.text);
            }
            clean.continues = more.continues;
            clean.marked |= more.marked;
            next += 1;
        }
        let statement = statement_reader::read(&clean.text).map_err(|wrong| format!("{wrong} of '{}'", clean.text))?;
        let length = clean.text.len();
        let joins = next > line + 1 && !clean.text.is_empty();
        let start = if joins { 0 } else { clean.start };
        let joined = joins.then(|| clean.text.into_boxed_str());
        let place = span(start, start + length);
        Ok((HeidenhainLine { number: clean.number, statement, place, joined, next }, clean.marked))
    }

    /// A block whose text is not that of its line.
    fn compile_alone(&self, host: &dyn InterpreterHost, text: &[u8]) -> Result<Arc<HeidenhainLine>, String> {
        let line = host.place().line;
        self.compile(host, text, (line, line), &|_| &[]).map(|(read, _)| Arc::new(read))
    }
}

impl Interpreter for Heidenhain {
    fn block(&mut self, host: &mut dyn InterpreterHost, text: &[u8]) -> Result<Remaining, Halt> {
        self.calling = None;
        self.lines.taken = None;
        self.plane_angles(host);
        let place = host.place();
        let read = match place.as_read {
            true => self.line(host, place.line),
            false => self.compile_alone(host, text),
        };
        let line = match read {
            Ok(line) => line,
            Err(wrong) => return Err(host.alarm(&diag::MACRO_SYNTAX, wrong)),
        };
        if place.as_read && line.next > place.line + 1 {
            host.go_to(line.next)?;
        }
        if let HeidenhainStatement::Contour(what) = &line.statement {
            let moves = self.contour_statement(host, what, place)?;
            return Ok(left::leave(self, host, &line, moves.blocks()));
        }
        let left = self.carry_out(host, &line, place)?;
        Ok(left::leave(self, host, &line, left))
    }

    fn restart(&mut self, reset: bool) {
        self.variables.begin(reset);
        self.calling = None;
        self.path = PathState::default();
        self.units = feeds::Units::default();
        self.modes = iso_blocks::IsoModes::default();
        self.space = space::Space::default();
        self.planes = planes::Planes::default();
        self.cycles.running = cycle_state::RunningCycle::default();
        if reset {
            self.shifts = shifts::Shifts::default();
            self.cycles.contours = sl_contours::Contours::default();
            self.cycles.global.clear();
            self.cycles.defined = cycle_state::DefinedCycle::default();
            self.cycles.pattern = patterns::PointPattern::default();
            self.selected = Selected::default();
        }
    }

    fn cycle(
        &mut self,
        host: &mut dyn InterpreterHost,
        (file, _): (FileId, ProgramRange),
        blocks: &mut MadeBlocks,
    ) -> Result<bool, Halt> {
        self.hole(host, file, blocks)
    }

    fn on_call(&mut self, _: &mut dyn InterpreterHost) {
        self.lines.keeping = true;
        let kind = self.calling.take().unwrap_or(flow::CalleeKind::Program);
        match kind {
            flow::CalleeKind::Program => self.variables.calls.enter(HeidenhainCallLevel::default()),
            flow::CalleeKind::Label => self.variables.calls.enter_part(HeidenhainCallLevel::default()),
            flow::CalleeKind::Cycle => {
                self.variables.calls.enter(HeidenhainCallLevel::default());
                self.cycle_begins();
            }
        }
    }

    fn on_repeat(&mut self) {
        if let Some(level) = self.variables.calls.called_mut() {
            level.repeats.clear();
        }
    }

    fn on_return(&mut self, _: &mut dyn InterpreterHost) {
        self.variables.calls.leave();
        self.cycle_returns();
    }

    fn variable(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
        indices: &[f64],
    ) -> Result<Option<MacroValue>, Halt> {
        let Some(name) = spelled(name, indices) else { return Ok(None) };
        let value = self.variables.get(name).or_else(|| self.variables.of_control(name, &*host));
        Ok(value.filter(|_| QParameterStore::exists(name)).map(|value| eval::given(&value)))
    }

    fn set_variable(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
        indices: &[f64],
        value: &MacroValue,
    ) -> Result<bool, Halt> {
        let Some(name) = spelled(name, indices) else { return Ok(false) };
        let value = match (value.as_real(), value.as_text()) {
            (Some(value), _) if value.is_finite() => q_parameter::ParameterValue::Number(value),
            (_, Some(text)) => q_parameter::ParameterValue::Text(text.into()),
            _ => return Ok(false),
        };
        host.effect();
        Ok(self.variables.set(name, value))
    }

    fn memory(&self) -> u64 {
        (self.variables.bytes()
            + self.lines.kept.bytes()
            + self.labels.bytes()
            + self.tools.bytes()
            + self.cycles.contours.bytes()
            + self.cycles.pattern.bytes()) as u64
    }

    fn setting(&mut self, _: &mut dyn InterpreterHost, name: &str, values: &[MacroValue]) -> SettingOutcome {
        let made = self.settings.make(name, values);
        if made == SettingOutcome::Made {
            // The setting decides which lines are joined, so all lines are read again.
            self.lines.clear();
        }
        made
    }
}

/// A parameter as macros name it: `Q200`, or `Q` with an index apart.
fn spelled(name: &str, indices: &[f64]) -> Option<q_parameter::QParameter> {
    let text = match indices {
        [] => name.to_ascii_uppercase(),
        [index] if *index >= 0.0 && index.fract() == 0.0 && *index < 1e9 => {
            format!("{}{index}", name.to_ascii_uppercase().trim_end_matches(['(', '[', ' ']))
        }
        _ => return None,
    };
    let mut cursor = HeidenhainCursor::new(&text);
    formula::parameter(&mut cursor).filter(|_| cursor.is_over())
}
