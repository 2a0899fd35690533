//! From the text of a line to a [`Line`].

use super::expr::{Expr, Op, STACK};
use super::key_words::{STATEMENTS, key_word};
use super::statement::{Line, Names, Number, Statement};

/// Why a line cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("column {}: {text}", .at + 1)]
pub(crate) struct Error {
    /// Byte in the line.
    pub(crate) at: usize,
    /// What was expected.
    pub(crate) text: String,
}

/// Deepest nesting of brackets.
const NESTING: usize = 32;

/// Compiles a line (comments and optional-skip marks already blanked out) of a machine that has these names.
///
/// # Errors
/// [`Error`] with the column and what was expected.
pub(crate) fn compile(text: &[u8], names: Names<'_>) -> Result<Line, Error> {
    let mut parser = Parser { text, at: 0, depth: 0, names, written: None, name: None };
    let mut sequence = None;
    parser.blanks();
    if matches!(parser.peek(), Some(b'N' | b'n')) {
        let start = parser.at;
        parser.at += 1;
        match parser.unsigned() {
            Some(number) => sequence = Some(number),
            None => parser.at = start,
        }
    }
    let statement = parser.statement()?;
    parser.blanks();
    if parser.at < text.len() {
        return Err(parser.error("the end of the statement"));
    }
    Ok(Line { sequence, statement, name: parser.name, messages: Box::default() })
}

pub(super) struct Parser<'a> {
    pub(super) text: &'a [u8],
    pub(super) at: usize,
    depth: usize,
    pub(super) names: Names<'a>,
    /// The value read last, if it is a number as written.
    pub(super) written: Option<Number>,
    /// A program name in angle brackets.
    pub(super) name: Option<(u32, u32)>,
}

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

