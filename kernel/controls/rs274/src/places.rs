//! Targets of O codes: subprograms, blocks of statements, programs of a file.
//!
//! Facts: LinuxCNC documentation, "O codes": labels of subprograms apply to the whole file, all others to their
//! subprogram or to the main program. *Invariant:* partners are found in the text without executing it, so a jump out
//! of a loop leaves no open block.

use rustc_hash::FxHashMap;

use super::line::{OLabel, OWord, head, label, o_word};
use super::text::{BlockText, Rs274Cursor};
use counterpoint_program::kept::CachedTable;
use counterpoint_program::shape::ProgramRange;
use counterpoint_program::source::ProgramSource;

/// Kind of a block of statements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum OBlockKind {
    If,
    While,
    Do,
    Repeat,
}

/// Lines of a block of statements.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct OBlock {
    pub(super) kind: OBlockKind,
    label: Box<str>,
    pub(super) first: u32,
    /// 0 while the block is open.
    pub(super) last: u32,
    /// Lines of ELSEIF and ELSE.
    pub(super) marks: Vec<u32>,
}

/// A subprogram that is being read: its label, its first line, its open blocks.
type OpenSub = (Box<str>, u32, Vec<usize>);

/// The O codes of a file.
#[derive(Debug, Default)]
pub(super) struct OCodeIndex {
    /// First and last line of subprograms by label.
    subs: FxHashMap<Box<str>, (u32, u32)>,
    /// Last line of the subprogram that begins at a line.
    ends: FxHashMap<u32, u32>,
    /// First line of a subprogram that is defined inside another, by the first line of the outer subprogram.
    nested: FxHashMap<u32, u32>,
    /// First line of programs that M98 calls.
    programs: Vec<(Box<str>, u32)>,
    blocks: Vec<OBlock>,
    /// The block that a line belongs to.
    at: FxHashMap<u32, usize>,
    lines: u32,
}

/// The label and the word of a line's O code.
fn o_code_of(line: &[u8]) -> Option<(Box<str>, OWord)> {
    let text = line.trim_ascii_start();
    if !matches!(text.first(), Some(b'o' | b'O' | b'/' | b'n' | b'N')) {
        return None;
    }
    let text = BlockText::read(line).ok()?;
    let mut cursor = Rs274Cursor::new(&text);
    head(&mut cursor, &mut None).ok()?;
    if !cursor.takes("o") {
        return None;
    }
    match label(&mut cursor).ok()? {
        OLabel::Text(label) => Some((label, o_word(&mut cursor).ok()?)),
        OLabel::Computed(_) => None,
    }
}

impl OCodeIndex {
    /// Indexes a file.
    pub(super) fn of(source: &ProgramSource) -> Self {
        let mut index = Self { lines: source.lines(), ..Self::default() };
        // Open blocks of the main program, and of the subprogram that is being read.
        let mut main: Vec<usize> = Vec::new();
        let mut sub: Option<OpenSub> = None;
        for line in source.walk(1, source.lines()) {
            let Some((label, word)) = o_code_of(source.line(line)) else { continue };
            match word {
                OWord::Sub if sub.is_none() => sub = Some((label, line, Vec::new())),
                OWord::Sub => {
                    if let Some((_, first, _)) = &sub {
                        index.nested.entry(*first).or_insert(line);
                    }
                }
                OWord::EndSub => {
                    if let Some((name, first, _)) = sub.take_if(|(name, ..)| *name == label) {
                        index.ends.insert(first, line);
                        index.subs.entry(name).or_insert((first, line));
                    }
                }
                OWord::Program if sub.is_none() => {
                    index.programs.push((label, line));
                    main.clear();
                }
                _ => index.block(sub.as_mut().map_or(&mut main, |(.., open)| open), label, word, line),
            }
        }
        index
    }

