//! Names of files, command lines, settings, sorting.

use super::{FunctionContext, count, number, real, string};
use crate::fault::Outcome;
use crate::host::HostFn;
use crate::ident;
use crate::value::{MacroValue, ValueType};
use std::cmp::Ordering;

pub(super) fn at_end(context: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    if arguments.is_empty() {
        return context.host.function(context.state, HostFn::EndOfProgram, arguments);
    }
    context.state.unit_at_end(number(arguments, 0)?).map(MacroValue::Logical)
}

const SEPARATORS: [char; 2] = ['/', '\\'];

pub(super) fn base_name(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let path = string(arguments, 0)?;
    let mut name = path.rsplit(SEPARATORS).next().unwrap_or(path);
    if arguments.len() > 1
        && let Some(at) = name.rfind(string(arguments, 1)?)
    {
        name = name.get(..at).unwrap_or(name);
    }
    Ok(MacroValue::text(name))
}

pub(super) fn directory(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let path = string(arguments, 0)?;
    Ok(MacroValue::text(path.rfind(SEPARATORS).and_then(|at| path.get(..at)).unwrap_or("")))
}

/// Arguments of a text, or of the command line the host knows.
fn split(context: &mut FunctionContext<'_>, arguments: &[MacroValue], position: usize) -> Outcome<Vec<String>> {
    let text = match arguments.get(position) {
        Some(_) => string(arguments, position)?.to_owned(),
        None => context.host.setting(false, "$PARAM").unwrap_or_default(),
    };
    if arguments.len() > position + 1 {
        let separator = string(arguments, position + 1)?;
        if !separator.is_empty() {
            context.state.spend(text.matches(separator).count())?;
            return Ok(text.split(separator).map(str::to_owned).collect());
        }
    }
    let (mut parts, mut current, mut quoted, mut open) = (Vec::new(), String::new(), false, false);
    for c in text.chars() {
        match c {
            '"' => {
                quoted = !quoted;
                open = true;
                current.push(c);
            }
            ' ' | '\t' if !quoted => {
                if open {
                    parts.push(std::mem::take(&mut current));
                }
                open = false;
            }
            c => {
                open = true;
                current.push(c);
            }
        }
    }
    if open {
        parts.push(current);
    }
    context.state.spend(parts.len())?;
    Ok(parts)
}

pub(super) fn argument_count(context: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    Ok(real(split(context, arguments, 0)?.len()))
}

pub(super) fn argument(context: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let parts = split(context, arguments, 1)?;
    let position = number(arguments, 0)?;
    let found = if position >= 1.0 { parts.get(count(position) - 1) } else { None };
    Ok(MacroValue::text(found.map(String::as_str).unwrap_or("")))
}

fn qualifier(text: &str) -> Option<(&str, &str)> {
    let rest = text.trim().strip_prefix('/').or_else(|| text.trim().strip_prefix('-'))?;
    Some(rest.split_once('=').unwrap_or((rest, "")))
}

pub(super) fn qualifier_name(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    Ok(MacroValue::text(qualifier(string(arguments, 0)?).map_or("", |(name, _)| name)))
}

pub(super) fn qualifier_value(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let text = string(arguments, 0)?;
    Ok(MacroValue::text(qualifier(text).map_or(text, |(_, value)| value).replace('"', "")))
}

fn setting(context: &FunctionContext<'_>, definition: bool, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    Ok(context.host.setting(definition, string(arguments, 0)?).map_or(MacroValue::Null, MacroValue::text))
}

pub(super) fn environment(context: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    setting(context, false, arguments)
}

pub(super) fn definition(context: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    setting(context, true, arguments)
}

/// Sorts a sequence, optionally as rows of several columns, or a file into another one.
pub(super) fn sort(context: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let Some(MacroValue::Sequence(all)) = arguments.first() else { return super::sort::file(context, arguments) };
    let width = if arguments.len() > 1 { count(number(arguments, 1)?).max(1) } else { 1 };
    let mut keys = Vec::new();
    for pair in arguments.get(2..).unwrap_or(&[]).chunks(2) {
        let field = pair.first().and_then(MacroValue::as_real).map_or(0, count);
        let down = matches!(pair.get(1), Some(MacroValue::Keyword(code)) if ident::minor_name(*code) == Some("DECR"));
        if field < 1 || field > width {
            context.state.status = 22;
            return Ok(MacroValue::Null);
        }
        keys.push((field - 1, down));
    }
    if keys.is_empty() {
        keys.push((0, false));
    }
    if all.len() % width != 0 {
        context.state.status = 22;
        return Ok(MacroValue::Null);
    }
    // Every row meets about as many others as its number has bits.
    let rounds = (all.len() / width).max(1).ilog2() as usize + 1;
    for _ in 0..rounds {
        crate::state::pay_to_look_inside(context.state, all)?;
    }
    context.state.spend((all.len() / width).saturating_mul(keys.len()).saturating_mul(rounds) / 4)?;
    let mut rows: Vec<&[MacroValue]> = all.chunks(width).collect();
    rows.sort_by(|a, b| {
        keys.iter().fold(Ordering::Equal, |order, (field, down)| {
            let one = || match (a.get(*field), b.get(*field)) {
                (Some(x), Some(y)) => x.order(y).unwrap_or_else(|| rank(x).cmp(&rank(y))),
                _ => Ordering::Equal,
            };
            order.then_with(|| if *down { one().reverse() } else { one() })
        })
    });
    context.state.status = 0;
    Ok(MacroValue::sequence(rows.concat()))
}

/// Order of values of different types.
fn rank(value: &MacroValue) -> usize {
    let kind = value.kind();
    kind.and_then(|kind| ValueType::ALL.iter().position(|other| *other == kind)).map_or(0, |at| at + 1)
}
