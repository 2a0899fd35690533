//! Marks of waits and the rules that waits follow, by name.
//!
//! *Invariant:* the kernels and the coordinator of a job name the same mark and the same rule equally, whatever machine
//! or component they work with.

/// A family of marks: marks of two families never meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum MarkSpace {
    /// Numbers of statements, flags and signals.
    Statements,
    /// Numbers behind a letter.
    Letter(char),
    /// Coupled axes, by the code that couples them.
    Coupling(u16),
    /// Axes and spindles that channels exchange.
    Lease,
    /// Balance cutting.
    Balance,
    /// Numbers behind a word of `[[waits]]`, by the position of the first row with this word.
    Word(u16),
    /// Numbers of a row of `[[waits]]`, by its position.
    Row(u16),
}

/// The rule of a control that a wait follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum RuleId {
    /// The start of one head by the other.
    Start,
    /// A mark of both heads, by its position among their letters.
    Head(u16),
    /// A waiting code without a letter.
    Bare,
    /// Waiting codes of a letter, in upper case.
    Letter(char),
    /// A row of `[[waits]]`, by its position.
    Row(u16),
    /// A stage of balance cutting, by its position.
    Balance(u16),
    /// A code that couples axes, by its position.
    Coupling(u16),
}

/// The mark of a wait: equal keys belong together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct WaitMark {
    /// Which family of marks the number counts in.
    pub space: MarkSpace,
    /// Number of the mark.
    pub number: u32,
}

/// Marks with numbers from the first to the last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct MarkRange {
    /// Their family.
    pub space: MarkSpace,
    /// First number.
    pub first: u32,
    /// Last number.
    pub last: u32,
}
