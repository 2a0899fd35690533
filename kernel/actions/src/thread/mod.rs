//! Threads cut in one move: feed locked to the spindle.
//!
//! Facts: reference control-emulator.md 6.1 (lead = pitch · starts); the lead counts along the axis with the longer
//! travel as on the real control, unless a word names its axis; cycles of such moves are in `cycle`. *Invariant:* the
//! time is integrated exactly, with leads and speeds that change along the path. Decisions: docs/emulation.md,
//! "Threads".

mod arc;
pub(crate) mod cycle;

use counterpoint_channel::alarm_effect::NOT_DONE;
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::path_lengths::tool_path;
use counterpoint_channel::spindle::stopped;
use counterpoint_channel::thread::Screw;
use counterpoint_event::event::{FeedUnit, Motion, MotionKind, Position};
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::kind::thread::LeadChange;
use counterpoint_machine::ident::{DataId, codes, data};
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_motion::law::SpindleRotation;
use counterpoint_motion::thread::Lead;
use counterpoint_program::block::PendingCode;

use crate::context::{ActionContext, StraightSteps};
use crate::entry::{ActionEntry, CompensationEffect, entry_of_kind};
use crate::motion::moved_axes;
use crate::time::note_turning;
use counterpoint_channel::timed_path::{EVEN, TimedPath, rapid_seconds};

/// Codes with their actions.
pub(crate) const ENTRIES: &[ActionEntry] = &[
    entry_of_kind!(CodeKind::Thread(change) => |act, _row, code| thread(act, change, code))
        .moves()
        .contour(CompensationEffect::Leaves),
    ActionEntry::of(&[codes::INTERP_THREAD_ARC_CLW], |act, _row, code| arc::thread(act, true, code))
        .moves()
        .contour(CompensationEffect::Leaves),
    ActionEntry::of(&[codes::INTERP_THREAD_ARC_CCLW], |act, _row, code| arc::thread(act, false, code))
        .moves()
        .contour(CompensationEffect::Leaves),
    ActionEntry::of(&[codes::THREAD_LEAD_X], |act, _, _| lead_along(act, 0)),
    ActionEntry::of(&[codes::THREAD_LEAD_Z], |act, _, _| lead_along(act, 2)),
    ActionEntry::of(&[codes::INTERP_THREAD_OFF, codes::THREAD_OFF], |act, _, _| off(act))
        .contour(CompensationEffect::Leaves),
];

/// Cuts one pass.
pub(crate) fn thread(act: &mut ActionContext<'_, '_>, change: LeadChange, code: &PendingCode) -> Acted {
    let (pitch, sides) = take_pitch(act);
    let by_word = change == LeadChange::None && act.channel().env.machine.threads.changes;
    let change = take_change(act, if by_word { LeadChange::May } else { change }, code.modal);
    act.take(data::INTERP_THREAD_ANGLE);
    let starts = take_starts(act);
    act.channel_mut().state.threads.starts = starts;
    let (coded, target) = act.targets();
    if coded == 0 || target == act.channel().state.place.position {
        return Ok(());
    }
    let (pitch, along) =
        if sides == [None; 3] { (pitch, lead_axis(act.channel(), &target)) } else { by_axis(act, sides, &target) };
    if let Some(pitch) = pitch {
        remember_lead(act, pitch);
    }
    let screw = Screw { lead: pitch.unwrap_or(0.0) * starts, change: change * starts, along };
    act.channel_mut().state.threads.recorded = Some(screw);
    cut(act, coded, target, &screw)?;
    super::cutter::after_thread(act);
    Ok(())
}

/// Which axis leads count along, X (0) or Z (2).
fn lead_along(act: &mut ActionContext<'_, '_>, role: usize) -> Acted {
    act.channel_mut().state.threads.along = Some(role);
    Ok(())
}

/// Ends threads: moves are straight from here on.
pub(crate) fn off(act: &mut ActionContext<'_, '_>) -> Acted {
    super::motion::linear(act)
}

/// The pitch, and the pitches that count along X, Y and Z alone.
fn take_pitch(act: &mut ActionContext<'_, '_>) -> (Option<f64>, [Option<f64>; 3]) {
    let pitch = act.take(data::INTERP_THREAD_PITCH).map(|datum| datum.value);
    if let Some(lead) = pitch {
        remember_lead(act, lead);
        return (pitch, [None; 3]);
    }
    let sides = [data::INTERP_THREAD_PITCH_X, data::INTERP_THREAD_PITCH_Y, data::INTERP_THREAD_PITCH_Z];
    let sides = sides.map(|id| act.take(id).map(|datum| datum.value));
    (remembered_lead(act), sides)
}

