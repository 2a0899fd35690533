//! Typed reading of one table: each key is read once with its type and range, `finish` reports the rest.
//!
//! Invariant: a getter that finds something wrong reports it and returns `None`, so that the caller continues with its
//! default and finds the next mistake.

use std::ops::RangeInclusive;

use super::check::FindingCollector;
use super::node::{DefinitionPlace, Node, TomlTable, TomlValue};
use super::suggest::did_you_mean;

/// A table that is being read.
#[derive(Debug)]
pub(crate) struct TableReader<'a> {
    table: &'a TomlTable,
    place: DefinitionPlace,
    title: &'static str,
    asked: Vec<&'static str>,
    check: &'a FindingCollector,
}

impl<'a> TableReader<'a> {
    /// Starts to read a table.
    pub(crate) fn new(
        table: &'a TomlTable,
        place: DefinitionPlace,
        title: &'static str,
        check: &'a FindingCollector,
    ) -> Self {
        Self { table, place, title, asked: Vec::new(), check }
    }

    /// Where the table starts.
    pub(crate) fn place(&self) -> &DefinitionPlace {
        &self.place
    }

    /// Where a key's value is written; the table's place when the key is absent.
    pub(crate) fn place_of(&self, key: &str) -> &DefinitionPlace {
        self.table.get(key).map_or(&self.place, |node| &node.place)
    }

