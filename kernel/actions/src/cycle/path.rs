//! The moves of one hole.
//!
//! *Invariant:* every move goes through the motion actions, so events, limits, times and macros are theirs. Steps are
//! counted from the clearance height. Facts: reference control-emulator.md 6.4.

use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::cycle::{Cycle, CycleHole};
use counterpoint_event::event::{Position, SpindleDirection};
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::kind::cycle::{HoleCycle, Out, PeckStyle};
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_machine::model::CycleApproach;

use crate::context::ActionContext;
use crate::improbable::check_tap_rate;
use crate::motion::{feed_to_point, rapid_to_point};
use crate::{dwell, spindle};

/// Most steps of a hole.
const MOST_STEPS: u32 = 10_000;

/// A hole being made.
pub(crate) struct Drill<'h> {
    pub(crate) hole: &'h CycleHole,
    kind: HoleCycle,
    pub(crate) cycle: Cycle,
    /// Direction of the spindle when the hole began.
    turning: SpindleDirection,
}

/// Makes a hole with the current data of the cycle.
pub(crate) fn make_hole(act: &mut ActionContext<'_, '_>, hole: &CycleHole) -> Acted {
    let cycle = act.channel().state.cycle;
    let Some(kind) = HoleCycle::numbered(cycle.number) else { return Ok(()) };
    let turning = act.spindle_command()?.direction;
    let drill = Drill { hole, kind, cycle, turning };
    approach(act, hole)?;
    let Some(depth) = hole.depth else { return Ok(()) };
    if kind.bores_back() {
        return match hole.bottom {
            Some(bottom) => bore_back(act, &drill, depth, bottom),
            None => Ok(()),
        };
    }
    go_down(act, &drill, depth)?;
    further_webs(act, &drill, depth)?;
    rest(act, &drill, 0)?;
    come_out(act, &drill)
}

/// To the position at the clearance height.
fn approach(act: &mut ActionContext<'_, '_>, hole: &CycleHole) -> Acted {
    let along = hole.axis.bit();
    let mut target = hole.target;
    if act.channel().env.machine.cycles.approach == CycleApproach::PositionFirst {
        *target.at_mut(hole.axis) = act.channel().state.place.programmed().at(hole.axis);
        rapid_to_point(act, hole.coded & !along, target)?;
        return rapid_to_point(act, along, at_level(act.channel(), hole.axis, hole.clear));
    }
    *target.at_mut(hole.axis) = hole.clear;
    rapid_to_point(act, hole.coded | along, target)
}

fn at_level(channel: &ChannelContext<'_>, axis: AxisSlot, level: f64) -> Position {
    let mut target = channel.state.place.programmed();
    *target.at_mut(axis) = level;
    target
}

/// Along the axis of the cycle at rapid.
pub(crate) fn lift(act: &mut ActionContext<'_, '_>, drill: &Drill<'_>, level: f64) -> Acted {
    rapid_to_point(act, drill.hole.axis.bit(), at_level(act.channel(), drill.hole.axis, level))
}

/// Along the axis of the cycle at feed.
pub(crate) fn plunge(act: &mut ActionContext<'_, '_>, drill: &Drill<'_>, level: f64, ratio: f64) -> Acted {
    let (feed, unit) = drill.cycle.rates.feed;
    if drill.kind.is_rigid() {
        check_tap_rate(act, (feed.map(|feed| feed * ratio), unit), drill.hole.axis)?;
    }
    let target = at_level(act.channel(), drill.hole.axis, level);
    feed_to_point(act, drill.hole.axis.bit(), target, feed.map(|feed| feed * ratio), unit)
}

/// Dwell at depth (0), per step (1), at the top (2).
fn rest(act: &mut ActionContext<'_, '_>, drill: &Drill<'_>, place: usize) -> Acted {
    let amount = drill.cycle.rates.dwell.get(place).copied().filter(|_| drill.kind.dwells());
    dwell::of_cycle(act, amount.unwrap_or(0.0))
}

