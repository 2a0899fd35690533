//! `$FGET`, `$FGETR`, `$FEOF`: looking through the program without moving the reading position.
//!
//! Facts: reference functions.md 9; the block in process is not looked at.

use counterpoint_lang::fault::{MacroFault, Outcome};
use counterpoint_lang::pattern::STEPS;
use counterpoint_lang::value::MacroValue;
use counterpoint_lang::vm::MacroState;

use crate::context::KernelHost;
use counterpoint_channel::macros::store::names;

/// Whether the program has no further block.
pub(crate) fn at_end(host: &KernelHost<'_, '_>) -> bool {
    let Some(frame) = host.kernel.flow.frames.last() else { return true };
    let Some(source) = host.kernel.channel.env.sources.get(frame.file) else { return true };
    !(frame.next..=frame.range.last).any(|line| !source.line(line).trim_ascii().is_empty())
}

pub(crate) fn search_program(
    host: &mut KernelHost<'_, '_>,
    state: &mut MacroState,
    arguments: &[MacroValue],
    forward: bool,
) -> Outcome<MacroValue> {
    let single;
    let expressions = match arguments.first() {
        Some(MacroValue::Sequence(all)) => all.as_slice(),
        Some(one) => {
            single = [one.clone()];
            &single
        }
        None => &[],
    };
    let mut patterns = Vec::new();
    for expression in expressions {
        let text = expression.as_text().ok_or_else(|| MacroFault::kind("a regular expression", expression))?;
        patterns.push(state.pattern(text)?);
    }
    let Some((file, range, next)) = host.kernel.flow.frames.last().map(|f| (f.file, f.range, f.next)) else {
        return Ok(MacroValue::Real(0.0));
    };
    let record = |at: usize| arguments.get(at).and_then(MacroValue::as_real).map_or(0, |number| number.max(0.0) as u32);
    let (start, end) = (record(1), record(2));
    let sources = host.kernel.channel.env.sources;
    let Some(source) = sources.get(file) else { return Ok(MacroValue::Real(0.0)) };
    let here = next.saturating_sub(1);
    let (mut line, last, step) = if forward {
        let first = if start == 0 { here + 1 } else { start };
        (first.max(range.first), if end == 0 { range.last } else { end.min(range.last) }, 1_i64)
    } else {
        let first = if start == 0 { here.saturating_sub(1) } else { start };
        (first.min(range.last), end.max(range.first), -1)
    };
    let mut budget = STEPS;
    while if forward { line <= last } else { line >= last && line > 0 } {
        let text = String::from_utf8_lossy(source.line(line));
        for pattern in &patterns {
            state.spend(2 + text.len() / 16)?;
            let before = budget;
            let found = pattern.find(&text, 0, &mut budget);
            state.spend(usize::try_from((before - budget) / 8).unwrap_or(usize::MAX))?;
            if found?.is_some() {
                let text = text.into_owned();
                host.kernel.macros.variables.store.set(names().mcdrd, MacroValue::text(text));
                return Ok(MacroValue::Real(f64::from(line)));
            }
        }
        line = u32::try_from(i64::from(line) + step).unwrap_or(0);
    }
    Ok(MacroValue::Real(0.0))
}
