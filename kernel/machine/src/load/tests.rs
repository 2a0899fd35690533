//! Tests of loading: the findings with their places, and the shipped machines.

mod chains;
mod contradictions;
mod diagnostics;
mod dialogs;
mod doubles;
mod guesses;
mod macros;
mod mistakes;
mod mistakes_in_rows;
mod nonsense;
mod questionnaire;
mod shipped;

use super::*;
use counterpoint_ports::files::MemoryFiles;

/// A small machine without family; cases are written before or after it.
pub(super) const BASE: &str = r#"
[ce]
name = "test"
[machine]
type = "lathe"
[[registers]]
name = "G"
whole = 3
frac = 1
[[registers]]
name = "M"
whole = 8
[[registers]]
name = "X"
second = "U"
whole = 5
frac = 3
[[registers]]
name = "P"
whole = 8
[[codes]]
id = "CODE_RAPID"
word = "G0"
[[codes]]
id = "CODE_SPINDLE_CLW"
word = "M3"
[[data]]
id = "REG_AXIS_X"
register = "X"
[[axes]]
name = "X1"
rapid = 1000
[[spindles]]
number = 1
max = 4000
[[channels]]
number = 1
axes = ["X1"]
"#;

pub(super) fn load_text(text: &str) -> Loaded {
    let mut files = MemoryFiles::default();
    files.insert("m/machine.toml", text);
    load(&files, "m")
}

/// Findings of [`BASE`] with text after it; lines count from the first line of that text.
pub(super) fn after(text: &str) -> Vec<String> {
    let skip = BASE.lines().count() as u32;
    shown(&load_text(&format!("{BASE}{text}")), skip)
}

/// Findings of [`BASE`] with text before it.
pub(super) fn before(text: &str) -> Vec<String> {
    shown(&load_text(&format!("{text}{BASE}")), 0)
}

fn shown(loaded: &Loaded, skip: u32) -> Vec<String> {
    let errors = loaded.findings.iter().any(|finding| finding.error);
    assert_eq!(loaded.machine.is_none(), errors, "a machine exactly when there is no error");
    loaded
        .findings
        .iter()
        .map(|finding| {
            let kind = if finding.error { "error" } else { "warning" };
            let line = i64::from(finding.line) - i64::from(skip);
            format!("{line}:{}: {kind}: {}", finding.column, finding.text)
        })
        .collect()
}

#[test]
fn the_base_is_correct() {
    assert_eq!(after(""), [""; 0]);
}
