//! Expressions, read.
//!
//! Facts: the control's priorities, strongest first: NOT B_NOT; * / DIV MOD and the chain `:`; + −; B_AND; B_XOR; B_OR;
//! AND; XOR; OR; `<<`, which may also be before its first value; comparisons. Since comparisons bind weakest, a second
//! comparison without parentheses is a mistake. Invariant: expressions are bounded in depth, so that their evaluation
//! is too.

use counterpoint_control_api::expression::{
    CompiledExpression, ExpressionPart, Grammar, Operators, PrefixOperator, read,
};
use counterpoint_control_api::numeric::NumericOperator;

use super::compiled::{Expression, IndexedName, Op, SiemensArgument, SiemensOp};
use super::cursor::{SiemensCursor, split_list};
use super::functions;
use super::value::Data;

/// Deepest nesting of parentheses, brackets and arguments.
const DEEPEST: usize = 24;
/// Most operators of an expression.
const MOST_OPERATORS: usize = 200;

/// Level of comparisons.
const COMPARISONS: usize = 0;

/// Reads expressions from a text.
struct SiemensExpressionReader<'c, 'a> {
    cursor: &'c mut SiemensCursor<'a>,
    ops: Vec<Op>,
}

/// Reads an expression.
pub(super) fn expression(cursor: &mut SiemensCursor<'_>) -> Result<Expression, String> {
    cursor.operators = 0;
    part(cursor)
}

/// Reads an expression that is a part of another one.
fn part(cursor: &mut SiemensCursor<'_>) -> Result<Expression, String> {
    let depth = cursor.depth;
    let mut reader = SiemensExpressionReader { cursor, ops: Vec::new() };
    let done = read(&mut reader, 0);
    let ops = reader.ops;
    cursor.depth = depth;
    done.map(|_| CompiledExpression::new(ops))
}

/// Reads a text that has to be one expression.
pub(super) fn whole(text: &str) -> Result<Expression, String> {
    let mut cursor = SiemensCursor::new(text);
    let read = expression(&mut cursor)?;
    cursor.blanks();
    if cursor.is_at_end() { Ok(read) } else { Err(unexpected(&cursor)) }
}

/// The error at the cursor.
pub(super) fn unexpected(cursor: &SiemensCursor<'_>) -> String {
    let rest: String = cursor.rest().trim_start().chars().take(20).collect();
    if rest.is_empty() { "the block ends too early".to_owned() } else { format!("unexpected '{rest}'") }
}

impl Grammar for SiemensExpressionReader<'_, '_> {
    type Value = Data;
    type Own = SiemensOp;
    type Mistake = String;

    const OPERATORS: Operators = &[
        &[
            ("==", NumericOperator::Eq),
            ("<>", NumericOperator::Ne),
            ("<=", NumericOperator::Le),
            (">=", NumericOperator::Ge),
            ("<", NumericOperator::Lt),
            (">", NumericOperator::Gt),
        ],
        &[("<<", NumericOperator::Join)],
        &[("OR", NumericOperator::Or)],
        &[("XOR", NumericOperator::Xor)],
        &[("AND", NumericOperator::And)],
        &[("B_OR", NumericOperator::BitOr)],
        &[("B_XOR", NumericOperator::BitXor)],
        &[("B_AND", NumericOperator::BitAnd)],
        &[("+", NumericOperator::Add), ("-", NumericOperator::Sub)],
        &[
            ("*", NumericOperator::Mul),
            ("/", NumericOperator::Div),
            ("DIV", NumericOperator::WholeDiv),
            ("MOD", NumericOperator::Rem),
            (":", NumericOperator::Chain),
        ],
    ];
    const SIGNS: &'static [(&'static str, PrefixOperator)] = &[
        ("-", PrefixOperator::Minus),
        ("NOT", PrefixOperator::Not),
        ("B_NOT", PrefixOperator::NotBits),
        ("+", PrefixOperator::Plus),
    ];

    fn ops(&mut self) -> &mut Vec<Op> {
        &mut self.ops
    }

    fn takes(&mut self, word: &str) -> bool {
        // Most operators are ruled out by their first byte.
        if !word.bytes().next().is_some_and(|first| first.eq_ignore_ascii_case(&self.cursor.next_byte())) {
            return false;
        }
        if word.starts_with(|c: char| c.is_ascii_alphabetic()) {
            return self.cursor.word(word);
        }
        let from = self.cursor.at();
        let mut takes = self.cursor.takes(word);
        // `<` of `<<` belongs to the other operator.
        if takes && matches!((word, self.cursor.byte(0)), ("<", b'<') | (">", b'>')) {
            self.cursor.back_to(from);
            takes = false;
        }
        takes
    }

    fn operand(&mut self) -> Result<ExpressionPart, String> {
        let start = self.ops.len();
        self.primary()?;
        Ok(ExpressionPart { start, truth: false })
    }

    fn negated(value: &Data) -> Option<Data> {
        match value {
            Data::Int(value) => Some(Data::Int(-value)),
            Data::Real(value) => Some(Data::Real(-value)),
            _ => None,
        }
    }

    fn nest(&mut self, sign: bool) -> Result<(), String> {
        if sign && self.cursor.depth >= DEEPEST {
            return Err(too_deep());
        }
        self.cursor.depth += usize::from(sign);
        Ok(())
    }

    fn unnest(&mut self, signs: usize) {
        self.cursor.depth = self.cursor.depth.saturating_sub(signs);
    }

    fn check(&mut self, level: usize, chained: bool) -> Result<(), String> {
        if level == COMPARISONS && chained {
            return Err("comparisons bind weaker than AND and OR; put each one in parentheses".to_owned());
        }
        self.cursor.operators += 1;
        if self.cursor.operators > MOST_OPERATORS {
            return Err(format!("the expression has more than {MOST_OPERATORS} operators"));
        }
        Ok(())
    }
}

