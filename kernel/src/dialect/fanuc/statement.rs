//! A compiled program line, and what its words may be called.

use super::expr::Expr;
use crate::mcd::key_words::Number;

/// A line after compiling.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Line {
    /// Sequence number.
    pub(crate) sequence: Option<u32>,
    /// What it does.
    pub(crate) statement: Statement,
    /// Place of the statement, behind the sequence number.
    pub(crate) place: (u32, u32),
    /// Place of a program name in angle brackets.
    pub(crate) name: Option<(u32, u32)>,
    /// Places of its messages to the operator.
    pub(crate) messages: Box<[(u32, u32)]>,
}

/// What a line does.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Statement {
    /// A block of words, some of them with expressions.
    Words(Vec<TemplateWord>),
    /// `#i = expression`, left to right.
    Assign(Vec<(Expr, Expr)>),
    /// `IF [condition] GOTO n`.
    IfGoto(Expr, Expr),
    /// `IF [condition] THEN statement`.
    IfThen(Expr, Box<Statement>),
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
    /// `POPEN` and `PCLOS`: output begins, output ends.
    Output(bool),
    /// `DPRNT[…]`: a line of text and numbers.
    Print(Vec<Item>),
    /// `BPRNT[…]`: a line of text and binary numbers.
    PrintBinary(Vec<Item>),
}

/// A part of what a printing statement writes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Item {
    Text(String),
    /// A variable, its digits before the point and after it.
    Number(Expr, u8, u8),
}

/// A word whose value may be an expression.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TemplateWord {
    /// What it is called.
    pub(crate) name: Name,
    /// Value; vacant values drop the word.
    pub(crate) value: Expr,
    /// The value is this number, which the word's register reads.
    pub(crate) written: Option<Number>,
    /// Start in the line.
    pub(crate) start: u32,
    /// End in the line.
    pub(crate) end: u32,
}

/// What a word is called.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Name {
    /// Upper-case letter.
    Letter(u8),
    /// A special register of the machine, and whether it is the incremental form.
    Register(u8, bool),
    /// A literal text: row of the code table. It has no value.
    Text(u16),
}
