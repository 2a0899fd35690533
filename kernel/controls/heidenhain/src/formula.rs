//! Formulas: the text after the equal sign of a Q parameter.
//!
//! Facts: Heidenhain pre-processor pages (operators, functions, string functions), programming manuals: functions act
//! on the operand that follows, before powers, then multiplication, then addition. Decisions: powers are taken from
//! left to right; a sign belongs to its operand. Invariant: reading a formula recurses as deep as it is nested.

use std::sync::Arc;

use counterpoint_control_api::expression;
use counterpoint_control_api::expression::{
    CompiledExpression, ExpressionPart, Grammar, Operators, PrefixOperator, read, signed,
};
use counterpoint_control_api::numeric::{NumericFunction, NumericOperator};

use super::lex::HeidenhainCursor;
use super::q_parameter::{ParameterKind, ParameterValue, QParameter};

/// Names of the functions besides those of all controls.
const FUNCTIONS: [(&str, NumericFunction); 8] = [
    ("ATAN", NumericFunction::Atan),
    ("ARCSIN", NumericFunction::Asin),
    ("SQ", NumericFunction::Square),
    ("LOG", NumericFunction::Log),
    ("NEG", NumericFunction::Neg),
    ("INT", NumericFunction::Fix),
    ("FRAC", NumericFunction::Frac),
    ("SGN", NumericFunction::Sign),
];

/// An operation that only this control has.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum HeidenhainOp {
    Variable(QParameter),
    /// Number and places.
    ToChar,
    /// Text, begin, length (negative: up to the end).
    Substring,
    ToNumber,
    /// Text, text to find, start.
    Find,
    Length,
    /// Two texts.
    Compare,
    /// A function that the control may not know.
    Unknown(Arc<str>),
}

pub(super) type Op = expression::ExpressionOp<ParameterValue, HeidenhainOp>;

/// A compiled formula.
pub(super) type Formula = CompiledExpression<ParameterValue, HeidenhainOp>;

/// Deepest nesting of brackets and functions.
const DEEPEST: usize = 100;

/// Why a text is not a formula: the expected input and the place.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FormulaError {
    pub(super) expected: &'static str,
    pub(super) column: usize,
}

impl std::fmt::Display for FormulaError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "expected {} at column {}", self.expected, self.column)
    }
}

/// The expected input at a cursor.
pub(super) fn expected(cursor: &HeidenhainCursor<'_>, expected: &'static str) -> FormulaError {
    FormulaError { expected, column: cursor.column() }
}

/// A parameter at the cursor, if there is one.
pub(super) fn parameter(cursor: &mut HeidenhainCursor<'_>) -> Option<QParameter> {
    let mut ahead = cursor.clone();
    if !ahead.take(b'Q') {
        return None;
    }
    let kind = match ahead.next_byte() {
        Some(b'L') => ParameterKind::Local,
        Some(b'R') => ParameterKind::Kept,
        Some(b'S') => ParameterKind::Text,
        _ => ParameterKind::Q,
    };
    if kind != ParameterKind::Q {
        ahead.bump();
    }
    if !ahead.next_byte().is_some_and(|byte| byte.is_ascii_digit()) {
        return None;
    }
    let index = ahead.run(|byte| byte.is_ascii_digit()).parse().unwrap_or(u32::MAX);
    *cursor = ahead;
    Some(QParameter { kind, index })
}

/// A number.
pub(super) fn number(value: f64) -> Formula {
    Formula::constant(ParameterValue::Number(value))
}

/// A text.
pub(super) fn text(text: &str) -> Formula {
    Formula::constant(ParameterValue::Text(text.into()))
}

/// Reads a formula as far as it goes.
pub(super) fn formula(cursor: &mut HeidenhainCursor<'_>) -> Result<Formula, FormulaError> {
    let mut parser = FormulaParser { cursor, ops: Vec::new(), depth: 0 };
    read(&mut parser, 0)?;
    Ok(Formula::new(parser.ops))
}

/// Reads one operand: a number, a parameter, a text, with or without sign.
pub(super) fn operand(cursor: &mut HeidenhainCursor<'_>) -> Result<Formula, FormulaError> {
    let mut parser = FormulaParser { cursor, ops: Vec::new(), depth: 0 };
    signed(&mut parser)?;
    Ok(Formula::new(parser.ops))
}

/// Operands and the operation on them.
pub(super) fn with(operands: impl IntoIterator<Item = Formula>, op: Op) -> Formula {
    Formula::new(operands.into_iter().flat_map(CompiledExpression::into_ops).chain([op]).collect())
}

struct FormulaParser<'c, 't> {
    cursor: &'c mut HeidenhainCursor<'t>,
    ops: Vec<Op>,
    depth: usize,
}

impl Grammar for FormulaParser<'_, '_> {
    type Value = ParameterValue;
    type Own = HeidenhainOp;
    type Mistake = FormulaError;

