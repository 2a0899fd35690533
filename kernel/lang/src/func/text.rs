//! Text and sequences.

use super::{FunctionContext, count, number, real, sequence as elements, string};
use crate::diag::DiagnosticNumber;
use crate::fault::{MacroFault, Outcome};
use crate::pattern::STEPS;
use crate::state::{MacroState, pay_to_look_inside, pay_to_write, range, sequence_of};
use crate::value::MacroValue;

/// Steps of a search that one tick pays for.
const STEPS_PER_TICK: u64 = 8;

pub(super) fn character(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let code = number(arguments, 0)?.round();
    let found = u32::try_from(count(code)).ok().and_then(char::from_u32).filter(|_| code >= 0.0);
    match found {
        Some(found) => Ok(MacroValue::text(found.to_string())),
        None => Err(MacroFault::new(DiagnosticNumber::OUT_OF_RANGE, format!("{code} is not a valid character code"))),
    }
}

pub(super) fn code_of(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let first = string(arguments, 0)?.chars().next().unwrap_or(' ');
    Ok(MacroValue::Real(f64::from(u32::from(first))))
}

pub(super) fn length(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    match arguments.first() {
        Some(MacroValue::Text(text)) => Ok(real(text.chars().count().max(1))),
        Some(MacroValue::Unset) => Ok(real(1)),
        Some(MacroValue::Sequence(elements)) => Ok(real(elements.len())),
        other => Err(MacroFault::kind("a text or a sequence", other.unwrap_or(&MacroValue::Unset))),
    }
}

pub(super) fn index(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let (text, wanted) = (string(arguments, 0)?, string(arguments, 1)?);
    let wanted = if wanted.is_empty() { " " } else { wanted };
    let text = if text.is_empty() { " " } else { text };
    let found = text.find(wanted).and_then(|at| text.get(..at));
    Ok(real(found.map_or(0, |before| before.chars().count() + 1)))
}

pub(super) fn find(context: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let elements = match arguments.first() {
        Some(MacroValue::Sequence(elements)) => elements.as_slice(),
        Some(MacroValue::Array(array)) => array.elements.as_slice(),
        other => return Err(MacroFault::kind("a sequence or an array", other.unwrap_or(&MacroValue::Unset))),
    };
    let wanted = arguments.get(1).unwrap_or(&MacroValue::Unset);
    let limit = if arguments.len() > 2 { count(number(arguments, 2)?) } else { usize::MAX };
    let looked = elements.get(..limit.min(elements.len())).unwrap_or(elements);
    pay_to_look_inside(context.state, looked)?;
    // A text is compared with every element.
    context.state.spend(looked.len().saturating_mul(wanted.as_text().map_or(0, str::len)) / 64)?;
    let found = elements.iter().take(limit).position(|element| element.equals(wanted) == Some(true));
    Ok(real(found.map_or(0, |at| at + 1)))
}

/// Most elements of a system variable that are looked at without a limit.
const MOST_ELEMENTS: usize = 10_000;

