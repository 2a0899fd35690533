//! Expressions: their form and how they are read.
//!
//! Facts: reference control-emulator.md 5.4. Decision, the order of operators, tightest first: sign and NOT; `*`, `/`
//! and MOD; `+` and `-`; comparisons; AND; OR and EOR. Invariant: an expression has [`MOST`] parts at the most and is
//! [`DEEPEST`] brackets deep, so neither reading nor evaluating nor dropping it runs out of stack.

use super::cursor::{OkumaCursor, OkumaSyntaxError};
use super::math::{self, OkumaFunction, StepRounding};
use super::names::{self, Family, LocalVariableName};
use counterpoint_control_api::expression::{
    self, COMPARISONS, CompiledExpression, ExpressionPart, Grammar, Operators, PrefixOperator, read,
};
use counterpoint_control_api::numeric::NumericOperator;

/// Parts of an expression.
const MOST: usize = 256;

/// Brackets and signs inside each other.
const DEEPEST: usize = 40;

/// An operation that only this control has.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum OkumaOp {
    /// The value that a variable without a value equals.
    Empty,
    Variable(OkumaVariable),
    /// Whether a variable has a value.
    HasValue(OkumaVariable),
    /// True for a value that is not a variable.
    IsValue,
    /// A number rounded to the smallest steps of the control.
    Steps(StepRounding),
    /// A function that the control does not have, as it is written.
    Unknown(Box<str>),
}

pub(super) type Op = expression::ExpressionOp<f64, OkumaOp>;

/// An expression.
pub(super) type Expr = CompiledExpression<f64, OkumaOp>;

/// A variable that is read or written.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum OkumaVariable {
    Local(LocalVariableName),
    Common(Family, Box<Expr>),
    /// One of the control's own, or a name that nothing has: its name and its indices.
    System(Box<str>, Box<[Expr]>),
}

/// Reads expressions from a text.
pub(super) struct OkumaExpressionReader<'c, 'a> {
    pub(super) cursor: &'c mut OkumaCursor<'a>,
    ops: Vec<Op>,
    parts: usize,
    /// Brackets and signs around the current operand.
    depth: usize,
}

impl Grammar for OkumaExpressionReader<'_, '_> {
    type Value = f64;
    type Own = OkumaOp;
    type Mistake = OkumaSyntaxError;

    const OPERATORS: Operators = &[
        &[("OR", NumericOperator::BitOr), ("EOR", NumericOperator::BitXor)],
        &[("AND", NumericOperator::BitAnd)],
        COMPARISONS,
        &[("+", NumericOperator::Add), ("-", NumericOperator::Sub)],
        &[("*", NumericOperator::Mul), ("/", NumericOperator::Div), ("MOD", NumericOperator::Rem)],
    ];
    const SIGNS: &'static [(&'static str, PrefixOperator)] =
        &[("+", PrefixOperator::Plus), ("-", PrefixOperator::Minus), ("NOT", PrefixOperator::NotEither)];

    fn ops(&mut self) -> &mut Vec<Op> {
        &mut self.ops
    }

    fn takes(&mut self, word: &str) -> bool {
        // Words of letters may be close to a number that follows: `EQ5`.
        if word.len() == 1 { self.cursor.key_word(word) } else { self.cursor.word(word) }
    }

    fn operand(&mut self) -> Result<ExpressionPart, OkumaSyntaxError> {
        self.value()
    }

    fn negated(value: &f64) -> Option<f64> {
        Some(-value)
    }

    fn nest(&mut self, _: bool) -> Result<(), OkumaSyntaxError> {
        self.count()?;
        self.depth += 1;
        if self.depth > DEEPEST { Err(OkumaSyntaxError::TooLong(self.cursor.at + 1)) } else { Ok(()) }
    }

    fn unnest(&mut self, signs: usize) {
        self.depth -= signs + 1;
    }

    fn check(&mut self, _: usize, _: bool) -> Result<(), OkumaSyntaxError> {
        self.count()
    }

    fn join(&mut self, operator: NumericOperator, left: ExpressionPart, right: ExpressionPart) -> ExpressionPart {
        let is_empty = |ops: &[Op]| matches!(ops, [Op::Own(OkumaOp::Empty)]);
        let (before, after) = self.ops.split_at(right.start.min(self.ops.len()));
        let first = before.get(left.start..).unwrap_or_default();
        if matches!(operator, NumericOperator::Eq | NumericOperator::Ne) && (is_empty(first) || is_empty(after)) {
            let after = self.ops.split_off(right.start);
            let before = self.ops.split_off(left.start);
            self.ops.extend([before, after].into_iter().flat_map(has_value));
        }
        self.ops.push(Op::Combine(operator));
        let logical = matches!(operator, NumericOperator::BitAnd | NumericOperator::BitOr | NumericOperator::BitXor);
        ExpressionPart { start: left.start, truth: operator.compares() || logical && left.truth && right.truth }
    }
}

