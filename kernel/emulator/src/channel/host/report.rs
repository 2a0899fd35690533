//! Messages, diagnostics and printed lines of the interpreter.

use std::sync::Arc;

use counterpoint_fault::{Acted, DiagnosticFacts, Halt};

use crate::channel::Kernel;
use counterpoint_channel::shared_target::SharedTarget;
use counterpoint_control_api::{ReportHost, Unknown};
use counterpoint_event::event::{Kind, OperatorMessage};
use counterpoint_fault as diag;
use counterpoint_machine::model::PrintFileFormat;
use counterpoint_sync::races::AccessMode;

impl ReportHost for Kernel<'_> {
    fn show(&mut self, text: &str) {
        self.display(text);
    }

    fn log_message(&mut self, text: &str) {
        self.channel.emit(0, Kind::Message(OperatorMessage { text: text.into(), printed: false }));
    }

    fn handles_messages(&self, text: &[u8]) -> bool {
        self.plan.hooks.is_some()
            && self.channel.tables.scanner.remarks(text).iter().any(|(is_message, ..)| *is_message)
    }

    fn report_unrecognised(&mut self, word: &str) -> Acted {
        let place = format!("'{}'", self.channel.block_text());
        if self.channel.env.machine.habits.unknown_alarms {
            let why = self.dialect.kind.unknown_text(word, Unknown::Word);
            return Err(Kernel::alarm(
                self,
                &diag::UNKNOWN_TEXT,
                format!("{why} in {place}; no part of the block acts"),
            ));
        }
        Kernel::report_unrecognised(self, word, place);
        Ok(())
    }

    fn diagnose(&mut self, facts: &'static DiagnosticFacts, text: String) {
        let unknown = facts.number == diag::NOT_RECOGNISED.number && self.channel.env.machine.habits.unknown_alarms;
        Kernel::diagnose(self, if unknown { &diag::UNKNOWN_TEXT } else { facts }, text);
    }

    fn report(&mut self, facts: &'static DiagnosticFacts, severity: u8, text: String) {
        Kernel::diagnose(self, &DiagnosticFacts { severity, ..*facts }, text);
    }

    fn alarm(&mut self, facts: &'static DiagnosticFacts, text: String) -> Halt {
        Kernel::alarm(self, facts, text)
    }

    fn continues_after(&self, facts: &'static DiagnosticFacts) -> bool {
        !self.channel.env.machine.stops_at(facts)
    }

    fn output(&self) -> &PrintFileFormat {
        &self.channel.env.machine.output
    }

    fn open_output(&mut self, open: bool) {
        self.flow.printing.open = open;
    }

    /// All channels write one file, in the order of simulated time; how much is written is bounded (reference
    /// fanuc-variables-and-alarms.md 2.5).
    fn print(&mut self, line: &str) -> Acted {
        let output = &self.channel.env.machine.output;
        if output.opened
            && !self.flow.printing.open
            && !std::mem::replace(&mut self.flow.printing.closed_reported, true)
        {
            let text = format!("'{}' prints without POPEN before it; its output is kept", self.channel.block_text());
            self.diagnose(&diag::PRINT_CLOSED, text);
        }
        self.flow.pass.effects = true;
        if let Err(text) =
            self.access(SharedTarget::File, AccessMode::Write, |shared| shared.files.print(&output.file, line))?
        {
            self.diagnose(&diag::MACRO_FILES, text);
        }
        Ok(())
    }

    fn append(&mut self, path: &str, text: &str) -> Result<bool, Halt> {
        self.flow.pass.effects = true;
        let done = self.access(SharedTarget::File, AccessMode::Write, |shared| shared.files.print(path, text))?;
        if let Err(text) = &done {
            self.diagnose(&diag::MACRO_FILES, text.clone());
        }
        Ok(done.is_ok())
    }

    fn has_written(&mut self, path: &str) -> Result<Option<bool>, Halt> {
        self.access(SharedTarget::File, AccessMode::Read, |shared| shared.files.has(path))
    }

    fn written(&mut self, path: &str) -> Result<Option<Arc<str>>, Halt> {
        self.access(SharedTarget::File, AccessMode::Read, |shared| shared.files.get(path).flatten())
    }

    fn remove_written(&mut self, path: &str) -> Acted {
        self.flow.pass.effects = true;
        self.access(SharedTarget::File, AccessMode::Write, |shared| shared.files.remove(path))
    }
}
