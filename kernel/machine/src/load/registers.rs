//! `[[registers]]`: the letters of a program.
//!
//! Invariant: names, second names and indexes are unique. Facts: reference control-emulator.md 1.4.

use crate::index::{IdTable, RegisterId};
use crate::rows::{DecimalPointRule, Excess, NumberFormat, Register, ZeroRule};
use crate::toml::check::FindingCollector;
use crate::toml::section::TableReader;

/// Most registers of a machine.
const MOST: usize = 99;

/// Reads the rows; the list is in ascending index.
pub(super) fn read(top: &mut TableReader<'_>, check: &FindingCollector) -> IdTable<RegisterId, Register> {
    top.require("registers", "the letters of the program");
    let mut registers: Vec<Register> = Vec::new();
    for row in top.rows("registers", "[[registers]]", MOST) {
        if let Some(register) = read_row(row, &registers, check) {
            registers.push(register);
        }
    }
    registers.sort_by_key(|register| register.index);
    registers.into_iter().collect()
}

/// Settings of `[control]` for numbers of coordinates: signed registers with digits after the point.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct CoordinateSettings {
    /// Without a point they count units of their last digit.
    pub increments: bool,
    /// Digits after the last one of the register.
    pub excess: Excess,
    /// Those with eight digits have one more before the point.
    pub nine: bool,
}

/// Changes the formats of coordinates.
pub(super) fn change_coordinates(registers: &mut IdTable<RegisterId, Register>, rule: CoordinateSettings) {
    for register in registers.iter_mut().filter(|register| register.signed && register.pointed) {
        for format in [&mut register.format, &mut register.secondary].into_iter().filter(|format| format.frac > 0) {
            format.excess = rule.excess;
            if rule.nine && format.whole + format.frac == 8 {
                format.whole += 1;
            }
            if rule.increments {
                (format.point, format.lead, format.trail) = (DecimalPointRule::Omit, ZeroRule::Omit, ZeroRule::Keep);
            }
        }
        register.counts = rule.increments;
    }
}

fn read_row(mut row: TableReader<'_>, known: &[Register], check: &FindingCollector) -> Option<Register> {
    row.require("name", "a capital letter, or text for a special register");
    let name = register_name(&mut row, "name");
    let second = register_name(&mut row, "second");
    for (key, text) in [("name", &name), ("second", &second)] {
        if let Some(text) = text
            && known.iter().any(|other| other.name == *text || other.second.as_ref() == Some(text))
        {
            check.error(row.place_of(key), format!("there is already a register with the name \"{text}\""));
        }
    }
    if name.is_some() && name == second {
        row.error("second", "`second` must differ from `name`");
    }
    let next = known.last().map_or(1, |last| last.index.saturating_add(1)).min(MOST as u8);
    let index = row.integer("index", 1..=MOST as i64).map_or(next, |index| index as u8);
    if let Some(other) = known.iter().find(|other| other.index == index) {
        row.error("index", format!("index {index} already belongs to register {}", other.name));
    }
    let before = special_text(&mut row, "before").or_else(|| name.as_deref().map(characters));
    let after = special_text(&mut row, "after").unwrap_or_default();
    let same = |other: &&Register| Some(&other.before) == before.as_ref() && other.after == after;
    if let Some(other) = known.iter().find(same).filter(|other| Some(&other.name) != name.as_ref()) {
        let around = "the same texts around its number, so that words of both look the same";
        row.error("before", format!("register {} has {around}", other.name));
    }
    let second = second.as_deref().map(characters);
    let format = number_format(&mut row);
    let secondary = secondary_format(&mut row, format);
    let increment = row.above_zero("increment");
    let signed = row.flag("signed").unwrap_or(false);
    let pointed = row.flag("pointed").unwrap_or(true);
    let names = row.flag("names").unwrap_or(false);
    if names && (after.is_empty() || before.as_deref().is_none_or(str::is_empty)) {
        row.error("names", "a register of names needs `before` and `after`, the texts around the name");
    }
    row.finish();
    let (name, before) = (name?, before?);
    Some(Register {
        index,
        name,
        second,
        before,
        after,
        format,
        secondary,
        increment,
        signed,
        pointed,
        names,
        counts: false,
    })
}

/// Text around the number of a special register; the empty text is one.
fn special_text(row: &mut TableReader<'_>, key: &'static str) -> Option<String> {
    let text = characters(row.text(key)?);
    if text.len() > 16 || text.ends_with(|c: char| key == "before" && (c.is_ascii_digit() || c == '.')) {
        row.error(key, format!("`{key}` must be up to 16 characters, and not end in a digit before the number"));
        return None;
    }
    Some(text)
}

/// `^nnn` is the character with this number.
fn characters(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some((plain, code)) = rest.split_once('^') {
        out.push_str(plain);
        let number = code.get(..3).filter(|digits| digits.bytes().all(|b| b.is_ascii_digit()));
        match number.and_then(|digits| digits.parse::<u8>().ok()) {
            Some(number) => {
                out.push(char::from(number));
                rest = code.get(3..).unwrap_or_default();
            }
            None => {
                out.push('^');
                rest = code;
            }
        }
    }
    out.push_str(rest);
    out
}

fn register_name(row: &mut TableReader<'_>, key: &'static str) -> Option<String> {
    let name = row.name(key, 16)?;
    let one_other = name.len() == 1 && !name.chars().all(|c| c.is_ascii_uppercase());
    if one_other || !name.chars().all(|c| c.is_ascii_graphic()) || name.starts_with(|c: char| c.is_ascii_digit()) {
        let expected = "one capital letter, or a longer name of ASCII characters that does not start with a digit";
        row.error(key, format!("`{key}` must be {expected}, not \"{}\"", name.escape_debug()));
        return None;
    }
    Some(name.to_owned())
}

fn number_format(row: &mut TableReader<'_>) -> NumberFormat {
    row.require("whole", "digits before the point");
    let whole = row.integer("whole", 0..=9).unwrap_or(9) as u8;
    let frac = row.integer("frac", 0..=9).unwrap_or(0) as u8;
    let points = [
        ("keep", DecimalPointRule::Keep),
        ("fractional", DecimalPointRule::Fractional),
        ("omit", DecimalPointRule::Omit),
    ];
    let zeros = [("keep", ZeroRule::Keep), ("one", ZeroRule::One), ("omit", ZeroRule::Omit)];
    NumberFormat {
        whole,
        frac,
        point: row.choice("point", &points).unwrap_or(DecimalPointRule::Fractional),
        lead: row.choice("lead", &zeros).unwrap_or(ZeroRule::Omit),
        trail: row.choice("trail", &zeros).unwrap_or(ZeroRule::Omit),
        plus: row.flag("plus").unwrap_or(false),
        excess: Excess::default(),
    }
}

fn secondary_format(row: &mut TableReader<'_>, primary: NumberFormat) -> NumberFormat {
    let Some(mut section) = row.table("secondary", "secondary of [[registers]]") else { return primary };
    let whole = section.integer("whole", 0..=9).map_or(primary.whole, |whole| whole as u8);
    let frac = section.integer("frac", 0..=9).map_or(primary.frac, |frac| frac as u8);
    section.finish();
    NumberFormat { whole, frac, ..primary }
}
