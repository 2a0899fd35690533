//! Modal macro calls: blocks call a macro until G67.
//!
//! Facts: reference control-emulator.md 5.4. Decisions: G66 calls after every block that moves; its block sets the
//! local variables, which the calls share. G66.1 calls with the words of every block, which has no other effect. Inside
//! a macro that was called with arguments no block calls, unless that macro contains G66 itself, or unless blocks
//! called it and there is a G66 before that one: then its blocks call the macro of that earlier G66. G67 ends the last
//! one; subprograms called by M98 continue calling. *Invariant:* a modal call ends with the macro that made it.

use counterpoint_control_api::MacroCall;
use counterpoint_program::block::{Block, Word};

use super::code_calls::CallingWord;
use crate::channel::Kernel;
use crate::channel::callee::{Callee, Pending};
use crate::channel::flow::ProgramFlow;

/// A macro that blocks call.
#[derive(Debug)]
pub struct ModalCall {
    pub what: Callee,
    pub(crate) passes: u32,
    /// Local variables of its macro: the arguments, and the values that the calls have left in them.
    pub(crate) arguments: Vec<(u8, f64)>,
    /// Every block calls, with its own words.
    pub(super) each: bool,
    /// Macro calls that were running when it was made.
    pub(super) level: usize,
    /// The word that made it, if that calls by itself.
    pub(super) by: Option<CallingWord>,
}

/// The active modal calls, the last one made at the end.
#[derive(Debug, Default)]
pub struct ModalCalls {
    calls: Vec<ModalCall>,
    /// The modal call that makes the next call.
    calling: Option<usize>,
}

/// Maximum number of active modal calls; a further call replaces the last one.
const MOST: usize = 64;

impl ModalCalls {
    pub(crate) fn is_empty(&self) -> bool {
        self.calls.is_empty()
    }

    pub(super) fn push(&mut self, call: ModalCall) {
        if self.calls.len() >= MOST {
            self.calls.pop();
        }
        self.calls.push(call);
    }

    /// Takes the last one away.
    pub fn pop(&mut self) -> Option<ModalCall> {
        self.calls.pop()
    }

    /// Which one makes the call that begins; none for other calls.
    pub(crate) fn take_caller(&mut self) -> Option<usize> {
        self.calling.take()
    }

    /// A call by one of them is over: the next call finds its variables unchanged. Only G66 sets arguments.
    pub(crate) fn keep(&mut self, caller: usize, variables: impl Iterator<Item = (u8, f64)>) {
        if let Some(call) = self.calls.get_mut(caller).filter(|call| !call.each) {
            call.arguments.clear();
            call.arguments.extend(variables);
        }
    }

    /// Trigger of the calls: 66 for every block that moves, 66.1 for every block; none without a modal call.
    pub(crate) fn word(&self) -> Option<f64> {
        self.calls.last().map(|call| if call.each { 66.1 } else { 66.0 })
    }

    /// Ends those of macros that have ended.
    pub(crate) fn leave(&mut self, level: usize) {
        self.calls.retain(|call| call.level <= level);
    }
}

impl Kernel<'_> {
    /// A G word of the dialect that calls macros, which a block without a code for it may have; the one that ends modal
    /// calls does so at once.
    #[cold]
    pub(crate) fn macro_call_of(&mut self, g: f64) -> Option<MacroCall> {
        let call = self.dialect.kind.macro_call(g);
        if call == Some(MacroCall::End) {
            self.flow.modal.pop();
        }
        call
    }

    /// Whether a G word of the block calls by itself.
    pub(super) fn has_own_call(&self) -> bool {
        let calls = |value| self.dialect.kind.macro_call(value).is_some_and(|call| call != MacroCall::End);
        let is_call = |word: &Word| Some(word.register) == self.plan.registers.g && calls(word.value);
        self.channel.block.words.iter().any(is_call)
    }
}

impl ProgramFlow {
    /// Macro calls that are running.
    pub(crate) fn call_level(&self) -> usize {
        self.frames.iter().filter(|frame| frame.own_variables).count()
    }

    /// The modal call that blocks make here.
    pub(super) fn acting_modal(&self) -> Option<usize> {
        let (calls, level) = (&self.modal.calls, self.call_level());
        if let Some(own) = calls.iter().rposition(|call| call.level == level) {
            return Some(own);
        }
        // In a macro that a modal call has called, the modal call before that one calls.
        let caller = self.frames.iter().rev().find(|frame| frame.own_variables)?.modal?;
        let before = caller.checked_sub(1)?;
        (calls.get(before)?.level == calls.get(caller)?.level).then_some(before)
    }

    /// The same, to look at.
    pub(super) fn modal_call(&self) -> Option<&ModalCall> {
        self.modal.calls.get(self.acting_modal()?)
    }

    /// The next call is one that blocks make without saying so.
    pub(super) fn call_is_modal(&mut self) {
        self.modal.calling = self.acting_modal();
    }

    /// Whether the words of a block are the arguments of a modal call.
    #[inline(always)]
    pub fn calls_each_block(&self, block: &Block) -> bool {
        !self.modal.is_empty() && self.is_argument_block(block)
    }

    #[cold]
    fn is_argument_block(&self, block: &Block) -> bool {
        self.modal_call().is_some_and(|call| call.each) && !block.words.is_empty()
    }

    /// Makes the modal call after a block that has moved.
    #[cold]
    pub(crate) fn call_modally(&mut self, block: &mut Block) {
        if !block.flags.moved {
            return;
        }
        let Some(call) = self.modal_call().filter(|call| !call.each) else { return };
        let (what, passes) = (call.what.clone(), call.passes);
        let (arguments, by) = (Some(call.arguments.clone()), call.by.map(Box::new));
        self.call_is_modal();
        block.flags.moved = false;
        self.pending = Some(Pending::Call { what, passes, arguments, by });
    }
}
