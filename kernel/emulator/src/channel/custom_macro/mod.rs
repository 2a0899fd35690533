//! Macro calls of custom macro: by G65, G66 and G66.1, by codes that the machine names, and by every block.
//!
//! Facts: reference control-emulator.md 5.4. *Invariant:* which G words call is the dialect's, what the words of a call say is
//! the interpreter's; here is what the calls do to the flow of the program.

mod call;
mod code_calls;
mod modal;

pub(crate) use code_calls::{By, CodeCalls, CodeMacro, WordKind};
pub(crate) use modal::ModalCalls;
