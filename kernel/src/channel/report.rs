//! Diagnostics of a kernel.

use super::burden::{RESULT, shortened};
use super::{Halt, Kernel};
use crate::diag::{self, Facts};
use crate::log::event::{Diagnostic, Kind};

impl Kernel<'_> {
    /// Logs a diagnostic at the current block. Beyond the limit of a channel one closing notice follows, then
    /// nothing but alarms.
    pub(crate) fn diagnose(&mut self, facts: &Facts, text: impl Into<String>) {
        if self.has_room(facts.alarm) {
            self.log_diagnostic(facts, text.into());
        }
    }

    /// Counts a diagnostic; false if it is one too many.
    pub(crate) fn has_room(&mut self, alarm: bool) -> bool {
        let limit = self.options.limits.diagnostics;
        self.diagnostics = self.diagnostics.saturating_add(1);
        if self.diagnostics > limit && !alarm {
            if self.diagnostics == limit + 1 {
                let text =
                    format!("more than {limit} diagnostics in channel {}; further ones are not logged", self.rank);
                self.log_diagnostic(&diag::TOO_MANY_DIAGNOSTICS, text);
            }
            return false;
        }
        true
    }

    fn log_diagnostic(&mut self, facts: &Facts, text: String) {
        let Some((severity, text)) = self.customised(facts.number, (facts.severity, facts.alarm), text) else { return };
        if self.macros.is_some() {
            return self.issue((facts.number, severity), text, None);
        }
        let text = shortened(&text);
        self.burden.result(text.len() + RESULT);
        let diagnostic = Diagnostic { number: facts.number, severity, text: text.into(), ..Diagnostic::default() };
        self.emit(0, Kind::Diagnostic(Box::new(diagnostic)));
    }

    /// Logs an alarm of the control and returns what stops the channel.
    pub(crate) fn alarm(&mut self, facts: &Facts, text: impl Into<String>) -> Halt {
        self.diagnose(facts, text);
        Halt::Alarm
    }

    /// Text of the current block, for messages: at most 60 characters.
    pub(crate) fn block_text(&self) -> String {
        match self.macros.as_deref().and_then(|runtime| runtime.text.as_ref()) {
            Some(text) => crate::log::info::cut(text, 60),
            None => self.info.block_text(self.file, self.line, 60).into_owned(),
        }
    }
}
