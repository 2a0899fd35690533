//! `$TLMIN`, `$TLMAX`, `$OPMIN`, `$OPMAX` as macros read and write them.

use counterpoint_lang::fault::Outcome;
use counterpoint_lang::value::Value;

use crate::channel::Kernel;
use crate::macros::books::travel::COLUMNS;
use crate::state::channel::Channel;
use counterpoint_event::event::{MAX_AXES, Motion, MotionKind};
use counterpoint_machine::ident::{DataId, data};
use counterpoint_machine::index::{AxisSlot, BySlot};
use counterpoint_results::geometry::Round;

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
pub(crate) enum End {
    Low,
    High,
}

/// Place of a column and of a row by the numbers of a macro.
fn place(at: &[i64]) -> Option<(usize, usize)> {
    let index = |at: Option<&i64>| usize::try_from(*at?).ok()?.checked_sub(1);
    Some((index(at.first())?, index(at.get(1))?))
}

impl Kernel<'_> {
    /// Notes where a motion leads.
    pub(crate) fn note_travel(&mut self, motion: &Motion) {
        self.note_offsets(motion.moving);
        let axes = || {
            let info = self.channel.env.info;
            info.channel(self.channel.at.channel).map_or(&[][..], |channel| channel.axes.as_slice())
        };
        let is_straight = matches!(motion.kind, MotionKind::Rapid | MotionKind::Linear);
        let round = if is_straight { None } else { Round::of(motion, axes()).map(|round| (round, axes())) };
        let preset = self.channel.state.place.preset;
        let books = &mut self.macros.books;
        let rows = [books.tool_sums.row_number(), books.operation_sums.row_number()];
        let ends = motion.from.iter().zip(&motion.to).zip(&preset).zip(&books.columns);
        for (axis, (((from, to), preset), column)) in ends.enumerate() {
            let (mut low, mut high) = (from.min(*to), from.max(*to));
            if let Some((round, axes)) = round {
                for at in round.reversals(axes, axis) {
                    (low, high) = (low.min(at), high.max(at));
                }
            }
            let Some(column) = column.filter(|_| low < high) else { continue };
            let way = (low + preset, high + preset);
            books.tool_travel.add(rows[0], column, way);
            books.operation_travel.add(rows[1], column, way);
        }
    }

    fn travel_place(&self, of_tools: bool, at: &[i64]) -> Option<(usize, usize)> {
        match at {
            [column, row] if of_tools => place(&[*column, self.kept_tool_row(*row)]),
            _ => place(at),
        }
    }

    /// `$TLMIN(column,row)` and the others.
    pub(crate) fn travel_value(&self, of_tools: bool, end: End, at: &[i64]) -> Value {
        let books = &self.macros.books;
        let travel = if of_tools { &books.tool_travel } else { &books.operation_travel };
        let found = self.travel_place(of_tools, at).and_then(|(column, row)| {
            let [low, high] = travel.rows.get(row)?.get(column)?;
            if end == End::Low { *low } else { *high }
        });
        // Digits of arcs after the ninth were not programmed.
        found.map_or(Value::Null, |value| Value::Real((value * 1e9).round() / 1e9))
    }

    /// Writes one of them.
    pub(crate) fn set_travel_value(&mut self, of_tools: bool, end: End, at: &[i64], value: &Value) -> Outcome<()> {
        let place = self.travel_place(of_tools, at);
        let Some((column, row)) = place else { return Ok(()) };
        let books = &mut self.macros.books;
        let travel = if of_tools { &mut books.tool_travel } else { &mut books.operation_travel };
        if let Some([low, high]) = travel.row(row).and_then(|row| row.get_mut(column)) {
            *(if end == End::Low { low } else { high }) = value.as_real();
        }
        Ok(())
    }
}

/// A second table about Z takes the place of the first one where that is missing.
fn second_table(channel: &Channel<'_>, id: DataId) -> Option<AxisSlot> {
    channel.axis_of_data(data::AXIS_CT2).filter(|_| id == data::AXIS_CT)
}

/// Column of each axis of the channel, none for those that the tables do not have.
pub(crate) fn travel_columns(channel: &Channel<'_>) -> [Option<usize>; MAX_AXES] {
    let mut columns = [None; MAX_AXES];
    for (column, id) in AXES.into_iter().enumerate() {
        let axis = channel.axis_of_data(id).or_else(|| second_table(channel, id));
        if let Some(axis) = axis {
            *columns.at_mut(axis) = Some(column);
        }
    }
    columns
}
