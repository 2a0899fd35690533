//! A block, read: its number, its label, its words and statements in their order.
//!
//! Facts: reference control-emulator.md 5.4. A name starts with two letters or underscores; a single letter is an
//! address. The meaning of a name — variable, word, subprogram, literal code — is decided when the block runs.
//! Invariant: text that is not a statement is kept unchanged.

use counterpoint_control_api::statement::{IDLE, Statements};
use counterpoint_control_api::words::span;

use super::compiled::{Expression, IndexedName};
use super::cursor::{SiemensCursor, begins_name, in_name};
use super::expression::{arguments, expression, indexed, unexpected};
use super::item::{AssignmentValue, PositionMode, SiemensItem, SiemensLine, Structure, Width};
use super::statement::{JUMPS, call, case, direction, jump, repeat};
use super::value::Data;
use super::{actions, define};

/// Key words that are alone.
const STRUCTURES: [(&str, Structure); 7] = [
    ("ELSE", Structure::Else),
    ("ENDIF", Structure::EndIf),
    ("LOOP", Structure::Loop),
    ("ENDLOOP", Structure::EndLoop),
    ("ENDFOR", Structure::EndFor),
    ("ENDWHILE", Structure::EndWhile),
    ("REPEAT", Structure::Repeat),
];

const POSITIONINGS: [(&str, PositionMode); 16] = [
    ("AC", PositionMode::Absolute),
    ("IC", PositionMode::Incremental),
    ("DC", PositionMode::Shortest),
    ("ACP", PositionMode::Positive),
    ("ACN", PositionMode::Negative),
    ("CAC", PositionMode::Absolute),
    ("CDC", PositionMode::Shortest),
    ("CACP", PositionMode::Positive),
    ("CACN", PositionMode::Negative),
    ("QU", PositionMode::Value),
    ("PM", PositionMode::PerMinute),
    ("PR", PositionMode::PerRevolution),
    ("DAC", PositionMode::AbsoluteAs(Width::Diameter)),
    ("DIC", PositionMode::IncrementalAs(Width::Diameter)),
    ("RAC", PositionMode::AbsoluteAs(Width::Radius)),
    ("RIC", PositionMode::IncrementalAs(Width::Radius)),
];

/// Key words of statements that other controls have too.
const STATEMENTS: Statements<&str> = &[
    ("STOPRE", &IDLE),
    ("SBLOF", &IDLE),
    ("SBLON", &IDLE),
    ("DISPLOF", &IDLE),
    ("DISPLON", &IDLE),
    ("ACTBLOCNO", &IDLE),
    ("ENDLABEL", &IDLE),
];

/// Number and label at the start of a block; the cursor stops after them.
pub(super) fn head(cursor: &mut SiemensCursor<'_>) -> (Option<String>, Option<String>) {
    let mut number = None;
    cursor.blanks();
    let first = cursor.byte(0).to_ascii_uppercase();
    if (first == b'N' || first == b':') && cursor.byte(1).is_ascii_digit() {
        let from = cursor.at();
        cursor.step();
        let digits = cursor.digits();
        if in_name(cursor.byte(0)) && first == b'N' && cursor.byte(0) == b'_' {
            cursor.back_to(from);
        } else {
            number = Some(digits.to_owned());
        }
    }
    let from = cursor.at();
    if let Some(name) = cursor.name()
        && cursor.takes(":")
    {
        return (number, Some(name.to_ascii_uppercase()));
    }
    cursor.back_to(from);
    (number, None)
}

/// Reads a block without comment and marks of optional skip.
pub(super) fn read(text: &str) -> Result<SiemensLine, String> {
    let mut cursor = SiemensCursor::new(text);
    cursor.blanks();
    let start = cursor.at();
    let (number, label) = head(&mut cursor);
    let end = start + 1 + number.as_ref().map_or(0, String::len);
    let mut line = SiemensLine { number, label, places: vec![span(start, end)], ..SiemensLine::default() };
    loop {
        cursor.blanks();
        if cursor.is_at_end() {
            line.speed_is_other = line.items.iter().any(super::spindles::changes_speed);
            return if line.items.len() > 1 { alone(line) } else { Ok(line) };
        }
        let start = cursor.at();
        let item = item(&mut cursor)?;
        line.items.push(item);
        line.places.push(span(start, start + cursor.since(start).trim_end().len()));
    }
}

