//! A program file: its text, the programs in it and its sequence numbers.
//!
//! Invariant: programs and sequence numbers are looked for once, when they are first needed; every line of text after
//! the rewind-stop belongs to exactly one program.

use std::ops::{Deref, RangeInclusive};
use std::sync::atomic::{AtomicU8, Ordering::Relaxed};
use std::sync::{Arc, OnceLock};

use bytes::Bytes;
use counterpoint_event::Text;
use counterpoint_event::info::FileSection;
use rustc_hash::FxHashMap;

use super::line_up::LineUp;
use super::rules::TapeRuleSet;
use super::shape::{ProgramDelimiters, ProgramRange, leading_number};
use super::spot::BlockStart;
use super::syntax::Syntax;
use counterpoint_ports::control::StopSignal;

/// Data of a byte in a text.
const UNKNOWN: u8 = 0;
const PRESENT: u8 = 1;
const ABSENT: u8 = 2;

/// A file of the job.
#[derive(Debug)]
pub struct ProgramSource {
    /// Name as the job knows it.
    pub name: String,
    text: Arc<Text>,
    shape: Arc<ProgramDelimiters>,
    stop: StopSignal,
    programs: OnceLock<Vec<ProgramRange>>,
    sequences: OnceLock<FxHashMap<u32, Vec<BlockStart>>>,
    /// Whether a byte occurs in the text, by byte: [`UNKNOWN`] until it is requested.
    has: [AtomicU8; 256],
    /// Findings of one tape editor about the whole text, and its number.
    tape: OnceLock<(u64, TapeRuleSet)>,
    /// Labels at which systems line up, ascending.
    labels: OnceLock<Vec<u32>>,
    /// Stretches that belong to channels, in order.
    sections: Vec<FileSection>,
    /// Views that the channels have of a file with such sections.
    views: Vec<(u16, Arc<ProgramSource>)>,
}

impl ProgramSource {
    /// A file of a machine without habits of its own.
    #[must_use]
    pub fn new(name: impl Into<String>, bytes: Bytes) -> Self {
        Self::shaped(name, bytes, Arc::default(), StopSignal::default())
    }

