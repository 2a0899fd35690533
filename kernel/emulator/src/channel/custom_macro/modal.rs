//! Modal macro calls: blocks call a macro until G67.
//!
//! Facts: reference control-emulator.md 5.4. Decisions: G66 calls after every block that moves; its block sets the
//! local variables, which the calls share. G66.1 calls with the words of every block, which has no other effect. Inside
//! a macro that was called with arguments no block calls, unless that macro contains G66 itself, or unless blocks
//! called it and there is a G66 before that one: then its blocks call the macro of that earlier G66. G67 ends the last
//! one; subprograms called by M98 continue calling. *Invariant:* a modal call ends with the macro that made it.

use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::flow::ProgramFlow;
use counterpoint_control_api::MacroCall;
use counterpoint_program::block::Word;

use crate::channel::dialect_state::DialectState;

/// A G word of the dialect that calls macros, which a block without a code for it may have; the one that ends modal
/// calls does so at once.
#[cold]
pub(crate) fn macro_call_of(flow: &mut ProgramFlow, dialect: &DialectState, g: f64) -> Option<MacroCall> {
    let call = dialect.kind.macro_call(g);
    if call == Some(MacroCall::End) {
        flow.modal.pop();
    }
    call
}

/// Whether a G word of the block calls by itself.
pub(super) fn has_own_call(channel: &ChannelContext<'_>, dialect: &DialectState) -> bool {
    let calls = |value| dialect.kind.macro_call(value).is_some_and(|call| call != MacroCall::End);
    let is_call = |word: &Word| Some(word.register) == channel.tables.registers.g && calls(word.value);
    channel.block.words.iter().any(is_call)
}