/// The pitch along X, Y or Z and its axis. Of several pitches, that of the longest travel counts, and the last one of
/// equal travels. `None` if no axis with a pitch moves.
fn by_axis(act: &ActionContext<'_, '_>, sides: [Option<f64>; 3], target: &Position) -> (Option<f64>, Option<AxisSlot>) {
    let changes = act.channel().state.place.changes(&act.channel().state.place.position, target);
    let axes = &act.channel().state.place.layout.cartesian;
    let mut longest = (None, None, 0.0);
    for (role, pitch) in sides.into_iter().enumerate() {
        let Some(pitch) = pitch else { continue };
        let axis = axes.get(role).copied().flatten();
        let way = axis.map_or(0.0, |axis| changes.at(axis).abs());
        if way > 0.0 && way >= longest.2 {
            longest = (Some(pitch.abs()), axis, way);
        }
    }
    (longest.0, longest.1)
}

/// Change of the pitch with each revolution.
fn take_change(act: &mut ActionContext<'_, '_>, change: LeadChange, implied: bool) -> f64 {
    let id = data::INTERP_THREAD_PITCH_VAR;
    let said = if change == LeadChange::None { None } else { act.take(id).map(|datum| datum.value) };
    let last = act.channel().state.remembered.value(id).unwrap_or(0.0);
    let value = match (change, said) {
        (LeadChange::None, _) => 0.0,
        (LeadChange::May, None) if !implied => 0.0,
        (LeadChange::May | LeadChange::Signed, said) => said.unwrap_or(last),
        (LeadChange::Up, said) => said.unwrap_or(last).abs(),
        (LeadChange::Down, said) => -said.unwrap_or(last).abs(),
    };
    if value == 0.0 && said.is_none() && matches!(change, LeadChange::Signed | LeadChange::Up | LeadChange::Down) {
        let text = format!("a thread with a changing lead needs its change in '{}'", act.channel().block_text());
        act.diagnose(&diag::DATA_MISSING, text);
    }
    act.channel_mut().state.remembered.remember(id, value);
    value
}

/// Number of starts; which of them is cut makes no difference to the move.
fn take_starts(act: &mut ActionContext<'_, '_>) -> f64 {
    let take = |act: &mut ActionContext<'_, '_>, id: DataId| act.take(id).map(|datum| datum.value);
    let starts = take(act, data::INTERP_THREAD_STARTS);
    let current = take(act, data::INTERP_THREAD_START_CURRENT);
    let total = take(act, data::INTERP_THREAD_START_TOTAL);
    let known = starts.or(total).or_else(|| act.channel().state.remembered.value(data::INTERP_THREAD_STARTS));
    let starts = known.map_or(1.0, |starts| starts.max(1.0));
    if let Some(current) = current
        && !(1.0..=starts).contains(&current)
    {
        let text = format!("start {current} of a thread with {starts} starts in '{}'", act.channel().block_text());
        act.diagnose(&diag::DATA_OUT_OF_RANGE, text);
    }
    starts
}

/// The axis that the program has set for leads, if it moves.
fn lead_axis(channel: &ChannelContext<'_>, target: &Position) -> Option<AxisSlot> {
    let axis = channel.state.place.layout.cartesian.get(channel.state.threads.along?).copied().flatten()?;
    (channel.state.place.position.at(axis) != target.at(axis)).then_some(axis)
}

/// Stops the channel at a thread without a lead before anything of it is made, where that is an alarm.
pub(crate) fn check_lead(act: &mut ActionContext<'_, '_>, screw: &Screw) -> Acted {
    if screw.lead > 0.0 || !act.channel().env.machine.stops_at(&diag::NO_LEAD) {
        return Ok(());
    }
    let text = format!("thread without a lead in '{}', {NOT_DONE}", act.channel().block_text());
    act.diagnose(&diag::NO_LEAD, text);
    act.channel().check_stop()
}

/// Remembers the lead as feed per revolution if both are words of one register, as the F of a control.
pub(crate) fn remember_lead(act: &mut ActionContext<'_, '_>, pitch: f64) {
    act.channel_mut().state.remembered.remember(data::INTERP_THREAD_PITCH, pitch);
    if act.lead_is_feed() {
        act.channel_mut().state.remembered.remember(data::FEED_UPR, pitch);
    }
}

/// The lead last programmed, or the feed per revolution where that is the same word.
pub(crate) fn remembered_lead(act: &ActionContext<'_, '_>) -> Option<f64> {
    let feed = if act.lead_is_feed() { act.channel().state.remembered.value(data::FEED_UPR) } else { None };
    feed.or_else(|| act.channel().state.remembered.value(data::INTERP_THREAD_PITCH))
}

