//! Expressions: their form and how they are read.
//!
//! Facts: reference control-emulator.md 5.4. Decision, the order of operators, tightest first: sign and NOT; `*`, `/`
//! and MOD; `+` and `-`; comparisons; AND; OR and EOR. Invariant: an expression has [`MOST`] parts at the most and is
//! [`DEEPEST`] brackets deep, so neither reading nor evaluating nor dropping it runs out of stack.

use super::cursor::{Cursor, Mistake};
use super::math::{Binary, Function};
use super::names::{self, Family, Local};
use crate::expression::{Grammar, read};

/// Parts of an expression.
const MOST: usize = 256;

/// Brackets and signs inside each other.
const DEEPEST: usize = 40;

/// An expression.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Expr {
    Number(f64),
    /// What a variable without a value is equal to.
    Empty,
    Variable(Variable),
    Apply(Function, Box<[Expr]>),
    Binary(Binary, Box<(Expr, Expr)>),
    /// A function that the control does not have, as it is written.
    Unknown(Box<str>),
}

/// A variable that is read or written.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Variable {
    Local(Local),
    Common(Family, Box<Expr>),
    /// One of the control's own, or a name that nothing has: its name and its indices.
    System(Box<str>, Box<[Expr]>),
}

impl Expr {
    /// Its value is a truth.
    fn is_truth(&self) -> bool {
        match self {
            Expr::Binary(Binary::And | Binary::Or | Binary::Eor, sides) => sides.0.is_truth() && sides.1.is_truth(),
            Expr::Binary(operator, _) => operator.compares(),
            Expr::Apply(function, _) => *function == Function::NotTrue,
            _ => false,
        }
    }
}

/// Reads expressions from a text.
pub(super) struct Reader<'c, 'a> {
    pub(super) cursor: &'c mut Cursor<'a>,
    parts: usize,
    /// Brackets and signs around what is being read.
    depth: usize,
}

/// Operators by how tight they are, loosest first.
const LEVELS: &[&[(&str, Binary)]] = &[
    &[("OR", Binary::Or), ("EOR", Binary::Eor)],
    &[("AND", Binary::And)],
    &[
        ("EQ", Binary::Eq),
        ("NE", Binary::Ne),
        ("GT", Binary::Gt),
        ("GE", Binary::Ge),
        ("LT", Binary::Lt),
        ("LE", Binary::Le),
    ],
    &[("+", Binary::Add), ("-", Binary::Sub)],
    &[("*", Binary::Mul), ("/", Binary::Div), ("MOD", Binary::Mod)],
];

impl Grammar for Reader<'_, '_> {
    type Operator = Binary;
    type Part = Expr;
    type Mistake = Mistake;

    fn operand(&mut self) -> Result<Expr, Mistake> {
        self.signed()
    }

    fn operator(&mut self, loosest: usize) -> Option<(usize, Binary)> {
        self.cursor.peek()?;
        // Words of letters may stand close to a number that follows: `EQ5`.
        let cursor = &mut *self.cursor;
        let mut take = |word: &str| if word.len() == 1 { cursor.key_word(word) } else { cursor.word(word) };
        for (level, operators) in LEVELS.iter().enumerate().skip(loosest) {
            if let Some((_, operator)) = operators.iter().find(|(word, _)| take(word)) {
                return Some((level, *operator));
            }
        }
        None
    }

    fn check(&mut self, _: usize, _: bool) -> Result<(), Mistake> {
        self.count()
    }

    fn join(&mut self, operator: Binary, left: Expr, right: Expr) -> Expr {
        Expr::Binary(operator, Box::new((left, right)))
    }
}

impl<'c, 'a> Reader<'c, 'a> {
    pub(super) fn new(cursor: &'c mut Cursor<'a>) -> Self {
        Self { cursor, parts: 0, depth: 0 }
    }

    /// A whole expression.
    pub(super) fn expression(&mut self) -> Result<Expr, Mistake> {
        read(self, 0)
    }

    fn count(&mut self) -> Result<(), Mistake> {
        self.parts += 1;
        if self.parts > MOST { Err(Mistake::TooLong(self.cursor.at + 1)) } else { Ok(()) }
    }

