//! Words that an interpreter leaves of a block, kept while the block runs.

use crate::block::Block;
use crate::block_list::BlockList;
use std::sync::Arc;

/// The words that an interpreter leaves, beside those of the block.
#[derive(Debug, Default)]
pub struct LeftWords {
    /// Whether a trace or a macro may ask for the text of the words.
    pub asked: bool,
    /// The text of the words, if it may be asked for.
    pub text: String,
    /// The interpreter continues its block after these words have acted.
    pub continues: bool,
    /// Text of a block of several lines.
    pub joined: Option<Arc<[u8]>>,
    /// Blocks that precede the block of the kernel.
    pub blocks: BlockList,
}

impl LeftWords {
    /// Removes the words of the previous block.
    pub fn clear(&mut self, asked: bool) {
        self.asked = asked;
        self.text.clear();
        self.continues = false;
        self.joined = None;
        self.blocks.clear();
    }

    /// Takes the words off the block of the kernel: they act before the words that follow.
    pub fn end_block(&mut self, block: &mut Block) {
        self.blocks.push(block, &mut self.text);
    }

    /// Adds the text of words, if it may be needed.
    pub fn add(&mut self, text: impl FnOnce() -> String) {
        if self.asked {
            if !self.text.is_empty() {
                self.text.push(' ');
            }
            self.text.push_str(&text());
        }
    }
}
