//! Console, diagnostics and trace.

use counterpoint_lang::diag::MacroDiagnostic;
use counterpoint_lang::host::{ConsoleHost, TraceStep};
use counterpoint_lang::state::MacroState;

use super::Standalone;
use crate::outside::OutputStream;

impl ConsoleHost for Standalone {
    fn read_console(&mut self) -> Option<String> {
        match &mut self.outside {
            Some(outside) => outside.console(),
            None => self.typed.pop_front(),
        }
    }

    fn write_console(&mut self, line: &str) {
        match &mut self.outside {
            Some(outside) => {
                outside.line(OutputStream::Console, line);
            }
            None => self.output.printed.push(line.to_owned()),
        }
    }

    fn report(&mut self, _: &mut MacroState, diagnostic: MacroDiagnostic) {
        let Some(diagnostic) = self.tables.changed(diagnostic).filter(|_| !self.output.closed) else { return };
        match &mut self.outside {
            Some(outside) => outside.report(&diagnostic),
            None => self.output.diagnostics.push(diagnostic),
        }
    }

    fn diagnostic(&self, number: u32) -> Option<(u8, String)> {
        self.tables.diagnostic(number)
    }

    fn trace(&mut self, step: TraceStep<'_>) {
        let line = step.to_string();
        match &mut self.outside {
            Some(_) if self.output.closed => {}
            Some(outside) => self.output.closed = !outside.line(OutputStream::Traced, &line),
            None => self.output.traced.push(line),
        }
    }
}
