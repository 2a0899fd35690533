//! Dwells: seconds or spindle revolutions.

use counterpoint_channel::plausible::{LONGEST_DWELL, hours};
use counterpoint_channel::spindle::stopped;
use counterpoint_event::event::{Dwell, Kind};
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_lang::format::wildcard_text;
use counterpoint_machine::ident::{DataId, codes, data};
use counterpoint_motion::law::SpindleRotation;

use crate::context::ActionContext;
use crate::entry::{ActionEntry, CompensationEffect};

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    ActionEntry::of(&[codes::DELAY], |act, _, _| seconds(act)).contour(CompensationEffect::Waits),
    ActionEntry::of(&[codes::DELAY_REV], |act, _, _| revolutions(act)),
];

/// Dwell in seconds.
pub(crate) fn seconds(act: &mut ActionContext<'_, '_>) -> Acted {
    let Some(seconds) = take_seconds(act, data::DELAY) else {
        if act.channel().env.machine.habits.dwell.bare {
            return super::mode::exact_stop_block(act);
        }
        let text = format!("a dwell needs its time in '{}'", act.channel().block_text());
        act.diagnose(&diag::DATA_MISSING, text);
        return Ok(());
    };
    dwell(act, seconds)
}

/// Dwell in revolutions of the spindle.
pub(crate) fn revolutions(act: &mut ActionContext<'_, '_>) -> Acted {
    let Some(datum) = act.take(data::DELAY_REV) else {
        let text = format!("a dwell needs its revolutions in '{}'", act.channel().block_text());
        act.diagnose(&diag::DATA_MISSING, text);
        return Ok(());
    };
    turns(act, datum.value)
}

/// Takes a time, seconds. On some controls a decimal point makes seconds of a word in thousandths.
pub(crate) fn take_seconds(act: &mut ActionContext<'_, '_>, id: DataId) -> Option<f64> {
    let pointed = act.channel().env.machine.habits.dwell.pointed && is_pointed(act, id);
    act.take(id).map(|datum| if pointed { datum.raw } else { datum.value })
}

/// Takes a factor. On some controls a decimal point makes it the factor itself.
pub(crate) fn take_factor(act: &mut ActionContext<'_, '_>, id: DataId) -> Option<f64> {
    let pointed = act.channel().env.machine.habits.pointed_factors && is_pointed(act, id);
    act.take(id).map(|datum| if pointed { datum.raw } else { datum.value })
}

/// Whether the word that supplies a value counts thousandths or less and has a decimal point.
fn is_pointed(act: &ActionContext<'_, '_>, id: DataId) -> bool {
    let sources = act.sources(id).iter();
    let found = sources.filter_map(|source| Some((source.mul, act.channel().block.look(source.register)?))).next();
    let Some((mul, word)) = found.filter(|(mul, _)| mul.abs() <= 0.001) else { return false };
    let text = act.channel().word_bytes(&word);
    // A point within an expression is not a written point.
    mul != 0.0 && text.contains(&b'.') && !text.iter().any(|byte| matches!(byte, b'#' | b'['))
}

fn turns(act: &mut ActionContext<'_, '_>, revolutions: f64) -> Acted {
    let minutes = match act.speed_from_now()? {
        Some(SpindleRotation::Driven(driven, elapsed)) => driven.minutes_of(elapsed, revolutions),
        Some(turning) => {
            revolutions / turning.rpm(act.channel().state.place.radius(&act.channel().state.place.position))
        }
        None => {
            let text =
                format!("{} in the dwell in revolutions '{}'", stopped(act.channel()), act.channel().block_text());
            act.diagnose(&diag::SPINDLE_STANDS, text);
            return Ok(());
        }
    };
    let seconds = minutes * 60.0;
    act.assume_speed(seconds);
    if seconds > 0.0 {
        act.trace_instead(&format!("dwell rev={}", wildcard_text(revolutions)));
    }
    dwell(act, seconds)
}

/// A dwell of a cycle: positive seconds, negative revolutions, 0 none.
pub(crate) fn of_cycle(act: &mut ActionContext<'_, '_>, amount: f64) -> Acted {
    if amount < 0.0 {
        return turns(act, -amount);
    }
    if amount > 0.0 { dwell(act, amount) } else { Ok(()) }
}

fn dwell(act: &mut ActionContext<'_, '_>, seconds: f64) -> Acted {
    if seconds <= 0.0 {
        let text = format!("a dwell of {seconds} s in '{}' takes no time", act.channel().block_text());
        act.diagnose(&diag::DWELL_NOT_POSITIVE, text);
        return Ok(());
    }
    if seconds > LONGEST_DWELL && !std::mem::replace(&mut act.channel_mut().reports.plausible.dwell, true) {
        let text =
            format!("a dwell of {} in '{}': check the unit of its time", hours(seconds), act.channel().block_text());
        act.diagnose(&diag::LONG_DWELL, text);
    }
    let ns = counterpoint_channel::at::nanoseconds(seconds);
    act.channel_mut().emit(ns, Kind::Dwell(Dwell));
    act.channel_mut().advance(ns);
    act.note_dwell(ns);
    Ok(())
}
