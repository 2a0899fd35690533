//! Data of threading cycles.
//!
//! *Invariant:* a cycle takes only the words it uses, and across the thread only those of that axis; the rest stays in
//! the block and is reported. A value that makes no sense is diagnosed and ignored. Facts: reference
//! control-emulator.md 6.5.

use counterpoint_channel::modal::group;
use counterpoint_event::event::Position;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::{DataId, codes, data};
use counterpoint_machine::index::{AxisSlot, BySlot};

use super::{Thread, ThreadCycle};
use crate::context::ActionContext;
use crate::thread::{Screw, remember_lead, remembered_lead};

/// Starts of a thread at most.
const MOST_STARTS: f64 = 99.0;

/// Identifiers of the positions of the axes.
const AXES: [usize; 2] = [0, 2];

/// Words for the place of a thread: start and end as programmed, offset of the start, taper.
pub(crate) type Said = ([Option<f64>; 2], [Option<f64>; 2], [Option<f64>; 2], f64);

/// Whether a position of a thread is in the block.
pub(crate) fn positioned(act: &ActionContext<'_, '_>) -> bool {
    let own = [data::THREAD_MULTI_END_X, data::THREAD_MULTI_END_Z];
    let axes =
        AXES.into_iter().filter_map(|role| act.channel().state.place.layout.cartesian.get(role).copied().flatten());
    let axes = axes.map(|axis| act.channel().state.place.layout.axes[axis].data);
    own.into_iter().chain(axes).any(|id| act.block_has(id))
}

/// Positions along X and Z as programmed in the work frame; with `axes` the words of the axes stand in.
pub(crate) fn points(act: &mut ActionContext<'_, '_>, ids: [DataId; 2], axes: bool) -> [Option<f64>; 2] {
    let relative = act.channel().state.modal.code(group::POSITION) == Some(codes::POSITION_RELATIVE);
    let mut points = [None; 2];
    for (slot, (id, role)) in points.iter_mut().zip(ids.into_iter().zip(AXES)) {
        let Some(axis) = act.channel().state.place.layout.cartesian.get(role).copied().flatten() else {
            continue;
        };
        let word = Some(act.channel().state.place.layout.axes[axis].data).filter(|_| axes);
        let datum = act.take(id).or_else(|| word.and_then(|word| act.take(word)));
        let of = |list: &Position| list.at(axis);
        *slot = datum.map(|datum| {
            if datum.incremental || relative && !datum.absolute {
                of(&act.channel().state.place.programmed()) + datum.value
            } else if act.channel().block.flags.machine_frame {
                datum.value - act.channel().shift_in_machine_frame(axis)
            } else {
                datum.value
            }
        });
    }
    points
}

/// Values of two identifiers.
pub(crate) fn values(act: &mut ActionContext<'_, '_>, ids: [DataId; 2]) -> [Option<f64>; 2] {
    ids.map(|id| act.take(id).map(|datum| datum.value))
}

fn take_within(act: &mut ActionContext<'_, '_>, id: DataId, least: f64, most: f64) -> Option<f64> {
    let value = act.take(id)?.value;
    if (least..=most).contains(&value) {
        return Some(value);
    }
    let name = act.channel().env.machine.data_name(id).to_owned();
    let text = format!("{name} {value} is not in {least} to {most} in '{}'", act.channel().block_text());
    act.diagnose(&diag::DATA_OUT_OF_RANGE, text);
    None
}

/// Data that last from cycle to cycle: the first of two lines.
pub(crate) fn settings(act: &mut ActionContext<'_, '_>, kind: ThreadCycle) -> Acted {
    let finish = if kind.face { data::THREAD_MULTI_FINISH_Z } else { data::THREAD_MULTI_FINISH_X };
    if let Some(finish) = act.take(finish) {
        act.channel_mut().state.threads.cycle.finish = finish.value.abs();
    }
    if let Some(least) = act.take(data::THREAD_MULTI_STEP_MIN) {
        act.channel_mut().state.threads.cycle.least = least.value.abs();
    }
    if let Some(cuts) = take_within(act, data::THREAD_MULTI_CUTS_FINISH, 0.0, 99.0) {
        act.channel_mut().state.threads.cycle.finish_cuts = cuts.trunc();
    }
    packed(act)?;
    angles(act)?;
    chamfer(act);
    Ok(())
}

/// Nose angle and infeed.
fn angles(act: &mut ActionContext<'_, '_>) -> Acted {
    if let Some(angle) = take_within(act, data::THREAD_MULTI_ANGLE, 0.0, 170.0) {
        check_nose(act, angle)?;
        act.channel_mut().state.threads.cycle.nose = angle;
    }
    if let Some(mode) = take_within(act, data::THREAD_MULTI_INFEED, 0.0, 4.0) {
        act.channel_mut().state.threads.cycle.mode = mode as u8;
    }
    Ok(())
}

/// Depth, steps and passes.
pub(crate) fn amounts(act: &mut ActionContext<'_, '_>, kind: ThreadCycle) -> Acted {
    let one_line = !act.channel().env.machine.threads.two_lines;
    let finish = if kind.face { data::THREAD_MULTI_FINISH_Z } else { data::THREAD_MULTI_FINISH_X };
    if one_line && let Some(finish) = act.take(finish) {
        act.channel_mut().state.threads.cycle.finish = finish.value.abs();
    }
    let (height, step) = match kind.face {
        true => (data::THREAD_MULTI_HEIGHT_Z, data::THREAD_MULTI_STEP_Z),
        false => (data::THREAD_MULTI_HEIGHT_X, data::THREAD_MULTI_STEP_X),
    };
    if let Some(height) = act.take(height) {
        act.channel_mut().state.threads.cycle.depth = Some(height.value.abs());
    }
    if let Some(step) = act.take(step) {
        act.channel_mut().state.threads.cycle.step = Some(step.value.abs());
    }
    if one_line && let Some(least) = act.take(data::THREAD_MULTI_STEP_MIN) {
        act.channel_mut().state.threads.cycle.least = least.value.abs();
    }
    if let Some(cuts) = take_within(act, data::THREAD_MULTI_CUTS, 1.0, 999.0) {
        act.channel_mut().state.threads.cycle.cuts = Some(cuts.trunc());
    }
    if one_line && let Some(cuts) = take_within(act, data::THREAD_MULTI_CUTS_FINISH, 0.0, 99.0) {
        act.channel_mut().state.threads.cycle.finish_cuts = cuts.trunc();
    }
    angles(act)
}

