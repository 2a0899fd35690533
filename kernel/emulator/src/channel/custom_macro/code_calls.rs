//! Words that call programs by themselves: G M T S B, as the machine says.
//!
//! Facts: reference control-emulator.md 5.4 (calls by G M T S B). A parameter of the control defines the call of each
//! word (O9010 by a G code, O9001 by an M code, O9000 by T with #149, and so on). They act before the code table sees
//! their word. Decisions: a word that calls a macro makes arguments of all other words; a subprogram is called after
//! the other words of the block have acted. In a program that a word has called, words of the same kind (G, or all
//! others) act as without the row, those of the other kind if the machine says so; after G66.1 words are arguments
//! only. Invariant: a machine without such words pays one test for each block.

use std::sync::Arc;

use counterpoint_channel::callee::{Callee, Pending};
use counterpoint_channel::calling_words::{CallingWord, CodeCalls, CodeMacro, WordKind};
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::flow::ProgramFlow;
use counterpoint_control_api::{MacroCall, NotThere};
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_machine::ident::data;
use counterpoint_machine::model::{CallHow, NestedCalls, WordCall};

use crate::channel::Kernel;
use crate::channel::custom_macro::modal::has_own_call;

impl Kernel<'_> {
    /// Takes the words off the block that call; true for a macro with the other words as arguments.
    #[cold]
    pub(crate) fn calls_by_code(&mut self) -> bool {
        let tables = self.channel.tables;
        let Some(calls) = tables.code_calls.as_deref() else { return false };
        let has_any = self.channel.block.words.iter().any(|word| calls.find(word.register, word.value).is_some());
        if !has_any || has_own_call(&self.channel, &self.dialect) || self.flow.calls_each_block(&self.channel.block) {
            return false;
        }
        if let Some((_, call, program, by)) = calling_word(&self.channel, &self.flow, calls, true) {
            let how = match call.how {
                CallHow::Moves => MacroCall::AfterMoves,
                CallHow::Blocks => MacroCall::EachBlock,
                CallHow::Macro | CallHow::Subprogram => MacroCall::Once,
            };
            let register = call.register;
            self.flow.code_macro = Some(Box::new(CodeMacro { register, program, how, by }));
            return true;
        }
        while let Some((at, call, program, by)) = calling_word(&self.channel, &self.flow, calls, false) {
            self.channel.block.words.remove(at);
            let letter = self.channel.env.machine.registers[call.register].name.as_str();
            let passes = if matches!(letter, "G" | "M") { self.repeat_word() } else { 1 };
            self.ask(Pending::Call { what: Callee::Program(program), passes, arguments: None, by: Some(Box::new(by)) });
        }
        false
    }

    /// Takes the repeat word off the block.
    fn repeat_word(&mut self) -> u32 {
        let source = self.channel.tables.sources_of(data::CALSUB_REPEAT).first();
        let at =
            source.and_then(|source| self.channel.block.words.iter().position(|word| word.register == source.register));
        let Some(at) = at else { return 1 };
        let count = self.channel.block.words.remove(at).value;
        self.passes(count).max(1)
    }

    /// Hands the value of the word over to the program that it calls.
    pub(crate) fn hand_over(&mut self, by: &CallingWord) -> Acted {
        match by.variable {
            Some(variable) => self.set_numbered(variable, by.value).map_err(|why| match why {
                NotThere::Halt(halt) => halt,
                NotThere::Missing | NotThere::ReadOnly | NotThere::TooBig => {
                    let text = format!("variable #{variable} cannot be written in '{}'", self.channel.block_text());
                    self.alarm(&diag::MACRO_VARIABLE, text)
                }
            }),
            None => Ok(()),
        }
    }
}

/// Whether a word of the block may call a program by itself, here or elsewhere.
#[cold]
pub(crate) fn calls_by_words(channel: &ChannelContext<'_>) -> bool {
    let Some(calls) = channel.tables.code_calls.as_deref() else { return false };
    channel.block.words.iter().any(|word| calls.find(word.register, word.value).is_some())
}

/// The first word that calls a macro, or a subprogram, and may do so here.
fn calling_word<'c>(
    channel: &ChannelContext<'_>,
    flow: &ProgramFlow,
    calls: &'c CodeCalls,
    arguments: bool,
) -> Option<(usize, &'c WordCall, u32, CallingWord)> {
    channel.block.words.iter().enumerate().find_map(|(at, word)| {
        let (call, program) = calls.find(word.register, word.value)?;
        let kind = if Some(word.register) == channel.tables.registers.g { WordKind::G } else { WordKind::Other };
        let fits = arguments == (call.how != CallHow::Subprogram) && may_call(channel, flow, kind);
        fits.then_some((at, call, program, CallingWord { kind, variable: call.variable, value: word.value }))
    })
}

/// Whether a word of this kind calls in the running program.
fn may_call(channel: &ChannelContext<'_>, flow: &ProgramFlow, kind: WordKind) -> bool {
    let mut callers = flow.frames.iter().filter_map(|frame| frame.by);
    match channel.env.machine.subprograms.nested {
        NestedCalls::OtherKind => callers.all(|caller| caller != kind),
        NestedCalls::Never => callers.next().is_none(),
    }
}

/// Takes the program name off the block.
pub fn take_name(channel: &mut ChannelContext<'_>) -> Option<Arc<str>> {
    let (start, end) = channel.block.take_name()?;
    let line = channel.text_bytes();
    let name = line.get(start as usize + 1..(end as usize).saturating_sub(1))?;
    Some(String::from_utf8_lossy(name).into())
}
