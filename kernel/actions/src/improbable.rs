//! Feeds that a control accepts but that are hardly ever intended: above the rate of every axis, moves of hours, taps
//! above the rate of their axis, and moves with the spindle off.
//!
//! *Invariant:* nothing here changes a move or its time. Feed moves that need no look cost one comparison.

use crate::context::ActionContext;
use crate::thread::EVEN;
use crate::time::TimedPath;
use counterpoint_channel::plausible::hours;
use counterpoint_event::event::{FeedUnit, SpindleDirection};
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_machine::ident::kind::cycle::HoleCycle;
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_motion::law::SpindleRotation;

/// Feeds from here on are a way to ask for the highest one, units per minute.
const HIGHEST: f64 = 99_999.0;

impl ActionContext<'_, '_> {
    /// Reports a rigid tap whose feed is above the rate of its axis, once in a program.
    pub(crate) fn check_tap_rate(&mut self, (feed, unit): (Option<f64>, FeedUnit), axis: AxisSlot) -> Acted {
        let Some(feed) = feed.filter(|_| !self.channel().reports.plausible.thread) else { return Ok(()) };
        let asked = match (unit, self.spindle_speed()?) {
            (FeedUnit::PerMinute, _) => feed,
            (FeedUnit::PerRevolution, Some(SpindleRotation::Fixed(rpm))) => feed * rpm,
            _ => return Ok(()),
        };
        let most = self.channel().state.place.layout.axes[axis].rapid * 60.0;
        if asked <= most * EVEN {
            return Ok(());
        }
        self.channel_mut().reports.plausible.thread = true;
        let text = format!(
            "the rigid tap of '{}' needs a rate of {asked:.0} where its axis reaches {most:.0}: reduce the spindle speed",
            self.channel().block_text()
        );
        self.diagnose(&diag::THREAD_RATE, text);
        self.channel().check_stop()
    }

    /// Checks a feed per minute above [`look_above`](counterpoint_channel::plausible::Plausible).
    #[cold]
    pub(crate) fn look_at_feed(&mut self, feed: f64, path: &TimedPath<'_>) -> Acted {
        let again = self.look_at_spindle(path)?;
        self.channel_mut().reports.plausible.look_above = if again { 0.0 } else { f64::INFINITY };
        if self.channel().reports.plausible.feed {
            return Ok(());
        }
        let fastest = self.fastest_rate();
        if fastest <= 0.0 {
            return Ok(());
        }
        if feed <= fastest || feed >= HIGHEST {
            self.channel_mut().reports.plausible.look_above = if again { 0.0 } else { fastest };
            return Ok(());
        }
        self.report_feed_rate(feed, fastest, "");
        Ok(())
    }

    /// Looks at the rate of a feed per revolution, units per minute.
    #[cold]
    pub(crate) fn look_at_revolutions(&mut self, rate: f64) -> Acted {
        let fastest = self.fastest_rate();
        let looks = !self.channel().reports.plausible.feed && fastest > 0.0;
        self.channel_mut().reports.plausible.look_above_revolutions = if looks { fastest } else { f64::INFINITY };
        if looks && rate > fastest {
            self.channel_mut().reports.plausible.look_above_revolutions = f64::INFINITY;
            self.report_feed_rate(rate, fastest, ", per revolution at the speed of the spindle,");
        }
        self.channel().check_stop()
    }

    /// Reports a move at feed that takes hours, once in a program.
    #[cold]
    pub(crate) fn report_long_move(&mut self, seconds: f64) {
        if std::mem::replace(&mut self.channel_mut().reports.plausible.long_move, true) {
            return;
        }
        let text = format!(
            "the move at feed of '{}' takes {}: check the value and the unit of F",
            self.channel().block_text(),
            hours(seconds)
        );
        self.diagnose(&diag::LONG_MOVE, text);
    }

    /// The highest rate of the linear axes, units per minute.
    fn fastest_rate(&self) -> f64 {
        let rates =
            self.channel().state.place.layout.axes.iter().filter(|axis| !axis.rotary).map(|axis| axis.rapid * 60.0);
        rates.fold(0.0, f64::max)
    }

    fn report_feed_rate(&mut self, rate: f64, fastest: f64, how: &str) {
        self.channel_mut().reports.plausible.feed = true;
        let text = format!(
            "the feed {rate:.0}{how} in '{}' is above the rate of every axis, at most {fastest:.0}: check its value and \
             unit",
            self.channel().block_text()
        );
        self.diagnose(&diag::FEED_RATE, text);
    }

    /// Reports the first move at feed while the spindle is off, where the machine asks for it; returns whether the next
    /// move has to be looked at as well, because this one is an exception.
    fn look_at_spindle(&mut self, path: &TimedPath<'_>) -> Result<bool, Halt> {
        let asked = self.channel().env.machine.habits.feed_needs_spindle && !self.channel().reports.plausible.spindle;
        let own = self.channel().state.spindle.id.is_some() && !self.channel().state.spindle.shared;
        if !(asked && own) {
            return Ok(false);
        }
        if self.taps() {
            return Ok(true);
        }
        if self.spindle_speed()?.is_some() {
            return Ok(false);
        }
        // Stopped at an angle on purpose: fine boring, broaching.
        if self.channel().state.spindle.command.direction == SpindleDirection::Oriented {
            return Ok(false);
        }
        if self.only_turns(path) {
            return Ok(true);
        }
        self.channel_mut().reports.plausible.spindle = true;
        let text = format!("the move at feed in '{}' begins while the spindle is off", self.channel().block_text());
        self.diagnose(&diag::SPINDLE_OFF, text);
        Ok(false)
    }

    /// Whether a tapping cycle runs, which turns the spindle itself.
    fn taps(&self) -> bool {
        self.channel().state.cycle.running
            && HoleCycle::numbered(self.channel().state.cycle.number).is_some_and(HoleCycle::taps)
    }

    /// Whether only rotary axes move: they position the part or the head.
    fn only_turns(&self, path: &TimedPath<'_>) -> bool {
        let moves = |slot: AxisSlot| path.from.at(slot) != path.to.at(slot);
        let mut moving = self.channel().state.place.layout.axes.entries().filter(|(slot, _)| moves(*slot)).peekable();
        // A whole circle ends where it begins.
        moving.peek().is_some() && moving.all(|(_, axis)| axis.rotary)
    }
}