/// The packed word: two digits each of finishing passes, chamfer in tenths of the lead, nose angle.
pub(crate) fn packed(act: &mut ActionContext<'_, '_>) -> Acted {
    let Some(word) = take_within(act, data::THREAD_MULTI_PWORD, 0.0, 999_999.0) else { return Ok(()) };
    let word = word as u32;
    check_nose(act, f64::from(word % 100))?;
    let cycle = &mut act.channel_mut().state.threads.cycle;
    cycle.finish_cuts = f64::from(word / 10_000);
    let tenths = word / 100 % 100;
    cycle.pull_out.on = tenths > 0;
    cycle.pull_out.leads = (tenths > 0).then(|| f64::from(tenths) / 10.0);
    cycle.nose = f64::from(word % 100);
    Ok(())
}

/// The control has an angle of the nose.
fn check_nose(act: &mut ActionContext<'_, '_>, angle: f64) -> Acted {
    let noses = act.channel().env.machine.threads.noses;
    if noses == 0 || angle.fract() == 0.0 && noses >> (angle as u32).min(127) & 1 != 0 {
        return Ok(());
    }
    let listed: Vec<String> = (0..=120).filter(|degree| noses >> degree & 1 != 0).map(|d: u32| d.to_string()).collect();
    let text = format!("nose angle {angle} in '{}'; the control has {}", act.channel().block_text(), listed.join(", "));
    Err(act.alarm(&diag::NOSE_ANGLE, text))
}

/// Length and angle of the chamfer; a length of nothing is none.
pub(crate) fn chamfer(act: &mut ActionContext<'_, '_>) {
    if let Some(length) = act.take(data::THREAD_CHAMFER_LENGTH) {
        let cycle = &mut act.channel_mut().state.threads.cycle;
        cycle.pull_out.length = length.value.abs();
        cycle.pull_out.leads = None;
        cycle.pull_out.on = cycle.pull_out.length > 0.0;
    }
    if let Some(angle) = take_within(act, data::THREAD_CHAMFER_ANGLE, 10.0, 80.0) {
        act.channel_mut().state.threads.cycle.pull_out.angle = angle;
    }
}

/// The lead: the cycle's own word, otherwise that of threads.
pub(crate) fn screw(
    act: &mut ActionContext<'_, '_>,
    pitch: DataId,
    change: DataId,
    along: AxisSlot,
    starts: Option<DataId>,
) -> Screw {
    let own = act.take(pitch).or_else(|| act.take(data::INTERP_THREAD_PITCH)).map(|datum| datum.value);
    if let Some(pitch) = own {
        remember_lead(act, pitch);
    }
    let pitch = remembered_lead(act).unwrap_or(0.0);
    let change = act.take(change).map_or(0.0, |datum| datum.value);
    act.channel_mut().state.remembered.remember(data::INTERP_THREAD_PITCH_VAR, change);
    act.take(data::INTERP_THREAD_ANGLE);
    let said = starts.and_then(|id| take_within(act, id, 1.0, MOST_STARTS));
    let starts = said.or_else(|| act.channel().state.remembered.value(data::INTERP_THREAD_STARTS)).unwrap_or(1.0);
    let starts = starts.clamp(1.0, MOST_STARTS).trunc();
    act.channel_mut().state.threads.starts = starts;
    Screw { lead: pitch * starts, change: change * starts, along: Some(along) }
}

/// The thread between start and end, in geometry units.
pub(crate) fn thread(
    act: &mut ActionContext<'_, '_>,
    kind: ThreadCycle,
    axes: [AxisSlot; 2],
    (start, end, offset, taper): Said,
    screw: Screw,
) -> Option<Thread> {
    let order = |[x, z]: [Option<f64>; 2]| if kind.face { [x, z] } else { [z, x] };
    let (start, end, offset) = (order(start), order(end), order(offset));
    let scales = axes.map(|axis| act.channel().state.place.layout.axes[axis].scale);
    let place = act.channel().state.place.programmed();
    let here = axes.map(|axis| place.at(axis));
    if end.iter().any(Option::is_none) {
        let text = format!("a thread needs its end along X and Z in '{}'", act.channel().block_text());
        act.diagnose(&diag::DATA_MISSING, text);
    }
    let along = |value: Option<f64>| value.unwrap_or(here[0]) * scales[0];
    let across = |value: Option<f64>| value.unwrap_or(here[1]) * scales[1];
    let root = across(end[1]);
    let taper = match start[1] {
        Some(_) => across(start[1]) - root,
        None => taper,
    };
    let thread = Thread {
        axes,
        scales,
        begin: along(start[0]) + offset[0].unwrap_or(0.0),
        end: along(end[0]),
        root,
        taper: taper + offset[1].unwrap_or(0.0),
        screw,
    };
    let sound = [thread.begin, thread.end, thread.root, thread.taper].iter().all(|value| value.is_finite());
    (sound && thread.begin != thread.end).then_some(thread)
}