impl SiemensExpressionReader<'_, '_> {
    fn primary(&mut self) -> Result<(), String> {
        let cursor = &mut *self.cursor;
        cursor.blanks();
        let constant = match cursor.byte(0) {
            // `<<` before a value makes a text of it: that of nothing joined with it.
            b'<' if cursor.byte(1) == b'<' => Data::Text("".into()),
            b'(' => {
                cursor.takes("(");
                if cursor.depth >= DEEPEST {
                    return Err(too_deep());
                }
                cursor.depth += 1;
                read(self, 0)?;
                self.cursor.depth -= 1;
                return if self.cursor.takes(")") {
                    Ok(())
                } else {
                    Err(format!("a ')' is missing, {}", unexpected(self.cursor)))
                };
            }
            b'"' => match cursor.quoted() {
                Some(text) => Data::Text(text.into()),
                None => return Err("a text is not closed".to_owned()),
            },
            b'\'' => constant(cursor)?,
            b'0'..=b'9' | b'.' => number(cursor)?,
            _ => {
                return match cursor.name() {
                    Some(name) => self.named(&name.to_ascii_uppercase()),
                    None => Err(unexpected(cursor)),
                };
            }
        };
        self.ops.push(Op::Value(constant));
        Ok(())
    }

    /// A name in capital letters has been read.
    fn named(&mut self, name: &str) -> Result<(), String> {
        self.cursor.blanks_before_brackets();
        let op = match name {
            "TRUE" => Op::Value(Data::Bool(true)),
            "FALSE" => Op::Value(Data::Bool(false)),
            _ if self.cursor.byte(0) == b'(' => {
                let mut arguments = arguments(self.cursor)?;
                match (functions::of_one(name), arguments.as_mut_slice()) {
                    (Some(function), [SiemensArgument { value: Ok(value), .. }]) if value.is_some() => {
                        self.ops.extend(value.take().into_iter().flat_map(CompiledExpression::into_ops));
                        Op::Apply(function)
                    }
                    _ => Op::Own(SiemensOp::Call(name.to_owned(), arguments)),
                }
            }
            _ => Op::Own(SiemensOp::Name(indexed(self.cursor, name)?)),
        };
        self.ops.push(op);
        Ok(())
    }
}

fn too_deep() -> String {
    format!("the expression is nested deeper than {DEEPEST} levels")
}

/// `'HFF'`, `'B0101'`, `'D12'`, or a character.
fn constant(cursor: &mut SiemensCursor<'_>) -> Result<Data, String> {
    let inner = cursor.rest().get(1..).and_then(|rest| rest.split_once('\'')).map(|(inner, _)| inner);
    let Some(inner) = inner else { return Err("a constant in ' ' is not closed".to_owned()) };
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
        return Ok(Data::Int(value));
    }
    match inner.as_bytes() {
        [one] => Ok(Data::Char(*one)),
        _ => Err(format!("'{inner}' is not a valid constant")),
    }
}

fn number(cursor: &mut SiemensCursor<'_>) -> Result<Data, String> {
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
        Ok(value) if !point => Ok(Data::Int(value)),
        _ => real(text),
    }
}

fn real(text: &str) -> Result<Data, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(Data::Real(value)),
        _ => Err(format!("{text} is not a number that this control accepts")),
    }
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
pub(super) fn indexed(cursor: &mut SiemensCursor<'_>, name: &str) -> Result<IndexedName, String> {
    if let Some(number) = parameter(name) {
        return Ok(IndexedName { name: "R".to_owned(), index: vec![Expression::constant(Data::Int(number))] });
    }
    let name = if name == "$R" { "R" } else { name };
    let mut index = Vec::new();
    while cursor.takes("[") {
        loop {
            if cursor.depth >= DEEPEST {
                return Err(too_deep());
            }
            cursor.depth += 1;
            let read = part(cursor);
            cursor.depth -= 1;
            index.push(read?);
            if cursor.takes("]") {
                break;
            }
            if !cursor.takes(",") || index.len() > 8 {
                return Err(format!("a ']' is missing, {}", unexpected(cursor)));
            }
        }
        if index.len() > 8 {
            return Err("too many indices".to_owned());
        }
    }
    Ok(IndexedName { name: name.to_owned(), index })
}

/// Arguments in parentheses.
pub(super) fn arguments(cursor: &mut SiemensCursor<'_>) -> Result<Vec<SiemensArgument>, String> {
    if cursor.depth >= DEEPEST {
        return Err(too_deep());
    }
    let Some(inner) = cursor.enclosed(b'(', b')') else { return Err("a ')' is missing".to_owned()) };
    if inner.trim().is_empty() {
        return Ok(Vec::new());
    }
    Ok(split_list(inner).into_iter().map(|text| argument(cursor, text)).collect())
}

fn argument(cursor: &SiemensCursor<'_>, text: &str) -> SiemensArgument {
    let mut inner = cursor.inside(text);
    let value = if text.is_empty() {
        Ok(None)
    } else {
        part(&mut inner).and_then(|read| {
            inner.blanks();
            if inner.is_at_end() { Ok(Some(read)) } else { Err(unexpected(&inner)) }
        })
    };
    SiemensArgument { text: text.to_owned(), value }
}
