//! How far axes went, by tool and by operation: `$TLMIN`, `$TLMAX`, `$OPMIN`, `$OPMAX`.
//!
//! Facts: reference system-variables.md 13, 14: columns 1 to 3 X Y Z, 4 to 6 U V W, 7 to 9 A B C as tables, 10 to 12 A
//! B C as heads, 13 an extending axis, 14 and 15 attachable ones; row 1 is the whole program. Decision: positions are
//! those of `$XM`, arcs with their extremes. *Invariant:* an axis that has not moved in a row has no position there.

use counterpoint_lang::value::MacroValue;

use super::Books;
use crate::channel_context::ChannelContext;
use crate::macros::tool_table::ToolTable;
use counterpoint_event::event::{Motion, MotionKind};
use counterpoint_machine::ident::{DataId, data};
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_results::geometry::ArcGeometry;

/// Columns of the tables.
pub(super) const COLUMNS: usize = 15;

/// Smallest and largest position of each column.
pub type Row = [[Option<f64>; 2]; COLUMNS];

/// The range of a column without positions.
const NOWHERE: (f64, f64) = (f64::INFINITY, f64::NEG_INFINITY);

/// The rows of one table.
#[derive(Debug, Default)]
pub struct TravelTable {
    /// The rows, in the order of their tools or operations.
    pub rows: Vec<Row>,
    /// The row of the last motion, and for each column the range that this row and the first row have in common. A
    /// motion within it changes nothing.
    last: Option<(usize, [(f64, f64); COLUMNS])>,
}

impl TravelTable {
    /// A row that a macro may change.
    pub fn row(&mut self, at: usize) -> Option<&mut Row> {
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
    pub fn add(&mut self, row: usize, column: usize, (low, high): (f64, f64)) {
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

/// Data of the axes of the columns.
const AXES: [DataId; COLUMNS] = [
    data::AXIS_X,
    data::AXIS_Y,
    data::AXIS_Z,
    data::AXIS_U,
    data::AXIS_V,
    data::AXIS_W,
    data::AXIS_AT,
    data::AXIS_BT,
    data::AXIS_CT,
    data::AXIS_AH,
    data::AXIS_BH,
    data::AXIS_CH,
    data::AXIS_E,
    data::AXIS_N,
    data::AXIS_N2,
];

/// Which end of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RangeEnd {
    /// The smallest position.
    Low,
    /// The largest position.
    High,
}

/// Place of a column and of a row by the numbers of a macro.
fn place(at: &[i64]) -> Option<(usize, usize)> {
    let index = |at: Option<&i64>| usize::try_from(*at?).ok()?.checked_sub(1);
    Some((index(at.first())?, index(at.get(1))?))
}

/// A second table about Z takes the place of the first one where that is missing.
fn second_table(channel: &ChannelContext<'_>, id: DataId) -> Option<AxisSlot> {
    channel.state.place.axis_of_data(data::AXIS_CT2).filter(|_| id == data::AXIS_CT)
}

fn travel_place(tools: &ToolTable, of_tools: bool, at: &[i64]) -> Option<(usize, usize)> {
    match at {
        [column, row] if of_tools => place(&[*column, tools.kept_row(*row)]),
        _ => place(at),
    }
}

impl Books {
    /// Finds the column of each axis of the channel; `None` for an axis that the tables do not have.
    pub fn set_columns(&mut self, channel: &ChannelContext<'_>) {
        for (column, id) in AXES.into_iter().enumerate() {
            let axis = channel.state.place.axis_of_data(id).or_else(|| second_table(channel, id));
            if let Some(axis) = axis {
                *self.columns.at_mut(axis) = Some(column);
            }
        }
    }

    /// Notes where a motion leads.
    pub fn note_travel(&mut self, channel: &ChannelContext<'_>, motion: &Motion) {
        self.note_offsets(channel, motion.moving);
        let axes = || {
            let info = channel.env.info;
            info.channel(channel.at.channel).map_or(&[][..], |one| one.axes.as_slice())
        };
        let is_straight = matches!(motion.kind, MotionKind::Rapid | MotionKind::Linear);
        let round = if is_straight { None } else { ArcGeometry::of(motion, axes()).map(|round| (round, axes())) };
        let preset = channel.state.place.preset;
        let rows = channel.state.times.rows();
        let ends = motion.from.iter().zip(&motion.to).zip(&preset).zip(&self.columns);
        for (axis, (((from, to), preset), column)) in ends.enumerate() {
            let (mut low, mut high) = (from.min(*to), from.max(*to));
            if let Some((round, axes)) = round {
                for at in round.reversals(axes, axis) {
                    (low, high) = (low.min(at), high.max(at));
                }
            }
            let Some(column) = column.filter(|_| low < high) else { continue };
            let way = (low + preset, high + preset);
            self.tool_travel.add(rows[0], column, way);
            self.operation_travel.add(rows[1], column, way);
        }
    }

    /// `$TLMIN(column,row)` and the others.
    pub fn travel_value(&self, tools: &ToolTable, of_tools: bool, end: RangeEnd, at: &[i64]) -> MacroValue {
        let travel = if of_tools { &self.tool_travel } else { &self.operation_travel };
        let found = travel_place(tools, of_tools, at).and_then(|(column, row)| {
            let [low, high] = travel.rows.get(row)?.get(column)?;
            if end == RangeEnd::Low { *low } else { *high }
        });
        // Digits of arcs after the ninth were not programmed.
        found.map_or(MacroValue::Null, |value| MacroValue::Real((value * 1e9).round() / 1e9))
    }

    /// Writes one of them.
    pub fn set_travel_value(
        &mut self,
        tools: &ToolTable,
        of_tools: bool,
        end: RangeEnd,
        (at, value): (&[i64], &MacroValue),
    ) {
        let Some((column, row)) = travel_place(tools, of_tools, at) else { return };
        let travel = if of_tools { &mut self.tool_travel } else { &mut self.operation_travel };
        if let Some([low, high]) = travel.row(row).and_then(|row| row.get_mut(column)) {
            *(if end == RangeEnd::Low { low } else { high }) = value.as_real();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_grows_in_the_program_and_in_the_row_of_the_motion() {
        let mut travel = TravelTable::default();
        let range = |travel: &TravelTable, row: usize| travel.rows.get(row).map(|row| row[2]);
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
