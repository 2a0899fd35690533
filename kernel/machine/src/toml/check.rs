//! Collects findings while a machine file is read.
//!
//! Invariant: a line that is broken as TOML is reported as such only; consequences on the same line are not reported a
//! second time.

use std::cell::{Cell, RefCell};

use super::node::DefinitionPlace;
use crate::finding::Finding;

/// Most findings kept of one load.
const MAX_FINDINGS: usize = 1000;

/// The collector.
#[derive(Debug, Default)]
pub(crate) struct FindingCollector {
    findings: RefCell<Vec<Finding>>,
    broken: RefCell<Vec<DefinitionPlace>>,
    incomplete: Cell<bool>,
    dropped: Cell<usize>,
}

impl FindingCollector {
    /// An error.
    pub(crate) fn error(&self, place: &DefinitionPlace, text: impl Into<String>) {
        self.push(Finding::error(&*place.file, place.line, place.column, text));
    }

    /// A warning.
    pub(crate) fn warning(&self, place: &DefinitionPlace, text: impl Into<String>) {
        self.push(Finding::warning(&*place.file, place.line, place.column, text));
    }

    /// An error of TOML syntax.
    pub(crate) fn syntax(&self, place: &DefinitionPlace, text: String) {
        self.push(Finding::error(&*place.file, place.line, place.column, text));
        self.broken.borrow_mut().push(place.clone());
    }

    /// An error because something else is not there. Not reported while the definition is known to be incomplete (a
    /// family, or a machine whose family could not be read).
    pub(crate) fn missing(&self, place: &DefinitionPlace, text: impl Into<String>) {
        if !self.incomplete.get() {
            self.error(place, text);
        }
    }

    /// A warning because something else is not there, under the same condition.
    pub(crate) fn idle(&self, place: &DefinitionPlace, text: impl Into<String>) {
        if !self.incomplete.get() {
            self.warning(place, text);
        }
    }

    /// Whether there is an error so far.
    pub(crate) fn has_errors(&self) -> bool {
        self.findings.borrow().iter().any(|finding| finding.error)
    }

    /// Marks the text as not the whole definition.
    pub(crate) fn set_incomplete(&self) {
        self.incomplete.set(true);
    }

    /// All findings by file, line and column.
    pub(crate) fn into_findings(self) -> Vec<Finding> {
        let mut findings = self.findings.into_inner();
        findings.sort_by(|a, b| (&a.file, a.line, a.column, !a.error).cmp(&(&b.file, b.line, b.column, !b.error)));
        findings.dedup();
        if self.dropped.get() > 0 {
            let file = findings.last().map_or(String::new(), |last| last.file.clone());
            findings.push(Finding::error(file, 0, 0, format!("and {} more mistakes", self.dropped.get())));
        }
        findings
    }

    /// Hands over those findings that are wanted.
    pub(crate) fn pass_on(self, to: &FindingCollector, wanted: impl Fn(&Finding) -> bool) {
        self.into_findings().into_iter().filter(wanted).for_each(|finding| to.push(finding));
    }

    fn push(&self, finding: Finding) {
        let broken = self.broken.borrow();
        if finding.line > 0 && broken.iter().any(|at| *at.file == *finding.file && at.line == finding.line) {
            return;
        }
        let mut findings = self.findings.borrow_mut();
        if findings.len() < MAX_FINDINGS {
            findings.push(finding);
        } else {
            self.dropped.set(self.dropped.get() + 1);
        }
    }
}
