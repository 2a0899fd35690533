//! Expressions, read.
//!
//! Facts: the control's priorities, strongest first: NOT B_NOT; * / DIV MOD and the chain `:`; + −; B_AND; B_XOR; B_OR;
//! AND; XOR; OR; `<<`; comparisons. Since comparisons bind weakest, a second one without parentheses is a mistake.
//! Invariant: what was read is bounded in depth, so that evaluating it is too.

use std::sync::Arc;

use super::cursor::{Cursor, split_list};
use crate::expression::{Grammar, read};

/// Deepest nesting of parentheses, brackets and arguments.
const DEEPEST: usize = 24;
/// Most operators of an expression.
const MOST_OPERATORS: usize = 200;

/// An expression.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Expression {
    Int(i64),
    Real(f64),
    Bool(bool),
    Char(u8),
    Text(Arc<str>),
    /// A variable, an axis, a system variable.
    Name(Name),
    Call(String, Vec<Argument>),
    Unary(Unary, Box<Expression>),
    Binary(Binary, Box<Expression>, Box<Expression>),
}

/// A name in capital letters with its indices; `R5` is `R` with the index 5.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Name {
    pub(super) name: String,
    pub(super) index: Vec<Expression>,
}

/// An argument as it is written, and as an expression if it is one; both empty if it was left out.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Argument {
    pub(super) text: String,
    pub(super) value: Result<Option<Expression>, String>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Unary {
    Minus,
    Not,
    BitNot,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Binary {
    Equal,
    NotEqual,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Join,
    Or,
    Xor,
    And,
    BitOr,
    BitXor,
    BitAnd,
    Add,
    Subtract,
    Multiply,
    Divide,
    IntegerDivide,
    Modulo,
    Chain,
}

/// Level of comparisons.
const COMPARISONS: usize = 0;

/// Operators by level, weakest first.
const LEVELS: [&[(&str, Binary)]; 10] = [
    &[
        ("==", Binary::Equal),
        ("<>", Binary::NotEqual),
        ("<=", Binary::LessEqual),
        (">=", Binary::GreaterEqual),
        ("<", Binary::Less),
        (">", Binary::Greater),
    ],
    &[("<<", Binary::Join)],
    &[("OR", Binary::Or)],
    &[("XOR", Binary::Xor)],
    &[("AND", Binary::And)],
    &[("B_OR", Binary::BitOr)],
    &[("B_XOR", Binary::BitXor)],
    &[("B_AND", Binary::BitAnd)],
    &[("+", Binary::Add), ("-", Binary::Subtract)],
    &[
        ("*", Binary::Multiply),
        ("/", Binary::Divide),
        ("DIV", Binary::IntegerDivide),
        ("MOD", Binary::Modulo),
        (":", Binary::Chain),
    ],
];

/// Reads an expression.
pub(super) fn expression(cursor: &mut Cursor<'_>) -> Result<Expression, String> {
    cursor.operators = 0;
    read(cursor, 0)
}

/// Reads a text that has to be one expression.
pub(super) fn whole(text: &str) -> Result<Expression, String> {
    let mut cursor = Cursor::new(text);
    let read = expression(&mut cursor)?;
    cursor.blanks();
    if cursor.is_at_end() { Ok(read) } else { Err(unexpected(&cursor)) }
}

/// What is wrong where the cursor stands.
pub(super) fn unexpected(cursor: &Cursor<'_>) -> String {
    let rest: String = cursor.rest().trim_start().chars().take(20).collect();
    if rest.is_empty() { "the block ends too early".to_owned() } else { format!("'{rest}' is not expected") }
}

impl Grammar for Cursor<'_> {
    type Operator = Binary;
    type Part = Expression;
    type Mistake = String;

    fn operand(&mut self) -> Result<Expression, String> {
        unary(self)
    }

    fn operator(&mut self, loosest: usize) -> Option<(usize, Binary)> {
        let mut levels = LEVELS.iter().enumerate().skip(loosest);
        levels.find_map(|(level, operators)| Some((level, operator(self, operators)?)))
    }

    fn check(&mut self, level: usize, chained: bool) -> Result<(), String> {
        if level == COMPARISONS && chained {
            return Err("a comparison binds weaker than AND and OR, each one needs parentheses".to_owned());
        }
        self.operators += 1;
        if self.operators > MOST_OPERATORS {
            return Err(format!("the expression has more than {MOST_OPERATORS} operators"));
        }
        Ok(())
    }

    fn join(&mut self, operator: Binary, left: Expression, right: Expression) -> Expression {
        Expression::Binary(operator, Box::new(left), Box::new(right))
    }
}

