//! Values as text.

use super::{Code, Format, Numeric, Piece, Registers};
use crate::diag::Number;
use crate::fault::{Fault, Outcome};
use crate::ident;
use crate::value::{Record, Value};

/// Maximum bytes of a text; callers may allow less.
const LONGEST: usize = 2 << 20;

/// Appends `arguments` in `format` to `out`.
///
/// # Errors
/// The number of arguments or the type of one does not fit.
pub fn write(out: &mut String, format: &Format, arguments: &[Value], registers: &mut dyn Registers) -> Outcome<()> {
    if arguments.len() != format.arguments {
        let message = format!("the format has {} codes for {} values", format.arguments, arguments.len());
        return Err(Fault::new(Number::FORMAT_MISMATCH, message));
    }
    let start = out.len();
    let mut rest = arguments.iter();
    for piece in &format.pieces {
        match piece {
            Piece::Literal(text) => out.push_str(text),
            Piece::Code(Code::Column { column, back }) => to_column(out, start, *column, *back),
            Piece::Code(Code::Skip(count)) => out.extend(std::iter::repeat_n(' ', *count)),
            Piece::Code(Code::Register { register, word, argument }) => {
                let value = if *argument { Some(real(rest.next().unwrap_or(&Value::Unset))?) } else { None };
                let text = registers.register_text(*register, value, *word);
                out.push_str(&text.ok_or_else(|| Fault::new(Number::NO_HOST, "unknown register"))?);
            }
            Piece::Code(code) => one(out, code, rest.next().unwrap_or(&Value::Unset), registers)?,
        }
        if out.len() - start > LONGEST {
            return Err(Fault::new(Number::SIZE, format!("a text has more than {LONGEST} bytes")));
        }
    }
    Ok(())
}

fn real(value: &Value) -> Outcome<f64> {
    value.as_real().ok_or_else(|| Fault::kind("a number", value))
}

fn one(out: &mut String, code: &Code, value: &Value, registers: &dyn Registers) -> Outcome<()> {
    match code {
        Code::Number(numeric) => numeric.write(out, real(value)?),
        Code::Text { width, lower } => {
            fit(out, value.as_text().ok_or_else(|| Fault::kind("a text", value))?, *width, *lower);
        }
        Code::Minor { width, lower } => match value {
            Value::Keyword(code) => fit(out, &keyword(*code), *width, *lower),
            Value::Record(name) if name.class == ident::MAJOR_CLASS && name.subclass > 1000 => {
                fit(out, &record(*name), *width, *lower);
            }
            _ => return Err(Fault::kind("a keyword", value)),
        },
        Code::Record { width, lower } => match value {
            Value::Record(name) => fit(out, &record(*name), *width, *lower),
            _ => return Err(Fault::kind("a record", value)),
        },
        Code::Logical { width, lower } => {
            let truth = value.as_logical().ok_or_else(|| Fault::kind("a truth value", value))?;
            fit(out, logical(truth), *width, *lower);
        }
        Code::Character => {
            let code = real(value)?.round();
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let character = if (0.0..=1_114_111.0).contains(&code) { char::from_u32(code as u32) } else { None };
            let fault = || Fault::new(Number::FORMAT_MISMATCH, "this number is not a valid character code");
            out.push(character.ok_or_else(fault)?);
        }
        Code::Any | Code::Column { .. } | Code::Skip(_) | Code::Register { .. } => any(out, value, registers),
    }
    Ok(())
}

fn logical(truth: bool) -> &'static str {
    if truth { "TRUE" } else { "FALSE" }
}

fn keyword(code: i32) -> String {
    ident::minor_name(code).map_or_else(|| format!("#{code}"), str::to_owned)
}

fn record(name: Record) -> String {
    let part = |number: i32| if number < 0 { "*".to_owned() } else { number.to_string() };
    match ident::record_name(name) {
        Some(word) => word.to_owned(),
        None => format!("#{}:{}", part(name.class), part(name.subclass)),
    }
}

/// Appends any value by the wildcard; a list that makes the text longer than 2 MiB is cut.
pub fn any(out: &mut String, value: &Value, registers: &dyn Registers) {
    match value {
        Value::Unset => out.push('0'),
        Value::Null => out.push_str("$NULL"),
        Value::Real(number) => Numeric::WILDCARD.write(out, *number),
        Value::Logical(truth) => out.push_str(logical(*truth)),
        Value::Text(text) => out.push_str(text),
        Value::Keyword(code) => out.push_str(&keyword(*code)),
        Value::Record(name) => out.push_str(&record(*name)),
        Value::Code(code) => out.push_str(&registers.code_name(*code)),
        Value::Register(register) => out.push_str(&registers.register_name(*register)),
        Value::Sequence(elements) => list(out, elements, registers),
        Value::Array(array) => list(out, &array.elements, registers),
    }
}

fn list(out: &mut String, elements: &[Value], registers: &dyn Registers) {
    out.push('<');
    for (index, element) in elements.iter().enumerate() {
        if index > 0 {
            out.push(',');
        }
        if out.len() > LONGEST {
            break;
        }
        any(out, element, registers);
    }
    out.push('>');
}

fn fit(out: &mut String, text: &str, width: usize, lower: bool) {
    let start = out.len();
    if width == 0 {
        out.push_str(text);
    } else {
        out.extend(text.chars().take(width));
        out.extend(std::iter::repeat_n(' ', width.saturating_sub(text.chars().count())));
    }
    if lower {
        let lowered = out.get(start..).unwrap_or("").to_lowercase();
        out.truncate(start);
        out.push_str(&lowered);
    }
}

fn to_column(out: &mut String, start: usize, column: usize, back: bool) {
    let line = out.get(start..).unwrap_or("");
    let length = line.chars().count();
    if length < column - 1 {
        out.extend(std::iter::repeat_n(' ', column - 1 - length));
    } else if back {
        let keep = line.char_indices().nth(column - 1).map_or(line.len(), |(at, _)| at);
        out.truncate(start + keep);
    }
}