/// Refuses other words beside statements of loops and branches, and axis words beside statements that take none.
fn alone(line: SiemensLine) -> Result<SiemensLine, String> {
    if let Some((statement, axis)) = super::own_block::axis_beside_statement(&line.items) {
        return Err(format!("{statement} takes no axis word; program {axis} in a block of its own"));
    }
    let is_structure = |item: &&SiemensItem| {
        matches!(
            item,
            SiemensItem::If(_, None)
                | SiemensItem::Structure(_)
                | SiemensItem::For(..)
                | SiemensItem::While(_)
                | SiemensItem::Until(_)
                | SiemensItem::RepeatPart { .. }
        )
    };
    match line.items.iter().find(is_structure) {
        Some(_) => Err("a loop, branch or repetition must be alone in its block; behind the condition of IF only a jump (GOTOF, GOTOB) may stand".to_owned()),
        None => Ok(line),
    }
}

pub(super) fn item(cursor: &mut SiemensCursor<'_>) -> Result<SiemensItem, String> {
    let (first, second) = (cursor.byte(0), cursor.byte(1));
    let named = first == b'$' || first == b'_' || second == b'_';
    if begins_name(first) && (named || second.is_ascii_alphabetic()) {
        let from = cursor.at();
        let name = cursor.name().unwrap_or_default().to_ascii_uppercase();
        return statement(cursor, &name, from);
    }
    if first.is_ascii_alphabetic() {
        return address(cursor, first.to_ascii_uppercase());
    }
    let from = cursor.at();
    if first == b'"' && cursor.quoted().is_some() {
        return Ok(SiemensItem::Text(cursor.since(from).to_owned()));
    }
    while !cursor.is_at_end() && !matches!(cursor.byte(0), b' ' | b'\t') {
        cursor.step();
    }
    Ok(SiemensItem::Text(cursor.since(from).to_owned()))
}

/// A word by its letter.
fn address(cursor: &mut SiemensCursor<'_>, letter: u8) -> Result<SiemensItem, String> {
    let from = cursor.at();
    cursor.step();
    let extension = cursor.digits().to_owned();
    let name = format!("{}{extension}", char::from(letter));
    let behind = cursor.at();
    if cursor.byte(0) == b'[' {
        if let Ok(name) = indexed(cursor, &name)
            && cursor.assigns()
        {
            return assignment(cursor, name);
        }
        cursor.back_to(behind);
    } else if cursor.assigns() {
        let name = indexed(cursor, &name)?;
        if let ("P", []) = (name.name.as_str(), name.index.as_slice()) {
            cursor.takes("=");
            let value = expression(cursor)?;
            return Ok(SiemensItem::Passes(value, cursor.since(from).to_owned()));
        }
        return assignment(cursor, name);
    }
    if letter == b'L' && !extension.is_empty() && cursor.byte(0) == b'(' {
        return Ok(SiemensItem::Function(name, arguments(cursor)?));
    }
    if extension.is_empty() {
        // A blank between letter and number belongs to the word.
        cursor.blanks();
        if matches!(cursor.byte(0), b'+' | b'-') {
            cursor.step();
        }
        if cursor.decimal().is_none() {
            cursor.back_to(behind);
        }
    } else if cursor.byte(0) == b'.' {
        cursor.step();
        cursor.digits();
    }
    let text = cursor.since(from);
    Ok(match letter {
        b'L' if !extension.is_empty() && text.len() == name.len() => SiemensItem::Program(name),
        b'P' => match extension.parse() {
            Ok(passes) => SiemensItem::Passes(Expression::constant(Data::Int(passes)), text.to_owned()),
            Err(_) => SiemensItem::Text(text.to_owned()),
        },
        b'M' if extension.parse() == Ok(17) && text.len() == name.len() => SiemensItem::Return(name, false),
        _ => SiemensItem::Text(text.to_owned()),
    })
}

fn assignment(cursor: &mut SiemensCursor<'_>, name: IndexedName) -> Result<SiemensItem, String> {
    cursor.takes("=");
    cursor.blanks();
    let from = cursor.at();
    let before = cursor.clone();
    if let Some(key) = cursor.name().map(str::to_ascii_uppercase)
        && cursor.byte(0) == b'('
    {
        match key.as_str() {
            "SET" => return Ok(SiemensItem::Set { name, value: AssignmentValue::List(arguments(cursor)?) }),
            "REP" => return Ok(SiemensItem::Set { name, value: AssignmentValue::Fill(arguments(cursor)?) }),
            _ => {}
        }
        // `CIC` is the incremental path along coded positions.
        let way = if key == "IC" || key == "CIC" {
            Some(PositionMode::Incremental)
        } else {
            POSITIONINGS.iter().find(|(text, _)| *text == key).map(|(_, way)| *way)
        };
        if let Some(way) = way {
            cursor.takes("(");
            let value = expression(cursor)?;
            if !cursor.takes(")") {
                return Err(format!("a ')' is missing, {}", unexpected(cursor)));
            }
            return Ok(SiemensItem::Set { name, value: AssignmentValue::Positioned(way, value, key) });
        }
    }
    *cursor = before;
    if let Some(list) = define::list(cursor)? {
        return Ok(SiemensItem::Set { name, value: AssignmentValue::List(list) });
    }
    let value = expression(cursor)?;
    Ok(SiemensItem::Set { name, value: AssignmentValue::One(value, cursor.since(from).trim().to_owned()) })
}

