//! How expressions are read, for any words.
//!
//! *Invariant:* operators of one level bind from left to right. Reading recurses once per level and operand, so a bound
//! on the nesting of operands also bounds the stack.

use super::code::ExpressionOp;
use crate::numeric::{NumericFunction, NumericOperator};

/// Operators by level, loosest first: their words and their operations.
pub type Operators = &'static [&'static [(&'static str, NumericOperator)]];

/// Comparisons of the controls that write them as words.
pub const COMPARISONS: &[(&str, NumericOperator)] = &[
    ("EQ", NumericOperator::Eq),
    ("NE", NumericOperator::Ne),
    ("GT", NumericOperator::Gt),
    ("GE", NumericOperator::Ge),
    ("LT", NumericOperator::Lt),
    ("LE", NumericOperator::Le),
];

/// A prefix of an operand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PrefixOperator {
    /// Changes nothing.
    Plus,
    /// Changes the sign.
    Minus,
    /// Inverts a truth.
    Not,
    /// Inverts the bits of a number.
    NotBits,
    /// Inverts a truth if the operand is one, otherwise the bits.
    NotEither,
}

/// A compiled part: from one operation to the last one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ExpressionPart {
    /// Its first operation.
    pub start: usize,
    /// Its value is a truth.
    pub truth: bool,
}

/// The expressions of a dialect: its words, and their source.
pub trait Grammar {
    /// A constant of an expression.
    type Value: Clone;
    /// An operation that only this control has.
    type Own;
    /// Why a text is not an expression.
    type Mistake;

    /// The operators between two operands, by their words.
    const OPERATORS: Operators;
    /// The prefixes of operands, by their words.
    const SIGNS: &'static [(&'static str, PrefixOperator)];

    /// The part read so far.
    fn ops(&mut self) -> &mut Vec<ExpressionOp<Self::Value, Self::Own>>;

    /// Takes an operator or sign, if it is next in the text.
    fn takes(&mut self, word: &str) -> bool;

    /// Reads an operand without signs.
    ///
    /// # Errors
    /// There is none.
    fn operand(&mut self) -> Result<ExpressionPart, Self::Mistake>;

    /// A constant with its sign changed, if it is a number.
    fn negated(value: &Self::Value) -> Option<Self::Value>;

    /// Counts a level of nesting: an operand, or a sign before it.
    ///
    /// # Errors
    /// There are too many.
    fn nest(&mut self, _sign: bool) -> Result<(), Self::Mistake> {
        Ok(())
    }

    /// An operand with this many signs has been read.
    fn unnest(&mut self, _signs: usize) {}

    /// Operators of this level are understood here.
    fn allows(&self, _level: usize) -> bool {
        true
    }

    /// Whether the operator that was taken is allowed here; `chained` after another operator of its level.
    ///
    /// # Errors
    /// It is not.
    fn check(&mut self, _level: usize, _chained: bool) -> Result<(), Self::Mistake> {
        Ok(())
    }

    /// Adds an operand of one operation.
    fn push(&mut self, op: ExpressionOp<Self::Value, Self::Own>) -> ExpressionPart {
        let ops = self.ops();
        ops.push(op);
        ExpressionPart { start: ops.len() - 1, truth: false }
    }

    /// Adds a sign to an operand.
    fn sign(&mut self, sign: PrefixOperator, part: ExpressionPart) -> ExpressionPart {
        let function = match sign {
            PrefixOperator::Plus => return part,
            PrefixOperator::Minus => NumericFunction::Neg,
            PrefixOperator::Not => NumericFunction::Not,
            PrefixOperator::NotEither if part.truth => NumericFunction::Not,
            PrefixOperator::NotBits | PrefixOperator::NotEither => NumericFunction::NotBits,
        };
        let ops = self.ops();
        if let (NumericFunction::Neg, Some(ExpressionOp::Value(value))) = (function, ops.last_mut())
            && let Some(negated) = Self::negated(value)
        {
            // A constant is the last operation of its own operand only.
            *value = negated;
            return part;
        }
        ops.push(ExpressionOp::Apply(function));
        ExpressionPart { truth: function == NumericFunction::Not, ..part }
    }

    /// Adds an operator to its operands.
    fn join(&mut self, operator: NumericOperator, left: ExpressionPart, right: ExpressionPart) -> ExpressionPart {
        self.ops().push(ExpressionOp::Combine(operator));
        let bits = matches!(operator, NumericOperator::BitAnd | NumericOperator::BitOr | NumericOperator::BitXor);
        ExpressionPart { start: left.start, truth: operator.compares() || bits && left.truth && right.truth }
    }
}

/// Reads operands and operators of this level and tighter ones, as far as they go.
///
/// # Errors
/// An operand is missing, or an operator is not allowed.
pub fn read<G: Grammar + ?Sized>(grammar: &mut G, loosest: usize) -> Result<ExpressionPart, G::Mistake> {
    let mut left = signed(grammar)?;
    let mut before = None;
    while let Some((level, operator)) = operator(grammar, loosest) {
        grammar.check(level, before == Some(level))?;
        let right = read(grammar, level + 1)?;
        left = grammar.join(operator, left, right);
        before = Some(level);
    }
    Ok(left)
}