    /// The syntax of its pre-processor.
    #[must_use]
    pub fn syntax(&self) -> &'static Syntax {
        self.shape.syntax()
    }

    /// A file as a machine tells its programs apart. When `stop` is requested, searches in the text end where they are;
    /// their result must not be used any more.
    #[must_use]
    pub fn shaped(name: impl Into<String>, bytes: Bytes, shape: Arc<ProgramDelimiters>, stop: StopSignal) -> Self {
        let text = Arc::new(Text::new(bytes, || stop.asked_once_resumed()));
        let (programs, sequences, tape) = (OnceLock::new(), OnceLock::new(), OnceLock::new());
        let has = [const { AtomicU8::new(UNKNOWN) }; 256];
        let (labels, sections, views) = (OnceLock::new(), Vec::new(), Vec::new());
        Self { name: name.into(), text, shape, stop, programs, sequences, has, tape, labels, sections, views }
    }

    /// The same file with the sections that belong to channels, and the view of each channel.
    pub(super) fn divided(self, sections: Vec<FileSection>, views: Vec<(u16, Arc<Self>)>) -> Self {
        Self { sections, views, ..self }
    }

    /// The same file with another text.
    pub(super) fn with_text(&self, text: Bytes) -> Self {
        Self::shaped(self.name.clone(), text, Arc::clone(&self.shape), self.stop.clone())
    }

    /// Stretches that belong to channels, in order.
    #[must_use]
    pub fn sections(&self) -> &[FileSection] {
        &self.sections
    }

    /// The file as a channel sees it: without the stretches of others.
    #[inline(always)]
    #[must_use]
    pub fn seen_by(self: &Arc<Self>, channel: u16) -> &Arc<Self> {
        if self.views.is_empty() { self } else { self.view(channel) }
    }

    #[inline(never)]
    fn view(self: &Arc<Self>, channel: u16) -> &Arc<Self> {
        self.views.iter().find(|(of, _)| *of == channel).map_or(self, |(_, view)| view)
    }

    /// The text of the file.
    #[must_use]
    pub fn text(&self) -> &Arc<Text> {
        &self.text
    }

    /// Whether a byte occurs in the text; it is looked for once.
    #[inline(always)]
    pub fn has(&self, byte: u8) -> bool {
        match self.has.get(usize::from(byte)).map(|known| known.load(Relaxed)) {
            Some(UNKNOWN) | None => self.find(byte),
            Some(known) => known == PRESENT,
        }
    }

    #[cold]
    #[inline(never)]
    fn find(&self, byte: u8) -> bool {
        let found = memchr::memchr(byte, self.text.bytes()).is_some();
        if let Some(known) = self.has.get(usize::from(byte)) {
            known.store(if found { PRESENT } else { ABSENT }, Relaxed);
        }
        found
    }

    /// Rules of the tape editor with this number that may change something in the text: found out once, for one tape
    /// editor.
    #[inline]
    pub(super) fn tape_rules(&self, number: u64, find: impl FnOnce(&[u8]) -> TapeRuleSet) -> Option<&TapeRuleSet> {
        let (of, rules) = self.tape.get_or_init(|| (number, find(self.text.bytes())));
        (*of == number).then_some(rules)
    }

    /// The numbers of these lines, until the job is to end.
    pub fn walk(&self, first: u32, last: u32) -> impl DoubleEndedIterator<Item = u32> + Clone + '_ {
        LineIter { lines: first..=last, stop: &self.stop }
    }

    /// The programs in the file, in order. Text before the first definition is one without number, so is a file without
    /// definitions.
    #[must_use]
    pub fn programs(&self) -> &[ProgramRange] {
        self.programs.get_or_init(|| ranges(self, &self.shape))
    }

    /// The name that a line defines a program by.
    pub fn name_at(&self, line: u32) -> Option<&[u8]> {
        self.shape.name(self.line(line))
    }

    /// Whether a line is a rewind-stop.
    pub(super) fn is_stop(&self, line: u32) -> bool {
        self.shape.is_stop(self.line(line))
    }

    /// Whether a line defines a program.
    pub(super) fn defines(&self, line: u32) -> bool {
        let text = self.line(line);
        self.shape.number(text).is_some() || self.shape.name(text).is_some()
    }

    /// A line without comments and messages, in capitals.
    pub(super) fn words(&self, line: u32) -> Vec<u8> {
        self.shape.words(self.line(line))
    }

    /// Whether something is in a line besides blanks, comments and a rewind-stop.
    pub fn has_text(&self, line: u32) -> bool {
        self.shape.has_text(self.line(line))
    }

    /// The program of a name, letter case ignored.
    #[must_use]
    pub fn named(&self, name: &str) -> Option<ProgramRange> {
        let is =
            |range: &&ProgramRange| self.name_at(range.first).is_some_and(|n| n.eq_ignore_ascii_case(name.as_bytes()));
        self.programs().iter().filter(|range| range.number.is_none()).find(is).copied()
    }

    /// A program without a definition: the text of the file, or the part before the first definition.
    #[must_use]
    pub fn is_plain(&self, range: ProgramRange) -> bool {
        range.number.is_none() && self.name_at(range.first).is_none()
    }

    /// Whether the file has a word at which systems line up with this label, on a machine with these systems (bit `n −
    /// 1` for `n`).
    pub fn lines_up(&self, mark: u8, label: u32, all: u32) -> bool {
        let labels = self.labels.get_or_init(|| {
            let mut found = Vec::new();
            for line in self.walk(1, self.lines()) {
                if memchr::memchr(mark, self.line(line)).is_none() {
                    continue;
                }
                let (text, mut at) = (self.words(line), 0);
                while let Some(next) = text.get(at..).and_then(|rest| memchr::memchr(mark, rest)) {
                    let word = LineUp::parse(&text, at + next, mark);
                    found.extend(word.map(|(word, _)| word.resolve(all).1));
                    at = word.map_or(at + next + 1, |(_, end)| end);
                }
            }
            found.sort_unstable();
            found.dedup();
            found
        });
        labels.binary_search(&label).is_ok()
    }

    /// Blocks that begin with sequence number `number`, ascending.
    #[must_use]
    pub fn sequences(&self, number: u32) -> &[BlockStart] {
        self.sequences
            .get_or_init(|| {
                let mut index: FxHashMap<u32, Vec<BlockStart>> = FxHashMap::default();
                for line in self.walk(1, self.lines()) {
                    let text = self.line(line);
                    for offset in self.shape.block_starts(text) {
                        let block = text.get(offset..).unwrap_or_default();
                        if let Some(number) = leading_number(block, b'N') {
                            index.entry(number).or_default().push(BlockStart { line, offset: offset as u32 });
                        }
                    }
                }
                index
            })
            .get(&number)
            .map_or(&[], Vec::as_slice)
    }
}

impl Deref for ProgramSource {
    type Target = Text;

    #[inline]
    fn deref(&self) -> &Text {
        &self.text
    }
}

