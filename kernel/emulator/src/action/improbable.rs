//! Feeds that a control takes and that are hardly ever meant: above the rate of every axis, and with the spindle off.
//!
//! *Invariant:* nothing here changes a move or its time. Feed moves that need no look cost one comparison.

use crate::act::Act;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;

/// Feeds from here on are a way to ask for the highest one, units per minute.
const HIGHEST: f64 = 99_999.0;

impl Act<'_, '_> {
    /// Looks at a feed per minute that is above [`look_above`](crate::state::plausible::Plausible).
    #[cold]
    pub(super) fn look_at_feed(&mut self, feed: f64) -> Acted {
        self.reports.plausible.look_above = f64::INFINITY;
        self.look_at_spindle()?;
        if self.reports.plausible.feed {
            return Ok(());
        }
        let rates = self.state.place.layout.axes.iter().filter(|axis| !axis.rotary).map(|axis| axis.rapid * 60.0);
        let fastest = rates.fold(0.0, f64::max);
        if fastest <= 0.0 {
            return Ok(());
        }
        if feed <= fastest || feed >= HIGHEST {
            self.reports.plausible.look_above = fastest;
            return Ok(());
        }
        self.reports.plausible.feed = true;
        let text = format!(
            "the feed {feed:.0} in '{}' is above the rate of every axis, at most {fastest:.0}: check its value and unit",
            self.block_text()
        );
        self.diagnose(&diag::FEED_RATE, text);
        Ok(())
    }

    /// Reports the first move at feed while the spindle is off, where the machine asks for it.
    fn look_at_spindle(&mut self) -> Acted {
        let asked = self.env.machine.habits.feed_needs_spindle && !self.reports.plausible.spindle;
        let own = self.state.spindle.id.is_some() && !self.state.spindle.shared;
        if !(asked && own) || self.spindle_speed()?.is_some() {
            return Ok(());
        }
        self.reports.plausible.spindle = true;
        let text = format!("the move at feed in '{}' begins while the spindle is off", self.block_text());
        self.diagnose(&diag::SPINDLE_OFF, text);
        Ok(())
    }
}
