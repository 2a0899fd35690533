//! Words and text of a block that nothing recognises.
//!
//! Facts: reference control-emulator.md 2.2 step 12 (the emulated system diagnoses the remaining text and continues);
//! fanuc-variables-and-alarms.md 3 (PS0009, PS0010: no part of the block acts); siemens-cycles.md 6 (12470, 12550).
//! Decision: `[control] unknown_code` selects one of the two. *Invariant:* where they are alarms, no part of the block
//! has acted, unless a macro after the block may still recognise its text.

use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::text;
use counterpoint_channel::unknown_words::{
    is_code_word, is_letter, is_word_like, moves_by_itself, shortened, unknown_parts, words_needed,
};
use counterpoint_control_api::Unknown;
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, DiagnosticFacts};
use counterpoint_machine::ident::codes;
use counterpoint_machine::macros::model::Hook;
use counterpoint_machine::rows::CodeForm;
use counterpoint_program::block::irregular;
use counterpoint_program::letter_zero::letter_for_zero;
use rustc_hash::FxHashSet;

use super::Kernel;
use crate::channel::components::Components;
use crate::channel::dialect_state::DialectState;
use crate::channel::unknown_codes::{lacks_code, remedy_for};

impl Kernel<'_> {
    /// Checks for unknown text before anything of the block acts.
    #[inline(always)]
    pub(crate) fn check_known(&mut self) -> Acted {
        if self.channel.block.has_remarks() { self.report_remarks() } else { self.channel.check_stop() }
    }

    #[cold]
    fn report_remarks(&mut self) -> Acted {
        self.check_numbers()?;
        if self.channel.block.unrecognised.is_empty() { self.channel.check_stop() } else { self.unknown_before() }
    }

    /// Numbers that a control refuses at their address; on other machines they are read as they are.
    pub(super) fn check_numbers(&mut self) -> Acted {
        let kinds = [
            (irregular::DIGITS, &diag::TOO_MANY_DIGITS, "a number has more digits than its address allows"),
            (irregular::POINT, &diag::DECIMAL_POINT, "a number has a decimal point at an address that takes none"),
            (irregular::SIGN, &diag::MINUS_SIGN, "a value is negative at an address that takes no sign"),
        ];
        for (bit, facts, what) in kinds {
            if self.channel.block.flags.irregular & bit != 0 && self.channel.env.machine.is_alarm(facts) {
                let text = format!("{what} in '{}'; no part of the block acts", self.channel.block_text());
                return Err(self.alarm(facts, text));
            }
        }
        Ok(())
    }

    #[cold]
    fn unknown_before(&mut self) -> Acted {
        self.channel.check_stop()?;
        let unknown = unknown_parts(&mut self.channel);
        // A macro after the block may take text, but no word.
        let later = self.macros.ready(Hook::BlockShutdown).is_some();
        let code = unknown.iter().find(|text| is_code_word(&self.channel, text)).cloned();
        let first = unknown.into_iter().next().filter(|_| !later);
        if self.channel.env.machine.habits.unknown_alarms {
            let Some(what) = code.or(first) else { return Ok(()) };
            let (facts, why) = not_known(&self.channel, &self.dialect, &self.components, &what);
            let block = self.channel.block_text();
            let hint = letter_for_zero(&what, &block);
            let remedy = remedy_for(&self.channel, &self.components, facts, &what);
            return Err(self.alarm(facts, format!("{why} in '{block}'{hint}; no part of the block acts{remedy}")));
        }
        if let Some(code) = code {
            self.moves_all_the_same(&code);
        }
        Ok(())
    }

    /// Reports the unrecognised parts of the block that are not in `known`, without stopping the channel; `computed`:
    /// the block may have the words that its codes need.
    #[cold]
    pub fn report_unknown_parts(&mut self, known: &mut FxHashSet<String>, computed: bool) {
        let stopping = self.channel.reports.alarms.stopping;
        for part in unknown_parts(&mut self.channel) {
            if computed && words_needed(&self.channel, &shortened(&part)).is_some() {
                continue;
            }
            if !known.insert(part.clone()) {
                continue;
            }
            let block = self.channel.block_text();
            let hint = letter_for_zero(&part, &block);
            if self.channel.env.machine.habits.unknown_alarms {
                let (facts, why) = not_known(&self.channel, &self.dialect, &self.components, &part);
                let remedy = remedy_for(&self.channel, &self.components, facts, &part);
                self.diagnose(facts, format!("{why} in '{block}'{hint}{remedy}"));
            } else {
                self.report_unrecognised(&shortened(&part), format!("'{block}'{hint}"));
            }
        }
        self.channel.reports.alarms.stopping = stopping;
    }

    /// The emulated system lets the active motion code have the words of a block whose code it does not know. That is
    /// an error: on the control they mean something else.
    fn moves_all_the_same(&mut self, code: &str) {
        let moves = self.channel.block.has_any(self.channel.tables.registers.motion) && !moves_by_itself(&self.channel);
        let letter = code.bytes().next().and_then(|letter| self.channel.tables.scanner.register(letter));
        let motions = self
            .channel
            .env
            .machine
            .codes
            .iter()
            .filter(|row| row.id == codes::RAPID || row.id == codes::INTERP_LINEAR);
        let mut registers = motions.filter_map(|row| match row.form {
            CodeForm::Register { register, .. } | CodeForm::RegisterAsData { register, .. } => Some(register),
            _ => None,
        });
        if moves && registers.any(|register| letter.is_some_and(|(of, _)| of == register)) {
            let code = shortened(code);
            let text = format!("'{}' moves by the active motion code, {code} is not known", self.channel.block_text());
            self.diagnose(&diag::UNKNOWN_MOVES, text);
        }
    }

    /// The text that is unrecognised after all codes have acted.
    pub(crate) fn unknown_text(&mut self) -> Acted {
        let left = text::left_text(&self.channel);
        let text = shortened(&left.split_whitespace().collect::<Vec<_>>().join(" "));
        if text.is_empty() {
            return Ok(());
        }
        let block = self.channel.block_text();
        let hint = letter_for_zero(&text, &block);
        if self.channel.env.machine.habits.unknown_alarms {
            let (facts, why) = not_known(&self.channel, &self.dialect, &self.components, &text);
            let remedy = remedy_for(&self.channel, &self.components, facts, &text);
            return Err(self.alarm(facts, format!("{why} in '{block}'{hint}{remedy}")));
        }
        self.report_unrecognised(&text, format!("'{block}'{hint}"));
        Ok(())
    }
}

