//! How far axes went, by tool and by operation: `$TLMIN`, `$TLMAX`, `$OPMIN`, `$OPMAX`.
//!
//! Facts: reference system-variables.md 13, 14: columns 1 to 3 X Y Z, 4 to 6 U V W, 7 to 9 A B C as tables, 10 to 12 A
//! B C as heads, 13 an extending axis, 14 and 15 attachable ones; row 1 is the whole program. Decision: positions are
//! those of `$XM`, arcs with their extremes. *Invariant:* an axis that has not moved in a row has no position there.

/// Columns of the tables.
pub(crate) const COLUMNS: usize = 15;

/// Smallest and largest position of each column.
pub(crate) type Row = [[Option<f64>; 2]; COLUMNS];

/// The rows of one table.
#[derive(Debug, Default)]
pub(crate) struct Travel {
    pub(crate) rows: Vec<Row>,
}

impl Travel {
    pub(crate) fn row(&mut self, at: usize) -> Option<&mut Row> {
        if self.rows.len() <= at {
            self.rows.resize(at + 1, Row::default());
        }
        self.rows.get_mut(at)
    }

    /// An axis was at these positions, in the whole program and in a row, which counts from 1.
    pub(crate) fn add(&mut self, row: usize, column: usize, (low, high): (f64, f64)) {
        let rows = [0, row.saturating_sub(1)];
        for &at in rows.get(..if row > 1 { 2 } else { 1 }).unwrap_or_default() {
            if let Some([least, most]) = self.row(at).and_then(|row| row.get_mut(column)) {
                *least = Some(least.map_or(low, |least| least.min(low)));
                *most = Some(most.map_or(high, |most| most.max(high)));
            }
        }
    }
}
