//! Subprogram calls and returns.
//!
//! Facts: reference control-emulator.md 5.7. Control moves on at the end of the block, so that the rest of the block
//! acts first.

use crate::context::ActionContext;
use crate::entry::{ActionEntry, CompensationEffect};
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::codes;
use counterpoint_machine::ident::data;
use counterpoint_machine::model::CallForm;

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    ActionEntry::of(&[codes::CALSUB_ID], |act, _, _| call(act)).contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::CALSUB_RANGE], |act, _, _| call_range(act)).contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::CALSUB_RETURN], |act, _, _| return_from(act)).contour(CompensationEffect::Waits),
];

/// Call by number, by name, or from a sequence number of the same program.
pub(crate) fn call(act: &mut ActionContext<'_, '_>) -> Acted {
    let id = act.take(data::CALSUB_ID).map(|d| d.value);
    let repeat = act.take(data::CALSUB_REPEAT).map(|d| d.value);
    if id.is_none()
        && let Some(name) = act.take_name()
    {
        let passes = repeat.map_or(1, |count| act.passes(count)).max(1);
        act.call_named(name, passes);
        return Ok(());
    }
    if id.is_none()
        && let Some(first) =
            [data::CALSUB_BLOCK_START, data::CALSUB_SEQUENCE].into_iter().find_map(|id| act.take(id)).map(|d| d.value)
        && let Some(first) = sequence(first)
    {
        let passes = repeat.map_or(1, |count| act.passes(count)).max(1);
        act.call_from(first, passes);
        return Ok(());
    }
    let Some(id) = id.filter(|v| *v >= 1.0 && *v <= f64::from(u32::MAX) && v.fract() == 0.0) else {
        let text = format!("a call needs a program number in '{}'", act.channel().block_text());
        return Err(act.alarm(&diag::SUBPROGRAM_MISSING, text));
    };
    let id = id as u32;
    let (number, packed) = match act.channel().env.machine.subprograms.call {
        // O0012 called 3 times is P30012; a number of up to four digits is only that.
        CallForm::RepeatAndNumber if repeat.is_none() && id > 9999 => (id % 10_000, id / 10_000),
        _ => (id, 1),
    };
    let passes = repeat.map_or(packed, |count| act.passes(count));
    // Mitsubishi M98 P H, Mazak M98 P Q: the call begins at a sequence number of the program.
    match act.take(data::CALSUB_BLOCK_START).and_then(|first| sequence(first.value)) {
        Some(first) => act.call_program_from(number, first, passes.max(1)),
        None => act.call_program(number, passes.max(1)),
    }
    Ok(())
}

/// A sequence number at which a call begins.
fn sequence(value: f64) -> Option<u32> {
    (value >= 1.0 && value <= f64::from(u32::MAX) && value.fract() == 0.0).then_some(value as u32)
}

/// Call of the blocks from one sequence number or label to another in the current file; without the other, to a return.
pub(crate) fn call_range(act: &mut ActionContext<'_, '_>) -> Acted {
    let numbers = [data::CALSUB_BLOCK_START, data::CALSUB_BLOCK_END].map(|id| act.take(id).map(|d| d.value));
    let labels = [data::LABEL, data::LABEL_END].map(|id| act.take(id).map(|d| d.value));
    let repeat = act.take(data::RANGE_REPEAT).map(|d| d.value);
    let by_labels = numbers == [None; 2] && labels != [None; 2];
    let number = |v: f64| (v >= 0.0 && v <= f64::from(u32::MAX) && v.fract() == 0.0).then_some(v as u32);
    let [first, last] = if by_labels { labels } else { numbers }.map(|value| value.and_then(number));
    if let (Some(first), None) = (first, numbers[1])
        && !by_labels
    {
        let passes = repeat.map_or(1, |count| act.passes(count)).max(1);
        act.call_from(first, passes);
        return Ok(());
    }
    let (Some(first), Some(last)) = (first, last) else {
        let what = if by_labels { "label" } else { "sequence number" };
        let text = format!("a range call needs its first and last {what} in '{}'", act.channel().block_text());
        return Err(act.alarm(&diag::SUBPROGRAM_MISSING, text));
    };
    let passes = repeat.map_or(1, |count| act.passes(count)).max(1);
    act.call_range(by_labels, (first, last), passes);
    Ok(())
}

/// Return, optionally to a sequence number of the caller.
pub(crate) fn return_from(act: &mut ActionContext<'_, '_>) -> Acted {
    let target = act.take(data::CALSUB_ID).map(|d| d.value).filter(|v| *v >= 1.0 && v.fract() == 0.0);
    act.return_from(target.map(|v| v.min(f64::from(u32::MAX)) as u32));
    Ok(())
}
