//! `[[refusals]]`: blocks that the control refuses with an alarm.
//!
//! Invariant: a row looks for a code or for the word of a register, and says when that is refused.

use super::names::NameRegistry;
use super::word::{self, CodeWordError};
use crate::ident;
use crate::refusals::{Active, BlockRefusal, CodeReference, WordRule};
use crate::rows::CodeRow;
use crate::toml::node::DefinitionPlace;
use crate::toml::section::TableReader;

/// Most rows of the table.
const MOST: usize = 1000;

/// Keys of a row that is switched off: it only removes that of the family.
const KEYS: [&str; 19] = [
    "alarm", "name", "text", "codes", "implied", "with", "all", "without", "active", "inactive", "register", "min",
    "max", "whole", "point", "most", "zero", "unless", "together",
];

/// Reads the rows in file order.
pub(super) fn read(top: &mut TableReader<'_>, names: &NameRegistry<'_>, codes: &[CodeRow]) -> Vec<BlockRefusal> {
    let mut refusals: Vec<BlockRefusal> = Vec::new();
    for mut row in top.rows("refusals", "[[refusals]]", MOST) {
        if row.flag("enable") == Some(false) {
            for key in KEYS {
                row.node(key);
            }
            row.finish();
            continue;
        }
        let Some(refusal) = read_row(&mut row, names, codes) else {
            row.finish();
            continue;
        };
        if let Some(twin) = refusals.iter().find(|other| other.name == refusal.name) {
            let text = format!("a row of the name {} is already at {}:{}", twin.name, twin.file, twin.line);
            row.error(if row.place_of("name") == row.place() { "alarm" } else { "name" }, text);
        }
        row.finish();
        refusals.push(refusal);
    }
    refusals
}

fn read_row(row: &mut TableReader<'_>, names: &NameRegistry<'_>, codes: &[CodeRow]) -> Option<BlockRefusal> {
    row.require("alarm", "the number of the alarm as the control shows it");
    row.require("text", "what the alarm is about");
    let alarm = row.name("alarm", 32).map(str::to_owned);
    let name = row.name("name", 80).map(str::to_owned).or_else(|| alarm.clone());
    let text = row.name("text", 200).map(str::to_owned);
    let [on, together, unless] = ["codes", "together", "unless"].map(|key| {
        let listed = row.texts(key).unwrap_or_default();
        listed.into_iter().filter_map(|(name, place)| written(name, place, row, names)).collect::<Vec<_>>()
    });
    let implied = row.flag("implied").unwrap_or(false);
    let [with, all, without] = ["with", "all", "without"].map(|key| {
        let listed = row.texts(key).unwrap_or_default();
        let registers = listed.into_iter().filter_map(|(name, place)| names.register(name, place));
        registers.fold(0_u128, |bits, register| bits | register.bit())
    });
    let [active, inactive] = ["active", "inactive"].map(|key| {
        let listed = row.texts(key).unwrap_or_default();
        listed.into_iter().filter_map(|(name, place)| state(name, place, names, codes)).collect::<Vec<_>>()
    });
    let word = word_rule(row, names);
    if on.is_empty() && word.is_none() && row.place_of("codes") == row.place() {
        names.check.error(row.place(), "[[refusals]] needs `codes` or `register`: what it looks for on a block");
    }
    let states = !active.is_empty() || !inactive.is_empty() || !together.is_empty();
    let says = with != 0 || all != 0 || without != 0 || states || word.is_some();
    if !says {
        let text = "[[refusals]] would refuse every block of these codes: it needs `with`, `all`, `without`, `together`, \
                    `active`, `inactive` or `register`";
        names.check.error(row.place(), text);
    }
    Some(BlockRefusal {
        name: name?,
        alarm: alarm?,
        text: text?,
        codes: on,
        implied,
        with,
        all,
        without,
        together,
        unless,
        active,
        inactive,
        word,
        line: row.place().line,
        file: row.place().file.to_string(),
    })
}

/// A code by its identifier or by its word.
fn written(
    name: &str,
    place: &DefinitionPlace,
    row: &TableReader<'_>,
    names: &NameRegistry<'_>,
) -> Option<CodeReference> {
    if name.to_ascii_uppercase().starts_with("CODE_") {
        return names.code(name, place).map(CodeReference::Id);
    }
    match word::parse(name, &names.registers) {
        Ok(word) => Some(CodeReference::Word { register: word.register, min: word.min, max: word.max }),
        Err(CodeWordError::Register(letters)) => {
            names.unknown_register(&letters, place);
            None
        }
        Err(CodeWordError::Form(text)) => {
            row.error_at(place, text);
            None
        }
    }
}

/// A code with the modal group that it has on this machine.
fn state(name: &str, place: &DefinitionPlace, names: &NameRegistry<'_>, codes: &[CodeRow]) -> Option<Active> {
    let id = names.code(name, place)?;
    let row = codes.iter().find(|row| row.id == id).map(|row| row.group);
    let group = row.or_else(|| ident::code_facts(id).map(|facts| facts.group)).unwrap_or(0);
    if group == 0 {
        names.check.error(place, format!("{} has no modal group, it is never active", name.escape_debug()));
        return None;
    }
    Some(Active { group, id })
}

fn word_rule(row: &mut TableReader<'_>, names: &NameRegistry<'_>) -> Option<WordRule> {
    let name = row.text("register");
    let place = row.place_of("register").clone();
    let register = name.and_then(|name| names.register(name, &place));
    let min = row.number("min");
    let max = row.number("max");
    let whole = row.flag("whole").unwrap_or(false);
    let pointed = row.flag("point").unwrap_or(true);
    let most = row.integer("most", 1..=99).map(|most| most as u8);
    let zero = row.flag("zero").unwrap_or(false);
    let says = zero || min.is_some() || max.is_some() || whole || !pointed || most.is_some();
    match (name.is_some(), says) {
        (true, false) => row.error("register", "`register` needs `min`, `max`, `zero`, `whole`, `point` or `most`"),
        (false, true) => {
            row.error("register", "`min`, `max`, `zero`, `whole`, `point` and `most` are about a `register`")
        }
        _ => {}
    }
    Some(WordRule {
        register: register?,
        min: min.unwrap_or(f64::NEG_INFINITY),
        max: max.unwrap_or(f64::INFINITY),
        zero,
        whole,
        pointed,
        most,
    })
}
