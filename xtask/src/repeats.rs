//! Lines that occur in several files of the machine definitions.

use std::collections::{BTreeMap, BTreeSet};

/// Number of equal lines that make a repeat.
pub(crate) const RUN: usize = 10;

/// Lines with content; empty lines and comment lines are left out.
fn content(text: &str) -> Vec<&str> {
    let lines = text.lines().map(str::trim);
    lines.filter(|line| !line.is_empty() && !line.starts_with(['#', ';']) && !line.starts_with("//")).collect()
}

/// By file, its lines in a run of [`RUN`] lines that also occurs in another file, or twice in this file.
pub(crate) fn repeated(files: &BTreeMap<String, String>) -> BTreeMap<String, usize> {
    let files: BTreeMap<&str, Vec<&str>> = files.iter().map(|(name, text)| (name.as_str(), content(text))).collect();
    let mut runs: BTreeMap<&[&str], usize> = BTreeMap::new();
    for lines in files.values() {
        lines.windows(RUN).for_each(|run| *runs.entry(run).or_default() += 1);
    }
    let mut found = BTreeMap::new();
    for (name, lines) in &files {
        let starts = lines.windows(RUN).enumerate().filter(|(_, run)| runs.get(run).is_some_and(|count| *count > 1));
        let repeated: BTreeSet<usize> = starts.flat_map(|(start, _)| start..start + RUN).collect();
        if !repeated.is_empty() {
            found.insert((*name).to_owned(), repeated.len());
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ten_equal_lines_are_a_repeat() {
        let lines =
            |from: usize, to: usize| (from..to).map(|n| format!("  G1 X{n}\n\n; note {n}\n")).collect::<String>();
        let files = [("a.h", lines(0, 30)), ("b.h", format!("G0\n{}M30\n", lines(5, 17))), ("c.h", lines(40, 49))];
        let files = files.map(|(name, text)| (name.to_owned(), text)).into();
        assert_eq!(repeated(&files), BTreeMap::from([("a.h".to_owned(), 12), ("b.h".to_owned(), 12)]));
    }
}
