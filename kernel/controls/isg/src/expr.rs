//! Expressions: their form and how they are read.
//!
//! Facts: reference channel-synchronisation.md 1.7. Decision, the order of operators, loosest first: OR, XOR, AND,
//! those of bits in the same order, `== !=`, `< <= > >=`, `+ -`, `* / MOD`, `**`. Invariant: an expression has [`MOST`]
//! parts at the most and is [`DEEPEST`] brackets deep, so neither reading nor evaluating nor dropping it runs out of
//! stack.

use super::cursor::{IsgCursor, IsgSyntaxError};
use counterpoint_control_api::expression::{
    self, CompiledExpression, ExpressionPart, Grammar, Operators, PrefixOperator, read,
};
use counterpoint_control_api::numeric::{NumericFunction, NumericOperator};

/// Parts of an expression.
const MOST: usize = 256;

/// Brackets and signs inside each other.
const DEEPEST: usize = 40;

/// Level of `+` and `-`: words have no looser operators.
const SUM: usize = 8;

/// An operation that only this control has.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum IsgOp {
    Variable(IsgVariable),
    /// Ten to a power.
    PowerOfTen,
}

pub(super) type Op = expression::ExpressionOp<f64, IsgOp>;

/// An expression.
pub(super) type Expr = CompiledExpression<f64, IsgOp>;

/// A variable that is read or written.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum IsgVariable {
    /// A parameter P by its number, with the indices of an array.
    Parameter(Box<Expr>, Box<[Expr]>),
    /// `V.…`, with the indices of an array.
    Named(Box<str>, Box<[Expr]>),
}

/// Functions, with their names.
const FUNCTIONS: &[(&str, NumericFunction)] = &[
    ("ATAN", NumericFunction::Atan),
    ("SQR", NumericFunction::Square),
    ("LOG", NumericFunction::Log),
    ("INT", NumericFunction::Fix),
    ("FRACT", NumericFunction::Frac),
    ("ROUND", NumericFunction::Round),
    ("NOT", NumericFunction::Not),
];

/// Reads expressions from a text.
pub(super) struct IsgExpressionReader<'c, 'a> {
    cursor: &'c mut IsgCursor<'a>,
    ops: Vec<Op>,
    parts: usize,
    /// Brackets and signs around the current operand.
    depth: usize,
}

impl Grammar for IsgExpressionReader<'_, '_> {
    type Value = f64;
    type Own = IsgOp;
    type Mistake = IsgSyntaxError;

    const OPERATORS: Operators = &[
        &[("||", NumericOperator::Or), ("OR", NumericOperator::Or)],
        &[("^^", NumericOperator::Xor), ("XOR", NumericOperator::Xor)],
        &[("&&", NumericOperator::And), ("AND", NumericOperator::And)],
        &[("|", NumericOperator::BitOr)],
        &[("^", NumericOperator::BitXor)],
        &[("&", NumericOperator::BitAnd)],
        &[("==", NumericOperator::Eq), ("!=", NumericOperator::Ne)],
        &[
            ("<=", NumericOperator::Le),
            (">=", NumericOperator::Ge),
            ("<", NumericOperator::Lt),
            (">", NumericOperator::Gt),
        ],
        &[("+", NumericOperator::Add), ("-", NumericOperator::Sub)],
        &[("*", NumericOperator::Mul), ("/", NumericOperator::Div), ("MOD", NumericOperator::Rem)],
        &[("**", NumericOperator::Power)],
    ];
    const SIGNS: &'static [(&'static str, PrefixOperator)] = &[
        ("+", PrefixOperator::Plus),
        ("-", PrefixOperator::Minus),
        ("!", PrefixOperator::Not),
        ("NOT", PrefixOperator::Not),
    ];

    fn ops(&mut self) -> &mut Vec<Op> {
        &mut self.ops
    }

    fn takes(&mut self, word: &str) -> bool {
        if word.starts_with(|c: char| c.is_ascii_alphabetic()) {
            return self.cursor.word(word);
        }
        let mut ahead = self.cursor.clone();
        let twice = matches!(word, "|" | "^" | "&" | "*");
        let longer = |next: Option<u8>| twice && next == word.bytes().next();
        let is = ahead.key(word) && !longer(ahead.here());
        if is {
            self.cursor.at = ahead.at;
        }
        is
    }

    fn operand(&mut self) -> Result<ExpressionPart, IsgSyntaxError> {
        match self.cursor.peek() {
            Some(b'[') => {
                self.cursor.at += 1;
                let inside = read(self, 0)?;
                self.cursor.expect(b']', "']'")?;
                Ok(inside)
            }
            Some(b'0'..=b'9' | b'.') => self.number(),
            Some(b'A'..=b'Z') => self.name(),
            _ => Err(IsgSyntaxError::expected("a value", self.cursor.at)),
        }
    }

    fn negated(value: &f64) -> Option<f64> {
        Some(-value)
    }

    fn nest(&mut self, _: bool) -> Result<(), IsgSyntaxError> {
        self.count()?;
        self.depth += 1;
        if self.depth > DEEPEST { Err(self.too_long()) } else { Ok(()) }
    }

    fn unnest(&mut self, signs: usize) {
        self.depth -= signs + 1;
    }

    fn check(&mut self, _: usize, _: bool) -> Result<(), IsgSyntaxError> {
        self.count()
    }
}

