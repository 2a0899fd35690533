//! A tree of values, each with its place.
//!
//! Invariant: entries of a table are in the order in which they were written.

use std::sync::Arc;

/// Where something is written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct DefinitionPlace {
    /// File, relative to the machines folder.
    pub(crate) file: Arc<str>,
    /// Line from 1.
    pub(crate) line: u32,
    /// Column from 1.
    pub(crate) column: u32,
}

/// A value and its place.
#[derive(Debug, Clone)]
pub(crate) struct Node {
    /// Where the value starts.
    pub(crate) place: DefinitionPlace,
    /// The value.
    pub(crate) value: TomlValue,
}

/// A TOML value.
#[derive(Debug, Clone)]
pub(crate) enum TomlValue {
    /// Text in quotes.
    Text(String),
    /// Whole number.
    Integer(i64),
    /// Number with a point or an exponent.
    Float(f64),
    /// `true` or `false`.
    Flag(bool),
    /// Date or time; no key of a machine file takes one.
    Date,
    /// List.
    Array(Vec<Node>),
    /// Table.
    Table(TomlTable),
}

impl TomlValue {
    /// Its description in messages.
    pub(crate) fn kind(&self) -> &'static str {
        match self {
            Self::Text(_) => "text",
            Self::Integer(_) => "a whole number",
            Self::Float(_) => "a number",
            Self::Flag(_) => "true or false",
            Self::Date => "a date",
            Self::Array(_) => "a list",
            Self::Table(_) => "a table",
        }
    }
}

/// A key with its value.
#[derive(Debug, Clone)]
pub(crate) struct TomlEntry {
    /// Key.
    pub(crate) key: String,
    /// Where the key is written.
    pub(crate) place: DefinitionPlace,
    /// Its value.
    pub(crate) node: Node,
}

/// A table.
#[derive(Debug, Clone, Default)]
pub(crate) struct TomlTable {
    /// Keys and values.
    pub(crate) entries: Vec<TomlEntry>,
}

impl TomlTable {
    /// Value of a key.
    pub(crate) fn get(&self, key: &str) -> Option<&Node> {
        self.entries.iter().find(|entry| entry.key == key).map(|entry| &entry.node)
    }

    /// Text of a key, if it is text.
    pub(crate) fn text(&self, key: &str) -> Option<&str> {
        match self.get(key).map(|node| &node.value) {
            Some(TomlValue::Text(text)) => Some(text),
            _ => None,
        }
    }

    /// Takes a key out.
    pub(crate) fn remove(&mut self, key: &str) {
        self.entries.retain(|entry| entry.key != key);
    }

    /// The table under a key, to change it.
    pub(crate) fn table_mut(&mut self, key: &str) -> Option<&mut TomlTable> {
        self.entries.iter_mut().find(|entry| entry.key == key).and_then(|entry| match &mut entry.node.value {
            TomlValue::Table(table) => Some(table),
            _ => None,
        })
    }
}