    fn block(&mut self, open: &mut Vec<usize>, label: Box<str>, word: OWord, line: u32) {
        let is = |blocks: &[OBlock], at: usize| blocks.get(at).is_some_and(|block| block.label == label);
        let found = open.iter().rposition(|at| is(&self.blocks, *at));
        let kind = found.and_then(|found| open.get(found)).and_then(|at| self.blocks.get(*at)).map(|block| block.kind);
        let opens = match (word, kind) {
            (OWord::If, None) => Some(OBlockKind::If),
            (OWord::While, None) => Some(OBlockKind::While),
            (OWord::Do, None) => Some(OBlockKind::Do),
            (OWord::Repeat, None) => Some(OBlockKind::Repeat),
            _ => None,
        };
        if let Some(kind) = opens {
            self.at.insert(line, self.blocks.len());
            open.push(self.blocks.len());
            self.blocks.push(OBlock { kind, label, first: line, last: 0, marks: Vec::new() });
            return;
        }
        let (Some(found), Some(kind)) = (found, kind) else { return };
        let Some(&at) = open.get(found) else { return };
        let Some(block) = self.blocks.get_mut(at) else { return };
        match (word, kind) {
            (OWord::EndIf, OBlockKind::If)
            | (OWord::EndWhile, OBlockKind::While)
            | (OWord::While, OBlockKind::Do)
            | (OWord::EndRepeat, OBlockKind::Repeat) => {
                block.last = line;
                open.truncate(found);
            }
            (OWord::ElseIf | OWord::Else, OBlockKind::If) => block.marks.push(line),
            (OWord::Break | OWord::Continue, OBlockKind::While | OBlockKind::Do | OBlockKind::Repeat) => {}
            _ => return,
        }
        self.at.insert(line, at);
    }

    /// The block of statements of a line, if it is complete.
    pub(super) fn block_of(&self, line: u32) -> Option<&OBlock> {
        self.blocks.get(*self.at.get(&line)?).filter(|block| block.last > 0)
    }

    /// First line of the definition inside the subprogram that begins at a line.
    pub(super) fn nested_in(&self, line: u32) -> Option<u32> {
        self.nested.get(&line).copied()
    }

    /// Last line of the subprogram that begins at a line.
    pub(super) fn end_of(&self, line: u32) -> Option<u32> {
        self.ends.get(&line).copied()
    }

    /// Lines of a subprogram.
    pub(super) fn sub(&self, label: &str) -> Option<ProgramRange> {
        self.subs.get(label).map(|(first, last)| ProgramRange { number: None, first: *first, last: *last })
    }

    /// Lines of a program that M98 calls.
    pub(super) fn program(&self, label: &str) -> Option<ProgramRange> {
        let at = self.programs.iter().position(|(known, _)| &**known == label)?;
        let first = self.programs.get(at)?.1;
        let last = self.programs.get(at + 1).map_or(self.lines, |(_, next)| next - 1);
        Some(ProgramRange { number: None, first, last })
    }

    /// Whether a program that M98 calls, other than the first of the file, begins at a line.
    pub(super) fn begins_program(&self, line: u32) -> bool {
        self.programs.iter().any(|(_, first)| *first == line)
    }
}

impl CachedTable for OCodeIndex {
    fn bytes(&self) -> usize {
        let marks: usize = self.blocks.iter().map(|block| block.marks.len() * 4 + block.label.len()).sum();
        (self.subs.len() + self.programs.len() + self.blocks.len()) * 120
            + (self.at.len() + self.ends.len() + self.nested.len()) * 16
            + marks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn index(text: &str) -> OCodeIndex {
        OCodeIndex::of(&ProgramSource::new("t", bytes::Bytes::copy_from_slice(text.as_bytes())))
    }

    #[test]
    fn partners_within_the_same_subprogram() {
        let text = "o1 sub\no2 if [1]\no2 else\no2 endif\no1 endsub\no2 do\no3 while [1]\no3 break\no3 endwhile\no2 while [0]\n";
        let index = index(text);
        let lines = |line| index.block_of(line).map(|block| (block.kind, block.first, block.last));
        assert_eq!([2, 3, 4].map(lines), [Some((OBlockKind::If, 2, 4)); 3]);
        assert_eq!([6, 10].map(lines), [Some((OBlockKind::Do, 6, 10)); 2]);
        assert_eq!([7, 8, 9].map(lines), [Some((OBlockKind::While, 7, 9)); 3]);
        assert_eq!((index.end_of(1), index.sub("1").map(|range| (range.first, range.last))), (Some(5), Some((1, 5))));
    }

    #[test]
    fn programs_go_to_the_next_one() {
        let index = index("o1 (main)\nM98 P100\nM30\nO0100\nG0\nM99\no200\nM99\n");
        let range = |label| index.program(label).map(|range| (range.first, range.last));
        assert_eq!(["1", "100", "200", "7"].map(range), [Some((1, 3)), Some((4, 6)), Some((7, 8)), None]);
    }
}
