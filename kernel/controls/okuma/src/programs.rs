//! Programs and sequence names in the text of a file, and where a subprogram is.
//!
//! Facts: reference control-emulator.md 5.7. Decisions: a program goes from its name to the next one or to a line with
//! the name of a file; a subprogram is looked for in the current file, in that of the main program, in the files named
//! after it, then in the files of subprograms (`.SSB`, `.SUB`, `.LIB`), first beside the main program, then among those
//! stored with the machine. Invariant: the order of files is that of their ids, so the same job finds the same text.

use super::line::{BlockPrefix, LineReadOptions, is_header, read};
use super::loops::{LoopBuilder, LoopPartners};
use super::names::normal;
use super::text::prepare;
use counterpoint_control_api::words::part;
use counterpoint_program::kept::CachedTable;
use counterpoint_program::search::{LabelSearchOrder, Labels};
use counterpoint_program::shape::ProgramRange;
use counterpoint_program::source::ProgramSource;

/// Ends of the names of files that hold subprograms.
const LIBRARIES: &[&str] = &["ssb", "sub", "lib"];

/// Where the files stored with the machine are.
const STORED: &str = counterpoint_machine::stored::StoredFile::ROOT;

/// A program of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct ProgramDefinition {
    /// Its name without O, as it is compared.
    pub(super) name: String,
    pub(super) first: u32,
    pub(super) last: u32,
}

/// The definitions of a file.
#[derive(Debug, Default)]
pub(super) struct Index {
    pub(super) definitions: Vec<ProgramDefinition>,
    /// Lines by sequence number or name without N, ascending.
    labels: Labels<String>,
    /// Lines continue those above them.
    pub(super) continues: bool,
    /// WHILE, DO and END.
    pub(super) loops: LoopPartners,
}

impl Index {
    /// Looks through a file.
    pub(super) fn of(source: &ProgramSource) -> Self {
        let mut index = Self::default();
        let (mut open, mut loops) = (false, LoopBuilder::default());
        for line in source.walk(1, source.lines()) {
            let text = source.line(line);
            if is_header(text) {
                open = false;
                continue;
            }
            index.continues |= super::line::is_continued(text);
            let head = head(text);
            loops.line(source, line, matches!(head, Some(BlockPrefix::Program(_))));
            match head {
                Some(BlockPrefix::Program((start, end))) => {
                    let name = normal(&part(text, (start + 1, end)));
                    index.definitions.push(ProgramDefinition { name, first: line, last: line });
                    open = true;
                }
                Some(BlockPrefix::Number((start, end)) | BlockPrefix::Name((start, end))) => {
                    let label = normal(&part(text, (start + 1, end)));
                    index.labels.add(label, line);
                }
                _ => {}
            }
            if let Some(last) = index.definitions.last_mut().filter(|_| open) {
                last.last = line;
            }
        }
        index.loops = loops.close();
        index
    }

    /// Lines of a program by its name.
    pub(super) fn program(&self, name: &str) -> Option<ProgramRange> {
        let found = self.definitions.iter().find(|definition| definition.name == name)?;
        Some(ProgramRange { number: None, first: found.first, last: found.last })
    }

    /// The line to go to from another one: from there on, otherwise from the top of the program that the line belongs
    /// to.
    pub(super) fn label(&self, name: &str, from: u32, range: ProgramRange) -> Option<u32> {
        // Definitions and lines are in ascending order.
        let at = self.definitions.partition_point(|definition| definition.first <= from);
        let own = at.checked_sub(1).and_then(|at| self.definitions.get(at));
        let next = self.definitions.get(at);
        let first = own.map_or(1, |definition| definition.first).max(range.first);
        let end = next.map_or(u32::MAX, |definition| definition.first.saturating_sub(1));
        let last = if range.last >= range.first { end.min(range.last) } else { end };
        self.labels.find(name, LabelSearchOrder::Around, from, (first, last))
    }
}

impl CachedTable for Index {
    fn bytes(&self) -> usize {
        self.definitions.len() * 60 + self.labels.bytes() + self.loops.len() * 8
    }
}

/// The name or number at the start of a line.
fn head(text: &[u8]) -> Option<BlockPrefix> {
    let start = text.iter().copied().find(|byte| !matches!(byte, b' ' | b'\t' | b'/' | b'1'..=b'9'))?;
    if !matches!(start, b'N' | b'n' | b'O' | b'o') {
        return None;
    }
    // Only the head is wanted, so nothing after it may be a mistake.
    let line = read(prepare(cut(text)), LineReadOptions { subprograms: true, drawing: false, offsets: false }).ok()?;
    line.head.into_iter().find(|head| !matches!(head, BlockPrefix::Mark(_)))
}

/// A line up to the end of its first word with a letter.
fn cut(text: &[u8]) -> &[u8] {
    let from = text.iter().position(u8::is_ascii_alphabetic).unwrap_or(text.len());
    let word = text.get(from..).unwrap_or_default();
    let length = word.iter().position(|byte| !byte.is_ascii_alphanumeric()).unwrap_or(word.len());
    // The next character distinguishes a name from a variable.
    text.get(..(from + length + 1).min(text.len())).unwrap_or_default()
}

