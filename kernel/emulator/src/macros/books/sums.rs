//! Times, feeds and speeds by tool and by operation: `$TLSUM`, `$OPSUM`.
//!
//! Facts: reference system-variables.md 13, 14: columns 1 to 3 seconds of feed, positioning and everything else, 4 and
//! 5 smallest and largest feed per minute (10000 and −1 before any), 6 and 7 smallest and largest rev/min (0 before
//! any), taken at the ends of motions. *Invariant:* row 1 is neither a tool nor an operation; every second belongs to
//! one row, waiting to the third column. Decision: the feed per minute of a motion is its length by its time.

use counterpoint_lang::value::Value;

use super::Books;
use crate::macros::tool_table::ToolTable;
use counterpoint_event::event::Direction;
use counterpoint_sync::shared::Command;

/// The content of one row.
#[derive(Debug, Clone, Copy)]
struct Sum {
    feed: f64,
    rapid: f64,
    /// All of its time before it became the current row, in nanoseconds.
    whole: i64,
    feeds: (f64, f64),
    speeds: (f64, f64),
}

impl Default for Sum {
    fn default() -> Self {
        Self { feed: 0.0, rapid: 0.0, whole: 0, feeds: (10_000.0, -1.0), speeds: (0.0, 0.0) }
    }
}

/// The rows of one table.
#[derive(Debug, Default)]
pub(crate) struct Sums {
    rows: Vec<Sum>,
    /// Place of the current row, and when it became that.
    current: usize,
    since: i64,
    /// Takes amounts without a row; never read.
    lost: Sum,
}

impl Sums {
    /// Another row becomes the current one; rows count from 1.
    pub(crate) fn switch(&mut self, row: usize, clock: i64) {
        let since = self.since;
        self.row().whole += clock - since;
        (self.current, self.since) = (row.saturating_sub(1), clock);
    }

    /// Number of the current row.
    pub(crate) fn row_number(&self) -> usize {
        self.current + 1
    }

    fn row(&mut self) -> &mut Sum {
        if self.rows.len() <= self.current {
            self.rows.resize(self.current + 1, Sum::default());
        }
        match self.rows.get_mut(self.current) {
            Some(row) => row,
            None => &mut self.lost,
        }
    }

    /// A motion; its length counts for feeds only.
    pub(crate) fn motion(&mut self, rapid: bool, (seconds, length): (f64, f64), speed: f64) {
        let row = self.row();
        if rapid {
            row.rapid += seconds;
        } else {
            row.feed += seconds;
            if seconds > 0.0 {
                let feed = length / seconds * 60.0;
                row.feeds = (row.feeds.0.min(feed), row.feeds.1.max(feed));
            }
        }
        if speed > 0.0 {
            let (low, high) = row.speeds;
            row.speeds = (if low == 0.0 { speed } else { low.min(speed) }, high.max(speed));
        }
    }

    /// A value of the table.
    pub(crate) fn value(&self, column: i64, row: i64, clock: i64) -> f64 {
        let at = usize::try_from(row).ok().and_then(|row| row.checked_sub(1));
        let sum = at.and_then(|at| self.rows.get(at)).copied().unwrap_or_default();
        let open = if at == Some(self.current) { clock - self.since } else { 0 };
        match column {
            1 => sum.feed,
            2 => sum.rapid,
            3 => {
                let other = (sum.whole + open) as f64 / 1e9 - sum.feed - sum.rapid;
                // The remainder of rounding to nanoseconds does not count as time.
                if other.abs() < 1e-6 { 0.0 } else { other }
            }
            4 => sum.feeds.0,
            5 => sum.feeds.1,
            6 => sum.speeds.0,
            _ => sum.speeds.1,
        }
    }
}

impl Books {
    /// Notes a motion of some seconds and length.
    pub(crate) fn sum_motion(&mut self, command: &Command, rapid: bool, amount: (f64, f64)) {
        let turning = matches!(command.direction, Direction::Clockwise | Direction::CounterClockwise);
        let speed = if turning && !command.css { command.rpm } else { 0.0 };
        self.tool_sums.motion(rapid, amount, speed);
        self.operation_sums.motion(rapid, amount, speed);
    }

    /// `$TLSUM(column,row)`, or `$OPSUM`, at this clock, ns.
    pub(crate) fn sum_value(&self, tools: &ToolTable, of_tools: bool, clock: i64, at: &[i64]) -> Value {
        let (column, row) = (at.first().copied().unwrap_or(0), at.get(1).copied().unwrap_or(0));
        let row = if of_tools { tools.kept_row(row) } else { row };
        let sums = if of_tools { &self.tool_sums } else { &self.operation_sums };
        Value::Real(sums.value(column, row, clock))
    }
}
