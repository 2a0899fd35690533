//! Blocks that the control refuses by rules of the machine, looked at before anything of them acts.
//!
//! Facts: reference fanuc-variables-and-alarms.md 3; the rules are rows of the machine definition (`[[refusals]]`).
//! *Invariant:* a block without a code or register that a rule looks for costs one look at each of its codes.

use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::Machine;
use counterpoint_machine::index::RegisterId;
use counterpoint_machine::refusals::{Active, BlockRefusal, CodeReference, WordRule};
use counterpoint_machine::tables::form_range;
use counterpoint_program::block::{PendingCode, Word};
use counterpoint_program::refusal_rules::{NOTHING, WordCondition, bit};

use super::Kernel;

impl Kernel<'_> {
    /// Refuses the block if a rule of the machine says so; its codes are known, nothing has acted.
    #[inline(always)]
    pub(crate) fn check_refused(&mut self) -> Acted {
        if self.channel.block.present & self.channel.state.place.layout.bounds.foreign != 0 {
            self.foreign_axis()?;
        }
        let Some(refusals) = self.channel.tables.rules.refusals.as_deref() else { return Ok(()) };
        let looked = |pending: &PendingCode| refusals.rows[pending.row];
        let rules = self.channel.block.pending.iter().fold(0, |bits, pending| bits | looked(pending));
        let mut asleep = if self.channel.state.cycle.rigid == 0.0 { refusals.rigid } else { 0 };
        // A macro of the machine may take over such a code.
        if self.channel.state.place.frames.is_none() && self.plan.hooks.is_none() {
            asleep |= refusals.wrapped;
        }
        let rules = rules & !asleep;
        if rules != 0 || self.channel.block.present & refusals.registers != 0 {
            let (words, free) = refusals.looked_for(&self.channel.block);
            let rules = refusals.fitting((rules | free) & !asleep, words);
            if rules != 0 {
                return self.refused(rules, words);
            }
        }
        Ok(())
    }

    /// A word of an axis that the channel does not have; a code of the block may ignore it.
    #[cold]
    fn foreign_axis(&mut self) -> Acted {
        let machine = self.channel.env.machine;
        let rows = || self.channel.block.pending.iter().map(|pending| &machine.codes[pending.row]);
        let wrong = |register: RegisterId| {
            self.channel.state.place.layout.bounds.foreign & register.bit() != 0 && self.channel.block.has(register)
        };
        let exchanged = |register: RegisterId| {
            let layout = &self.channel.state.place.layout;
            let moves = |id| machine.tables.data_of_register[register].iter().any(|&row| machine.data[row].id == id);
            let own =
                layout.axes.entries().filter(|(slot, axis)| layout.exchanged & slot.bit() != 0 && moves(axis.data));
            own.fold(0, |slots, (slot, _)| slots | slot.bit())
        };
        let ignored = |register: RegisterId| rows().any(|row| row.ignores.contains(&register));
        let words = || self.channel.block.words.iter().filter(|word| wrong(word.register) && !ignored(word.register));
        let Some(word) = words().find(|word| exchanged(word.register) == 0) else {
            let slots = words().fold(0, |slots, word| slots | exchanged(word.register));
            return self.check_exchanged(slots);
        };
        let word = self.channel.span_text((word.start, word.end));
        let text = format!(
            "{} for {word} in '{}'; no part of the block acts",
            no_such_axis(&self.channel),
            self.channel.block_text()
        );
        Err(self.alarm(&diag::AXIS_NOT_IN_CHANNEL, text))
    }

    #[inline(never)]
    fn refused(&mut self, rules: u64, words: u128) -> Acted {
        let machine = self.channel.env.machine;
        let all = &machine.diagnostics.refusals;
        let mut own = rules & !bit(63);
        let rule = loop {
            if own == 0 {
                let last = if rules & bit(63) == 0 { &[][..] } else { all.get(63..).unwrap_or_default() };
                break last
                    .iter()
                    .find(|rule| WordCondition::of(rule).fit(words) && is_refused_by(&self.channel, rule));
            }
            let rule = all.get(own.trailing_zeros() as usize).filter(|rule| is_refused_by(&self.channel, rule));
            if rule.is_some() {
                break rule;
            }
            own &= own - 1;
        };
        let Some(rule) = rule else { return Ok(()) };
        let text =
            format!("{} {} in '{}'; no part of the block acts", rule.alarm, rule.text, self.channel.block_text());
        Err(self.alarm(&diag::REFUSED, text))
    }
}

