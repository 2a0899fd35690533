//! Data of a cycle, in the order in which it is taken: feed, depth, clearance, position, and data of only some kinds.
//!
//! *Invariant:* a kind takes only the words it uses; the rest stays in the block and is reported. Facts: reference
//! control-emulator.md 6.4 (feed, depth axis, clearance, position axes are documented by a trace).

use counterpoint_channel::cycle::Height;
use counterpoint_channel::modal::{feed_of, group};
use counterpoint_event::event::{FeedUnit, Position};
use counterpoint_fault as diag;
use counterpoint_machine::ident::dimension::Dimension;
use counterpoint_machine::ident::kind::cycle::HoleCycle;
use counterpoint_machine::ident::{DataId, codes, data};
use counterpoint_machine::index::AxisSlot;
use counterpoint_machine::model::DistanceMode;
use counterpoint_program::block::RetrievedValue;

use crate::context::ActionContext;
use crate::dwell::take_seconds;
use crate::motion::programmed_targets;

/// Most holes of one block.
const MOST_TIMES: f64 = 9999.0;

/// A calculated number of repeats may differ from a whole number by less.
const NEARLY_WHOLE: f64 = 1e-6;

/// Position of a block and how often the cycle is executed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CycleTarget {
    pub(crate) target: Position,
    /// Coded axes, bit by axis.
    pub(crate) coded: u8,
    /// Axes whose words are distances, bit by axis.
    pub(crate) relative: u8,
    pub(crate) times: u32,
}

/// Takes the data of a cycle code; the kind may become a rigid one.
pub(crate) fn take(act: &mut ActionContext<'_, '_>, kind: HoleCycle) -> (HoleCycle, CycleTarget) {
    let pitched = act.channel().env.machine.cycles.tap_pitch && kind.taps();
    let kind = if pitched { tap_type(act, kind) } else { kind };
    if pitched && (kind.is_rigid() || act.channel().state.cycle.tap.is_some_and(|tap| tap >= 1.0)) {
        take_pitch(act);
    } else {
        take_feed(act);
    }
    let Some((role, axis)) = act.channel().state.cycle.axis else { return (kind, position(act)) };
    let scale = act.channel().state.place.layout.axes[axis].scale;
    let rules = (act.channel().env.machine.cycles.clearance, act.channel().env.machine.cycles.depth);
    depth(act, (role, axis), scale, rules.1);
    if kind.bores_back()
        && let Some(bottom) = height(act, data::CYCLE_BOTTOM, rules.0, scale)
    {
        act.channel_mut().state.cycle.heights.bottom = Some(bottom);
    }
    if let Some(clear) = height(act, data::CYCLE_CLEAR, rules.0, scale) {
        act.channel_mut().state.cycle.heights.clear = Some(clear);
    }
    if kind.has_webs() {
        for (web, ids) in super::webs::DATA.into_iter().enumerate() {
            for (end, id) in ids.into_iter().enumerate() {
                let height = height(act, id, rules.1, scale);
                let slot = act.channel_mut().state.cycle.heights.webs.get_mut(web).and_then(|web| web.get_mut(end));
                if let (Some(slot), Some(height)) = (slot, height) {
                    *slot = Some(height);
                }
            }
        }
    }
    let mut words = position(act);
    if let Some(retract) = height(act, data::CYCLE_RETRACT, rules.0, scale) {
        act.channel_mut().state.cycle.heights.retract = Some(retract);
    }
    let kind = amounts(act, kind);
    words.times = times(act);
    (kind, words)
}

/// Takes the position of a block that executes the cycle defined before.
pub(crate) fn take_position(act: &mut ActionContext<'_, '_>) -> CycleTarget {
    take_feed(act);
    let mut words = position(act);
    words.times = times(act);
    words
}

/// A feed of the cycle's own lasts until another one is programmed or the cycle ends; otherwise that of the mode
/// counts.
fn take_feed(act: &mut ActionContext<'_, '_>) {
    let own = [
        (data::CYCLE_UPM, FeedUnit::PerMinute),
        (data::CYCLE_UPR, FeedUnit::PerRevolution),
        (data::CYCLE_TPU, FeedUnit::PerRevolution),
    ];
    for (id, unit) in own {
        if let Some(datum) = act.take(id) {
            let pitch = |threads: f64| {
                if threads == 0.0 { 0.0 } else { act.channel().unit_factor(Dimension::Length) / threads }
            };
            let value = if id == data::CYCLE_TPU { pitch(datum.value) } else { datum.value };
            act.channel_mut().state.cycle.rates.feed = (Some(value), unit);
            act.channel_mut().state.cycle.rates.own_feed = true;
            return;
        }
    }
    let (id, unit) = feed_of(act.channel().state.modal.code(group::FEED));
    if let Some(datum) = act.take(id) {
        act.channel_mut().state.remembered.remember(id, datum.value);
        act.channel_mut().state.cycle.rates.feed = (Some(datum.value), unit);
        act.channel_mut().state.cycle.rates.own_feed = false;
    } else if !act.channel().state.cycle.rates.own_feed {
        // Inverse time belongs to its block alone.
        let known = if unit == FeedUnit::InverseTime { None } else { act.channel().state.remembered.value(id) };
        act.channel_mut().state.cycle.rates.feed = (known, unit);
    }
}

