//! `$TLSUM` and `$OPSUM` as macros read them.

use counterpoint_lang::value::Value;

use crate::channel::Kernel;

impl Kernel<'_> {
    /// Notes a motion for the tables.
    pub(crate) fn sum_motion(&mut self, rapid: bool, seconds: f64, length: f64) {
        use counterpoint_event::event::Direction;
        let command = &self.channel.state.spindle.command;
        let turning = matches!(command.direction, Direction::Clockwise | Direction::CounterClockwise);
        let speed = if turning && !command.css { command.rpm } else { 0.0 };
        let books = &mut self.macros.books;
        books.tool_sums.motion(rapid, (seconds, length), speed);
        books.operation_sums.motion(rapid, (seconds, length), speed);
    }

    /// `$TLSUM(column,row)`, or `$OPSUM`.
    pub(crate) fn sum_value(&self, of_tools: bool, at: &[i64]) -> Value {
        let (column, row) = (at.first().copied().unwrap_or(0), at.get(1).copied().unwrap_or(0));
        let row = if of_tools { self.kept_tool_row(row) } else { row };
        let books = &self.macros.books;
        let sums = if of_tools { &books.tool_sums } else { &books.operation_sums };
        Value::Real(sums.value(column, row, self.channel.now()))
    }
}