    /// Value of a key, unchecked.
    pub(crate) fn node(&mut self, key: &'static str) -> Option<&'a Node> {
        self.asked.push(key);
        self.table.get(key)
    }

    /// Reports a missing key.
    pub(crate) fn require(&self, key: &str, expected: &str) {
        if self.table.get(key).is_none() {
            self.check.missing(&self.place, format!("{} needs `{key}`: {expected}", self.title));
        }
    }

    /// An error at a key.
    pub(crate) fn error(&self, key: &str, text: impl Into<String>) {
        self.check.error(self.place_of(key), text);
    }

    /// A warning at a key.
    pub(crate) fn warning(&self, key: &str, text: impl Into<String>) {
        self.check.warning(self.place_of(key), text);
    }

    /// An error at another place, for files that a key names.
    pub(crate) fn error_at(&self, place: &DefinitionPlace, text: impl Into<String>) {
        self.check.error(place, text);
    }

    /// Text.
    pub(crate) fn text(&mut self, key: &'static str) -> Option<&'a str> {
        let node = self.node(key)?;
        match &node.value {
            TomlValue::Text(text) => Some(text),
            other => self.wrong_type(key, node, "text in quotes", other),
        }
    }

    /// Text of 1 to `longest` characters.
    pub(crate) fn name(&mut self, key: &'static str, longest: usize) -> Option<&'a str> {
        let text = self.text(key)?;
        let length = text.chars().count();
        if length == 0 || length > longest || text.trim() != text || text.chars().any(char::is_control) {
            let expected = format!("1 to {longest} characters without blanks around them");
            self.error(key, format!("`{key}` must be {expected}, not \"{}\"", text.escape_debug()));
            return None;
        }
        Some(text)
    }

    /// At most one character; empty text is `Some(None)`.
    pub(crate) fn character(&mut self, key: &'static str) -> Option<Option<char>> {
        let text = self.text(key)?;
        let mut chars = text.chars();
        match (chars.next(), chars.next()) {
            (first, None) => Some(first),
            _ => {
                self.error(key, format!("`{key}` must be one character or empty, not \"{}\"", text.escape_debug()));
                None
            }
        }
    }

    /// One of some words.
    pub(crate) fn choice<T: Copy>(&mut self, key: &'static str, words: &[(&str, T)]) -> Option<T> {
        let text = self.text(key)?;
        if let Some((_, value)) = words.iter().find(|(word, _)| *word == text) {
            return Some(*value);
        }
        let near = did_you_mean(text, words.iter().map(|(word, _)| *word));
        let list: Vec<String> = words.iter().map(|(word, _)| format!("\"{word}\"")).collect();
        let text = text.escape_debug();
        self.error(key, format!("`{key}` must be one of {}, not \"{text}\"{near}", list.join(", ")));
        None
    }

    /// `true` or `false`.
    pub(crate) fn flag(&mut self, key: &'static str) -> Option<bool> {
        let node = self.node(key)?;
        match &node.value {
            TomlValue::Flag(flag) => Some(*flag),
            other => self.wrong_type(key, node, "true or false", other),
        }
    }

    /// Whole number in a range.
    pub(crate) fn integer(&mut self, key: &'static str, range: RangeInclusive<i64>) -> Option<i64> {
        let node = self.node(key)?;
        let expected = format!("a whole number from {} to {}", range.start(), range.end());
        match &node.value {
            TomlValue::Integer(number) if range.contains(number) => Some(*number),
            TomlValue::Integer(number) => {
                self.check.error(&node.place, format!("`{key}` must be {expected}, not {number}"));
                None
            }
            other => self.wrong_type(key, node, &expected, other),
        }
    }

    /// Finite number.
    pub(crate) fn number(&mut self, key: &'static str) -> Option<f64> {
        let node = self.node(key)?;
        number(node, key, self.check)
    }

    /// Finite number, zero or more.
    pub(crate) fn at_least_zero(&mut self, key: &'static str) -> Option<f64> {
        let value = self.number(key)?;
        if value < 0.0 {
            self.error(key, format!("`{key}` must be zero or more, not {value}"));
            return None;
        }
        Some(value)
    }

    /// Finite number above zero.
    pub(crate) fn above_zero(&mut self, key: &'static str) -> Option<f64> {
        let value = self.number(key)?;
        if value <= 0.0 {
            self.error(key, format!("`{key}` must be above zero, not {value}"));
            return None;
        }
        Some(value)
    }

    /// List of any values.
    pub(crate) fn list(&mut self, key: &'static str) -> Option<&'a [Node]> {
        let node = self.node(key)?;
        match &node.value {
            TomlValue::Array(items) => Some(items),
            other => self.wrong_type(key, node, "a list in [ ]", other),
        }
    }

    /// List of texts with their places.
    pub(crate) fn texts(&mut self, key: &'static str) -> Option<Vec<(&'a str, &'a DefinitionPlace)>> {
        let items = self.list(key)?;
        let mut texts = Vec::with_capacity(items.len());
        for item in items {
            match &item.value {
                TomlValue::Text(text) => texts.push((text.as_str(), &item.place)),
                other => {
                    let kind = other.kind();
                    self.check.error(&item.place, format!("`{key}` must be a list of texts, this one is {kind}"));
                }
            }
        }
        Some(texts)
    }

    /// List of `count` finite numbers.
    pub(crate) fn numbers(&mut self, key: &'static str, count: RangeInclusive<usize>) -> Option<Vec<f64>> {
        let items = self.list(key)?;
        if !count.contains(&items.len()) {
            let expected = if count.start() == count.end() {
                format!("{} numbers", count.start())
            } else {
                format!("{} to {} numbers", count.start(), count.end())
            };
            self.error(key, format!("`{key}` must be a list of {expected}, not of {}", items.len()));
            return None;
        }
        let check = self.check;
        let numbers: Vec<f64> = items.iter().filter_map(|item| number(item, key, check)).collect();
        (numbers.len() == items.len()).then_some(numbers)
    }

    /// Table under a key.
    pub(crate) fn table(&mut self, key: &'static str, title: &'static str) -> Option<TableReader<'a>> {
        let node = self.node(key)?;
        match &node.value {
            TomlValue::Table(table) => Some(TableReader::new(table, node.place.clone(), title, self.check)),
            other => self.wrong_type(key, node, "a table", other),
        }
    }

    /// Keys and values of a table whose keys are free (names or numbers).
    pub(crate) fn free_table(&mut self, key: &'static str) -> Option<&'a TomlTable> {
        let node = self.node(key)?;
        match &node.value {
            TomlValue::Table(table) => Some(table),
            other => self.wrong_type(key, node, "a table", other),
        }
    }

    /// Rows of an array of tables, at most `most`.
    pub(crate) fn rows(&mut self, key: &'static str, title: &'static str, most: usize) -> Vec<TableReader<'a>> {
        let Some(items) = self.list(key) else { return Vec::new() };
        if items.len() > most {
            self.error(key, format!("{title} has {} rows, at most {most} are allowed", items.len()));
        }
        let mut rows = Vec::with_capacity(items.len().min(most));
        for item in items.iter().take(most) {
            match &item.value {
                TomlValue::Table(table) => rows.push(TableReader::new(table, item.place.clone(), title, self.check)),
                other => self.check.error(&item.place, format!("{title} must be a table, this is {}", other.kind())),
            }
        }
        rows
    }

    /// Reports the keys that were not read.
    pub(crate) fn finish(self) {
        for entry in &self.table.entries {
            if !self.asked.contains(&entry.key.as_str()) {
                let near = did_you_mean(&entry.key, self.asked.iter().copied());
                let key = entry.key.escape_debug();
                self.check.error(&entry.place, format!("unknown key `{key}` in {}{near}", self.title));
            }
        }
    }

    fn wrong_type<T>(&self, key: &str, node: &Node, expected: &str, found: &TomlValue) -> Option<T> {
        self.check.error(&node.place, format!("`{key}` must be {expected}, not {}", found.kind()));
        None
    }
}

/// Finite number of a node.
pub(crate) fn number(node: &Node, key: &str, check: &FindingCollector) -> Option<f64> {
    match &node.value {
        TomlValue::Integer(number) => Some(*number as f64),
        TomlValue::Float(number) if number.is_finite() => Some(*number),
        TomlValue::Float(number) => {
            check.error(&node.place, format!("`{key}` must be a finite number, not {number}"));
            None
        }
        other => {
            check.error(&node.place, format!("`{key}` must be a number, not {}", other.kind()));
            None
        }
    }
}
