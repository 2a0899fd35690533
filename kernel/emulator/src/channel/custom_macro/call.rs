//! A macro call with its arguments.
//!
//! Facts: reference control-emulator.md 5.4. Decision: text that cannot be an argument is reported as left over.

use counterpoint_channel::callee::{Callee, Pending};
use counterpoint_channel::calling_words::CallingWord;
use counterpoint_channel::modal_calls::ModalCall;
use counterpoint_control_api::{MacroCall, WordHost};
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_program::block::irregular;

use crate::channel::Kernel;
use crate::channel::custom_macro::code_calls::take_name;
use crate::channel::hook_points::BlockOrigin;

impl Kernel<'_> {
    /// A block whose words are the arguments of a macro.
    pub fn macro_call(&mut self) -> Acted {
        let own = self.flow.code_macro.take();
        let word = own.as_deref().map(|call| (call.register, call.by.value));
        let (sources, file, line) = (self.channel.env.sources, self.channel.at.file, self.channel.at.line);
        let is_line = self.plan.hooks.is_none() && self.channel.text.edited.is_none();
        let held = (!is_line).then(|| self.channel.text_bytes().into_owned());
        let as_read = || sources.get(file).map_or(&[][..], |source| source.line(line));
        let text = held.as_deref().unwrap_or_else(as_read);
        self.channel.state.remembered.remember_sequence(self.channel.block.sequence);
        self.channel.block.clear();
        let words = self.with_interpreter(|interpreter, kernel| interpreter.arguments(kernel, text, word));
        let Some(mut words) = words.transpose()?.flatten() else { return Ok(()) };
        // Arguments are not words of their registers.
        self.channel.block.flags.irregular &= !irregular::NUMBERS;
        if words.call.is_some() {
            for (register, number) in [words.program_number, words.count_number].into_iter().flatten() {
                self.read(register, number);
            }
            self.check_numbers()?;
        }
        let mut by: Option<CallingWord> = None;
        let what = match own {
            Some(call) => {
                (words.call, by) = (Some(call.how), Some(call.by));
                Some(Callee::Program(call.program))
            }
            None if words.call.is_some() => match words.program {
                Some(p) if (1.0..=f64::from(u32::MAX)).contains(&p) => Some(Callee::Program(p as u32)),
                Some(_) => None,
                None => take_name(&mut self.channel).map(Callee::Named),
            },
            // A block that only gives the arguments: P and L are arguments, too.
            None => self.flow.modal_call().map(|call| call.what.clone()),
        };
        let Some(what) = what else {
            let text = format!("macro call without a program number P in '{}'", self.channel.block_text());
            return Err(self.alarm(&diag::MACRO_CALL, text));
        };
        let passes = match (words.call, words.count, self.flow.modal_call()) {
            (None, _, Some(call)) => call.passes,
            (_, Some(count), _) => self.passes(count).max(1),
            _ => 1,
        };
        let arguments = words.values;
        match words.call {
            Some(how @ (MacroCall::AfterMoves | MacroCall::EachBlock)) => {
                let each = how == MacroCall::EachBlock;
                let level = self.flow.call_level();
                self.flow.modal.push(ModalCall { what, passes, arguments, each, level, by });
            }
            how => {
                let by = by.map(Box::new);
                if how.is_none() {
                    self.flow.call_is_modal();
                }
                self.ask(Pending::Call { what, passes, arguments: Some(arguments), by });
            }
        }
        if self.channel.block.words.is_empty() {
            return self.leftovers();
        }
        // Words before the call act on their own.
        self.categorise();
        self.codes(BlockOrigin::Items)
    }
}
