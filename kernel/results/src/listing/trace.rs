//! Blocks and the lines of a trace, in order.
//!
//! Layout: reference listing-and-trace.md 3 and 4. Invariant: blocks of files stored with the machine are shown only
//! with the letter Z; without it their actions stand alone.

use std::io::{Result, Write};

use super::actions::Actions;
use super::blocks;
use counterpoint_event::event::trace::{ACTION, BLOCK, DWELL, LISTING};
use counterpoint_event::event::{Dwell, Event, Kind, Message, Trace};
use counterpoint_event::info::Info;
use counterpoint_event::info::STORED;

/// Writes blocks and what the letters ask for.
#[derive(Debug, Default)]
pub(super) struct Tracer {
    actions: Actions,
    /// A macro has switched the listing off: no blocks and no lines of the trace; diagnostics and summaries stay.
    off: bool,
    /// What the next dwell does has been told in other words than its seconds.
    told: bool,
    /// Text of the next block, if it is not the line of a file.
    own: Option<Box<str>>,
}

impl Tracer {
    /// The line of a block is shown.
    pub(super) fn shows(&self, info: &Info, event: &Event) -> bool {
        !self.off && (info.trace.has('Z') || !info.file_name(event.file).starts_with(STORED))
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
    fn control(&mut self, text: &str, out: &mut dyn Write) -> Result<()> {
        if let Some(block) = text.strip_prefix(BLOCK) {
            self.own = Some(block.into());
            return Ok(());
        }
        match text {
            "on" => self.off = false,
            "off" => self.off = true,
            _ if self.off => {}
            lines => (0..lines.parse().unwrap_or(0)).try_for_each(|_: u32| writeln!(out))?,
        }
        Ok(())
    }

    /// The lines of an event that the letters ask for.
    pub(super) fn event(&mut self, info: &Info, event: &Event, out: &mut dyn Write) -> Result<()> {
        match &event.kind {
            Kind::Trace(Trace { letter: LISTING, text }) => return self.control(text, out),
            _ if self.off => return Ok(()),
            Kind::Message(Message { text, printed: true }) => return writeln!(out, "{text}"),
            _ if info.trace.is_empty() => return Ok(()),
            _ => {}
        }
        match &event.kind {
            Kind::Dwell(Dwell) if std::mem::take(&mut self.told) => Ok(()),
            Kind::Trace(Trace { letter, text }) => {
                self.told = *letter == ACTION && text.contains(DWELL);
                writeln!(out, "{text}")
            }
            Kind::Message(Message { text, .. }) if info.trace.has('S') => writeln!(out, "Display : {text}"),
            _ if info.trace.has('A') => {
                let axes = info.channel(event.channel).map_or(&[][..], |c| &c.axes);
                self.actions.of(axes, event).iter().try_for_each(|action| writeln!(out, "      | {action}"))
            }
            _ => Ok(()),
        }
    }
}
