//! Data of a cycle, in the order in which it is taken: feed, depth, clearance, position, and what only some kinds have.
//!
//! Invariant: a kind takes what it uses; the rest stays on the block and is told. Facts: reference control-emulator.md
//! 6.4 (feed, depth axis, clearance, position axes are documented by a trace).

use crate::channel::Kernel;
use crate::channel::data::Datum;
use crate::diag;
use crate::log::event::{FeedUnit, Position};
use crate::machine::ident::kind::cycle::Kind;
use crate::machine::ident::{DataId, codes, data};
use crate::machine::model::{Dimension, Heights};
use crate::state::cycle::Height;
use crate::state::modal::{feed_of, group};

/// Most holes of one block.
const MOST_TIMES: f64 = 9999.0;

/// Position of a block and how often the cycle is carried out.
#[derive(Debug, Clone, Copy)]
pub(super) struct Words {
    pub(super) target: Position,
    /// Coded axes, bit by axis.
    pub(super) coded: u8,
    /// Axes whose words are distances, bit by axis.
    pub(super) relative: u8,
    pub(super) times: u32,
}

/// Takes the data of a cycle code; the kind may become a rigid one.
pub(super) fn take(kernel: &mut Kernel<'_>, kind: Kind) -> (Kind, Words) {
    take_feed(kernel);
    let Some((role, axis)) = kernel.channel.state.cycle.axis else { return (kind, position(kernel)) };
    let scale = kernel.channel.state.place.axes.get(axis).map_or(1.0, |axis| axis.scale);
    let rules = (kernel.channel.env.machine.cycles.clearance, kernel.channel.env.machine.cycles.depth);
    depth(kernel, (role, axis), scale, rules.1);
    if kind.bores_back()
        && let Some(bottom) = height(kernel, data::CYCLE_BOTTOM, rules.0, scale)
    {
        kernel.channel.state.cycle.bottom = Some(bottom);
    }
    if let Some(clear) = height(kernel, data::CYCLE_CLEAR, rules.0, scale) {
        kernel.channel.state.cycle.clear = Some(clear);
    }
    if kind.has_webs() {
        for (web, ids) in super::webs::DATA.into_iter().enumerate() {
            for (end, id) in ids.into_iter().enumerate() {
                let height = height(kernel, id, rules.1, scale);
                let slot = kernel.channel.state.cycle.webs.get_mut(web).and_then(|web| web.get_mut(end));
                if let (Some(slot), Some(height)) = (slot, height) {
                    *slot = Some(height);
                }
            }
        }
    }
    let mut words = position(kernel);
    if let Some(retract) = height(kernel, data::CYCLE_RETRACT, rules.0, scale) {
        kernel.channel.state.cycle.retract = Some(retract);
    }
    let kind = amounts(kernel, kind);
    words.times = times(kernel);
    (kind, words)
}

/// Takes the position of a block that carries out the cycle defined before.
pub(super) fn take_position(kernel: &mut Kernel<'_>) -> Words {
    take_feed(kernel);
    let mut words = position(kernel);
    words.times = times(kernel);
    words
}

/// A feed of the cycle's own lasts until another one is programmed or the cycle ends; else that of the mode counts.
fn take_feed(kernel: &mut Kernel<'_>) {
    let own = [
        (data::CYCLE_UPM, FeedUnit::PerMinute),
        (data::CYCLE_UPR, FeedUnit::PerRevolution),
        (data::CYCLE_TPU, FeedUnit::PerRevolution),
    ];
    for (id, unit) in own {
        if let Some(datum) = kernel.take(id) {
            let pitch = |threads: f64| {
                if threads == 0.0 { 0.0 } else { kernel.channel.unit_factor(Dimension::Length) / threads }
            };
            let value = if id == data::CYCLE_TPU { pitch(datum.value) } else { datum.value };
            kernel.channel.state.cycle.feed = (Some(value), unit);
            kernel.channel.state.cycle.own_feed = true;
            return;
        }
    }
    let (id, unit) = feed_of(kernel.channel.state.modal.code(group::FEED));
    if let Some(datum) = kernel.take(id) {
        kernel.channel.state.modal.remember(id, datum.value);
        kernel.channel.state.cycle.feed = (Some(datum.value), unit);
        kernel.channel.state.cycle.own_feed = false;
    } else if !kernel.channel.state.cycle.own_feed {
        // Inverse time belongs to its block alone.
        let known = if unit == FeedUnit::InverseTime { None } else { kernel.channel.state.modal.value(id) };
        kernel.channel.state.cycle.feed = (known, unit);
    }
}

/// The depth: data of its own, else the word of the axis.
fn depth(kernel: &mut Kernel<'_>, (role, axis): (usize, usize), scale: f64, rule: Heights) {
    let id = [data::CYCLE_DEPTH_X, data::CYCLE_DEPTH_Y, data::CYCLE_DEPTH_Z].get(role).copied();
    let own = id.and_then(|id| height(kernel, id, rule, scale));
    let depth = own.or_else(|| {
        let id = kernel.channel.state.place.axes.get(axis).map(|axis| axis.data)?;
        height(kernel, id, rule, 1.0)
    });
    if depth.is_some() {
        kernel.channel.state.cycle.depth = depth;
    }
}

