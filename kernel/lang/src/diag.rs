//! Diagnostics of the language: rendering with the source line and a caret.

pub use counterpoint_fault::language::{DiagnosticNumber, LanguageDiagnostic, TABLE};

use crate::source::{MacroSource, Span};
use std::fmt;

/// One diagnostic with its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MacroDiagnostic {
    /// Stable number.
    pub number: DiagnosticNumber,
    /// 0–3 message, 4–7 warning, 8–15 error, 16–99 fatal.
    pub severity: u8,
    /// The error, one sentence.
    pub message: String,
    /// A near miss or another way out.
    pub help: Option<String>,
    /// File.
    pub file: String,
    /// Line, 1-based.
    pub line: u32,
    /// Column, 1-based, in characters.
    pub column: u32,
    /// Characters to mark, at least one.
    pub width: u32,
    /// Text of the line.
    pub source_line: String,
    /// Macro, for run-time diagnostics.
    pub macro_name: Option<String>,
    /// It is a user function, for run-time diagnostics.
    pub in_function: bool,
    /// The statement as the trace shows it, for run-time diagnostics.
    pub statement: Option<String>,
}

impl MacroDiagnostic {
    /// A diagnostic of `span` in `source`.
    #[must_use]
    pub fn new(
        source: &MacroSource,
        span: Span,
        number: DiagnosticNumber,
        message: impl Into<String>,
    ) -> MacroDiagnostic {
        let (line, column) = source.place(span.start);
        let source_line = source.line_text(line).to_owned();
        let marked = source.slice(span).lines().next().map_or(0, |text| text.chars().count());
        MacroDiagnostic {
            number,
            severity: number.severity(),
            message: message.into(),
            help: None,
            file: source.name.clone(),
            line,
            column,
            width: u32::try_from(marked).unwrap_or(1).max(1),
            source_line,
            macro_name: None,
            in_function: false,
            statement: None,
        }
    }

    /// Adds a near miss or another way out.
    #[must_use]
    pub fn help(mut self, help: Option<String>) -> MacroDiagnostic {
        self.help = help;
        self
    }

    /// Tells whether the macro cannot be used.
    #[must_use]
    pub fn is_error(&self) -> bool {
        self.severity >= 8
    }

    /// Type word of the severity.
    #[must_use]
    pub fn word(&self) -> &'static str {
        word(self.severity)
    }
}

/// Type word of a severity: Message, Warning, Error, Fatal.
#[must_use]
pub fn word(severity: u8) -> &'static str {
    match severity {
        0..=3 => "Message",
        4..=7 => "Warning",
        8..=15 => "Error",
        _ => "Fatal",
    }
}

impl fmt::Display for MacroDiagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} {}: {}", self.word(), self.number, self.message)?;
        let name = self.macro_name.as_ref().map(|name| format!(" in {name}")).unwrap_or_default();
        writeln!(f, "  --> {}:{}:{}{name}", self.file, self.line, self.column)?;
        let shown: String = self.source_line.chars().map(|c| if c.is_control() { ' ' } else { c }).take(600).collect();
        writeln!(f, "{:>5} | {shown}", self.line)?;
        let room = shown.chars().count().max(1);
        let before = (self.column as usize - 1).min(room);
        let width = (self.width as usize).min(room.saturating_sub(before).max(1));
        writeln!(f, "      | {}{}", " ".repeat(before), "^".repeat(width))?;
        if let Some(help) = &self.help {
            writeln!(f, "      = {help}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rendered_with_a_caret() {
        let source = MacroSource::new("park.mac", "A=1\nB=$XX+1");
        let diagnostic =
            MacroDiagnostic::new(&source, Span { start: 6, end: 9 }, DiagnosticNumber::UNKNOWN_VARIABLE, "no $XX")
                .help(Some("did you mean $XM?".into()));
        assert_eq!(
            diagnostic.to_string(),
            "Error 02910020: no $XX\n  --> park.mac:2:3\n    2 | B=$XX+1\n      |   ^^^\n      = did you mean $XM?\n"
        );
    }
}