/// The name of letters and digits by which a line defines a program, without O; one of digits alone is none.
pub(super) fn program_name(text: &[u8]) -> Option<&[u8]> {
    let Some(BlockPrefix::Program((start, end))) = head(text) else { return None };
    let name = text.get(start as usize + 1..end as usize)?;
    name.iter().any(u8::is_ascii_alphabetic).then_some(name)
}

/// Whether a line returns from a subprogram.
pub(super) fn returns(text: &[u8]) -> bool {
    prepare(text).upper.trim_ascii().ends_with(b"RTS")
}

/// The name that a line calls, seen textually.
pub(super) fn called(text: &[u8]) -> Option<String> {
    let upper = prepare(text).upper;
    let behind = ["CALL", "MODIN"].into_iter().find_map(|word| {
        let at = memchr::memmem::find(&upper, word.as_bytes())?;
        upper.get(at + word.len()..)
    })?;
    let name = behind.trim_ascii_start().strip_prefix(b"O")?;
    let length = name.iter().position(|byte| !byte.is_ascii_alphanumeric()).unwrap_or(name.len());
    Some(normal(std::str::from_utf8(name.get(..length)?).ok()?))
}

/// Files where a subprogram may be, with whether the whole file is it if it defines nothing.
pub(super) fn places(files: &[String], main: &str, name: &str) -> Vec<(usize, bool)> {
    let folder = main.rsplit_once('/').map_or("", |(folder, _)| folder);
    let beside = |file: &str| !file.starts_with(STORED) && file.rsplit_once('/').map_or("", |(f, _)| f) == folder;
    let stored = |file: &str| file.strip_prefix(STORED).is_some_and(|rest| !rest.contains('/'));
    let parts = |file: &str| {
        let file = file.rsplit_once('/').map_or(file, |(_, name)| name).to_owned();
        match file.rsplit_once('.') {
            Some((stem, extension)) => (stem.to_owned(), extension.to_ascii_lowercase()),
            None => (file, String::new()),
        }
    };
    let is_named = |file: &str| {
        let stem = parts(file).0.to_ascii_uppercase();
        normal(&stem) == name || stem.strip_prefix('O').is_some_and(|stem| normal(stem) == name)
    };
    let is_library = |file: &str| LIBRARIES.contains(&parts(file).1.as_str());
    let mut found = Vec::new();
    for near in [&beside as &dyn Fn(&str) -> bool, &stored] {
        let here = || files.iter().enumerate().filter(|(_, file)| near(file));
        found.extend(here().filter(|(_, file)| is_named(file)).map(|(at, _)| (at, true)));
        let libraries = here().filter(|(_, file)| !is_named(file) && is_library(file));
        found.extend(libraries.map(|(at, _)| (at, false)));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn source(text: &str) -> ProgramSource {
        ProgramSource::new("t", bytes::Bytes::copy_from_slice(text.as_bytes()))
    }

    #[test]
    fn programs_and_labels_of_a_file() {
        let source =
            source("$A.MIN%\nOMAIN\nN1 G0\nNA1 CALL OSUB\nN1\nM2\n$B.SSB%\nOSUB\n/2 N0001 G1\nRTS\n(ONO)\nN=5\n");
        let index = Index::of(&source);
        let lines: Vec<_> = index.definitions.iter().map(|d| (d.name.as_str(), d.first, d.last)).collect();
        assert_eq!(lines, [("MAIN", 2, 6), ("SUB", 8, 12)]);
        let all = ProgramRange { number: None, first: 1, last: 12 };
        assert_eq!(index.label("1", 3, all), Some(5));
        assert_eq!(index.label("1", 5, all), Some(3));
        assert_eq!(index.label("1", 8, all), Some(9));
        assert_eq!(index.label("A1", 9, all), None);
    }

    #[test]
    fn what_lines_say_of_programs() {
        assert_eq!(program_name(b" /2 oab (X)"), Some(b"ab".as_slice()));
        assert_eq!(program_name(b"O1000"), None);
        assert_eq!(program_name(b"OA=5"), None);
        assert_eq!(program_name(b"OFF5X"), Some(b"FF5X".as_slice()));
        assert_eq!(called(b"N1 CALL O0012 Q2").as_deref(), Some("12"));
        assert_eq!(called(b"MODIN OAB").as_deref(), Some("AB"));
        assert_eq!(called(b"(CALL OAB)"), None);
        assert!(returns(b"NEND RTS (BACK)") && !returns(b"(RTS)"));
    }

    #[test]
    fn files_of_a_subprogram() {
        let files = ["a/p.min", "a/oab.ssb", "ab.sub", "a/x.lib", "a/y.min", "//ICAMFS/OAB", "//ICAMFS/f/OAB"];
        let files: Vec<String> = files.into_iter().map(str::to_owned).collect();
        assert_eq!(places(&files, "a/p.min", "AB"), [(1, true), (3, false), (5, true)]);
    }
}
