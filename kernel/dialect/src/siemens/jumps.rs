//! Where jumps lead: labels, block numbers, the partners of loops and branches, the programs of an archive.
//!
//! Facts: reference control-emulator.md 5.4. A file is looked through once, as it stands. Decisions: GOTO looks onwards
//! first, then from the beginning; a jump stays in its program, and in a part that is repeated. Invariant: partners are
//! found without running anything, so a jump out of a loop leaves nothing after.

use std::borrow::Cow;
use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::cursor::Cursor;
use super::line::{Direction, Item, Jump, Label, Line, Structure, head, read};
use super::value::Data;
use super::{Fault, Outcome, Siemens};
use crate::host::{Host, Place, Programs};
use crate::text::without_comment;
use counterpoint_event::FileId;
use counterpoint_fault as diag;
use counterpoint_program::kept::Table;
use counterpoint_program::search::{Labels, Search};
use counterpoint_program::shape::Range;
use counterpoint_program::source::Source;

/// The items to be found in a file.
#[derive(Debug, Default)]
pub(super) struct Places {
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
enum Kind {
    If,
    Loop,
    For,
    While,
    Repeat,
}

/// The effect of a line on loops and branches.
enum Step {
    Open(Kind),
    Else,
    Close(Kind),
}

/// A block as the search sees it: without marks of optional skip and comment.
pub(super) fn bare(text: &str) -> &str {
    without_comment(unmarked(text))
}

fn unmarked(text: &str) -> &str {
    let mut text = text.trim_start();
    while let Some(rest) = text.strip_prefix('/') {
        text = rest.strip_prefix(|c: char| c.is_ascii_digit()).unwrap_or(rest).trim_start();
    }
    text
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
    let defines = |item: &Item| {
        matches!(item, Item::Declare(_) | Item::Redeclare(_) | Item::Header(_) | Item::External(_) | Item::Define(..))
    };
    text != "%" && read(text).is_ok_and(|line| line.items.first().is_some_and(|item| !defines(item)))
}

fn step(text: &str, cursor: &Cursor<'_>) -> Option<Step> {
    let word = cursor.peeked_name()?.to_ascii_uppercase();
    Some(match word.as_str() {
        "LOOP" => Step::Open(Kind::Loop),
        "FOR" => Step::Open(Kind::For),
        "WHILE" => Step::Open(Kind::While),
        "ELSE" => Step::Else,
        "ENDIF" => Step::Close(Kind::If),
        "ENDLOOP" => Step::Close(Kind::Loop),
        "ENDFOR" => Step::Close(Kind::For),
        "ENDWHILE" => Step::Close(Kind::While),
        "UNTIL" => Step::Close(Kind::Repeat),
        "IF" | "REPEAT" => match read(text).ok()?.items.first()? {
            Item::If(_, None) => Step::Open(Kind::If),
            Item::Structure(Structure::Repeat) => Step::Open(Kind::Repeat),
            _ => return None,
        },
        _ => return None,
    })
}

impl Places {
    fn of(source: &Source) -> Self {
        let mut places = Self::default();
        let mut open: Vec<(Kind, Partners)> = Vec::new();
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
            let mut cursor = Cursor::new(text);
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

    fn partner(&mut self, open: &mut Vec<(Kind, Partners)>, step: Step, line: u32) {
        match step {
            Step::Open(kind) => open.push((kind, Partners { first: line, otherwise: None, last: 0 })),
            Step::Else => {
                if let Some((Kind::If, partners)) = open.last_mut() {
                    partners.otherwise = Some(line);
                }
            }
            Step::Close(kind) => {
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
    pub(super) fn find(&self, label: &Label, search: Search, here: u32, around: (u32, u32)) -> Option<u32> {
        match label {
            Label::Number(number) => self.numbers.find(number, search, here, around),
            Label::Name(name) => self.labels.find(name.as_str(), search, here, around),
            Label::Value(_) => None,
        }
    }

    /// Line of the first block of the program around a line that defines nothing.
    pub(super) fn first_block(&self, range: Range, line: u32) -> Option<u32> {
        let (first, last) = self.program(range, line);
        let at = self.first_blocks.partition_point(|block| *block < first);
        self.first_blocks.get(at).copied().filter(|block| *block <= last)
    }

    /// Lines of the program around a line.
    pub(super) fn program(&self, range: Range, line: u32) -> (u32, u32) {
        let around = self.programs.iter().find(|(_, first, last)| (*first..=*last).contains(&line));
        around.map_or((range.first, range.last), |(_, first, last)| (range.first.max(*first), range.last.min(*last)))
    }
}

impl Table for Places {
    fn bytes(&self) -> usize {
        let lines = self.labels.bytes() + self.numbers.bytes() + self.partners.len() * 40;
        lines + self.programs.len() * 80 + self.first_blocks.len() * 4
    }
}

impl Siemens {
    /// Labels and loops of a file.
    pub(super) fn places(&mut self, host: &dyn Programs, file: FileId) -> Arc<Places> {
        self.places.get(file, || host.source(file).map(|source| Places::of(&source)).unwrap_or_default())
    }

    /// A block of a file, read.
    pub(super) fn line_of(&mut self, host: &dyn Host, file: FileId, line: u32) -> Arc<Result<Line, String>> {
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
    pub(super) fn partners(&mut self, host: &mut dyn Host) -> Outcome<Partners> {
        let place = host.place();
        let found = self.places(host, place.file).partners.get(&place.line).copied();
        match found.filter(|partners| partners.last >= place.range.first) {
            Some(partners) => Ok(partners),
            None => Err(Fault::Alarm(&diag::MACRO_LOOP, "the loop or branch has no matching statement".to_owned())),
        }
    }

    /// Goes on at a line, which has to be in the running text, or directly after it.
    pub(super) fn go(&mut self, host: &mut dyn Host, line: u32) -> Outcome<()> {
        let range = host.place().range;
        if line < range.first || line > range.last.saturating_add(1) {
            return Err(Fault::Alarm(&diag::JUMP_TARGET, "the jump leaves the part that is repeated".to_owned()));
        }
        Ok(host.go_to(line)?)
    }

    /// Executes a jump; false if its target is missing and that is not a mistake.
    pub(super) fn jump(&mut self, host: &mut dyn Host, jump: &Jump) -> Outcome<bool> {
        let place = host.place();
        let places = self.places(host, place.file);
        let (first, last) = places.program(place.range, place.line);
        if jump.direction == Direction::Start {
            self.go(host, first)?;
            return Ok(true);
        }
        let label = self.label(host, &jump.target)?;
        let search = match jump.direction {
            Direction::Forward => Search::Forward,
            Direction::Back => Search::Back,
            Direction::Either | Direction::Silent | Direction::Start => Search::Around,
        };
        let found = places.find(&label, search, place.line, (first, last));
        match found {
            Some(line) => {
                self.go(host, line)?;
                Ok(true)
            }
            None if jump.direction == Direction::Silent => Ok(false),
            None => {
                let way = match jump.direction {
                    Direction::Forward => " after this block",
                    Direction::Back => " before this block",
                    _ => "",
                };
                let text = format!("{} not found in the program{way}", shown(&label));
                Err(Fault::Alarm(&diag::JUMP_TARGET, text))
            }
        }
    }

    /// A label without expressions.
    fn label<'l>(&mut self, host: &mut dyn Host, label: &'l Label) -> Outcome<Cow<'l, Label>> {
        let value = match label {
            Label::Name(name) if self.variables.knows(name) => {
                let name = super::expression::Name { name: name.clone(), index: Vec::new() };
                self.read(host, &name)?
            }
            Label::Value(expression) => self.evaluate(host, expression)?,
            known => return Ok(Cow::Borrowed(known)),
        };
        let text = match value {
            Data::Text(text) => text.trim().trim_end_matches(':').to_ascii_uppercase(),
            other => super::value::shown(super::evaluate::number(&other)?),
        };
        let digits = text.strip_prefix(['N', ':']).unwrap_or(&text);
        Ok(Cow::Owned(match digits.parse() {
            Ok(number) => Label::Number(number),
            Err(_) => Label::Name(text),
        }))
    }

    /// The line of a label for REPEAT and CALL BLOCK: before this block, otherwise after it.
    pub(super) fn label_line(&mut self, host: &mut dyn Host, label: &Label, place: &Place) -> Outcome<u32> {
        let label = self.label(host, label)?;
        let places = self.places(host, place.file);
        let around = places.program(place.range, place.line.clamp(place.range.first, place.range.last));
        match places.find(&label, Search::BackThenForward, place.line, around) {
            Some(line) => Ok(line),
            None => Err(Fault::Alarm(&diag::JUMP_TARGET, format!("{} not found in the program", shown(&label)))),
        }
    }

    /// The first ENDLABEL of the program from a line on.
    pub(super) fn end_label(&mut self, host: &mut dyn Host, place: &Place, from: u32) -> Option<u32> {
        let places = self.places(host, place.file);
        let within = (from, place.line.saturating_sub(1));
        places.labels.find("ENDLABEL", Search::FromTop, place.line, within)
    }
}

pub(super) fn shown(label: &Label) -> String {
    match label {
        Label::Number(number) => format!("block N{number}"),
        Label::Name(name) => format!("label {name}"),
        Label::Value(_) => "such label".to_owned(),
    }
}
