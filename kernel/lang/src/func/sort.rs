//! `$FSORT` of a file.
//!
//! *Invariant:* lines that compare equal keep their order; a failure writes nothing, gives -1 and sets `$ERRNO`. Facts:
//! reference functions.md 7. Choices of this project: without a field the whole line is compared as text, upward; a
//! field that a line does not have is empty, and 0 as a number; without delimiters fields are divided by runs of
//! blanks, every character of a delimiter text divides on its own.

use super::{FunctionContext, convert, count, string};
use crate::fault::{MacroFault, Outcome};
use crate::ident;
use crate::value::MacroValue;
use std::cmp::Ordering;

const CANNOT_READ: i32 = 2;
const CANNOT_WRITE: i32 = 5;
const BAD_ARGUMENTS: i32 = 22;

/// A field to sort by.
struct SortKey {
    /// Position, from 0.
    field: usize,
    number: bool,
    down: bool,
}

/// The keys after the file names and the delimiters; none if they make no sense.
fn keys(arguments: &[MacroValue]) -> Option<Vec<SortKey>> {
    arguments
        .chunks(3)
        .map(|chunk| {
            let [field, kind, order] = chunk else { return None };
            let field = count(field.as_real()?).checked_sub(1)?;
            let number = match kind.as_text()?.trim().to_ascii_uppercase().as_str() {
                "N" => true,
                "S" => false,
                _ => return None,
            };
            let MacroValue::Keyword(code) = order else { return None };
            let down = match ident::minor_name(*code) {
                Some("DECR") => true,
                Some("INCR") => false,
                _ => return None,
            };
            Some(SortKey { field, number, down })
        })
        .collect()
}

fn field<'a>(line: &'a str, delimiters: Option<&str>, at: usize) -> &'a str {
    let found = match delimiters {
        Some(delimiters) => line.split(|c| delimiters.contains(c)).nth(at),
        None => line.split_whitespace().nth(at),
    };
    found.unwrap_or("")
}

fn compare(a: &str, b: &str, delimiters: Option<&str>, keys: &[SortKey]) -> Ordering {
    if keys.is_empty() {
        return a.cmp(b);
    }
    keys.iter().fold(Ordering::Equal, |order, key| {
        order.then_with(|| {
            let (x, y) = (field(a, delimiters, key.field), field(b, delimiters, key.field));
            let order = if key.number { convert::prefix(x).total_cmp(&convert::prefix(y)) } else { x.cmp(y) };
            if key.down { order.reverse() } else { order }
        })
    })
}

/// Sorts the lines of one file into another one; returns their number.
pub(super) fn file(context: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let [input, output, rest @ ..] = arguments else {
        return Err(MacroFault::kind("a sequence, or two file names", arguments.first().unwrap_or(&MacroValue::Unset)));
    };
    let (input, output) = match (input.as_text(), output.as_text()) {
        (Some(input), Some(output)) => (input, output),
        (None, _) => return Err(MacroFault::kind("a sequence or a file name", input)),
        _ => return Err(MacroFault::kind("a file name", output)),
    };
    let delimiters = rest.first().and_then(|_| string(rest, 0).ok());
    let keys = keys(rest.get(usize::from(delimiters.is_some())..).unwrap_or(&[]));
    let status = match keys {
        Some(keys) => match sorted(context, (input, output), delimiters.filter(|text| !text.trim().is_empty()), &keys)?
        {
            Ok(lines) => {
                context.state.status = 0;
                return Ok(super::real(lines));
            }
            Err(status) => status,
        },
        None => BAD_ARGUMENTS,
    };
    context.state.status = status;
    Ok(MacroValue::Real(-1.0))
}

fn sorted(
    context: &mut FunctionContext<'_>,
    (input, output): (&str, &str),
    delimiters: Option<&str>,
    keys: &[SortKey],
) -> Outcome<Result<usize, i32>> {
    for path in [input, output] {
        let status = context.host.may_open(context.state, path);
        if status != 0 {
            return Ok(Err(status));
        }
    }
    let Some(text) = context.host.read_file(input) else { return Ok(Err(CANNOT_READ)) };
    let mut lines: Vec<&str> = text.lines().collect();
    context.state.check_elements(lines.len())?;
    // Every line meets about as many others as its number has bits, and is looked through for every field.
    let rounds = lines.len().max(1).ilog2() as usize + 1;
    let delimiting = delimiters.map_or(1, str::len).max(1);
    context
        .state
        .spend(lines.len() + (text.len() / 16).saturating_mul(rounds * keys.len().max(1)).saturating_mul(delimiting))?;
    lines.sort_by(|a, b| compare(a, b, delimiters, keys));
    let mut out = lines.join("\n");
    if !lines.is_empty() {
        out.push('\n');
    }
    Ok(if context.host.write_file(output, &out) { Ok(lines.len()) } else { Err(CANNOT_WRITE) })
}
