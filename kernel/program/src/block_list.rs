//! Blocks of words that an interpreter leaves for one block of the program.
//!
//! *Invariant:* a block that is filled from the list has exactly the words that the list took off it. A cycle leaves
//! hundreds of thousands of blocks, so they share their memory.

use crate::block::{Block, Word};
use crate::line_up::LineUp;
use counterpoint_machine::index::CodeRowId;

/// Words whose memory is kept for the next block of the program.
const MOST_KEPT: usize = 1000;

/// Where the parts of a block end, and its properties as a whole.
#[derive(Debug, Clone, Copy)]
struct BlockBoundary {
    words: usize,
    texts: usize,
    unrecognised: usize,
    text: usize,
    sequence: Option<u32>,
    irregular: u8,
    line_up: Option<LineUp>,
}

/// Blocks, one after another.
#[derive(Debug, Default)]
pub struct BlockList {
    words: Vec<Word>,
    texts: Vec<CodeRowId>,
    unrecognised: Vec<(u32, u32)>,
    text: String,
    ends: Vec<BlockBoundary>,
}

impl BlockList {
    /// Forgets all blocks.
    pub fn clear(&mut self) {
        self.words.clear();
        self.texts.clear();
        self.unrecognised.clear();
        self.text.clear();
        self.ends.clear();
    }

    /// An empty list; the memory of many blocks is not kept.
    pub fn emptied(mut self) -> Self {
        if self.words.capacity() > MOST_KEPT {
            return Self::default();
        }
        self.clear();
        self
    }

    /// Whether there is no block.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Number of blocks.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Takes the words of a block with their text.
    pub fn push(&mut self, block: &mut Block, text: &mut String) {
        self.words.append(&mut block.words);
        self.texts.append(&mut block.texts);
        self.unrecognised.append(&mut block.unrecognised);
        self.text.push_str(text);
        text.clear();
        self.ends.push(BlockBoundary {
            words: self.words.len(),
            texts: self.texts.len(),
            unrecognised: self.unrecognised.len(),
            text: self.text.len(),
            sequence: block.sequence,
            irregular: block.flags.irregular,
            line_up: block.line_up,
        });
        block.clear();
    }

    /// Fills a block and its text with those of a place.
    pub fn fill(&self, at: usize, block: &mut Block, text: &mut String) {
        block.clear();
        text.clear();
        let Some(ended) = self.ends.get(at) else { return };
        let begun = at.checked_sub(1).and_then(|before| self.ends.get(before));
        let [words, texts, unrecognised, from] =
            begun.map_or([0; 4], |begun| [begun.words, begun.texts, begun.unrecognised, begun.text]);
        block.words.extend_from_slice(self.words.get(words..ended.words).unwrap_or_default());
        block.texts.extend_from_slice(self.texts.get(texts..ended.texts).unwrap_or_default());
        block
            .unrecognised
            .extend_from_slice(self.unrecognised.get(unrecognised..ended.unrecognised).unwrap_or_default());
        text.push_str(self.text.get(from..ended.text).unwrap_or_default());
        (block.sequence, block.line_up) = (ended.sequence, ended.line_up);
        block.flags.irregular = ended.irregular;
    }
}