/// Takes the operator that follows, if its level is at least `loosest`: level and operator.
fn operator<G: Grammar + ?Sized>(grammar: &mut G, loosest: usize) -> Option<(usize, NumericOperator)> {
    for (level, operators) in G::OPERATORS.iter().enumerate().skip(loosest) {
        if grammar.allows(level)
            && let Some((_, operator)) = operators.iter().find(|(word, _)| grammar.takes(word))
        {
            return Some((level, *operator));
        }
    }
    None
}

/// Reads an operand with its signs.
///
/// # Errors
/// There is none, or it is nested too deeply.
pub fn signed<G: Grammar + ?Sized>(grammar: &mut G) -> Result<ExpressionPart, G::Mistake> {
    grammar.nest(false)?;
    let mut signs = Vec::new();
    while let Some((_, sign)) = G::SIGNS.iter().find(|(word, _)| grammar.takes(word)) {
        signs.push(*sign);
        grammar.nest(true)?;
    }
    let mut part = grammar.operand()?;
    grammar.unnest(signs.len());
    for sign in signs.into_iter().rev() {
        part = grammar.sign(sign, part);
    }
    Ok(part)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Digits with a few operators; its code is checked as text.
    struct Digits<'t> {
        text: &'t str,
        ops: Vec<ExpressionOp<u32, ()>>,
    }

    impl Grammar for Digits<'_> {
        type Value = u32;
        type Own = ();
        type Mistake = &'static str;

        const OPERATORS: Operators = &[
            &[("<", NumericOperator::Lt)],
            &[("+", NumericOperator::Add), ("-", NumericOperator::Sub), ("&", NumericOperator::BitAnd)],
            &[("*", NumericOperator::Mul), ("/", NumericOperator::Div)],
        ];
        const SIGNS: &'static [(&'static str, PrefixOperator)] =
            &[("-", PrefixOperator::Minus), ("!", PrefixOperator::NotEither)];

        fn ops(&mut self) -> &mut Vec<ExpressionOp<u32, ()>> {
            &mut self.ops
        }

        fn takes(&mut self, word: &str) -> bool {
            let rest = self.text.strip_prefix(word);
            self.text = rest.unwrap_or(self.text);
            rest.is_some()
        }

        fn operand(&mut self) -> Result<ExpressionPart, &'static str> {
            if self.takes("(") {
                let part = read(self, 0)?;
                return if self.takes(")") { Ok(part) } else { Err("open") };
            }
            let (digit, rest) = self.text.split_at_checked(1).ok_or("the end")?;
            self.text = rest;
            let value = digit.parse().map_err(|_| "not a digit")?;
            Ok(self.push(ExpressionOp::Value(value)))
        }

        fn negated(_: &u32) -> Option<u32> {
            None
        }

        fn check(&mut self, level: usize, chained: bool) -> Result<(), &'static str> {
            if level == 0 && chained { Err("a second comparison") } else { Ok(()) }
        }
    }

    fn postfix(text: &str) -> Result<String, &'static str> {
        let mut digits = Digits { text, ops: Vec::new() };
        read(&mut digits, 0)?;
        let op = |op: &ExpressionOp<u32, ()>| match op {
            ExpressionOp::Value(value) => value.to_string(),
            ExpressionOp::Combine(operator) => format!("{operator:?} "),
            ExpressionOp::CombineWith(operator, value) => format!("{value}{operator:?} "),
            ExpressionOp::Apply(function) => format!("{function:?} "),
            ExpressionOp::Own(()) => String::new(),
        };
        Ok(digits.ops.iter().map(op).collect())
    }

    #[test]
    fn tighter_operators_bind_first_and_equal_ones_from_left_to_right() {
        for (text, code) in [
            ("1-2-3", "12Sub 3Sub "),
            ("1+2*3-4", "123Mul Add 4Sub "),
            ("1*2/3<4+5", "12Mul 3Div 45Add Lt "),
            ("(1<2)*3", "12Lt 3Mul "),
            ("-1*--2", "1Neg 2Neg Neg Mul "),
        ] {
            assert_eq!(postfix(text).as_deref(), Ok(code), "{text}");
        }
        assert_eq!(postfix("1<2<3"), Err("a second comparison"));
        assert_eq!(postfix("1+"), Err("the end"));
    }

    #[test]
    fn truths_are_inverted_as_truths() {
        for (text, code) in [
            ("!1", "1NotBits "),
            ("!(1<2)", "12Lt Not "),
            ("!((1<2)&(3<4))", "12Lt 34Lt BitAnd Not "),
            ("!((1<2)&3)", "12Lt 3BitAnd NotBits "),
            ("!!(1<2)", "12Lt Not Not "),
        ] {
            assert_eq!(postfix(text).as_deref(), Ok(code), "{text}");
        }
    }
}