/// An operand as one that says whether it has a value.
fn has_value(mut operand: Vec<Op>) -> Vec<Op> {
    match operand.as_mut_slice() {
        [Op::Own(OkumaOp::Empty)] => return vec![Op::Value(0.0)],
        [Op::Own(OkumaOp::Variable(variable @ (OkumaVariable::Local(_) | OkumaVariable::Common(..))))] => {
            return vec![Op::Own(OkumaOp::HasValue(variable.clone()))];
        }
        _ => {}
    }
    operand.push(Op::Own(OkumaOp::IsValue));
    operand
}

impl<'c, 'a> OkumaExpressionReader<'c, 'a> {
    pub(super) fn new(cursor: &'c mut OkumaCursor<'a>) -> Self {
        Self { cursor, ops: Vec::new(), parts: 0, depth: 0 }
    }

    /// A whole expression.
    pub(super) fn expression(&mut self) -> Result<Expr, OkumaSyntaxError> {
        let outer = std::mem::take(&mut self.ops);
        let done = read(self, 0);
        let ops = std::mem::replace(&mut self.ops, outer);
        done.map(|_| CompiledExpression::new(ops))
    }

    fn count(&mut self) -> Result<(), OkumaSyntaxError> {
        self.parts += 1;
        if self.parts > MOST { Err(OkumaSyntaxError::TooLong(self.cursor.at + 1)) } else { Ok(()) }
    }

    /// A value without signs.
    fn value(&mut self) -> Result<ExpressionPart, OkumaSyntaxError> {
        match self.cursor.peek() {
            Some(b'[') => {
                self.cursor.at += 1;
                let inside = read(self, 0)?;
                self.cursor.expect(b']', "']'")?;
                Ok(inside)
            }
            Some(b'0'..=b'9' | b'.') => self.number(),
            Some(b'#' | b'$') => self.hexadecimal(),
            Some(b'A'..=b'Z') => self.name(),
            _ => Err(OkumaSyntaxError::Expected("a value", self.cursor.at + 1)),
        }
    }

    fn number(&mut self) -> Result<ExpressionPart, OkumaSyntaxError> {
        let at = self.cursor.at;
        match number_text(self.cursor).parse() {
            Ok(value) => Ok(self.push(Op::Value(value))),
            Err(_) => Err(OkumaSyntaxError::Expected("a number", at + 1)),
        }
    }

    /// `#81H` or `$81`.
    fn hexadecimal(&mut self) -> Result<ExpressionPart, OkumaSyntaxError> {
        let closes = self.cursor.here() == Some(b'#');
        self.cursor.at += 1;
        let at = self.cursor.at;
        let digits = self.cursor.run(|byte| byte.is_ascii_hexdigit());
        // A value cannot be a whole number with more digits.
        let value = i64::from_str_radix(digits, 16).ok().filter(|_| digits.len() <= 12);
        let Some(value) = value else { return Err(OkumaSyntaxError::Expected("a hexadecimal number", at + 1)) };
        if closes && self.cursor.here() == Some(b'H') {
            self.cursor.at += 1;
        }
        Ok(self.push(Op::Value(value as f64)))
    }

    fn name(&mut self) -> Result<ExpressionPart, OkumaSyntaxError> {
        let start = self.cursor.at;
        let name = name_text(self.cursor);
        if name == "EMPTY" {
            return Ok(self.push(Op::Own(OkumaOp::Empty)));
        }
        let opens = self.cursor.peek() == Some(b'[');
        if let Some((name, known)) = math::named(name) {
            return self.function(name, known);
        }
        if opens && !name.starts_with('V') {
            self.list()?;
            let text = self.cursor.between(start).into();
            return Ok(self.push(Op::Own(OkumaOp::Unknown(text))));
        }
        let variable = self.variable(name)?;
        Ok(self.push(Op::Own(OkumaOp::Variable(variable))))
    }

    /// The arguments of a function.
    fn function(&mut self, name: &'static str, known: OkumaFunction) -> Result<ExpressionPart, OkumaSyntaxError> {
        let (start, at) = (self.ops.len(), self.cursor.at + 1);
        let arguments = self.list()?;
        let (wanted, words) = if matches!(known, OkumaFunction::Two(_)) { (2, "two values") } else { (1, "one value") };
        if arguments.len() != wanted {
            return Err(OkumaSyntaxError::Arguments(name, words, at));
        }
        self.ops.extend(arguments.into_iter().flat_map(CompiledExpression::into_ops));
        self.ops.push(match known {
            OkumaFunction::One(function) => Op::Apply(function),
            OkumaFunction::Steps(steps) => Op::Own(OkumaOp::Steps(steps)),
            OkumaFunction::Two(operator) => Op::Combine(operator),
        });
        Ok(ExpressionPart { start, truth: false })
    }