/// Finds the programs of a file. The text before the first definition, after a rewind-stop if there is one, is a
/// program of its own without a number; blank lines and comments are not text. Without any definition the file is one
/// program.
fn ranges(source: &ProgramSource, shape: &ProgramDelimiters) -> Vec<ProgramRange> {
    let mut found: Vec<ProgramRange> = Vec::new();
    let last = source.lines();
    let mut next = 1;
    while let Some(line) = next_definition(source, shape, next) {
        next = line + 1;
        let text = source.line(line);
        let number = shape.number(text);
        if number.is_some() || shape.name(text).is_some() {
            if let Some(previous) = found.last_mut() {
                previous.last = line - 1;
            }
            found.push(ProgramRange { number, first: line, last });
        }
    }
    let Some(definition) = found.first().map(|range| range.first) else {
        return if last > 0 { vec![ProgramRange { number: None, first: 1, last }] } else { found };
    };
    let stop = source.walk(1, definition - 1).find(|&line| shape.is_stop(source.line(line)));
    let first = stop.map_or(1, |line| line + 1);
    if source.walk(first, definition - 1).any(|line| shape.has_text(source.line(line))) {
        found.insert(0, ProgramRange { number: None, first, last: definition - 1 });
    }
    found
}

/// The first line from `first` on that may define a program; none if there is none or the job is to end.
fn next_definition(source: &ProgramSource, shape: &ProgramDelimiters, first: u32) -> Option<u32> {
    let letters = shape.definition_letters().filter(|_| !(shape.has_angle_names() && source.has(b'<')));
    let Some([a, b, c]) = letters else {
        return source.walk(first, source.lines()).find(|line| shape.may_define(source.line(*line)));
    };
    let (text, mut line) = (source.text(), first);
    // Few lines contain any of the letters.
    while !source.stop.asked_once_resumed()
        && let at = text.start(line)
        && let Some(found) = memchr::memchr3(a, b, c, text.bytes().get(at..)?)
    {
        line = text.line_at(at + found);
        if line > source.lines() {
            return None;
        }
        if shape.may_define(source.line(line)) {
            return Some(line);
        }
        line += 1;
    }
    None
}

/// Lines until the job is to end.
#[derive(Debug, Clone)]
struct LineIter<'s> {
    lines: RangeInclusive<u32>,
    stop: &'s StopSignal,
}

impl Iterator for LineIter<'_> {
    type Item = u32;

    #[inline]
    fn next(&mut self) -> Option<u32> {
        if self.stop.asked_once_resumed() { None } else { self.lines.next() }
    }
}

impl DoubleEndedIterator for LineIter<'_> {
    fn next_back(&mut self) -> Option<u32> {
        if self.stop.asked_once_resumed() { None } else { self.lines.next_back() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lines_that_may_define_a_program_are_those_that_a_look_at_each_line_finds() {
        let lines = ["O1", " /o2 (x)", "(O3)", ":4", "G1 X1 (<NO>)", "<SUB>", "N5 GOTO 7", "", "\t:6", "M30 O7"];
        for names in [false, true] {
            let shape = if names { ProgramDelimiters::with_angle_names() } else { ProgramDelimiters::default() };
            for first in 0..lines.len() {
                for by in 1..lines.len() {
                    let some = (0..7).filter_map(|at| lines.get((first + at * by) % lines.len()).copied());
                    let text = some.collect::<Vec<_>>().join(if by % 2 == 0 { "\n" } else { "\r\n" });
                    let source = ProgramSource::shaped("t", text.clone().into(), Arc::default(), StopSignal::default());
                    let all: Vec<u32> = (1..=source.lines()).filter(|at| shape.may_define(source.line(*at))).collect();
                    let mut found = Vec::new();
                    while let Some(line) = next_definition(&source, &shape, found.last().map_or(1, |last| last + 1)) {
                        found.push(line);
                    }
                    // Without such names a line in angle brackets defines nothing.
                    let defines = |line: &u32| names || !source.line(*line).starts_with(b"<");
                    assert_eq!(found, all.into_iter().filter(defines).collect::<Vec<_>>(), "{text}");
                }
            }
        }
    }

    #[test]
    fn nothing_is_looked_for_when_the_job_is_to_end() {
        let stop = StopSignal::default();
        let text = Bytes::from_static(b"O1\nN1\nO2\nN2\n");
        let source = ProgramSource::shaped("t", text, Arc::default(), stop.clone());
        assert_eq!(source.walk(2, 3).collect::<Vec<_>>(), [2, 3]);
        stop.ask();
        assert_eq!(source.walk(1, 4).count(), 0);
        assert!(source.programs().iter().all(|range| range.number.is_none()));
        assert!(source.sequences(2).is_empty());
    }
}
