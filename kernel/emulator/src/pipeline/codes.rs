//! Stage *codes*: the rows that the words of a block match, and the loop that lets the codes act by order.
//!
//! Facts: reference control-emulator.md 1.2, 2.3, 3.1, 3.3.

use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::code_time::take_time;
use counterpoint_channel::conditions::{categorise_conditional, fits, fitting_text};
use counterpoint_channel::length_words::length_words;
use counterpoint_channel::modal::group;
use counterpoint_channel::queued_codes::{data_word, enter_code, group_queued, queue_modal, sort_codes, still_fires};
use counterpoint_control_api::MacroCall;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::CodeId;
use counterpoint_machine::number::written;
use counterpoint_machine::rows::{CodeForm, CodeRow};
use counterpoint_machine::{Machine, ident};
use counterpoint_program::block::{PendingCode, Word};

use crate::channel::Kernel;
use crate::channel::custom_macro::modal::macro_call_of;
use crate::channel::hook_points::BlockOrigin;
use crate::pipeline::implied::imply_motion;
use crate::pipeline::owned_words::{refuse_axis_words, take_axis_words};
use crate::pipeline::speed_words::speed_before_codes;
use counterpoint_channel::trace::{trace_code, trace_ignored};

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
            length_words(&mut self.channel);
        }
        imply(self);
        if let Some(hooks) = hooks {
            (hooks.codes.implied)(self);
        }
        self.check_refused()?;
        if self.channel.block.has_any(self.channel.tables.registers.before_codes) {
            words_before_codes(self)?;
        }
        sort_codes(&mut self.channel);
        while let Some(&pending) = self.channel.block.pending.get(self.channel.block.next) {
            self.channel.block.next += 1;
            fire(self, pending)?;
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
                    match macro_call_of(&mut self.flow, &self.dialect, word.value) {
                        Some(how) => {
                            call |= how != MacroCall::End;
                            self.channel.block.use_word(position);
                        }
                        None => data_word(&mut self.channel, position),
                    }
                }
                None => data_word(&mut self.channel, position),
                Some((index, row)) if row.with.is_empty() && row.without.is_empty() => {
                    self.channel.block.use_word(position);
                    self.channel.block.queue(index, row, word.value, false);
                }
                Some(_) => conditional = true,
            }
        }
        if conditional {
            categorise_conditional(&mut self.channel);
        }
        for index in 0..self.channel.block.texts.len() {
            if let Some(mut row) = self.channel.block.texts.get(index).copied() {
                if !fits(&self.channel.block, &machine.codes[row]) {
                    row = fitting_text(&self.channel, row);
                    if let Some(slot) = self.channel.block.texts.get_mut(index) {
                        *slot = row;
                    }
                }
                self.channel.block.queue(row, &machine.codes[row], 0.0, false);
            }
        }
        if self.channel.block.pending.len() > 1 && self.channel.tables.rules.exclusive.is_some() {
            last_of_groups(self);
        }
        if self.channel.block.pending.len() > 1 && machine.cycles.last_of_block {
            self.cycle_or_motion();
        }
        call
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
}

/// Words that act before the codes of their block.
#[inline(never)]
fn words_before_codes(kernel: &mut Kernel<'_>) -> Acted {
    if kernel.channel.block.has_any(kernel.channel.tables.registers.offsets) {
        offset_words(kernel)?;
    }
    if kernel.channel.block.has_any(kernel.channel.tables.registers.speed) {
        speed_before_codes(kernel)
    } else {
        Ok(())
    }
}

/// Numbers of offsets that no code of the block takes select their offsets.
fn offset_words(kernel: &mut Kernel<'_>) -> Acted {
    let takers = &kernel.channel.tables.rules.number_takers;
    let taken = kernel.channel.block.pending.iter().fold(0, |bits, pending| bits | takers[pending.row]);
    let free = kernel.channel.tables.registers.offsets & !taken;
    if kernel.channel.block.has_any(free) { (kernel.plan.actions.offset_words)(kernel, free) } else { Ok(()) }
}

/// Of several G codes of one group the last one acts.
#[inline(never)]
fn last_of_groups(kernel: &mut Kernel<'_>) {
    for position in 0..kernel.channel.block.words.len() {
        let Some((word, at, group)) = code_of_word(&kernel.channel, position) else { continue };
        let later = |at: usize| code_of_word(&kernel.channel, at).filter(|&(_, _, other)| other == group);
        let Some((last, ..)) = (position + 1..kernel.channel.block.words.len()).find_map(later) else { continue };
        kernel.channel.block.pending.remove(at);
        if last.value != word.value {
            let text = format!(
                "{} has no effect: {} of the same group comes later in '{}'",
                word_text(kernel.channel.env.machine, word),
                word_text(kernel.channel.env.machine, last),
                kernel.channel.block_text()
            );
            kernel.diagnose(&diag::GROUP_TWICE, text);
        }
    }
}

