//! How far axes went, by tool and by operation: `$TLMIN`, `$TLMAX`, `$OPMIN`, `$OPMAX`.
//!
//! Facts: reference system-variables.md 13, 14: columns 1 to 3 X Y Z, 4 to 6 U V W, 7 to 9 A B C as tables, 10 to 12 A
//! B C as heads, 13 an extending axis, 14 and 15 attachable ones; row 1 is the whole program. Decision: positions are
//! those of `$XM`, arcs with their extremes. *Invariant:* an axis that has not moved in a row has no position there.

/// Columns of the tables.
pub(crate) const COLUMNS: usize = 15;

/// Smallest and largest position of each column.
pub(crate) type Row = [[Option<f64>; 2]; COLUMNS];

/// The range of a column without positions.
const NOWHERE: (f64, f64) = (f64::INFINITY, f64::NEG_INFINITY);

/// The rows of one table.
#[derive(Debug, Default)]
pub(crate) struct Travel {
    pub(crate) rows: Vec<Row>,
    /// The row of the last motion, and for each column the range that this row and the first row have in common. A
    /// motion within it changes nothing.
    last: Option<(usize, [(f64, f64); COLUMNS])>,
}

impl Travel {
    /// A row that a macro may change.
    pub(crate) fn row(&mut self, at: usize) -> Option<&mut Row> {
        self.last = None;
        self.row_at(at)
    }

    fn row_at(&mut self, at: usize) -> Option<&mut Row> {
        if self.rows.len() <= at {
            self.rows.resize(at + 1, Row::default());
        }
        self.rows.get_mut(at)
    }

    /// An axis was at these positions, in the whole program and in a row, which counts from 1.
    #[inline]
    pub(crate) fn add(&mut self, row: usize, column: usize, (low, high): (f64, f64)) {
        let known = self.last.as_ref().filter(|(last, _)| *last == row).and_then(|(_, ranges)| ranges.get(column));
        if !known.is_some_and(|(least, most)| *least <= low && high <= *most) {
            self.widen(row, column, (low, high));
        }
    }

    #[inline(never)]
    fn widen(&mut self, row: usize, column: usize, (low, high): (f64, f64)) {
        let rows = [0, row.saturating_sub(1)];
        let mut common = (f64::NEG_INFINITY, f64::INFINITY);
        for &at in rows.get(..if row > 1 { 2 } else { 1 }).unwrap_or_default() {
            if let Some([least, most]) = self.row_at(at).and_then(|row| row.get_mut(column)) {
                let range = (least.map_or(low, |least| least.min(low)), most.map_or(high, |most| most.max(high)));
                (*least, *most) = (Some(range.0), Some(range.1));
                common = (common.0.max(range.0), common.1.min(range.1));
            }
        }
        let (_, ranges) = match &mut self.last {
            Some(last) if last.0 == row => last,
            other => other.insert((row, [NOWHERE; COLUMNS])),
        };
        if let Some(range) = ranges.get_mut(column) {
            *range = common;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_grows_in_the_program_and_in_the_row_of_the_motion() {
        let mut travel = Travel::default();
        let range = |travel: &Travel, row: usize| travel.rows.get(row).map(|row| row[2]);
        travel.add(2, 2, (-5.0, 10.0));
        travel.add(2, 2, (-1.0, 3.0));
        assert_eq!(range(&travel, 0), Some([Some(-5.0), Some(10.0)]));
        travel.add(3, 2, (-2.0, 4.0));
        travel.add(3, 2, (-3.0, 12.0));
        assert_eq!(range(&travel, 0), Some([Some(-5.0), Some(12.0)]));
        assert_eq!(range(&travel, 1), Some([Some(-5.0), Some(10.0)]));
        assert_eq!(range(&travel, 2), Some([Some(-3.0), Some(12.0)]));
        // A macro writes an end: later motions count from there.
        travel.row(2).unwrap()[2] = [Some(0.0), Some(0.0)];
        travel.add(3, 2, (-1.0, 1.0));
        assert_eq!(range(&travel, 2), Some([Some(-1.0), Some(1.0)]));
        assert_eq!(range(&travel, 0), Some([Some(-5.0), Some(12.0)]));
    }
}