/// The feed of a tap that is its pitch; it lasts like a feed of the cycle's own.
fn take_pitch(act: &mut ActionContext<'_, '_>) {
    if let Some(datum) = act.take(data::FEED_UPR) {
        act.channel_mut().state.cycle.rates.feed = (Some(datum.value), FeedUnit::PerRevolution);
        act.channel_mut().state.cycle.rates.own_feed = true;
    } else if !act.channel().state.cycle.rates.own_feed {
        act.channel_mut().state.cycle.rates.feed = (None, FeedUnit::PerRevolution);
    }
}

/// The depth: data of its own, otherwise the word of the axis.
fn depth(act: &mut ActionContext<'_, '_>, (role, axis): (usize, AxisSlot), scale: f64, rule: DistanceMode) {
    let id = [data::CYCLE_DEPTH_X, data::CYCLE_DEPTH_Y, data::CYCLE_DEPTH_Z].get(role).copied();
    let own = id.and_then(|id| height(act, id, rule, scale));
    let depth = own.or_else(|| height(act, act.channel().state.place.layout.axes[axis].data, rule, 1.0));
    if depth.is_some() {
        act.channel_mut().state.cycle.heights.depth = depth;
    }
}

/// A height; a distance is divided by `scale`, which makes a radius a diameter.
fn height(act: &mut ActionContext<'_, '_>, id: DataId, rule: DistanceMode, scale: f64) -> Option<Height> {
    let datum = act.take(id)?;
    let relative = is_relative(act, rule, &datum);
    if relative {
        return Some(Height { value: datum.value / scale, relative });
    }
    let axis = act.channel().state.cycle.axis.map(|(_, axis)| axis);
    // The word of the axis itself has been taken as its axis counts.
    let own = axis.filter(|axis| act.channel().state.place.layout.axes[*axis].data != id);
    let factor = own.map_or(1.0, |axis| act.axis_diameter_factor(axis));
    let shift = axis
        .filter(|_| act.channel().block.flags.machine_frame)
        .map_or(0.0, |axis| act.channel().shift_in_machine_frame(axis));
    Some(Height { value: datum.value * factor - shift, relative })
}

fn is_relative(act: &ActionContext<'_, '_>, rule: DistanceMode, datum: &RetrievedValue) -> bool {
    let mode = act.channel().state.modal.code(group::POSITION) == Some(codes::POSITION_RELATIVE);
    datum.incremental
        || !datum.absolute
            && match rule {
                DistanceMode::Mode => mode,
                DistanceMode::Absolute => false,
                DistanceMode::Incremental => true,
            }
}

/// Position axes, and which of them are distances.
fn position(act: &mut ActionContext<'_, '_>) -> CycleTarget {
    let mode = act.channel().state.modal.code(group::POSITION) == Some(codes::POSITION_RELATIVE);
    let mut relative = 0;
    for (index, axis) in act.channel().state.place.layout.axes.iter().enumerate() {
        let sources = act.sources(axis.data).iter();
        let word = sources.filter_map(|source| act.channel().block.look(source.register)).next();
        let added = || act.channel().block.added.iter().any(|(id, _)| *id == axis.data);
        if word.is_some_and(|word| word.incremental || mode) || mode && added() {
            relative |= 1 << index;
        }
    }
    let (coded, target) = programmed_targets(act);
    CycleTarget { target, coded, relative: relative & coded, times: 1 }
}