impl<'c, 'a> IsgExpressionReader<'c, 'a> {
    pub(super) fn new(cursor: &'c mut IsgCursor<'a>) -> Self {
        Self { cursor, ops: Vec::new(), parts: 0, depth: 0 }
    }

    /// A whole expression.
    pub(super) fn expression(&mut self) -> Result<Expr, IsgSyntaxError> {
        self.from(0)
    }

    /// The value of a word: no comparisons and nothing looser.
    pub(super) fn sum(&mut self) -> Result<Expr, IsgSyntaxError> {
        self.from(SUM)
    }

    fn from(&mut self, level: usize) -> Result<Expr, IsgSyntaxError> {
        let outer = std::mem::take(&mut self.ops);
        let done = read(self, level);
        let ops = std::mem::replace(&mut self.ops, outer);
        done.map(|_| CompiledExpression::new(ops))
    }

    fn too_long(&self) -> IsgSyntaxError {
        IsgSyntaxError::syntax(format!("the expression is too long at column {}", self.cursor.at + 1))
    }

    fn count(&mut self) -> Result<(), IsgSyntaxError> {
        self.parts += 1;
        if self.parts > MOST { Err(self.too_long()) } else { Ok(()) }
    }

    fn number(&mut self) -> Result<ExpressionPart, IsgSyntaxError> {
        let at = self.cursor.at;
        match number_text(self.cursor).parse() {
            Ok(value) => Ok(self.push(Op::Value(value))),
            Err(_) => Err(IsgSyntaxError::expected("a number", at)),
        }
    }

    fn name(&mut self) -> Result<ExpressionPart, IsgSyntaxError> {
        if is_variable(self.cursor) {
            let variable = self.variable()?;
            return Ok(self.push(Op::Own(IsgOp::Variable(variable))));
        }
        let at = self.cursor.at;
        let name = self.cursor.run(|byte| byte.is_ascii_alphabetic());
        match name {
            "TRUE" => return Ok(self.push(Op::Value(1.0))),
            "FALSE" => return Ok(self.push(Op::Value(0.0))),
            _ => {}
        }
        let function = FUNCTIONS.iter().find(|(known, _)| *known == name).map(|(_, function)| *function);
        let op = match function.or_else(|| NumericFunction::named(name)) {
            Some(function) => Op::Apply(function),
            None if name == "DEXP" => Op::Own(IsgOp::PowerOfTen),
            None => return Err(IsgSyntaxError::expected("a value", at)),
        };
        let start = self.ops.len();
        self.cursor.expect(b'[', "'['")?;
        read(self, 0)?;
        self.cursor.expect(b']', "']'")?;
        self.ops.push(op);
        Ok(ExpressionPart { start, truth: false })
    }

    /// A variable, which has to be here.
    pub(super) fn variable(&mut self) -> Result<IsgVariable, IsgSyntaxError> {
        if self.cursor.take(b'P') {
            let number = match self.cursor.here() {
                Some(b'0'..=b'9') => {
                    let at = self.cursor.at;
                    let digits = self.cursor.run(|byte| byte.is_ascii_digit());
                    Expr::constant(digits.parse().map_err(|_| IsgSyntaxError::expected("a number", at))?)
                }
                Some(b'P') => {
                    self.nest(false)?;
                    let inner = self.variable()?;
                    self.unnest(0);
                    Expr::own(IsgOp::Variable(inner))
                }
                Some(b'[') => self.index()?,
                _ => return Err(IsgSyntaxError::expected("the number of a parameter", self.cursor.at)),
            };
            return Ok(IsgVariable::Parameter(Box::new(number), self.indices()?));
        }
        let start = self.cursor.at;
        self.cursor.run(|byte| byte.is_ascii_alphanumeric() || byte == b'_' || byte == b'.');
        let name = self.cursor.between(start);
        if !name.starts_with("V.") || name.len() < 5 || name.ends_with('.') {
            return Err(IsgSyntaxError::expected("a variable (P1, V.P.NAME)", start));
        }
        Ok(IsgVariable::Named(name.into(), self.indices()?))
    }