/// `$FFIND` in the elements of a system variable: its position in the table of the host, the value to find, the limit
/// or `$NULL`, the indices of the first element. The last index counts.
pub(super) fn find_in_system(context: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let [_, wanted, limit, indices @ ..] = arguments else { return Ok(MacroValue::Null) };
    let system = u32::try_from(count(number(arguments, 0)?)).unwrap_or(u32::MAX);
    let limit = limit.as_real().map_or(MOST_ELEMENTS, count);
    #[allow(clippy::cast_possible_truncation)]
    let whole = |value: &MacroValue| value.as_real().map(|number| number as i64);
    let indices: Option<Vec<i64>> = indices.iter().map(whole).collect();
    let mut indices =
        indices.ok_or_else(|| MacroFault::new(DiagnosticNumber::TYPE_MISMATCH, "an index must be a number"))?;
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
fn text_and_number(arguments: &[MacroValue]) -> Outcome<(Option<&str>, Option<usize>)> {
    let (mut text, mut which) = (None, None);
    for value in arguments.iter().skip(2) {
        match value {
            MacroValue::Text(given) => text = Some(given.as_str()),
            MacroValue::Real(given) => which = Some(count(*given)),
            other => return Err(MacroFault::kind("a text or a number", other)),
        }
    }
    Ok((text, which))
}

/// Searches with the steps that a search may take, as long as there are ticks for them.
fn search<R>(context: &mut FunctionContext<'_>, work: impl FnOnce(&MacroState, &mut u64) -> Outcome<R>) -> Outcome<R> {
    let most = STEPS.min(context.state.ticks.saturating_mul(STEPS_PER_TICK));
    let mut budget = most;
    let found = work(context.state, &mut budget);
    context.state.spend(usize::try_from((most - budget) / STEPS_PER_TICK).unwrap_or(usize::MAX))?;
    match found {
        // The search was stopped by the end of the ticks.
        Err(fault) if fault.number == DiagnosticNumber::BACKTRACKING && most < STEPS => {
            context.state.spend(usize::MAX)?;
            Err(fault)
        }
        found => found,
    }
}

pub(super) fn edit(context: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let pattern = context.state.pattern(string(arguments, 1)?)?;
    let (with, which) = text_and_number(arguments)?;
    let (text, with) = (string(arguments, 0)?, (with.unwrap_or(""), which.unwrap_or(0)));
    let text = search(context, |state, budget| pattern.replace_within(text, with, state.limits.text, budget))?;
    Ok(MacroValue::text(text))
}

pub(super) fn matched(context: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let pattern = context.state.pattern(string(arguments, 1)?)?;
    let (template, which) = text_and_number(arguments)?;
    let (text, wanted) = (string(arguments, 0)?, (template, which.unwrap_or(1).max(1)));
    let found = search(context, |_, budget| pattern.nth_within(text, wanted, budget))?.unwrap_or_default();
    context.state.check_text(found.len())?;
    Ok(MacroValue::text(found))
}

pub(super) fn split(context: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let pattern = context.state.pattern(string(arguments, 1)?)?;
    let limit = if arguments.len() > 2 { count(number(arguments, 2)?) } else { 0 };
    let text = string(arguments, 0)?;
    let pieces = search(context, |state, budget| pattern.split_within(text, (limit, state.limits.elements), budget))?;
    Ok(MacroValue::sequence(pieces.into_iter().map(MacroValue::text).collect()))
}

pub(super) fn formatted(context: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let format = context.state.format(string(arguments, 0)?, false)?;
    arguments.iter().try_for_each(|value| pay_to_write(context.state, value))?;
    let mut out = String::new();
    crate::format::write(&mut out, &format, arguments.get(1..).unwrap_or(&[]), context.host)?;
    context.state.check_text(out.len())?;
    Ok(MacroValue::text(out))
}

/// A text that may be longer than its source.
fn made(context: &FunctionContext<'_>, text: String) -> Outcome<MacroValue> {
    context.state.check_text(text.len())?;
    Ok(MacroValue::text(text))
}

pub(super) fn lower(context: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    made(context, string(arguments, 0)?.to_lowercase())
}

pub(super) fn upper(context: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    made(context, string(arguments, 0)?.to_uppercase())
}

/// Characters of a trim mask in ascending order; `a..b` is a range.
fn mask(arguments: &[MacroValue]) -> Outcome<Vec<(char, char)>> {
    if arguments.len() < 2 {
        return Ok(['\0', '\t', '\n', '\u{b}', '\r', ' '].map(|c| (c, c)).to_vec());
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
    // In order, each range with the furthest end so far, so that a character is found by halving.
    ranges.sort_unstable();
    let mut end = '\0';
    for range in &mut ranges {
        end = end.max(range.1);
        range.1 = end;
    }
    Ok(ranges)
}

fn trimmed(arguments: &[MacroValue], left: bool, right: bool) -> Outcome<MacroValue> {
    let mask = mask(arguments)?;
    let cut = |c: char| {
        let at = mask.partition_point(|(low, _)| *low <= c);
        at.checked_sub(1).and_then(|at| mask.get(at)).is_some_and(|(_, end)| c <= *end)
    };
    let mut text = string(arguments, 0)?;
    if left {
        text = text.trim_start_matches(cut);
    }
    if right {
        text = text.trim_end_matches(cut);
    }
    Ok(MacroValue::text(text))
}

pub(super) fn trim(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    trimmed(arguments, true, true)
}

pub(super) fn trim_left(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    trimmed(arguments, true, false)
}

pub(super) fn trim_right(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    trimmed(arguments, false, true)
}

pub(super) fn element(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let (list, index) = (elements(arguments, 0)?, number(arguments, 1)?);
    let found = if index >= 1.0 { list.get(count(index) - 1) } else { None };
    let message = || format!("index {} is outside 1 to {}", index.trunc(), list.len());
    found.cloned().ok_or_else(|| MacroFault::new(DiagnosticNumber::OUT_OF_RANGE, message()))
}

fn part(arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let (from, to) = (number(arguments, 1)?, number(arguments, 2)?);
    if from < 1.0 || to < 0.0 {
        return Err(MacroFault::new(DiagnosticNumber::OUT_OF_RANGE, "positions of a part count from 1"));
    }
    #[allow(clippy::cast_possible_truncation)]
    range(arguments.first().unwrap_or(&MacroValue::Unset), from as i64, to as i64)
}

pub(super) fn part_of_sequence(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    elements(arguments, 0)?;
    part(arguments)
}

pub(super) fn part_of_text(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    string(arguments, 0)?;
    part(arguments)
}

pub(super) fn sequence(context: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    sequence_of(context.state, arguments.iter())
}
