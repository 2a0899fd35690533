//! Block lines and wait lines.
//!
//! Layout: reference listing-and-trace.md 3 (`n! block`), 8 (waits, prefix of the merged listing).

use std::collections::VecDeque;
use std::io::{Result, Write};

use rustc_hash::FxHashMap;

use crate::summary::Summary;
use counterpoint_event::event::{Event, WaitArrival};
use counterpoint_event::info::Info;

/// `n! block`, the block exactly as read.
pub(super) fn write_block(info: &Info, event: &Event, out: &mut dyn Write) -> Result<()> {
    writeln!(out, "{}! {}", event.line, info.line_text(event.file, event.line))
}

/// `K2 t=000:12.400 ` before a line of the merged listing.
pub(super) fn write_prefix(event: &Event, out: &mut dyn Write) -> Result<()> {
    write!(out, "K{} t={} ", event.channel, clock(event.t_ns))
}

/// Simulated time as `mmm:ss.sss`, rounded to the nearest millisecond.
pub(super) fn clock(ns: i64) -> String {
    let ms = ns.saturating_add(500_000) / 1_000_000;
    format!("{:03}:{:02}.{:03}", ms / 60_000, ms / 1000 % 60, ms % 1000)
}

/// Releases of the waits to come, by channel, in order.
#[derive(Debug)]
pub(super) struct UpcomingReleases(FxHashMap<u16, VecDeque<Option<i64>>>);

impl UpcomingReleases {
    pub(super) fn new(summary: &Summary) -> Self {
        let mut releases: FxHashMap<u16, VecDeque<Option<i64>>> = FxHashMap::default();
        for meeting in summary.waits.iter() {
            for arrival in &meeting.arrivals {
                releases.entry(arrival.channel).or_default().push_back(meeting.release_ns);
            }
        }
        Self(releases)
    }

    /// The line of a wait at its arrival.
    pub(super) fn write(&mut self, event: &Event, wait: &WaitArrival, out: &mut dyn Write) -> Result<()> {
        let release = self.0.get_mut(&event.channel).and_then(VecDeque::pop_front).flatten();
        let mark = &wait.mark;
        match release {
            Some(ns) => writeln!(out, "wait mark={mark} until {}", clock(ns)),
            None => writeln!(out, "wait mark={mark} never released"),
        }
    }
}
