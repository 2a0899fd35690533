//! `[[subprograms.calls]]`: words that call programs.
//!
//! Invariant: no word calls twice, none that calls, returns or waits by itself calls, and a variable that gets a value
//! is a common one of the machine. Facts: reference control-emulator.md 5.4 (calls by G M T S B); that a word calls is
//! a parameter of the control, so the machine says it.

use super::digits;
use super::word::{self, CodeWord, CodeWordError};
use crate::ident::codes;
use crate::index::{IdTable, RegisterId};
use crate::model::{CallHow, ProgramVariables, WordCall};
use crate::preprocessor::Preprocessor;
use crate::rows::{CodeRow, Register};
use crate::tables::{form_range, overlap};
use crate::toml::section::TableReader;

/// Most rows of the table.
const MOST: usize = 1000;

/// Largest program number, and largest value of a word.
const LARGEST: u32 = 99_999_999;

/// G words of the pre-processor's own calls.
const OWN: [f64; 4] = [65.0, 66.0, 66.1, 67.0];

/// The references of the rows.
pub(super) struct Around<'a> {
    pub(super) registers: &'a IdTable<RegisterId, Register>,
    pub(super) codes: &'a [CodeRow],
    pub(super) variables: &'a ProgramVariables,
    pub(super) preprocessor: Preprocessor,
}

/// Reads the rows in file order.
pub(super) fn read(section: &mut TableReader<'_>, around: &Around<'_>) -> Vec<WordCall> {
    let mut calls: Vec<WordCall> = Vec::new();
    for mut row in section.rows("calls", "[[subprograms.calls]]", MOST) {
        let call = read_row(&mut row, around);
        if let Some(call) = &call {
            check(&row, call, &calls, around);
        }
        row.finish();
        calls.extend(call);
    }
    if !calls.is_empty() && !around.preprocessor.row().calls_by_word {
        let able = Preprocessor::all().map(Preprocessor::row).filter(|row| row.calls_by_word);
        let able: Vec<String> = able.map(|row| format!("`preprocessor = \"{}\"`", row.name)).collect();
        section.error("calls", format!("words call programs only with {} in [ce]", able.join(" or ")));
    }
    calls
}

fn read_row(row: &mut TableReader<'_>, around: &Around<'_>) -> Option<WordCall> {
    row.require("word", "a letter, a word, or a range of words");
    row.require("program", "the number of the program that is called");
    let enable = row.flag("enable").unwrap_or(true);
    let word = read_word(row, around.registers);
    let program = row.integer("program", 1..=i64::from(LARGEST)).and_then(|number| u32::try_from(number).ok());
    let consecutive = row.flag("consecutive").unwrap_or(false);
    let ways = [
        ("macro", CallHow::Macro),
        ("subprogram", CallHow::Subprogram),
        ("modal", CallHow::Moves),
        ("modal-each", CallHow::Blocks),
    ];
    row.require("as", "how it calls: \"macro\", \"subprogram\", \"modal\" or \"modal-each\"");
    let how = row.choice("as", &ways);
    let variable = row.integer("variable", 100..=99_999).and_then(|number| u32::try_from(number).ok());
    let CodeWord { register, min, max } = word?;
    let (line, file) = (row.place().line, row.place().file.to_string());
    let call = WordCall { register, min, max, program: program?, consecutive, how: how?, variable, line, file };
    enable.then_some(call)
}

/// A word, a range, or a letter alone: every value of it.
fn read_word(row: &mut TableReader<'_>, registers: &IdTable<RegisterId, Register>) -> Option<CodeWord> {
    let text = row.text("word")?;
    let alone = registers.find(|register| register.name == text);
    let parsed = match alone {
        Some(register) => Ok(CodeWord { register, min: f64::NEG_INFINITY, max: f64::INFINITY }),
        None => word::parse(text, registers),
    };
    match parsed {
        Ok(word) => {
            let register = &registers[word.register];
            if let Some(complaint) = digits::complaint(text, word.min, register) {
                row.warning("word", complaint);
            }
            Some(word)
        }
        Err(CodeWordError::Form(text)) => {
            row.error("word", text);
            None
        }
        Err(CodeWordError::Register(letters)) => {
            row.error("word", format!("no register has the name \"{}\"", letters.escape_debug()));
            None
        }
    }
}

fn check(row: &TableReader<'_>, call: &WordCall, before: &[WordCall], around: &Around<'_>) {
    let range = (call.min, call.max);
    let letter = around.registers[call.register].name.as_str();
    let same = |other: &&WordCall| other.register == call.register && overlap(range, (other.min, other.max));
    if let Some(other) = before.iter().find(same) {
        row.error("word", format!("the word already calls O{:04} at {}:{}", other.program, other.file, other.line));
    }
    if letter.len() != 1 || ["N", "O", "L", "P"].contains(&letter) {
        row.error("word", format!("words of {letter} cannot call a program"));
    }
    if letter == "G" && OWN.iter().any(|own| overlap(range, (*own, *own))) {
        row.error("word", "G65, G66, G66.1 and G67 are calls of the pre-processor");
    }
    let fixed = [codes::CALSUB_ID, codes::CALSUB_RANGE, codes::CALSUB_RETURN, codes::SYNC_REG];
    let taken = around.codes.iter().filter(|code| code.enable && fixed.contains(&code.id)).find(|code| {
        form_range(&code.form)
            .is_some_and(|(register, min, max)| register == call.register && overlap(range, (min, max)))
    });
    if let Some(code) = taken {
        let what = if code.id == codes::SYNC_REG { "is a waiting code" } else { "calls or returns" };
        row.error("word", format!("the word {what} by the row at {}:{}", code.file, code.line));
    }
    if letter != "G" && matches!(call.how, CallHow::Moves | CallHow::Blocks) {
        row.error("as", "only G words call modally");
    }
    if call.consecutive && f64::from(call.program) + (call.max - call.min) > f64::from(LARGEST) {
        row.error("consecutive", format!("the last word of the range would call a program beyond {LARGEST}"));
    }
    let common = |number: &u32| {
        let ProgramVariables { shared, channel, .. } = around.variables;
        shared.iter().chain(channel).any(|(first, last)| (first..=last).contains(&number))
    };
    if let Some(number) = call.variable.filter(|number| !common(number)) {
        row.error("variable", format!("#{number} is not a common variable of [variables]"));
    }
}
