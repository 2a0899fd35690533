//! Where jumps lead: labels, block numbers, the partners of loops and branches, the programs of an archive.
//!
//! Facts: reference control-emulator.md 5.4. A file is looked through once, as it stands. Decisions: GOTO looks onwards
//! first, then from the beginning; a jump stays in its program, and in a part that is repeated. Invariant: partners are
//! found without running anything, so a jump out of a loop leaves nothing after.

use std::borrow::Cow;
use std::sync::Arc;

use counterpoint_control_api::host::{InterpreterHost, ProgramHost, ProgramPlace};
use counterpoint_event::FileId;
use counterpoint_fault as diag;
use counterpoint_program::kept::CachedTable;
use counterpoint_program::search::{LabelSearchOrder, Labels};
use counterpoint_program::shape::ProgramRange;
use counterpoint_program::source::ProgramSource;
use rustc_hash::FxHashMap;

use super::block_text::{bare, unmarked};
use super::cursor::SiemensCursor;
use super::item::{JumpDirection, SiemensItem, SiemensJump, SiemensJumpTarget, SiemensLine, Structure};
use super::line::{head, read};
use super::value::Data;
use super::{Outcome, Siemens, SiemensBlockError};

/// The items to be found in a file.
#[derive(Debug, Default)]
pub(super) struct SiemensFileIndex {
    pub(super) labels: Labels<String>,
    numbers: Labels<u32>,
    /// Programs of an archive: name, first and last line.
    pub(super) programs: Vec<(String, u32, u32)>,
    pub(super) partners: FxHashMap<u32, Partners>,
    /// For each program the line of its first block that defines nothing.
    first_blocks: Vec<u32>,
}

/// Lines of a loop or branch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Partners {
    pub(super) first: u32,
    pub(super) otherwise: Option<u32>,
    pub(super) last: u32,
}

/// Kinds of loops and branches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ControlStructure {
    If,
    Loop,
    For,
    While,
    Repeat,
}

/// The effect of a line on loops and branches.
enum StructureMark {
    Open(ControlStructure),
    Else,
    Close(ControlStructure),
}

/// Start of the text of a block after its marks of optional skip.
fn start_of(text: &str) -> usize {
    text.len() - unmarked(text).len()
}

/// The head of a program of an archive; `%` alone is none.
pub(super) fn is_head(text: &str) -> bool {
    text.trim_start()
        .strip_prefix('%')
        .is_some_and(|name| name.starts_with(|c: char| c.is_ascii_alphanumeric() || c == '_'))
}

/// Whether a text can be read, and its block does not begin with a definition.
fn is_block(text: &str) -> bool {
    let text = text.trim();
    let defines = |item: &SiemensItem| {
        matches!(
            item,
            SiemensItem::Declare(_)
                | SiemensItem::Redeclare(_)
                | SiemensItem::Header(_)
                | SiemensItem::External(_)
                | SiemensItem::Define(..)
        )
    };
    text != "%" && read(text).is_ok_and(|line| line.items.first().is_some_and(|item| !defines(item)))
}

fn step(text: &str, cursor: &SiemensCursor<'_>) -> Option<StructureMark> {
    let word = cursor.peeked_name()?.to_ascii_uppercase();
    Some(match word.as_str() {
        "LOOP" => StructureMark::Open(ControlStructure::Loop),
        "FOR" => StructureMark::Open(ControlStructure::For),
        "WHILE" => StructureMark::Open(ControlStructure::While),
        "ELSE" => StructureMark::Else,
        "ENDIF" => StructureMark::Close(ControlStructure::If),
        "ENDLOOP" => StructureMark::Close(ControlStructure::Loop),
        "ENDFOR" => StructureMark::Close(ControlStructure::For),
        "ENDWHILE" => StructureMark::Close(ControlStructure::While),
        "UNTIL" => StructureMark::Close(ControlStructure::Repeat),
        "IF" | "REPEAT" => match read(text).ok()?.items.first()? {
            SiemensItem::If(_, None) => StructureMark::Open(ControlStructure::If),
            SiemensItem::Structure(Structure::Repeat) => StructureMark::Open(ControlStructure::Repeat),
            _ => return None,
        },
        _ => return None,
    })
}

