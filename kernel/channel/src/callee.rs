//! Targets of calls and jumps.

use std::sync::Arc;

use counterpoint_control_api as dialect;
use counterpoint_event::event::StopCode;
use counterpoint_motion::turning::strip::Strip;
use rustc_hash::FxHashMap;

use crate::calling_words::CallingWord;
use crate::figure::CopiedFigure;
use crate::turning::ContourCycle;

/// The next step after the current block.
#[derive(Debug, Clone, PartialEq)]
pub enum Pending {
    /// Call a subprogram.
    Call {
        /// Which one.
        what: Callee,
        /// Passes, at least 1.
        passes: u32,
        /// Arguments of a macro call by variable number.
        arguments: Option<Vec<(u8, f64)>>,
        /// The word that calls, if it does so by itself.
        by: Option<Box<CallingWord>>,
    },
    /// Call a program whose passes are copies of a figure.
    Figure {
        /// Number of the program.
        program: u32,
        /// Passes, at least 1.
        passes: u32,
        /// The figure.
        figure: Box<CopiedFigure>,
    },
    /// Call the blocks from one sequence number or label to another.
    CallRange {
        /// Which ones.
        what: Callee,
        /// Passes, at least 1.
        passes: u32,
    },
    /// Call a text that the pre-processor has found.
    CallText(Box<dialect::SubprogramCall>),
    /// A cycle along contour blocks of the program.
    Contour(Box<ContourCycle>),
    /// Run a text whose moves are a contour.
    ReadContour(Box<dialect::SubprogramCall>),
    /// Remove stock along the contour that was read.
    Strip(Box<Strip>),
    /// Pass the data blocks that follow.
    DataBlocks,
    /// Return, optionally to a sequence number of the caller.
    Return(Option<u32>),
    /// End of the program.
    End(StopCode),
}

impl Pending {
    /// Whether it calls a subprogram.
    pub fn calls(&self) -> bool {
        matches!(self, Self::Call { .. } | Self::Figure { .. } | Self::CallRange { .. } | Self::CallText(_))
    }
}

/// Printing statements of the program.
#[derive(Debug, Default)]
pub struct Printing {
    /// Between POPEN and PCLOS.
    pub open: bool,
    /// Output outside them has been reported.
    pub closed_reported: bool,
}

/// The callee.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Callee {
    /// A program by its number, 0 for the main program.
    Program(u32),
    /// A program by its number, from a sequence number on.
    ProgramFrom(u32, u32),
    /// A program by its name.
    Named(Arc<str>),
    /// Blocks from one sequence number to another.
    Blocks(u32, u32),
    /// Blocks from a sequence number to the return.
    From(u32),
    /// Blocks from one label to another.
    Labels(u32, u32),
}

impl std::fmt::Display for Callee {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Callee::Program(number) => write!(f, "subprogram {number}"),
            Callee::ProgramFrom(number, first) => write!(f, "subprogram {number} from N{first}"),
            Callee::Named(name) => write!(f, "subprogram <{name}>"),
            Callee::Blocks(first, last) => write!(f, "the range N{first} to N{last}"),
            Callee::From(first) => write!(f, "the blocks from N{first}"),
            Callee::Labels(first, last) => write!(f, "the range from label {first} to label {last}"),
        }
    }
}

/// Lines of a file by label, ascending.
pub type Labels = FxHashMap<u32, Vec<u32>>;
