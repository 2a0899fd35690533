//! Where jumps and calls lead: labels, control blocks, the programs of a file.
//!
//! Facts: reference channel-synchronisation.md 1.7. Decisions: a label is a block number, with or without a colon, or a
//! name in brackets; it is looked for onwards, then from the top of its program. A subprogram `%L NAME` or the main
//! program `%NAME` goes to the next `%`. Invariant: partners are found without running anything, so a jump out of a
//! loop leaves nothing after.

use rustc_hash::FxHashMap;

use super::cursor::{IsgCursor, plain};
use super::line::{BlockHead, head};
use counterpoint_control_api::words::part;
use counterpoint_program::kept::CachedTable;
use counterpoint_program::search::Labels;
use counterpoint_program::shape::ProgramRange;
use counterpoint_program::source::ProgramSource;
use counterpoint_program::syntax::NamedPrograms;

pub(super) const PROGRAMS: NamedPrograms =
    NamedPrograms { defined, called, is_header: |_| false, returns, in_archive: None };

/// A control block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ControlBlockKind {
    If,
    While,
    For,
    Do,
    Repeat,
    Switch,
}

/// Lines of a control block.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct ControlBlock {
    pub(super) kind: ControlBlockKind,
    pub(super) first: u32,
    /// 0 while it is open.
    pub(super) last: u32,
    /// ELSEIF, ELSE, CASE and DEFAULT.
    pub(super) marks: Vec<u32>,
}

/// The items to be found in a file.
#[derive(Debug, Default)]
pub(super) struct IsgFileIndex {
    numbers: Labels<u32>,
    names: Labels<String>,
    blocks: Vec<ControlBlock>,
    /// The control block of a line.
    at: FxHashMap<u32, usize>,
    /// Name, whether it is a local subprogram, first and last line.
    programs: Vec<(String, bool, u32, u32)>,
}

/// Name of the program that begins with a line, and whether it is a local subprogram.
fn program(line: &[u8]) -> Option<(bool, &[u8])> {
    let rest = line.trim_ascii_start().strip_prefix(b"%")?;
    let local = matches!(rest, [b'L' | b'l', b' ' | b'\t', ..]);
    let rest = if local { rest.get(1..)? } else { rest }.trim_ascii_start();
    let length = rest.iter().position(|byte| b" \t\r\n\0(;\"],#$".contains(byte)).unwrap_or(rest.len());
    let name = rest.get(..length)?;
    (!name.is_empty()).then_some((local, name))
}

/// Whether a line is the head of a program.
pub(super) fn is_head(line: &[u8]) -> bool {
    line.trim_ascii_start().first() == Some(&b'%')
}

fn defined(line: &[u8]) -> Option<&[u8]> {
    program(line).map(|(_, name)| name)
}

/// The head of a local subprogram.
fn returns(line: &[u8]) -> bool {
    program(line).is_some_and(|(local, _)| local)
}

/// The local subprogram that a line calls.
fn called(line: &[u8]) -> Option<String> {
    let text = std::str::from_utf8(line).ok()?;
    let at = text.find("LL ")?;
    let before = text.get(..at)?;
    if before.ends_with(|c: char| c.is_ascii_alphabetic()) {
        return None;
    }
    let name = text.get(at + 3..)?.split_ascii_whitespace().next()?;
    Some(name.to_ascii_uppercase())
}

impl IsgFileIndex {
    /// Looks through a file.
    pub(super) fn of(source: &ProgramSource) -> Self {
        let mut places = Self::default();
        let mut open: Vec<usize> = Vec::new();
        for line in source.walk(1, source.lines()) {
            let text = source.line(line);
            if let Some((local, name)) = program(text) {
                open.clear();
                if let Some(previous) = places.programs.last_mut() {
                    previous.3 = line - 1;
                }
                let name = String::from_utf8_lossy(name).to_ascii_uppercase();
                places.programs.push((name, local, line, source.lines()));
                continue;
            }
            let upper = plain(text);
            let mut cursor = IsgCursor::new(&upper);
            let BlockHead { number, label, .. } = head(&mut cursor);
            let digits = |(start, end)| part(&upper, (start + 1, end)).parse().ok();
            if let Some(number) = number.and_then(digits) {
                places.numbers.add(number, line);
            }
            if let Some(label) = label {
                places.names.add(label, line);
            }
            if cursor.take(b'$') {
                let word = cursor.run(|byte| byte.is_ascii_alphabetic());
                let jumps = upper.windows(5).any(|text| text == b"$GOTO");
                places.control(&mut open, word, jumps, line);
            }
        }
        places
    }

