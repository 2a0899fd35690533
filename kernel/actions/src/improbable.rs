//! Feeds that a control accepts but that are hardly ever intended: above the rate of every axis, moves of hours, taps
//! above the rate of their axis, and moves with the spindle off.
//!
//! *Invariant:* nothing here changes a move or its time. Feed moves that need no look cost one comparison.

use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::plausible::hours;
use counterpoint_event::event::{FeedUnit, SpindleDirection};
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_machine::ident::kind::cycle::HoleCycle;
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_motion::law::SpindleRotation;

use crate::context::ActionContext;
use counterpoint_channel::timed_path::{EVEN, TimedPath};

/// Feeds from here on are a way to ask for the highest one, units per minute.
const HIGHEST: f64 = 99_999.0;

/// Checks a feed per minute above [`look_above`](counterpoint_channel::plausible::Plausible).
#[cold]
pub(crate) fn look_at_feed(act: &mut ActionContext<'_, '_>, feed: f64, path: &TimedPath<'_>) -> Acted {
    let again = look_at_spindle(act, path)?;
    act.channel_mut().reports.plausible.look_above = if again { 0.0 } else { f64::INFINITY };
    if act.channel().reports.plausible.feed {
        return Ok(());
    }
    let fastest = fastest_rate(act.channel());
    if fastest <= 0.0 {
        return Ok(());
    }
    if feed <= fastest || feed >= HIGHEST {
        act.channel_mut().reports.plausible.look_above = if again { 0.0 } else { fastest };
        return Ok(());
    }
    report_feed_rate(act, feed, fastest, "");
    Ok(())
}

/// Checks the rate of a feed per revolution, units per minute.
#[cold]
pub(crate) fn look_at_revolutions(act: &mut ActionContext<'_, '_>, rate: f64) -> Acted {
    let fastest = fastest_rate(act.channel());
    let looks = !act.channel().reports.plausible.feed && fastest > 0.0;
    act.channel_mut().reports.plausible.look_above_revolutions = if looks { fastest } else { f64::INFINITY };
    if looks && rate > fastest {
        act.channel_mut().reports.plausible.look_above_revolutions = f64::INFINITY;
        report_feed_rate(act, rate, fastest, ", per revolution at the speed of the spindle,");
    }
    act.channel().check_stop()
}

/// Reports a move at feed that takes hours, once in a program.
#[cold]
pub(crate) fn report_long_move(act: &mut ActionContext<'_, '_>, seconds: f64) {
    if std::mem::replace(&mut act.channel_mut().reports.plausible.long_move, true) {
        return;
    }
    let text = format!(
        "the move at feed of '{}' takes {}: check the value and the unit of F",
        act.channel().block_text(),
        hours(seconds)
    );
    act.diagnose(&diag::LONG_MOVE, text);
}

/// Reports a rigid tap whose feed is above the rate of its axis, once in a program.
pub(crate) fn check_tap_rate(
    act: &mut ActionContext<'_, '_>,
    (feed, unit): (Option<f64>, FeedUnit),
    axis: AxisSlot,
) -> Acted {
    let Some(feed) = feed.filter(|_| !act.channel().reports.plausible.thread) else { return Ok(()) };
    let asked = match (unit, act.spindle_speed()?) {
        (FeedUnit::PerMinute, _) => feed,
        (FeedUnit::PerRevolution, Some(SpindleRotation::Fixed(rpm))) => feed * rpm,
        _ => return Ok(()),
    };
    let most = act.channel().state.place.layout.axes[axis].rapid * 60.0;
    if asked <= most * EVEN {
        return Ok(());
    }
    act.channel_mut().reports.plausible.thread = true;
    let text = format!(
        "the rigid tap of '{}' needs a rate of {asked:.0} where its axis reaches {most:.0}: reduce the spindle speed",
        act.channel().block_text()
    );
    act.diagnose(&diag::THREAD_RATE, text);
    act.channel().check_stop()
}

/// The highest rate of the linear axes, units per minute.
fn fastest_rate(channel: &ChannelContext<'_>) -> f64 {
    let rates = channel.state.place.layout.axes.iter().filter(|axis| !axis.rotary).map(|axis| axis.rapid * 60.0);
    rates.fold(0.0, f64::max)
}

fn report_feed_rate(act: &mut ActionContext<'_, '_>, rate: f64, fastest: f64, how: &str) {
    act.channel_mut().reports.plausible.feed = true;
    let text = format!(
        "the feed {rate:.0}{how} in '{}' is above the rate of every axis, at most {fastest:.0}: check its value and \
         unit",
        act.channel().block_text()
    );
    act.diagnose(&diag::FEED_RATE, text);
}

/// Reports the first move at feed while the spindle is off, where the machine asks for it; returns whether the next
/// move has to be looked at as well, because this one is an exception.
fn look_at_spindle(act: &mut ActionContext<'_, '_>, path: &TimedPath<'_>) -> Result<bool, Halt> {
    let asked = act.channel().env.machine.habits.feed_needs_spindle && !act.channel().reports.plausible.spindle;
    let own = act.channel().state.spindle.id.is_some() && !act.channel().state.spindle.shared;
    if !(asked && own) {
        return Ok(false);
    }
    if taps(act.channel()) {
        return Ok(true);
    }
    if act.spindle_speed()?.is_some() {
        return Ok(false);
    }
    // Stopped at an angle on purpose: fine boring, broaching.
    if act.channel().state.spindle.command.direction == SpindleDirection::Oriented {
        return Ok(false);
    }
    if only_turns(act.channel(), path) {
        return Ok(true);
    }
    act.channel_mut().reports.plausible.spindle = true;
    let text = format!("the move at feed in '{}' begins while the spindle is off", act.channel().block_text());
    act.diagnose(&diag::SPINDLE_OFF, text);
    Ok(false)
}

/// Whether a tapping cycle runs, which turns the spindle itself.
fn taps(channel: &ChannelContext<'_>) -> bool {
    channel.state.cycle.running && HoleCycle::numbered(channel.state.cycle.number).is_some_and(HoleCycle::taps)
}

/// Whether only rotary axes move: they position the part or the head.
fn only_turns(channel: &ChannelContext<'_>, path: &TimedPath<'_>) -> bool {
    let moves = |slot: AxisSlot| path.from.at(slot) != path.to.at(slot);
    let mut moving = channel.state.place.layout.axes.entries().filter(|(slot, _)| moves(*slot)).peekable();
    // A whole circle ends where it begins.
    moving.peek().is_some() && moving.all(|(_, axis)| axis.rotary)
}
