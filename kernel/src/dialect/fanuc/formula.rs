//! Expressions: from text to postfix operations.
//!
//! Facts: reference control-emulator.md 5.4 (Fanuc row). Binding from weak to strong: `||`, `&&`, comparisons, sums
//! with OR and XOR, products with AND and MOD, signs. Invariant: what is made fits the stack of the evaluation.

use super::cursor::{Error, Parser};
use super::expr::{Expr, Op, STACK};

/// Functions of one argument in brackets.
const FUNCTIONS: &[(&str, Op)] = &[
    ("SIN", Op::Sin),
    ("COS", Op::Cos),
    ("TAN", Op::Tan),
    ("ASIN", Op::Asin),
    ("ACOS", Op::Acos),
    ("ATAN", Op::Atan),
    ("SQRT", Op::Sqrt),
    ("SQR", Op::Sqrt),
    ("ABS", Op::Abs),
    ("ROUND", Op::Round),
    ("FIX", Op::Fix),
    ("FUP", Op::Fup),
    ("LN", Op::Ln),
    ("EXP", Op::Exp),
    ("BIN", Op::Bin),
    ("BCD", Op::Bcd),
];

/// What stands between `&&` and `||`.
#[derive(Debug, Clone, Copy)]
pub(super) enum Operand {
    /// Outside brackets: no comparisons.
    Expression,
    /// Inside brackets.
    Relation,
}

