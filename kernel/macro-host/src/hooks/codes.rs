//! Hooks around the codes of a block: code macros before built-in actions, data macros on every value taken.
//!
//! Facts: reference control-emulator.md 2.3, 4.2. Invariants: a macro that runs cannot be selected again; a code counts
//! as acting (and modal) before its macro runs; codes that macros add act in this block, by their order.

use counterpoint_channel::context::Withheld;
use counterpoint_channel::macro_queries::{
    adds_motion, block_has_data, block_has_identifier, matching_code_macro, own_sequence, row_of_code,
};
use counterpoint_channel::macros::calls::OutputTask;
use counterpoint_channel::macros::values::{code_value, data_value};
use counterpoint_channel::modal::group;
use counterpoint_channel::queued_codes::{data_of_code, enter_code, group_queued};
use counterpoint_channel::trace::trace_data;
use counterpoint_channel::word_values::{recall, scaled_number, word_number};
use counterpoint_emulator::channel::hook_points::BlockOrigin;
use counterpoint_emulator::pipeline::codes::perform;
use counterpoint_emulator::pipeline::implied::{imply_motion, queue_by_data};
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_lang::value::MacroValue;
use counterpoint_machine::Machine;
use counterpoint_machine::ident::dimension::Dimension;
use counterpoint_machine::ident::{CodeId, DataId, codes, data};
use counterpoint_machine::index::{DataMacroId, RegisterId};
use counterpoint_machine::macros::condition::BlockIdentifier;
use counterpoint_machine::rows::CodeForm;
use counterpoint_program::block::{PendingCode, RetrievedValue};
use counterpoint_program::data_plan::{NEEDED, RECALLED};

use crate::context::MacroHooks;
use crate::host::block;

/// A value that has been taken, before data macros and units.
struct TakenValue {
    value: f64,
    factor: f64,
    incremental: bool,
    raw: f64,
    modal: bool,
    register: Option<RegisterId>,
}

impl MacroHooks<'_, '_> {
    /// Sequence numbers and marks of the block that macros can ask for.
    pub(crate) fn begin_codes(&mut self, origin: BlockOrigin) {
        self.head_sequence();
        if let Some(number) = self.kernel.channel.block.sequence {
            self.kernel.macros.books.note_sequence(number);
        }
        self.kernel.channel.block.next = 0;
        let mark = self.kernel.channel.context.mark.filter(|_| origin == BlockOrigin::Text);
        if let Some(level) = mark {
            self.kernel.channel.block.added.push((data::OPSKIP, f64::from(level)));
        }
    }

    /// Block Shutdown, for a block that was a text.
    pub(crate) fn end_codes(&mut self, origin: BlockOrigin) -> Acted {
        if origin == BlockOrigin::Text { self.block_shutdown() } else { Ok(()) }
    }

    /// Drops data that macros added and no code took; then reports the pending findings of macros about the program.
    pub(crate) fn drop_added_data(&mut self) -> Acted {
        self.report_withheld();
        self.added_leftovers();
        self.pending_halt()
    }

    /// The sequence number that the head of this channel has of its own.
    fn head_sequence(&mut self) {
        if let Some(register) = own_sequence(&self.kernel.channel)
            && let Some(word) = self.kernel.channel.block.take(register)
        {
            self.kernel.channel.block.sequence =
                self.kernel.channel.block.sequence.or((word.value >= 0.0).then_some(word.value as u32));
        }
    }

    /// Returns the halt that macros raised in a place that could not leave the program.
    pub(crate) fn pending_halt(&mut self) -> Acted {
        self.kernel.macros.calls.pending().map_or(Ok(()), Err)
    }

    /// Codes that data fire: motion by added axis values, and the codes set up by `$FCEDAC`.
    pub(crate) fn imply_by_data(&mut self) {
        if adds_motion(&self.kernel.channel)
            && !group_queued(&self.kernel.channel, group::MOTION)
            && !self.kernel.channel.block.has_any(self.kernel.channel.tables.registers.motion)
        {
            imply_motion(self.kernel.plan, &mut self.kernel.channel, &self.kernel.macros);
        }
        let count = self.kernel.macros.modes.data_codes.len();
        for at in 0..count {
            let pair = self.kernel.macros.modes.data_codes.get(at).copied();
            let Some((id, group)) = pair else { break };
            if block_has_data(&self.kernel.channel, id) && !group_queued(&self.kernel.channel, group) {
                queue_by_data(self.kernel.plan, &mut self.kernel.channel, group);
            }
        }
    }