impl Parser<'_> {
    pub(super) fn error(&self, expected: &str) -> Error {
        let rest = self.text.get(self.at..).unwrap_or_default();
        let found = String::from_utf8_lossy(rest.get(..rest.len().min(12)).unwrap_or_default()).trim().to_owned();
        let found = if found.is_empty() { "the end of the block".to_owned() } else { format!("'{found}'") };
        Error { at: self.at, text: format!("expected {expected}, found {found}") }
    }

    pub(super) fn blanks(&mut self) {
        while matches!(self.text.get(self.at), Some(b' ' | b'\t')) {
            self.at += 1;
        }
    }

    pub(super) fn peek(&mut self) -> Option<u8> {
        self.blanks();
        self.text.get(self.at).map(u8::to_ascii_uppercase)
    }

    fn accept(&mut self, byte: u8) -> bool {
        let found = self.peek() == Some(byte);
        if found {
            self.at += 1;
        }
        found
    }

    /// Letters from here on, upper case, without moving.
    fn letters(&mut self) -> String {
        self.blanks();
        self.text
            .get(self.at..)
            .unwrap_or_default()
            .iter()
            .take_while(|b| b.is_ascii_alphabetic())
            .take(8)
            .map(|b| char::from(b.to_ascii_uppercase()))
            .collect()
    }

    /// A key word of statements, taken; letters of a shortened one are taken as far as they agree.
    fn keyword(&mut self, allowed: &[&'static str]) -> Option<&'static str> {
        let letters = self.letters();
        if letters.len() < 2 {
            return None;
        }
        let mut best: Option<(&'static str, usize)> = None;
        for &word in allowed {
            let common = word.bytes().zip(letters.bytes()).take_while(|(a, b)| a == b).count();
            if common >= 2 && (common == letters.len() || common == word.len()) && best.is_none_or(|(_, n)| common > n)
            {
                best = Some((word, common));
            }
        }
        let (word, common) = best?;
        self.at += common;
        Some(word)
    }

    fn unsigned(&mut self) -> Option<u32> {
        self.blanks();
        let start = self.at;
        let mut value = 0_u32;
        while let Some(digit @ b'0'..=b'9') = self.text.get(self.at) {
            value = value.saturating_mul(10).saturating_add(u32::from(digit - b'0'));
            self.at += 1;
        }
        (self.at > start).then_some(value)
    }

    fn statement(&mut self) -> Result<Statement, Error> {
        if self.peek() == Some(b'#') {
            return self.assignments();
        }
        if self.stands_long_name() || !key_word(self.names, self.text, self.at) {
            return self.words();
        }
        match self.keyword(STATEMENTS) {
            Some("IF") => self.conditional(),
            Some("WHILE") => {
                let condition = self.condition()?;
                if self.keyword(&["DO"]).is_none() {
                    return Err(self.error("DO after the condition"));
                }
                Ok(Statement::While(condition, self.loop_number()?))
            }
            Some("DO") => Ok(Statement::Do(self.loop_number()?)),
            Some("END") => Ok(Statement::End(self.loop_number()?)),
            Some("ENDIF") => Ok(Statement::EndIf),
            Some("ELSE") => Ok(Statement::Else),
            Some("GOTO") => Ok(Statement::Goto(self.jump_target()?)),
            Some("THEN") => Err(self.error("IF before THEN")),
            Some(_) => {
                self.at = self.text.len();
                Ok(Statement::Ignored)
            }
            None => self.words(),
        }
    }

    fn conditional(&mut self) -> Result<Statement, Error> {
        let condition = self.condition()?;
        match self.keyword(&["GOTO", "THEN"]) {
            Some("GOTO") => Ok(Statement::IfGoto(condition, self.jump_target()?)),
            Some(_) if self.peek().is_none() => Ok(Statement::IfBlock(condition)),
            Some(_) => {
                self.depth += 1;
                if self.depth > NESTING {
                    return Err(self.error("less nesting"));
                }
                let inner = self.statement()?;
                self.depth -= 1;
                Ok(Statement::IfThen(condition, Box::new(inner)))
            }
            None => Err(self.error("GOTO or THEN after the condition")),
        }
    }

    fn loop_number(&mut self) -> Result<u8, Error> {
        match self.unsigned() {
            Some(n @ 1..=3) => Ok(n as u8),
            _ => Err(self.error("a loop number 1, 2 or 3")),
        }
    }

    fn jump_target(&mut self) -> Result<Expr, Error> {
        match self.peek() {
            Some(b'0'..=b'9') => Ok(Expr::constant(f64::from(self.unsigned().unwrap_or(0)))),
            Some(b'[' | b'#') => {
                let mut ops = Vec::new();
                self.primary(&mut ops)?;
                Ok(Expr { ops })
            }
            _ => Err(self.error("a sequence number")),
        }
    }

    fn condition(&mut self) -> Result<Expr, Error> {
        if self.peek() != Some(b'[') {
            return Err(self.error("'[' before the condition"));
        }
        let mut ops = Vec::new();
        self.primary(&mut ops)?;
        self.checked(ops)
    }

    fn assignments(&mut self) -> Result<Statement, Error> {
        let mut list = Vec::new();
        while self.accept(b'#') {
            let mut target = Vec::new();
            self.variable_number(&mut target)?;
            if !self.accept(b'=') {
                return Err(self.error("'=' after the variable"));
            }
            let mut value = Vec::new();
            self.logical(&mut value, Operand::Expression)?;
            list.push((self.checked(target)?, self.checked(value)?));
        }
        Ok(Statement::Assign(list))
    }

    /// An expression that fits the evaluation stack.
    pub(super) fn checked(&self, ops: Vec<Op>) -> Result<Expr, Error> {
        let (mut depth, mut most) = (0_usize, 0_usize);
        for op in &ops {
            match op {
                Op::Number(_) | Op::Variable(_) => depth += 1,
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
    fn logical(&mut self, ops: &mut Vec<Op>, operand: Operand) -> Result<(), Error> {
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
    fn variable_number(&mut self, ops: &mut Vec<Op>) -> Result<(), Error> {
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

    fn nest(&mut self) -> Result<(), Error> {
        self.depth += 1;
        if self.depth > NESTING { Err(self.error("at most 32 levels of brackets")) } else { Ok(()) }
    }

    fn bracketed(&mut self, ops: &mut Vec<Op>) -> Result<(), Error> {
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
            return Err(self.error("a value"));
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

/// What stands between `&&` and `||`.
#[derive(Debug, Clone, Copy)]
enum Operand {
    /// Outside brackets: no comparisons.
    Expression,
    /// Inside brackets.
    Relation,
}

#[cfg(test)]
mod tests {
    use super::super::expr::{Fault, VACANT, Variables};
    use super::*;

    struct Fixed;

    impl Variables for Fixed {
        fn get(&mut self, index: u32) -> Result<f64, Fault> {
            Ok(match index {
                0 | 9 => VACANT,
                n => f64::from(n),
            })
        }
    }

    fn plain(text: &[u8]) -> Result<Line, Error> {
        compile(text, Names::default())
    }

    fn value(text: &str) -> Result<f64, Fault> {
        let line = plain(format!("#1={text}").as_bytes()).unwrap();
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
        assert!(matches!(value("#[1.5]"), Err(Fault::NoVariable(_))));
    }

    #[test]
    fn statements() {
        let kind = |text: &str| plain(text.as_bytes()).map(|l| l.statement);
        assert!(matches!(kind("IF[#4GT0]GOTO10"), Ok(Statement::IfGoto(..))));
        assert!(matches!(kind("N10 IF [#1 EQ 2] THEN #3=4"), Ok(Statement::IfThen(..))));
        assert!(matches!(kind("WHILE[#1LT200000]DO1"), Ok(Statement::While(_, 1))));
        assert!(matches!(kind("WH[#1LT3]DO2"), Ok(Statement::While(_, 2))));
        assert!(matches!(kind("END1"), Ok(Statement::End(1))));
        assert!(matches!(kind("EN2"), Ok(Statement::End(2))));
        assert!(matches!(kind("ENDIF"), Ok(Statement::EndIf)));
        assert!(matches!(kind("GO20"), Ok(Statement::Goto(_))));
        assert!(matches!(kind("DPRNT[X#1[42]]"), Ok(Statement::Ignored)));
        assert_eq!(plain(b"N20 G1 X#4 Y-#5 Z[#6+1]").unwrap().sequence, Some(20));
        assert!(plain(b"#1=[1+2").is_err());
        assert!(plain(b"IF[1EQ1]").is_err());
        assert!(plain("#1=".repeat(2).as_bytes()).is_err());
        assert!(plain(format!("#1={}1", "[".repeat(10_000)).as_bytes()).is_err());
        assert!(plain(format!("#1={}1", "#".repeat(10_000)).as_bytes()).is_err());
    }
}
