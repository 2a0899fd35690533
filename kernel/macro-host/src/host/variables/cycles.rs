//! Variables of canned cycles: `$CY…` and `$CRMODE`.
//!
//! *Invariant:* a value that is set before the first code of a cycle belongs to that cycle. Facts: reference
//! system-variables.md 8.

use counterpoint_channel::cycle::{Cycle, Height};
use counterpoint_channel::macro_queries::activate_code;
use counterpoint_channel::modal::group;
use counterpoint_emulator::channel::Kernel;
use counterpoint_event::event::FeedUnit;
use counterpoint_event::info::MachineUnit;
use counterpoint_lang::fault::Outcome;
use counterpoint_lang::value::MacroValue;
use counterpoint_machine::ident::codes;

use super::{Read, Write};

fn optional(value: Option<f64>) -> MacroValue {
    value.map_or(MacroValue::Null, MacroValue::Real)
}

fn height(value: Option<Height>) -> MacroValue {
    MacroValue::Real(value.map_or(0.0, |height| height.value))
}

/// Sets a datum of the running cycle, or of the next one.
fn set(kernel: &mut Kernel<'_>, change: impl FnOnce(&mut Cycle)) -> Outcome<()> {
    let machine = kernel.channel.env.machine;
    kernel.channel.state.cycle.prepare(machine);
    change(&mut kernel.channel.state.cycle);
    Ok(())
}

/// A number that is set; anything else counts as none.
fn real(value: &MacroValue) -> Option<f64> {
    value.as_real().filter(|number| number.is_finite())
}

fn number(value: &MacroValue) -> f64 {
    real(value).unwrap_or(0.0)
}

/// The changed height; it remains a position or a distance.
fn changed(old: Option<Height>, value: &MacroValue) -> Option<Height> {
    let relative = old.is_some_and(|height| height.relative);
    real(value).map(|value| Height { value, relative })
}

fn shift<const AT: usize>() -> (Read, Option<Write>) {
    (
        |k, _| optional(k.channel.state.cycle.boring.shifts.get(AT).copied().flatten()),
        Some(|k, _, value| {
            set(k, |cycle| {
                if let Some(slot) = cycle.boring.shifts.get_mut(AT) {
                    *slot = real(value);
                }
            })
        }),
    )
}

fn dwell<const AT: usize>() -> (Read, Option<Write>) {
    (
        |k, _| MacroValue::Real(k.channel.state.cycle.rates.dwell.get(AT).copied().unwrap_or(0.0)),
        Some(|k, _, value| {
            set(k, |cycle| {
                if let Some(slot) = cycle.rates.dwell.get_mut(AT) {
                    *slot = number(value);
                }
            })
        }),
    )
}

/// `$CYFEDT`: 1 and 2 inches per minute and revolution, 3 and 4 millimetres.
fn feed_kind(kernel: &Kernel<'_>, _: &[i64]) -> MacroValue {
    let per_revolution = kernel.channel.state.cycle.rates.feed.1 == FeedUnit::PerRevolution;
    let inch = kernel.channel.env.machine.unit == MachineUnit::Inch;
    MacroValue::Real(match (inch, per_revolution) {
        (true, false) => 1.0,
        (true, true) => 2.0,
        (false, false) => 3.0,
        (false, true) => 4.0,
    })
}

/// 5 and 6 are in the unit of the machine.
fn set_feed_kind(kernel: &mut Kernel<'_>, _: &[i64], value: &MacroValue) -> Outcome<()> {
    let per_revolution = [2.0, 4.0, 6.0].contains(&number(value));
    set(kernel, |cycle| {
        cycle.rates.feed.1 = if per_revolution { FeedUnit::PerRevolution } else { FeedUnit::PerMinute };
    })
}

fn retract_mode(kernel: &Kernel<'_>, _: &[i64]) -> MacroValue {
    MacroValue::Real(match kernel.channel.state.modal.code(group::RETRACT) {
        Some(codes::CYCLE_RETRACT_INITIAL) => 0.0,
        Some(codes::CYCLE_RETRACT_R) => 1.0,
        _ => -1.0,
    })
}