    /// A value with its signs.
    fn signed(&mut self) -> Result<Expr, Mistake> {
        self.count()?;
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(Mistake::TooLong(self.cursor.at + 1));
        }
        let value = self.with_sign()?;
        self.depth -= 1;
        Ok(value)
    }

    fn with_sign(&mut self) -> Result<Expr, Mistake> {
        if self.cursor.take(b'+') {
            return self.signed();
        }
        if self.cursor.take(b'-') {
            return Ok(match self.signed()? {
                Expr::Number(value) => Expr::Number(-value),
                value => Expr::Apply(Function::Minus, [value].into()),
            });
        }
        if self.cursor.word("NOT") {
            let value = self.signed()?;
            let function = if value.is_truth() { Function::NotTrue } else { Function::Not };
            return Ok(Expr::Apply(function, [value].into()));
        }
        self.operand()
    }

    fn operand(&mut self) -> Result<Expr, Mistake> {
        match self.cursor.peek() {
            Some(b'[') => {
                self.cursor.at += 1;
                let inside = self.expression()?;
                self.cursor.expect(b']', "']'")?;
                Ok(inside)
            }
            Some(b'0'..=b'9' | b'.') => self.number(),
            Some(b'#' | b'$') => self.hexadecimal(),
            Some(b'A'..=b'Z') => self.name(),
            _ => Err(Mistake::Expected("a value", self.cursor.at + 1)),
        }
    }

    fn number(&mut self) -> Result<Expr, Mistake> {
        let at = self.cursor.at;
        let text = number_text(self.cursor);
        text.parse().map(Expr::Number).map_err(|_| Mistake::Expected("a number", at + 1))
    }

    /// `#81H` or `$81`.
    fn hexadecimal(&mut self) -> Result<Expr, Mistake> {
        let closes = self.cursor.here() == Some(b'#');
        self.cursor.at += 1;
        let at = self.cursor.at;
        let digits = self.cursor.run(|byte| byte.is_ascii_hexdigit());
        // More digits are no whole number that a value can be.
        let value = i64::from_str_radix(digits, 16).ok().filter(|_| digits.len() <= 12);
        let Some(value) = value else { return Err(Mistake::Expected("a hexadecimal number", at + 1)) };
        if closes && self.cursor.here() == Some(b'H') {
            self.cursor.at += 1;
        }
        Ok(Expr::Number(value as f64))
    }

    fn name(&mut self) -> Result<Expr, Mistake> {
        let start = self.cursor.at;
        let name = name_text(self.cursor);
        if name == "EMPTY" {
            return Ok(Expr::Empty);
        }
        let (known, opens) = (Function::named(name), self.cursor.peek() == Some(b'['));
        if let Some((name, function)) = known {
            let at = self.cursor.at + 1;
            let arguments = self.list()?;
            if arguments.len() != function.arguments() {
                let wanted = if function.arguments() == 1 { "one value" } else { "two values" };
                return Err(Mistake::Arguments(name, wanted, at));
            }
            return Ok(Expr::Apply(function, arguments));
        }
        if opens && !name.starts_with('V') {
            self.list()?;
            return Ok(Expr::Unknown(self.cursor.between(start).into()));
        }
        self.variable(name).map(Expr::Variable)
    }

    /// The variable of a name that has just been read, with its indices.
    pub(super) fn variable(&mut self, name: &str) -> Result<Variable, Mistake> {
        if let Some(local) = names::local(name) {
            return Ok(Variable::Local(local));
        }
        let indices = if self.cursor.peek() == Some(b'[') { self.list()? } else { Box::default() };
        Ok(match (names::common(name), &*indices) {
            (Some((family, Some(number))), []) => Variable::Common(family, Box::new(Expr::Number(number))),
            (Some((family, None)), [index]) => Variable::Common(family, Box::new(index.clone())),
            _ => Variable::System(name.into(), indices),
        })
    }

    /// Values in brackets.
    fn list(&mut self) -> Result<Box<[Expr]>, Mistake> {
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
pub(super) fn number_text<'a>(cursor: &mut Cursor<'a>) -> &'a str {
    let start = cursor.at;
    cursor.run(|byte| byte.is_ascii_digit());
    if cursor.here() == Some(b'.') {
        cursor.at += 1;
        cursor.run(|byte| byte.is_ascii_digit());
    }
    cursor.between(start)
}

/// The letters and then the digits of a name.
pub(super) fn name_text<'a>(cursor: &mut Cursor<'a>) -> &'a str {
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
        let mut cursor = Cursor::new(text.as_bytes());
        let expr = Reader::new(&mut cursor).expression().unwrap();
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
        assert!(matches!(read("LA1"), Expr::Variable(Variable::Local(_))));
        assert!(matches!(read("VC[LA1]"), Expr::Variable(Variable::Common(Family::Vc, _))));
        assert!(matches!(read("V33"), Expr::Variable(Variable::Common(Family::V, _))));
        assert_eq!(read("VTOFX[1]"), Expr::Variable(Variable::System("VTOFX".into(), [Expr::Number(1.0)].into())));
        assert_eq!(read("HALF[ 1, 2]"), Expr::Unknown("HALF[ 1, 2]".into()));
        assert_eq!(
            (read("#81H"), read("$fF".to_ascii_uppercase().as_str())),
            (Expr::Number(129.0), Expr::Number(255.0))
        );
        assert_eq!((read("EMPTY"), read("-.5")), (Expr::Empty, Expr::Number(-0.5)));
    }
}
