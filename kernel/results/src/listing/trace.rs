//! Blocks and the lines of a trace, in order.
//!
//! Layout: reference listing-and-trace.md 3 and 4. *Invariant:* blocks of files stored with the machine are shown only
//! with the letter Z; without it only their actions are shown.

use std::io::{Result, Write};

use super::actions::ActionFormatter;
use super::blocks;
use counterpoint_event::event::{Dwell, Event, Kind, Listing, OperatorMessage, Trace};
use counterpoint_event::info::Info;

/// Writes blocks and the data that the letters request.
#[derive(Debug, Default)]
pub(super) struct Tracer {
    actions: ActionFormatter,
    /// A macro has switched the listing off: no blocks and no lines of the trace; diagnostics and summaries stay.
    off: bool,
    /// A line of the trace took the place of the action of the next event.
    instead: bool,
    /// Text of the next block, if it is not the line of a file.
    own: Option<Box<str>>,
}

impl Tracer {
    /// Whether the line of a block is shown.
    pub(super) fn shows(&self, info: &Info, event: &Event) -> bool {
        !self.off && (info.trace.has('Z') || !info.is_stored(event.file))
    }

    /// The line of a block.
    pub(super) fn block(&mut self, info: &Info, event: &Event, out: &mut dyn Write) -> Result<()> {
        let own = self.own.take();
        if !self.shows(info, event) {
            return Ok(());
        }
        match own {
            Some(text) if info.trace.has('I') => writeln!(out, "Block :   {text}"),
            Some(text) => writeln!(out, "exec! {text}"),
            None if info.trace.has('I') => writeln!(out, "Block :   {}", info.line_text(event.file, event.line)),
            None => blocks::write_block(info, event, out),
        }
    }

    /// LPRINT, and the text of a block to come.
    fn control(&mut self, listing: &Listing, out: &mut dyn Write) -> Result<()> {
        match listing {
            Listing::On => self.off = false,
            Listing::Off => self.off = true,
            Listing::Block(text) => self.own = Some(text.clone()),
            Listing::Lines(_) if self.off => {}
            Listing::Lines(lines) => (0..*lines).try_for_each(|_| writeln!(out))?,
        }
        Ok(())
    }

    /// The lines of an event that the letters ask for.
    pub(super) fn event(&mut self, info: &Info, event: &Event, out: &mut dyn Write) -> Result<()> {
        match &event.kind {
            Kind::Trace(Trace { listing: Some(listing), .. }) => return self.control(listing, out),
            _ if self.off => return Ok(()),
            Kind::Message(OperatorMessage { text, printed: true }) => return writeln!(out, "{text}"),
            _ if info.trace.is_empty() => return Ok(()),
            _ => {}
        }
        match &event.kind {
            Kind::Dwell(Dwell) if std::mem::take(&mut self.instead) => Ok(()),
            Kind::Trace(trace) => {
                self.instead = trace.instead;
                writeln!(out, "{}", trace.text)
            }
            Kind::Message(OperatorMessage { text, .. }) if info.trace.has('S') => writeln!(out, "Display : {text}"),
            _ if info.trace.has('A') => {
                let axes = info.channel(event.channel).map_or(&[][..], |c| &c.axes);
                self.actions.of(axes, event).iter().try_for_each(|action| writeln!(out, "      | {action}"))
            }
            _ => Ok(()),
        }
    }
}
