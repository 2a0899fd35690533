//! Axis words beside statements that take none: cycles, transformations, files, axes and channels.
//!
//! Decisions, as no page of a manual was found: a call of a predefined procedure needs a block of its own, and the alarm
//! is 12080. Only axis words are refused, since no other word moves anything. Marks (SETM, CLEARM,
//! WAITM, WAITMC), WAITS, FGROUP, MSG, STOPRE and calls of the user's subprograms are not refused: they occur beside
//! moves. *Invariant:* a block that is refused moves nothing.

use super::item::SiemensItem;

/// Procedures of the control.
const PROCEDURES: [&str; 22] = [
    "AXTOCHAN", "CANCEL", "CONTPRON", "DELETE", "EXECUTE", "GEOAX", "GET", "GETD", "INIT", "ORIRESET", "READ",
    "RELEASE", "SETAL", "SETMS", "START", "TRACYL", "TRAFOOF", "TRANSMIT", "TRAORI", "WAITE", "WAITP", "WRITE",
];

/// Cycles of the control: the start of their names, before a number or a list of arguments.
const CYCLES: [&str; 6] = ["CYCLE", "HOLES", "POCKET", "SLOT", "LONGHOLE", "GROUP_"];

/// The statement and the axis word that cannot be in one block.
pub(super) fn axis_beside_statement(items: &[SiemensItem]) -> Option<(String, String)> {
    let statement = items.iter().find_map(|item| match item {
        SiemensItem::Function(name, _) | SiemensItem::Bare(name) => {
            Some(name.to_ascii_uppercase()).filter(|name| takes_no_axes(name))
        }
        _ => None,
    })?;
    let axis = items.iter().find_map(|item| match item {
        SiemensItem::Text(text) if is_axis(text) => Some(text.clone()),
        SiemensItem::Set { name, .. } if is_axis(&name.name) => Some(name.name.clone()),
        _ => None,
    })?;
    Some((statement, axis))
}

fn takes_no_axes(name: &str) -> bool {
    let is_cycle = || {
        let rest = CYCLES.iter().find_map(|start| name.strip_prefix(start));
        rest.is_some_and(|rest| name.starts_with("GROUP_") || rest.bytes().all(|byte| byte.is_ascii_digit()))
    };
    PROCEDURES.contains(&name) || is_cycle()
}

/// Whether a word is that of an axis: one letter, with or without a number.
fn is_axis(word: &str) -> bool {
    let mut bytes = word.bytes();
    let letter = bytes.next().is_some_and(|byte| matches!(byte.to_ascii_uppercase(), b'A'..=b'C' | b'U'..=b'Z'));
    letter && bytes.next().is_none_or(|byte| !byte.is_ascii_alphabetic() && byte != b'_')
}