/// The control's alarm for unknown text.
fn not_known(
    channel: &ChannelContext<'_>,
    dialect: &DialectState,
    components: &Components<'_>,
    text: &str,
) -> (&'static DiagnosticFacts, String) {
    let text = shortened(text);
    let is_g = text.starts_with(['G', 'g']);
    let dialect = dialect.kind;
    if let Some(needs) = words_needed(channel, &text) {
        return (&diag::CODE_NEEDS, format!("{text} needs {needs} in its block"));
    }
    if is_code_word(channel, &text) {
        let lacks = lacks_code(channel, components, &text);
        // A machine with words of its own for it names its own alarm.
        let rule = channel.env.machine.diagnostics.rule(diag::UNKNOWN_CODE.number);
        let named = rule.is_some_and(|rule| rule.text.is_some());
        let why = match dialect.unknown_g_code().filter(|_| is_g && !named) {
            Some(alarm) => format!("{alarm}: {lacks}"),
            None => lacks,
        };
        return (&diag::UNKNOWN_CODE, why);
    }
    let kind = match () {
        () if is_word_like(&text) => Unknown::Word,
        () if is_letter(channel, &text) => Unknown::Address,
        () => Unknown::Text,
    };
    (&diag::UNKNOWN_TEXT, dialect.unknown_text(&text, kind))
}
