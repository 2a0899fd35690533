//! The tree of a file of macros.
//!
//! *Invariant:* expressions are at most [`MAX_DEPTH`] deep, so walking them needs bounded stack. Statements form a flat
//! list per macro (a jump may enter any block); the lowering pairs blocks with their ends.

use crate::lex::Sign;
use crate::source::Span;
use crate::value::{RecordName, ValueType};

/// Deepest expression.
pub const MAX_DEPTH: u32 = 200;
/// Deepest nesting of blocks.
pub const MAX_BLOCKS: usize = 100;

/// A variable by its way of being named.
#[derive(Clone, Debug, PartialEq)]
pub enum VariableName {
    /// User variable, upper case.
    User(String),
    /// `%Gnn`
    Global(u8),
    /// `%Lnn`
    Local(u8),
    /// `$Pnn`
    Param(u8),
    /// `$NAME`
    System(String),
}

/// An expression with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Expr {
    /// Its kind.
    pub kind: ExprKind,
    /// Where it is.
    pub span: Span,
    /// Height of the tree below, at least 1.
    pub depth: u32,
}

/// Kind of an expression.
#[derive(Clone, Debug, PartialEq)]
pub enum ExprKind {
    /// Number constant.
    Real(f64),
    /// Text constant.
    Text(String),
    /// Truth constant.
    Logical(bool),
    /// `$NULL`
    Null,
    /// Minor word.
    Keyword(i32),
    /// Major word or record.
    Record(RecordName),
    /// `CODE_…`
    Code(String),
    /// `REG_…`
    Register(String),
    /// Value of a variable.
    Variable(VariableName),
    /// `v(i,…)`, or a call of a user function.
    Element(VariableName, Vec<Expr>),
    /// `v(i:j)`
    Range(VariableName, Option<Box<Expr>>, Option<Box<Expr>>),
    /// `{…}`
    Sequence(Vec<Expr>),
    /// `$F…(…)`
    Call(String, Vec<Expr>),
    /// `-` `+` `.NOT.`
    Unary(Sign, Box<Expr>),
    /// Operator with two operands.
    Binary(Sign, Box<Expr>, Box<Expr>),
}

/// Life of a declared variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MacroVariableScope {
    /// One activation of the macro.
    Local,
    /// All macros of the same object.
    Object,
    /// All macros of the process.
    Global,
}

/// One name of a DECLAR.
#[derive(Clone, Debug, PartialEq)]
pub struct DeclaredName {
    /// Name, upper case.
    pub name: String,
    /// Sizes of an array.
    pub sizes: Vec<Expr>,
    /// First value.
    pub value: Option<Expr>,
    /// Place of the name.
    pub span: Span,
}

/// Blocks that need an end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CompoundStatement {
    /// IF
    If,
    /// CASE
    Case,
    /// WHILE
    While,
    /// REPEAT
    Repeat,
    /// DO
    Do,
}

/// One item of a WHEN list.
#[derive(Clone, Debug, PartialEq)]
pub enum WhenItem {
    /// A constant.
    One(Expr),
    /// `a,THRU,b`
    Thru(Expr, Expr),
}

/// Header of a user function.
#[derive(Clone, Debug, PartialEq)]
pub struct FunctionHeader {
    /// Name, upper case.
    pub name: String,
    /// Type of the result.
    pub result: Option<ValueType>,
    /// Parameters.
    pub parameters: Vec<(String, Option<ValueType>)>,
    /// Place of the name.
    pub span: Span,
}

/// The effect of a statement.
#[derive(Clone, Debug, PartialEq)]
pub enum StatementKind {
    /// Only a label, or a statement that could not be read.
    Empty,
    /// `v=e`, `v(i)=e`, and the compound forms.
    Assign {
        /// Variable or element.
        target: Expr,
        /// `=` or a compound sign.
        sign: Sign,
        /// Right side.
        value: Expr,
    },
    /// DECLAR
    Declare {
        /// Life.
        scope: MacroVariableScope,
        /// Type of all names.
        kind: Option<ValueType>,
        /// Hidden channel dimension.
        channel: bool,
        /// Names.
        names: Vec<DeclaredName>,
    },
    /// IF
    If(Expr),
    /// ELSEIF
    ElseIf(Expr),
    /// ELSE
    Else,
    /// CASE
    Case(Expr),
    /// WHEN list; empty = OTHERS
    When(Vec<WhenItem>),
    /// WHILE
    While(Expr),
    /// REPEAT
    Repeat,
    /// UNTIL
    Until(Expr),
    /// DO
    Do {
        /// Loop variable.
        variable: Expr,
        /// First value.
        start: Expr,
        /// Last value.
        end: Expr,
        /// Step, 1 if absent.
        step: Option<Expr>,
    },
    /// ENDOF
    EndOf(CompoundStatement),
    /// EXIT
    Exit(u32),
    /// JUMPTO
    Jump(String, Span),
    /// TERMAC
    Terminate,
    /// ENDMAC
    EndMacro,
    /// MATCH
    Match(bool),
    /// OUTPUT
    Output,
    /// EXEC; the flag is NOW
    Exec(bool, Vec<Expr>),
    /// TAPERD
    TapeRead,
    /// TAPEWT
    TapeWrite,
    /// SEARCH
    Search(Expr),
    /// SAVMODAL
    SaveModal,
    /// RSTMODAL
    RestoreModal,
    /// LPRINT/ON, OFF
    Listing(bool),
    /// LPRINT/n
    Skip(Expr),
    /// PPRINT
    Print(Vec<Expr>),
    /// OPEN
    Open(Vec<Expr>),
    /// CLOSE
    Close(Expr),
    /// WRITE unit, format and values
    Write(Vec<Expr>),
    /// READ
    Read {
        /// Unit or text.
        source: Expr,
        /// The last line again.
        again: bool,
        /// Format.
        format: Expr,
        /// Variables.
        targets: Vec<Expr>,
    },
    /// ERROR
    Error(Vec<Expr>),
    /// SYSTEM
    System(Expr),
    /// INCLUD
    Include(String),
}

/// A statement with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct MacroStatement {
    /// Label, upper case.
    pub label: Option<(String, Span)>,
    /// Its effect.
    pub kind: StatementKind,
    /// Where it is.
    pub span: Span,
}

/// A macro: a user function if it has a header.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ParsedMacro {
    /// Header of a function.
    pub header: Option<FunctionHeader>,
    /// Statements.
    pub statements: Vec<MacroStatement>,
    /// Place of the first statement.
    pub span: Span,
}

impl Expr {
    /// Makes an expression; the height follows from its parts.
    #[must_use]
    pub fn new(kind: ExprKind, span: Span) -> Expr {
        let below = |parts: &[Expr]| parts.iter().map(|part| part.depth).max().unwrap_or(0);
        let part = |part: &Option<Box<Expr>>| part.as_ref().map_or(0, |part| part.depth);
        let depth = 1 + match &kind {
            ExprKind::Element(_, parts) | ExprKind::Sequence(parts) | ExprKind::Call(_, parts) => below(parts),
            ExprKind::Range(_, from, to) => part(from).max(part(to)),
            ExprKind::Unary(_, operand) => operand.depth,
            ExprKind::Binary(_, left, right) => left.depth.max(right.depth),
            _ => 0,
        };
        Expr { kind, span, depth }
    }
}
