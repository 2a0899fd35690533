//! `[[tape_editor]]`: rules that change the text of blocks.
//!
//! Invariant: every expression compiles. Facts: reference control-emulator.md 5.2.

use counterpoint_lang::pattern::TextPattern;

use crate::model::TapeRule;
use crate::toml::section::TableReader;

/// Most rules of a machine.
const MOST: usize = 256;

/// Longest expression or replacement, characters.
const LONGEST: usize = 1000;

/// Reads the rules in file order.
pub(super) fn read(top: &mut TableReader<'_>) -> Vec<TapeRule> {
    let mut rules = Vec::new();
    for mut row in top.rows("tape_editor", "[[tape_editor]]", MOST) {
        row.require("find", "an expression in the dialect of ed");
        let find = row.text("find").unwrap_or_default().to_owned();
        let replace = row.text("replace").unwrap_or_default().to_owned();
        let on = row.flag("on").unwrap_or(true);
        let words = row.choice("sees", &[("words", true), ("text", false)]).unwrap_or(true);
        for (key, text) in [("find", &find), ("replace", &replace)] {
            if text.chars().count() > LONGEST || text.contains(['\n', '\r']) {
                row.error(key, format!("`{key}` must be one line of up to {LONGEST} characters"));
            }
        }
        if let Err(fault) = TextPattern::new(&find) {
            row.error("find", format!("\"{}\" is not a valid expression: {}", find.escape_debug(), fault.message));
        }
        rules.push(TapeRule { find, replace, on, words, line: row.place().line, file: row.place().file.to_string() });
        row.finish();
    }
    rules
}
