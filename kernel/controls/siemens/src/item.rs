//! A block as data: its words and statements in their order.
//!
//! *Invariant:* text that is not a statement is kept unchanged.

use counterpoint_control_api::statement::SharedStatement;
use counterpoint_control_api::words::Span;

use super::compiled::{Expression, IndexedName, SiemensArgument};
use super::declaration::{ProcHeader, VariableDeclaration};

/// A block.
#[derive(Debug, Default, PartialEq)]
pub(super) struct SiemensLine {
    /// Its number as written without the letter.
    pub(super) number: Option<String>,
    /// In capital letters.
    pub(super) label: Option<String>,
    pub(super) items: Vec<SiemensItem>,
    /// Places in the block of the number with its letter, then of the items; empty if the text does not come from the
    /// block.
    pub(super) places: Vec<Span>,
    /// Its text has neither a mark of optional skip nor is it the head of a program: nothing is to be asked before it
    /// acts.
    pub(super) at_once: bool,
    /// Its text is such a one, and is for the interpreter whether plain words are or not.
    pub(super) is_statement: bool,
    /// A G function of the block makes a limit or a cutting speed of S.
    pub(super) speed_is_other: bool,
}

impl SiemensLine {
    /// The line with its places moved by `offset`, for a text that ends with the line.
    pub(super) fn at(self, offset: usize) -> Self {
        let offset = offset as u32;
        let places = self.places.into_iter().map(|(start, end)| (start + offset, end + offset)).collect();
        Self { places, ..self }
    }
}

/// A word or statement.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum SiemensItem {
    /// A plain word, or text that is none.
    Text(String),
    /// `NAME=…`: a variable or a word.
    Set {
        name: IndexedName,
        value: AssignmentValue,
    },
    /// A name alone.
    Bare(String),
    /// A name with arguments.
    Function(String, Vec<SiemensArgument>),
    /// `P…` beside a call, with the word as it is written.
    Passes(Expression, String),
    /// `L…`
    Program(String),
    /// CALL, EXTCALL with a name; PCALL with arguments.
    CallText {
        name: Expression,
        section: Option<(String, String)>,
        arguments: Vec<SiemensArgument>,
    },
    /// MCALL
    Modal,
    /// M17, RET as written; whether it wants to go elsewhere.
    Return(String, bool),
    Define(String, String),
    Declare(VariableDeclaration),
    Redeclare(VariableDeclaration),
    Header(ProcHeader),
    External(ProcHeader),
    Message(Option<SiemensArgument>),
    /// A synchronised action.
    Synchronised(std::sync::Arc<SynchronisedAction>),
    If(Expression, Option<SiemensJump>),
    Case(Expression, Vec<(Expression, SiemensJump)>, Option<SiemensJump>),
    Goto(SiemensJump),
    For(IndexedName, Expression, Expression),
    While(Expression),
    Until(Expression),
    RepeatPart {
        first: SiemensJumpTarget,
        last: Option<SiemensJumpTarget>,
        passes: Option<Expression>,
        one_block: bool,
    },
    /// ELSE ENDIF LOOP ENDLOOP ENDFOR ENDWHILE REPEAT
    Structure(Structure),
    /// A statement that other controls have too, with its keyword as written.
    Shared {
        statement: &'static SharedStatement,
        text: String,
        operands: Vec<SiemensArgument>,
    },
}

/// Statements of one word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Structure {
    Else,
    EndIf,
    Loop,
    EndLoop,
    EndFor,
    EndWhile,
    Repeat,
}

/// The text after `=`.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum AssignmentValue {
    /// An expression, and how it is written.
    One(Expression, String),
    /// `SET(…)` or a list in parentheses.
    List(Vec<SiemensArgument>),
    /// `REP(value[, number])`
    Fill(Vec<SiemensArgument>),
    /// `AC(…)` and the like.
    Positioned(PositionMode, Expression, String),
}

/// How a position counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PositionMode {
    Absolute,
    Incremental,
    Shortest,
    Positive,
    Negative,
    /// `QU(…)`: only the value counts.
    Value,
    /// `PM(…)`: a feed per minute.
    PerMinute,
    /// `PR(…)`: a feed per revolution.
    PerRevolution,
    /// `DAC(…)`, `RAC(…)`: a position as a diameter or a radius, in any mode of the program.
    AbsoluteAs(Width),
    /// `DIC(…)`, `RIC(…)`: a distance likewise.
    IncrementalAs(Width),
}

/// Meaning of a value across the axis of turning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Width {
    Diameter,
    Radius,
}

/// Where a jump looks for its target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum JumpDirection {
    Forward,
    Back,
    Either,
    /// GOTOC: a missing target is ignored.
    Silent,
    /// GOTOS: the beginning of the program.
    Start,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct SiemensJump {
    pub(super) direction: JumpDirection,
    pub(super) target: SiemensJumpTarget,
}

/// A label, a block number, or an expression that gives one of them.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum SiemensJumpTarget {
    Number(u32),
    Name(String),
    Value(Expression),
}

/// When an action acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Trigger {
    Once,
    While,
    Edge,
    Since,
    Always,
}

/// An action as it is written.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SynchronisedAction {
    /// Its number, and whether it stays beyond the program.
    pub(super) number: Option<(Expression, bool)>,
    pub(super) trigger: Trigger,
    pub(super) condition: Option<Expression>,
    pub(super) does: Vec<SiemensItem>,
    pub(super) text: String,
}

impl SynchronisedAction {
    /// Whether it sets or deletes marks for other channels.
    pub(super) fn coordinates(&self) -> bool {
        self.does
            .iter()
            .any(|item| matches!(item, SiemensItem::Function(name, _) if matches!(name.as_str(), "SETM" | "CLEARM")))
    }
}