/// From the clearance height to the depth, in steps if the kind has them.
fn go_down(act: &mut ActionContext<'_, '_>, drill: &Drill<'_>, depth: f64) -> Acted {
    let steps = drill.kind.steps();
    let step = drill.cycle.pecks.first.filter(|step| *step > 0.0 && step.is_finite());
    let Some(step) = step.filter(|_| steps != PeckStyle::None) else {
        if steps != PeckStyle::None && act.channel().env.machine.cycles.step_required {
            let text = format!("a cycle needs its step in '{}', it is drilled in one step", act.channel().block_text());
            act.diagnose(&diag::DATA_MISSING, text);
        }
        return plunge(act, drill, depth, 1.0);
    };
    in_steps(act, drill, depth, step)
}

/// Size of a program's unit along an axis for the cycle's own lengths: the program may be scaled, steps and shifts
/// are not.
pub(crate) fn own_scale(channel: &ChannelContext<'_>, axis: AxisSlot) -> f64 {
    let place = &channel.state.place;
    let role = place.layout.cartesian.iter().position(|own| *own == Some(axis));
    let scaled = role
        .filter(|_| place.frames.is_some())
        .and_then(|role| channel.state.place.frame_values().scale.get(role).copied());
    let factor = scaled.map(f64::abs).filter(|factor| *factor > 0.0 && factor.is_finite()).unwrap_or(1.0);
    place.layout.axes[axis].scale * factor
}

fn in_steps(act: &mut ActionContext<'_, '_>, drill: &Drill<'_>, depth: f64, first: f64) -> Acted {
    let (hole, cycle) = (drill.hole, &drill.cycle);
    let scale = own_scale(act.channel(), hole.axis);
    let (whole, down) = ((depth - hole.clear).abs() * scale, (depth - hole.clear).signum());
    let at = |reached: f64| hole.clear + down * reached / scale;
    let (mut reached, mut step, mut last_out) = (0.0, first, 0.0);
    for _ in 0..MOST_STEPS {
        let next = reached + step;
        if next >= whole - 1e-9 {
            return plunge(act, drill, depth, 1.0);
        }
        plunge(act, drill, at(next), 1.0)?;
        rest(act, drill, 1)?;
        let above = (next - cycle.pecks.retract).max(0.0);
        let leaves = cycle.pecks.out > 0.0 && next - last_out >= cycle.pecks.out - 1e-9;
        last_out = if leaves { next } else { last_out };
        between(act, drill, at(above), leaves)?;
        reached = next;
        let less = (step - cycle.pecks.decrement).max(cycle.pecks.least);
        step = if less > 0.0 { less } else { step };
    }
    let text = format!(
        "the cycle of '{}' has more than {MOST_STEPS} steps, the rest is drilled in one step",
        act.channel().block_text()
    );
    act.diagnose(&diag::CYCLE_STEPS, text);
    plunge(act, drill, depth, 1.0)
}

/// Between two steps: fully out and back to `above`, or only up to there.
fn between(act: &mut ActionContext<'_, '_>, drill: &Drill<'_>, above: f64, leaves: bool) -> Acted {
    let full = leaves || drill.kind.steps() == PeckStyle::Full;
    let ratio = drill.cycle.rates.ratio;
    if !drill.kind.taps() {
        if full {
            lift(act, drill, drill.hole.clear)?;
            rest(act, drill, 2)?;
        }
        return lift(act, drill, above);
    }
    reverse(act, drill)?;
    plunge(act, drill, if full { drill.hole.clear } else { above }, ratio)?;
    turn_again(act, drill)?;
    if full {
        rest(act, drill, 2)?;
        plunge(act, drill, above, ratio)?;
    }
    Ok(())
}

fn come_out(act: &mut ActionContext<'_, '_>, drill: &Drill<'_>) -> Acted {
    let (hole, ratio) = (drill.hole, drill.cycle.rates.ratio);
    match drill.kind.out() {
        Out::Rapid => lift(act, drill, hole.back),
        Out::Feed => {
            plunge(act, drill, hole.clear, ratio)?;
            lift(act, drill, hole.back)
        }
        Out::Reversed => {
            reverse(act, drill)?;
            plunge(act, drill, hole.clear, ratio)?;
            turn_again(act, drill)?;
            rest(act, drill, 2)?;
            lift(act, drill, hole.back)
        }
        Out::Stopped => {
            turn(act, drill, SpindleDirection::Off)?;
            lift(act, drill, hole.back)?;
            turn_again(act, drill)
        }
        Out::Oriented => {
            turn(act, drill, SpindleDirection::Oriented)?;
            shift_aside(act, drill, 1.0)?;
            lift(act, drill, hole.back)?;
            shift_aside(act, drill, -1.0)?;
            turn_again(act, drill)
        }
    }
}