    fn control(&mut self, open: &mut Vec<usize>, word: &str, jumps: bool, line: u32) {
        let opened = match word {
            "IF" if !jumps => Some(ControlBlockKind::If),
            "WHILE" => Some(ControlBlockKind::While),
            "FOR" => Some(ControlBlockKind::For),
            "DO" => Some(ControlBlockKind::Do),
            "REPEAT" => Some(ControlBlockKind::Repeat),
            "SWITCH" => Some(ControlBlockKind::Switch),
            _ => None,
        };
        if let Some(kind) = opened {
            self.at.insert(line, self.blocks.len());
            open.push(self.blocks.len());
            self.blocks.push(ControlBlock { kind, first: line, last: 0, marks: Vec::new() });
            return;
        }
        let closed = match word {
            "ENDIF" => Some(ControlBlockKind::If),
            "ENDWHILE" => Some(ControlBlockKind::While),
            "ENDFOR" => Some(ControlBlockKind::For),
            "ENDDO" => Some(ControlBlockKind::Do),
            "UNTIL" => Some(ControlBlockKind::Repeat),
            "ENDSWITCH" => Some(ControlBlockKind::Switch),
            _ => None,
        };
        let kind_of = |at: &usize| self.blocks.get(*at).map(|block| block.kind);
        if let Some(kind) = closed {
            if let Some(at) = open.pop_if(|at| kind_of(at) == Some(kind)) {
                self.at.insert(line, at);
                self.blocks.get_mut(at).into_iter().for_each(|block| block.last = line);
            }
            return;
        }
        let holds = |kind: ControlBlockKind| match word {
            "ELSEIF" | "ELSE" => Some(kind == ControlBlockKind::If),
            "CASE" | "DEFAULT" => Some(kind == ControlBlockKind::Switch),
            // These leave or repeat the innermost loop around them.
            "BREAK" => (kind != ControlBlockKind::If).then_some(true),
            "CONTINUE" => (!matches!(kind, ControlBlockKind::If | ControlBlockKind::Switch)).then_some(true),
            _ => Some(false),
        };
        let found = open.iter().rev().find_map(|at| Some((*at, holds(kind_of(at)?)?)));
        if let Some((at, true)) = found {
            self.at.insert(line, at);
            if !matches!(word, "BREAK" | "CONTINUE") {
                self.blocks.get_mut(at).into_iter().for_each(|block| block.marks.push(line));
            }
        }
    }

    /// The control block of a line, if it is complete.
    pub(super) fn block(&self, line: u32) -> Option<&ControlBlock> {
        self.blocks.get(*self.at.get(&line)?).filter(|block| block.last > 0)
    }

    /// Lines of the program around a line.
    pub(super) fn program(&self, range: ProgramRange, line: u32) -> (u32, u32) {
        let around = self.programs.iter().find(|(.., first, last)| (*first..=*last).contains(&line));
        around.map_or((range.first, range.last), |(.., first, last)| (range.first.max(*first), range.last.min(*last)))
    }

    /// Lines of a local subprogram.
    pub(super) fn subprogram(&self, name: &str) -> Option<ProgramRange> {
        let found = self.programs.iter().find(|(known, local, ..)| *local && known == name);
        found.map(|(.., first, last)| ProgramRange { number: None, first: *first, last: *last })
    }

    /// Lines of the main program of the file; none if no line is its head.
    pub(super) fn main(&self) -> Option<ProgramRange> {
        let found = self.programs.iter().find(|(_, local, ..)| !*local);
        found.map(|(.., first, last)| ProgramRange { number: None, first: *first, last: *last })
    }

    /// Labels by number.
    pub(super) fn numbers(&self) -> &Labels<u32> {
        &self.numbers
    }

    /// Labels by name.
    pub(super) fn names(&self) -> &Labels<String> {
        &self.names
    }
}

impl CachedTable for IsgFileIndex {
    fn bytes(&self) -> usize {
        let labels = self.numbers.bytes() + self.names.bytes();
        let marks: usize = self.blocks.iter().map(|block| block.marks.len()).sum();
        labels + self.blocks.len() * 100 + marks * 4 + self.at.len() * 16 + self.programs.len() * 80
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(text: &str) -> IsgFileIndex {
        IsgFileIndex::of(&ProgramSource::new("t", bytes::Bytes::copy_from_slice(text.as_bytes())))
    }

    #[test]
    fn control_blocks_and_what_leaves_them() {
        let text = "$WHILE P1<3\n$IF P1==1\n$BREAK\n$ELSEIF P1==2\n$CONTINUE\n$ELSE\n$ENDIF\n$ENDWHILE\n$ENDIF\n$DO\n";
        let places = places(text);
        let block = |line| places.block(line).map(|block| (block.kind, block.first, block.last));
        assert_eq!([1, 3, 5, 8].map(block), [Some((ControlBlockKind::While, 1, 8)); 4]);
        assert_eq!([2, 4, 6, 7].map(block), [Some((ControlBlockKind::If, 2, 7)); 4]);
        assert_eq!(places.block(2).map(|block| block.marks.clone()), Some(vec![4, 6]));
        assert_eq!([9, 10].map(block), [None; 2], "a partner is missing");
    }

    #[test]
    fn programs_of_a_file() {
        let places = places("(head)\n%L UP1\nG0\nM17\n%L up2 (two)\nG1\n%MAIN\nLL UP1\nM30\n");
        let lines = |range: Option<ProgramRange>| range.map(|range| (range.first, range.last));
        assert_eq!(lines(places.subprogram("UP1")), Some((2, 4)));
        assert_eq!(lines(places.subprogram("UP2")), Some((5, 6)));
        assert_eq!((lines(places.main()), lines(places.subprogram("MAIN"))), (Some((7, 9)), None));
        assert_eq!(defined(b"% kanal_1"), Some(&b"kanal_1"[..]));
        assert_eq!((defined(b"%"), defined(b"G0")), (None, None));
        assert!(returns(b"%L UP1") && !returns(b"%LATHE") && !returns(b"%MAIN"));
        assert_eq!(called(b"N10 LL UP1 P5").as_deref(), Some("UP1"));
        assert_eq!(called(b"CALL UP1"), None);
    }
}