impl SiemensFileIndex {
    fn of(source: &ProgramSource) -> Self {
        let mut places = Self::default();
        let mut open: Vec<(ControlStructure, Partners)> = Vec::new();
        let mut defines = true;
        for line in source.walk(1, source.lines()) {
            let text = String::from_utf8_lossy(source.line(line));
            let text = bare(&text);
            if let Some(name) = text.trim_start().strip_prefix('%').filter(|_| is_head(text)) {
                open.clear();
                defines = true;
                if let Some(previous) = places.programs.last_mut() {
                    previous.2 = line - 1;
                }
                places.programs.push((super::files::program_name(name.trim()), line, source.lines()));
                continue;
            }
            let mut cursor = SiemensCursor::new(text);
            let (number, label) = head(&mut cursor);
            if let Some(number) = number.and_then(|number| number.parse().ok()) {
                places.numbers.add(number, line);
            }
            if let Some(label) = label {
                places.labels.add(label, line);
            }
            defines |= cursor.peeked_name().is_some_and(|name| name.eq_ignore_ascii_case("PROC"));
            if defines && is_block(text) {
                defines = false;
                places.first_blocks.push(line);
            }
            let Some(step) = step(text, &cursor) else { continue };
            places.partner(&mut open, step, line);
        }
        places
    }

    fn partner(&mut self, open: &mut Vec<(ControlStructure, Partners)>, step: StructureMark, line: u32) {
        match step {
            StructureMark::Open(kind) => open.push((kind, Partners { first: line, otherwise: None, last: 0 })),
            StructureMark::Else => {
                if let Some((ControlStructure::If, partners)) = open.last_mut() {
                    partners.otherwise = Some(line);
                }
            }
            StructureMark::Close(kind) => {
                if let Some((_, mut partners)) = open.pop_if(|(opened, _)| *opened == kind) {
                    partners.last = line;
                    for line in [Some(partners.first), partners.otherwise, Some(line)].into_iter().flatten() {
                        self.partners.insert(line, partners);
                    }
                }
            }
        }
    }

    /// Line of a label or block number from another line, within some lines.
    pub(super) fn find(
        &self,
        label: &SiemensJumpTarget,
        search: LabelSearchOrder,
        here: u32,
        around: (u32, u32),
    ) -> Option<u32> {
        match label {
            SiemensJumpTarget::Number(number) => self.numbers.find(number, search, here, around),
            SiemensJumpTarget::Name(name) => self.labels.find(name.as_str(), search, here, around),
            SiemensJumpTarget::Value(_) => None,
        }
    }

    /// Line of the first block of the program around a line that defines nothing.
    pub(super) fn first_block(&self, range: ProgramRange, line: u32) -> Option<u32> {
        let (first, last) = self.program(range, line);
        let at = self.first_blocks.partition_point(|block| *block < first);
        self.first_blocks.get(at).copied().filter(|block| *block <= last)
    }

    /// Lines of the program around a line.
    pub(super) fn program(&self, range: ProgramRange, line: u32) -> (u32, u32) {
        let around = self.programs.iter().find(|(_, first, last)| (*first..=*last).contains(&line));
        around.map_or((range.first, range.last), |(_, first, last)| (range.first.max(*first), range.last.min(*last)))
    }
}

impl CachedTable for SiemensFileIndex {
    fn bytes(&self) -> usize {
        let lines = self.labels.bytes() + self.numbers.bytes() + self.partners.len() * 40;
        lines + self.programs.len() * 80 + self.first_blocks.len() * 4
    }
}

impl Siemens {
    /// Labels and loops of a file.
    pub(super) fn places(&mut self, host: &dyn ProgramHost, file: FileId) -> Arc<SiemensFileIndex> {
        self.places.get(file, || host.source(file).map(|source| SiemensFileIndex::of(&source)).unwrap_or_default())
    }

    /// A block of a file, read.
    pub(super) fn line_of(
        &mut self,
        host: &dyn InterpreterHost,
        file: FileId,
        line: u32,
    ) -> Arc<Result<SiemensLine, String>> {
        if let Some(known) = self.read.get((file, line)) {
            return Arc::clone(known);
        }
        let source = host.source(file);
        let text = source.as_ref().map(|source| String::from_utf8_lossy(source.line(line)));
        let whole = text.as_deref().unwrap_or_default();
        let made = Arc::new(read(bare(whole)).map(|line| line.at(start_of(whole))));
        self.read.insert((file, line), &made, text.as_deref().map_or(0, str::len));
        made
    }

    /// Partners of the loop or branch of this block.
    pub(super) fn partners(&mut self, host: &mut dyn InterpreterHost) -> Outcome<Partners> {
        let place = host.place();
        let found = self.places(host, place.file).partners.get(&place.line).copied();
        match found.filter(|partners| partners.last >= place.range.first) {
            Some(partners) => Ok(partners),
            None => Err(SiemensBlockError::Alarm(
                &diag::MACRO_LOOP,
                "the loop or branch has no matching statement".to_owned(),
            )),
        }
    }