fn statement(cursor: &mut SiemensCursor<'_>, name: &str, from: usize) -> Result<SiemensItem, String> {
    cursor.blanks_before_brackets();
    if actions::begins(name, cursor) {
        return actions::action(cursor, name, item);
    }
    if let Some((_, structure)) = STRUCTURES.iter().find(|(text, _)| *text == name) {
        if *structure == Structure::Repeat {
            return repeat(cursor, false);
        }
        return Ok(SiemensItem::Structure(*structure));
    }
    if let Some((_, direction)) = JUMPS.iter().find(|(text, _)| *text == name) {
        return Ok(SiemensItem::Goto(jump(cursor, *direction)?));
    }
    if let Some((_, statement)) = STATEMENTS.iter().find(|(text, _)| *text == name) {
        let text = cursor.since(from).to_owned();
        let operands = if statement.operands > 0 { arguments(cursor)? } else { Vec::new() };
        if operands.len() != statement.operands {
            return Err(format!("{name} takes {} arguments, not {}", statement.operands, operands.len()));
        }
        return Ok(SiemensItem::Shared { statement, text, operands });
    }
    Ok(match name {
        "REPEATB" => return repeat(cursor, true),
        "IF" => {
            let condition = expression(cursor)?;
            let before = cursor.clone();
            let direction = cursor.name().and_then(direction);
            match direction {
                Some(direction) => SiemensItem::If(condition, Some(jump(cursor, direction)?)),
                None => {
                    *cursor = before;
                    SiemensItem::If(condition, None)
                }
            }
        }
        "CASE" => return case(cursor),
        "FOR" => {
            let Some(variable) = cursor.name() else { return Err(unexpected(cursor)) };
            let variable = indexed(cursor, &variable.to_ascii_uppercase())?;
            if !cursor.assigns() || !cursor.takes("=") {
                return Err(unexpected(cursor));
            }
            let first = expression(cursor)?;
            if !cursor.word("TO") {
                return Err(format!("TO is missing, {}", unexpected(cursor)));
            }
            SiemensItem::For(variable, first, expression(cursor)?)
        }
        "WHILE" => SiemensItem::While(expression(cursor)?),
        "UNTIL" => SiemensItem::Until(expression(cursor)?),
        "DEF" => SiemensItem::Declare(define::declaration(cursor)?),
        "REDEF" => SiemensItem::Redeclare(define::declaration(cursor)?),
        "DEFINE" => {
            let Some(name) = cursor.name() else { return Err(unexpected(cursor)) };
            if !cursor.word("AS") {
                return Err(format!("AS is missing, {}", unexpected(cursor)));
            }
            let text = cursor.rest().trim().to_owned();
            while !cursor.is_at_end() {
                cursor.step();
            }
            SiemensItem::Define(name.to_ascii_uppercase(), text)
        }
        "PROC" => SiemensItem::Header(define::header(cursor)?),
        "EXTERN" => SiemensItem::External(define::header(cursor)?),
        "MSG" => {
            SiemensItem::Message(if cursor.byte(0) == b'(' { arguments(cursor)?.into_iter().next() } else { None })
        }
        "MCALL" => SiemensItem::Modal,
        "RET" => {
            let elsewhere = cursor.byte(0) == b'(' && !arguments(cursor)?.is_empty();
            SiemensItem::Return(cursor.since(from).to_owned(), elsewhere)
        }
        "CALL" | "EXTCALL" | "PCALL" => return call(cursor, name),
        _ if cursor.byte(0) == b'(' => SiemensItem::Function(name.to_owned(), arguments(cursor)?),
        _ => {
            let behind = cursor.at();
            match indexed(cursor, name) {
                Ok(target) if cursor.assigns() => return assignment(cursor, target),
                _ => cursor.back_to(behind),
            }
            if cursor.byte(0) == b'[' {
                while !cursor.is_at_end() && !matches!(cursor.byte(0), b' ' | b'\t') {
                    cursor.step();
                }
                return Ok(SiemensItem::Text(cursor.since(from).to_owned()));
            }
            SiemensItem::Bare(cursor.since(from).to_owned())
        }
    })
}