/// One thread move to a programmed point.
pub(crate) fn cut_to_point(act: &mut ActionContext<'_, '_>, coded: u8, target: Position, screw: &Screw) -> Acted {
    let target = act.channel_mut().state.place.work_point(&target);
    cut(act, coded, target, screw)
}

/// One thread move to a target in the work frame.
pub(crate) fn cut(act: &mut ActionContext<'_, '_>, coded: u8, target: Position, screw: &Screw) -> Acted {
    let from = act.channel().state.place.position;
    if target == from {
        return Ok(());
    }
    let changes = act.channel().state.place.changes(&from, &target);
    let seconds = thread_seconds(act, &target, &changes, screw)?;
    let length = tool_path(act.channel(), &changes);
    let feed = (screw.lead, FeedUnit::PerRevolution);
    let moving = moved_axes(act.channel(), coded, &changes);
    act.travel(seconds, &Motion::straight(MotionKind::Thread, moving, [from, target], feed, length))
}

/// Seconds of a thread move; falls back to the rapid time (with a diagnostic) without lead or speed.
fn thread_seconds(
    act: &mut ActionContext<'_, '_>,
    target: &Position,
    changes: &Position,
    screw: &Screw,
) -> Result<f64, Halt> {
    let longest = || changes.iter().fold(0.0_f64, |most, change| most.max(change.abs()));
    let way = screw.along.map_or_else(longest, |axis| changes.at(axis).abs());
    let seconds = lead_seconds(act, target, way, screw)?;
    check_rates(act, changes, seconds);
    Ok(seconds)
}

/// Seconds of a thread move for a path along the axis of the lead, geometry units.
fn lead_seconds(act: &mut ActionContext<'_, '_>, target: &Position, way: f64, screw: &Screw) -> Result<f64, Halt> {
    let from = act.channel().state.place.position;
    if screw.lead.is_nan() || screw.lead <= 0.0 {
        let done = act.channel().becomes(&diag::NO_LEAD, "the move is timed as rapid");
        let text = format!("thread without a lead in '{}', {done}", act.channel().block_text());
        act.diagnose(&diag::NO_LEAD, text);
        return Ok(rapid_seconds(act.channel(), &from, target));
    }
    let Some(turning) = act.speed_of_cut()? else {
        let text = format!(
            "{} in the thread '{}', the move is timed as rapid",
            stopped(act.channel()),
            act.channel().block_text()
        );
        act.diagnose(&diag::SPINDLE_STANDS, text);
        return Ok(rapid_seconds(act.channel(), &from, target));
    };
    let minutes = |lead: Lead| match turning {
        SpindleRotation::Fixed(rpm) => lead.minutes(way, rpm),
        SpindleRotation::Driven(driven, elapsed) => Some(driven.minutes_of(elapsed, lead.revolutions(way)?)),
        SpindleRotation::Surface(speed) => lead.surface_minutes(
            way,
            &speed,
            act.channel().state.place.radius(&from),
            act.channel().state.place.radius(target),
        ),
    };
    let lead = Lead { start: screw.lead, change: screw.change };
    let path = TimedPath { from: &from, to: target, length: way, arc: None };
    if let Some(minutes) = minutes(lead) {
        note_turning(act, &path, lead, turning);
        act.assume_speed(minutes * 60.0);
        return Ok(minutes * 60.0);
    }
    let steady = minutes(Lead { change: 0.0, ..lead }).unwrap_or(0.0) * 60.0;
    note_turning(act, &path, Lead { change: 0.0, ..lead }, turning);
    let text = format!(
        "the lead reaches zero before the end of the thread in '{}', the move is timed with its initial lead",
        act.channel().block_text()
    );
    act.diagnose(&diag::THREAD_LEAD, text);
    Ok(steady)
}

/// Reports a thread that needs a higher rate than an axis has.
fn check_rates(act: &mut ActionContext<'_, '_>, changes: &Position, seconds: f64) {
    let axes = act.channel().state.place.layout.axes.iter().zip(changes);
    let over = axes.map(|(axis, change)| (change.abs(), axis.rapid)).find(|(way, most)| *way > most * seconds * EVEN);
    let Some((way, most)) = over.filter(|_| !act.channel().reports.plausible.thread) else { return };
    act.channel_mut().reports.plausible.thread = true;
    let [asked, most] = [way / seconds, most].map(|rate| format!("{:.0}", rate * 60.0));
    let text = format!(
        "the thread in '{}' needs a rate of {asked} where its axis reaches {most}: reduce the spindle speed",
        act.channel().block_text()
    );
    act.diagnose(&diag::THREAD_RATE, text);
}
