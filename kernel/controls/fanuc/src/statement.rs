//! A compiled program line, and the names of its words.

use super::expr::Expr;
use counterpoint_control_api::statement::SharedStatement;
use counterpoint_machine::index::{CodeRowId, RegisterId};
use counterpoint_program::key_words::WrittenNumber;

/// A line after compiling.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FanucLine {
    /// Sequence number.
    pub(super) sequence: Option<u32>,
    /// Its effect.
    pub(super) statement: FanucStatement,
    /// Place of the statement, after the sequence number.
    pub(super) place: (u32, u32),
    /// Place of a program name in angle brackets.
    pub(super) name: Option<(u32, u32)>,
    /// Places of its messages to the operator.
    pub(super) messages: Box<[(u32, u32)]>,
    /// It is more than plain words.
    pub(super) executes: bool,
}

/// The effect of a line.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum FanucStatement {
    /// A block of words, some of them with expressions.
    Words(Vec<TemplateWord>),
    /// `#i = expression`, left to right.
    Assign(Vec<(AssignmentTarget, Expr)>),
    /// `IF [condition] GOTO n`.
    IfGoto(Expr, Expr),
    /// `IF [condition] THEN statement`.
    IfThen(Expr, Box<FanucStatement>),
    /// `IF [condition] THEN` alone: a block form that `ELSE` and `ENDIF` close.
    IfBlock(Expr),
    /// `ELSE`.
    Else,
    /// `ENDIF`.
    EndIf,
    /// `WHILE [condition] DO m`.
    While(Expr, u8),
    /// `DO m` without a condition.
    Do(u8),
    /// `END m`.
    End(u8),
    /// `GOTO n`.
    Goto(Expr),
    /// A statement that other controls have too, with its operands.
    Shared(&'static SharedStatement, Box<[Expr]>),
    /// `DPRNT[…]`: a line of text and numbers.
    Print(Vec<PrintItem>),
    /// `BPRNT[…]`: a line of text and binary numbers.
    PrintBinary(Vec<PrintItem>),
}

/// A variable that is assigned to.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum AssignmentTarget {
    /// `#n`.
    Variable(u32),
    /// `#` of an expression.
    Indirect(Expr),
}

/// A part of the output of a printing statement.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum PrintItem {
    Text(String),
    /// A variable, its digits before the point and after it.
    Number(Expr, u8, u8),
}

/// A word whose value may be an expression.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TemplateWord {
    /// Its name.
    pub(super) name: WordName,
    /// Value; vacant values drop the word.
    pub(super) value: Expr,
    /// The value is this number, which the word's register reads.
    pub(super) written: Option<WrittenNumber>,
    /// Start in the line.
    pub(super) start: u32,
    /// End in the line.
    pub(super) end: u32,
}

/// The name of a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum WordName {
    /// Upper-case letter.
    Letter(u8),
    /// A special register of the machine, and whether it is the incremental form.
    Register(RegisterId, bool),
    /// A literal text: row of the code table. It has no value.
    Text(CodeRowId),
}
