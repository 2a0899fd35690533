//! Figures while a load is in progress: a table on a terminal, a line every ten seconds elsewhere.

use console::Term;
use tokio::time::Instant;

use super::measure::Measured;
use crate::say::{self, DIM, styled};
use crate::text;

/// Rows of the table.
const ROWS: usize = 12;
/// Seconds between two lines.
const LINES: usize = 10;

/// The content of the terminal.
#[derive(Debug)]
pub(super) struct LiveDisplay {
    terminal: Option<Term>,
    quiet: bool,
    lines: usize,
    shown: usize,
}

impl LiveDisplay {
    pub(super) fn new(quiet: bool) -> Self {
        let terminal = Some(Term::stderr()).filter(Term::is_term);
        Self { terminal, quiet, lines: 0, shown: 0 }
    }

    /// Shows the last seconds.
    pub(super) fn show(&mut self, measured: &Measured, _now: Instant) {
        self.shown += 1;
        if self.quiet || self.terminal.is_none() && !self.shown.is_multiple_of(LINES) {
            return;
        }
        let rows = if self.terminal.is_some() { ROWS } else { 1 };
        let text = table(measured, rows);
        self.clear();
        for line in text.lines() {
            say::status_line(line);
        }
        if self.terminal.is_some() {
            self.lines = text.lines().count();
        }
    }

    /// Removes the table.
    pub(super) fn clear(&mut self) {
        if let Some(terminal) = &self.terminal {
            let _ = terminal.clear_last_lines(std::mem::take(&mut self.lines));
        }
    }
}

fn table(measured: &Measured, rows: usize) -> String {
    let ms = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |ms| format!("{ms:.1}"));
    let heads =
        ["s", "submits/s", "p50", "p99 ms", "ends/s", "p50", "p99 ms", "events/s", "open", "errors", "cores", "MiB"];
    let mut lines = vec![heads.map(str::to_owned).to_vec()];
    for second in measured.seconds.iter().rev().take(rows).rev() {
        let mark = if second.warm_up { "warm-up " } else { "" };
        lines.push(vec![
            format!("{mark}{:.0}", second.at_s),
            second.submitted.to_string(),
            ms(second.submit_p50_ms),
            ms(second.submit_p99_ms),
            second.ended.to_string(),
            ms(second.end_p50_ms),
            ms(second.end_p99_ms),
            second.events.to_string(),
            second.open.to_string(),
            second.errors.to_string(),
            second.process.map_or_else(|| "-".to_owned(), |process| format!("{:.2}", process.cores)),
            second.process.map_or_else(|| "-".to_owned(), |process| (process.rss >> 20).to_string()),
        ]);
    }
    let mut out = text::table(&lines, 0);
    if !measured.errors.is_empty() {
        let errors: Vec<String> = measured.errors.iter().map(|(reason, count)| format!("{reason} {count}")).collect();
        out += &format!("  {}\n", styled(DIM, errors.join(", ")));
    }
    out
}
