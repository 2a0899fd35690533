//! The state of the current block that macros read and change.
//!
//! *Invariant:* a block within another one has a context of its own; the outer one comes back as it was.

use std::sync::Arc;

use counterpoint_machine::ident::{CodeId, DataId};

/// The block in process, beyond its words.
#[derive(Debug, Default)]
pub struct BlockContext {
    /// Text if it is not the line of the file.
    pub text: Option<Arc<String>>,
    /// The words that the pre-processor left of the block, as text.
    pub left: Option<Arc<String>>,
    /// Text in place of unrecognised text, if a macro has set it.
    pub unrecognised: Option<Arc<String>>,
    /// The pre-processor has worked on it: text that it removes is gone.
    pub preprocessed: bool,
    /// The pre-processor has made its words, or has left its text.
    pub made: bool,
    /// Level of its first mark of block skip, if the machine has data for that.
    pub mark: Option<u8>,
    /// `$CECODE`
    pub code: Option<CodeId>,
    /// A data macro has removed a needed value.
    pub withheld: Option<Withheld>,
}

/// A value that a data macro has removed.
#[derive(Debug, Clone, Copy)]
pub struct Withheld {
    /// Its data.
    pub id: DataId,
    /// Index of the macro.
    pub code: u16,
    /// Diagnostics of the channel before.
    pub diagnostics: u32,
}

impl BlockContext {
    /// Makes another text the block: a line of the file, or a block that EXEC issued.
    pub fn begin(&mut self, text: Option<Arc<String>>) {
        (self.text, self.left, self.unrecognised, self.made) = (text, None, None, false);
    }

    /// The context of a block within this one, which is returned.
    pub fn enter(&mut self) -> Self {
        let inner = Self { preprocessed: self.preprocessed, made: self.made, mark: self.mark, ..Self::default() };
        std::mem::replace(self, inner)
    }

    /// Sets `$CECODE`; returns its value before.
    pub fn set_code(&mut self, id: Option<CodeId>) -> Option<CodeId> {
        std::mem::replace(&mut self.code, id)
    }
}
