//! The verification listing of one channel, and the merged one of all.
//!
//! Layouts: reference listing-and-trace.md 2, 3, 5, 7, 8; columns are exact. Invariants: the same log gives the same
//! listing (no date, no process number); events are folded as they stream by, the log is never held.
//!
//! Where the reference leaves a choice: diagnostics of the master kernel are in every listing, since they concern
//! all channels; tooling feeds are as programmed (threads and inverse time left out); the rev/min of constant surface
//! speed are the means of the motions; travel extremes are those of all places reached by the motions of a table.

mod actions;
mod blocks;
mod console;
mod crlf;
mod diagnostics;
mod header;
#[cfg(test)]
mod tests;
mod time;
mod tooling;
mod trace;
mod travel;

pub use console::render_console;
pub use crlf::Crlf;

use std::io::{BufWriter, Result, Write};

use rustc_hash::FxHashMap;

use crate::summary::Summary;
use blocks::UpcomingReleases;
use counterpoint_event::event::{Event, FrameShift, Kind};
use counterpoint_event::info::Info;
use diagnostics::DiagnosticCounts;
use tooling::Tooling;
use trace::Tracer;
use travel::TravelTables;

const BUFFER: usize = 64 * 1024;

/// Writes the listing of one channel from the events of the whole log, in order.
///
/// # Errors
/// Those of `out`.
pub fn render(
    info: &Info,
    channel: u16,
    summary: &Summary,
    events: &mut dyn Iterator<Item = (u64, Event)>,
    out: &mut dyn Write,
) -> Result<()> {
    whole(info, (channel, false), summary, events, out)
}

/// Writes the log file of one channel: identification, diagnostics as they come, the summaries of the listing. Never a
/// block, never a line of the trace (reference listing-and-trace.md 9).
///
/// # Errors
/// Those of `out`.
pub fn render_log(
    info: &Info,
    channel: u16,
    summary: &Summary,
    events: &mut dyn Iterator<Item = (u64, Event)>,
    out: &mut dyn Write,
) -> Result<()> {
    whole(info, (channel, true), summary, events, out)
}

/// Writes the trace of one channel: blocks, the lines that the letters of the job ask for, and diagnostics in place.
///
/// # Errors
/// Those of `out`.
pub fn render_trace(
    info: &Info,
    channel: u16,
    events: &mut dyn Iterator<Item = (u64, Event)>,
    out: &mut dyn Write,
) -> Result<()> {
    let mut out = BufWriter::with_capacity(BUFFER, out);
    let mut tracer = Tracer::default();
    for (_, event) in events.filter(|(_, e)| e.channel == channel || e.channel == 0) {
        match &event.kind {
            Kind::Diagnostic(diagnostic) => diagnostics::write(info, &event, diagnostic, &mut out)?,
            _ if event.channel != channel && !of_master(&event) => {}
            Kind::Block(_) => tracer.block(info, &event, &mut out)?,
            _ => tracer.event(info, &event, &mut out)?,
        }
    }
    out.flush()
}

/// Output of the macros of the master kernel: in every listing, as its diagnostics are; no listing is switched off by
/// it.
fn of_master(event: &Event) -> bool {
    event.channel == 0
        && match event.kind {
            Kind::Trace(ref trace) => trace.listing.is_none(),
            Kind::Message(_) => true,
            _ => false,
        }
}

fn whole(
    info: &Info,
    (channel, log_only): (u16, bool),
    summary: &Summary,
    events: &mut dyn Iterator<Item = (u64, Event)>,
    out: &mut dyn Write,
) -> Result<()> {
    let mut out = BufWriter::with_capacity(BUFFER, out);
    let own = info.channel(channel);
    let ended = summary.channels.iter().find(|c| c.channel == channel);
    let end_ns = ended.map_or(0, |c| c.end_ns);
    let axes = own.map_or(&[][..], |c| &c.axes);
    let mut waits = UpcomingReleases::new(summary);
    let mut counts = DiagnosticCounts::default();
    let mut tracer = Tracer::default();
    let mut tooling = Tooling::new(end_ns);
    let mut travel = TravelTables::new(axes);
    header::write(info, &mut out)?;
    for (_, event) in events.filter(|(_, e)| e.channel == channel || e.channel == 0) {
        match &event.kind {
            Kind::Diagnostic(diagnostic) => {
                counts.add(diagnostic.severity);
                diagnostics::write(info, &event, diagnostic, &mut out)?;
            }
            _ if event.channel != channel || log_only && matches!(event.kind, Kind::Block(_) | Kind::Wait(_)) => {}
            Kind::Block(_) => tracer.block(info, &event, &mut out)?,
            Kind::Wait(wait) => waits.write(&event, wait, &mut out)?,
            Kind::Motion(motion) => {
                tooling.motion(&event, motion);
                travel.motion(motion);
            }
            Kind::Frame(FrameShift { shift }) => travel.frame(shift),
            _ => tooling.event(&event),
        }
        if !log_only && (event.channel == channel || of_master(&event)) {
            tracer.event(info, &event, &mut out)?;
        }
    }
    tooling.write(ended.map_or(&[][..], |c| &c.tools), &mut out)?;
    travel.write(&mut out)?;
    time::write(info, summary, channel, &mut out)?;
    counts.write(&mut out)?;
    out.flush()
}

/// Writes the merged listing: the blocks of all channels in order of simulated time, each with its kernel and time, and
/// the lines of their traces, then a time table for each channel.
///
/// # Errors
/// Those of `out`.
pub fn render_merged(
    info: &Info,
    summary: &Summary,
    events: &mut dyn Iterator<Item = (u64, Event)>,
    out: &mut dyn Write,
) -> Result<()> {
    let mut out = BufWriter::with_capacity(BUFFER, out);
    let mut waits = UpcomingReleases::new(summary);
    let mut counts = DiagnosticCounts::default();
    let mut tracers: FxHashMap<u16, Tracer> = FxHashMap::default();
    header::write(info, &mut out)?;
    for (_, event) in events {
        let tracer = tracers.entry(event.channel).or_default();
        match &event.kind {
            Kind::Diagnostic(diagnostic) => {
                counts.add(diagnostic.severity);
                diagnostics::write(info, &event, diagnostic, &mut out)?;
            }
            Kind::Block(_) => {
                if tracer.shows(info, &event) {
                    blocks::write_prefix(&event, &mut out)?;
                }
                tracer.block(info, &event, &mut out)?;
            }
            Kind::Wait(wait) => {
                blocks::write_prefix(&event, &mut out)?;
                waits.write(&event, wait, &mut out)?;
            }
            _ => {}
        }
        tracer.event(info, &event, &mut out)?;
    }
    for channel in &info.channels {
        write!(out, "\nKERNEL {} {}\n", channel.number, channel.name)?;
        time::write(info, summary, channel.number, &mut out)?;
    }
    counts.write(&mut out)?;
    out.flush()
}