/// Whether no rule can refuse the block, for any active codes.
pub(crate) fn is_block_never_refused(channel: &ChannelContext<'_>) -> bool {
    let Some(refusals) = channel.tables.rules.refusals.as_deref() else { return true };
    let block = &channel.block;
    let (words, free) = refusals.looked_for(block);
    let of_codes = block.pending.iter().fold(free, |bits, pending| bits | refusals.rows[pending.row]);
    let fitting = refusals.fitting(of_codes, words);
    let mut rules = channel.env.machine.diagnostics.refusals.iter().zip(0..63);
    fitting & bit(63) == 0
        && rules.all(|(rule, at)| {
            fitting & bit(at) == 0 || rule.word.as_ref().is_some_and(|word| !breaks_rule(channel, word))
        })
}

/// Whether a rule refuses the block, whose words are as it wants them.
#[inline]
fn is_refused_by(channel: &ChannelContext<'_>, rule: &BlockRefusal) -> bool {
    rule.word.as_ref().is_none_or(|word| breaks_rule(channel, word)) && has_state(channel, rule)
}

/// Whether the block's words of a register are not as the rule wants them.
fn breaks_rule(channel: &ChannelContext<'_>, rule: &WordRule) -> bool {
    let mut count = 0_usize;
    let mut wrong = false;
    for word in channel.block.words.iter().filter(|word| word.register == rule.register) {
        count += 1;
        let value = word.value;
        wrong |= value < rule.min || value > rule.max || rule.whole && value.fract() != 0.0;
        wrong |= rule.zero && value.abs() < NOTHING;
        wrong |= !rule.pointed && is_written_with_point(channel, word);
    }
    wrong || rule.most.is_some_and(|most| count > usize::from(most))
}

/// Whether the word is a number with a decimal point; a point within an expression does not count.
#[cold]
fn is_written_with_point(channel: &ChannelContext<'_>, word: &Word) -> bool {
    let text = channel.word_bytes(word);
    text.contains(&b'.') && !text.iter().any(|byte| matches!(byte, b'#' | b'['))
}

/// `channel 1 has no axis (its axes are X, Y and Z)`.
pub(crate) fn no_such_axis(channel: &ChannelContext<'_>) -> String {
    let machine = channel.env.machine;
    let axes = channel.state.place.layout.axes.entries();
    let letters: Vec<&str> = axes.map(|(_, axis)| machine.axes[axis.machine].letter.as_str()).collect();
    let letters = match letters.as_slice() {
        [] => "it has none".to_owned(),
        [one] => format!("its axis is {one}"),
        [first @ .., last] => format!("its axes are {} and {last}", first.join(", ")),
    };
    format!("channel {} has no axis ({letters})", channel.at.channel)
}

/// Whether a code of the block is one of the rule, and the active codes satisfy the rule.
fn has_state(channel: &ChannelContext<'_>, rule: &BlockRefusal) -> bool {
    let mut pending =
        channel.block.pending.iter().filter(|pending| rule.implied && !pending.only_if_data_left || !pending.modal);
    let trigger = pending.find(|pending| rule.codes.iter().any(|code| is_written(channel.env.machine, code, pending)));
    if trigger.is_none() && !rule.codes.is_empty() {
        return false;
    }
    let mut written = channel.block.pending.iter().filter(|pending| !pending.modal);
    let mut others = channel.block.pending.iter().filter(|pending| !pending.modal && Some(*pending) != trigger);
    if !rule.together.is_empty()
        && !others.any(|other| rule.together.iter().any(|c| is_written(channel.env.machine, c, other)))
    {
        return false;
    }
    if !rule.unless.is_empty()
        && written.any(|pending| rule.unless.iter().any(|c| is_written(channel.env.machine, c, pending)))
    {
        return false;
    }
    let was = |state: &Active| channel.state.modal.code(state.group) == Some(state.id);
    let stays = |state: &Active| was(state) && !is_ended(channel, state, trigger);
    (rule.active.is_empty() || rule.active.iter().any(stays)) && !rule.inactive.iter().any(was)
}

fn is_written(machine: &Machine, code: &CodeReference, pending: &PendingCode) -> bool {
    let row = &machine.codes[pending.row];
    match *code {
        CodeReference::Id(id) => row.id == id,
        CodeReference::Word { register, min, max } => {
            let own = form_range(&row.form).filter(|(own, ..)| *own == register);
            // An omitted value has the value of its row.
            own.is_some_and(|(_, first, _)| (min..=max).contains(if pending.modal { &first } else { &pending.value }))
        }
    }
}

/// Whether another code of the group of an active code is in the block.
fn is_ended(channel: &ChannelContext<'_>, state: &Active, trigger: Option<&PendingCode>) -> bool {
    let others = channel.block.pending.iter().filter(|pending| !pending.modal && Some(*pending) != trigger);
    let mut rows = others.map(|pending| &channel.env.machine.codes[pending.row]);
    rows.any(|row| row.group == state.group && row.id != state.id)
}
