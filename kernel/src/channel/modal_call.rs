//! Modal macro calls: blocks call a macro until G67.
//!
//! Facts: reference control-emulator.md 5.4. Decisions: G66 calls behind every block that moves, with the arguments of
//! its own block; G66.1 calls with the words of every block, which does nothing else; inside a macro that was called
//! with arguments nothing calls, unless it says so itself; subprograms called by M98 go on calling.

use super::Kernel;
use super::flow::Callee;
use super::flow::Pending;
use super::word_calls::By;
use crate::state::block::Word;

/// Calls once.
const CALL: f64 = 65.0;
/// Calls behind blocks that move.
const CALL_MOVES: f64 = 66.0;
/// Calls with the words of every block.
const CALL_EACH: f64 = 66.1;
/// Ends modal calls.
pub(crate) const END_CALLS: f64 = 67.0;

/// A macro that blocks call.
#[derive(Debug)]
pub(crate) struct ModalCall {
    pub(crate) what: Callee,
    pub(crate) passes: u32,
    pub(crate) arguments: Vec<(u8, f64)>,
    /// Every block calls, with its own words.
    pub(crate) each: bool,
    /// Macro calls that were going on when it was said.
    pub(crate) level: usize,
    /// The word that said it, if that calls by itself.
    pub(crate) by: Option<By>,
}

impl Kernel<'_> {
    /// A G word of the pre-processor that calls macros; the one that ends modal calls does so at once.
    #[cold]
    pub(crate) fn calls_by(&mut self, value: f64) -> bool {
        if !self.plan.scanner.has_macros() {
            return false;
        }
        if value == END_CALLS {
            self.flow.modal_call = None;
        }
        [CALL, CALL_MOVES, CALL_EACH, END_CALLS].contains(&value)
    }

    /// How a G word calls: `None` for none, else whether it is modal, and for each block.
    pub(crate) fn way_of_call(value: f64) -> Option<(bool, bool)> {
        let modal = value == CALL_MOVES || value == CALL_EACH;
        (modal || value == CALL).then_some((modal, value == CALL_EACH))
    }

    /// A G word of the block calls by the pre-processor itself.
    pub(crate) fn has_own_call(&self) -> bool {
        let is_call =
            |word: &Word| Some(word.register) == self.plan.registers.g && Self::way_of_call(word.value).is_some();
        self.channel.block.words.iter().any(is_call)
    }

    /// Macro calls that are going on.
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
            // The macro that has said it is over.
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
