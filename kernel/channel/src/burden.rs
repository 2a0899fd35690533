//! The resources of a kernel besides time: memory of its job, and work within blocks.
//!
//! Invariants: every part is counted in the order of the program that makes it, or of the tags of shared operations, so
//! that whether a limit is reached depends on nothing else; a block that does the work of many counts as many.

use counterpoint_event::event::Event;
use counterpoint_results::timeline::bars::ActivityBar;
use counterpoint_results::toolpath::store::{Curve, PathMove};

/// Elements that a block may set or look at before it counts as one more.
pub const PER_BLOCK: u64 = 256;
/// Elements that a block within a block counts as.
pub const BLOCK: usize = PER_BLOCK as usize;
/// Elements between two looks at whether the job is to end.
pub const LOOK_EVERY: u64 = 4096;
/// Bytes of the text of a message or a diagnostic; the rest is cut off.
pub const LONGEST_TEXT: usize = 4096;

/// Bytes that a diagnostic or a stay takes besides its text.
pub const RESULT: usize = 256;

/// Bytes that an event takes at most: in the toolpath, as half of the block and the move with an arc that it mostly is;
/// as a bar; and while it waits.
pub const PATH: u64 = (size_of::<PathMove>() + size_of::<Curve>()) as u64 / 2;
/// Bytes of half an activity bar.
pub const BAR: u64 = size_of::<ActivityBar>() as u64 / 2;
/// Bytes of an event.
pub const EVENT: u64 = size_of::<Event>() as u64;

/// The use of a kernel.
#[derive(Debug, Clone, Copy, Default)]
pub struct Burden {
    /// Work within blocks, in elements.
    pub work: u64,
    /// Steps of macros.
    pub steps: u64,
    /// Bytes of diagnostics and of waits.
    pub results: u64,
}

impl Burden {
    /// Blocks that the work within blocks counts as.
    pub fn blocks(&self) -> u64 {
        self.work / PER_BLOCK
    }

    /// Counts bytes that stay in the results.
    pub fn result(&mut self, bytes: usize) {
        self.results += bytes as u64;
    }
}

/// A text without its part beyond [`LONGEST_TEXT`].
pub fn shortened(text: &str) -> &str {
    let mut end = text.len().min(LONGEST_TEXT);
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    text.get(..end).unwrap_or(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_text_is_cut_between_characters() {
        let text = "ä".repeat(LONGEST_TEXT);
        assert_eq!(shortened(&text).len(), LONGEST_TEXT);
        let text = format!("x{text}");
        assert_eq!(shortened(&text).len(), LONGEST_TEXT - 1);
    }
}
