//! Variables of threads and their cycles: `$PITCH`, `$E`, `$TH…`.
//!
//! *Invariant:* they are those of the last thread; a value that a macro sets counts for threads without the word.
//! Depth, first step and passes that a macro sets are those of one cycle. Facts: reference system-variables.md 8, 9.

use counterpoint_lang::fault::Outcome;
use counterpoint_lang::value::MacroValue;

use super::{Read, Write};
use counterpoint_channel::modal::group;
use counterpoint_channel::thread::Threading;
use counterpoint_emulator::channel::Kernel;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::kind::thread::ThreadCycle;
use counterpoint_machine::ident::{CodeId, DataId, data};

fn real(value: &MacroValue) -> f64 {
    value.as_real().filter(|value| value.is_finite()).unwrap_or(0.0)
}

fn known(kernel: &Kernel<'_>, id: DataId) -> f64 {
    kernel.channel.state.remembered.value(id).unwrap_or(0.0)
}

fn remember(kernel: &mut Kernel<'_>, id: DataId, value: f64) -> Outcome<()> {
    kernel.channel.state.remembered.remember(id, value);
    Ok(())
}

const PITCH: DataId = data::INTERP_THREAD_PITCH;
const CHANGE: DataId = data::INTERP_THREAD_PITCH_VAR;

/// How a variable is read and written.
pub(crate) fn find(name: &str) -> Option<(Read, Option<Write>)> {
    let row: (Read, Option<Write>) = match name {
        "$PITCH" => (|k, _| MacroValue::Real(known(k, PITCH)), Some(|k, _, value| remember(k, PITCH, real(value)))),
        "$PITCHV" => (|k, _| MacroValue::Real(known(k, CHANGE)), Some(|k, _, value| remember(k, CHANGE, real(value)))),
        "$MULTRD" => (
            |k, _| MacroValue::Real(k.channel.state.threads.starts),
            Some(|k, _, value| {
                let starts = real(value).max(1.0);
                k.channel.state.threads.starts = starts;
                remember(k, data::INTERP_THREAD_STARTS, starts)
            }),
        ),
        "$E" => (
            |k, _| MacroValue::Real(known(k, PITCH) * k.channel.state.threads.starts),
            Some(|k, _, value| remember(k, PITCH, real(value) / k.channel.state.threads.starts)),
        ),
        "$EV" => (
            |k, _| MacroValue::Real(known(k, CHANGE) * k.channel.state.threads.starts),
            Some(|k, _, value| remember(k, CHANGE, real(value) / k.channel.state.threads.starts)),
        ),
        _ => return cycle(name),
    };
    Some(row)
}

/// `$THTYPE`: the cycle whose code is active, otherwise the one that acted in this block.
fn kind(kernel: &Kernel<'_>) -> f64 {
    let active = [group::MOTION, group::CYCLE].into_iter().filter_map(|group| kernel.channel.state.modal.code(group));
    let active = active.map(CodeId::kind).find_map(|kind| match kind {
        CodeKind::ThreadCycle(cycle) => Some(cycle),
        _ => None,
    });
    active
        .or_else(|| kernel.channel.state.threads.cycle.acting(kernel.channel.at.blocks))
        .map_or(0.0, ThreadCycle::number)
}

/// Sets something that lasts.
fn set(kernel: &mut Kernel<'_>, change: impl FnOnce(&mut Threading)) -> Outcome<()> {
    change(&mut kernel.channel.state.threads.cycle);
    Ok(())
}

/// Sets something of the cycle to come.
fn next(kernel: &mut Kernel<'_>, change: impl FnOnce(&mut Threading)) -> Outcome<()> {
    kernel.channel.state.threads.cycle.prepare();
    change(&mut kernel.channel.state.threads.cycle);
    Ok(())
}

/// A value above nothing.
fn programmed(value: &MacroValue) -> Option<f64> {
    Some(real(value).abs()).filter(|value| *value > 0.0)
}

/// `$TH…`
fn cycle(name: &str) -> Option<(Read, Option<Write>)> {
    let row: (Read, Option<Write>) = match name {
        "$THTYPE" => (|k, _| MacroValue::Real(kind(k)), None),
        "$THMODE" => (
            |k, _| MacroValue::Real(f64::from(k.channel.state.threads.cycle.mode)),
            Some(|k, _, value| set(k, |cycle| cycle.mode = real(value).clamp(0.0, 4.0) as u8)),
        ),
        "$THDPTH" => (
            |k, _| MacroValue::Real(k.channel.state.threads.cycle.depth.unwrap_or(0.0)),
            Some(|k, _, value| next(k, |cycle| cycle.depth = programmed(value))),
        ),
        "$THSTEP" => (
            |k, _| MacroValue::Real(k.channel.state.threads.cycle.step.unwrap_or(0.0)),
            Some(|k, _, value| next(k, |cycle| cycle.step = programmed(value))),
        ),
        "$THCUTS" => (
            |k, _| MacroValue::Real(k.channel.state.threads.cycle.passes()),
            Some(|k, _, value| next(k, |cycle| cycle.cuts = programmed(value).map(f64::trunc))),
        ),
        "$THMIN" => (
            |k, _| MacroValue::Real(k.channel.state.threads.cycle.least),
            Some(|k, _, value| set(k, |cycle| cycle.least = real(value).abs())),
        ),
        "$THFINC" => (
            |k, _| MacroValue::Real(k.channel.state.threads.cycle.finish_cuts),
            Some(|k, _, value| set(k, |cycle| cycle.finish_cuts = real(value).clamp(0.0, 99.0).trunc())),
        ),
        "$THFINA" => (
            |k, _| MacroValue::Real(k.channel.state.threads.cycle.finish),
            Some(|k, _, value| set(k, |cycle| cycle.finish = real(value).abs())),
        ),
        "$THNOSE" => (
            |k, _| MacroValue::Real(k.channel.state.threads.cycle.nose),
            Some(|k, _, value| set(k, |cycle| cycle.nose = real(value).clamp(0.0, 170.0))),
        ),
        "$THCHFT" => (
            |k, _| MacroValue::Real(f64::from(u8::from(k.channel.state.threads.cycle.pull_out.on))),
            Some(|k, _, value| set(k, |cycle| cycle.pull_out.on = real(value) != 0.0)),
        ),
        "$THCHFL" => (
            |k, _| MacroValue::Real(k.channel.state.threads.cycle.pull_out.length),
            Some(|k, _, value| set(k, |cycle| cycle.set_chamfer(real(value).abs()))),
        ),
        "$THCHFA" => (
            |k, _| MacroValue::Real(k.channel.state.threads.cycle.pull_out.angle),
            Some(|k, _, value| set(k, |cycle| cycle.pull_out.angle = real(value).clamp(10.0, 80.0))),
        ),
        _ => return None,
    };
    Some(row)
}