/// A height; a distance is divided by `scale`, which makes a radius a diameter.
fn height(kernel: &mut Kernel<'_>, id: DataId, rule: Heights, scale: f64) -> Option<Height> {
    let datum = kernel.take(id)?;
    let relative = is_relative(kernel, rule, &datum);
    if relative {
        return Some(Height { value: datum.value / scale, relative });
    }
    let axis = kernel.channel.state.cycle.axis.map(|(_, axis)| axis);
    // The word of the axis itself has been taken as its axis counts.
    let own = axis.filter(|axis| kernel.channel.state.place.axes.get(*axis).is_some_and(|axis| axis.data != id));
    let factor = own.map_or(1.0, |axis| kernel.factor_across(axis));
    let shift =
        axis.filter(|_| kernel.channel.block.machine_frame).and_then(|axis| kernel.channel.state.place.shift.get(axis));
    Some(Height { value: datum.value * factor - shift.copied().unwrap_or(0.0), relative })
}

fn is_relative(kernel: &Kernel<'_>, rule: Heights, datum: &Datum) -> bool {
    let mode = kernel.channel.state.modal.code(group::POSITION) == Some(codes::POSITION_RELATIVE);
    datum.incremental
        || !datum.absolute
            && match rule {
                Heights::Mode => mode,
                Heights::Absolute => false,
                Heights::Incremental => true,
            }
}

/// Position axes, and which of them are distances.
fn position(kernel: &mut Kernel<'_>) -> Words {
    let mode = kernel.channel.state.modal.code(group::POSITION) == Some(codes::POSITION_RELATIVE);
    let mut relative = 0;
    for (index, axis) in kernel.channel.state.place.axes.iter().enumerate() {
        let sources = kernel.plan.data.sources.get(usize::from(axis.data.0)).into_iter().flatten();
        let word = sources.filter_map(|source| kernel.channel.block.look(source.register)).next();
        let added = || kernel.channel.block.added.iter().any(|(id, _)| *id == axis.data);
        if word.is_some_and(|word| word.incremental || mode) || mode && added() {
            relative |= 1 << index;
        }
    }
    let (coded, target) = kernel.programmed_targets();
    Words { target, coded, relative: relative & coded, times: 1 }
}

/// Steps, dwell and shift, as far as the kind has them.
fn amounts(kernel: &mut Kernel<'_>, kind: Kind) -> Kind {
    use crate::machine::ident::kind::cycle::{Out, Steps};
    let mut kind = tap_type(kernel, kind);
    if kernel.channel.state.cycle.rigid == 2.0 && kind.taps() {
        kind = kind.rigid(false);
        if let Some(step) = kernel.take(data::CYCLE_STEP) {
            kernel.channel.state.cycle.step = Some(step.value.abs());
        }
        kind = kind.rigid(kernel.channel.state.cycle.step.is_some_and(|step| step > 0.0));
        kernel.channel.state.cycle.number = kind.number();
    } else if kind.is_rigid() {
        kernel.channel.state.cycle.rigid = 1.0;
    }
    if kind.dwells()
        && let Some(dwell) = kernel.take_seconds(data::CYCLE_DWELL)
        && let [bottom, ..] = &mut kernel.channel.state.cycle.dwell
    {
        *bottom = dwell;
    }
    if kind.steps() != Steps::None {
        if let Some(step) = kernel.take(data::CYCLE_STEP) {
            kernel.channel.state.cycle.step = Some(step.value.abs());
        }
        if let Some(decrement) = kernel.take(data::CYCLE_STEP_DECR) {
            kernel.channel.state.cycle.decrement = decrement.value.abs();
        }
    }
    if (kind.steps() != Steps::None || kind.has_webs())
        && let Some(back) = kernel.take(data::CYCLE_STEP_BACK)
    {
        kernel.channel.state.cycle.step_back = back.value.abs();
    }
    if kind.is_rigid()
        && let Some(orient) = kernel.take(data::CYCLE_RIGID_ORIENT)
    {
        kernel.channel.state.cycle.orient = orient.value;
    }
    if kind.out() == Out::Oriented {
        shifts(kernel);
    }
    kind
}

/// A tap as its type says, if one has been programmed.
fn tap_type(kernel: &mut Kernel<'_>, kind: Kind) -> Kind {
    if !kind.taps() {
        return kind;
    }
    if let Some(datum) = kernel.take(data::CYCLE_TAP_TYPE) {
        if kind.tap(datum.value).is_none() {
            let text = format!(
                "{} is no type of a tap in '{}': 0 floating, 1 rigid, 2 deep, 3 breaking chips",
                datum.value,
                kernel.block_text()
            );
            kernel.diagnose(&diag::DATA_OUT_OF_RANGE, text);
        } else {
            kernel.channel.state.cycle.tap = Some(datum.value);
        }
    }
    let Some(typed) = kernel.channel.state.cycle.tap.and_then(|wanted| kind.tap(wanted)) else { return kind };
    kernel.channel.state.cycle.number = typed.number();
    if !typed.is_rigid() && kernel.channel.state.cycle.rigid == 1.0 {
        kernel.channel.state.cycle.rigid = 0.0;
    }
    typed
}

fn shifts(kernel: &mut Kernel<'_>) {
    if let Some(orient) = kernel.take(data::CYCLE_ORIENT) {
        kernel.channel.state.cycle.orient = orient.value;
    }
    if let Some(shift) = kernel.take(data::CYCLE_BORE_JOG) {
        kernel.channel.state.cycle.shift = shift.value;
    }
    for (index, id) in [data::CYCLE_BORE_JOG_X, data::CYCLE_BORE_JOG_Y, data::CYCLE_BORE_JOG_Z].into_iter().enumerate()
    {
        if let Some(datum) = kernel.take(id)
            && let Some(slot) = kernel.channel.state.cycle.shifts.get_mut(index)
        {
            *slot = Some(datum.value);
        }
    }
}

/// How often the cycle is carried out on this block; 0 only stores its values.
fn times(kernel: &mut Kernel<'_>) -> u32 {
    kernel.take(data::CYCLE_REPEAT).map_or(1, |datum| datum.value.clamp(0.0, MOST_TIMES) as u32)
}
