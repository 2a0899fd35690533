//! Expressions: from text to postfix operations.
//!
//! Facts: reference control-emulator.md 5.4 (Fanuc row). Binding from weak to strong: `||`, `&&`, comparisons, sums
//! with OR and XOR, products with AND and MOD, signs. Invariant: the compiled code fits the stack of the evaluation.

use super::cursor::{FanucParser, FanucSyntaxError};
use super::expr::{Expr, FanucOp, Op, STACK};
use counterpoint_control_api::expression::{
    COMPARISONS, CompiledExpression, ExpressionPart, Grammar, Operators, PrefixOperator, read,
};
use counterpoint_control_api::numeric::{NAMED, NumericFunction, NumericOperator};

/// Functions of one argument in brackets besides those of all controls.
const FUNCTIONS: &[(&str, Op)] = &[
    ("ATAN", Op::Apply(NumericFunction::Atan)),
    ("SQR", Op::Apply(NumericFunction::Sqrt)),
    ("ROUND", Op::Own(FanucOp::Round)),
    ("FIX", Op::Apply(NumericFunction::Fix)),
    ("FUP", Op::Apply(NumericFunction::Fup)),
    ("BIN", Op::Apply(NumericFunction::Bin)),
    ("BCD", Op::Apply(NumericFunction::Bcd)),
];

/// Level of comparisons, which are understood inside brackets only.
const COMPARING: usize = 2;
/// Level of sums.
const SUMS: usize = 3;

/// Reads an expression into postfix operations.
struct FanucExpressionReader<'p, 't> {
    parser: &'p mut FanucParser<'t>,
    ops: &'p mut Vec<Op>,
    /// Inside brackets.
    compares: bool,
}

impl Grammar for FanucExpressionReader<'_, '_> {
    type Value = f64;
    type Own = FanucOp;
    type Mistake = FanucSyntaxError;

    const OPERATORS: Operators = &[
        &[("||", NumericOperator::Or)],
        &[("&&", NumericOperator::And)],
        COMPARISONS,
        &[
            ("+", NumericOperator::Add),
            ("-", NumericOperator::Sub),
            ("|", NumericOperator::BitOr),
            ("OR", NumericOperator::BitOr),
            ("XOR", NumericOperator::BitXor),
        ],
        &[
            ("*", NumericOperator::Mul),
            ("/", NumericOperator::Div),
            ("&", NumericOperator::BitAnd),
            ("AND", NumericOperator::BitAnd),
            ("MOD", NumericOperator::RemOfWhole),
        ],
    ];
    const SIGNS: &'static [(&'static str, PrefixOperator)] =
        &[("-", PrefixOperator::Minus), ("+", PrefixOperator::Plus)];

    fn ops(&mut self) -> &mut Vec<Op> {
        self.ops
    }

    fn takes(&mut self, word: &str) -> bool {
        self.parser.takes(word)
    }

    fn operand(&mut self) -> Result<ExpressionPart, FanucSyntaxError> {
        let start = self.ops.len();
        self.parser.primary(self.ops)?;
        Ok(ExpressionPart { start, truth: false })
    }

    fn negated(value: &f64) -> Option<f64> {
        Some(-value)
    }

    fn allows(&self, level: usize) -> bool {
        level != COMPARING || self.compares
    }

    fn sign(&mut self, sign: PrefixOperator, part: ExpressionPart) -> ExpressionPart {
        match (sign, self.ops.last_mut()) {
            (PrefixOperator::Minus, Some(Op::Value(value))) => *value = -*value,
            // Two signs leave a vacant value vacant.
            (PrefixOperator::Minus, Some(Op::Apply(NumericFunction::Neg))) => {
                self.ops.pop();
            }
            (PrefixOperator::Minus, _) => self.ops.push(Op::Apply(NumericFunction::Neg)),
            _ => {}
        }
        part
    }
}