    /// A code that has been removed from the block: its macro, otherwise its action.
    #[inline(never)]
    pub(crate) fn act_with_macros(&mut self, pending: PendingCode, id: CodeId) -> Acted {
        let outer = self.kernel.channel.context.set_code(Some(id));
        let done = self.run_code(pending, id);
        self.kernel.channel.context.set_code(outer);
        self.report_withheld();
        done
    }

    /// Reports that a data macro has removed a value that an action needed, unless the action has reported it.
    fn report_withheld(&mut self) {
        let Some(Withheld { id, code, diagnostics }) = self.kernel.channel.context.withheld.take() else { return };
        if self.kernel.channel.reports.diagnostics != diagnostics {
            return;
        }
        let machine = self.kernel.channel.env.machine;
        let name = machine.macros.as_deref().and_then(|macros| macros.name_of(code)).unwrap_or_default();
        let text = format!(
            "the data macro '{name}' removes the value of {} in '{}'; the action continues without it",
            machine.data_name(id),
            self.kernel.channel.block_text()
        );
        self.kernel.diagnose(&diag::VALUE_WITHHELD, text);
    }

    fn run_code(&mut self, pending: PendingCode, id: CodeId) -> Acted {
        let Some(code) = matching_code_macro(&self.kernel.channel, &self.kernel.macros, id) else {
            let machine = self.kernel.channel.env.machine;
            return perform(self.kernel, &machine.codes[pending.row], pending);
        };
        let mut arguments = [code_value(Some(id)), value_of_code(self.kernel.channel.env.machine, pending)];
        self.run_macro(code, OutputTask::Code(pending, id), &mut arguments).map(|_| ())
    }

    /// OUTPUT of a code macro: the code that `$P1` holds now continues to the next macro or to its action.
    pub(crate) fn output_code(&mut self, pending: PendingCode, id: CodeId, wanted: Option<&MacroValue>) -> Acted {
        let target = match wanted {
            None => id,
            Some(value @ MacroValue::Code(_)) => match self.host().code_id(value) {
                Some(target) => target,
                None => return Ok(()),
            },
            Some(other) => {
                let text = format!("$P1 of a code macro is {}, not a code", other.kind_name());
                self.kernel.diagnose(&diag::MACRO_RESULT, text);
                return Ok(());
            }
        };
        let row = if target == id { Some(pending.row) } else { row_of_code(&self.kernel.channel, target) };
        let Some(row) = row else {
            self.no_such_code(target);
            return Ok(());
        };
        let machine = self.kernel.channel.env.machine;
        let own = data_of_code(self.kernel.channel.env.machine, &machine.codes[pending.row], pending);
        let pending = PendingCode { row, ..pending };
        self.kernel.channel.acting.as_data = own;
        if target != id {
            enter_code(&mut self.kernel.channel, &machine.codes[row], pending);
            self.kernel.channel.acting.as_data = self.kernel.channel.acting.as_data.or(own);
        }
        let done = self.act_with_macros(pending, target);
        self.kernel.channel.acting.as_data = None;
        done
    }

