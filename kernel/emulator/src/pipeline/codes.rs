//! Stage *codes*: the rows that the words of a block match, and the loop that lets the codes act by order.
//!
//! Facts: reference control-emulator.md 1.2, 2.3, 3.1, 3.3.

use crate::channel::Kernel;
use crate::channel::hook_points::BlockOrigin;
use crate::pipeline::conditions;
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_control_api::MacroCall;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::Machine;
use counterpoint_machine::ident::kind::CodeKind;
use counterpoint_machine::ident::{self, CodeId, DataId, codes};
use counterpoint_machine::index::{DataRowId, RegisterId};
use counterpoint_machine::number::written;
use counterpoint_machine::rows::{CodeForm, CodeRow, Modality};
use counterpoint_program::block::{PendingCode, Word};

use counterpoint_channel::channel_context::Handed;
use counterpoint_channel::modal::group;

impl Kernel<'_> {
    /// Sorts the words of the block into codes and data, lets the codes act, and treats the remaining words.
    #[inline]
    pub fn codes(&mut self, origin: BlockOrigin) -> Acted {
        let hooks = self.plan.hooks;
        if origin == BlockOrigin::Text && (self.categorise() || self.flow.calls_each_block(&self.channel.block)) {
            return self.macro_call();
        }
        self.check_known()?;
        if let Some(hooks) = hooks {
            (hooks.codes.begin)(self, origin);
        }
        if self.channel.tables.rules.length_moves
            && (self.channel.block.flags.special || self.channel.block.has_any(self.channel.tables.registers.length))
        {
            self.length_words();
        }
        self.imply();
        if let Some(hooks) = hooks {
            (hooks.codes.implied)(self);
        }
        self.check_refused()?;
        if self.channel.block.has_any(self.channel.tables.registers.before_codes) {
            self.words_before_codes()?;
        }
        self.sort();
        while let Some(&pending) = self.channel.block.pending.get(self.channel.block.next) {
            self.channel.block.next += 1;
            self.fire(pending)?;
            if let Some(hooks) = hooks {
                (hooks.codes.acted)(self)?;
            }
        }
        if let Some(hooks) = hooks {
            (hooks.codes.end)(self, origin)?;
        }
        self.leftovers()?;
        if let Some(hooks) = hooks {
            (hooks.codes.dropped)(self)?;
        }
        Ok(())
    }

    /// Words that act before the codes of their block.
    #[inline(never)]
    fn words_before_codes(&mut self) -> Acted {
        if self.channel.block.has_any(self.channel.tables.registers.offsets) {
            self.offset_words()?;
        }
        if self.channel.block.has_any(self.channel.tables.registers.speed) { self.speed_before_codes() } else { Ok(()) }
    }

    /// Numbers of offsets that no code of the block takes select their offsets.
    fn offset_words(&mut self) -> Acted {
        let takers = &self.channel.tables.rules.number_takers;
        let taken = self.channel.block.pending.iter().fold(0, |bits, pending| bits | takers[pending.row]);
        let free = self.channel.tables.registers.offsets & !taken;
        if self.channel.block.has_any(free) { (self.plan.actions.offset_words)(self, free) } else { Ok(()) }
    }

    /// Finds code rows and makes the rest available as data. Returns `true` for a macro call of the pre-processor.
    #[inline(always)]
    pub fn categorise(&mut self) -> bool {
        let machine = self.channel.env.machine;
        let mut conditional = false;
        let mut call = self.channel.tables.code_calls.is_some() && self.calls_by_code();
        for position in 0..self.channel.block.words.len() {
            let Some(word) = self.channel.block.words.get(position) else { break };
            if self.channel.tables.registers.only_data & word.register.bit() != 0 {
                self.channel.block.index_word(position);
                continue;
            }
            let word = *word;
            let candidates = machine.tables.code(word.register, word.value);
            match candidates.first().map(|&row| (row, &machine.codes[row])) {
                None if Some(word.register) == self.channel.tables.registers.g => {
                    match self.macro_call_of(word.value) {
                        Some(how) => {
                            call |= how != MacroCall::End;
                            self.channel.block.use_word(position);
                        }
                        None => self.data_word(position),
                    }
                }
                None => self.data_word(position),
                Some((index, row)) if row.with.is_empty() && row.without.is_empty() => {
                    self.channel.block.use_word(position);
                    self.channel.block.queue(index, row, word.value, false);
                }
                Some(_) => conditional = true,
            }
        }
        if conditional {
            self.categorise_conditional();
        }
        for index in 0..self.channel.block.texts.len() {
            if let Some(mut row) = self.channel.block.texts.get(index).copied() {
                if !conditions::fits(&self.channel.block, &machine.codes[row]) {
                    row = conditions::fitting_text(&self.channel, row);
                    if let Some(slot) = self.channel.block.texts.get_mut(index) {
                        *slot = row;
                    }
                }
                self.channel.block.queue(row, &machine.codes[row], 0.0, false);
            }
        }
        if self.channel.block.pending.len() > 1 && self.channel.tables.rules.exclusive.is_some() {
            self.last_of_groups();
        }
        if self.channel.block.pending.len() > 1 && machine.cycles.last_of_block {
            self.cycle_or_motion();
        }
        call
    }

    /// Of several G codes of one group the last one acts.
    #[inline(never)]
    fn last_of_groups(&mut self) {
        for position in 0..self.channel.block.words.len() {
            let Some((word, at, group)) = self.code_of_word(position) else { continue };
            let later = |at: usize| self.code_of_word(at).filter(|&(_, _, other)| other == group);
            let Some((last, ..)) = (position + 1..self.channel.block.words.len()).find_map(later) else { continue };
            self.channel.block.pending.remove(at);
            if last.value != word.value {
                let text = format!(
                    "{} has no effect: {} of the same group comes later in '{}'",
                    word_text(self.channel.env.machine, word),
                    word_text(self.channel.env.machine, last),
                    self.channel.block_text()
                );
                self.diagnose(&diag::GROUP_TWICE, text);
            }
        }
    }

    /// The word at a position, the place of the code that it fires and the group in which only the last one acts.
    fn code_of_word(&self, position: usize) -> Option<(Word, usize, u16)> {
        let word = self
            .channel
            .block
            .words
            .get(position)
            .copied()
            .filter(|word| Some(word.register) == self.channel.tables.registers.g)?;
        let rows = self.channel.env.machine.tables.code(word.register, word.value);
        let fired = |pending: &PendingCode| pending.value == word.value && rows.contains(&pending.row);
        let at = self.channel.block.pending.iter().position(fired)?;
        let group = self
            .channel
            .block
            .pending
            .get(at)
            .and_then(|pending| Some(self.channel.tables.rules.exclusive.as_ref()?[pending.row]))?;
        (group != 0).then_some((word, at, group))
    }

    /// Treats a word that is not a code: data if a row knows its register, otherwise unknown text.
    pub(super) fn data_word(&mut self, position: usize) {
        let Some(word) = self.channel.block.words.get(position).copied() else { return };
        let known = !self.channel.env.machine.tables.data_of(word.register).is_empty();
        if Some(word.register) == self.channel.tables.registers.definition {
            self.channel.block.use_word(position);
        } else if known {
            self.channel.block.index_word(position);
        } else {
            self.channel.block.use_word(position);
            self.channel.block.unrecognised.push((word.start, word.end));
        }
    }

    /// Modal codes that fire without being written: motion by axis words, persistent codes, and the modal member of
    /// a group that a non-modal code overrode on an earlier block.
    #[inline(always)]
    pub(crate) fn imply(&mut self) {
        if self.channel.block.flags.special {
            self.drop_ignored();
        }
        if self.channel.block.has_any(self.channel.tables.registers.motion) && !self.group_queued(group::MOTION) {
            self.imply_motion();
        }
        if self.channel.state.modal.refires.is_empty() {
            return;
        }
        for index in (0..self.channel.state.modal.refires.len()).rev() {
            let Some(&(group, forever)) = self.channel.state.modal.refires.get(index) else { continue };
            if self.group_queued(group) {
                continue;
            }
            queue_modal(&mut self.channel, group);
            if !forever {
                self.channel.state.modal.refires.remove(index);
            }
        }
    }

    /// Words of axes that ignored codes of the block ignore move nothing.
    #[cold]
    fn drop_ignored(&mut self) {
        for at in 0..self.channel.block.pending.len() {
            let row = self.channel.block.pending.get(at).map(|pending| &self.channel.env.machine.codes[pending.row]);
            let row = row.filter(|row| !row.process);
            for &register in row.map_or(&[][..], |row| row.ignores.as_slice()) {
                self.channel.block.take(register);
            }
            if row.is_some_and(|row| row.owns_axes) {
                self.take_axis_words(|_, _| {});
            }
        }
    }

    /// The same for a code that data fire: it acts only if some of them are left by then.
    pub fn queue_by_data(&mut self, group: u16) {
        let before = self.channel.block.pending.len();
        queue_modal(&mut self.channel, group);
        // Alone in its block it finds the data that fire it.
        if (before > 0 || !self.channel.state.modal.refires.is_empty() || self.plan.hooks.is_some())
            && let Some(pending) = self.channel.block.pending.get_mut(before)
        {
            pending.only_if_data_left = true;
        }
    }

    /// Whether some of the data that fire a code remain; data taken meanwhile fire nothing.
    #[cold]
    fn is_left(&self, group: u16) -> bool {
        let moves = group == group::MOTION || group == group::CYCLE;
        moves && (self.channel.block.has_any(self.channel.tables.registers.motion) || self.adds_motion())
            || self.has_calling_data(group)
    }

    /// Whether a code of a group has yet to act on this block.
    pub fn group_queued(&self, group: u16) -> bool {
        self.channel.block.pending.iter().any(|f| self.channel.env.machine.codes[f.row].group == group)
    }

    /// By order, left to right among equals (insertion sort: a block has few codes).
    #[inline(always)]
    pub fn sort(&mut self) {
        let pending = &mut self.channel.block.pending;
        for end in 1..pending.len() {
            let mut at = end;
            while at > 0 && pending.get(at - 1).map(|f| f.order) > pending.get(at).map(|f| f.order) {
                pending.swap(at - 1, at);
                at -= 1;
            }
        }
    }

    /// Lets one code act.
    pub(crate) fn fire(&mut self, pending: PendingCode) -> Acted {
        self.channel.check_stop()?;
        let machine = self.channel.env.machine;
        let row = &machine.codes[pending.row];
        if pending.only_if_data_left && !self.is_left(row.group) {
            return Ok(());
        }
        if !row.process {
            self.swallow(row, pending);
            return Ok(());
        }
        self.enter_code(row, pending);
        let result = match self.plan.hooks {
            Some(hooks) => (hooks.codes.act)(self, pending, row.id),
            None => self.perform(row, pending),
        };
        self.channel.acting.as_data = None;
        if row.owns_axes && result.is_ok() {
            self.refuse_axis_words(row, pending);
        }
        result
    }

    /// Treats a code that the machine recognises and ignores.
    #[cold]
    fn swallow(&mut self, row: &CodeRow, pending: PendingCode) {
        self.trace_ignored(row.id);
        if row.seconds > 0.0 {
            self.take_time(row, pending);
        } else if let CodeForm::Register { register, .. } | CodeForm::RegisterAsData { register, .. } = row.form
            && Some(register) == self.channel.tables.registers.function
        {
            self.channel.reports.swallowed.note(pending.value);
        }
    }

    /// Reports at the end of the program the M functions that had no effect.
    pub(crate) fn report_swallowed(&mut self) {
        let swallowed = std::mem::take(&mut self.channel.reports.swallowed);
        if swallowed.is_empty() || self.channel.env.options.lint {
            return;
        }
        self.diagnose(
            &diag::FUNCTIONS_IGNORED,
            format!("this machine gives these functions neither an effect nor a time: {swallowed}"),
        );
    }

    /// Steps before a code acts: it is remembered if it is a function, hands over its data, becomes active in its modal
    /// group.
    #[inline(always)]
    pub fn enter_code(&mut self, row: &CodeRow, pending: PendingCode) {
        if !pending.modal
            && let CodeForm::Register { register, .. } | CodeForm::RegisterAsData { register, .. } = row.form
            && Some(register) == self.channel.tables.registers.function
            && !matches!(row.id, codes::CALSUB_ID | codes::CALSUB_RETURN)
        {
            self.channel.state.remembered.remember_function(pending.value);
        }
        self.channel.acting.as_data = data_of_code(self.channel.env.machine, row, pending);
        self.channel.acting.mode_changed = self.channel.state.modal.code(row.group) != Some(row.id);
        match row.modality {
            Modality::NonModal if row.group != 0 && !pending.modal => self.channel.state.modal.refire_once(row.group),
            Modality::NonModal => {}
            Modality::Modal => self.channel.state.modal.activate(row.group, row.id, Some(pending.row)),
            Modality::Persistent => self.channel.state.modal.activate_persistent(row.group, row.id, Some(pending.row)),
        }
    }

    /// The built-in action of a code.
    #[inline(always)]
    pub fn perform(&mut self, row: &CodeRow, pending: PendingCode) -> Acted {
        let result = match self.plan.action_of_row[pending.row] {
            Some(action) => {
                if self.channel.env.trace.is_some() {
                    self.trace_code(row.id);
                }
                action.run(self, row, &pending)
            }
            None => {
                self.trace_ignored(row.id);
                self.without_action(row.id);
                Ok(())
            }
        };
        if row.seconds > 0.0 && result.is_ok() {
            self.take_time(row, pending);
        }
        result
    }

    /// A code that nothing handles (reference control-emulator.md 2.3).
    pub fn without_action(&mut self, id: CodeId) {
        let name = self.channel.env.machine.code_name(id).to_owned();
        if name == "CODE_IGNORE" {
            return;
        }
        let documented_without = ident::code_facts(id).is_some_and(|facts| !facts.built_in);
        let text = self.channel.block_text();
        if documented_without {
            self.diagnose(
                &diag::CODE_WITHOUT_PROCESSING,
                format!("{} has no built-in processing and is ignored in '{text}'", name.to_lowercase()),
            );
        } else {
            self.diagnose(&diag::NO_ACTION, format!("{} has no action in '{text}'", name.to_lowercase()));
        }
    }

    /// Loads the start state of the machine: these codes become active without acting. A form of the tool direction
    /// among them is the one in which programs write directions.
    pub fn initial_codes(&mut self) {
        for &id in &self.channel.env.machine.initial {
            let row = self.channel.env.machine.codes.entries().find(|(_, row)| row.id == id);
            if let Some((index, row)) = row {
                self.channel.state.modal.activate(row.group, id, Some(index));
            } else if let Some(facts) = ident::code_facts(id) {
                self.channel.state.modal.activate(facts.group, id, None);
            }
            if let CodeKind::TipFormat(format) = id.kind() {
                self.channel.state.others.tip.format = format;
            }
        }
        self.channel.state.secondary = self.channel.state.says_secondary();
    }
}

