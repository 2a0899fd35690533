//! Blocks as statements.
//!
//! Facts: Heidenhain pre-processor pages, programming manuals of the control. Conversational and ISO forms of a
//! statement are one. Invariant: a block that is not a statement consists of words; reading fails only for blocks that
//! start as a statement.

use counterpoint_control_api::statement::SharedStatement;

use super::formula::Formula;
use super::path_state::PathBlockKind;
use super::q_parameter::QParameter;
use super::words::HeidenhainWord;

/// Label of a place in the program.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) enum Label {
    Number(u32),
    Name(String),
}

impl std::fmt::Display for Label {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number(number) => write!(f, "LBL {number}"),
            Self::Name(name) => write!(f, "LBL \"{name}\""),
        }
    }
}

/// The condition of a branch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Test {
    Equal,
    NotEqual,
    Greater,
    Less,
}

/// Condition of a branch.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum BranchCondition {
    Compare(Formula, Test, Formula),
    /// The parameter has a value, or has none.
    Defined(QParameter, bool),
}

/// A statement.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum HeidenhainStatement {
    Nothing,
    Words(Vec<HeidenhainWord>),
    Assign(QParameter, Formula),
    /// Several parameters in a block, as those of a cycle are written.
    Parameters(Vec<HeidenhainWord>),
    Branch(BranchCondition, Formula),
    /// A statement that other controls have too, with its operands.
    Shared(&'static SharedStatement, Box<[Formula]>),
    /// FN 16: the mask and the target of the output.
    Print(String),
    /// FN 38: the text to send.
    Send(String),
    SysRead {
        to: QParameter,
        id: Formula,
        number: Formula,
        index: Option<Formula>,
    },
    SysWrite {
        id: Formula,
        number: Formula,
        index: Option<Formula>,
        value: Formula,
    },
    Label(Label),
    EndOfLabel,
    CallLabel {
        label: Formula,
        repeat: Option<Formula>,
    },
    CallProgram(Formula),
    SelectProgram(Formula),
    CallSelected,
    /// SEL PATTERN and SEL TABLE with the name of a table.
    SelectPoints(Formula),
    SelectDatums(Formula),
    /// SEL CONTOUR with the program that makes an area of contours.
    SelectContour(Formula),
    /// PRESET SELECT with the words after it.
    SelectPreset(Vec<HeidenhainWord>),
    Begin {
        iso: bool,
        inch: Option<bool>,
        words: Vec<HeidenhainWord>,
    },
    End,
    CycleDefinition(Vec<HeidenhainWord>),
    /// A line of a cycle of several lines: number, part, words after the title.
    CyclePart {
        cycle: u32,
        part: u32,
        words: Vec<HeidenhainWord>,
        text: String,
    },
    CycleCall {
        kind: CycleCallForm,
        words: Vec<HeidenhainWord>,
    },
    ToolCall {
        tool: Option<Formula>,
        words: Vec<HeidenhainWord>,
    },
    ToolDefinition {
        tool: Formula,
        words: Vec<HeidenhainWord>,
    },
    Stop(Vec<HeidenhainWord>),
    Path {
        shape: PathBlockKind,
        iso: bool,
        words: Vec<HeidenhainWord>,
    },
    /// The requests of the program of an SL cycle.
    Contour(String),
    /// A statement of the control that is not emulated, unless the machine has a code for it.
    Foreign(Vec<HeidenhainWord>),
}

/// Form of CYCL CALL.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum CycleCallForm {
    Here,
    Position,
    Pattern,
}
