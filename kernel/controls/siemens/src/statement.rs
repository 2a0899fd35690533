//! Statements that name labels or programs, read: jumps, repetitions, CASE, and calls by a text.
//!
//! Facts: reference control-emulator.md 5.4. Invariant: a label stays a name until the block runs, since a variable of
//! type STRING may have that name.

use super::compiled::Expression;
use super::cursor::{SiemensCursor, in_name};
use super::expression::{arguments, expression, unexpected};
use super::item::{JumpDirection, SiemensItem, SiemensJump, SiemensJumpTarget, Structure};
use super::value::Data;

pub(super) const JUMPS: [(&str, JumpDirection); 5] = [
    ("GOTO", JumpDirection::Either),
    ("GOTOF", JumpDirection::Forward),
    ("GOTOB", JumpDirection::Back),
    ("GOTOC", JumpDirection::Silent),
    ("GOTOS", JumpDirection::Start),
];

pub(super) fn direction(name: &str) -> Option<JumpDirection> {
    JUMPS.iter().find(|(text, _)| text.eq_ignore_ascii_case(name)).map(|(_, direction)| *direction)
}

pub(super) fn jump(cursor: &mut SiemensCursor<'_>, direction: JumpDirection) -> Result<SiemensJump, String> {
    let target = if direction == JumpDirection::Start { SiemensJumpTarget::Number(0) } else { label(cursor)? };
    Ok(SiemensJump { direction, target })
}

/// A label as statements name it.
fn label(cursor: &mut SiemensCursor<'_>) -> Result<SiemensJumpTarget, String> {
    cursor.blanks();
    let before = cursor.clone();
    if matches!(cursor.byte(0), b'N' | b'n' | b':') {
        cursor.step();
    }
    let digits = cursor.digits();
    if !digits.is_empty() && !in_name(cursor.byte(0)) && !joined(cursor) {
        return digits
            .parse()
            .map(SiemensJumpTarget::Number)
            .map_err(|_| format!("{digits} is not a valid block number"));
    }
    *cursor = before.clone();
    if let Some(name) = cursor.name()
        && !matches!(cursor.byte(0), b'(' | b'[')
        && !joined(cursor)
    {
        return Ok(SiemensJumpTarget::Name(name.to_ascii_uppercase()));
    }
    *cursor = before;
    Ok(SiemensJumpTarget::Value(expression(cursor)?))
}

fn joined(cursor: &SiemensCursor<'_>) -> bool {
    cursor.rest().trim_start().starts_with("<<")
}

pub(super) fn repeat(cursor: &mut SiemensCursor<'_>, one_block: bool) -> Result<SiemensItem, String> {
    cursor.blanks();
    if cursor.is_at_end() && !one_block {
        return Ok(SiemensItem::Structure(Structure::Repeat));
    }
    let first = label(cursor)?;
    let is_passes = |cursor: &SiemensCursor<'_>| {
        let rest = cursor.rest().trim_start().as_bytes();
        rest.is_empty()
            || (rest.first().is_some_and(|byte| byte.eq_ignore_ascii_case(&b'P'))
                && rest.get(1).is_none_or(|byte| matches!(byte, b'=' | b' ' | b'\t' | b'0'..=b'9')))
    };
    let last = if one_block || is_passes(cursor) { None } else { Some(label(cursor)?) };
    let mut passes = None;
    cursor.blanks();
    if cursor.byte(0).eq_ignore_ascii_case(&b'P') {
        cursor.step();
        cursor.takes("=");
        passes = Some(expression(cursor)?);
    }
    Ok(SiemensItem::RepeatPart { first, last, passes, one_block })
}

pub(super) fn case(cursor: &mut SiemensCursor<'_>) -> Result<SiemensItem, String> {
    let value = expression(cursor)?;
    if !cursor.word("OF") {
        return Err(format!("OF is missing, {}", unexpected(cursor)));
    }
    let mut cases = Vec::new();
    loop {
        cursor.blanks();
        if cursor.is_at_end() {
            return Ok(SiemensItem::Case(value, cases, None));
        }
        let default = cursor.word("DEFAULT");
        let constant = if default { Expression::constant(Data::Bool(true)) } else { expression(cursor)? };
        let Some(direction) = cursor.name().and_then(direction) else {
            return Err(format!("a jump is missing after CASE, {}", unexpected(cursor)));
        };
        let jump = jump(cursor, direction)?;
        if default {
            return Ok(SiemensItem::Case(value, cases, Some(jump)));
        }
        cases.push((constant, jump));
    }
}

pub(super) fn call(cursor: &mut SiemensCursor<'_>, kind: &str) -> Result<SiemensItem, String> {
    let section = |cursor: &mut SiemensCursor<'_>| -> Result<Option<(String, String)>, String> {
        if !cursor.word("BLOCK") {
            return Ok(None);
        }
        let first = cursor.name().map(str::to_ascii_uppercase);
        let last = if cursor.word("TO") { cursor.name().map(str::to_ascii_uppercase) } else { None };
        match (first, last) {
            (Some(first), Some(last)) => Ok(Some((first, last))),
            _ => Err("BLOCK needs two labels with TO between them".to_owned()),
        }
    };
    if kind == "CALL"
        && let Some(section) = section(cursor)?
    {
        let name = Expression::constant(Data::Text(String::new()));
        return Ok(SiemensItem::CallText { name, section: Some(section), arguments: Vec::new() });
    }
    if kind == "PCALL" {
        // The path may be without quotation marks.
        cursor.blanks();
        if !matches!(cursor.byte(0), b'"') {
            let from = cursor.at();
            while !cursor.is_at_end() && !matches!(cursor.byte(0), b' ' | b'\t' | b'(') {
                cursor.step();
            }
            let name = Expression::constant(Data::Text(cursor.since(from).into()));
            let arguments = if cursor.byte(0) == b'(' { arguments(cursor)? } else { Vec::new() };
            return Ok(SiemensItem::CallText { name, section: None, arguments });
        }
    }
    let name = match kind {
        "PCALL" => Expression::constant(Data::Text(cursor.quoted().unwrap_or_default().into())),
        _ => expression(cursor)?,
    };
    let arguments = if kind == "PCALL" && cursor.byte(0) == b'(' { arguments(cursor)? } else { Vec::new() };
    let section = if kind == "CALL" { section(cursor)? } else { None };
    Ok(SiemensItem::CallText { name, section, arguments })
}
