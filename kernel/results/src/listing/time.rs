//! The table of machining time.
//!
//! Layout: reference listing-and-trace.md 7.4. Each time is rounded by itself, the total from the unrounded sum.

use std::io::{Result, Write};

use crate::summary::Summary;
use counterpoint_event::info::Info;

/// `HH:MM:SS`, nearest second.
pub(super) fn clock(ns: i64) -> String {
    let seconds = ns.saturating_add(500_000_000) / 1_000_000_000;
    format!("{:02}:{:02}:{:02}", seconds / 3600, seconds / 60 % 60, seconds % 60)
}

pub(super) fn write(info: &Info, summary: &Summary, channel: u16, out: &mut dyn Write) -> Result<()> {
    let own = summary.channels.iter().find(|c| c.channel == channel);
    let [feed, rapid, misc, idle] = own.map_or([0; 4], |c| [c.feed_ns, c.rapid_ns, c.misc_ns, c.wait_ns]);
    let total = feed + rapid + misc + idle;
    write!(out, "\nTYPE       HH:MM:SS      PERCENT\n\n")?;
    let rows = [("FEED", feed), ("RAPID", rapid), ("MISC", misc), ("IDLE", idle)];
    let shown = if info.channels.len() > 1 { 4 } else { 3 };
    for (name, ns) in rows.into_iter().take(shown) {
        let percent = if total > 0 { ns as f64 / total as f64 * 100.0 } else { 0.0 };
        writeln!(out, "{name:<11}{}{percent:>13.3}", clock(ns))?;
    }
    writeln!(out, "\n{:<11}{}", "TOTAL", clock(total))
}
