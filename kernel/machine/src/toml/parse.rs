//! Text of a machine file to a tree with places; mistakes of syntax become findings and the rest is kept.
//!
//! Invariant: for any bytes, the result is a tree (possibly empty) and findings.

use std::ops::Range;
use std::sync::Arc;

use ::toml::Spanned;
use ::toml::de::{DeTable, DeValue};

use super::check::FindingCollector;
use super::node::{DefinitionPlace, Node, TomlEntry, TomlTable, TomlValue};

/// Largest machine file in bytes.
const MAX_FILE: usize = 1 << 20;

/// Most keys of a table and items of a list: keeps merging and checking quick for any file.
const MAX_ITEMS: usize = 5000;

/// Parses a file.
pub(crate) fn parse(file: &Arc<str>, bytes: &[u8], check: &FindingCollector) -> TomlTable {
    let start = DefinitionPlace { file: file.clone(), line: 0, column: 0 };
    if bytes.len() > MAX_FILE {
        check.error(&start, format!("the file is larger than {} MiB", MAX_FILE >> 20));
        return TomlTable::default();
    }
    match std::str::from_utf8(bytes) {
        Ok(text) => parse_text(file, text, check),
        Err(error) => {
            let lines = LineStarts::new(file, bytes);
            let place = lines.place(&(error.valid_up_to()..error.valid_up_to()));
            check.syntax(&place, "the file must be text in UTF-8; this byte is not part of any character".to_owned());
            TomlTable::default()
        }
    }
}

fn parse_text(file: &Arc<str>, text: &str, check: &FindingCollector) -> TomlTable {
    let lines = LineStarts::new(file, text.as_bytes());
    let (table, errors) = DeTable::parse_recoverable(text);
    for error in errors {
        let place = lines.place(&error.span().unwrap_or(0..0));
        check.syntax(&place, error.message().replace('\n', ", "));
    }
    convert_table(table.get_ref(), &lines, check)
}

fn convert_table(table: &DeTable<'_>, lines: &LineStarts<'_>, check: &FindingCollector) -> TomlTable {
    let mut entries: Vec<(usize, TomlEntry)> = table
        .iter()
        .map(|(key, value)| {
            let entry = TomlEntry {
                key: key.get_ref().to_string(),
                place: lines.place(&key.span()),
                node: convert(value, lines, check),
            };
            (key.span().start, entry)
        })
        .collect();
    entries.sort_by_key(|(start, _)| *start);
    if let Some((_, entry)) = entries.get(MAX_ITEMS) {
        check.error(&entry.place, format!("a table may have at most {MAX_ITEMS} keys"));
        entries.truncate(MAX_ITEMS);
    }
    TomlTable { entries: entries.into_iter().map(|(_, entry)| entry).collect() }
}

fn convert(value: &Spanned<DeValue<'_>>, lines: &LineStarts<'_>, check: &FindingCollector) -> Node {
    let place = lines.place(&value.span());
    let value = match value.get_ref() {
        DeValue::String(text) => TomlValue::Text(text.to_string()),
        DeValue::Integer(number) => match i64::from_str_radix(number.as_str(), number.radix()) {
            Ok(number) => TomlValue::Integer(number),
            Err(_) => {
                check.syntax(&place, format!("the number {number} is too large"));
                TomlValue::Integer(0)
            }
        },
        DeValue::Float(number) => TomlValue::Float(number.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(flag) => TomlValue::Flag(*flag),
        DeValue::Datetime(_) => TomlValue::Date,
        DeValue::Array(items) => {
            if items.len() > MAX_ITEMS {
                check.error(&place, format!("a list may have at most {MAX_ITEMS} items"));
            }
            TomlValue::Array(items.iter().take(MAX_ITEMS).map(|item| convert(item, lines, check)).collect())
        }
        DeValue::Table(table) => TomlValue::Table(convert_table(table, lines, check)),
    };
    Node { place, value }
}

/// Starts of lines, to turn byte offsets into lines and columns.
struct LineStarts<'t> {
    file: &'t Arc<str>,
    text: &'t [u8],
    starts: Vec<usize>,
}

impl<'t> LineStarts<'t> {
    fn new(file: &'t Arc<str>, text: &'t [u8]) -> Self {
        let starts = std::iter::once(0).chain(memchr::memchr_iter(b'\n', text).map(|at| at + 1)).collect();
        Self { file, text, starts }
    }

    fn place(&self, span: &Range<usize>) -> DefinitionPlace {
        let at = span.start.min(self.text.len());
        let line = self.starts.partition_point(|start| *start <= at);
        let start = self.starts.get(line.saturating_sub(1)).copied().unwrap_or(0);
        let before = self.text.get(start..at).unwrap_or_default();
        let column = String::from_utf8_lossy(before).chars().count() + 1;
        DefinitionPlace { file: self.file.clone(), line: count(line), column: count(column) }
    }
}

fn count(n: usize) -> u32 {
    u32::try_from(n).unwrap_or(u32::MAX)
}
