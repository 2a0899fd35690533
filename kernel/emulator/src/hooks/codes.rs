//! Hooks around the codes of a block: code macros before built-in actions, data macros on every value taken.
//!
//! Facts: reference control-emulator.md 2.3, 4.2. Invariants: a macro that runs cannot be selected again; a code counts
//! as acting (and modal) before its macro runs; codes that macros add act in this block, by their order.

use counterpoint_lang::value::MacroValue;
use counterpoint_machine::Machine;
use counterpoint_machine::ident::kind::data::DataKind;
use counterpoint_machine::index::{DataMacroId, RegisterId};

use crate::channel::Kernel;
use crate::channel::hook_points::BlockOrigin;
use crate::channel::plan::{NEEDED, RECALLED};
use crate::host::block;
use crate::pipeline::codes::data_of_code;
use counterpoint_channel::context::Withheld;
use counterpoint_channel::macros::calls::OutputTask;
use counterpoint_channel::macros::values::{code_value, data_value};
use counterpoint_channel::modal::group;
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_machine::ident::dimension::Dimension;
use counterpoint_machine::ident::{CodeId, DataId, codes, data};
use counterpoint_machine::macros::condition::BlockIdentifier;
use counterpoint_machine::rows::CodeForm;
use counterpoint_program::block::PendingCode;
use counterpoint_program::block::RetrievedValue;

/// A value that has been taken, before data macros and units.
struct TakenValue {
    value: f64,
    factor: f64,
    incremental: bool,
    raw: f64,
    modal: bool,
    register: Option<RegisterId>,
}