    /// Indices close to their variable.
    fn indices(&mut self) -> Result<Box<[Expr]>, IsgSyntaxError> {
        let mut indices = Vec::new();
        while self.cursor.here() == Some(b'[') {
            indices.push(self.index()?);
        }
        Ok(indices.into())
    }

    /// A value in brackets.
    pub(super) fn index(&mut self) -> Result<Expr, IsgSyntaxError> {
        self.cursor.expect(b'[', "'['")?;
        let index = self.expression()?;
        self.cursor.expect(b']', "']'")?;
        Ok(index)
    }
}

/// Whether a variable is here.
pub(super) fn is_variable(cursor: &IsgCursor<'_>) -> bool {
    match (cursor.here(), cursor.ahead(1)) {
        (Some(b'V'), Some(b'.')) => true,
        (Some(b'P'), Some(b'0'..=b'9' | b'[')) => true,
        (Some(b'P'), Some(b'P')) => matches!(cursor.ahead(2), Some(b'0'..=b'9' | b'[' | b'P')),
        _ => false,
    }
}

/// Whether the value of a word may begin here: a number, a sign, brackets, a variable or a function.
pub(super) fn is_value(cursor: &IsgCursor<'_>) -> bool {
    match cursor.here() {
        Some(b'0'..=b'9' | b'.' | b'+' | b'-' | b'[') => true,
        Some(b'A'..=b'Z') => is_variable(cursor) || is_function(cursor),
        _ => false,
    }
}

/// Whether a function comes next; a blank may be before its bracket.
pub(super) fn is_function(cursor: &IsgCursor<'_>) -> bool {
    let mut ahead = cursor.clone();
    let name = ahead.run(|byte| byte.is_ascii_alphabetic());
    let known = FUNCTIONS.iter().any(|(known, _)| *known == name) || NumericFunction::named(name).is_some();
    (known || name == "DEXP") && ahead.peek() == Some(b'[')
}

/// The digits of a number without sign.
fn number_text<'a>(cursor: &mut IsgCursor<'a>) -> &'a str {
    let start = cursor.at;
    cursor.run(|byte| byte.is_ascii_digit());
    if cursor.here() == Some(b'.') {
        cursor.at += 1;
        cursor.run(|byte| byte.is_ascii_digit());
    }
    cursor.between(start)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Expr {
        let mut cursor = IsgCursor::new(text.as_bytes());
        let expr = IsgExpressionReader::new(&mut cursor).expression().unwrap();
        cursor.end().unwrap();
        expr
    }

    #[test]
    fn the_order_of_operators() {
        for (text, brackets) in [
            ("1+2*3-4", "[1+[2*3]]-4"),
            ("2*3**2", "2*[3**2]"),
            ("P1+1==2*3 AND 1<2 OR P2", "[[[P1+1]==[2*3]] AND [1<2]] OR P2"),
            ("1||2||3&&4", "[1||2]||[3&&4]"),
            ("1|2&3", "1|[2&3]"),
            ("!P1==0", "[!P1]==0"),
            ("P1MOD3", "P1 MOD 3"),
        ] {
            assert_eq!(read(text), read(brackets), "{text}");
        }
    }

    #[test]
    fn variables() {
        let named = |name: &str| Expr::own(IsgOp::Variable(IsgVariable::Named(name.into(), Box::default())));
        assert_eq!((read("V.E.PART"), read("V.A.ABS.X")), (named("V.E.PART"), named("V.A.ABS.X")));
        let one = || Box::new(Expr::constant(1.0));
        assert_eq!(read("P1"), Expr::own(IsgOp::Variable(IsgVariable::Parameter(one(), Box::default()))));
        let array = IsgVariable::Parameter(one(), [Expr::constant(2.0), Expr::constant(3.0)].into());
        assert_eq!(read("P1[2][3]"), Expr::own(IsgOp::Variable(array)));
        assert!(matches!(read("PP1").as_own(), Some(IsgOp::Variable(IsgVariable::Parameter(..)))));
        for wrong in ["V.", "V.P.", "V.X", "P", "Q1", "SIN 5", "1+", "[1", "1 2", &"[".repeat(100)] {
            let mut cursor = IsgCursor::new(wrong.as_bytes());
            let done = IsgExpressionReader::new(&mut cursor).expression();
            assert!(done.is_err() || cursor.end().is_err(), "{wrong}");
        }
    }
}
