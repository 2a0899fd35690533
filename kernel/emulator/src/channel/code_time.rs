//! Time of a code from the machine's table.

use super::Kernel;
use counterpoint_event::event::{Function, Kind};
use counterpoint_machine::rows::{CodeForm, CodeRow};
use counterpoint_program::block::PendingCode;

impl Kernel<'_> {
    /// Time of a code from the machine's table.
    pub(crate) fn take_time(&mut self, row: &CodeRow, pending: PendingCode) {
        let ns = crate::state::channel::nanoseconds(row.seconds);
        let (letter, value) = self.written(row, pending);
        self.emit(ns, Kind::Function(Function { letter, value }));
        self.channel.advance(ns);
    }

    /// Letter and value of a code as written.
    pub(crate) fn written(&self, row: &CodeRow, pending: PendingCode) -> (char, f64) {
        let register = match row.form {
            CodeForm::Register { register, .. } | CodeForm::RegisterAsData { register, .. } => Some(register),
            CodeForm::Text(_) | CodeForm::NotApplicable => None,
        };
        let letter = register
            .and_then(|register| self.channel.env.machine.registers[register].name.chars().next())
            .unwrap_or('?');
        (letter, pending.value)
    }
}