/// Beside the centre down to the lower clearance, up at feed, and out beside the centre.
fn bore_back(act: &mut ActionContext<'_, '_>, drill: &Drill<'_>, depth: f64, bottom: f64) -> Acted {
    turn(act, drill, SpindleDirection::Oriented)?;
    shift_aside(act, drill, 1.0)?;
    lift(act, drill, bottom)?;
    shift_aside(act, drill, -1.0)?;
    turn_again(act, drill)?;
    plunge(act, drill, depth, 1.0)?;
    rest(act, drill, 0)?;
    come_out(act, drill)
}

/// The shift of oriented boring, away from the centre (1) or back (−1).
fn shift_aside(act: &mut ActionContext<'_, '_>, drill: &Drill<'_>, way: f64) -> Acted {
    let cycle = &drill.cycle;
    let mut target = act.channel().state.place.programmed();
    let mut coded = 0_u8;
    let given = cycle.boring.shifts.iter().any(Option::is_some);
    // The first axis of the plane: X of G17, Z of G18, Y of G19 (Fanuc parameter 5101#4 and #5 at 0).
    let along = cycle.axis.map_or(2, |(along, _)| along);
    let axes = act.channel().state.place.layout.cartesian;
    let first =
        [(along + 1) % 3, (along + 2) % 3].into_iter().find(|role| axes.get(*role).copied().flatten().is_some());
    for (role, axis) in axes.iter().enumerate() {
        let part = match cycle.boring.shifts.get(role).copied().flatten() {
            Some(part) => part,
            None if !given && Some(role) == first => cycle.boring.shift,
            None => 0.0,
        };
        let Some(axis) = axis.filter(|_| part != 0.0) else { continue };
        *target.at_mut(axis) += way * part / own_scale(act.channel(), axis);
        coded |= axis.bit();
    }
    rapid_to_point(act, coded, target)
}

/// Stops or orients a spindle that turned when the hole began.
fn turn(act: &mut ActionContext<'_, '_>, drill: &Drill<'_>, direction: SpindleDirection) -> Acted {
    match drill.turning {
        SpindleDirection::Clockwise | SpindleDirection::CounterClockwise => spindle::turn_inside(act, direction),
        _ => Ok(()),
    }
}

/// The direction that the hole began with.
fn turn_again(act: &mut ActionContext<'_, '_>, drill: &Drill<'_>) -> Acted {
    change_direction(act, drill, drill.turning)
}

fn reverse(act: &mut ActionContext<'_, '_>, drill: &Drill<'_>) -> Acted {
    let opposite = match drill.turning {
        SpindleDirection::Clockwise => SpindleDirection::CounterClockwise,
        _ => SpindleDirection::Clockwise,
    };
    change_direction(act, drill, opposite)
}

/// Through a standstill if the spindle turns the other way.
fn change_direction(act: &mut ActionContext<'_, '_>, drill: &Drill<'_>, direction: SpindleDirection) -> Acted {
    if drill.kind.taps() {
        turn(act, drill, SpindleDirection::Off)?;
    }
    turn(act, drill, direction)
}

/// From the depth of the first web through the others.
fn further_webs(act: &mut ActionContext<'_, '_>, drill: &Drill<'_>, depth: f64) -> Acted {
    let hole = drill.hole;
    let scale = own_scale(act.channel(), hole.axis);
    let up = (hole.clear - depth).signum() * drill.cycle.pecks.retract / scale;
    for [start, depth] in hole.webs.into_iter().flatten() {
        lift(act, drill, start + up)?;
        plunge(act, drill, depth, 1.0)?;
    }
    Ok(())
}
