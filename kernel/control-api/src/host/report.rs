//! Output for people: messages, diagnostics, alarms, and the output of programs.

use std::sync::Arc;

use counterpoint_fault::{Acted, DiagnosticFacts, Halt};

use counterpoint_machine::model::PrintFileFormat;

/// Ways to the log.
pub trait ReportHost {
    /// Displays a message to the operator.
    fn show(&mut self, text: &str);

    /// Logs a message without the code of a display.
    fn log_message(&mut self, text: &str);

    /// Whether the kernel itself handles the messages of this text.
    fn handles_messages(&self, text: &[u8]) -> bool;

    /// Reports a diagnostic of the block.
    fn diagnose(&mut self, facts: &'static DiagnosticFacts, text: String);

    /// Reports a word of the block that nothing recognises.
    ///
    /// # Errors
    /// The machine has an alarm for that: no part of the block acts.
    fn report_unrecognised(&mut self, word: &str) -> Acted;

    /// Reports a diagnostic with a severity of its own.
    fn report(&mut self, facts: &'static DiagnosticFacts, severity: u8, text: String);

    /// Reports an alarm; returns its effect: the channel stops, or the rest of the block is dropped.
    fn alarm(&mut self, facts: &'static DiagnosticFacts, text: String) -> Halt;

    /// Whether the machine continues after this alarm.
    fn continues_after(&self, facts: &'static DiagnosticFacts) -> bool;

    /// The form in which the control writes the output of programs.
    fn output(&self) -> &PrintFileFormat;

    /// The program opens or closes its output.
    fn open_output(&mut self, open: bool);

    /// Prints a line, with its end.
    ///
    /// # Errors
    /// The job was stopped.
    fn print(&mut self, line: &str) -> Acted;

    /// Adds to a file of the job; false if that is full.
    ///
    /// # Errors
    /// The job was stopped.
    fn append(&mut self, path: &str, text: &str) -> Result<bool, Halt>;

    /// Whether programs of the job have written such a file; false if it was removed.
    ///
    /// # Errors
    /// The job was stopped.
    fn has_written(&mut self, path: &str) -> Result<Option<bool>, Halt>;

    /// Its text.
    ///
    /// # Errors
    /// The job was stopped.
    fn written(&mut self, path: &str) -> Result<Option<Arc<str>>, Halt>;

    /// Removes such a file.
    ///
    /// # Errors
    /// The job was stopped.
    fn remove_written(&mut self, path: &str) -> Acted;
}
