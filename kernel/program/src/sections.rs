//! Sections of a file that belong to channels: they alternate, and all sections of one channel are one program.
//!
//! Facts: reference channel-synchronisation.md 1.5 (`G13`, `G14`), 1.6 (`$1`, `$2`, `$0` for data of all);
//! control-emulator.md 1.5 (Output Format #9, HEAD #10), 8.1. Decisions: with codes of heads the main program of the
//! file is divided, text before the first head belongs to that head, and subprograms after it belong to all channels.
//! With `$n` text before the first section is shared, and so is a program that is defined after the end code of a
//! section, up to the next section. *Invariant:* each line belongs to one section or to all channels; a channel sees
//! the lines of others as empty, so that a line has one number for all channels.

use std::sync::Arc;

use bytes::{BufMut, Bytes, BytesMut};
use counterpoint_event::info::FileSection;
use counterpoint_machine::Machine;
use counterpoint_machine::habits::FileLayout;
use counterpoint_machine::ident::{codes, data};
use counterpoint_machine::index::CodeRowId;
use counterpoint_machine::rows::CodeForm;

use super::callers::Callers;
use super::mains::mains;
use super::shape::{ProgramDelimiters, ProgramRange};
use super::source::ProgramSource;
use crate::block::{Block, Word};
use crate::scan::LineScanner;
use counterpoint_ports::control::StopSignal;

/// A file as a machine reads it: with the stretches that belong to its channels.
#[must_use]
pub fn source(
    name: impl Into<String>,
    bytes: Bytes,
    shape: Arc<ProgramDelimiters>,
    stop: StopSignal,
    machine: &Machine,
) -> ProgramSource {
    let whole = ProgramSource::shaped(name, bytes, shape, stop);
    let sections = divide(machine, &whole);
    let views = views(&whole, &sections);
    whole.divided(sections, views)
}

/// The stretches of a file, in order, as the machine divides its files; none if it does not.
fn divide(machine: &Machine, source: &ProgramSource) -> Vec<FileSection> {
    match machine.habits.programs {
        FileLayout::Numbers => Vec::new(),
        FileLayout::Heads => by_heads(machine, source),
        FileLayout::Sections => by_marks(machine, source),
    }
}

/// The view that each channel has of a divided file.
fn views(source: &ProgramSource, sections: &[FileSection]) -> Vec<(u16, Arc<ProgramSource>)> {
    let mut channels: Vec<u16> = sections.iter().map(|section| section.channel).filter(|&c| c > 0).collect();
    channels.sort_unstable();
    channels.dedup();
    let view = |channel| (channel, Arc::new(source.with_text(seen_by(source, sections, channel).freeze())));
    channels.into_iter().map(view).collect()
}

/// Whether the last stretch of a program for all heads belongs to another channel and has the end code of the program.
#[must_use]
pub fn ends_for_all(machine: &Machine, source: &ProgramSource, channel: u16) -> bool {
    let heads = machine.habits.programs == FileLayout::Heads;
    source.sections().last().filter(|last| heads && last.channel != channel).is_some_and(|last| {
        let range = ProgramRange { number: None, first: last.lines.0, last: last.lines.1 };
        Callers::of(machine, source.syntax()).ends_in(source, range)
    })
}

/// The text of a file without the lines of other channels, and without the marks of sections.
fn seen_by(source: &ProgramSource, sections: &[FileSection], channel: u16) -> BytesMut {
    let mut text = BytesMut::with_capacity(source.size() / 2);
    let mut ahead = sections.iter().peekable();
    for line in source.walk(1, source.lines()) {
        while ahead.next_if(|section| section.lines.1 < line).is_some() {}
        let own = ahead.peek().filter(|section| section.lines.0 <= line);
        let bytes = source.line(line);
        if own.is_none_or(|section| section.channel == channel) || source.is_stop(line) {
            let mark = mark(bytes).filter(|_| own.is_some_and(|section| section.name.starts_with('$')));
            let after = mark.map_or(0, |(_, after)| after);
            text.put_bytes(b' ', after);
            text.extend_from_slice(bytes.get(after..).unwrap_or_default());
        }
        text.put_u8(b'\n');
    }
    text
}

/// Channel of the mark that a line begins with, and where the text after it begins.
fn mark(line: &[u8]) -> Option<(u16, usize)> {
    let at = line.iter().position(|byte| !byte.is_ascii_whitespace())?;
    let rest = line.get(at..)?.strip_prefix(b"$")?;
    let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let number = std::str::from_utf8(rest.get(..digits)?).ok()?.parse().ok().filter(|number| *number <= 99)?;
    let next = rest.get(digits);
    next.is_none_or(|byte| byte.is_ascii_whitespace() || *byte == b'(').then_some((number, at + 1 + digits))
}

