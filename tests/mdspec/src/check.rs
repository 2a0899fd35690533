//! Comparing an example with its output.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use similar::TextDiff;

use crate::marks::Marked;
use crate::page::{Example, Fence};
use crate::update::Edit;

/// The differences in an example, and the edits that would correct its page.
#[derive(Debug)]
pub struct Check<'a> {
    page: &'a str,
    example: &'a Example,
    /// Bytes where a fence that is missing is put in.
    end: usize,
    wrong: String,
    edits: Vec<Edit>,
    /// Nothing that can be written into the page would make it true.
    hopeless: bool,
}

impl<'a> Check<'a> {
    /// A check of an example of the page with this name.
    #[must_use]
    pub fn new(page: &'a str, example: &'a Example) -> Self {
        let end = example.fences.last().map_or(0, |fence| fence.whole.end);
        Self { page, example, end, wrong: String::new(), edits: Vec::new(), hopeless: false }
    }

    /// The outcome of this fence.
    pub fn outcome(&mut self, fence: &Fence, found: &str) {
        let name = format!("{} {}", fence.kind, fence.words);
        self.differ(
            fence.line,
            name.trim(),
            &fence.body.text,
            found,
            Edit { range: fence.range.clone(), text: found.to_owned() },
        );
    }

    /// The outcome of the fences of this kind, only compared where there are some.
    pub fn given(&mut self, kind: &str, found: impl FnOnce() -> String) {
        if let Some(fence) = self.example.fence(kind) {
            self.outcome(fence, &found());
        }
    }

    /// The outcome of a kind of fence: without such a fence, nothing may.
    pub fn required(&mut self, kind: &str, found: &str) {
        match self.example.fence(kind) {
            Some(fence) if found.is_empty() && !fence.body.text.is_empty() => {
                let range = fence.whole.start.saturating_sub(1)..fence.whole.end;
                self.differ(fence.line, kind, &fence.body.text, found, Edit { range, text: String::new() });
            }
            Some(fence) => self.outcome(fence, found),
            None => {
                let text = format!("\n```{kind}\n{found}```\n");
                self.differ(self.example.line, kind, "", found, Edit { range: self.end..self.end, text });
            }
        }
    }

    /// Expectations beside the lines of a fence.
    pub fn marks(&mut self, fence: &Fence, found: BTreeMap<u32, Vec<String>>) {
        if found == fence.body.marks {
            return;
        }
        let found = Marked { text: fence.body.text.clone(), marks: found }.join();
        let name = format!("{} {}", fence.kind, fence.words);
        let edit = Edit { range: fence.range.clone(), text: found.clone() };
        self.differ(fence.line, name.trim(), &fence.body.join(), &found, edit);
    }

    /// Differences that no other expectation would fix.
    pub fn wrong(&mut self, line: usize, text: &str) {
        let _ = writeln!(self.wrong, "{}:{line}: {text}", self.page);
        self.hopeless = true;
    }

    fn differ(&mut self, line: usize, what: &str, expected: &str, found: &str, edit: Edit) {
        if expected == found {
            return;
        }
        let diff = TextDiff::from_lines(expected, found);
        let diff = diff.unified_diff().context_radius(2).missing_newline_hint(false).to_string();
        let lines: Vec<&str> = diff.lines().filter(|line| !line.starts_with("@@")).collect();
        let _ =
            writeln!(self.wrong, "{}:{line}: {what} differs (- expected, + found)\n{}", self.page, lines.join("\n"));
        self.edits.push(edit);
    }

    /// The differences, empty when there are none, and the edits that would fix them (none if edits would not help).
    #[must_use]
    pub fn finish(self) -> (String, Vec<Edit>) {
        (self.wrong, if self.hopeless { Vec::new() } else { self.edits })
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::path::Path;

    use super::Check;
    use crate::page::{Fences, Page, Role};
    use crate::update::rewritten;

    const FENCES: Fences = &[
        ("nc", Role::Program),
        ("events", Role::Outcome),
        ("diagnostics", Role::Outcome),
        ("findings", Role::Outcome),
    ];

    /// The differences, and the page after the update.
    fn checked(text: &str, check: impl FnOnce(&mut Check<'_>, &crate::Example)) -> (String, String) {
        let page = Page::parse(Path::new("page.md"), text, FENCES).unwrap();
        let example = &page.examples[0];
        let mut found = Check::new("page.md", example);
        check(&mut found, example);
        let (wrong, edits) = found.finish();
        (wrong, rewritten(text, &edits))
    }

    #[test]
    fn an_update_makes_the_page_true() {
        let text = "# Page\n\nProse  \nstays.\n\n```nc\nG1 X1\nM30   \u{2190} error no-feed\n```\n\n```findings\nold\n```\n\n\
            ```events\nrapid\nstop\n```\n\nProse.\n";
        let run = |check: &mut Check<'_>, example: &crate::Example| {
            check.marks(example.fence("nc").unwrap(), BTreeMap::from([(1, vec!["error no-feed".to_owned()])]));
            check.given("events", || "linear\nstop\n".to_owned());
            check.required("findings", "");
            check.required("diagnostics", "fatal deadlock\n");
        };
        let (wrong, updated) = checked(text, run);
        assert!(
            wrong.contains("page.md:15: events differs (- expected, + found)\n-rapid\n+linear\n stop\n"),
            "{wrong}"
        );
        let expected = "# Page\n\nProse  \nstays.\n\n```nc\nG1 X1   \u{2190} error no-feed\nM30\n```\n\n\
            ```events\nlinear\nstop\n```\n\n```diagnostics\nfatal deadlock\n```\n\nProse.\n";
        assert_eq!(updated, expected);
        assert_eq!(checked(&updated, run), (String::new(), updated.clone()));
    }

    #[test]
    fn what_cannot_be_mended_changes_nothing() {
        let text = "```nc\nG1\n```\n\n```events\nrapid\n```\n";
        let (wrong, updated) = checked(text, |check, _| {
            check.given("events", || "linear\n".to_owned());
            check.wrong(1, "the log depends on scheduling");
        });
        assert!(wrong.contains("page.md:1: the log depends on scheduling\n"), "{wrong}");
        assert_eq!(updated, text);
    }
}
