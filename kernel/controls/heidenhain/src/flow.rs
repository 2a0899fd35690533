//! Labels, repeats and calls.
//!
//! Facts: programming manuals of the control: CALL LBL without REP calls a subprogram that ends at LBL 0; with REP m
//! the part from the label to the call runs m more times. Heidenhain pre-processor page: CALL PGM, TNC: and the file
//! root. Decisions: REP with a label further down calls it that many times; the first label of a name counts.
//! Invariant: a jump back and a call are counted by the kernel.

use counterpoint_control_api::host::{InterpreterHost, SubprogramCall};
use counterpoint_event::FileId;
use counterpoint_fault as diag;
use counterpoint_fault::Halt;
use counterpoint_machine::stored::StoredFile;
use counterpoint_program::search::{LabelSearchOrder, Labels};
use counterpoint_program::shape::ProgramRange;
use counterpoint_program::source::ProgramSource;

use super::eval::Evaluator;
use super::formula::Formula;
use super::q_parameter::ParameterValue;
use super::statement::{HeidenhainStatement, Label};
use super::statement_reader;
use super::words::{LeftBlock, headed};
use super::{Heidenhain, lex};

/// The program of a frame of the kernel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum CalleeKind {
    #[default]
    Program,
    Label,
    /// The program of a cycle.
    Cycle,
}

/// Labels of a file; blocks that cannot be read have none.
fn labels(source: &ProgramSource) -> Labels<Label> {
    let mut labels = Labels::default();
    for line in source.walk(1, source.lines()) {
        let text = source.line(line);
        let may = |word: &[u8]| memchr::memmem::find(text, word).is_some();
        if !(may(b"LBL") || may(b"lbl") || may(b"Lbl") || may(b"98")) {
            continue;
        }
        let clean = lex::clean(text, &|_| false);
        if let Ok(HeidenhainStatement::Label(label)) = statement_reader::read(&clean.text) {
            labels.add(label, line);
        }
    }
    labels
}

/// Most passes of a repeat.
const MOST: f64 = 65_534.0;

impl Heidenhain {
    /// Line of a label in the file being processed.
    pub(super) fn find_label(&mut self, host: &mut dyn InterpreterHost, label: &Label) -> Option<u32> {
        let file = host.place().file;
        self.find_label_in(host, file, label)
    }

    /// Line of a label in a file.
    pub(super) fn find_label_in(&mut self, host: &mut dyn InterpreterHost, file: FileId, label: &Label) -> Option<u32> {
        let known = self.labels.get(file, || host.source(file).map(|source| labels(&source)).unwrap_or_default());
        known.find(label, LabelSearchOrder::FromTop, 0, (1, u32::MAX))
    }

    pub(super) fn label_of(&mut self, host: &mut dyn InterpreterHost, formula: &Formula) -> Result<Label, Halt> {
        let value = Evaluator::new(&mut self.variables, host).value(formula)?;
        match value {
            ParameterValue::Text(name) => Ok(Label::Name(name.to_string())),
            ParameterValue::Number(number) if (0.0..=1e9).contains(&number) && number.fract() == 0.0 => {
                Ok(Label::Number(number as u32))
            }
            ParameterValue::Number(number) => {
                let text = format!("label {number} not found in '{}'", host.block_text());
                Err(host.alarm(&diag::JUMP_TARGET, text))
            }
        }
    }

    fn known_label(&mut self, host: &mut dyn InterpreterHost, formula: &Formula) -> Result<(Label, u32), Halt> {
        let label = self.label_of(host, formula)?;
        match self.find_label(host, &label) {
            Some(line) => Ok((label, line)),
            None => {
                let text = format!("{label} not found in the program for '{}'", host.block_text());
                Err(host.alarm(&diag::JUMP_TARGET, text))
            }
        }
    }

    /// GOTO LBL.
    pub(super) fn jump(&mut self, host: &mut dyn InterpreterHost, to: &Formula) -> Result<(), Halt> {
        let (_, line) = self.known_label(host, to)?;
        self.lines.keeping = true;
        host.go_to(line)
    }

    /// CALL LBL: a subprogram, or a repeat of the blocks between the label and here.
    pub(super) fn call_label(
        &mut self,
        host: &mut dyn InterpreterHost,
        label: &Formula,
        repeat: Option<&Formula>,
    ) -> Result<(), Halt> {
        let (label, line) = self.known_label(host, label)?;
        let here = host.place();
        let passes = match repeat {
            None => 1,
            Some(repeat) => {
                let passes = Evaluator::new(&mut self.variables, host).number(repeat)?;
                passes.clamp(0.0, MOST) as u32
            }
        };
        if repeat.is_some() && line < here.line {
            let frame = self.variables.calls.here_mut();
            let at = frame.repeats.iter().position(|(call, _)| *call == here.line);
            let left = at.and_then(|at| frame.repeats.get(at)).map_or(passes, |(_, left)| *left);
            if let Some(at) = at {
                frame.repeats.remove(at);
            }
            if left == 0 {
                return Ok(());
            }
            frame.repeats.push((here.line, left - 1));
            host.effect();
            self.lines.keeping = true;
            return host.go_to(line);
        }
        if passes == 0 {
            return Ok(());
        }
        let last = host.source(here.file).map_or(here.range.last, |source| source.lines());
        let place = Some((here.file, ProgramRange { number: None, first: line, last }));
        self.calling = Some(CalleeKind::Label);
        host.call(SubprogramCall { name: label.to_string().into(), place, passes, closes: true });
        Ok(())
    }

