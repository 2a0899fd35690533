//! Parts of a program, and the findings in them.

use counterpoint_program::spot::BlockStart;

use counterpoint_channel::callee::Callee;

/// Lines of the running program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ProgramRegion {
    pub(super) first: u32,
    pub(super) last: u32,
}

/// The last line before a block; its own where others are before it in the line.
pub(super) fn before(target: BlockStart) -> u32 {
    if target.offset > 0 { target.line } else { target.line.saturating_sub(1) }
}

/// The findings in a part.
pub(super) enum Looked {
    /// The part is clear; with the lines that its jumps add to it.
    Clear(ProgramRegion),
    /// Something is in this line.
    At(u32),
}

/// Known properties of a block besides its words.
#[derive(Debug, Clone, Copy)]
pub(super) struct Certain {
    /// It calls a program, to which its words are arguments.
    pub(super) calls: bool,
    /// It has words whose values are computed, so that a code may have the word that it needs.
    pub(super) computed: bool,
}

/// The effect of the words of a block.
pub(super) enum Meant {
    /// Nothing for the flow and for others.
    Nothing,
    /// They call this.
    Call(Callee),
    /// They end the program.
    End,
    /// They act on other channels, or their effect is computed.
    Meet,
}
