//! Findings of machine definitions on standard error.

use counterpoint_proto::v1;

use crate::say::{self, BAD, WARN, styled};

/// Prints findings: file, line, column, text.
pub(crate) fn print(findings: &[v1::Finding]) {
    for finding in findings {
        let word = if finding.error { styled(BAD, "error") } else { styled(WARN, "warning") };
        let place = match (finding.line, finding.column) {
            (0, _) => finding.file.clone(),
            (line, 0) => format!("{}:{line}", finding.file),
            (line, column) => format!("{}:{line}:{column}", finding.file),
        };
        say::status_line(format_args!("{place}: {word}: {}", finding.text));
    }
}

/// A finding as JSON; line and column are 0 where it has none.
pub(crate) fn as_json(finding: &v1::Finding) -> serde_json::Value {
    let severity = if finding.error { "error" } else { "warning" };
    serde_json::json!({
        "severity": severity, "file": finding.file, "line": finding.line, "column": finding.column,
        "text": finding.text,
    })
}
