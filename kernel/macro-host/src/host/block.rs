//! The block in process as macros see it: its codes, its data, the active codes.
//!
//! Facts: reference functions.md 9. *Invariant:* actions do not find data that a macro takes, and find data that it
//! adds.

use counterpoint_channel::macro_queries::{activate_code, row_of_code, waiting_code};
use counterpoint_channel::macros::values::code_value;
use counterpoint_channel::word_values::handed_value;
use counterpoint_channel::word_values::{scaled_number, word_number};
use counterpoint_lang::diag::DiagnosticNumber;
use counterpoint_lang::fault::{MacroFault, Outcome};
use counterpoint_lang::ident;
use counterpoint_lang::value::MacroValue;
use counterpoint_lang::vm::MacroState;
use counterpoint_machine::Machine;
use counterpoint_machine::ident::{CodeId, DataId};
use counterpoint_machine::macros::condition::BlockIdentifier;
use counterpoint_machine::rows::CodeForm;
use counterpoint_program::block::PendingCode;

use crate::context::KernelHost;

/// Codes and data that macros may add to one block.
const MOST_ADDED: usize = 1000;

impl KernelHost<'_, '_> {
    /// `$FCEADD`
    pub(crate) fn add_item(&mut self, arguments: &[MacroValue]) -> Outcome<MacroValue> {
        let Some(item) = arguments.first() else { return Ok(MacroValue::Logical(false)) };
        if self.kernel.channel.block.added.len() + self.kernel.channel.block.pending.len() >= MOST_ADDED {
            return Err(MacroFault::new(
                DiagnosticNumber::SIZE,
                format!("a block has more than {MOST_ADDED} codes and data"),
            ));
        }
        let value = match arguments.get(1) {
            None => 0.0,
            Some(value) => value.as_real().ok_or_else(|| MacroFault::kind("a number", value))?,
        };
        if let MacroValue::Code(_) = item {
            return Ok(MacroValue::Logical(self.code_id(item).is_some_and(|id| self.add_code(id, value))));
        }
        let MacroValue::Register(_) = item else { return Err(MacroFault::kind("a code or data identifier", item)) };
        let known = self.data_id(item).filter(|id| knows_data(self.kernel.channel.env.machine, *id));
        if let Some(id) = known {
            self.kernel.channel.block.added.push((id, value));
        }
        Ok(MacroValue::Logical(known.is_some()))
    }

    /// Inserts a code by its order among those that have not acted yet.
    pub(crate) fn add_code(&mut self, id: CodeId, value: f64) -> bool {
        let Some(row) = row_of_code(&self.kernel.channel, id) else { return false };
        let facts = &self.kernel.channel.env.machine.codes[row];
        // The number before the row's factor and addend.
        let value = if facts.mul == 0.0 { value } else { (value - facts.add) / facts.mul };
        let pending = PendingCode { order: facts.order, row, value, modal: false, only_if_data_left: false };
        let next = self.kernel.channel.block.next.min(self.kernel.channel.block.pending.len());
        let rest = self.kernel.channel.block.pending.get(next..).unwrap_or(&[]);
        let at = next + rest.iter().take_while(|other| other.order <= pending.order).count();
        self.kernel.channel.block.pending.insert(at, pending);
        true
    }

    /// `$FCEGET`: takes a code or data off the block. Data pass the columns of their row; the data macros of those that
    /// no built-in action takes run, since nothing else obtains them.
    pub(crate) fn take_item(&mut self, state: &mut MacroState, arguments: &[MacroValue]) -> Outcome<MacroValue> {
        match self.named_item(arguments)? {
            Some(BlockIdentifier::Code(id)) => {
                let pending =
                    waiting_code(&self.kernel.channel, id).map(|at| self.kernel.channel.block.pending.remove(at));
                Ok(pending.map_or(MacroValue::Null, |pending| {
                    MacroValue::Real(code_number(self.kernel.channel.env.machine, pending))
                }))
            }
            Some(BlockIdentifier::Data(id)) => {
                let mut value = None;
                let runs = counterpoint_machine::ident::data_facts(id).is_none_or(|facts| !facts.built_in);
                self.hooks().meanwhile(state, |kernel| {
                    value = kernel.take_for_macro(id, runs);
                    Ok(())
                })?;
                Ok(value.map_or(MacroValue::Null, MacroValue::Real))
            }
            None => Ok(MacroValue::Null),
        }
    }

    /// The code or the data that a macro names; none if the machine does not know it.
    fn named_item(&self, arguments: &[MacroValue]) -> Outcome<Option<BlockIdentifier>> {
        match arguments.first() {
            None => Ok(None),
            Some(item @ MacroValue::Code(_)) => Ok(self.code_id(item).map(BlockIdentifier::Code)),
            Some(item @ MacroValue::Register(_)) => Ok(self.data_id(item).map(BlockIdentifier::Data)),
            Some(other) => Err(MacroFault::kind("a code or data identifier", other)),
        }
    }