    /// Takes the value of data off the block and lets every matching data macro have it.
    #[inline(never)]
    pub(crate) fn take_with_macros(&mut self, id: DataId) -> Option<RetrievedValue> {
        let block = &self.kernel.channel.block;
        let absent = (block.present | RECALLED) & self.kernel.channel.tables.data.registers_of[id] == 0;
        if absent && block.added.is_empty() && self.kernel.channel.acting.as_data.is_none() {
            return None;
        }
        let Some(mut taken) = self.taken(id) else {
            return if self.kernel.refuse(id) { None } else { recall(&self.kernel.channel, id) };
        };
        let mut absolute = false;
        let list = self.kernel.channel.env.machine.macros.as_deref().map_or(&[][..], |macros| macros.of_data(id));
        if !list.is_empty() && self.kernel.macros.hooks.matching {
            absolute = self.data_macros(id, list, &mut taken)?;
        }
        let value = taken.value * taken.factor;
        if taken.modal && !taken.incremental {
            self.kernel.channel.state.remembered.remember(id, value);
        }
        trace_data(&mut self.kernel.channel, id, value);
        Some(RetrievedValue { value, incremental: taken.incremental, absolute, raw: taken.raw })
    }

    /// Takes the value of data off the block for a macro, in the unit of the program; never a remembered value.
    pub(crate) fn take_for_macro(&mut self, id: DataId, runs: bool) -> Option<f64> {
        let Some(mut taken) = self.taken(id) else {
            self.kernel.refuse_word(id);
            return None;
        };
        let list = self.kernel.channel.env.machine.macros.as_deref().map_or(&[][..], |macros| macros.of_data(id));
        if runs && !list.is_empty() && self.kernel.macros.hooks.matching {
            self.data_macros(id, list, &mut taken)?;
        }
        if taken.modal && !taken.incremental && !id.kind().is_axis() {
            self.kernel.channel.state.remembered.remember(id, taken.value * taken.factor);
        }
        Some(taken.value)
    }

    fn taken(&mut self, id: DataId) -> Option<TakenValue> {
        if let Some(handed) = self.kernel.channel.acting.as_data.take_if(|handed| handed.id == id) {
            if self.kernel.refuse_handed(handed) {
                return None;
            }
            let (value, factor, modal) = self.kernel.accept(handed);
            return Some(TakenValue { value, factor, incremental: false, raw: handed.raw, modal, register: None });
        }
        let tables = self.kernel.channel.tables;
        for source in tables.sources_of(id) {
            let Some(word) = self.kernel.channel.block.take(source.register) else { continue };
            let raw = word_number(&self.kernel.channel, source, &word);
            let incremental = word.incremental;
            if raw < source.min || raw > source.max {
                self.kernel.out_of_range(source.row, raw);
            }
            let diameter = if source.diameter_x { self.kernel.channel.position_factor(id, incremental) } else { 1.0 };
            let (value, dimension) = scaled_number(&self.kernel.channel, source, &word, raw);
            let factor = self.kernel.channel.unit_factor(dimension) * diameter;
            let register = Some(source.register);
            return Some(TakenValue { value, factor, incremental, raw, modal: source.modal, register });
        }
        let at = self.kernel.channel.block.added.iter().position(|(other, _)| *other == id)?;
        let (_, value) = self.kernel.channel.block.added.remove(at);
        let rows = self.kernel.channel.env.machine.tables.data(id);
        let row = rows.first().map(|&row| &self.kernel.channel.env.machine.data[row]);
        let (dimension, modal) = row.map_or((Dimension::None, false), |row| (row.dimension.plain(), row.modal));
        let is_x = self.kernel.channel.tables.data.diameter_x.contains(&id);
        let diameter = if is_x { self.kernel.channel.position_factor(id, false) } else { 1.0 };
        let factor = self.kernel.channel.unit_factor(dimension) * diameter;
        Some(TakenValue { value, factor, incremental: false, raw: value, modal, register: None })
    }

