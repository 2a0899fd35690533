//! The rest of a block, gathered while its items are executed.
//!
//! *Invariant:* words that replace those of the block get their places when the block is left.

use super::aims::Aims;
use super::places::RemainderParts;
use counterpoint_control_api::host::SubprogramCall;

/// The rest of a block.
#[derive(Debug, Default)]
pub(super) struct SiemensRemainder {
    /// Blocks that act before the words.
    pub(super) before: Vec<String>,
    pub(super) words: String,
    /// The parts of the words, with their places in the block.
    pub(super) places: RemainderParts,
    pub(super) call: Option<SubprogramCall>,
    pub(super) passes: Option<u32>,
    /// The word for passes; without a call it stays a word of the block.
    pub(super) passes_word: Option<String>,
    /// Whether an axis is programmed.
    pub(super) moves: bool,
    /// Words of the direction of the tool that the machine's tables do not know.
    pub(super) aims: Option<Box<Aims>>,
    /// G90 or G91 of the block: whether positions are relative.
    pub(super) relative: Option<bool>,
    /// Whether S of the block is a limit or a cutting speed.
    pub(super) speed_is_other: bool,
    /// Whether the block has SPOS.
    pub(super) oriented: bool,
    /// Axes that POS of the block moves, with their positions as programmed.
    pub(super) beside: Vec<(String, f64)>,
}

impl SiemensRemainder {
    /// An empty rest with the G90 or G91 of another block.
    pub(super) fn counting_as(other: &Self) -> Self {
        Self { relative: other.relative, ..Self::default() }
    }

    /// Whether nothing is left.
    pub(super) fn is_empty(&self) -> bool {
        let Self { before, words, call, passes_word, aims, moves, beside, .. } = self;
        let nothing = before.is_empty() && words.is_empty() && beside.is_empty();
        nothing && call.is_none() && passes_word.is_none() && aims.is_none() && !moves
    }

    /// Replaces the words of the block.
    pub(super) fn replace(&mut self, words: String) {
        self.words = words;
        self.places.replaced = true;
    }

    /// Takes the words, which the caller replaces.
    pub(super) fn take_words(&mut self) -> String {
        self.places.replaced = true;
        std::mem::take(&mut self.words)
    }

    /// Appends a word.
    pub(super) fn add(&mut self, word: &str) {
        if !self.words.is_empty() {
            self.words.push(' ');
        }
        self.words.push_str(word);
    }
}
