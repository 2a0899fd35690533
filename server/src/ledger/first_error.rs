//! The first error of a job. The ledger keeps it, so that a status can name it without reading the log.
//!
//! *Invariant:* its size is bounded, regardless of the texts in programs and machines.

use counterpoint_kernel::log::summary::Summary;
use serde::{Deserialize, Serialize};

/// Lowest severity of an error.
const ERROR: u8 = 8;
/// Maximum bytes of the text and of the file name.
const TEXT: usize = 512;
const FILE: usize = 255;

/// An error of a job.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct FirstError {
    /// Number of the diagnostic; 0 = the job could not be run.
    pub number: u32,
    /// Text for people.
    pub text: String,
    /// File, empty = none.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub file: String,
    /// Line from 1, 0 = none.
    pub line: u32,
    /// Channel, 0 = none.
    pub channel: u16,
}

/// The beginning of a text; an ellipsis marks a truncated text.
fn cut(text: &str, most: usize) -> String {
    const MARK: &str = "…";
    if text.len() <= most {
        return text.to_owned();
    }
    let end = text.floor_char_boundary(most.saturating_sub(MARK.len()));
    format!("{}{MARK}", text.get(..end).unwrap_or_default())
}

impl FirstError {
    /// An error with bounded texts.
    pub(crate) fn new(number: u32, (text, file): (&str, &str), line: u32, channel: u16) -> Self {
        Self { number, text: cut(text, TEXT), file: cut(file, FILE), line, channel }
    }

    /// The first error of a run, in the order of the log.
    pub(crate) fn of(summary: &Summary) -> Option<Self> {
        let first = summary.diagnostics.iter().find(|diagnostic| diagnostic.severity >= ERROR)?;
        let texts = (first.text.as_str(), first.file.as_str());
        Some(Self::new(first.number, texts, first.line, first.channel))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_texts_are_cut_between_characters() {
        let error = FirstError::new(1, (&"ä".repeat(TEXT), &"x".repeat(FILE + 1)), 2, 3);
        assert!(error.text.len() <= TEXT && error.text.ends_with("ä…"), "{}", error.text);
        assert!(error.file.len() == FILE && error.file.ends_with("x…"), "{}", error.file);
        let whole = FirstError::new(1, ("text", "a.nc"), 2, 3);
        assert_eq!((whole.text.as_str(), whole.file.as_str()), ("text", "a.nc"));
    }
}