impl Kernel<'_> {
    /// Sequence numbers and marks of the block that macros can ask for.
    pub(crate) fn begin_codes(&mut self, origin: BlockOrigin) {
        self.head_sequence();
        if let Some(number) = self.channel.block.sequence {
            self.macros.books.note_sequence(number);
        }
        self.channel.block.next = 0;
        let mark = self.channel.context.mark.filter(|_| origin == BlockOrigin::Text);
        if let Some(level) = mark {
            self.channel.block.added.push((data::OPSKIP, f64::from(level)));
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
        if let Some(register) = self.own_sequence()
            && let Some(word) = self.channel.block.take(register)
        {
            self.channel.block.sequence =
                self.channel.block.sequence.or((word.value >= 0.0).then_some(word.value as u32));
        }
    }

    /// Register of the sequence numbers that the head of this channel has of its own.
    pub(crate) fn own_sequence(&self) -> Option<RegisterId> {
        let own = usize::from(self.channel.env.kernel_number(self.channel.at.channel))
            .checked_sub(1)
            .and_then(|head| self.plan.registers.head_sequences.get(head));
        own.copied().flatten()
    }

    /// Returns the halt that macros raised in a place that could not leave the program.
    pub(crate) fn pending_halt(&mut self) -> Acted {
        self.macros.calls.pending().map_or(Ok(()), Err)
    }

    /// Codes that data fire: motion by added axis values, and the codes set up by `$FCEDAC`.
    pub(crate) fn imply_by_data(&mut self) {
        if self.adds_motion()
            && !self.group_queued(group::MOTION)
            && !self.channel.block.has_any(self.plan.registers.motion)
        {
            self.imply_motion();
        }
        let count = self.macros.modes.data_codes.len();
        for at in 0..count {
            let pair = self.macros.modes.data_codes.get(at).copied();
            let Some((id, group)) = pair else { break };
            if self.has_data(id) && !self.group_queued(group) {
                self.queue_by_data(group);
            }
        }
    }

    /// Whether a macro has put the position of an axis or the shape of an arc in the block.
    pub(crate) fn adds_motion(&self) -> bool {
        self.channel.block.added.iter().any(|(id, _)| matches!(id.kind(), DataKind::Axis(_) | DataKind::Arc))
    }

    /// Data by which `$FCEDAC` fires the code of a group are in the block.
    pub(crate) fn has_calling_data(&self, group: u16) -> bool {
        let pairs = self.macros.modes.data_codes.as_slice();
        pairs.iter().any(|(id, of)| *of == group && self.has_data(*id))
    }

    /// The first code macro for a code that is on, not running, and whose condition holds.
    pub(crate) fn matching_code_macro(&self, id: CodeId) -> Option<u16> {
        let macros = self.channel.env.machine.macros.as_deref()?;
        let list = macros.of_code(id);
        let runtime = &*self.macros;
        if list.is_empty() || !runtime.hooks.matching {
            return None;
        }
        list.iter().find_map(|&at| {
            let named = &macros.codes[at];
            let may = runtime.hooks.has_code(at) && !runtime.calls.is_busy(named.code);
            let holds = || named.condition.is_empty() || named.condition.holds(|item| self.is_present(item, Some(id)));
            (may && holds()).then_some(named.code)
        })
    }

    /// Whether an identifier is in the block; the code that acts counts as present.
    fn is_present(&self, item: BlockIdentifier, fired: Option<CodeId>) -> bool {
        match item {
            BlockIdentifier::Code(id) => Some(id) == fired || self.has_code(id),
            BlockIdentifier::Data(id) => self.has_data(id),
        }
    }

    /// A code that has been removed from the block: its macro, otherwise its action.
    #[inline(never)]
    pub(crate) fn act_with_macros(&mut self, pending: PendingCode, id: CodeId) -> Acted {
        let outer = self.channel.context.set_code(Some(id));
        let done = self.run_code(pending, id);
        self.channel.context.set_code(outer);
        self.report_withheld();
        done
    }

    /// Reports that a data macro has removed a value that an action needed, unless the action has reported it.
    fn report_withheld(&mut self) {
        let Some(Withheld { id, code, diagnostics }) = self.channel.context.withheld.take() else { return };
        if self.channel.reports.diagnostics != diagnostics {
            return;
        }
        let machine = self.channel.env.machine;
        let name = machine.macros.as_deref().and_then(|macros| macros.name_of(code)).unwrap_or_default();
        let text = format!(
            "the data macro '{name}' removes the value of {} in '{}'; the action continues without it",
            machine.data_name(id),
            self.channel.block_text()
        );
        self.diagnose(&diag::VALUE_WITHHELD, text);
    }

    fn run_code(&mut self, pending: PendingCode, id: CodeId) -> Acted {
        let Some(code) = self.matching_code_macro(id) else {
            let machine = self.channel.env.machine;
            return self.perform(&machine.codes[pending.row], pending);
        };
        let mut arguments = [code_value(Some(id)), value_of_code(self.channel.env.machine, pending)];
        self.run_macro(code, OutputTask::Code(pending, id), &mut arguments).map(|_| ())
    }

    /// OUTPUT of a code macro: the code that `$P1` holds now continues to the next macro or to its action.
    pub(crate) fn output_code(&mut self, pending: PendingCode, id: CodeId, wanted: Option<&MacroValue>) -> Acted {
        let target = match wanted {
            None => id,
            Some(value @ MacroValue::Code(_)) => match self.code_id(value) {
                Some(target) => target,
                None => return Ok(()),
            },
            Some(other) => {
                let text = format!("$P1 of a code macro is {}, not a code", other.kind_name());
                self.diagnose(&diag::MACRO_RESULT, text);
                return Ok(());
            }
        };
        let row = if target == id { Some(pending.row) } else { self.row_of_code(target) };
        let Some(row) = row else {
            self.no_such_code(target);
            return Ok(());
        };
        let machine = self.channel.env.machine;
        let own = data_of_code(self.channel.env.machine, &machine.codes[pending.row], pending);
        let pending = PendingCode { row, ..pending };
        self.channel.acting.as_data = own;
        if target != id {
            self.enter_code(&machine.codes[row], pending);
            self.channel.acting.as_data = self.channel.acting.as_data.or(own);
        }
        let done = self.act_with_macros(pending, target);
        self.channel.acting.as_data = None;
        done
    }

    /// Takes the value of data off the block and lets every matching data macro have it.
    #[inline(never)]
    pub(crate) fn take_with_macros(&mut self, id: DataId) -> Option<RetrievedValue> {
        let block = &self.channel.block;
        let absent = (block.present | RECALLED) & self.plan.data.registers_of[id] == 0;
        if absent && block.added.is_empty() && self.channel.acting.as_data.is_none() {
            return None;
        }
        let Some(mut taken) = self.taken(id) else {
            return if self.refuse(id) { None } else { self.recall(id) };
        };
        let mut absolute = false;
        let list = self.channel.env.machine.macros.as_deref().map_or(&[][..], |macros| macros.of_data(id));
        if !list.is_empty() && self.macros.hooks.matching {
            absolute = self.data_macros(id, list, &mut taken)?;
        }
        let value = taken.value * taken.factor;
        if taken.modal && !taken.incremental {
            self.channel.state.remembered.remember(id, value);
        }
        self.trace_data(id, value);
        Some(RetrievedValue { value, incremental: taken.incremental, absolute, raw: taken.raw })
    }

    /// Takes the value of data off the block for a macro, in the unit of the program; never a remembered value.
    pub(crate) fn take_for_macro(&mut self, id: DataId, runs: bool) -> Option<f64> {
        let Some(mut taken) = self.taken(id) else {
            self.refuse_word(id);
            return None;
        };
        let list = self.channel.env.machine.macros.as_deref().map_or(&[][..], |macros| macros.of_data(id));
        if runs && !list.is_empty() && self.macros.hooks.matching {
            self.data_macros(id, list, &mut taken)?;
        }
        if taken.modal && !taken.incremental && !id.kind().is_axis() {
            self.channel.state.remembered.remember(id, taken.value * taken.factor);
        }
        Some(taken.value)
    }

    fn taken(&mut self, id: DataId) -> Option<TakenValue> {
        if let Some(handed) = self.channel.acting.as_data.take_if(|handed| handed.id == id) {
            if self.refuse_handed(handed) {
                return None;
            }
            let (value, factor, modal) = self.accept(handed);
            return Some(TakenValue { value, factor, incremental: false, raw: handed.raw, modal, register: None });
        }
        let plan = self.plan;
        for source in plan.sources_of(id) {
            let Some(word) = self.channel.block.take(source.register) else { continue };
            let raw = self.raw(source, &word);
            let incremental = word.incremental;
            if raw < source.min || raw > source.max {
                self.out_of_range(source.row, raw);
            }
            let diameter = if source.diameter_x { self.channel.position_factor(id, incremental) } else { 1.0 };
            let (value, dimension) = self.scaled(source, &word, raw);
            let factor = self.channel.unit_factor(dimension) * diameter;
            let register = Some(source.register);
            return Some(TakenValue { value, factor, incremental, raw, modal: source.modal, register });
        }
        let at = self.channel.block.added.iter().position(|(other, _)| *other == id)?;
        let (_, value) = self.channel.block.added.remove(at);
        let rows = self.channel.env.machine.tables.data(id);
        let row = rows.first().map(|&row| &self.channel.env.machine.data[row]);
        let (dimension, modal) = row.map_or((Dimension::None, false), |row| (row.dimension.plain(), row.modal));
        let is_x = self.plan.data.diameter_x.contains(&id);
        let diameter = if is_x { self.channel.position_factor(id, false) } else { 1.0 };
        let factor = self.channel.unit_factor(dimension) * diameter;
        Some(TakenValue { value, factor, incremental: false, raw: value, modal, register: None })
    }

    /// Runs the data macros of an identifier, in list order; none if one of them takes the value away. True if a macro
    /// says that the value is absolute in any mode.
    fn data_macros(&mut self, id: DataId, list: &[DataMacroId], taken: &mut TakenValue) -> Option<bool> {
        let relative =
            taken.incremental || self.channel.state.modal.code(group::POSITION) == Some(codes::POSITION_RELATIVE);
        let mode = if relative { 2.0 } else { 1.0 };
        let register = taken.register.map(|register| &self.channel.env.machine.registers[register]);
        let register = MacroValue::Real(register.map_or(0.0, |register| f64::from(register.index)));
        let mut arguments =
            [MacroValue::Real(1.0), MacroValue::Real(taken.value), data_value(id), MacroValue::Real(mode), register];
        for &at in list {
            let Some(code) = self.matching_data_macro(at) else { continue };
            let before = arguments.clone();
            if let Err(halt) = self.run_macro(code, OutputTask::None, &mut arguments) {
                self.macros.calls.stop(halt);
                break;
            }
            self.check_result(&before, &mut arguments);
            if arguments.first().and_then(MacroValue::as_real) == Some(0.0) {
                if NEEDED.contains(&id) {
                    let diagnostics = self.channel.reports.diagnostics;
                    self.channel.context.withheld = Some(Withheld { id, code, diagnostics });
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
        let named = &self.channel.env.machine.macros.as_deref()?.data[at];
        let runtime = &*self.macros;
        let may = runtime.hooks.has_data(at) && !runtime.calls.is_busy(named.code);
        // The data that are being taken count as present; they are off the block already.
        let holds = || {
            let present = |item| match (item, self.channel.env.machine.macros.as_deref()) {
                (BlockIdentifier::Data(id), Some(macros)) if macros.of_data(id).contains(&at) && !self.has_data(id) => {
                    true
                }
                _ => self.is_present(item, None),
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
            self.diagnose(&diag::MACRO_RESULT, text);
        }
    }

    /// Added data that nothing has taken.
    fn added_leftovers(&mut self) {
        while let Some((id, value)) = self.channel.block.added.pop() {
            if id == data::OPSKIP {
                continue;
            }
            let rows = self.channel.env.machine.tables.data(id).iter().map(|&row| &self.channel.env.machine.data[row]);
            let modal = rows.clone().any(|row| row.modal && row.process);
            if modal && !id.kind().is_axis() {
                let factor = rows.map(|row| self.channel.unit_factor(row.dimension.plain())).next().unwrap_or(1.0);
                self.channel.state.remembered.remember(id, value * factor);
                continue;
            }
            let name = self.channel.env.machine.data_name(id);
            let value = counterpoint_lang::format::wildcard_text(value);
            self.diagnose(&diag::DATA_NOT_USED, format!("{name} {value} is not used by any code; ignored"));
        }
    }

    /// Runs a macro of a hook without arguments.
    ///
    /// # Errors
    /// It made the kernel leave its program.
    pub fn plain_macro(&mut self, hook: counterpoint_machine::macros::model::Hook) -> Result<(), Halt> {
        match self.macros.ready(hook) {
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
