//! The effect of an alarm in its block.

use counterpoint_fault::{Acted, DiagnosticFacts, Halt};

use super::channel_context::ChannelContext;

/// The effect of an alarm in its block.
pub const NOT_DONE: &str = "no part of the block acts";

/// Replacement for a circle that cannot be made.
pub const STRAIGHT: &str = "a straight move is made instead";

impl ChannelContext<'_> {
    /// Treatment of a block with this report: the replacement, unless the channel stops.
    pub fn becomes(&self, facts: &DiagnosticFacts, instead: &'static str) -> &'static str {
        if self.env.machine.stops_at(facts) { NOT_DONE } else { instead }
    }

    /// A diagnostic of this block has stopped the channel.
    #[inline(always)]
    pub fn check_stop(&self) -> Acted {
        if self.reports.alarms.stopping { Err(Halt::Alarm) } else { Ok(()) }
    }
}