    /// LBL 0: the end of a subprogram, nothing where none was called.
    pub(super) fn end_label(&mut self, host: &mut dyn InterpreterHost) {
        if self.variables.calls.in_part() {
            host.return_from();
        }
    }

    /// END PGM: a code of the machine if it has one, otherwise the end of the program or the return of a called one.
    pub(super) fn end_program(&mut self, host: &mut dyn InterpreterHost) -> Result<Vec<LeftBlock>, Halt> {
        if self.variables.calls.depth() > 0 {
            let unit = self.unit_of_caller(host);
            host.return_from();
            return Ok(unit.into_iter().collect());
        }
        if host.is_code_text("END PGM") {
            return Ok(vec![headed("END PGM", [])]);
        }
        Err(Halt::ProgramEnd(None))
    }

    /// A program called by name.
    pub(super) fn call_program(&mut self, host: &mut dyn InterpreterHost, name: &str) -> Result<(), Halt> {
        let place = self.find_program(host, name, false)?;
        self.calling = Some(CalleeKind::Program);
        host.call(SubprogramCall { name: name.trim().into(), place, passes: 1, closes: true });
        Ok(())
    }

    /// Whether the current program is an ISO program: by setting, first block, or file name.
    pub(super) fn is_iso(&self, host: &dyn InterpreterHost) -> bool {
        if let Some(iso) = self.settings.iso {
            return iso;
        }
        let file = host.place().file;
        let first = host.source(file).and_then(|source| {
            let lines = source.walk(1, source.lines()).map(|line| source.line(line).trim_ascii());
            lines.into_iter().find(|line| !line.is_empty()).map(<[u8]>::to_vec)
        });
        if first.is_some_and(|first| first.starts_with(b"%")) {
            return true;
        }
        let files = host.files();
        files.get(usize::from(file)).is_some_and(|name| name.to_ascii_uppercase().ends_with(".I"))
    }

    /// Where a program of a name is: beside the calling or the main program, then where the settings say.
    pub(super) fn find_program(
        &self,
        host: &mut dyn InterpreterHost,
        name: &str,
        stored: bool,
    ) -> Result<Option<(FileId, ProgramRange)>, Halt> {
        let path = name.trim().trim_matches('"').replace('\\', "/");
        let files = host.files();
        let folder = |file: FileId| {
            let name = files.get(usize::from(file)).map_or("", String::as_str);
            name.rsplit_once('/').map_or(String::new(), |(folder, _)| format!("{folder}/"))
        };
        let mut wanted = Vec::new();
        if stored {
            wanted.push(format!("{}{path}", StoredFile::ROOT));
        }
        let root = self.settings.root.as_str();
        let absolute = path.get(..4).filter(|drive| drive.eq_ignore_ascii_case("TNC:")).and_then(|_| path.get(4..));
        match absolute {
            Some(path) => {
                let path = path.trim_start_matches('/');
                wanted.push(format!("{}{path}", StoredFile::ROOT));
                wanted.push(format!("{}{path}", folder(host.main_file())));
                let own = path.rsplit_once('/').map_or(path, |(_, name)| name);
                wanted.push(format!("{}{own}", folder(host.main_file())));
            }
            None => {
                let path = path.trim_start_matches('/');
                wanted.push(format!("{}{path}", folder(host.place().file)));
                wanted.push(format!("{}{path}", folder(host.main_file())));
                wanted.push(format!("{root}{path}"));
            }
        }
        let endings = if self.is_iso(host) { ["", ".I", ".H"] } else { ["", ".H", ".I"] };
        for place in &wanted {
            for ending in endings {
                let full = format!("{place}{ending}");
                if let Some(file) = files.iter().position(|file| file.eq_ignore_ascii_case(&full)) {
                    return whole(host, file as FileId).map(Some);
                }
            }
        }
        Ok(None)
    }
}

/// All of a file.
fn whole(host: &mut dyn InterpreterHost, file: FileId) -> Result<(FileId, ProgramRange), Halt> {
    host.load(file)?;
    let last = host.source(file).map_or(0, |source| source.lines());
    Ok((file, ProgramRange { number: None, first: 1, last }))
}
