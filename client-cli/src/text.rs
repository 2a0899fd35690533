//! Times, tables and shortened lists as text.

use std::borrow::Cow;
use std::fmt::Write as _;

use crate::say::{DIM, styled};
use crate::visible::visible;

/// Simulated time as minutes, seconds and milliseconds, from one hour on with hours.
pub(crate) fn time(ns: i64) -> String {
    let ms = ns.saturating_add(500_000) / 1_000_000;
    let (minutes, seconds, rest) = (ms / 60_000, ms / 1000 % 60, ms % 1000);
    match minutes / 60 {
        0 => format!("{minutes:02}:{seconds:02}.{rest:03}"),
        hours => format!("{hours}:{:02}:{seconds:02}.{rest:03}", minutes % 60),
    }
}

/// Lays rows out in columns; the first `left` columns to the left, the rest to the right. Deceptive characters are
/// escaped.
pub(crate) fn table(rows: &[Vec<String>], left: usize) -> String {
    let rows: Vec<Vec<Cow<'_, str>>> = rows.iter().map(|row| row.iter().map(|cell| visible(cell)).collect()).collect();
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |c: usize| rows.iter().filter_map(|row| row.get(c)).map(|cell| cell.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut out = String::new();
    for row in &rows {
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
