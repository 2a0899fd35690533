//! Expectations beside the line of a program that they are about: `G1 X20   ← warning no-feed`.
//!
//! *Invariant:* a text without its marks is the text that is run; no line of it is added, removed or changed otherwise.

use std::collections::BTreeMap;
use std::fmt::Write as _;

/// The mark between a line and its expectations. No control and no macro language uses it.
pub const ARROW: char = '←';

/// The text of a fence, and the expectations beside its lines.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Marked {
    /// The text without marks.
    pub text: String,
    /// Expectations by line, the first line is 1.
    pub marks: BTreeMap<u32, Vec<String>>,
}

impl Marked {
    /// Separates the lines of a fence from their marks. Spaces before a mark belong to it.
    #[must_use]
    pub fn split(body: &str) -> Self {
        let mut marked = Self::default();
        for (number, line) in (1..).zip(body.split_inclusive('\n')) {
            let Some((code, mark)) = line.split_once(ARROW) else {
                marked.text.push_str(line);
                continue;
            };
            marked.text.push_str(code.trim_end_matches(' '));
            marked.text.push('\n');
            let expected = mark.split(',').map(|one| one.trim().to_owned()).filter(|one| !one.is_empty());
            marked.marks.insert(number, expected.collect());
        }
        marked
    }

    /// The body of a fence with these marks, one below the other.
    #[must_use]
    pub fn join(&self) -> String {
        let width = |line: &str| line.chars().count();
        let marked = (1..).zip(self.text.lines()).filter(|(number, _)| self.marks.contains_key(number));
        let column = marked.map(|(_, line)| width(line)).max().unwrap_or(0) + 3;
        let mut body = String::new();
        for (number, line) in (1..).zip(self.text.lines()) {
            body.push_str(line);
            if let Some(marks) = self.marks.get(&number) {
                let _ = write!(body, "{}{ARROW} {}", " ".repeat(column - width(line)), marks.join(", "));
            }
            body.push('\n');
        }
        body
    }
}

/// Equal expectations in a row as one with their number: `error no-feed ×2`.
#[must_use]
pub fn counted(marks: &[String]) -> Vec<String> {
    let text = |run: &[String]| {
        let first = run.first()?;
        Some(if run.len() > 1 { format!("{first} ×{}", run.len()) } else { first.clone() })
    };
    marks.chunk_by(|one, next| one == next).filter_map(text).collect()
}

/// The word of a severity.
#[must_use]
pub fn severity_name(severity: u8) -> &'static str {
    match severity {
        0..=3 => "message",
        4..=7 => "warning",
        8..=15 => "error",
        16.. => "fatal",
    }
}

#[cfg(test)]
mod tests {
    use super::{Marked, counted};

    #[test]
    fn equal_marks_in_a_row_are_counted() {
        let marks = ["a", "a", "b", "a"].map(str::to_owned);
        assert_eq!(counted(&marks), ["a ×2", "b", "a"]);
    }

    #[test]
    fn marks_come_off_and_go_on_again() {
        let body = "O1\nG1 X20   ← warning no-feed, warning unused-word\nG0 X1    ← warning over-travel\n\nM30\n";
        let marked = Marked::split(body);
        assert_eq!(marked.text, "O1\nG1 X20\nG0 X1\n\nM30\n");
        assert_eq!(marked.marks.get(&2).map(Vec::len), Some(2));
        assert_eq!(marked.join(), body);
    }

    #[test]
    fn a_text_without_marks_stays_as_it_is() {
        let body = "%\n  G1 X20  \n; a comment ;~ <-\n";
        assert_eq!(Marked::split(body).text, body);
        assert_eq!(Marked::split("").text, "");
    }
}
