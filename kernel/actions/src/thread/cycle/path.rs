//! The moves of threading cycles.
//!
//! Facts: reference control-emulator.md 6.5: rapid to the depth, thread, chamfer (a thread between 30 and 60 degrees,
//! straight feed otherwise), clear, rapid back. *Invariant:* every pass begins and ends where the cycle was called.

use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_event::event::{FeedUnit, Position};
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_motion::thread::Lead;

use super::{Thread, plan};
use crate::context::ActionContext;
use crate::motion::{feed_to_point, rapid_to_point};
use crate::thread::{Screw, cut_to_point};

impl Thread {
    /// Outwards: away from the thread, towards where the tool is.
    fn outward(&self, level: f64) -> f64 {
        if level < self.root { -1.0 } else { 1.0 }
    }

    /// Where the flank is across, at a place along the thread; `root` is where the pass ends.
    fn across(&self, root: f64, along: f64) -> f64 {
        root + self.taper * (self.end - along) / (self.end - self.begin)
    }
}

/// A pull-out at the end of a pass.
struct Chamfer {
    /// Where it begins, and where it ends along and across.
    from: f64,
    to: [f64; 2],
    /// Cut as thread.
    locked: bool,
}

/// All passes of a thread, each for every start.
pub(crate) fn all_passes(act: &mut ActionContext<'_, '_>, thread: &Thread) -> Acted {
    let plan = plan(act)?;
    let (passes, cut_short) = plan.passes();
    act.channel_mut().state.threads.cycle.made = (passes.len() as u32).saturating_sub(plan.finish_cuts);
    if cut_short {
        let text =
            format!("the thread of '{}' has too many passes, the rest is cut in one pass", act.channel().block_text());
        act.diagnose(&diag::THREAD_PASSES, text);
    }
    let level = act.channel().state.place.programmed().at(thread.axes[1]) * thread.scales[1];
    let outward = thread.outward(level);
    let flank = libm::tan(act.channel().state.threads.cycle.nose.to_radians() / 2.0);
    let mut first = true;
    for pass in passes {
        let aside = match plan.mode {
            1 | 3 => true,
            2 | 4 => pass.number > 0 && pass.number % 2 == 0,
            _ => false,
        };
        let shift = if aside { flank * pass.depth } else { 0.0 };
        let root = thread.root + outward * (plan.depth - pass.depth);
        for _ in 0..act.channel().state.threads.starts as u32 {
            if !std::mem::take(&mut first) {
                act.count_as_block()?;
            }
            cut_pass(act, thread, root, shift)?;
        }
    }
    Ok(())
}

/// One pass that ends at `root` across and begins `shift` further along.
pub(crate) fn cut_pass(act: &mut ActionContext<'_, '_>, thread: &Thread, root: f64, shift: f64) -> Acted {
    let [along, across] = thread.axes;
    let home = act.channel().state.place.programmed();
    let of = |axis: AxisSlot| home.at(axis);
    let level = of(across) * thread.scales[1];
    let way = thread.end - thread.begin;
    let begin = thread.begin + way.signum() * shift.min(way.abs());
    rapid_aside(act, thread, [begin, thread.across(root, begin)])?;
    let chamfer = pull_out(act.channel_mut(), thread, root, level, begin);
    let last = chamfer.as_ref().map_or(thread.end, |chamfer| chamfer.from);
    let target = place_of(act.channel(), thread, [last, thread.across(root, last)]);
    cut_to_point(act, along.bit() | moved(act.channel(), across, &target), target, &thread.screw)?;
    if let Some(chamfer) = chamfer {
        cut_chamfer(act, thread, &chamfer, (last - begin).abs())?;
    }
    let mut clear = act.channel().state.place.programmed();
    *clear.at_mut(across) = of(across);
    rapid_to_point(act, across.bit(), clear)?;
    rapid_to_point(act, along.bit(), home)
}

/// A position with these places along and across the thread.
fn place_of(channel: &ChannelContext<'_>, thread: &Thread, places: [f64; 2]) -> Position {
    let mut target = channel.state.place.programmed();
    for ((axis, scale), value) in thread.axes.iter().zip(thread.scales).zip(places) {
        let (slot, wanted) = (target.at_mut(*axis), value / scale);
        // Digits of sums after the ninth were not programmed.
        *slot = if (wanted - *slot).abs() < 1e-9 { *slot } else { wanted };
    }
    target
}

/// Bit of an axis if it moves to the target.
fn moved(channel: &ChannelContext<'_>, axis: AxisSlot, target: &Position) -> u8 {
    if channel.state.place.programmed().at(axis) == target.at(axis) { 0 } else { axis.bit() }
}

fn rapid_aside(act: &mut ActionContext<'_, '_>, thread: &Thread, places: [f64; 2]) -> Acted {
    let target = place_of(act.channel(), thread, places);
    let coded = thread.axes.iter().fold(0, |bits, axis| bits | moved(act.channel(), *axis, &target));
    rapid_to_point(act, coded, target)
}

/// The chamfer of a pass, if there is one: no higher than where the tool is.
fn pull_out(channel: &mut ChannelContext<'_>, thread: &Thread, root: f64, level: f64, begin: f64) -> Option<Chamfer> {
    let cycle = &mut channel.state.threads.cycle;
    if !cycle.pull_out.on {
        return None;
    }
    let slope = libm::tan(cycle.pull_out.angle.to_radians());
    if let Some(leads) = cycle.pull_out.leads {
        cycle.pull_out.length = leads * thread.screw.lead;
    }
    let starts = channel.state.threads.starts;
    let cycle = &channel.state.threads.cycle;
    let length = if cycle.pull_out.length > 0.0 {
        cycle.pull_out.length
    } else {
        // As high as a thread of 60 degrees is deep.
        thread.screw.lead / starts / (2.0 * libm::tan(std::f64::consts::FRAC_PI_6)) / slope
    };
    let angle = cycle.pull_out.angle;
    let way = thread.end - begin;
    let length = length.min(way.abs());
    if length.is_nan() || length <= 0.0 {
        return None;
    }
    let from = thread.end - way.signum() * length;
    let foot = thread.across(root, from);
    let outward = thread.outward(level);
    let room = outward * (level - foot);
    let height = if room > 0.0 { (length * slope).min(room) } else { length * slope };
    let to = [from + way.signum() * height / slope, foot + outward * height];
    Some(Chamfer { from, to, locked: (30.0..=60.0).contains(&angle) })
}

fn cut_chamfer(act: &mut ActionContext<'_, '_>, thread: &Thread, chamfer: &Chamfer, way: f64) -> Acted {
    let target = place_of(act.channel(), thread, chamfer.to);
    let coded = thread.axes[0].bit() | thread.axes[1].bit();
    let lead = Lead { start: thread.screw.lead, change: thread.screw.change }.after(way);
    if chamfer.locked {
        return cut_to_point(act, coded, target, &Screw { lead, ..thread.screw });
    }
    feed_to_point(act, coded, target, Some(lead), FeedUnit::PerRevolution)
}
