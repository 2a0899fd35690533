//! Moves that end where an axis meets a part or a stop.
//!
//! Facts: reference shop-machines.md 12 (part transfer, press). Decisions: there is no model of the part, so the machine
//! or a variable gives its place. A mode applies to slides of spindles and axes with a known stop that move away from
//! home. A code or a name applies to its axes in both directions. *Invariant:* no move passes a stop that it looks for.

use counterpoint_event::event::{Motion, MotionKind};
use counterpoint_fault::{self as diag, Acted, DiagnosticFacts, Halt};
use counterpoint_lang::format::wildcard_text;
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_machine::model::FixedStop;

use super::{Kernel, chucks, variables};

/// A move of an axis that looks for a stop, in the machine frame.
#[derive(Debug)]
struct Search {
    slot: AxisSlot,
    from: f64,
    to: f64,
    stop: f64,
    /// It moves away from home.
    away: bool,
}

impl Search {
    /// The share of the move until the axis meets its stop, if it does. An axis at its stop cannot move away from home.
    fn share(&self) -> Option<f64> {
        if self.stop == self.from {
            return (self.to == self.from || self.away).then_some(0.0);
        }
        let share = (self.stop - self.from) / (self.to - self.from);
        (0.0..=1.0).contains(&share).then_some(share)
    }

    /// Whether the axis has passed the stop and moves further away from it.
    fn goes_away(&self) -> bool {
        self.stop != self.from && self.to != self.from && (self.stop > self.from) != (self.to > self.from)
    }
}

/// Executes a move that may end at a stop.
pub(super) fn travel(kernel: &mut Kernel<'_>, seconds: f64, motion: &Motion) -> Acted {
    let searches = searches(kernel, motion)?;
    if searches.is_empty() {
        return chucks::travel(kernel, seconds, motion);
    }
    if let Some(search) = searches.iter().find(|search| search.goes_away() && motion.kind == MotionKind::Linear) {
        let text = format!(
            "axis {} would move from {} to {}, away from its stop at {}: check the position of the stop and the previous move",
            name_of(kernel, search.slot),
            wildcard_text(search.from),
            wildcard_text(search.to),
            wildcard_text(search.stop)
        );
        return Err(refuse(kernel, &diag::FIXED_STOP_MISSED, &text));
    }
    let met = searches.iter().filter_map(|search| Some((search.share()?, search)));
    let Some((share, search)) = met.min_by(|a, b| a.0.total_cmp(&b.0)) else {
        if motion.from != motion.to {
            chucks::travel(kernel, seconds, motion)?;
        }
        return missed(kernel, motion, &searches);
    };
    let stops = kernel.channel.state.others.spindles.fixed_stops;
    if motion.kind != MotionKind::Linear || kernel.channel.state.cycle.running || stops.in_turning_cycle {
        let text = format!(
            "axis {} would pass its stop at {}: only a straight feed move outside a cycle ends at a stop",
            name_of(kernel, search.slot),
            wildcard_text(search.stop)
        );
        return Err(refuse(kernel, &diag::FIXED_STOP_KIND, &text));
    }
    kernel.channel.state.others.spindles.fixed_stops.met |= stops.named & search.slot.bit();
    if share == 0.0 {
        return Ok(());
    }
    let mut to = motion.from;
    to.iter_mut().zip(&motion.to).for_each(|(slot, end)| *slot += (end - *slot) * share);
    *to.at_mut(search.slot) = motion.from.at(search.slot) + (search.stop - search.from);
    let (seconds, motion) = (kernel.plan.actions.straight.shorten)(kernel, motion, to)?;
    chucks::travel(kernel, seconds, &motion)?;
    kernel.channel.emitter.stop_path();
    Ok(())
}

/// The axes of a move that look for a stop.
fn searches(kernel: &mut Kernel<'_>, motion: &Motion) -> Result<Vec<Search>, Halt> {
    let machine = kernel.channel.env.machine;
    let stops = kernel.channel.state.others.spindles.fixed_stops;
    let place = &kernel.channel.state.place;
    let [from, to] = [&motion.from, &motion.to].map(|position| place.machine_point(position));
    let mut found = Vec::new();
    for slot in place.layout.axes.ids() {
        let axis = place.layout.axes[slot].machine;
        let (from, to, home) = (from.at(slot), to.at(slot), machine.axes[axis].home);
        let stop = machine.axes[axis].positioning.stop;
        let away = (to - home).abs() > (from - home).abs();
        let by_name = (stops.once & motion.moving | stops.named) & slot.bit() != 0;
        let slides = machine.spindles.iter().any(|spindle| spindle.slide == Some(axis));
        let by_mode = stops.modal && away && (slides || stop != Default::default());
        if by_mode || by_name && (from != to || motion.from == motion.to) {
            found.push((slot, from, to, away, stop));
        }
    }
    let known = found.into_iter().map(|(slot, from, to, away, stop)| {
        let stop = place_of(kernel, slot, stop)?;
        Ok(Search { slot, from, to, stop, away })
    });
    known.collect()
}

/// Position at which an axis meets its stop.
fn place_of(kernel: &mut Kernel<'_>, slot: AxisSlot, stop: FixedStop) -> Result<f64, Halt> {
    if let Some(number) = stop.variable
        && let Some(at) = variables::value_of_variable(kernel, number)?
    {
        return Ok(at * counterpoint_channel::addresses::length_factor(&kernel.channel, slot));
    }
    if let Some(at) = stop.at {
        return Ok(at);
    }
    let axis = name_of(kernel, slot);
    let remedy = match stop.variable {
        Some(number) => format!("set variable {number} to its machine position"),
        None => format!("run with --set stop.{axis}=POSITION, or give the machine `stops.at`"),
    };
    let text = format!("the position at which axis {axis} meets its stop is not known: {remedy}");
    Err(refuse(kernel, &diag::FIXED_STOP_UNKNOWN, &text))
}

/// The name of an axis in machines and settings.
fn name_of<'m>(kernel: &Kernel<'m>, slot: AxisSlot) -> &'m str {
    &kernel.channel.env.machine.axes[kernel.channel.state.place.layout.axes[slot].machine].name
}

fn refuse(kernel: &mut Kernel<'_>, facts: &DiagnosticFacts, reason: &str) -> Halt {
    let text = format!("{reason}, in '{}'; nothing moves", kernel.channel.block_text());
    kernel.alarm(facts, text)
}

/// The alarm after a move that has met no stop.
fn missed(kernel: &mut Kernel<'_>, motion: &Motion, searches: &[Search]) -> Acted {
    let Some(search) = searches.first().filter(|_| motion.kind == MotionKind::Linear) else { return Ok(()) };
    let text = format!(
        "axis {} has moved from {} to {} and has not met its stop at {}, in '{}': check the position of the part and the end \
         of the move",
        name_of(kernel, search.slot),
        wildcard_text(search.from),
        wildcard_text(search.to),
        wildcard_text(search.stop),
        kernel.channel.block_text()
    );
    Err(kernel.alarm(&diag::FIXED_STOP_MISSED, text))
}