fn set_retract_mode(kernel: &mut Kernel<'_>, _: &[i64], value: &MacroValue) -> Outcome<()> {
    let stays = number(value) >= 1.0;
    activate_code(&mut kernel.channel, if stays { codes::CYCLE_RETRACT_R } else { codes::CYCLE_RETRACT_INITIAL });
    Ok(())
}

/// How a variable is read and written.
pub(crate) fn find(name: &str) -> Option<(Read, Option<Write>)> {
    let row: (Read, Option<Write>) = match name {
        "$CYTYPE" => (
            |k, _| MacroValue::Real(k.channel.state.cycle.number),
            Some(|k, _, value| set(k, |cycle| cycle.number = number(value))),
        ),
        "$CYMCH" => (
            |k, _| MacroValue::Logical(k.channel.state.cycle.running),
            Some(|k, _, value| {
                k.channel.state.cycle.running = value.as_logical() == Some(true);
                Ok(())
            }),
        ),
        "$CRMODE" => (retract_mode, Some(set_retract_mode)),
        "$CYCLRP" => (
            |k, _| height(k.channel.state.cycle.heights.clear),
            Some(|k, _, value| set(k, |cycle| cycle.heights.clear = changed(cycle.heights.clear, value))),
        ),
        "$CYDPTH" => (
            |k, _| height(k.channel.state.cycle.heights.depth),
            Some(|k, _, value| set(k, |cycle| cycle.heights.depth = changed(cycle.heights.depth, value))),
        ),
        "$CYRETN" => (
            |k, _| optional(k.channel.state.cycle.heights.retract.map(|height| height.value)),
            Some(|k, _, value| set(k, |cycle| cycle.heights.retract = changed(cycle.heights.retract, value))),
        ),
        "$CYCLRO" => (
            |k, _| MacroValue::Real(k.channel.state.cycle.boring.shift),
            Some(|k, _, value| set(k, |cycle| cycle.boring.shift = number(value))),
        ),
        "$CYCLRX" => shift::<0>(),
        "$CYCLRY" => shift::<1>(),
        "$CYCLRZ" => shift::<2>(),
        "$CYINCR" => (
            |k, _| optional(k.channel.state.cycle.pecks.first),
            Some(|k, _, value| set(k, |cycle| cycle.pecks.first = real(value).map(f64::abs))),
        ),
        "$CYDECR" => (
            |k, _| MacroValue::Real(k.channel.state.cycle.pecks.decrement),
            Some(|k, _, value| set(k, |cycle| cycle.pecks.decrement = number(value).abs())),
        ),
        "$CYMIN" => (
            |k, _| MacroValue::Real(k.channel.state.cycle.pecks.least),
            Some(|k, _, value| set(k, |cycle| cycle.pecks.least = number(value).max(0.0))),
        ),
        "$CYDWEL" => dwell::<0>(),
        "$CYDWLS" => dwell::<1>(),
        "$CYDWLT" => dwell::<2>(),
        "$CYFEDT" => (feed_kind, Some(set_feed_kind)),
        "$CYFEDV" => (
            |k, _| MacroValue::Real(k.channel.state.cycle.rates.feed.0.unwrap_or(0.0)),
            Some(|k, _, value| set(k, |cycle| (cycle.rates.feed.0, cycle.rates.own_feed) = (real(value), true))),
        ),
        "$CYORNT" => (
            |k, _| MacroValue::Real(k.channel.state.cycle.boring.orient),
            Some(|k, _, value| set(k, |cycle| cycle.boring.orient = number(value))),
        ),
        "$CYRATIO" => (
            |k, _| MacroValue::Real(k.channel.state.cycle.rates.ratio),
            Some(|k, _, value| set(k, |cycle| cycle.rates.ratio = real(value).filter(|n| *n > 0.0).unwrap_or(1.0))),
        ),
        "$CYRIGID" => (
            |k, _| MacroValue::Real(k.channel.state.cycle.rigid),
            Some(|k, _, value| set(k, |cycle| cycle.rigid = number(value))),
        ),
        "$CYDIR" => (|k, _| MacroValue::Real(k.channel.state.cycle.direction), None),
        _ => return None,
    };
    Some(row)
}