/// A word as its register writes it.
pub(super) fn word_text(machine: &Machine, word: Word) -> String {
    let register = &machine.registers[word.register];
    format!("{}{}", register.before, written(word.value, &register.format))
}

pub(crate) fn queue_modal(channel: &mut ChannelContext<'_>, group: u16) {
    if let Some(index) = channel.state.modal.row(group) {
        let row = &channel.env.machine.codes[index];
        let value = match row.form {
            CodeForm::RegisterAsData { min, .. } => min,
            _ => 0.0,
        };
        channel.block.queue(index, row, value, true);
    }
}

/// Value that a code hands over as data.
#[inline]
pub fn data_of_code(machine: &Machine, row: &CodeRow, pending: PendingCode) -> Option<Handed> {
    match row.form {
        CodeForm::RegisterAsData { register, data, .. } => {
            let raw = pending.value * row.mul + row.add;
            Some(Handed { id: data, raw, row: row_of_handed(machine, data, register) })
        }
        _ => None,
    }
}

/// The row that a value of a code passes: that of its register, or one that has none.
fn row_of_handed(machine: &Machine, data: DataId, register: RegisterId) -> Option<DataRowId> {
    let of = |wanted| machine.tables.data(data).iter().copied().find(|&row| machine.data[row].register == wanted);
    of(Some(register)).or_else(|| of(None))
}
