//! Alarms of a channel, and their effect in a block.

use super::channel::ChannelContext;
use counterpoint_fault::DiagnosticFacts;
use counterpoint_fault::{Acted, Halt};

/// Alarms of a channel.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Alarms {
    /// A diagnostic of this block stops the channel before the next code acts.
    pub(crate) stopping: bool,
    /// Diagnostics of severity 8 or more in the log.
    pub(crate) errors: u32,
    /// Alarms gone on from that are not among them.
    pub(crate) softened: u32,
}

impl Alarms {
    /// Counts an entry of the log if it is an error.
    pub(crate) fn count(&mut self, severity: u8) {
        if severity >= ERROR {
            self.errors = self.errors.saturating_add(1);
        }
    }
}

/// Severity from which a diagnostic is an error.
const ERROR: u8 = 8;

/// The effect of an alarm in its block.
pub(crate) const NOT_DONE: &str = "no part of the block acts";

/// Replacement for a circle that cannot be made.
pub(crate) const STRAIGHT: &str = "a straight move is made instead";

impl ChannelContext<'_> {
    /// Treatment of a block with this report: the replacement, unless the channel stops.
    pub(crate) fn becomes(&self, facts: &DiagnosticFacts, instead: &'static str) -> &'static str {
        if self.env.machine.stops_at(facts) { NOT_DONE } else { instead }
    }

    /// A diagnostic of this block has stopped the channel.
    #[inline(always)]
    pub(crate) fn check_stop(&self) -> Acted {
        if self.reports.alarms.stopping { Err(Halt::Alarm) } else { Ok(()) }
    }
}
