//! Expressions: their compiled form and their reader.
//!
//! Facts: LinuxCNC documentation, "Expressions", "Binary operators", "Functions". *Invariant:* an expression has at
//! most [`MOST`] parts and [`DEEPEST`] nested brackets, so reading, evaluating and dropping it never overflow the
//! stack.

use super::text::{Rs274Cursor, Rs274Mistake};
use counterpoint_control_api::expression::{
    self, CompiledExpression, ExpressionPart, Grammar, Operators, PrefixOperator, read, signed,
};
use counterpoint_control_api::numeric::{NumericFunction, NumericOperator};

/// Largest number of parts of an expression.
const MOST: usize = 256;

/// Largest depth of nested brackets and signs.
const DEEPEST: usize = 40;

/// An operation that only this control has.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Rs274Op {
    /// The parameter with this number.
    Fixed(u32),
    /// The parameter whose number is the last value.
    Numbered,
    Named(Box<str>),
    /// Whether a parameter with this name exists.
    Exists(Box<str>),
    /// Whether a parameter with the last value as its number exists.
    ExistsNumber,
}

pub(super) type Rs274Expr = CompiledExpression<f64, Rs274Op>;

type Op = expression::ExpressionOp<f64, Rs274Op>;

/// A parameter that is set.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum ParameterName {
    Number(Rs274Expr),
    Named(Box<str>),
}

/// Functions of one value in addition to those of all controls.
const FUNCTIONS: &[(&str, NumericFunction)] = &[
    ("abs", NumericFunction::Abs),
    ("acos", NumericFunction::Acos),
    ("asin", NumericFunction::Asin),
    ("cos", NumericFunction::Cos),
    ("exp", NumericFunction::Exp),
    ("fix", NumericFunction::Floor),
    ("fup", NumericFunction::Ceil),
    ("ln", NumericFunction::Ln),
    ("round", NumericFunction::Round),
    ("sin", NumericFunction::Sin),
    ("sqrt", NumericFunction::Sqrt),
    ("tan", NumericFunction::Tan),
];

/// Reads expressions.
pub(super) struct Rs274ExpressionReader<'c, 't> {
    cursor: &'c mut Rs274Cursor<'t>,
    ops: Vec<Op>,
    parts: usize,
    depth: usize,
}

impl Grammar for Rs274ExpressionReader<'_, '_> {
    type Value = f64;
    type Own = Rs274Op;
    type Mistake = Rs274Mistake;

    const OPERATORS: Operators = &[
        &[("and", NumericOperator::And), ("or", NumericOperator::Or), ("xor", NumericOperator::Xor)],
        &[
            ("eq", NumericOperator::EqNear),
            ("ne", NumericOperator::NeNear),
            ("gt", NumericOperator::Gt),
            ("ge", NumericOperator::Ge),
            ("lt", NumericOperator::Lt),
            ("le", NumericOperator::Le),
        ],
        &[("+", NumericOperator::Add), ("-", NumericOperator::Sub)],
        &[("*", NumericOperator::Mul), ("/", NumericOperator::Div), ("mod", NumericOperator::RemPositive)],
        &[("**", NumericOperator::Power)],
    ];
    const SIGNS: &'static [(&'static str, PrefixOperator)] =
        &[("+", PrefixOperator::Plus), ("-", PrefixOperator::Minus)];

    fn ops(&mut self) -> &mut Vec<Op> {
        &mut self.ops
    }

    fn takes(&mut self, word: &str) -> bool {
        if word == "*" && self.cursor.next() == Some(b'*') {
            return false;
        }
        self.cursor.takes(word)
    }

    fn operand(&mut self) -> Result<ExpressionPart, Rs274Mistake> {
        match self.cursor.here() {
            Some(b'[') => self.bracket(),
            Some(b'#') => self.parameter(),
            Some(b'a'..=b'z') => self.function(),
            _ => match self.cursor.number() {
                Some(value) => Ok(self.push(Op::Value(value))),
                None => Err(self.cursor.expected("a value")),
            },
        }
    }

    fn negated(value: &f64) -> Option<f64> {
        Some(-value)
    }

    fn nest(&mut self, _: bool) -> Result<(), Rs274Mistake> {
        self.count()?;
        self.depth += 1;
        if self.depth > DEEPEST { Err(too_long()) } else { Ok(()) }
    }

    fn unnest(&mut self, signs: usize) {
        self.depth -= signs + 1;
    }

    fn check(&mut self, _: usize, _: bool) -> Result<(), Rs274Mistake> {
        self.count()
    }
}

fn too_long() -> Rs274Mistake {
    Rs274Mistake::syntax("the expression is too long: divide it over several blocks")
}

impl<'c, 't> Rs274ExpressionReader<'c, 't> {
    pub(super) fn new(cursor: &'c mut Rs274Cursor<'t>) -> Self {
        Self { cursor, ops: Vec::new(), parts: 0, depth: 0 }
    }

    /// The value of a word: a number, a parameter, a function or an expression in brackets, with signs before it.
    pub(super) fn value(mut self) -> Result<Rs274Expr, Rs274Mistake> {
        signed(&mut self)?;
        Ok(CompiledExpression::new(self.ops))
    }