    /// Goes on at a line, which has to be in the running text, or directly after it.
    pub(super) fn go(&mut self, host: &mut dyn InterpreterHost, line: u32) -> Outcome<()> {
        let range = host.place().range;
        if line < range.first || line > range.last.saturating_add(1) {
            return Err(SiemensBlockError::Alarm(
                &diag::JUMP_TARGET,
                "the jump leaves the part that is repeated".to_owned(),
            ));
        }
        Ok(host.go_to(line)?)
    }

    /// Executes a jump; false if its target is missing and that is not a mistake.
    pub(super) fn jump(&mut self, host: &mut dyn InterpreterHost, jump: &SiemensJump) -> Outcome<bool> {
        let place = host.place();
        let places = self.places(host, place.file);
        let (first, last) = places.program(place.range, place.line);
        if jump.direction == JumpDirection::Start {
            self.go(host, first)?;
            return Ok(true);
        }
        let label = self.label(host, &jump.target)?;
        let search = match jump.direction {
            JumpDirection::Forward => LabelSearchOrder::Forward,
            JumpDirection::Back => LabelSearchOrder::Back,
            JumpDirection::Either | JumpDirection::Silent | JumpDirection::Start => LabelSearchOrder::Around,
        };
        let found = places.find(&label, search, place.line, (first, last));
        match found {
            Some(line) => {
                self.go(host, line)?;
                Ok(true)
            }
            None if jump.direction == JumpDirection::Silent => Ok(false),
            None => {
                let way = match jump.direction {
                    JumpDirection::Forward => " after this block",
                    JumpDirection::Back => " before this block",
                    _ => "",
                };
                let text = format!("{} not found in the program{way}", shown(&label));
                Err(SiemensBlockError::Alarm(&diag::JUMP_TARGET, text))
            }
        }
    }

    /// A label without expressions.
    fn label<'l>(
        &mut self,
        host: &mut dyn InterpreterHost,
        label: &'l SiemensJumpTarget,
    ) -> Outcome<Cow<'l, SiemensJumpTarget>> {
        let value = match label {
            SiemensJumpTarget::Name(name) if self.variables.knows(name) => {
                let name = super::compiled::IndexedName { name: name.clone(), index: Vec::new() };
                self.read(host, &name)?
            }
            SiemensJumpTarget::Value(expression) => self.evaluate(host, expression)?,
            known => return Ok(Cow::Borrowed(known)),
        };
        let text = match value {
            Data::Text(text) => text.trim().trim_end_matches(':').to_ascii_uppercase(),
            other => super::number_text::shown(super::conversions::number(&other)?),
        };
        let digits = text.strip_prefix(['N', ':']).unwrap_or(&text);
        Ok(Cow::Owned(match digits.parse() {
            Ok(number) => SiemensJumpTarget::Number(number),
            Err(_) => SiemensJumpTarget::Name(text),
        }))
    }

    /// The line of a label for REPEAT and CALL BLOCK: before this block, otherwise after it.
    pub(super) fn label_line(
        &mut self,
        host: &mut dyn InterpreterHost,
        label: &SiemensJumpTarget,
        place: &ProgramPlace,
    ) -> Outcome<u32> {
        let label = self.label(host, label)?;
        let places = self.places(host, place.file);
        let around = places.program(place.range, place.line.clamp(place.range.first, place.range.last));
        match places.find(&label, LabelSearchOrder::BackThenForward, place.line, around) {
            Some(line) => Ok(line),
            None => {
                Err(SiemensBlockError::Alarm(&diag::JUMP_TARGET, format!("{} not found in the program", shown(&label))))
            }
        }
    }

    /// The first ENDLABEL of the program from a line on.
    pub(super) fn end_label(&mut self, host: &mut dyn InterpreterHost, place: &ProgramPlace, from: u32) -> Option<u32> {
        let places = self.places(host, place.file);
        let within = (from, place.line.saturating_sub(1));
        places.labels.find("ENDLABEL", LabelSearchOrder::FromTop, place.line, within)
    }
}

pub(super) fn shown(label: &SiemensJumpTarget) -> String {
    match label {
        SiemensJumpTarget::Number(number) => format!("block N{number}"),
        SiemensJumpTarget::Name(name) => format!("label {name}"),
        SiemensJumpTarget::Value(_) => "such label".to_owned(),
    }
}