    const OPERATORS: Operators = &[
        &[("||", NumericOperator::Join)],
        &[("+", NumericOperator::Add), ("-", NumericOperator::Sub)],
        &[
            ("*", NumericOperator::Mul),
            ("/", NumericOperator::Div),
            ("%", NumericOperator::RemByQuotient),
            ("DIV", NumericOperator::Div),
        ],
        &[("^", NumericOperator::Power)],
    ];
    const SIGNS: &'static [(&'static str, PrefixOperator)] =
        &[("+", PrefixOperator::Plus), ("-", PrefixOperator::Minus)];

    fn ops(&mut self) -> &mut Vec<Op> {
        &mut self.ops
    }

    fn takes(&mut self, word: &str) -> bool {
        match word.as_bytes() {
            [b'A'..=b'Z', ..] => self.cursor.keyword(word),
            _ => self.cursor.take_text(word),
        }
    }

    fn operand(&mut self) -> Result<ExpressionPart, FormulaError> {
        let start = self.ops.len();
        self.primary()?;
        Ok(ExpressionPart { start, truth: false })
    }

    fn negated(value: &ParameterValue) -> Option<ParameterValue> {
        match value {
            ParameterValue::Number(value) => Some(ParameterValue::Number(-value)),
            ParameterValue::Text(_) => None,
        }
    }

    fn nest(&mut self, _: bool) -> Result<(), FormulaError> {
        self.depth += 1;
        if self.depth > DEEPEST { self.wrong("a formula that is not nested so deeply") } else { Ok(()) }
    }

    fn unnest(&mut self, signs: usize) {
        self.depth -= signs + 1;
    }
}

impl FormulaParser<'_, '_> {
    fn wrong<T>(&self, what: &'static str) -> Result<T, FormulaError> {
        Err(expected(self.cursor, what))
    }

    fn primary(&mut self) -> Result<(), FormulaError> {
        if let Some((_, value)) = self.cursor.number() {
            self.ops.push(Op::Value(ParameterValue::Number(value)));
            return Ok(());
        }
        if let Some(text) = self.cursor.quoted() {
            self.ops.push(Op::Value(ParameterValue::Text(text.into())));
            return Ok(());
        }
        if self.cursor.take(b'(') {
            read(self, 0)?;
            return self.close();
        }
        if let Some(name) = parameter(self.cursor) {
            self.ops.push(Op::Own(HeidenhainOp::Variable(name)));
            return Ok(());
        }
        self.function()
    }

    fn close(&mut self) -> Result<(), FormulaError> {
        if self.cursor.take(b')') { Ok(()) } else { self.wrong("a closing bracket") }
    }

    fn function(&mut self) -> Result<(), FormulaError> {
        self.cursor.blanks();
        let start = self.cursor.clone();
        let name = self.cursor.letters();
        if name.is_empty() {
            return self.wrong("a number, a parameter or a function");
        }
        if name == "PI" {
            self.ops.push(Op::Value(ParameterValue::Number(std::f64::consts::PI)));
            return Ok(());
        }
        let own = FUNCTIONS.iter().find(|(known, _)| *known == name).map(|(_, function)| *function);
        if let Some(function) = NumericFunction::named(name).or(own) {
            signed(self)?;
            self.ops.push(Op::Apply(function));
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
        let text = start.rest().get(..length).unwrap_or_default().into();
        self.ops.push(Op::Own(HeidenhainOp::Unknown(text)));
        Ok(())
    }

    /// A function with arguments by keywords, as in `SUBSTR ( SRC_QS10 BEG2 LEN4 )`.
    fn text_function(&mut self, name: &str) -> Result<(), FormulaError> {
        if !self.cursor.take(b'(') {
            return self.wrong("an opening bracket");
        }
        match name {
            "TOCHAR" => {
                self.argument("DAT", None)?;
                self.argument("DECIMALS", Some(0.0))?;
                self.ops.push(Op::Own(HeidenhainOp::ToChar));
            }
            "SUBSTR" => {
                self.argument("SRC_", None)?;
                self.argument("BEG", Some(0.0))?;
                self.argument("LEN", Some(-1.0))?;
                self.ops.push(Op::Own(HeidenhainOp::Substring));
            }
            "INSTR" => {
                self.argument("SRC_", None)?;
                self.argument("SEA_", None)?;
                self.argument("BEG", Some(0.0))?;
                self.ops.push(Op::Own(HeidenhainOp::Find));
            }
            "STRCOMP" => {
                self.argument("SRC_", None)?;
                self.argument("SEA_", None)?;
                self.ops.push(Op::Own(HeidenhainOp::Compare));
            }
            name => {
                self.argument("SRC_", None)?;
                self.ops.push(Op::Own(if name == "STRLEN" { HeidenhainOp::Length } else { HeidenhainOp::ToNumber }));
            }
        }
        self.close()
    }

    fn argument(&mut self, key: &str, default: Option<f64>) -> Result<(), FormulaError> {
        if self.cursor.take_text(key) {
            return signed(self).map(|_| ());
        }
        match default {
            Some(value) => {
                self.ops.push(Op::Value(ParameterValue::Number(value)));
                Ok(())
            }
            None => self.wrong("a source"),
        }
    }
}
