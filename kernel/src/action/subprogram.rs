//! Subprogram calls and returns.
//!
//! Facts: reference control-emulator.md 5.7. Control moves on at the end of the block, so that the rest of the block
//! acts first.

use crate::channel::Kernel;
use crate::channel::flow::Callee;
use crate::channel::flow::Pending;
use crate::diag;
use crate::machine::ident::data;
use crate::machine::model::CallForm;
use counterpoint_fault::Acted;

/// Call by number, or by name.
pub(super) fn call(kernel: &mut Kernel<'_>) -> Acted {
    let id = kernel.take(data::CALSUB_ID).map(|d| d.value);
    let repeat = kernel.take(data::CALSUB_REPEAT).map(|d| d.value);
    if id.is_none()
        && let Some(name) = kernel.take_name()
    {
        let passes = repeat.map_or(1, |count| passes(kernel, count)).max(1);
        kernel.ask(Pending::Call { what: Callee::Named(name), passes, arguments: None, by: None });
        return Ok(());
    }
    let Some(id) = id.filter(|v| *v >= 1.0 && *v <= f64::from(u32::MAX) && v.fract() == 0.0) else {
        let text = format!("a call needs a program number in '{}'", kernel.block_text());
        return Err(kernel.alarm(&diag::SUBPROGRAM_MISSING, text));
    };
    let id = id as u32;
    let (number, packed) = match kernel.channel.env.machine.subprograms.call {
        // O0012 called 3 times is P30012; a number of up to four digits is only that.
        CallForm::RepeatAndNumber if repeat.is_none() && id > 9999 => (id % 10_000, id / 10_000),
        _ => (id, 1),
    };
    let passes = repeat.map_or(packed, |count| passes(kernel, count));
    let (what, passes) = (Callee::Program(number), passes.max(1));
    kernel.ask(Pending::Call { what, passes, arguments: None, by: None });
    Ok(())
}

/// Call of the blocks from one sequence number or label to another in the current file.
pub(super) fn call_range(kernel: &mut Kernel<'_>) -> Acted {
    let numbers = [data::CALSUB_BLOCK_START, data::CALSUB_BLOCK_END].map(|id| kernel.take(id).map(|d| d.value));
    let labels = [data::LABEL, data::LABEL_END].map(|id| kernel.take(id).map(|d| d.value));
    let repeat = kernel.take(data::RANGE_REPEAT).map(|d| d.value);
    let by_labels = numbers == [None; 2] && labels != [None; 2];
    let number = |v: f64| (v >= 0.0 && v <= f64::from(u32::MAX) && v.fract() == 0.0).then_some(v as u32);
    let [first, last] = if by_labels { labels } else { numbers }.map(|value| value.and_then(number));
    let (Some(first), Some(last)) = (first, last) else {
        let what = if by_labels { "label" } else { "sequence number" };
        let text = format!("a range call needs its first and last {what} in '{}'", kernel.block_text());
        return Err(kernel.alarm(&diag::SUBPROGRAM_MISSING, text));
    };
    let passes = repeat.map_or(1, |count| passes(kernel, count)).max(1);
    let what = if by_labels { Callee::Labels(first, last) } else { Callee::Blocks(first, last) };
    kernel.ask(Pending::CallRange { what, passes });
    Ok(())
}

/// Passes of a repeat word.
pub(crate) fn passes(kernel: &mut Kernel<'_>, count: f64) -> u32 {
    if count < 0.0 || count.fract() != 0.0 {
        let text = format!("a repeat count is a whole number from 0 in '{}'", kernel.block_text());
        kernel.diagnose(&diag::DATA_OUT_OF_RANGE, text);
        return 1;
    }
    let count = count.min(f64::from(u32::MAX - 1)) as u32;
    if kernel.channel.env.machine.subprograms.repeat_is_executions { count } else { count + 1 }
}

/// Return, optionally to a sequence number of the caller.
pub(super) fn give_back(kernel: &mut Kernel<'_>) -> Acted {
    let target = kernel.take(data::CALSUB_ID).map(|d| d.value).filter(|v| *v >= 1.0 && v.fract() == 0.0);
    kernel.ask(Pending::Return(target.map(|v| v.min(f64::from(u32::MAX)) as u32)));
    Ok(())
}