/// Steps, dwell and shift, as far as the kind has them.
fn amounts(act: &mut ActionContext<'_, '_>, kind: HoleCycle) -> HoleCycle {
    use counterpoint_machine::ident::kind::cycle::{Out, PeckStyle};
    let mut kind = tap_type(act, kind);
    if act.channel().state.cycle.rigid == 2.0 && kind.taps() {
        kind = kind.rigid(false);
        if let Some(step) = act.take(data::CYCLE_STEP) {
            act.channel_mut().state.cycle.pecks.first = Some(step.value.abs());
        }
        kind = kind.rigid(act.channel().state.cycle.pecks.first.is_some_and(|step| step > 0.0));
        act.channel_mut().state.cycle.number = kind.number();
    } else if kind.is_rigid() {
        act.channel_mut().state.cycle.rigid = 1.0;
    } else if act.channel().state.cycle.rigid == 2.0 {
        super::end_rigid(act);
    }
    if kind.dwells()
        && let Some(dwell) = take_seconds(act, data::CYCLE_DWELL)
        && let [bottom, ..] = &mut act.channel_mut().state.cycle.rates.dwell
    {
        *bottom = dwell;
    }
    if kind.steps() != PeckStyle::None {
        if let Some(step) = act.take(data::CYCLE_STEP) {
            act.channel_mut().state.cycle.pecks.first = Some(step.value.abs());
        }
        let decrement = act.take(data::CYCLE_STEP_DECR);
        if let Some(decrement) = decrement {
            act.channel_mut().state.cycle.pecks.decrement = decrement.value.abs();
        }
        // One word may be the depth between full retracts, or where there is a decrement the smallest step.
        if (decrement.is_some() || kind.steps() != PeckStyle::Small)
            && let Some(least) = act.take(data::CYCLE_STEP_MIN)
        {
            act.channel_mut().state.cycle.pecks.least = least.value.abs();
        }
        if kind.steps() == PeckStyle::Small
            && let Some(out) = act.take(data::CYCLE_STEP_OUT)
        {
            act.channel_mut().state.cycle.pecks.out = out.value.abs();
        }
    }
    if (kind.steps() != PeckStyle::None || kind.has_webs())
        && let Some(back) = act.take(data::CYCLE_STEP_BACK)
    {
        act.channel_mut().state.cycle.pecks.retract = back.value.abs();
    }
    if kind.is_rigid()
        && let Some(orient) = act.take(data::CYCLE_RIGID_ORIENT)
    {
        act.channel_mut().state.cycle.boring.orient = orient.value;
    }
    if kind.out() == Out::Oriented {
        shifts(act);
    }
    kind
}

/// A tap of the programmed type, if one has been programmed.
fn tap_type(act: &mut ActionContext<'_, '_>, kind: HoleCycle) -> HoleCycle {
    if !kind.taps() {
        return kind;
    }
    if let Some(datum) = act.take(data::CYCLE_TAP_TYPE) {
        if kind.tap(datum.value).is_none() {
            let text = format!(
                "{} is not a valid tap type in '{}': 0 floating, 1 rigid, 2 peck, 3 chip breaking",
                datum.value,
                act.channel().block_text()
            );
            act.diagnose(&diag::DATA_OUT_OF_RANGE, text);
        } else {
            act.channel_mut().state.cycle.tap = Some(datum.value);
        }
    }
    let Some(typed) = act.channel().state.cycle.tap.and_then(|wanted| kind.tap(wanted)) else { return kind };
    act.channel_mut().state.cycle.number = typed.number();
    if !typed.is_rigid() && act.channel().state.cycle.rigid == 1.0 {
        act.channel_mut().state.cycle.rigid = 0.0;
    }
    typed
}

fn shifts(act: &mut ActionContext<'_, '_>) {
    if let Some(orient) = act.take(data::CYCLE_ORIENT) {
        act.channel_mut().state.cycle.boring.orient = orient.value;
    }
    if let Some(shift) = act.take(data::CYCLE_BORE_JOG) {
        act.channel_mut().state.cycle.boring.shift = shift.value;
    }
    // The words of the plane: I and J of G17, I and K of G18, J and K of G19. K alone is the number of repeats.
    let along = act.channel().state.cycle.axis.map_or(2, |(role, _)| role);
    let beside = |role: usize, id: DataId| role != along && act.block_has(id);
    let with_k = beside(0, data::CYCLE_BORE_JOG_X) || beside(1, data::CYCLE_BORE_JOG_Y);
    for (index, id) in [data::CYCLE_BORE_JOG_X, data::CYCLE_BORE_JOG_Y, data::CYCLE_BORE_JOG_Z].into_iter().enumerate()
    {
        if index != along
            && (index != 2 || with_k)
            && let Some(datum) = act.take(id)
            && let Some(slot) = act.channel_mut().state.cycle.boring.shifts.get_mut(index)
        {
            *slot = Some(datum.value);
        }
    }
}

/// How often the cycle is executed in this block; 0 only stores its values.
fn times(act: &mut ActionContext<'_, '_>) -> u32 {
    let Some(datum) = act.take(data::CYCLE_REPEAT) else { return 1 };
    let nearest = datum.value.round();
    if (datum.value - nearest).abs() < NEARLY_WHOLE {
        return nearest.clamp(0.0, MOST_TIMES) as u32;
    }
    let times = datum.value.clamp(0.0, MOST_TIMES) as u32;
    let holes = match times {
        0 => "no hole".to_owned(),
        1 => "one hole".to_owned(),
        times => format!("{times} holes"),
    };
    let text = format!(
        "{} is not a whole number of repeats in '{}'; the decimals are ignored, so the block makes {holes}",
        datum.value,
        act.channel().block_text()
    );
    act.diagnose(&diag::REPEATS_NOT_WHOLE, text);
    times
}