    /// An expression in brackets.
    pub(super) fn bracketed(mut self) -> Result<Rs274Expr, Rs274Mistake> {
        self.bracket()?;
        Ok(CompiledExpression::new(self.ops))
    }

    fn count(&mut self) -> Result<(), Rs274Mistake> {
        self.parts += 1;
        if self.parts > MOST { Err(too_long()) } else { Ok(()) }
    }

    fn bracket(&mut self) -> Result<ExpressionPart, Rs274Mistake> {
        self.cursor.expect("[")?;
        let inside = read(self, 0)?;
        self.cursor.expect("]")?;
        Ok(inside)
    }

    fn function(&mut self) -> Result<ExpressionPart, Rs274Mistake> {
        let start = self.ops.len();
        if self.cursor.takes("atan") {
            self.bracket()?;
            self.cursor.expect("/")?;
            self.bracket()?;
            self.ops.push(Op::Combine(NumericOperator::Atan2));
            return Ok(ExpressionPart { start, truth: false });
        }
        if self.cursor.takes("exists") {
            self.cursor.expect("[")?;
            self.cursor.expect("#")?;
            if self.cursor.here() == Some(b'<') {
                let name = name(self.cursor)?;
                self.cursor.expect("]")?;
                return Ok(self.push(Op::Own(Rs274Op::Exists(name))));
            }
            signed(self)?;
            self.cursor.expect("]")?;
            self.ops.push(Op::Own(Rs274Op::ExistsNumber));
            return Ok(ExpressionPart { start, truth: false });
        }
        let Some((_, function)) = FUNCTIONS.iter().find(|(name, _)| self.cursor.takes(name)) else {
            return Err(self.cursor.expected("a value"));
        };
        self.bracket()?;
        self.ops.push(Op::Apply(*function));
        Ok(ExpressionPart { start, truth: false })
    }

    fn parameter(&mut self) -> Result<ExpressionPart, Rs274Mistake> {
        self.cursor.expect("#")?;
        if self.cursor.here() == Some(b'<') {
            let name = name(self.cursor)?;
            return Ok(self.push(Op::Own(Rs274Op::Named(name))));
        }
        let start = self.ops.len();
        signed(self)?;
        let op = match (self.ops.len() == start + 1, self.ops.last()) {
            (true, Some(Op::Value(number))) => number_of(*number).map(Rs274Op::Fixed),
            _ => None,
        };
        match op {
            Some(op) => {
                self.ops.pop();
                self.ops.push(Op::Own(op));
            }
            None => self.ops.push(Op::Own(Rs274Op::Numbered)),
        }
        Ok(ExpressionPart { start, truth: false })
    }
}

/// The number of a parameter, which must be close to a whole number.
pub(super) fn number_of(value: f64) -> Option<u32> {
    let whole = value.round();
    ((value - whole).abs() < 0.0001 && (1.0..=1e6).contains(&whole)).then_some(whole as u32)
}

/// A name in angle brackets.
pub(super) fn name(cursor: &mut Rs274Cursor<'_>) -> Result<Box<str>, Rs274Mistake> {
    cursor.expect("<")?;
    let name = cursor.run(|byte| byte != b'>');
    cursor.expect(">")?;
    if name.is_empty() { Err(Rs274Mistake::syntax("the name in '< >' is empty")) } else { Ok(name.into()) }
}

/// The parameter that an assignment names, after its `#`.
pub(super) fn parameter_name(cursor: &mut Rs274Cursor<'_>) -> Result<ParameterName, Rs274Mistake> {
    if cursor.here() == Some(b'<') {
        return name(cursor).map(ParameterName::Named);
    }
    Rs274ExpressionReader::new(cursor).value().map(ParameterName::Number)
}

#[cfg(test)]
mod tests {
    use super::super::text::BlockText;
    use super::*;

    fn read(text: &str) -> Rs274Expr {
        let text = BlockText::read(text.as_bytes()).unwrap();
        Rs274ExpressionReader::new(&mut Rs274Cursor::new(&text)).value().unwrap()
    }

    #[test]
    fn the_order_of_operators() {
        for (text, brackets) in [
            ("[1+2*3-4]", "[[1+[2*3]]-4]"),
            ("[2*3**2]", "[2*[3**2]]"),
            ("[#1 GT 2 AND #2 LT 3 OR #3]", "[[[#1 GT 2] AND [#2 LT 3]] OR #3]"),
            ("[7 MOD 3 EQ 1]", "[[7 MOD 3] EQ 1]"),
            ("[2**3**2]", "[[2**3]**2]"),
        ] {
            assert_eq!(read(text), read(brackets), "{text}");
        }
    }

    #[test]
    fn a_sign_of_a_parameter_binds_tighter_than_operators() {
        assert_eq!(read("#1"), Rs274Expr::own(Rs274Op::Fixed(1)));
        assert_eq!(read("#[#2]").ops().len(), 2);
        assert_eq!(read("##2"), read("#[#2]"));
        assert_eq!(read("#<P a R am>"), Rs274Expr::own(Rs274Op::Named("param".into())));
        assert_eq!(read("-2").as_constant(), Some(&-2.0));
    }
}
