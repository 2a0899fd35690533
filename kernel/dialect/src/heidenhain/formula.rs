//! Formulas: what stands after the equal sign of a Q parameter.
//!
//! Facts: Heidenhain pre-processor pages (operators, functions, string functions), programming manuals: functions act
//! on the operand that follows, before powers, then multiplication, then addition. Decisions: powers are taken from
//! left to right; a sign belongs to its operand. Invariant: a compiled formula leaves one value on its stack.

use std::sync::Arc;

use super::lex::Cursor;
use crate::expression::{Grammar, read};
use crate::numeric;

/// Kind of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum Kind {
    Q,
    Local,
    Kept,
    Text,
}

impl Kind {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Q => "Q",
            Self::Local => "QL",
            Self::Kept => "QR",
            Self::Text => "QS",
        }
    }

    /// Largest index.
    pub(super) fn last(self) -> u32 {
        match self {
            Self::Q | Self::Text => 1999,
            Self::Local | Self::Kept => 499,
        }
    }
}

/// A parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct Name {
    pub(super) kind: Kind,
    pub(super) index: u32,
}

impl std::fmt::Display for Name {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}{}", self.kind.name(), self.index)
    }
}

/// Function of one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Function {
    /// One that other controls have, too.
    Common(numeric::Function),
    Minus,
    Square,
    Log,
    Frac,
    Sign,
}

/// Names of the functions.
const FUNCTIONS: [(&str, Function); 17] = [
    ("SIN", Function::Common(numeric::Function::Sin)),
    ("COS", Function::Common(numeric::Function::Cos)),
    ("TAN", Function::Common(numeric::Function::Tan)),
    ("ASIN", Function::Common(numeric::Function::Asin)),
    ("ACOS", Function::Common(numeric::Function::Acos)),
    ("ATAN", Function::Common(numeric::Function::Atan)),
    ("ARCSIN", Function::Common(numeric::Function::Asin)),
    ("SQ", Function::Square),
    ("SQRT", Function::Common(numeric::Function::Sqrt)),
    ("LN", Function::Common(numeric::Function::Ln)),
    ("LOG", Function::Log),
    ("EXP", Function::Common(numeric::Function::Exp)),
    ("NEG", Function::Minus),
    ("INT", Function::Common(numeric::Function::Fix)),
    ("ABS", Function::Common(numeric::Function::Abs)),
    ("FRAC", Function::Frac),
    ("SGN", Function::Sign),
];

/// Postfix operation.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Op {
    Number(f64),
    Text(Arc<str>),
    Variable(Name),
    Apply(Function),
    Add,
    Subtract,
    Multiply,
    Divide,
    Modulo,
    Power,
    /// Both texts.
    Join,
    /// Number and places.
    ToChar,
    /// Text, begin, length (negative: up to the end).
    Substring,
    ToNumber,
    /// Text, what is looked for, begin.
    Find,
    Length,
    /// Two texts.
    Compare,
    /// Distance and angle of two legs, for FN 8 and FN 13.
    Legs,
    Angle,
    /// A function that the control may not know.
    Unknown(Arc<str>),
}

/// A compiled formula.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Formula(pub(super) Vec<Op>);

/// Deepest nesting of brackets and functions.
const DEEPEST: usize = 100;

/// Why a text is no formula: what was expected, and where.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Wrong {
    pub(super) expected: &'static str,
    pub(super) column: usize,
}

impl std::fmt::Display for Wrong {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} is expected at column {}", self.expected, self.column)
    }
}

/// What is expected where a cursor stands.
pub(super) fn expected(cursor: &Cursor<'_>, expected: &'static str) -> Wrong {
    Wrong { expected, column: cursor.column() }
}

/// A parameter at the cursor, if there is one.
pub(super) fn parameter(cursor: &mut Cursor<'_>) -> Option<Name> {
    let mut ahead = cursor.clone();
    if !ahead.take(b'Q') {
        return None;
    }
    let kind = match ahead.next_byte() {
        Some(b'L') => Kind::Local,
        Some(b'R') => Kind::Kept,
        Some(b'S') => Kind::Text,
        _ => Kind::Q,
    };
    if kind != Kind::Q {
        ahead.bump();
    }
    if !ahead.next_byte().is_some_and(|byte| byte.is_ascii_digit()) {
        return None;
    }
    let index = ahead.run(|byte| byte.is_ascii_digit()).parse().unwrap_or(u32::MAX);
    *cursor = ahead;
    Some(Name { kind, index })
}

impl Formula {
    /// A number.
    pub(super) fn number(value: f64) -> Self {
        Self(vec![Op::Number(value)])
    }

    /// Reads a formula as far as it goes.
    pub(super) fn parse(cursor: &mut Cursor<'_>) -> Result<Self, Wrong> {
        let mut parser = Parser { cursor, ops: Vec::new(), depth: 0 };
        parser.joined()?;
        Ok(Self(parser.ops))
    }

    /// Reads one operand: a number, a parameter, a text, with or without sign.
    pub(super) fn operand(cursor: &mut Cursor<'_>) -> Result<Self, Wrong> {
        let mut parser = Parser { cursor, ops: Vec::new(), depth: 0 };
        parser.signed()?;
        Ok(Self(parser.ops))
    }

    /// Two formulas and what is done with them.
    pub(super) fn of_two(mut self, other: Self, op: Op) -> Self {
        self.0.extend(other.0);
        self.0.push(op);
        self
    }
}

struct Parser<'c, 't> {
    cursor: &'c mut Cursor<'t>,
    ops: Vec<Op>,
    depth: usize,
}