fn operator(cursor: &mut Cursor<'_>, operators: &[(&str, Binary)]) -> Option<Binary> {
    for &(text, operator) in operators {
        if text.starts_with(|c: char| c.is_ascii_alphabetic()) {
            if cursor.word(text) {
                return Some(operator);
            }
            continue;
        }
        let from = cursor.at();
        if cursor.takes(text) {
            // `<` of `<<` belongs to the other one.
            if (text == "<" && cursor.byte(0) == b'<') || (text == ">" && cursor.byte(0) == b'>') {
                cursor.back_to(from);
                continue;
            }
            return Some(operator);
        }
    }
    None
}

fn unary(cursor: &mut Cursor<'_>) -> Result<Expression, String> {
    let operator = if cursor.takes("-") {
        Some(Unary::Minus)
    } else if cursor.word("NOT") {
        Some(Unary::Not)
    } else if cursor.word("B_NOT") {
        Some(Unary::BitNot)
    } else {
        None
    };
    let Some(operator) = operator else {
        if cursor.takes("+") {
            return deeper(cursor, unary);
        }
        return primary(cursor);
    };
    let inner = deeper(cursor, unary)?;
    Ok(match (operator, inner) {
        (Unary::Minus, Expression::Int(value)) => Expression::Int(-value),
        (Unary::Minus, Expression::Real(value)) => Expression::Real(-value),
        (operator, inner) => Expression::Unary(operator, Box::new(inner)),
    })
}

fn deeper<T>(cursor: &mut Cursor<'_>, read: impl FnOnce(&mut Cursor<'_>) -> Result<T, String>) -> Result<T, String> {
    if cursor.depth >= DEEPEST {
        return Err(format!("the expression is nested deeper than {DEEPEST} levels"));
    }
    cursor.depth += 1;
    let done = read(cursor);
    cursor.depth -= 1;
    done
}

fn primary(cursor: &mut Cursor<'_>) -> Result<Expression, String> {
    cursor.blanks();
    match cursor.byte(0) {
        b'(' => {
            cursor.takes("(");
            let inner = deeper(cursor, |cursor| read(cursor, 0))?;
            if cursor.takes(")") { Ok(inner) } else { Err(format!("a ')' is missing, {}", unexpected(cursor))) }
        }
        b'"' => match cursor.quoted() {
            Some(text) => Ok(Expression::Text(text.into())),
            None => Err("a text has no end".to_owned()),
        },
        b'\'' => constant(cursor),
        b'0'..=b'9' | b'.' => number(cursor),
        _ => match cursor.name() {
            Some(name) => named(cursor, &name.to_ascii_uppercase()),
            None => Err(unexpected(cursor)),
        },
    }
}

/// `'HFF'`, `'B0101'`, `'D12'`, or a character.
fn constant(cursor: &mut Cursor<'_>) -> Result<Expression, String> {
    let inner = cursor.rest().get(1..).and_then(|rest| rest.split_once('\'')).map(|(inner, _)| inner);
    let Some(inner) = inner else { return Err("a constant in ' ' has no end".to_owned()) };
    for _ in 0..inner.chars().count() + 2 {
        cursor.step();
    }
    let radix = match inner.as_bytes().first().map(u8::to_ascii_uppercase) {
        Some(b'H') => 16,
        Some(b'B') => 2,
        Some(b'D') => 10,
        _ => 0,
    };
    if let Some(value) = inner.get(1..).filter(|_| radix > 0).and_then(|digits| i64::from_str_radix(digits, radix).ok())
    {
        return Ok(Expression::Int(value));
    }
    match inner.as_bytes() {
        [one] => Ok(Expression::Char(*one)),
        _ => Err(format!("'{inner}' is no constant")),
    }
}