    /// Runs the data macros of an identifier, in list order; none if one of them takes the value away. True if a macro
    /// says that the value is absolute in any mode.
    fn data_macros(&mut self, id: DataId, list: &[DataMacroId], taken: &mut TakenValue) -> Option<bool> {
        let relative = taken.incremental
            || self.kernel.channel.state.modal.code(group::POSITION) == Some(codes::POSITION_RELATIVE);
        let mode = if relative { 2.0 } else { 1.0 };
        let register = taken.register.map(|register| &self.kernel.channel.env.machine.registers[register]);
        let register = MacroValue::Real(register.map_or(0.0, |register| f64::from(register.index)));
        let mut arguments =
            [MacroValue::Real(1.0), MacroValue::Real(taken.value), data_value(id), MacroValue::Real(mode), register];
        for &at in list {
            let Some(code) = self.matching_data_macro(at) else { continue };
            let before = arguments.clone();
            if let Err(halt) = self.run_macro(code, OutputTask::None, &mut arguments) {
                self.kernel.macros.calls.stop(halt);
                break;
            }
            self.check_result(&before, &mut arguments);
            if arguments.first().and_then(MacroValue::as_real) == Some(0.0) {
                if NEEDED.contains(&id) {
                    let diagnostics = self.kernel.channel.reports.diagnostics;
                    self.kernel.channel.context.withheld = Some(Withheld { id, code, diagnostics });
                }
                return None;
            }
        }
        let [_, value, _, wanted, _] = &arguments;
        if let Some(value) = value.as_real() {
            taken.value = value;
        }
        let wanted = wanted.as_real().unwrap_or(mode);
        if wanted == mode {
            return Some(false);
        }
        taken.incremental = wanted == 2.0;
        Some(wanted == 1.0)
    }

    fn matching_data_macro(&self, at: DataMacroId) -> Option<u16> {
        let named = &self.kernel.channel.env.machine.macros.as_deref()?.data[at];
        let runtime = &*self.kernel.macros;
        let may = runtime.hooks.has_data(at) && !runtime.calls.is_busy(named.code);
        // The data that are being taken count as present; they are off the block already.
        let holds = || {
            let present = |item| match (item, self.kernel.channel.env.machine.macros.as_deref()) {
                (BlockIdentifier::Data(id), Some(macros))
                    if macros.of_data(id).contains(&at) && !block_has_data(&self.kernel.channel, id) =>
                {
                    true
                }
                _ => block_has_identifier(&self.kernel.channel, item, None),
            };
            named.condition.is_empty() || named.condition.holds(present)
        };
        (may && holds()).then_some(named.code)
    }

    /// A data macro returns numbers; anything else is reported and replaced by the value before.
    fn check_result(&mut self, before: &[MacroValue; 5], after: &mut [MacroValue; 5]) {
        for (at, (old, new)) in before.iter().zip(after.iter_mut()).enumerate() {
            if at == 2 || matches!(new, MacroValue::Real(number) if number.is_finite()) {
                continue;
            }
            let text = format!("$P{} of a data macro is {}, not a number; it is ignored", at + 1, new.kind_name());
            *new = old.clone();
            self.kernel.diagnose(&diag::MACRO_RESULT, text);
        }
    }

    /// Added data that nothing has taken.
    fn added_leftovers(&mut self) {
        while let Some((id, value)) = self.kernel.channel.block.added.pop() {
            if id == data::OPSKIP {
                continue;
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
            let modal = rows.clone().any(|row| row.modal && row.process);
            if modal && !id.kind().is_axis() {
                let factor =
                    rows.map(|row| self.kernel.channel.unit_factor(row.dimension.plain())).next().unwrap_or(1.0);
                self.kernel.channel.state.remembered.remember(id, value * factor);
                continue;
            }
            let name = self.kernel.channel.env.machine.data_name(id);
            let value = counterpoint_lang::format::wildcard_text(value);
            self.kernel.diagnose(&diag::DATA_NOT_USED, format!("{name} {value} is not used by any code; ignored"));
        }
    }

    /// Runs a macro of a hook without arguments.
    ///
    /// # Errors
    /// It made the kernel leave its program.
    pub(crate) fn plain_macro(&mut self, hook: counterpoint_machine::macros::model::Hook) -> Result<(), Halt> {
        match self.kernel.macros.ready(hook) {
            Some(code) => self.run_macro(code, OutputTask::None, &mut []).map(|_| ()),
            None => Ok(()),
        }
    }
}

/// `$P2` of a code macro.
fn value_of_code(machine: &Machine, pending: PendingCode) -> MacroValue {
    match &machine.codes[pending.row].form {
        CodeForm::Text(text) => MacroValue::text(text.as_str()),
        _ => MacroValue::Real(block::code_number(machine, pending)),
    }
}