/// `$1`, `$2`, …: the programs of channels, `$0`: data of all.
fn by_marks(machine: &Machine, source: &ProgramSource) -> Vec<FileSection> {
    let mut found: Vec<FileSection> = Vec::new();
    let mut callers = None;
    let mut open = false;
    let mut ended = false;
    for line in source.walk(1, source.lines()) {
        let bytes = source.line(line);
        if let Some((channel, _)) = mark(bytes) {
            found.push(FileSection { channel, name: format!("${channel}").into(), lines: (line, line) });
            (open, ended) = (true, false);
        } else if open && ended && source.defines(line) {
            open = false;
        } else if let Some(last) = found.last_mut().filter(|_| open) {
            last.lines.1 = line;
        }
        if open && !ended {
            let callers = callers.get_or_insert_with(|| Callers::of(machine, source.syntax()));
            ended = callers.ends_in(source, ProgramRange { number: None, first: line, last: line });
        }
    }
    found
}

/// Stretches of the main program by head, in order; none if no code of a head is in it.
fn by_heads(machine: &Machine, source: &ProgramSource) -> Vec<FileSection> {
    let Some(range) = mains(source, &Callers::of(machine, source.syntax())).first().copied() else { return Vec::new() };
    let mut found: Vec<FileSection> = Vec::new();
    let scanner = LineScanner::new(machine, source.syntax(), &[]);
    let mut block = Block::default();
    for line in source.walk(range.first, range.last) {
        let text = source.line(line);
        scanner.scan_as(text, false, &mut block, false);
        if let Some((channel, name)) = head_of(machine, &block, text)
            && found.last().is_none_or(|last| last.channel != channel)
        {
            // A definition before the first head belongs to all channels, so that labels and calls find their program.
            let before = found.is_empty().then(|| range.first + u32::from(source.defines(range.first)));
            found.push(FileSection { channel, name, lines: (before.unwrap_or(line).min(line), line) });
        } else if let Some(last) = found.last_mut() {
            last.lines.1 = line;
        }
    }
    found
}

/// Channel of the head that a block names, and the words that do.
fn head_of(machine: &Machine, block: &Block, line: &[u8]) -> Option<(u16, Box<str>)> {
    let text = |word: &Word| {
        String::from_utf8_lossy(line.get(word.start as usize..word.end as usize).unwrap_or_default()).into_owned()
    };
    let code = |row: CodeRowId| Some(&machine.codes[row]).filter(|row| row.process).map(|row| row.id);
    let written = block.words.iter().flat_map(|word| {
        let rows = machine.tables.code(word.register, word.value);
        rows.iter().filter_map(move |&row| Some((code(row)?, text(word))))
    });
    let texts = block.texts.iter().filter_map(|&row| match &machine.codes[row].form {
        CodeForm::Text(text) => Some((code(row)?, text.clone())),
        _ => None,
    });
    written.chain(texts).find_map(|(id, name)| match id {
        codes::HEAD_MAIN => Some((1, name.into())),
        codes::HEAD_SIDE => Some((2, name.into())),
        codes::HEAD_ID => {
            let (channel, word) = value(machine, block)?;
            Some((channel, format!("{name}{}", text(&word)).into()))
        }
        _ => None,
    })
}

/// Channel that the word of a head says, and that word.
fn value(machine: &Machine, block: &Block) -> Option<(u16, Word)> {
    let rows = machine.data.iter().filter(|row| row.id == data::HEAD_ID && row.enable && row.process);
    let mut values = rows.filter_map(|row| {
        let word = block.words.iter().find(|word| Some(word.register) == row.register)?;
        Some((word.value * row.mul + row.add, *word))
    });
    let (value, word) = values.next()?;
    ((1.0..=99.0).contains(&value) && value.fract() == 0.0).then_some((value as u16, word))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_of_sections() {
        assert_eq!(mark(b"$1"), Some((1, 2)));
        assert_eq!(mark(b"  $12 G4 P1"), Some((12, 5)));
        assert_eq!(mark(b"$0(data)"), Some((0, 2)));
        for line in [&b"$"[..], b"$A", b"$1A", b"$MC_X", b"G0 $1", b"$123", b"$99999999999"] {
            assert_eq!(mark(line), None);
        }
    }

    #[test]
    fn a_channel_sees_its_own_lines_and_those_of_all() {
        let text = "%\nO1\n$1 G0\nM30\n$2\nM30\n%\n";
        let source = ProgramSource::new("t", text.into());
        let section = |channel: u16, lines| FileSection { channel, name: format!("${channel}").into(), lines };
        let sections = [section(1, (3, 4)), section(2, (5, 7))];
        let seen = |channel| String::from_utf8(seen_by(&source, &sections, channel).to_vec()).unwrap();
        assert_eq!(seen(1), "%\nO1\n   G0\nM30\n\n\n%\n");
        assert_eq!(seen(2), "%\nO1\n\n\n  \nM30\n%\n");
    }
}
