//! Words and text of a block that nothing recognises.
//!
//! Facts: reference control-emulator.md 2.2 step 12 (the emulated system diagnoses the remaining text and continues);
//! fanuc-variables-and-alarms.md 3 (PS0009, PS0010: no part of the block acts); siemens-cycles.md 6 (12470, 12550).
//! Decision: `[control] unknown_code` selects one of the two. *Invariant:* where they are alarms, no part of the block
//! has acted, unless a macro after the block may still recognise its text.

use super::Kernel;
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::text;
use counterpoint_control_api::Unknown;
use counterpoint_fault::Acted;
use counterpoint_fault::{self as diag, DiagnosticFacts};
use counterpoint_machine::ident::codes;
use counterpoint_machine::macros::model::Hook;
use counterpoint_machine::rows::CodeForm;
use counterpoint_program::block::irregular;
use counterpoint_program::letter_zero::letter_for_zero;
use rustc_hash::FxHashSet;

/// Most characters of unknown text in a message.
const MOST: usize = 60;

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
        let unknown = self.unknown_parts();
        // A macro after the block may take text, but no word.
        let later = self.macros.ready(Hook::BlockShutdown).is_some();
        let code = unknown.iter().find(|text| self.is_code_word(text)).cloned();
        let first = unknown.into_iter().next().filter(|_| !later);
        if self.channel.env.machine.habits.unknown_alarms {
            let Some(what) = code.or(first) else { return Ok(()) };
            let (facts, why) = self.not_known(&what);
            let block = self.channel.block_text();
            let hint = letter_for_zero(&what, &block);
            let remedy = self.remedy(facts, &what);
            return Err(self.alarm(facts, format!("{why} in '{block}'{hint}; no part of the block acts{remedy}")));
        }
        if let Some(code) = code {
            self.moves_all_the_same(&code);
        }
        Ok(())
    }

    /// The unrecognised parts of the block, in their order.
    fn unknown_parts(&mut self) -> Vec<String> {
        self.left_name();
        let name = self.channel.block.name().filter(|_| calls_by_name(&self.channel));
        let line = self.channel.text_bytes();
        let spans = self.channel.block.unrecognised.iter().filter(|span| Some(**span) != name);
        let text = |&(start, end): &(u32, u32)| {
            let bytes = line.get(start as usize..end as usize).unwrap_or_default();
            String::from_utf8_lossy(bytes).trim().to_owned()
        };
        spans.map(text).collect()
    }

    /// Reports the unrecognised parts of the block that are not in `known`, without stopping the channel; `computed`:
    /// the block may have the words that its codes need.
    #[cold]
    pub fn report_unknown_parts(&mut self, known: &mut FxHashSet<String>, computed: bool) {
        let stopping = self.channel.reports.alarms.stopping;
        for part in self.unknown_parts() {
            if computed && self.needs(&shortened(&part)).is_some() {
                continue;
            }
            if !known.insert(part.clone()) {
                continue;
            }
            let block = self.channel.block_text();
            let hint = letter_for_zero(&part, &block);
            if self.channel.env.machine.habits.unknown_alarms {
                let (facts, why) = self.not_known(&part);
                let remedy = self.remedy(facts, &part);
                self.diagnose(facts, format!("{why} in '{block}'{hint}{remedy}"));
            } else {
                self.report_unrecognised(&shortened(&part), format!("'{block}'{hint}"));
            }
        }
        self.channel.reports.alarms.stopping = stopping;
    }

    /// Whether this is a word of a letter with which codes are written.
    fn is_code_word(&self, text: &str) -> bool {
        let letter = text.bytes().next().and_then(|letter| self.channel.tables.scanner.register(letter));
        let codes = letter.is_some_and(|(register, _)| self.channel.env.machine.tables.has_codes(register));
        codes && text.get(1..).is_some_and(|rest| rest.trim_start().starts_with(|c: char| c.is_ascii_digit()))
    }

    /// The control's alarm for unknown text.
    fn not_known(&self, text: &str) -> (&'static DiagnosticFacts, String) {
        let text = shortened(text);
        let is_g = text.starts_with(['G', 'g']);
        let dialect = self.dialect.kind;
        if let Some(needs) = self.needs(&text) {
            return (&diag::CODE_NEEDS, format!("{text} needs {needs} in its block"));
        }
        if self.is_code_word(&text) {
            let lacks = self.lacks(&text);
            // A machine with words of its own for it names its own alarm.
            let rule = self.channel.env.machine.diagnostics.rule(diag::UNKNOWN_CODE.number);
            let named = rule.is_some_and(|rule| rule.text.is_some());
            let why = match dialect.unknown_g_code().filter(|_| is_g && !named) {
                Some(alarm) => format!("{alarm}: {lacks}"),
                None => lacks,
            };
            return (&diag::UNKNOWN_CODE, why);
        }
        let kind = match () {
            () if is_word_like(&text) => Unknown::Word,
            () if self.is_letter(&text) => Unknown::Address,
            () => Unknown::Text,
        };
        (&diag::UNKNOWN_TEXT, dialect.unknown_text(&text, kind))
    }

    /// The words of which a code needs one, if the machine has the code only with another word.
    fn needs(&self, text: &str) -> Option<String> {
        let machine = self.channel.env.machine;
        let (register, _) = self.channel.tables.scanner.register(*text.as_bytes().first()?)?;
        let value = text.get(1..)?.trim().parse().ok()?;
        let rows = machine.tables.code(register, value).iter().map(|&row| &machine.codes[row]);
        let mut names: Vec<&str> = rows.flat_map(|row| &row.with).map(|&of| &*machine.registers[of].name).collect();
        names.sort_unstable();
        names.dedup();
        match names.split_last()? {
            (last, []) => Some((*last).to_owned()),
            (last, others) => Some(format!("{} or {last}", others.join(", "))),
        }
    }

    /// Whether this is an address alone.
    fn is_letter(&self, text: &str) -> bool {
        match text.as_bytes() {
            [letter] => self.channel.tables.scanner.register(*letter).is_some(),
            _ => false,
        }
    }

    /// The emulated system lets the active motion code have the words of a block whose code it does not know. That is
    /// an error: on the control they mean something else.
    fn moves_all_the_same(&mut self, code: &str) {
        let moves = self.channel.block.has_any(self.channel.tables.registers.motion) && !self.moves_by_itself();
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

    /// Whether a motion code is written in the block.
    fn moves_by_itself(&self) -> bool {
        self.group_queued(counterpoint_channel::modal::group::MOTION)
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
            let (facts, why) = self.not_known(&text);
            let remedy = self.remedy(facts, &text);
            return Err(self.alarm(facts, format!("{why} in '{block}'{hint}{remedy}")));
        }
        self.report_unrecognised(&text, format!("'{block}'{hint}"));
        Ok(())
    }
}

pub(super) fn shortened(text: &str) -> String {
    if text.chars().count() <= MOST {
        return text.to_owned();
    }
    text.chars().take(MOST - 3).chain("...".chars()).collect()
}

/// Whether a code of the block takes a program name.
fn calls_by_name(channel: &ChannelContext<'_>) -> bool {
    let mut rows = channel.block.pending.iter().map(|pending| &channel.env.machine.codes[pending.row]);
    rows.any(|row| row.id == codes::CALSUB_ID)
}

/// A letter and a number.
fn is_word_like(text: &str) -> bool {
    let rest = text.strip_prefix(|c: char| c.is_ascii_alphabetic()).map(str::trim_start);
    rest.is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | '+')))
}
