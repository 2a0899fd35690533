//! Times, tables and shortened lists as text.

use std::borrow::Cow;
use std::fmt::Write as _;

use crate::say::{DIM, styled};

/// Simulated time as minutes, seconds and milliseconds, from one hour on with hours.
pub(crate) fn time(ns: i64) -> String {
    let ms = ns.saturating_add(500_000) / 1_000_000;
    let (minutes, seconds, rest) = (ms / 60_000, ms / 1000 % 60, ms % 1000);
    match minutes / 60 {
        0 => format!("{minutes:02}:{seconds:02}.{rest:03}"),
        hours => format!("{hours}:{:02}:{seconds:02}.{rest:03}", minutes % 60),
    }
}

/// Whether a character changes the direction of a text, ends its line without being a control character, or has no
/// width.
fn deceives(c: char) -> bool {
    let with_range = matches!(c, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}');
    with_range || matches!(c, '\u{61c}' | '\u{feff}')
}

/// A text with an escape in place of each character that deceives its reader. The escape is one of JSON.
pub(crate) fn visible(text: &str) -> Cow<'_, str> {
    if !text.contains(deceives) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        let _ = if deceives(c) { write!(out, "\\u{:04x}", u32::from(c)) } else { write!(out, "{c}") };
    }
    Cow::Owned(out)
}

/// Lays rows out in columns; the first `left` columns to the left, the rest to the right.
pub(crate) fn table(rows: &[Vec<String>], left: usize) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |c: usize| rows.iter().filter_map(|row| row.get(c)).map(|cell| cell.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut out = String::new();
    for row in rows {
        let cells =
            row.iter().zip(&widths).enumerate().map(|(c, (cell, &width))| {
                if c < left { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
            });
        let line = cells.collect::<Vec<_>>().join("  ");
        let _ = writeln!(out, "  {}", line.trim_end());
    }
    out
}

/// How many of a list are not shown.
pub(crate) fn more(out: &mut String, count: usize, shown: usize, what: &str) {
    if count > shown {
        let _ = writeln!(out, "  {}", styled(DIM, format_args!("and {} more {what}", count - shown)));
    }
}
