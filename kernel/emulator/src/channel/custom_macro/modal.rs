//! Modal macro calls: blocks call a macro until G67.
//!
//! Facts: reference control-emulator.md 5.4. Decisions: G66 calls after every block that moves, with the arguments of
//! its own block; G66.1 calls with the words of every block, which does nothing else; inside a macro that was called
//! with arguments no block calls, unless that macro contains G66 itself; subprograms called by M98 continue calling.

use super::code_calls::By;
use crate::channel::Kernel;
use crate::channel::flow::Callee;
use crate::channel::flow::Pending;
use counterpoint_dialect::MacroCall;
use counterpoint_program::block::Word;

/// A macro that blocks call.
#[derive(Debug)]
pub(crate) struct ModalCall {
    pub(crate) what: Callee,
    pub(crate) passes: u32,
    pub(crate) arguments: Vec<(u8, f64)>,
    /// Every block calls, with its own words.
    pub(super) each: bool,
    /// Macro calls that were running when it was made.
    pub(super) level: usize,
    /// The word that made it, if that calls by itself.
    pub(super) by: Option<By>,
}

impl Kernel<'_> {
    /// A G word of the dialect that calls macros, which a block without a code for it may have; the one that ends modal calls
    /// does so at once.
    #[cold]
    pub(crate) fn macro_call_of(&mut self, g: f64) -> Option<MacroCall> {
        let call = self.dialect.kind.macro_call(g);
        if call == Some(MacroCall::End) {
            self.flow.modal_call = None;
        }
        call
    }

    /// A G word of the block calls by itself.
    pub(super) fn has_own_call(&self) -> bool {
        let calls = |value| self.dialect.kind.macro_call(value).is_some_and(|call| call != MacroCall::End);
        let is_call = |word: &Word| Some(word.register) == self.plan.registers.g && calls(word.value);
        self.channel.block.words.iter().any(is_call)
    }

    /// Macro calls that are running.
    pub(crate) fn call_level(&self) -> usize {
        self.flow.frames.iter().filter(|frame| frame.own_variables).count()
    }

    /// The words of this block are the arguments of a modal call.
    #[inline(always)]
    pub(crate) fn calls_each_block(&self) -> bool {
        self.flow.modal_call.is_some() && self.is_argument_block()
    }

    #[cold]
    fn is_argument_block(&self) -> bool {
        let level = self.call_level();
        self.flow.modal_call.as_deref().is_some_and(|call| call.each && call.level == level)
            && !self.channel.block.words.is_empty()
    }

    /// Calls behind a block that has moved.
    #[cold]
    pub(crate) fn call_modally(&mut self) {
        let level = self.call_level();
        let Some(call) = self.flow.modal_call.as_deref() else { return };
        if call.level > level {
            // The macro that made it has ended.
            self.flow.modal_call = None;
            return;
        }
        if call.each || call.level != level || !self.channel.block.flags.moved {
            return;
        }
        let (what, passes) = (call.what.clone(), call.passes);
        let (arguments, by) = (Some(call.arguments.clone()), call.by.map(Box::new));
        self.channel.block.flags.moved = false;
        self.flow.pending = Some(Pending::Call { what, passes, arguments, by });
    }
}
