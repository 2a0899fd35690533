//! Rows about a word on the pages of the controls.
//!
//! *Invariant:* only whole words are found: G76 is not G76.1, and SETMS is not SETMSX.

use counterpoint_kernel::files::JobFiles as _;
use counterpoint_kernel::machine::Machine;
use include_dir::{Dir, include_dir};
use serde_json::{Value, json};

use crate::local_machine::LocalMachine;

static COVERAGE: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/../docs/coverage");

const PREPROCESSORS: &str = include_str!("../../../docs/preprocessors.md");

/// Maximum number of rows of a page.
const MOST: usize = 4;

/// Maximum number of characters of a row.
const LONGEST: usize = 400;

/// Rows of the pages of the machine's control that name the word.
pub(super) fn rows(machine: &Machine, local: &LocalMachine, chain: &[String], word: &str) -> Vec<Value> {
    let mut found = Vec::new();
    let section = section(machine.preprocessor.row().name);
    add(&mut found, "docs/preprocessors.md", section, word);
    let mut controls: Vec<&str> = chain.iter().filter_map(|name| name.split('-').next()).collect();
    controls.dedup();
    for control in controls {
        let page = format!("{control}.md");
        if let Some(text) = COVERAGE.get_file(&page).and_then(|file| file.contents_utf8()) {
            add(&mut found, &format!("docs/coverage/{page}"), text, word);
        }
    }
    for folder in chain {
        let text = local.files.read(&format!("{folder}/README.md")).unwrap_or_default();
        add(&mut found, &format!("machines/{folder}/README.md"), &String::from_utf8_lossy(&text), word);
    }
    found
}

/// The part of the page about a pre-processor.
fn section(preprocessor: &str) -> &'static str {
    let part = |part: &&str| part.lines().next().is_some_and(|title| title.eq_ignore_ascii_case(preprocessor));
    PREPROCESSORS.split("\n## ").find(part).unwrap_or_default()
}

fn add(found: &mut Vec<Value>, page: &str, text: &str, word: &str) {
    let rows = rows_of(text).into_iter().filter(|row| names(row, word));
    found.extend(rows.take(MOST).map(|row| json!({ "page": page, "text": plain(&row) })));
}

/// Rows of tables, and list items with their continuation lines.
fn rows_of(text: &str) -> Vec<String> {
    let mut rows: Vec<String> = Vec::new();
    let mut inside = false;
    for line in text.lines() {
        if line.starts_with('|') || line.starts_with("* ") {
            inside = line.starts_with("* ");
            rows.push(line.to_owned());
        } else if inside && line.starts_with("  ") {
            if let Some(row) = rows.last_mut() {
                row.push(' ');
                row.push_str(line.trim());
            }
        } else {
            inside = false;
        }
    }
    rows
}

/// Whether the line has the word as a whole word.
fn names(line: &str, word: &str) -> bool {
    let part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    line.match_indices(word).any(|(at, _)| {
        let before = line.get(..at).and_then(|text| text.chars().next_back());
        let mut after = line.get(at + word.len()..).unwrap_or_default().chars();
        let (next, second) = (after.next(), after.next());
        let decimal = next == Some('.') && second.is_some_and(|c| c.is_ascii_digit());
        !before.is_some_and(|c| part(c) || matches!(c, '$' | '.')) && !next.is_some_and(part) && !decimal
    })
}

/// A row of a table as a sentence.
fn plain(line: &str) -> String {
    let cells = line.trim_start_matches("* ").trim().trim_matches('|').split('|').map(str::trim);
    let text = cells.filter(|cell| !cell.is_empty()).collect::<Vec<_>>().join(": ").replace('`', "");
    let text = crate::macros::without_links(&text);
    let Some((end, _)) = text.char_indices().nth(LONGEST) else { return text };
    // Cut at the end of a sentence or of a part of it, otherwise of a word.
    let start = text.get(..end).unwrap_or_default();
    let end = [". ", "; ", " "].iter().find_map(|end| start.rfind(end).filter(|at| *at > LONGEST / 2));
    format!("{} …", start.get(..end.unwrap_or(start.len())).unwrap_or_default().trim_end_matches([';', '.']))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_whole_words_count() {
        for (line, word, is) in [
            ("| `G76`, G77 | works |", "G76", true),
            ("| G76.1 | works |", "G76", false),
            ("| G760 | works |", "G76", false),
            ("| $P_SETMS | works |", "SETMS", false),
            ("| `SETMS(1)` | works |", "SETMS", true),
            ("| see G76. | works |", "G76", true),
        ] {
            assert_eq!(names(line, word), is, "{line}");
        }
        assert_eq!(plain("| `SETMS`, `SETMS(n)` | [of](a.md) a spindle |"), "SETMS, SETMS(n): of a spindle");
        let items = rows_of("* one is\n  long\n* two\n\n  other\n| a | b |\n  c\n");
        assert_eq!(items, ["* one is long", "* two", "| a | b |"]);
        let long = format!("* {}. {}", "a word ".repeat(45).trim(), "another ".repeat(20));
        assert!(plain(&long).ends_with("a word …"), "{}", plain(&long));
        assert!(section("siemens").contains("SETMS") && section("none").is_empty());
    }
}