impl Parser<'_> {
    /// An expression that fits the evaluation stack.
    pub(super) fn checked(&self, ops: Vec<Op>) -> Result<Expr, Error> {
        let (mut depth, mut most) = (0_usize, 0_usize);
        for op in &ops {
            match op {
                Op::Number(_) | Op::Variable(_) | Op::Unknown(..) => depth += 1,
                Op::Add
                | Op::Sub
                | Op::Mul
                | Op::Div
                | Op::Mod
                | Op::And
                | Op::Or
                | Op::Xor
                | Op::Both
                | Op::Either
                | Op::Eq
                | Op::Ne
                | Op::Gt
                | Op::Ge
                | Op::Lt
                | Op::Le
                | Op::Atan2 => depth = depth.saturating_sub(1),
                _ => {}
            }
            most = most.max(depth);
        }
        if most > STACK { Err(self.error("a shorter expression")) } else { Ok(Expr { ops }) }
    }

    /// Lowest binding: `||`, then `&&`, between operands of one kind.
    pub(super) fn logical(&mut self, ops: &mut Vec<Op>, operand: Operand) -> Result<(), Error> {
        self.conjunction(ops, operand)?;
        while self.accept_pair(b'|') {
            self.conjunction(ops, operand)?;
            ops.push(Op::Either);
        }
        Ok(())
    }

    fn conjunction(&mut self, ops: &mut Vec<Op>, operand: Operand) -> Result<(), Error> {
        let read = |parser: &mut Self, ops: &mut Vec<Op>| match operand {
            Operand::Expression => parser.expression(ops),
            Operand::Relation => parser.relation(ops),
        };
        read(self, ops)?;
        while self.accept_pair(b'&') {
            read(self, ops)?;
            ops.push(Op::Both);
        }
        Ok(())
    }

    fn stands_pair(&mut self, byte: u8) -> bool {
        self.peek() == Some(byte) && self.text.get(self.at + 1) == Some(&byte)
    }

    fn accept_pair(&mut self, byte: u8) -> bool {
        let found = self.stands_pair(byte);
        if found {
            self.at += 2;
        }
        found
    }

    /// Comparisons.
    fn relation(&mut self, ops: &mut Vec<Op>) -> Result<(), Error> {
        self.expression(ops)?;
        loop {
            let op = match self.letters().get(..2) {
                Some("EQ") => Op::Eq,
                Some("NE") => Op::Ne,
                Some("GT") => Op::Gt,
                Some("GE") => Op::Ge,
                Some("LT") => Op::Lt,
                Some("LE") => Op::Le,
                _ => return Ok(()),
            };
            self.at += 2;
            self.expression(ops)?;
            ops.push(op);
        }
    }

    pub(super) fn expression(&mut self, ops: &mut Vec<Op>) -> Result<(), Error> {
        self.term(ops)?;
        loop {
            let letters = self.letters();
            let op = match self.peek() {
                Some(b'+') => {
                    self.at += 1;
                    Op::Add
                }
                Some(b'-') => {
                    self.at += 1;
                    Op::Sub
                }
                Some(b'|') if !self.stands_pair(b'|') => {
                    self.at += 1;
                    Op::Or
                }
                _ if letters.starts_with("OR") => {
                    self.at += 2;
                    Op::Or
                }
                _ if letters.starts_with("XO") => {
                    self.at += if letters.starts_with("XOR") { 3 } else { 2 };
                    Op::Xor
                }
                _ => return Ok(()),
            };
            self.term(ops)?;
            ops.push(op);
        }
    }

    fn term(&mut self, ops: &mut Vec<Op>) -> Result<(), Error> {
        self.signed(ops)?;
        loop {
            let letters = self.letters();
            let op = match self.peek() {
                Some(b'*') => {
                    self.at += 1;
                    Op::Mul
                }
                Some(b'/') => {
                    self.at += 1;
                    Op::Div
                }
                Some(b'&') if !self.stands_pair(b'&') => {
                    self.at += 1;
                    Op::And
                }
                _ if letters.starts_with("AN") => {
                    self.at += if letters.starts_with("AND") { 3 } else { 2 };
                    Op::And
                }
                _ if letters.starts_with("MOD") => {
                    self.at += 3;
                    Op::Mod
                }
                _ => return Ok(()),
            };
            self.signed(ops)?;
            ops.push(op);
        }
    }

    fn signed(&mut self, ops: &mut Vec<Op>) -> Result<(), Error> {
        let mut negative = false;
        loop {
            if self.accept(b'-') {
                negative = !negative;
            } else if !self.accept(b'+') {
                break;
            }
        }
        self.primary(ops)?;
        if negative {
            ops.push(Op::Neg);
        }
        Ok(())
    }

    pub(super) fn primary(&mut self, ops: &mut Vec<Op>) -> Result<(), Error> {
        match self.peek() {
            Some(b'#') => {
                self.at += 1;
                let mut number = Vec::new();
                self.variable_number(&mut number)?;
                match number.as_slice() {
                    [Op::Number(n)] if *n >= 0.0 && n.fract() == 0.0 && *n <= f64::from(u32::MAX) => {
                        ops.push(Op::Variable(*n as u32));
                    }
                    _ => {
                        ops.append(&mut number);
                        ops.push(Op::Indirect);
                    }
                }
                Ok(())
            }
            Some(b'[') => self.bracketed(ops),
            Some(b'0'..=b'9' | b'.') => {
                ops.push(Op::Number(self.literal()?));
                Ok(())
            }
            Some(byte) if byte.is_ascii_uppercase() => self.function(ops),
            _ => Err(self.error("a value")),
        }
    }

    /// What stands after `#`: digits, `[expression]` or another variable.
    pub(super) fn variable_number(&mut self, ops: &mut Vec<Op>) -> Result<(), Error> {
        match self.peek() {
            Some(b'0'..=b'9') => {
                ops.push(Op::Number(f64::from(self.unsigned().unwrap_or(0))));
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

    pub(super) fn bracketed(&mut self, ops: &mut Vec<Op>) -> Result<(), Error> {
        self.nest()?;
        self.at += 1;
        self.logical(ops, Operand::Relation)?;
        if !self.accept(b']') {
            return Err(self.error("']'"));
        }
        self.depth -= 1;
        Ok(())
    }

    fn literal(&mut self) -> Result<f64, Error> {
        let start = self.at;
        while matches!(self.text.get(self.at), Some(b'0'..=b'9' | b'.')) {
            self.at += 1;
        }
        std::str::from_utf8(self.text.get(start..self.at).unwrap_or_default())
            .ok()
            .and_then(|s| s.parse().ok())
            .ok_or_else(|| self.error("a number"))
    }

    fn function(&mut self, ops: &mut Vec<Op>) -> Result<(), Error> {
        let letters = self.letters();
        // The longest name wins; two letters of a name are enough.
        let mut best: Option<(Op, usize)> = None;
        for &(name, op) in FUNCTIONS {
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
        if op == Op::Atan {
            return self.arc_tangent(ops);
        }
        self.bracketed(ops)?;
        ops.push(op);
        Ok(())
    }

    /// A function begins here that the control has.
    pub(super) fn stands_function(&mut self) -> bool {
        let letters = self.letters();
        letters.len() >= 2 && FUNCTIONS.iter().any(|(name, _)| name.starts_with(&letters))
    }

    /// `NAME[…]` that the control does not have: the machine may know its value.
    fn unknown_function(&mut self, ops: &mut Vec<Op>) -> Result<(), Error> {
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
                    ops.push(Op::Unknown(start as u32, self.at as u32));
                    return Ok(());
                }
                b']' => open -= 1,
                _ => {}
            }
        }
        Err(self.error("']'"))
    }

    /// The arguments of `ATAN[y]`, `ATAN[y]/[x]`, `ATAN[y,x]`.
    fn arc_tangent(&mut self, ops: &mut Vec<Op>) -> Result<(), Error> {
        self.nest()?;
        self.at += 1;
        self.logical(ops, Operand::Relation)?;
        let two = self.accept(b',');
        if two {
            self.logical(ops, Operand::Relation)?;
        }
        if !self.accept(b']') {
            return Err(self.error("']'"));
        }
        self.depth -= 1;
        let mark = self.at;
        if !two && self.accept(b'/') && self.peek() == Some(b'[') {
            self.bracketed(ops)?;
            ops.push(Op::Atan2);
            return Ok(());
        }
        self.at = mark;
        ops.push(if two { Op::Atan2 } else { Op::Atan });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::compile;
    use super::super::expr::{Fault, Variables};
    use super::super::statement::Statement;
    use crate::dialect::numeric::VACANT;
    use crate::mcd::key_words::Names;

    struct Fixed;

    impl Variables for Fixed {
        fn get(&mut self, index: u32) -> Result<f64, Fault> {
            Ok(match index {
                0 | 9 => VACANT,
                n => f64::from(n),
            })
        }
    }

    fn value(text: &str) -> Result<f64, Fault> {
        let line = compile(format!("#1={text}").as_bytes(), Names::default()).unwrap();
        let Statement::Assign(list) = line.statement else { panic!("no assignment") };
        list[0].1.eval(&mut Fixed)
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
            ("ATAN[1]", 45.0),
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
    fn faults_are_told() {
        assert_eq!(value("1/0"), Err(Fault::Division));
        assert!(matches!(value("SQRT[-1]"), Err(Fault::Domain("SQRT", _))));
        assert!(matches!(value("#[0-1.5]"), Err(Fault::NoVariable(_))));
    }
}
