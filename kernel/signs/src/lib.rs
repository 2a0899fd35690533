//! Guesses the machine of a job from the text of its programs.
//!
//! The signs are data of the machines (`[signs]`, docs/machine-definition.md). A sign weighs for the machines that have
//! it and against all others, and the answer names the signs, so that a reader can judge the guess. *Invariant:*
//! comments are never evidence, and no machine is chosen by default: programs without signs, with signs that disagree,
//! or for a control that no machine has are refused.

mod block;
mod controls;
mod evidence;
mod judge;
mod pattern;
mod prose;

pub use evidence::{ExaminedProgram, has_program, searched_bytes};
pub use judge::guess;
pub use pattern::SignPattern;

/// Rows of a table of signs with their weights.
pub type Rows = Vec<(SignPattern, u32)>;

/// Highest weight of a sign.
pub const HEAVIEST: u32 = 9;

/// The signs of a machine.
#[derive(Debug, Clone, Default)]
pub struct Signs {
    /// The control, as messages name it ("a Siemens control"); machines of one control share its marks.
    pub control: String,
    /// Programs without a mark of any control are for this one.
    pub plain: bool,
    /// Marks of the control.
    pub marks: Rows,
    /// Codes at which channels wait for each other.
    pub waits: Rows,
    /// Commands to other channels, each with the number of channels that a machine must have for it.
    pub channels: Rows,
    /// Marks of controls that no machine has, by the name of the control.
    pub elsewhere: Vec<(String, Rows)>,
    /// Traits of the machine, each with its signs: `milling`, `turning`, `five axes`.
    pub traits: Vec<(String, Rows)>,
}

/// A machine that may be meant.
#[derive(Debug, Clone)]
pub struct MachineCandidate {
    /// Its name.
    pub name: String,
    /// Number of its channels.
    pub channels: usize,
    /// One file has the programs of all channels, in sections or under heads.
    pub whole_file: bool,
    /// First letters of the names of its axes.
    pub axes: Vec<char>,
    /// Its signs.
    pub signs: Signs,
}

/// A machine and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Guess {
    /// Name of the machine.
    pub machine: String,
    /// The heaviest signs with their places.
    pub why: String,
}
