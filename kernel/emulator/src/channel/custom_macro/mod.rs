//! Macro calls of custom macro: by G65, G66 and G66.1, by codes that the machine names, and by every block.
//!
//! Facts: reference control-emulator.md 5.4. *Invariant:* the dialect knows the G words that call, and the interpreter
//! reads the words of a call; the effect of the calls on the flow of the program is here.

mod call;
pub mod code_calls;
pub(crate) mod modal;
