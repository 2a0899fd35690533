//! The console: messages and diagnostics, a line each.
//!
//! Form: reference listing-and-trace.md 5, last paragraph. No status line; unrecognised text is reported with its place
//! at the end and in the spelling of the console. Diagnostics raised by a macro end with the file and line of the
//! macro.

use std::io::{BufWriter, Result, Write};

use super::{BUFFER, diagnostics};
use counterpoint_event::event::{Diagnostic, Event, Kind, OperatorMessage, Unrecognised};
use counterpoint_event::info::Info;

/// Writes the console lines of one channel and the master, of all channels for 0.
///
/// # Errors
/// Those of `out`.
pub fn render_console(
    info: &Info,
    channel: u16,
    events: &mut dyn Iterator<Item = (u64, Event)>,
    out: &mut dyn Write,
) -> Result<()> {
    let mut out = BufWriter::with_capacity(BUFFER, out);
    for (_, event) in events.filter(|(_, event)| channel == 0 || [0, channel].contains(&event.channel)) {
        match &event.kind {
            Kind::Message(OperatorMessage { text, .. }) => writeln!(out, "Display : {text}")?,
            Kind::Diagnostic(diagnostic) => writeln!(out, "{}", line(info, &event, diagnostic))?,
            _ => {}
        }
    }
    out.flush()
}

fn line(info: &Info, event: &Event, diagnostic: &Diagnostic) -> String {
    let word = diagnostics::word(diagnostic.severity);
    if let Some(Unrecognised { text, place }) = diagnostic.unrecognised.as_deref() {
        return format!("{word}: '{text}' not recognized in {place} at line {}", event.user_place().line);
    }
    match diagnostics::origin(info, event, diagnostic) {
        Some(origin) => format!("{word}: {} ({}:{})", diagnostic.text, origin.file, origin.line),
        None => format!("{word}: {}", diagnostic.text),
    }
}