    /// The variable of a name that has just been read, with its indices.
    pub(super) fn variable(&mut self, name: &str) -> Result<OkumaVariable, OkumaSyntaxError> {
        if let Some(local) = names::local(name) {
            return Ok(OkumaVariable::Local(local));
        }
        let indices = match self.cursor.peek() {
            Some(b'[') => match self.address_of_io(name) {
                Some(address) => [Expr::constant(f64::from(address))].into(),
                None => self.list()?,
            },
            _ => Box::default(),
        };
        Ok(match (names::common(name), &*indices) {
            (Some((family, Some(number))), []) => OkumaVariable::Common(family, Box::new(Expr::constant(number))),
            (Some((family, None)), [index]) => OkumaVariable::Common(family, Box::new(index.clone())),
            _ => OkumaVariable::System(name.into(), indices),
        })
    }

    /// The address of inputs and outputs of the control, VIRD[003B]: hexadecimal digits without a mark.
    fn address_of_io(&mut self, name: &str) -> Option<u32> {
        if !matches!(name, "VIRD" | "VORD") {
            return None;
        }
        let start = self.cursor.at;
        self.cursor.expect(b'[', "'['").ok()?;
        let address = u32::from_str_radix(self.cursor.run(|byte| byte.is_ascii_hexdigit()), 16).ok();
        let closes = self.cursor.take(b']');
        if address.is_none() || !closes {
            self.cursor.at = start;
        }
        address.filter(|_| closes)
    }

    /// Values in brackets.
    pub(super) fn list(&mut self) -> Result<Box<[Expr]>, OkumaSyntaxError> {
        self.cursor.expect(b'[', "'['")?;
        let mut values = vec![self.expression()?];
        while self.cursor.take(b',') {
            values.push(self.expression()?);
        }
        self.cursor.expect(b']', "']'")?;
        Ok(values.into())
    }
}

/// The digits of a number without sign.
pub(super) fn number_text<'a>(cursor: &mut OkumaCursor<'a>) -> &'a str {
    let start = cursor.at;
    cursor.run(|byte| byte.is_ascii_digit());
    if cursor.here() == Some(b'.') {
        cursor.at += 1;
        cursor.run(|byte| byte.is_ascii_digit());
    }
    cursor.between(start)
}

/// The letters and then the digits of a name.
pub(super) fn name_text<'a>(cursor: &mut OkumaCursor<'a>) -> &'a str {
    cursor.peek();
    let start = cursor.at;
    cursor.run(|byte| byte.is_ascii_uppercase());
    cursor.run(|byte| byte.is_ascii_digit());
    cursor.between(start)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Expr {
        let mut cursor = OkumaCursor::new(text.as_bytes());
        let expr = OkumaExpressionReader::new(&mut cursor).expression().unwrap();
        cursor.end().unwrap();
        expr
    }

    #[test]
    fn the_order_of_operators() {
        for (text, brackets) in [
            ("1+2*3-4", "[1+[2*3]]-4"),
            ("1-2-3", "[1-2]-3"),
            ("VC1+1 EQ 2*3 AND 1 LT 2 OR LA", "[[[VC1+1] EQ [2*3]] AND [1 LT 2]] OR LA"),
            ("-LA1 MOD 3/2", "[[-LA1] MOD 3]/2"),
            ("NOT 1 EOR 2", "[NOT 1] EOR 2"),
            ("LA1EQ5", "LA1 EQ 5"),
        ] {
            assert_eq!(read(text), read(brackets), "{text}");
        }
    }

    #[test]
    fn variables() {
        assert!(matches!(read("LA1").as_own(), Some(OkumaOp::Variable(OkumaVariable::Local(_)))));
        assert!(matches!(read("VC[LA1]").as_own(), Some(OkumaOp::Variable(OkumaVariable::Common(Family::Vc, _)))));
        assert!(matches!(read("V33").as_own(), Some(OkumaOp::Variable(OkumaVariable::Common(Family::V, _)))));
        let system = OkumaVariable::System("VTOFX".into(), [Expr::constant(1.0)].into());
        assert_eq!(read("VTOFX[1]"), Expr::own(OkumaOp::Variable(system)));
        assert_eq!(read("HALF[ 1, 2]"), Expr::own(OkumaOp::Unknown("HALF[ 1, 2]".into())));
        assert_eq!(
            (read("#81H"), read("$fF".to_ascii_uppercase().as_str())),
            (Expr::constant(129.0), Expr::constant(255.0))
        );
        for (text, address) in [("VIRD[003B]", 59.0), ("VORD[0050]", 80.0)] {
            let system = OkumaVariable::System(text[..4].into(), [Expr::constant(address)].into());
            assert_eq!(read(text), Expr::own(OkumaOp::Variable(system)), "{text}");
        }
        assert_eq!((read("EMPTY"), read("-.5")), (Expr::own(OkumaOp::Empty), Expr::constant(-0.5)));
    }
}
