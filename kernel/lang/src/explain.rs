//! The effects of functions and statements, one line each.
//!
//! *Invariant:* every function and statement that control emulator macros can use has a row; a test compares the rows
//! with the tables of the parser and of the functions.

use std::sync::OnceLock;

/// A row of the tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExplainEntry {
    /// Name: `$FSIN`, `DECLAR`; `=` for the assignment.
    pub name: &'static str,
    /// How it is written.
    pub form: &'static str,
    /// Type of its result, none for a statement.
    pub result: Option<&'static str>,
    /// Its effect.
    pub about: &'static str,
}

fn rows(table: &'static str) -> impl Iterator<Item = Vec<&'static str>> {
    table.lines().filter(|line| !line.starts_with('#')).map(|line| line.split('\t').collect())
}

/// The functions.
pub fn functions() -> &'static [ExplainEntry] {
    static ROWS: OnceLock<Vec<ExplainEntry>> = OnceLock::new();
    ROWS.get_or_init(|| {
        let entry = |row: Vec<&'static str>| match row.as_slice() {
            [form, result, about] => {
                let name = form.split_once('(').map_or(*form, |(name, _)| name);
                Some(ExplainEntry { name, form, result: Some(result), about })
            }
            _ => None,
        };
        rows(include_str!("../data/functions.tsv")).filter_map(entry).collect()
    })
}

/// The statements.
pub fn statements() -> &'static [ExplainEntry] {
    static ROWS: OnceLock<Vec<ExplainEntry>> = OnceLock::new();
    ROWS.get_or_init(|| {
        let entry = |row: Vec<&'static str>| match row.as_slice() {
            [name, form, about] => Some(ExplainEntry { name, form, result: None, about }),
            _ => None,
        };
        rows(include_str!("../data/statements.tsv")).filter_map(entry).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::func::{EvaluationMethod, all};

    #[test]
    fn every_function_has_its_row() {
        let mut names: Vec<&str> = functions().iter().map(|entry| entry.name).collect();
        let wanted = all().filter(|function| !matches!(function.way, EvaluationMethod::Missing(_)));
        let mut wanted: Vec<&str> = wanted.map(|function| function.name).collect();
        names.sort_unstable();
        wanted.sort_unstable();
        assert_eq!(names, wanted);
    }

    #[test]
    fn forms_show_the_arguments_that_are_needed() {
        for entry in functions() {
            let function = crate::func::named(entry.name).unwrap();
            let first = entry.form.split(" or (").next().unwrap();
            let inside = first.split_once('(').unwrap().1;
            let needed = inside.split(['[', ')']).next().unwrap();
            let count = if needed.is_empty() { 0 } else { needed.trim_end_matches(',').split(',').count() };
            let free = function.arguments.contains('+') || first.contains('…') || inside.starts_with('[');
            assert!(
                free || count == function.least(),
                "{}: {} arguments in {}",
                entry.name,
                function.least(),
                entry.form
            );
        }
    }

    #[test]
    fn every_statement_has_its_row() {
        let names: Vec<&str> = statements().iter().map(|entry| entry.name).filter(|name| *name != "=").collect();
        assert_eq!(names, crate::parse::COMMANDS);
        assert!(statements().iter().chain(functions()).all(|entry| entry.about.ends_with('.')));
    }
}
