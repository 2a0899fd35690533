//! Code rows that hide each other.
//!
//! Invariant: only a warning, because order and place in the file decide. Facts: reference control-emulator.md 1.2.

use std::cmp::Ordering;

use crate::ident::{CodeId, Name, code_facts};
use crate::index::{IdTable, RegisterId};
use crate::macros::model::Macros;
use crate::rows::{CodeForm, CodeRow, Register};
use crate::tables::{form_range, overlap};
use crate::toml::check::FindingCollector;
use crate::toml::node::DefinitionPlace;

/// Warns about rows for the same word or text, one of which can never match there. A row of a child may take a word by
/// its order from a row of the family: that is meant.
pub(super) fn check_codes(codes: &[CodeRow], registers: &IdTable<RegisterId, Register>, check: &FindingCollector) {
    let mut by_word: Vec<(RegisterId, f64, f64, &CodeRow)> = codes
        .iter()
        .filter(|row| row.enable)
        .filter_map(|row| form_range(&row.form).map(|(register, min, max)| (register, min, max, row)))
        .collect();
    by_word.sort_by_key(|(register, _, _, _)| *register);
    for same in by_word.chunk_by(|a, b| a.0 == b.0) {
        for (index, (register, min, max, row)) in same.iter().enumerate() {
            let hidden = same.iter().enumerate().find(|(at, (_, from, to, other))| {
                let covers = from <= min && max <= to;
                match other.order.cmp(&row.order) {
                    Ordering::Less => covers && other.file == row.file && hides(other, row),
                    Ordering::Equal => *at < index && overlap((*min, *max), (*from, *to)) && hides(other, row),
                    Ordering::Greater => false,
                }
            });
            if let Some((_, (_, _, _, other))) = hidden {
                let letter = &registers[*register].name;
                let written =
                    if min == max { format!("{letter}{min}") } else { format!("{letter}{min}-{letter}{max}") };
                warn(&written, row, other, check);
            }
        }
    }
    let texts = codes.iter().filter(|row| row.enable);
    let texts: Vec<(&str, &CodeRow)> = texts.filter_map(|row| Some((text_of(row)?, row))).collect();
    for (index, (text, row)) in texts.iter().enumerate() {
        let first = |at: usize, other: &CodeRow| match other.order.cmp(&row.order) {
            Ordering::Less => other.file == row.file,
            order => order == Ordering::Equal && at < index,
        };
        let hidden = texts
            .iter()
            .enumerate()
            .find(|(at, (same, other))| same.eq_ignore_ascii_case(text) && first(*at, other) && hides(other, row));
        if let Some((_, (_, other))) = hidden {
            warn(&format!("'{text}'"), row, other, check);
        }
    }
}

fn text_of(row: &CodeRow) -> Option<&str> {
    match &row.form {
        CodeForm::Text(text) => Some(text),
        _ => None,
    }
}

/// Warns about codes of the machine's own that nothing handles.
pub(super) fn check_custom(
    codes: &[CodeRow],
    names: &IdTable<CodeId, Name>,
    macros: Option<&Macros>,
    check: &FindingCollector,
) {
    let mut reported = Vec::new();
    for row in codes.iter().filter(|row| row.enable && row.process) {
        if code_facts(row.id).is_some() {
            continue;
        }
        let name = &names[row.id];
        if !reported.contains(&row.id) && macros.is_none_or(|macros| macros.of_code(row.id).is_empty()) {
            reported.push(row.id);
            let text = format!(
                "{name} is a code of your own and no macro takes it: each use is an error (2900002); a row of \
                 [[macros.code]], or `process = false` to swallow it, is expected"
            );
            check.warning(&DefinitionPlace { file: row.file.as_str().into(), line: row.line, column: 1 }, text);
        }
    }
}

/// Whether the first row is taken whenever the other row could be.
fn hides(first: &CodeRow, other: &CodeRow) -> bool {
    if first.is_twin_of(other) {
        return false; // the same row twice is an error of its own
    }
    let always = first.with.is_empty() && first.without.is_empty();
    always || (first.with == other.with && first.without == other.without)
}

fn warn(written: &str, row: &CodeRow, other: &CodeRow, check: &FindingCollector) {
    let why = match other.order == row.order {
        true => format!("which has the same order {} and comes first", row.order),
        false => format!("whose order {} is less than {}, so that this one never acts", other.order, row.order),
    };
    // A row of a family is replaced, or switched off, by a row with its identifier and word.
    let inherited = other.file != row.file;
    let hint = if inherited {
        "; a row with the `id` and word of that row replaces it, or switches it off with `enable = false`"
    } else {
        ""
    };
    let text = format!("{written} overlaps the row at {}:{}, {why}{hint}", other.file, other.line);
    check.warning(&DefinitionPlace { file: row.file.as_str().into(), line: row.line, column: 1 }, text);
}
