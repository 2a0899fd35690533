//! The rest of a block, gathered while its items are executed.
//!
//! *Invariant:* words that replace those of the block are without places.

use super::aims::Aims;
use super::places::Places;
use crate::host::Call;

/// The rest of a block.
#[derive(Debug, Default)]
pub(super) struct Left {
    /// Blocks that act before the words.
    pub(super) before: Vec<String>,
    pub(super) words: String,
    /// The parts of the words, and where they are from.
    pub(super) places: Places,
    pub(super) call: Option<Call>,
    pub(super) passes: Option<u32>,
    /// The word for passes, which is one of the block if nothing is called.
    pub(super) passes_word: Option<String>,
    /// An axis is programmed.
    pub(super) moves: bool,
    /// Words of the direction of the tool that the machine's tables do not know.
    pub(super) aims: Option<Box<Aims>>,
    /// G90 or G91 is in the block.
    pub(super) relative: Option<bool>,
    /// S of the block is a limit or a cutting speed.
    pub(super) speed_is_other: bool,
    /// Whether the block has SPOS.
    pub(super) oriented: bool,
    /// Axes that POS of the block moves, with their positions as the program counts.
    pub(super) beside: Vec<(String, f64)>,
}

impl Left {
    /// Nothing yet, with the G90 or G91 of another block.
    pub(super) fn counting_as(other: &Self) -> Self {
        Self { relative: other.relative, ..Self::default() }
    }

    /// Whether nothing is left.
    pub(super) fn is_empty(&self) -> bool {
        let Self { before, words, call, passes_word, aims, moves, beside, .. } = self;
        let nothing = before.is_empty() && words.is_empty() && beside.is_empty();
        nothing && call.is_none() && passes_word.is_none() && aims.is_none() && !moves
    }

    /// Other words in place of those of the block.
    pub(super) fn replace(&mut self, words: String) {
        self.words = words;
        self.places.replaced = true;
    }

    /// Takes the words to make others of them.
    pub(super) fn take_words(&mut self) -> String {
        self.places.replaced = true;
        std::mem::take(&mut self.words)
    }

    /// A word more.
    pub(super) fn add(&mut self, word: &str) {
        if !self.words.is_empty() {
            self.words.push(' ');
        }
        self.words.push_str(word);
    }
}
