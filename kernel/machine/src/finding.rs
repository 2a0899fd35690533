//! Findings of a check of a machine or a job.

use std::fmt;

/// One mistake, with the place and the expected content.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Finding {
    /// `true` = cannot be used; `false` = a warning.
    pub error: bool,
    /// File, relative to the machine folder or the job.
    pub file: String,
    /// Line from 1, 0 when it belongs to no line.
    pub line: u32,
    /// Column from 1, 0 when unknown.
    pub column: u32,
    /// The error and the expected input, one line, lower case, no full stop.
    pub text: String,
}

impl Finding {
    /// An error at a place.
    #[must_use]
    pub fn error(file: impl Into<String>, line: u32, column: u32, text: impl Into<String>) -> Self {
        Self { error: true, file: file.into(), line, column, text: text.into() }
    }

    /// A warning at a place.
    #[must_use]
    pub fn warning(file: impl Into<String>, line: u32, column: u32, text: impl Into<String>) -> Self {
        Self { error: false, file: file.into(), line, column, text: text.into() }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kind = if self.error { "error" } else { "warning" };
        match (self.line, self.column) {
            (0, _) => write!(f, "{}: {kind}: {}", self.file, self.text),
            (line, 0) => write!(f, "{}:{line}: {kind}: {}", self.file, self.text),
            (line, column) => write!(f, "{}:{line}:{column}: {kind}: {}", self.file, self.text),
        }
    }
}
