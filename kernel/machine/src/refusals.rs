//! Blocks that a control refuses with an alarm of its own: words that cannot be in one block, missing words, values out
//! of range, words that an active state forbids.
//!
//! Facts: reference fanuc-variables-and-alarms.md 3. Invariant: a row has a code or a register that it looks for, so a
//! block that has neither costs nothing.

use super::ident::CodeId;
use crate::index::RegisterId;

/// A rule of the control: it refuses a block for which all that the row says is true.
#[derive(Debug, Clone, PartialEq)]
pub struct BlockRefusal {
    /// Name of the row.
    pub name: String,
    /// Number of the alarm as the control shows it.
    pub alarm: String,
    /// The description of the alarm.
    pub text: String,
    /// One of these codes is in the block; empty: any block.
    pub codes: Vec<CodeReference>,
    /// The code counts also where it acts without being written, in a block without other codes.
    pub implied: bool,
    /// One of these registers is in the block, bit by register; 0: any block.
    pub with: u128,
    /// All of these registers are in the block, bit by register.
    pub all: u128,
    /// None of these registers is in the block, bit by register.
    pub without: u128,
    /// One of these codes is also in the block; empty: any block.
    pub together: Vec<CodeReference>,
    /// None of these codes is in the block.
    pub unless: Vec<CodeReference>,
    /// One of these codes is active when the block begins, and the block makes no other of its group active.
    pub active: Vec<Active>,
    /// None of these codes is.
    pub inactive: Vec<Active>,
    /// The word of a register is not as it should be.
    pub word: Option<WordRule>,
    /// Line in `file` where the row is.
    pub line: u32,
    /// File of the row.
    pub file: String,
}

/// A code as a row names it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CodeReference {
    /// By its identifier, however it is written.
    Id(CodeId),
    /// By its word, or a range of words.
    Word {
        /// Index into the registers.
        register: RegisterId,
        /// Smallest value.
        min: f64,
        /// Largest value.
        max: f64,
    },
}

/// A code of a modal group.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Active {
    /// Its group.
    pub group: u16,
    /// The code.
    pub id: CodeId,
}

/// Requirement for a word; the rule refuses a block whose word does not meet it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WordRule {
    /// Index into the registers.
    pub register: RegisterId,
    /// Smallest value as written.
    pub min: f64,
    /// Largest value as written.
    pub max: f64,
    /// It is refused where it is zero.
    pub zero: bool,
    /// It is a whole number.
    pub whole: bool,
    /// It may be written with a decimal point.
    pub pointed: bool,
    /// Most words of the register in one block.
    pub most: Option<u8>,
}