/// Modal codes that fire without being written: motion by axis words, persistent codes, and the modal member of
/// a group that a non-modal code overrode on an earlier block.
#[inline(always)]
pub(crate) fn imply(kernel: &mut Kernel<'_>) {
    if kernel.channel.block.flags.special {
        drop_ignored(kernel);
    }
    if kernel.channel.block.has_any(kernel.channel.tables.registers.motion)
        && !group_queued(&kernel.channel, group::MOTION)
    {
        imply_motion(kernel.plan, &mut kernel.channel, &kernel.macros);
    }
    if kernel.channel.state.modal.refires.is_empty() {
        return;
    }
    for index in (0..kernel.channel.state.modal.refires.len()).rev() {
        let Some(&(group, forever)) = kernel.channel.state.modal.refires.get(index) else { continue };
        if group_queued(&kernel.channel, group) {
            continue;
        }
        queue_modal(&mut kernel.channel, group);
        if !forever {
            kernel.channel.state.modal.refires.remove(index);
        }
    }
}

/// Words of axes that ignored codes of the block ignore move nothing.
#[cold]
fn drop_ignored(kernel: &mut Kernel<'_>) {
    for at in 0..kernel.channel.block.pending.len() {
        let row = kernel.channel.block.pending.get(at).map(|pending| &kernel.channel.env.machine.codes[pending.row]);
        let row = row.filter(|row| !row.process);
        for &register in row.map_or(&[][..], |row| row.ignores.as_slice()) {
            kernel.channel.block.take(register);
        }
        if row.is_some_and(|row| row.owns_axes) {
            take_axis_words(kernel, |_, _| {});
        }
    }
}

/// Lets one code act.
pub(crate) fn fire(kernel: &mut Kernel<'_>, pending: PendingCode) -> Acted {
    kernel.channel.check_stop()?;
    let machine = kernel.channel.env.machine;
    let row = &machine.codes[pending.row];
    if pending.only_if_data_left && !still_fires(&kernel.channel, &kernel.macros, row.group) {
        return Ok(());
    }
    if !row.process {
        swallow(kernel, row, pending);
        return Ok(());
    }
    enter_code(&mut kernel.channel, row, pending);
    let result = match kernel.plan.hooks {
        Some(hooks) => (hooks.codes.act)(kernel, pending, row.id),
        None => perform(kernel, row, pending),
    };
    kernel.channel.acting.as_data = None;
    if row.owns_axes && result.is_ok() {
        refuse_axis_words(kernel, row, pending);
    }
    result
}

/// Treats a code that the machine recognises and ignores.
#[cold]
fn swallow(kernel: &mut Kernel<'_>, row: &CodeRow, pending: PendingCode) {
    trace_ignored(&mut kernel.channel, row.id);
    if row.seconds > 0.0 {
        take_time(&mut kernel.channel, row, pending);
    } else if let CodeForm::Register { register, .. } | CodeForm::RegisterAsData { register, .. } = row.form
        && Some(register) == kernel.channel.tables.registers.function
    {
        kernel.channel.reports.swallowed.note(pending.value);
    }
}

/// The built-in action of a code.
#[inline(always)]
pub fn perform(kernel: &mut Kernel<'_>, row: &CodeRow, pending: PendingCode) -> Acted {
    let result = match kernel.plan.action_of_row[pending.row] {
        Some(action) => {
            if kernel.channel.env.trace.is_some() {
                trace_code(&mut kernel.channel, row.id);
            }
            action.run(kernel, row, &pending)
        }
        None => {
            trace_ignored(&mut kernel.channel, row.id);
            without_action(kernel, row.id);
            Ok(())
        }
    };
    if row.seconds > 0.0 && result.is_ok() {
        take_time(&mut kernel.channel, row, pending);
    }
    result
}

/// A code that nothing handles (reference control-emulator.md 2.3).
pub fn without_action(kernel: &mut Kernel<'_>, id: CodeId) {
    let name = kernel.channel.env.machine.code_name(id).to_owned();
    if name == "CODE_IGNORE" {
        return;
    }
    let documented_without = ident::code_facts(id).is_some_and(|facts| !facts.built_in);
    let text = kernel.channel.block_text();
    if documented_without {
        kernel.diagnose(
            &diag::CODE_WITHOUT_PROCESSING,
            format!("{} has no built-in processing and is ignored in '{text}'", name.to_lowercase()),
        );
    } else {
        kernel.diagnose(&diag::NO_ACTION, format!("{} has no action in '{text}'", name.to_lowercase()));
    }
}

/// The word at a position, the place of the code that it fires and the group in which only the last one acts.
fn code_of_word(channel: &ChannelContext<'_>, position: usize) -> Option<(Word, usize, u16)> {
    let word =
        channel.block.words.get(position).copied().filter(|word| Some(word.register) == channel.tables.registers.g)?;
    let rows = channel.env.machine.tables.code(word.register, word.value);
    let fired = |pending: &PendingCode| pending.value == word.value && rows.contains(&pending.row);
    let at = channel.block.pending.iter().position(fired)?;
    let group = channel
        .block
        .pending
        .get(at)
        .and_then(|pending| Some(channel.tables.rules.exclusive.as_ref()?[pending.row]))?;
    (group != 0).then_some((word, at, group))
}

/// A word as its register writes it.
pub(super) fn word_text(machine: &Machine, word: Word) -> String {
    let register = &machine.registers[word.register];
    format!("{}{}", register.before, written(word.value, &register.format))
}
