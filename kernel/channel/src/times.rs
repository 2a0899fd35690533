//! Times of motions and of waiting, and times, feeds and speeds by tool and by operation: `$TLSUM`, `$OPSUM`.
//!
//! Facts: reference system-variables.md 13, 14: columns 1 to 3 seconds of feed, positioning and everything else, 4 and
//! 5 smallest and largest feed per minute (10000 and −1 before any), 6 and 7 smallest and largest rev/min (0 before
//! any), taken at the ends of motions. *Invariants:* row 1 is neither a tool nor an operation; every second belongs to
//! one row, waiting to the third column; nothing is recorded on a machine without macros, except waiting. Decision: the
//! feed per minute of a motion is its length by its time.

use counterpoint_event::event::SpindleDirection;
use counterpoint_sync::shared::SpindleCommand;

use super::at::nanoseconds;

/// The content of one row.
#[derive(Debug, Clone, Copy)]
struct SumRow {
    feed: f64,
    rapid: f64,
    /// Its time until the latest switch of rows, in nanoseconds.
    whole: i64,
    feeds: (f64, f64),
    speeds: (f64, f64),
}

impl Default for SumRow {
    fn default() -> Self {
        Self { feed: 0.0, rapid: 0.0, whole: 0, feeds: (10_000.0, -1.0), speeds: (0.0, 0.0) }
    }
}

/// The rows of one table.
#[derive(Debug, Default)]
struct SumTable {
    rows: Vec<SumRow>,
    /// Index of the current row, and the clock at which it became current.
    current: usize,
    since: i64,
    /// Takes amounts without a row; never read.
    lost: SumRow,
}

impl SumTable {
    /// Makes another row the current row; rows count from 1.
    fn switch(&mut self, row: usize, clock: i64) {
        let since = self.since;
        self.row().whole += clock - since;
        (self.current, self.since) = (row.saturating_sub(1), clock);
    }

    fn row(&mut self) -> &mut SumRow {
        if self.rows.len() <= self.current {
            self.rows.resize(self.current + 1, SumRow::default());
        }
        match self.rows.get_mut(self.current) {
            Some(row) => row,
            None => &mut self.lost,
        }
    }

    /// Adds a motion; its length counts for feeds only.
    fn motion(&mut self, rapid: bool, (seconds, length): (f64, f64), speed: f64) {
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
    fn value(&self, column: i64, row: i64, clock: i64) -> f64 {
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

/// The times of a channel, as macros read them.
#[derive(Debug, Default)]
pub struct TimeRecord {
    /// Motions are recorded.
    on: bool,
    /// `$FEDTIM`, `$RAPTIM` in seconds.
    motion: [f64; 2],
    /// Additions of macros to `$MISTIM`, `$IDLTIM`, in seconds.
    added: [f64; 2],
    /// Time of all motions and of all waiting, in nanoseconds.
    moving: i64,
    idle: i64,
    /// `$TLSUM`
    tools: SumTable,
    /// `$OPSUM`
    operations: SumTable,
}

/// The record of times, with the spindle command of the moves that it records.
pub struct MoveTimes<'s> {
    /// The record.
    pub record: &'s mut TimeRecord,
    /// The command of the spindle.
    pub command: &'s SpindleCommand,
}

impl MoveTimes<'_> {
    /// Records the time that the look-ahead adds to moves at feed, ns.
    pub fn extend(&mut self, ns: i64) {
        if self.record.on && ns > 0 {
            self.record.moving += ns;
            self.record.sum(self.command, false, (ns as f64 / 1e9, 0.0));
        }
    }
}

impl TimeRecord {
    /// Starts or stops recording motions.
    pub fn record_motions(&mut self, on: bool) {
        self.on = on;
    }

    /// Records a motion of some seconds and length.
    pub fn add_motion(&mut self, command: &SpindleCommand, rapid: bool, (seconds, length): (f64, f64)) {
        if self.on {
            self.moving += nanoseconds(seconds);
            self.sum(command, rapid, (seconds, length));
        }
    }

    fn sum(&mut self, command: &SpindleCommand, rapid: bool, amount: (f64, f64)) {
        if let Some(time) = self.motion.get_mut(usize::from(rapid)) {
            *time += amount.0;
        }
        let turning = matches!(command.direction, SpindleDirection::Clockwise | SpindleDirection::CounterClockwise);
        let speed = if turning && !command.css { command.rpm } else { 0.0 };
        self.tools.motion(rapid, amount, speed);
        self.operations.motion(rapid, amount, speed);
    }

    /// Records that the channel has waited, ns.
    pub fn add_waiting(&mut self, ns: i64) {
        self.idle = self.idle.saturating_add(ns);
    }

    /// Seconds at feed, or in rapid motion.
    pub fn motion(&self, rapid: bool) -> f64 {
        self.motion.get(usize::from(rapid)).copied().unwrap_or(0.0)
    }

    /// Sets the seconds at feed, or in rapid motion.
    pub fn set_motion(&mut self, rapid: bool, seconds: f64) {
        if let Some(time) = self.motion.get_mut(usize::from(rapid)) {
            *time = seconds;
        }
    }

    /// Seconds until this clock, ns, that were neither motion nor waiting.
    pub fn other(&self, clock: i64) -> f64 {
        (clock - self.moving - self.idle) as f64 / 1e9 + self.added[0]
    }

    /// Sets the seconds that were neither motion nor waiting.
    pub fn set_other(&mut self, clock: i64, seconds: f64) {
        let wanted = seconds - self.other(clock);
        self.added[0] += wanted;
    }

    /// Seconds of waiting.
    pub fn waiting(&self) -> f64 {
        self.idle as f64 / 1e9 + self.added[1]
    }

    /// Sets the seconds of waiting.
    pub fn set_waiting(&mut self, seconds: f64) {
        let wanted = seconds - self.waiting();
        self.added[1] += wanted;
    }

    /// Records that the tool in this row is loaded at this clock, ns; rows count from 1.
    pub fn switch_tool(&mut self, row: usize, clock: i64) {
        self.tools.switch(row, clock);
    }

    /// Records that the operation in this row begins at this clock, ns; rows count from 1.
    pub fn switch_operation(&mut self, row: usize, clock: i64) {
        self.operations.switch(row, clock);
    }

    /// Rows of the loaded tool and of the operation.
    pub fn rows(&self) -> [usize; 2] {
        [self.tools.current + 1, self.operations.current + 1]
    }

    /// A value of the table of tools, or of the table of operations, at this clock, ns.
    pub fn sum_value(&self, of_tools: bool, clock: i64, (column, row): (i64, i64)) -> f64 {
        let sums = if of_tools { &self.tools } else { &self.operations };
        sums.value(column, row, clock)
    }
}
