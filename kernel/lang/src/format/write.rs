//! Values as text.

use super::{FormatCode, FormatPiece, Numeric, RegisterHost, StringFormat};
use crate::diag::DiagnosticNumber;
use crate::fault::{MacroFault, Outcome};
use crate::ident;
use crate::value::{MacroValue, RecordName};

/// Maximum bytes of a text; callers may allow less.
const LONGEST: usize = 2 << 20;

/// Appends `arguments` in `format` to `out`.
///
/// # Errors
/// The number of arguments or the type of one does not fit.
pub fn write(
    out: &mut String,
    format: &StringFormat,
    arguments: &[MacroValue],
    registers: &mut dyn RegisterHost,
) -> Outcome<()> {
    if arguments.len() != format.arguments {
        let message = format!("the format has {} codes for {} values", format.arguments, arguments.len());
        return Err(MacroFault::new(DiagnosticNumber::FORMAT_MISMATCH, message));
    }
    let start = out.len();
    let mut rest = arguments.iter();
    for piece in &format.pieces {
        match piece {
            FormatPiece::Literal(text) => out.push_str(text),
            FormatPiece::Code(FormatCode::Column { column, back }) => to_column(out, start, *column, *back),
            FormatPiece::Code(FormatCode::Skip(count)) => out.extend(std::iter::repeat_n(' ', *count)),
            FormatPiece::Code(FormatCode::Register { register, word, argument }) => {
                let value = if *argument { Some(real(rest.next().unwrap_or(&MacroValue::Unset))?) } else { None };
                let text = registers.register_text(*register, value, *word);
                out.push_str(&text.ok_or_else(|| MacroFault::new(DiagnosticNumber::NO_HOST, "unknown register"))?);
            }
            FormatPiece::Code(code) => one(out, code, rest.next().unwrap_or(&MacroValue::Unset), registers)?,
        }
        if out.len() - start > LONGEST {
            return Err(MacroFault::new(DiagnosticNumber::SIZE, format!("a text has more than {LONGEST} bytes")));
        }
    }
    Ok(())
}

fn real(value: &MacroValue) -> Outcome<f64> {
    value.as_real().ok_or_else(|| MacroFault::kind("a number", value))
}

fn one(out: &mut String, code: &FormatCode, value: &MacroValue, registers: &dyn RegisterHost) -> Outcome<()> {
    match code {
        FormatCode::Number(numeric) => numeric.write(out, real(value)?),
        FormatCode::Text { width, lower } => {
            fit(out, value.as_text().ok_or_else(|| MacroFault::kind("a text", value))?, *width, *lower);
        }
        FormatCode::Minor { width, lower } => match value {
            MacroValue::Keyword(code) => fit(out, &keyword(*code), *width, *lower),
            MacroValue::Record(name) if name.class == ident::MAJOR_CLASS && name.subclass > 1000 => {
                fit(out, &record(*name), *width, *lower);
            }
            _ => return Err(MacroFault::kind("a keyword", value)),
        },
        FormatCode::Record { width, lower } => match value {
            MacroValue::Record(name) => fit(out, &record(*name), *width, *lower),
            _ => return Err(MacroFault::kind("a record", value)),
        },
        FormatCode::Logical { width, lower } => {
            let truth = value.as_logical().ok_or_else(|| MacroFault::kind("a truth value", value))?;
            fit(out, logical(truth), *width, *lower);
        }
        FormatCode::Character => {
            let code = real(value)?.round();
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let character = if (0.0..=1_114_111.0).contains(&code) { char::from_u32(code as u32) } else { None };
            let fault =
                || MacroFault::new(DiagnosticNumber::FORMAT_MISMATCH, "this number is not a valid character code");
            out.push(character.ok_or_else(fault)?);
        }
        FormatCode::Any | FormatCode::Column { .. } | FormatCode::Skip(_) | FormatCode::Register { .. } => {
            any(out, value, registers)
        }
    }
    Ok(())
}

fn logical(truth: bool) -> &'static str {
    if truth { "TRUE" } else { "FALSE" }
}

fn keyword(code: i32) -> String {
    ident::minor_name(code).map_or_else(|| format!("#{code}"), str::to_owned)
}

fn record(name: RecordName) -> String {
    let part = |number: i32| if number < 0 { "*".to_owned() } else { number.to_string() };
    match ident::record_name(name) {
        Some(word) => word.to_owned(),
        None => format!("#{}:{}", part(name.class), part(name.subclass)),
    }
}

/// Appends any value by the wildcard; a list that makes the text longer than 2 MiB is cut.
pub fn any(out: &mut String, value: &MacroValue, registers: &dyn RegisterHost) {
    match value {
        MacroValue::Unset => out.push('0'),
        MacroValue::Null => out.push_str("$NULL"),
        MacroValue::Real(number) => Numeric::WILDCARD.write(out, *number),
        MacroValue::Logical(truth) => out.push_str(logical(*truth)),
        MacroValue::Text(text) => out.push_str(text),
        MacroValue::Keyword(code) => out.push_str(&keyword(*code)),
        MacroValue::Record(name) => out.push_str(&record(*name)),
        MacroValue::Code(code) => out.push_str(&registers.code_name(*code)),
        MacroValue::Register(register) => out.push_str(&registers.register_name(*register)),
        MacroValue::Sequence(elements) => list(out, elements, registers),
        MacroValue::Array(array) => list(out, &array.elements, registers),
    }
}

fn list(out: &mut String, elements: &[MacroValue], registers: &dyn RegisterHost) {
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
