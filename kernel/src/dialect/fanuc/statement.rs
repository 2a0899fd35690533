//! A compiled program line, and what its words may be called.

use super::expr::Expr;
use crate::mcd::special::Special;

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
    /// Printing statements of the control, without effect here.
    Ignored,
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

/// A number as written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Number {
    /// Value read as a plain number.
    pub(crate) value: f64,
    /// A decimal point was written.
    pub(crate) point: bool,
    /// Digits written before the point.
    pub(crate) digits: u8,
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

/// What a machine has besides words of one letter.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Names<'a> {
    /// Literal texts that look like words, with their rows, longest first.
    pub(crate) like_words: &'a [(Vec<u8>, u16)],
    /// Special registers, longest first.
    pub(crate) registers: &'a [Special],
    /// All literal texts with their rows, longest first.
    pub(crate) texts: &'a [(Vec<u8>, u16)],
    /// Most levels of brackets in an expression.
    pub(crate) brackets: Option<u8>,
}
