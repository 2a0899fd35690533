//! Words with values that an interpreter leaves in its block.
//!
//! *Invariant:* a word has the place of the text from which it is made, so diagnostics quote the text of the program.

use std::borrow::Cow;

use crate::host::Words;

/// Start and end of a part of a block.
pub(crate) type Span = (u32, u32);

/// Makes a span of the start and the end of a part.
pub(crate) fn span(start: usize, end: usize) -> Span {
    (start as u32, end as u32)
}

/// The text at a place.
pub(crate) fn part(text: &[u8], (start, end): Span) -> Cow<'_, str> {
    String::from_utf8_lossy(text.get(start as usize..end as usize).unwrap_or_default())
}

/// A word with a value, as it is `spelled` or computed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Valued<'a> {
    pub(crate) name: &'a str,
    pub(crate) value: f64,
    pub(crate) spelled: Option<&'a str>,
    pub(crate) span: Span,
}

impl Valued<'_> {
    /// Adds the word to the block; false if no register of the machine has its name.
    pub(crate) fn push<W: Words + ?Sized>(&self, words: &mut W) -> bool {
        let register = words.register_named(self.name);
        if let Some(register) = register {
            words.push_value(register, self.value, self.spelled, self.span);
        }
        register.is_some()
    }
}