fn number(cursor: &mut Cursor<'_>) -> Result<Expression, String> {
    let Some((text, point)) = cursor.decimal() else { return Err(unexpected(cursor)) };
    if cursor.byte(0).eq_ignore_ascii_case(&b'E') && cursor.byte(1).eq_ignore_ascii_case(&b'X') {
        let from = cursor.at();
        cursor.step();
        cursor.step();
        let sign = if cursor.byte(0) == b'-' { "-" } else { "" };
        if matches!(cursor.byte(0), b'+' | b'-') {
            cursor.step();
        }
        let exponent = cursor.digits();
        if exponent.is_empty() || exponent.len() > 4 {
            cursor.back_to(from);
            return Err(unexpected(cursor));
        }
        return real(&format!("{text}e{sign}{exponent}"));
    }
    match text.parse::<i64>() {
        Ok(value) if !point => Ok(Expression::Int(value)),
        _ => real(text),
    }
}

fn real(text: &str) -> Result<Expression, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(Expression::Real(value)),
        _ => Err(format!("{text} is no number of the control")),
    }
}

/// A name in capital letters has been read.
fn named(cursor: &mut Cursor<'_>, name: &str) -> Result<Expression, String> {
    match name {
        "TRUE" => return Ok(Expression::Bool(true)),
        "FALSE" => return Ok(Expression::Bool(false)),
        _ => {}
    }
    if cursor.byte(0) == b'(' {
        return Ok(Expression::Call(name.to_owned(), arguments(cursor)?));
    }
    Ok(Expression::Name(indexed(cursor, name)?))
}

/// Number of an R parameter whose name has it, `R5` or `$R5`.
pub(super) fn parameter(name: &str) -> Option<i64> {
    let digits = name.strip_prefix('$').unwrap_or(name).strip_prefix('R')?;
    if digits.is_empty() || digits.len() > 9 || !digits.bytes().all(|byte| byte.is_ascii_digit()) {
        return None;
    }
    digits.parse().ok()
}

/// Indices after a name in capital letters.
pub(super) fn indexed(cursor: &mut Cursor<'_>, name: &str) -> Result<Name, String> {
    if let Some(number) = parameter(name) {
        return Ok(Name { name: "R".to_owned(), index: vec![Expression::Int(number)] });
    }
    let name = if name == "$R" { "R" } else { name };
    let mut index = Vec::new();
    while cursor.takes("[") {
        loop {
            index.push(deeper(cursor, |cursor| read(cursor, 0))?);
            if cursor.takes("]") {
                break;
            }
            if !cursor.takes(",") || index.len() > 8 {
                return Err(format!("a ']' is missing, {}", unexpected(cursor)));
            }
        }
        if index.len() > 8 {
            return Err("there are too many indices".to_owned());
        }
    }
    Ok(Name { name: name.to_owned(), index })
}

/// Arguments in parentheses.
pub(super) fn arguments(cursor: &mut Cursor<'_>) -> Result<Vec<Argument>, String> {
    if cursor.depth >= DEEPEST {
        return Err(format!("the expression is nested deeper than {DEEPEST} levels"));
    }
    let Some(inner) = cursor.enclosed(b'(', b')') else { return Err("a ')' is missing".to_owned()) };
    if inner.trim().is_empty() {
        return Ok(Vec::new());
    }
    Ok(split_list(inner).into_iter().map(|text| argument(cursor, text)).collect())
}

fn argument(cursor: &Cursor<'_>, text: &str) -> Argument {
    let mut inner = cursor.inside(text);
    let value = if text.is_empty() {
        Ok(None)
    } else {
        read(&mut inner, 0).and_then(|read| {
            inner.blanks();
            if inner.is_at_end() { Ok(Some(read)) } else { Err(unexpected(&inner)) }
        })
    };
    Argument { text: text.to_owned(), value }
}
