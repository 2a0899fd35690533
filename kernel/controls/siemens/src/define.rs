//! Declarations, read: DEF, REDEF, PROC and EXTERN.
//!
//! Facts: reference control-emulator.md 5.4. Invariant: reading changes nothing; sizes are expressions until the block
//! runs.

use super::compiled::{Expression, SiemensArgument};
use super::cursor::{SiemensCursor, split_list};
use super::declaration::{DeclaredVariable, Initial, Parameter, ProcHeader, VariableDeclaration, VariableScope};
use super::expression::{arguments, expression, unexpected};
use super::value::{Data, Type};

/// Attributes of data that change nothing here, with the number of values after them.
const ATTRIBUTES: [&str; 19] = [
    "SYNR", "SYNW", "SYNRW", "PHU", "APR", "APW", "APRP", "APWP", "APRB", "APWB", "LLI", "ULI", "ACCESS", "EXECX",
    "IPO", "PRLOC", "INIPO", "INIRE", "INICF",
];

/// A list of values in parentheses, if one follows.
pub(super) fn list(cursor: &mut SiemensCursor<'_>) -> Result<Option<Vec<SiemensArgument>>, String> {
    let mut ahead = cursor.clone();
    let is_list = ahead.enclosed(b'(', b')').is_some_and(|inner| split_list(inner).len() > 1);
    cursor.blanks();
    if is_list { arguments(cursor).map(Some) } else { Ok(None) }
}

/// Behind DEF or REDEF.
pub(super) fn declaration(cursor: &mut SiemensCursor<'_>) -> Result<VariableDeclaration, String> {
    let (mut scope, mut kind, mut length) = (None, None, None);
    while let Some(name) = cursor.peeked_name().map(str::to_ascii_uppercase) {
        match name.as_str() {
            "NCK" => scope = Some(VariableScope::Nck),
            "CHAN" => scope = Some(VariableScope::Channel),
            _ if ATTRIBUTES.contains(&name.as_str()) => {
                attribute(cursor)?;
                continue;
            }
            _ => match Type::named(&name) {
                Some(found) => {
                    cursor.name();
                    kind = Some(found);
                    length = text_length(cursor, found)?;
                    attributes(cursor)?;
                    break;
                }
                None => break,
            },
        }
        cursor.name();
    }
    let mut variables = Vec::new();
    loop {
        variables.push(declared(cursor)?);
        cursor.blanks();
        if cursor.is_at_end() {
            return Ok(VariableDeclaration { scope, kind, length, variables });
        }
        if !cursor.takes(",") {
            return Err(unexpected(cursor));
        }
    }
}

fn attribute(cursor: &mut SiemensCursor<'_>) -> Result<(), String> {
    let name = cursor.name().unwrap_or_default().to_ascii_uppercase();
    // When data get their first value again: the value may follow.
    let is_moment = name.starts_with("INI") || name == "PRLOC";
    cursor.blanks();
    let has_value = cursor.byte(0).is_ascii_digit() || matches!(cursor.byte(0), b'+' | b'-' | b'.' | b'"');
    if !name.starts_with("SYN") && (has_value || !is_moment) {
        expression(cursor)?;
    }
    Ok(())
}

/// `[n]` after STRING.
fn text_length(cursor: &mut SiemensCursor<'_>, kind: Type) -> Result<Option<Expression>, String> {
    if !matches!(kind, Type::Text(_)) || !cursor.takes("[") {
        return Ok(None);
    }
    let length = expression(cursor)?;
    if cursor.takes("]") { Ok(Some(length)) } else { Err(format!("a ']' is missing, {}", unexpected(cursor))) }
}

fn declared(cursor: &mut SiemensCursor<'_>) -> Result<DeclaredVariable, String> {
    let Some(name) = cursor.name() else { return Err(format!("a name is missing, {}", unexpected(cursor))) };
    let name = name.to_ascii_uppercase();
    let mut sizes = Vec::new();
    if cursor.takes("[") {
        loop {
            sizes.push(expression(cursor)?);
            if cursor.takes("]") {
                break;
            }
            if !cursor.takes(",") {
                return Err(format!("a ']' is missing, {}", unexpected(cursor)));
            }
        }
    }
    attributes(cursor)?;
    let assigned = cursor.takes("=");
    let from = cursor.at();
    let key = cursor.name().map(str::to_ascii_uppercase).filter(|_| cursor.byte(0) == b'(');
    let initial = match key.as_deref() {
        Some("SET") => Some(Initial::List(arguments(cursor)?)),
        Some("REP") => Some(Initial::Fill(arguments(cursor)?)),
        _ => {
            cursor.back_to(from);
            match assigned {
                false => None,
                true => Some(match list(cursor)? {
                    Some(list) => Initial::List(list),
                    None => Initial::One(expression(cursor)?),
                }),
            }
        }
    };
    attributes(cursor)?;
    Ok(DeclaredVariable { name, sizes, initial })
}

fn attributes(cursor: &mut SiemensCursor<'_>) -> Result<(), String> {
    while cursor.peeked_name().is_some_and(|name| ATTRIBUTES.contains(&name.to_ascii_uppercase().as_str())) {
        attribute(cursor)?;
    }
    Ok(())
}

/// Behind PROC or EXTERN.
pub(super) fn header(cursor: &mut SiemensCursor<'_>) -> Result<ProcHeader, String> {
    let Some(name) = cursor.name() else { return Err(format!("a name is missing, {}", unexpected(cursor))) };
    let mut header = ProcHeader { name: name.to_ascii_uppercase(), parameters: Vec::new(), save: false };
    let mut ahead = cursor.clone();
    if ahead.takes("(") {
        let Some(inner) = cursor.enclosed(b'(', b')') else { return Err("a ')' is missing".to_owned()) };
        if !inner.trim().is_empty() {
            for text in split_list(inner) {
                header.parameters.push(parameter(&mut cursor.inside(text))?);
            }
        }
    }
    while let Some(name) = cursor.name() {
        header.save |= name.eq_ignore_ascii_case("SAVE");
    }
    Ok(header)
}

fn parameter(cursor: &mut SiemensCursor<'_>) -> Result<Parameter, String> {
    let by_reference = cursor.word("VAR");
    let kind = cursor.name().and_then(|name| Type::named(&name.to_ascii_uppercase()));
    let Some(mut kind) = kind else { return Err(format!("a type is missing, {}", unexpected(cursor))) };
    if let Type::Text(_) = kind {
        let length = text_length(cursor, kind)?;
        let length = match length.as_ref().and_then(Expression::as_constant) {
            Some(Data::Int(length)) => u16::try_from(*length).unwrap_or(LONGEST_TEXT),
            _ => LONGEST_TEXT,
        };
        kind = Type::Text(length.min(LONGEST_TEXT));
    }
    let name = cursor.name().unwrap_or_default().to_ascii_uppercase();
    let array = cursor.enclosed(b'[', b']').is_some();
    let default = if cursor.takes("=") { Some(expression(cursor)?) } else { None };
    cursor.blanks();
    if cursor.is_at_end() {
        Ok(Parameter { kind, by_reference, name, array, default })
    } else {
        Err(unexpected(cursor))
    }
}

/// Most characters of a STRING.
pub(super) const LONGEST_TEXT: u16 = 400;
