//! Blocks that only control the flow of the program, kept by line.

use counterpoint_event::event::FileId;

/// Request of a kept block at its end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Leads {
    /// Nothing: the head of a program.
    On,
    /// A call of a program by its number.
    Call {
        /// The number.
        program: u32,
        /// Passes, at least 1.
        passes: u32,
    },
    /// The return from a subprogram.
    Return,
}

/// A kept block.
#[derive(Debug, Clone, Copy)]
pub struct KnownBlock {
    /// Its place.
    pub line: (FileId, u32),
    /// It was kept while the blocks of a contour were read.
    pub of_contour: bool,
    /// Its request.
    pub leads: Leads,
    /// Its sequence number.
    pub sequence: Option<u32>,
}

/// Blocks by line: those that were met last.
#[derive(Debug, Default)]
pub struct KnownBlocks(pub [Option<KnownBlock>; 32]);

impl KnownBlocks {
    /// The block of a line, if it is kept.
    #[inline(always)]
    pub fn get(&self, line: (FileId, u32)) -> Option<&KnownBlock> {
        let known = self.0.get(line.1 as usize % self.0.len())?.as_ref()?;
        (known.line == line).then_some(known)
    }
}
