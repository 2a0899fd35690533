//! The interface of a dialect to the rest of the kernel.
//!
//! Facts: reference control-emulator.md 5.4. *Invariant:* every difference between controls that comes from their
//! pre-processors is asked here or done by the [`Interpreter`]; nothing outside this module compares pre-processors.

use super::interpreter::{Interpreter, MacroCall};
use super::outline::OutlineReader;
use counterpoint_machine::Machine;
use counterpoint_program::syntax::Syntax;

/// The language of a control, for the parts of its programs that are not words.
pub trait Dialect: Sync {
    /// Name in machine definitions.
    fn name(&self) -> &'static str;

    /// Name in messages; in capitals the value of `$PREPROC`.
    fn title(&self) -> &'static str;

    /// The rules by which it reads program text.
    fn syntax(&self) -> &'static Syntax;

    /// Settings that `$FCEPP` can make, words joined by commas, besides those that all have.
    fn settings(&self) -> &'static [&'static str] {
        &[]
    }

    /// Whether the lead of a thread and the feed per revolution are the modal value of each other if they have the same
    /// address.
    fn lead_is_feed(&self) -> bool {
        false
    }

    /// Subprograms may be read as contours ([`super::host::FlowHost::read_contour`]).
    fn reads_contours(&self) -> bool {
        false
    }

    /// Number and title of the control's alarm for a G code that it does not have.
    fn unknown_g_code(&self) -> Option<&'static str> {
        None
    }

    /// The control's alarm about unknown text.
    fn unknown_text(&self, text: &str, _kind: Unknown) -> String {
        format!("{text} is not known to this control")
    }

    /// How a G word that the machine's code table does not have calls a macro.
    fn macro_call(&self, _g: f64) -> Option<MacroCall> {
        None
    }

    /// A new interpreter; none if plain words are all there is.
    fn interpreter(&self, _machine: &Machine) -> Option<Box<dyn Interpreter>> {
        None
    }

    /// Reads its blocks without executing them; none if it has no interpreter, or if the effect of its blocks is
    /// unknown.
    fn reader(&self, _machine: &Machine) -> Option<Box<dyn OutlineReader>> {
        None
    }

    /// An interpreter for a block within a block of its own, while the identification macro is asked. None if such
    /// blocks are dropped, because the interpreter has state besides the texts that it has read.
    fn nested(&self) -> Option<Box<dyn Interpreter>> {
        None
    }
}

/// Kind of a text that is neither a word of the machine nor a statement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unknown {
    /// An address and a number.
    Word,
    /// An address that the machine has, alone.
    Address,
    /// Anything else.
    Text,
}
