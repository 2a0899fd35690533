//! The programs of the heads in one file: codes of heads divide it.
//!
//! Facts: reference control-emulator.md 1.5 (Output Format #9, HEAD #10), 8.1: the side program is appended to the main
//! one; programs are distinguished by codes (`CODE_HEAD_MAIN`, `CODE_HEAD_SIDE`) or by values (`CODE_HEAD_ID` with
//! `REG_HEAD_ID`). Decisions: lines before the first head belong to its program, a head whose code comes again continues;
//! coming back to an earlier head is refused, since a channel runs one stretch of lines. Only the text up to the second
//! definition word is divided, so subprograms may follow.

use super::shape::Range;
use super::source::Source;
use crate::block::Block;
use crate::scan::Scanner;
use counterpoint_machine::Machine;
use counterpoint_machine::ident::{CodeId, codes, data};
use counterpoint_machine::index::CodeRowId;

/// Stretches of a program by head, in order; none if no code of a head stands in it. A head that comes back is the
/// error, with its line.
pub(super) fn divide(machine: &Machine, source: &Source, range: Range) -> Result<Vec<(u16, Range)>, (u16, u32)> {
    let mut found: Vec<(u16, Range)> = Vec::new();
    let scanner = Scanner::new(machine, source.syntax(), &[]);
    let mut block = Block::default();
    for line in source.walk(range.first, range.last) {
        scanner.scan_as(source.line(line), false, &mut block, false);
        let Some(head) = head_of(machine, &block) else { continue };
        match found.last_mut() {
            Some((last, _)) if *last == head => {}
            None => found.push((head, range)),
            Some((_, previous)) => {
                previous.last = line - 1;
                if found.iter().any(|(known, _)| *known == head) {
                    return Err((head, line));
                }
                found.push((head, Range { first: line, ..range }));
            }
        }
    }
    Ok(found)
}

/// Channel of the head that a block names.
fn head_of(machine: &Machine, block: &Block) -> Option<u16> {
    let written = block
        .words
        .iter()
        .filter_map(|word| machine.tables.code(word.register, word.value).iter().find_map(|&row| code(machine, row)));
    let texts = block.texts.iter().filter_map(|&row| code(machine, row));
    written.chain(texts).find_map(|id| match id {
        codes::HEAD_MAIN => Some(1),
        codes::HEAD_SIDE => Some(2),
        codes::HEAD_ID => value(machine, block),
        _ => None,
    })
}

fn code(machine: &Machine, row: CodeRowId) -> Option<CodeId> {
    let row = &machine.codes[row];
    row.process.then_some(row.id)
}

fn value(machine: &Machine, block: &Block) -> Option<u16> {
    let rows = machine.data.iter().filter(|row| row.id == data::HEAD_ID && row.enable && row.process);
    let mut values = rows.filter_map(|row| {
        let word = block.words.iter().find(|word| Some(word.register) == row.register)?;
        Some(word.value * row.mul + row.add)
    });
    values.next().filter(|value| (1.0..=99.0).contains(value) && value.fract() == 0.0).map(|value| value as u16)
}