/// Operators by level, loosest first.
static OPERATORS: [&[(&str, Op)]; 4] = [
    &[("||", Op::Join)],
    &[("+", Op::Add), ("-", Op::Subtract)],
    &[("*", Op::Multiply), ("/", Op::Divide), ("%", Op::Modulo), ("DIV", Op::Divide)],
    &[("^", Op::Power)],
];

impl Grammar for Parser<'_, '_> {
    type Operator = &'static Op;
    type Part = ();
    type Mistake = Wrong;

    fn operand(&mut self) -> Result<(), Wrong> {
        self.signed()
    }

    fn operator(&mut self, loosest: usize) -> Option<(usize, &'static Op)> {
        let cursor = &mut *self.cursor;
        let mut take = |text: &str| match text.as_bytes() {
            [sign] => cursor.take(*sign),
            [b'A'..=b'Z', ..] => cursor.keyword(text),
            _ => cursor.take_text(text),
        };
        for (level, operators) in OPERATORS.iter().enumerate().skip(loosest) {
            if let Some((_, op)) = operators.iter().find(|(text, _)| take(text)) {
                return Some((level, op));
            }
        }
        None
    }

    fn join(&mut self, op: &'static Op, (): (), (): ()) {
        self.ops.push(op.clone());
    }
}

impl Parser<'_, '_> {
    fn wrong<T>(&self, what: &'static str) -> Result<T, Wrong> {
        Err(expected(self.cursor, what))
    }

    fn joined(&mut self) -> Result<(), Wrong> {
        read(self, 0)
    }

    fn signed(&mut self) -> Result<(), Wrong> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return self.wrong("a formula that is not nested so deeply");
        }
        match self.cursor.peek() {
            Some(b'+') => {
                self.cursor.bump();
                self.signed()?;
            }
            Some(b'-') => {
                self.cursor.bump();
                self.signed()?;
                match self.ops.last_mut() {
                    Some(Op::Number(value)) => *value = -*value,
                    _ => self.ops.push(Op::Apply(Function::Minus)),
                }
            }
            _ => self.primary()?,
        }
        self.depth -= 1;
        Ok(())
    }

    fn primary(&mut self) -> Result<(), Wrong> {
        if let Some((_, value)) = self.cursor.number() {
            self.ops.push(Op::Number(value));
            return Ok(());
        }
        if let Some(text) = self.cursor.quoted() {
            self.ops.push(Op::Text(text.into()));
            return Ok(());
        }
        if self.cursor.take(b'(') {
            self.joined()?;
            return self.close();
        }
        if let Some(name) = parameter(self.cursor) {
            self.ops.push(Op::Variable(name));
            return Ok(());
        }
        self.function()
    }

    fn close(&mut self) -> Result<(), Wrong> {
        if self.cursor.take(b')') { Ok(()) } else { self.wrong("a closing bracket") }
    }

    fn function(&mut self) -> Result<(), Wrong> {
        self.cursor.blanks();
        let start = self.cursor.clone();
        let name = self.cursor.letters();
        if name.is_empty() {
            return self.wrong("a number, a parameter or a function");
        }
        if name == "PI" {
            self.ops.push(Op::Number(std::f64::consts::PI));
            return Ok(());
        }
        if let Some((_, function)) = FUNCTIONS.iter().find(|(known, _)| *known == name) {
            self.signed()?;
            self.ops.push(Op::Apply(*function));
            return Ok(());
        }
        if matches!(name, "TOCHAR" | "SUBSTR" | "TONUMB" | "INSTR" | "STRLEN" | "STRCOMP") {
            return self.text_function(name);
        }
        // The control does not know it; the machine may.
        if self.cursor.peek() == Some(b'(') {
            self.cursor.bump();
            let mut depth = 1_usize;
            while depth > 0 {
                match self.cursor.bump() {
                    Some('(') => depth += 1,
                    Some(')') => depth -= 1,
                    Some(_) => {}
                    None => return self.wrong("a closing bracket"),
                }
            }
        } else {
            self.cursor.run(|byte| byte.is_ascii_digit() || byte == b'.');
        }
        let length = start.rest().len() - self.cursor.rest().len();
        self.ops.push(Op::Unknown(start.rest().get(..length).unwrap_or_default().into()));
        Ok(())
    }

    /// A function with arguments by key words, as in `SUBSTR ( SRC_QS10 BEG2 LEN4 )`.
    fn text_function(&mut self, name: &str) -> Result<(), Wrong> {
        if !self.cursor.take(b'(') {
            return self.wrong("an opening bracket");
        }
        match name {
            "TOCHAR" => {
                self.argument("DAT", None)?;
                self.argument("DECIMALS", Some(0.0))?;
                self.ops.push(Op::ToChar);
            }
            "SUBSTR" => {
                self.argument("SRC_", None)?;
                self.argument("BEG", Some(0.0))?;
                self.argument("LEN", Some(-1.0))?;
                self.ops.push(Op::Substring);
            }
            "INSTR" => {
                self.argument("SRC_", None)?;
                self.argument("SEA_", None)?;
                self.argument("BEG", Some(0.0))?;
                self.ops.push(Op::Find);
            }
            "STRCOMP" => {
                self.argument("SRC_", None)?;
                self.argument("SEA_", None)?;
                self.ops.push(Op::Compare);
            }
            name => {
                self.argument("SRC_", None)?;
                self.ops.push(if name == "STRLEN" { Op::Length } else { Op::ToNumber });
            }
        }
        self.close()
    }

    fn argument(&mut self, key: &str, default: Option<f64>) -> Result<(), Wrong> {
        if self.cursor.take_text(key) {
            return self.signed();
        }
        match default {
            Some(value) => {
                self.ops.push(Op::Number(value));
                Ok(())
            }
            None => self.wrong("a source"),
        }
    }
}