impl FanucParser<'_> {
    /// An expression that fits the evaluation stack.
    pub(super) fn checked(&self, ops: Vec<Op>) -> Result<Expr, FanucSyntaxError> {
        let (mut depth, mut most) = (0_usize, 0_usize);
        for op in &ops {
            match op {
                Op::Value(_) | Op::Own(FanucOp::Variable(_) | FanucOp::Unknown(..)) => depth += 1,
                Op::Combine(_) => depth = depth.saturating_sub(1),
                Op::Apply(_) | Op::CombineWith(..) | Op::Own(FanucOp::Indirect | FanucOp::Round | FanucOp::Minus) => {}
            }
            most = most.max(depth);
        }
        if most > STACK { Err(self.error("a shorter expression")) } else { Ok(CompiledExpression::new(ops)) }
    }

    /// An expression outside brackets: without comparisons.
    pub(super) fn logical(&mut self, ops: &mut Vec<Op>) -> Result<(), FanucSyntaxError> {
        read(&mut FanucExpressionReader { parser: self, ops, compares: false }, 0).map(|_| ())
    }

    /// An expression inside brackets.
    pub(super) fn relation(&mut self, ops: &mut Vec<Op>) -> Result<(), FanucSyntaxError> {
        read(&mut FanucExpressionReader { parser: self, ops, compares: true }, 0).map(|_| ())
    }

    /// A sum.
    pub(super) fn expression(&mut self, ops: &mut Vec<Op>) -> Result<(), FanucSyntaxError> {
        read(&mut FanucExpressionReader { parser: self, ops, compares: false }, SUMS).map(|_| ())
    }

    /// Takes an operator or sign that is next; two letters of a word are enough, except for MOD.
    fn takes(&mut self, word: &str) -> bool {
        self.blanks();
        let here = self.text.get(self.at..).unwrap_or_default();
        let starts =
            |begin: &str| here.get(..begin.len()).is_some_and(|text| text.eq_ignore_ascii_case(begin.as_bytes()));
        let least = if word == "MOD" { word } else { word.get(..2).unwrap_or(word) };
        let length = match word.as_bytes() {
            // A doubled one is another operator.
            [sign @ (b'|' | b'&')] if here.get(1) == Some(sign) => 0,
            _ if starts(word) => word.len(),
            _ if starts(least) => least.len(),
            _ => 0,
        };
        self.at += length;
        length > 0
    }

    pub(super) fn primary(&mut self, ops: &mut Vec<Op>) -> Result<(), FanucSyntaxError> {
        match self.peek() {
            Some(b'#') => {
                self.at += 1;
                let mut number = Vec::new();
                self.variable_number(&mut number)?;
                match number.as_slice() {
                    [Op::Value(n)] if *n >= 0.0 && n.fract() == 0.0 && *n <= f64::from(u32::MAX) => {
                        ops.push(Op::Own(FanucOp::Variable(*n as u32)));
                    }
                    _ => {
                        ops.append(&mut number);
                        ops.push(Op::Own(FanucOp::Indirect));
                    }
                }
                Ok(())
            }
            Some(b'[') => self.bracketed(ops),
            Some(b'0'..=b'9' | b'.') => {
                ops.push(Op::Value(self.literal()?));
                Ok(())
            }
            Some(byte) if byte.is_ascii_uppercase() => self.function(ops),
            _ => Err(self.error("a value")),
        }
    }

    /// The text after `#`: digits, `[expression]` or another variable.
    pub(super) fn variable_number(&mut self, ops: &mut Vec<Op>) -> Result<(), FanucSyntaxError> {
        match self.peek() {
            Some(b'0'..=b'9') => {
                ops.push(Op::Value(f64::from(self.unsigned().unwrap_or(0))));
                Ok(())
            }
            Some(b'[') => self.bracketed(ops),
            Some(b'#') => {
                self.nest()?;
                self.primary(ops)?;
                self.depth -= 1;
                Ok(())
            }
            _ => Err(self.error("a variable number")),
        }
    }

    pub(super) fn bracketed(&mut self, ops: &mut Vec<Op>) -> Result<(), FanucSyntaxError> {
        self.nest()?;
        self.at += 1;
        self.relation(ops)?;
        if !self.accept(b']') {
            return Err(self.error("']'"));
        }
        self.depth -= 1;
        Ok(())
    }

    fn literal(&mut self) -> Result<f64, FanucSyntaxError> {
        let start = self.at;
        while matches!(self.text.get(self.at), Some(b'0'..=b'9' | b'.')) {
            self.at += 1;
        }
        std::str::from_utf8(self.text.get(start..self.at).unwrap_or_default())
            .ok()
            .and_then(|s| s.parse().ok())
            .ok_or_else(|| self.error("a number"))
    }

    fn function(&mut self, ops: &mut Vec<Op>) -> Result<(), FanucSyntaxError> {
        let letters = self.letters();
        if letters == "POW" && self.text.get(self.at + 3) == Some(&b'[') {
            self.at += 3;
            return self.power(ops);
        }
        // The longest name wins; two letters of a name are enough.
        let mut best: Option<(Op, usize)> = None;
        let common = NAMED.iter().map(|(name, function)| (*name, Op::Apply(*function)));
        for (name, op) in common.chain(FUNCTIONS.iter().copied()) {
            let common = name.bytes().zip(letters.bytes()).take_while(|(a, b)| a == b).count();
            if common >= 2 && common == letters.len() && best.is_none_or(|(_, n)| n < common) {
                best = Some((op, common));
            }
        }
        let Some((op, length)) = best else {
            return self.unknown_function(ops);
        };
        self.at += length;
        if self.peek() != Some(b'[') {
            return Err(self.error("'[' after the function"));
        }
        if op == Op::Apply(NumericFunction::Atan) {
            return self.arc_tangent(ops);
        }
        self.bracketed(ops)?;
        ops.push(op);
        if op == Op::Apply(NumericFunction::Asin) && self.names.formulas.full_angles {
            ops.push(Op::Apply(NumericFunction::FullTurn));
        }
        Ok(())
    }

    /// The arguments of `POW[base,exponent]`.
    fn power(&mut self, ops: &mut Vec<Op>) -> Result<(), FanucSyntaxError> {
        self.nest()?;
        self.at += 1;
        self.relation(ops)?;
        if !self.accept(b',') {
            return Err(self.error("',' and the exponent"));
        }
        self.relation(ops)?;
        if !self.accept(b']') {
            return Err(self.error("']'"));
        }
        self.depth -= 1;
        ops.push(Op::Combine(NumericOperator::Power));
        Ok(())
    }

    /// Whether a function begins here that the control has.
    pub(super) fn stands_function(&mut self) -> bool {
        let letters = self.letters();
        let mut names = NAMED.iter().map(|(name, _)| name).chain(FUNCTIONS.iter().map(|(name, _)| name));
        letters == "POW" || letters.len() >= 2 && names.any(|name| name.starts_with(&letters))
    }

    /// `NAME[…]` that the control does not have: the machine may know its value.
    fn unknown_function(&mut self, ops: &mut Vec<Op>) -> Result<(), FanucSyntaxError> {
        let start = self.at;
        let name = self.text.get(start..).unwrap_or_default();
        let name = name.iter().take_while(|byte| byte.is_ascii_alphanumeric() || **byte == b'_').count();
        self.at += name;
        if self.peek() != Some(b'[') {
            self.at = start;
            return Err(self.error("a value"));
        }
        let mut open = 0_usize;
        while let Some(byte) = self.text.get(self.at) {
            self.at += 1;
            match byte {
                b'[' => open += 1,
                b']' if open == 1 => {
                    ops.push(Op::Own(FanucOp::Unknown(start as u32, self.at as u32)));
                    return Ok(());
                }
                b']' => open -= 1,
                _ => {}
            }
        }
        Err(self.error("']'"))
    }

    /// The arguments of `ATAN[y]`, `ATAN[y]/[x]`, `ATAN[y,x]`.
    fn arc_tangent(&mut self, ops: &mut Vec<Op>) -> Result<(), FanucSyntaxError> {
        self.nest()?;
        self.at += 1;
        self.relation(ops)?;
        let two = self.accept(b',');
        if two {
            self.relation(ops)?;
        }
        if !self.accept(b']') {
            return Err(self.error("']'"));
        }
        self.depth -= 1;
        let of_two =
            Op::Combine(if self.names.formulas.full_angles { NumericOperator::Angle } else { NumericOperator::Atan2 });
        let mark = self.at;
        if !two && self.accept(b'/') && self.peek() == Some(b'[') {
            self.bracketed(ops)?;
            ops.push(of_two);
            return Ok(());
        }
        self.at = mark;
        ops.push(if two { of_two } else { Op::Apply(NumericFunction::Atan) });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::compile;
    use super::super::expr::{self, FanucValueError, VariableAccess};
    use super::super::statement::FanucStatement;
    use counterpoint_control_api::numeric::VACANT;
    use counterpoint_program::key_words::StatementVocabulary;

    struct Fixed;

    impl VariableAccess for Fixed {
        fn get(&mut self, index: u32) -> Result<f64, FanucValueError> {
            Ok(match index {
                0 | 9 => VACANT,
                n => f64::from(n),
            })
        }
    }

    fn value(text: &str) -> Result<f64, FanucValueError> {
        value_by(text, StatementVocabulary::default())
    }

    fn value_by(text: &str, names: StatementVocabulary<'_>) -> Result<f64, FanucValueError> {
        let line = compile(format!("#1={text}").as_bytes(), names).unwrap();
        let FanucStatement::Assign(list) = line.statement else { panic!("no assignment") };
        expr::value(&list[0].1, &mut Fixed)
    }

    /// Reference fanuc-variables-and-alarms.md, rows of ASIN and ATAN with parameter 6004#0.
    #[test]
    fn angles_of_a_full_turn() {
        let mut names = StatementVocabulary::default();
        names.formulas.full_angles = true;
        let angles = [("ATAN[3]/[-4]", 143.1301), ("ATAN[-3]/[-4]", 216.8699), ("ATAN[-3,-4]", 216.8699)];
        let others = [("ATAN[0.75]", 36.8699), ("ATAN[-0.75]", -36.8699), ("ASIN[-0.5]", 330.0), ("ACOS[-0.5]", 120.0)];
        for (text, expected) in angles.into_iter().chain(others) {
            assert_eq!((value_by(text, names).unwrap() * 1e4).round() / 1e4, expected, "{text}");
        }
    }

    #[test]
    fn operators_bind_as_on_the_control() {
        for (text, expected) in [
            ("1+2*3", 7.0),
            ("[1+2]*3", 9.0),
            ("-2*-3", 6.0),
            ("7MOD3", 1.0),
            ("#[2+3]", 5.0),
            ("##3", 3.0),
            ("SIN[30]", 0.5),
            ("COS[90]", 0.0),
            ("ATAN[1]/[-1]", 135.0),
            ("ATAN[-1]/[-1]", -135.0),
            ("ATAN[1]", 45.0),
            ("POW[2,3]*2", 16.0),
            ("POW[2+2,0.5]", 2.0),
            ("SQRT[#4*#4+9]", 5.0),
            ("FIX[-2.5]", -2.0),
            ("FUP[2.1]", 3.0),
            ("ROUND[2.5]", 3.0),
            ("[#3EQ3]AND[2LT1]", 0.0),
            ("[#3EQ3]OR[2LT1]", 1.0),
            ("6AN3", 2.0),
            ("6XO3", 5.0),
            ("6&&3", 1.0),
            ("0||[2&&0]", 0.0),
            ("[1EQ1&&2EQ3||4GT3]", 1.0),
            ("[1EQ2&&2EQ2]", 0.0),
            ("ATAN[1,-1]", 135.0),
            ("ATAN[1]/2", 22.5),
            ("[#9EQ#0]", 1.0),
            ("[#9EQ0]", 0.0),
            ("#9+1", 1.0),
        ] {
            let found = value(text).unwrap();
            assert!((found - expected).abs() < 1e-12, "{text}: {found}");
        }
    }

    #[test]
    fn faults_are_reported() {
        assert_eq!(value("1/0"), Err(FanucValueError::Division));
        assert!(matches!(value("SQRT[-1]"), Err(FanucValueError::Domain("SQRT", _))));
        assert!(matches!(value("#[0-1.5]"), Err(FanucValueError::NoVariable(_))));
    }
}
