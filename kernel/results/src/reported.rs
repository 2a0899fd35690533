//! Diagnostics and verdicts: the few events that results need in the order of the whole log, also those of the master
//! in the stream of a channel.
//!
//! *Invariant:* kept whole; everything else is read off each channel alone ([`super::channel_results`]).

use counterpoint_event::event::{Diagnostic, Event, FileId, Kind, SourcePlace, Verdict};

/// One such event.
#[derive(Debug)]
pub struct Reported {
    pub t_ns: i64,
    pub micro: u32,
    pub channel: u16,
    pub file: FileId,
    pub line: u32,
    pub caller: SourcePlace,
    pub what: ReportedContent,
}

/// Its content.
#[derive(Debug)]
pub enum ReportedContent {
    Diagnostic(Box<Diagnostic>),
    Verdict(Box<Verdict>),
}

impl Reported {
    /// `None` for all other events.
    pub fn of(event: &Event) -> Option<Self> {
        let what = match &event.kind {
            Kind::Diagnostic(diagnostic) => ReportedContent::Diagnostic(diagnostic.clone()),
            Kind::Verdict(verdict) => ReportedContent::Verdict(verdict.clone()),
            _ => return None,
        };
        let Event { t_ns, micro, channel, file, line, caller, .. } = *event;
        Some(Self { t_ns, micro, channel, file, line, caller, what })
    }

    /// The innermost place in the programs of the user.
    pub fn user_place(&self) -> SourcePlace {
        self.caller.or(SourcePlace::new(self.file, self.line))
    }

    /// The event it was.
    pub fn event(&self) -> Event {
        let Self { t_ns, micro, channel, file, line, caller, .. } = *self;
        let kind = match &self.what {
            ReportedContent::Diagnostic(diagnostic) => Kind::Diagnostic(diagnostic.clone()),
            ReportedContent::Verdict(verdict) => Kind::Verdict(verdict.clone()),
        };
        Event { t_ns, micro, dur_ns: 0, channel, file, line, caller, kind }
    }
}
