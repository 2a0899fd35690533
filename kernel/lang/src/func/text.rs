//! Text and sequences.

use super::{Context, count, number, real, sequence as elements, string};
use crate::diag::Number;
use crate::fault::{Fault, Outcome};
use crate::value::Value;
use crate::vm::{range, sequence_of};

pub(super) fn character(_: &mut Context<'_>, arguments: &[Value]) -> Outcome<Value> {
    let code = number(arguments, 0)?.round();
    let found = u32::try_from(count(code)).ok().and_then(char::from_u32).filter(|_| code >= 0.0);
    match found {
        Some(found) => Ok(Value::text(found.to_string())),
        None => Err(Fault::new(Number::OUT_OF_RANGE, format!("there is no character {code}"))),
    }
}

pub(super) fn code_of(_: &mut Context<'_>, arguments: &[Value]) -> Outcome<Value> {
    let first = string(arguments, 0)?.chars().next().unwrap_or(' ');
    Ok(Value::Real(f64::from(u32::from(first))))
}

pub(super) fn length(_: &mut Context<'_>, arguments: &[Value]) -> Outcome<Value> {
    match arguments.first() {
        Some(Value::Text(text)) => Ok(real(text.chars().count().max(1))),
        Some(Value::Unset) => Ok(real(1)),
        Some(Value::Sequence(elements)) => Ok(real(elements.len())),
        other => Err(Fault::kind("a text or a sequence", other.unwrap_or(&Value::Unset))),
    }
}

pub(super) fn index(_: &mut Context<'_>, arguments: &[Value]) -> Outcome<Value> {
    let (text, wanted) = (string(arguments, 0)?, string(arguments, 1)?);
    let wanted = if wanted.is_empty() { " " } else { wanted };
    let text = if text.is_empty() { " " } else { text };
    let found = text.find(wanted).and_then(|at| text.get(..at));
    Ok(real(found.map_or(0, |before| before.chars().count() + 1)))
}

pub(super) fn find(_: &mut Context<'_>, arguments: &[Value]) -> Outcome<Value> {
    let elements = match arguments.first() {
        Some(Value::Sequence(elements)) => elements.as_slice(),
        Some(Value::Array(array)) => array.elements.as_slice(),
        other => return Err(Fault::kind("a sequence or an array", other.unwrap_or(&Value::Unset))),
    };
    let wanted = arguments.get(1).unwrap_or(&Value::Unset);
    let limit = if arguments.len() > 2 { count(number(arguments, 2)?) } else { usize::MAX };
    let found = elements.iter().take(limit).position(|element| element.equals(wanted) == Some(true));
    Ok(real(found.map_or(0, |at| at + 1)))
}

/// Most elements of a system variable that are looked at without a limit.
const MOST_ELEMENTS: usize = 10_000;

/// `$FFIND` in the elements of a system variable: its position in the table of the host, what is looked for, the limit or
/// `$NULL`, the indices of the first element. The last index counts.
pub(super) fn find_in_system(context: &mut Context<'_>, arguments: &[Value]) -> Outcome<Value> {
    let [_, wanted, limit, indices @ ..] = arguments else { return Ok(Value::Null) };
    let system = u32::try_from(count(number(arguments, 0)?)).unwrap_or(u32::MAX);
    let limit = limit.as_real().map_or(MOST_ELEMENTS, count);
    #[allow(clippy::cast_possible_truncation)]
    let whole = |value: &Value| value.as_real().map(|number| number as i64);
    let indices: Option<Vec<i64>> = indices.iter().map(whole).collect();
    let mut indices = indices.ok_or_else(|| Fault::new(Number::TYPE_MISMATCH, "an index must be a number"))?;
    for position in 1..=limit {
        context.state.spend(1)?;
        match context.host.read_system(system, &indices) {
            Ok(element) if element.equals(wanted) == Some(true) => return Ok(real(position)),
            Ok(_) => {}
            Err(fault) if position == 1 => return Err(fault),
            Err(_) => break,
        }
        if let Some(last) = indices.last_mut() {
            *last += 1;
        }
    }
    Ok(real(0))
}

/// Third and fourth argument of $FEDIT and $FMATCH: a text is the replacement, a number the match.
fn text_and_number(arguments: &[Value]) -> Outcome<(Option<&str>, Option<usize>)> {
    let (mut text, mut which) = (None, None);
    for value in arguments.iter().skip(2) {
        match value {
            Value::Text(given) => text = Some(given.as_str()),
            Value::Real(given) => which = Some(count(*given)),
            other => return Err(Fault::kind("a text or a number", other)),
        }
    }
    Ok((text, which))
}

pub(super) fn edit(context: &mut Context<'_>, arguments: &[Value]) -> Outcome<Value> {
    let pattern = context.state.pattern(string(arguments, 1)?)?;
    let (with, which) = text_and_number(arguments)?;
    let text = pattern.replace(string(arguments, 0)?, with.unwrap_or(""), which.unwrap_or(0))?;
    context.state.check_text(text.len())?;
    Ok(Value::text(text))
}

