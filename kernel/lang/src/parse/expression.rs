//! Expressions: operators by binding, constants, variables, elements and ranges, calls.
//!
//! Facts: reference macro-language.md 1.2, 1.7 and 2; `.NOT.` binds looser than the comparisons.

use super::{LineParser, Parsed};
use crate::ast::{Expr, ExprKind, MAX_DEPTH, VariableName};
use crate::diag::DiagnosticNumber;
use crate::ident;
use crate::lex::{Sign, TokenKind};
use crate::source::Span;
use crate::value::RecordName;

const NOT: u8 = 8;
const UNARY: u8 = 18;

/// Binding of an operator to its left and right operand; larger binds stronger.
fn binding(sign: Sign) -> Option<(u8, u8)> {
    Some(match sign {
        Sign::Xor => (2, 3),
        Sign::Or => (4, 5),
        Sign::And => (6, 7),
        Sign::Equal | Sign::NotEqual | Sign::Greater | Sign::Less | Sign::GreaterEqual | Sign::LessEqual => (10, 11),
        Sign::Join => (12, 13),
        Sign::Plus | Sign::Minus => (14, 15),
        Sign::Star | Sign::Slash => (16, 17),
        Sign::Power => (21, 20),
        _ => return None,
    })
}

impl LineParser<'_> {
    /// Reads a whole expression.
    pub(crate) fn expression(&mut self) -> Parsed<Expr> {
        self.operators(0)
    }

    /// Reads expressions divided by commas, at least one.
    pub(crate) fn list(&mut self) -> Parsed<Vec<Expr>> {
        let mut list = vec![self.expression()?];
        while self.eat(Sign::Comma) {
            list.push(self.expression()?);
        }
        Ok(list)
    }

    fn operators(&mut self, least: u8) -> Parsed<Expr> {
        self.nesting += 1;
        if self.nesting > MAX_DEPTH {
            return self.too_deep();
        }
        let mut left = self.operand()?;
        while let Some((sign, (strong, right))) = self.sign().and_then(|sign| Some((sign, binding(sign)?))) {
            if strong < least {
                break;
            }
            self.at += 1;
            let operand = self.operators(right)?;
            let span = left.span.to(operand.span);
            left = self.limited(Expr::new(ExprKind::Binary(sign, Box::new(left), Box::new(operand)), span))?;
            if strong == 10 && self.sign().and_then(binding) == Some((10, 11)) {
                return self.fail(DiagnosticNumber::SYNTAX, "comparisons do not chain; join them with .AND.");
            }
        }
        self.nesting -= 1;
        Ok(left)
    }

    fn too_deep<T>(&mut self) -> Parsed<T> {
        self.fail(DiagnosticNumber::TOO_DEEP, format!("this expression has more than {MAX_DEPTH} levels"))
    }

    fn limited(&mut self, expression: Expr) -> Parsed<Expr> {
        if expression.depth > MAX_DEPTH { self.too_deep() } else { Ok(expression) }
    }

    fn operand(&mut self) -> Parsed<Expr> {
        let start = self.span();
        let Some(token) = self.peek() else {
            return self.fail(DiagnosticNumber::SYNTAX, "a value is missing here");
        };
        self.at += 1;
        let kind = match token {
            TokenKind::Number(number) => ExprKind::Real(*number),
            TokenKind::Text(text) => ExprKind::Text(text.clone()),
            TokenKind::Keyword(code) => ExprKind::Keyword(*code),
            TokenKind::Record(class, subclass) => ExprKind::Record(RecordName { class: *class, subclass: *subclass }),
            TokenKind::Name(name) => self.word(name, start)?,
            TokenKind::Percent(name) => self.variable(VariableName::User(name.clone()))?,
            TokenKind::Global(number) => self.variable(VariableName::Global(*number))?,
            TokenKind::Local(number) => self.variable(VariableName::Local(*number))?,
            TokenKind::Param(number) => self.variable(VariableName::Param(*number))?,
            TokenKind::System(name) => self.system(name)?,
            TokenKind::Sign(sign @ (Sign::Minus | Sign::Plus | Sign::Not)) => {
                let least = if *sign == Sign::Not { NOT } else { UNARY };
                ExprKind::Unary(*sign, Box::new(self.operators(least)?))
            }
            TokenKind::Sign(Sign::Open) => {
                let inner = self.operators(0)?;
                self.expect(Sign::Close)?;
                return Ok(Expr { span: start.to(self.before()), ..inner });
            }
            TokenKind::Sign(Sign::OpenBrace) => self.braces()?,
            TokenKind::Sign(_) => {
                self.at -= 1;
                return self.fail(DiagnosticNumber::SYNTAX, "a value is expected here");
            }
        };
        let expression = Expr::new(kind, start.to(self.before()));
        self.limited(expression)
    }

    fn braces(&mut self) -> Parsed<ExprKind> {
        if self.eat(Sign::CloseBrace) {
            return Ok(ExprKind::Sequence(Vec::new()));
        }
        let list = self.list()?;
        self.expect(Sign::CloseBrace)?;
        Ok(ExprKind::Sequence(list))
    }

    fn word(&mut self, name: &str, span: Span) -> Parsed<ExprKind> {
        if name.starts_with("CODE_") {
            return Ok(ExprKind::Code(name.to_owned()));
        }
        if let Some(rest) = name.strip_prefix("REG_").or_else(|| name.strip_prefix("DATA_")) {
            return Ok(ExprKind::Register(format!("REG_{rest}")));
        }
        if let Some(code) = ident::minor_code(name) {
            return Ok(ExprKind::Keyword(code));
        }
        if let Some(record) = ident::record(name) {
            return Ok(ExprKind::Record(record));
        }
        if ident::reserved(name).is_some() {
            let message = format!("{name} is a word of the language, not a value");
            return self.fail_at(
                span,
                DiagnosticNumber::RESERVED_WORD,
                message,
                Some(format!("a variable is written %{name}")),
            );
        }
        self.variable(VariableName::User(name.to_owned()))
    }

    fn system(&mut self, name: &str) -> Parsed<ExprKind> {
        Ok(match name {
            "$TRUE" => ExprKind::Logical(true),
            "$FALSE" => ExprKind::Logical(false),
            "$NULL" => ExprKind::Null,
            "$PI" => ExprKind::Real(std::f64::consts::PI),
            _ if name.starts_with("$F") && self.sign() == Some(Sign::Open) => {
                self.at += 1;
                let mut arguments = Vec::new();
                if !self.eat(Sign::Close) {
                    arguments = self.list()?;
                    self.expect(Sign::Close)?;
                }
                ExprKind::Call(name.to_owned(), arguments)
            }
            _ => self.variable(VariableName::System(name.to_owned()))?,
        })
    }

    /// Reads the part after a variable: indices or a range.
    pub(crate) fn variable(&mut self, variable: VariableName) -> Parsed<ExprKind> {
        if !self.eat(Sign::Open) {
            return Ok(ExprKind::Variable(variable));
        }
        if self.eat(Sign::Close) {
            return Ok(ExprKind::Element(variable, Vec::new()));
        }
        if self.eat(Sign::Colon) {
            return self.range(variable, None);
        }
        let first = self.expression()?;
        if self.eat(Sign::Colon) {
            return self.range(variable, Some(first));
        }
        let mut indices = vec![first];
        while self.eat(Sign::Comma) {
            indices.push(self.expression()?);
        }
        self.expect(Sign::Close)?;
        if self.sign() == Some(Sign::Open) {
            self.fail::<()>(
                DiagnosticNumber::SYNTAX,
                "an element cannot be indexed again; assign it to a variable first",
            )?;
        }
        Ok(ExprKind::Element(variable, indices))
    }

    fn range(&mut self, variable: VariableName, from: Option<Expr>) -> Parsed<ExprKind> {
        let to = if self.sign() == Some(Sign::Close) { None } else { Some(Box::new(self.expression()?)) };
        self.expect(Sign::Close)?;
        Ok(ExprKind::Range(variable, from.map(Box::new), to))
    }
}