    /// `$FCESEEK`
    pub(crate) fn seek_item(&self, arguments: &[MacroValue]) -> Outcome<MacroValue> {
        let id = match self.named_item(arguments)? {
            Some(BlockIdentifier::Data(id)) => id,
            Some(BlockIdentifier::Code(id)) => {
                let found = waiting_code(&self.kernel.channel, id)
                    .and_then(|at| self.kernel.channel.block.pending.get(at).copied());
                return Ok(found.map_or(MacroValue::Null, |pending| {
                    MacroValue::Real(code_number(self.kernel.channel.env.machine, pending))
                }));
            }
            None => return Ok(MacroValue::Null),
        };
        let named = |code: &i32| ident::minor_name(*code).filter(|name| ["MODAL", "LAST"].contains(name));
        let mode = match arguments.get(1) {
            None => "",
            Some(MacroValue::Keyword(code)) => {
                named(code).ok_or_else(|| MacroFault::kind("MODAL or LAST", &MacroValue::Keyword(*code)))?
            }
            Some(other) => return Err(MacroFault::kind("MODAL or LAST", other)),
        };
        if mode != "LAST"
            && let Some(value) = self.data_on_block(id)
        {
            return Ok(MacroValue::Real(value));
        }
        if mode.is_empty() {
            return Ok(MacroValue::Null);
        }
        let rows = self
            .kernel
            .channel
            .env
            .machine
            .tables
            .data(id)
            .iter()
            .map(|&row| &self.kernel.channel.env.machine.data[row]);
        let factor = rows.map(|row| self.kernel.channel.unit_factor(row.dimension)).next().unwrap_or(1.0);
        Ok(self
            .kernel
            .channel
            .state
            .remembered
            .value(id)
            .map_or(MacroValue::Null, |value| MacroValue::Real(value / factor)))
    }

    /// Value of data of this block, before any change of units.
    fn data_on_block(&self, id: DataId) -> Option<f64> {
        if let Some(handed) = self.kernel.channel.acting.as_data.filter(|handed| handed.id == id) {
            return Some(handed_value(self.kernel.channel.env.machine, handed));
        }
        let tables = self.kernel.channel.tables;
        for source in tables.sources_of(id) {
            if let Some(word) = self.kernel.channel.block.look(source.register) {
                return Some(
                    scaled_number(
                        &self.kernel.channel,
                        source,
                        &word,
                        word_number(&self.kernel.channel, source, &word),
                    )
                    .0,
                );
            }
        }
        let found = self.kernel.channel.block.added.iter().find(|(other, _)| *other == id);
        found.map(|(_, value)| *value)
    }

    /// `$FCEGAC`, `$FCESAC`
    pub(crate) fn active_code(&mut self, arguments: &[MacroValue], set: bool) -> MacroValue {
        let Some(id) = arguments.first().and_then(|item| self.code_id(item)) else { return MacroValue::Code(0) };
        let Some(row) = row_of_code(&self.kernel.channel, id) else { return MacroValue::Code(0) };
        let group = self.kernel.channel.env.machine.codes[row].group;
        let before = self.kernel.channel.state.modal.code(group).filter(|_| group != 0);
        if set {
            activate_code(&mut self.kernel.channel, id);
        }
        code_value(before)
    }

    /// `$FCEDAC`: data that fire the modal code of a group, or no longer.
    pub(crate) fn data_as_code(&mut self, arguments: &[MacroValue]) -> MacroValue {
        let id = arguments
            .first()
            .and_then(|item| self.data_id(item))
            .filter(|id| knows_data(self.kernel.channel.env.machine, *id));
        let group = arguments.get(1).and_then(MacroValue::as_real).unwrap_or(-1.0);
        let Some(id) = id else { return MacroValue::Logical(false) };
        let modes = &mut self.kernel.macros.modes;
        if group != -1.0 && !(1.0..=999.0).contains(&group) {
            return MacroValue::Logical(false);
        }
        modes.data_codes.retain(|(other, _)| *other != id);
        if group != -1.0 {
            modes.data_codes.push((id, group as u16));
        }
        MacroValue::Logical(true)
    }
}

/// Whether some row of the machine has this data.
pub(crate) fn knows_data(machine: &Machine, id: DataId) -> bool {
    !machine.tables.data(id).is_empty()
}

/// Value of a code as macros see it: of its word with the factor of its row, 0 for a literal text.
pub(crate) fn code_number(machine: &Machine, pending: PendingCode) -> f64 {
    let row = &machine.codes[pending.row];
    match row.form {
        CodeForm::Register { .. } | CodeForm::RegisterAsData { .. } => pending.value * row.mul + row.add,
        _ => pending.value,
    }
}