pub(super) fn matched(context: &mut Context<'_>, arguments: &[Value]) -> Outcome<Value> {
    let pattern = context.state.pattern(string(arguments, 1)?)?;
    let (template, which) = text_and_number(arguments)?;
    let found = pattern.nth(string(arguments, 0)?, template, which.unwrap_or(1).max(1))?;
    Ok(Value::text(found.unwrap_or_default()))
}

pub(super) fn split(context: &mut Context<'_>, arguments: &[Value]) -> Outcome<Value> {
    let pattern = context.state.pattern(string(arguments, 1)?)?;
    let limit = if arguments.len() > 2 { count(number(arguments, 2)?) } else { 0 };
    let pieces = pattern.split(string(arguments, 0)?, limit)?;
    context.state.check_elements(pieces.len())?;
    Ok(Value::sequence(pieces.into_iter().map(Value::text).collect()))
}

pub(super) fn formatted(context: &mut Context<'_>, arguments: &[Value]) -> Outcome<Value> {
    let format = context.state.format(string(arguments, 0)?, false)?;
    let mut out = String::new();
    let mut outside = crate::vm::commands::Outside(context.host);
    crate::format::write(&mut out, &format, arguments.get(1..).unwrap_or(&[]), &mut outside)?;
    context.state.check_text(out.len())?;
    Ok(Value::text(out))
}

pub(super) fn lower(_: &mut Context<'_>, arguments: &[Value]) -> Outcome<Value> {
    Ok(Value::text(string(arguments, 0)?.to_lowercase()))
}

pub(super) fn upper(_: &mut Context<'_>, arguments: &[Value]) -> Outcome<Value> {
    Ok(Value::text(string(arguments, 0)?.to_uppercase()))
}

/// Characters of a trim mask; `a..b` is a range.
fn mask(arguments: &[Value]) -> Outcome<Vec<(char, char)>> {
    if arguments.len() < 2 {
        return Ok([' ', '\t', '\n', '\r', '\0', '\u{b}'].map(|c| (c, c)).to_vec());
    }
    let text: Vec<char> = string(arguments, 1)?.chars().collect();
    let mut ranges = Vec::new();
    let mut rest = text.as_slice();
    while let Some((&first, after)) = rest.split_first() {
        if let ['.', '.', last, tail @ ..] = after {
            ranges.push((first, *last));
            rest = tail;
        } else {
            ranges.push((first, first));
            rest = after;
        }
    }
    Ok(ranges)
}

fn trimmed(arguments: &[Value], left: bool, right: bool) -> Outcome<Value> {
    let mask = mask(arguments)?;
    let cut = |c: char| mask.iter().any(|(low, high)| (*low..=*high).contains(&c));
    let mut text = string(arguments, 0)?;
    if left {
        text = text.trim_start_matches(cut);
    }
    if right {
        text = text.trim_end_matches(cut);
    }
    Ok(Value::text(text))
}

pub(super) fn trim(_: &mut Context<'_>, arguments: &[Value]) -> Outcome<Value> {
    trimmed(arguments, true, true)
}

pub(super) fn trim_left(_: &mut Context<'_>, arguments: &[Value]) -> Outcome<Value> {
    trimmed(arguments, true, false)
}

pub(super) fn trim_right(_: &mut Context<'_>, arguments: &[Value]) -> Outcome<Value> {
    trimmed(arguments, false, true)
}

pub(super) fn element(_: &mut Context<'_>, arguments: &[Value]) -> Outcome<Value> {
    let (list, index) = (elements(arguments, 0)?, number(arguments, 1)?);
    let found = if index >= 1.0 { list.get(count(index) - 1) } else { None };
    let message = || format!("the index {} is outside of 1 to {}", index.trunc(), list.len());
    found.cloned().ok_or_else(|| Fault::new(Number::OUT_OF_RANGE, message()))
}

fn part(arguments: &[Value]) -> Outcome<Value> {
    let (from, to) = (number(arguments, 1)?, number(arguments, 2)?);
    if from < 1.0 || to < 0.0 {
        return Err(Fault::new(Number::OUT_OF_RANGE, "the places of a part begin with 1"));
    }
    #[allow(clippy::cast_possible_truncation)]
    range(arguments.first().unwrap_or(&Value::Unset), from as i64, to as i64)
}

pub(super) fn part_of_sequence(_: &mut Context<'_>, arguments: &[Value]) -> Outcome<Value> {
    elements(arguments, 0)?;
    part(arguments)
}

pub(super) fn part_of_text(_: &mut Context<'_>, arguments: &[Value]) -> Outcome<Value> {
    string(arguments, 0)?;
    part(arguments)
}

pub(super) fn sequence(context: &mut Context<'_>, arguments: &[Value]) -> Outcome<Value> {
    sequence_of(context.state, arguments.iter())
}
