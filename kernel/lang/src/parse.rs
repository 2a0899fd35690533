//! From tokens to the tree.
//!
//! *Invariant:* parsing never fails; it gives a tree and diagnostics, continues at the next line after an error, and
//! takes linear time. Facts: reference macro-language.md 1 to 3; the grammar is in docs/macro-language/grammar.md.

mod expression;
mod statement;

pub use statement::COMMANDS;

use crate::ast::{Expr, ExprKind, MacroStatement, ParsedMacro, StatementKind, VariableName, WhenItem};
use crate::diag::{DiagnosticNumber, MacroDiagnostic};
use crate::lex::{self, LogicalLine, Sign, Spanned, TokenKind};
use crate::source::{MacroSource, Span};
use std::collections::HashSet;

/// Most diagnostics of one file.
pub const MAX_DIAGNOSTICS: usize = 200;

/// Marks that a diagnostic was made and the line is abandoned.
pub(crate) struct GivenUp;

type Parsed<T> = Result<T, GivenUp>;

/// Cursor over the tokens of one logical line.
pub(crate) struct LineParser<'a> {
    source: &'a MacroSource,
    tokens: &'a [Spanned],
    at: usize,
    end: Span,
    nesting: u32,
    diagnostics: &'a mut Vec<MacroDiagnostic>,
}

/// Reads a file.
#[must_use]
pub fn parse(source: &MacroSource) -> (Vec<ParsedMacro>, Vec<MacroDiagnostic>) {
    let (lines, mut diagnostics) = lex::lex(source);
    let mut macros = Vec::new();
    let mut current = ParsedMacro::default();
    let broken: HashSet<u32> = diagnostics.iter().map(|diagnostic| diagnostic.line).collect();
    let mut unheard = Vec::new();
    for line in &lines {
        if line.tokens.is_empty() && line.label.is_none() {
            continue;
        }
        // Text that the lexer refused would only be refused again.
        let hears = broken.is_empty()
            || !(source.line(line.span.start)..=source.line(line.span.end)).any(|n| broken.contains(&n));
        unheard.clear();
        let hearer = if hears { &mut diagnostics } else { &mut unheard };
        if let Some(statement) = header_or_statement(source, line, &mut current, &mut macros, hearer) {
            if current.statements.is_empty() && current.header.is_none() {
                current.span = statement.span;
            }
            let last = statement.kind == StatementKind::EndMacro;
            current.statements.push(statement);
            if last {
                macros.push(std::mem::take(&mut current));
            }
        }
    }
    // A file without statements is a macro that does nothing.
    if !current.statements.is_empty() || current.header.is_some() || (macros.is_empty() && diagnostics.is_empty()) {
        macros.push(current);
    }
    (macros, diagnostics)
}

/// Reads one expression, as embedded macro code has it; none if the text is not an expression.
#[must_use]
pub fn expression(source: &MacroSource) -> Option<crate::ast::Expr> {
    let (lines, diagnostics) = lex::lex(source);
    let line = lines.iter().find(|line| !line.tokens.is_empty())?;
    let mut found = Vec::new();
    let mut parser = LineParser::new(source, line, &mut found);
    let expression = parser.expression().ok()?;
    let done = parser.at == line.tokens.len();
    (done && found.is_empty() && diagnostics.is_empty()).then_some(expression)
}

fn header_or_statement(
    source: &MacroSource,
    line: &LogicalLine,
    current: &mut ParsedMacro,
    macros: &mut Vec<ParsedMacro>,
    diagnostics: &mut Vec<MacroDiagnostic>,
) -> Option<MacroStatement> {
    let mut parser = LineParser::new(source, line, diagnostics);
    if parser.command("MACRO") {
        if !current.statements.is_empty() || current.header.is_some() {
            macros.push(std::mem::take(current));
        }
        if let Ok(header) = parser.header() {
            current.span = header.span;
            current.header = Some(header);
        }
        return None;
    }
    let kind = parser.statement().unwrap_or_else(|GivenUp| stand_in(line));
    Some(MacroStatement { label: line.label.clone(), kind, span: line_span(line) })
}

/// Keeps the blocks in balance after an error in the line that opens or divides one.
fn stand_in(line: &LogicalLine) -> StatementKind {
    let Some(TokenKind::Name(word)) = line.tokens.first().map(|spanned| &spanned.token) else {
        return StatementKind::Empty;
    };
    let expr = |kind| Expr::new(kind, line_span(line));
    match word.as_str() {
        "IF" => StatementKind::If(expr(ExprKind::Logical(true))),
        "WHILE" => StatementKind::While(expr(ExprKind::Logical(true))),
        "UNTIL" => StatementKind::Until(expr(ExprKind::Logical(true))),
        "CASE" => StatementKind::Case(expr(ExprKind::Real(0.0))),
        "WHEN" => StatementKind::When(vec![WhenItem::One(expr(ExprKind::Real(0.0)))]),
        "DO" => StatementKind::Do {
            variable: expr(ExprKind::Variable(VariableName::Local(0))),
            start: expr(ExprKind::Real(0.0)),
            end: expr(ExprKind::Real(0.0)),
            step: None,
        },
        _ => StatementKind::Empty,
    }
}

fn line_span(line: &LogicalLine) -> Span {
    let start = line.label.as_ref().map(|(_, span)| *span);
    let first = line.tokens.first().map(|token| token.span);
    let last = line.tokens.last().map(|token| token.span);
    let from = start.or(first).unwrap_or(line.span);
    from.to(last.unwrap_or(from))
}

impl<'a> LineParser<'a> {
    fn new(
        source: &'a MacroSource,
        line: &'a LogicalLine,
        diagnostics: &'a mut Vec<MacroDiagnostic>,
    ) -> LineParser<'a> {
        let end = line.tokens.last().map_or(line.span.end, |token| token.span.end);
        LineParser { source, tokens: &line.tokens, at: 0, end: Span { start: end, end }, nesting: 0, diagnostics }
    }

    fn peek(&self) -> Option<&'a TokenKind> {
        self.peek_at(0)
    }

    fn peek_at(&self, ahead: usize) -> Option<&'a TokenKind> {
        self.tokens.get(self.at + ahead).map(|spanned| &spanned.token)
    }

    fn sign(&self) -> Option<Sign> {
        match self.peek() {
            Some(TokenKind::Sign(sign)) => Some(*sign),
            _ => None,
        }
    }

    fn span(&self) -> Span {
        self.tokens.get(self.at).map_or(self.end, |spanned| spanned.span)
    }

    fn before(&self) -> Span {
        self.at.checked_sub(1).and_then(|at| self.tokens.get(at)).map_or(self.end, |spanned| spanned.span)
    }

    fn eat(&mut self, sign: Sign) -> bool {
        let found = self.sign() == Some(sign);
        self.at += usize::from(found);
        found
    }

    fn eat_word(&mut self, word: &str) -> bool {
        let found = matches!(self.peek(), Some(TokenKind::Name(name)) if name == word);
        self.at += usize::from(found);
        found
    }

    /// Takes `WORD/`.
    fn command(&mut self, word: &str) -> bool {
        let found = matches!((self.peek(), self.peek_at(1)), (Some(TokenKind::Name(name)), Some(TokenKind::Sign(Sign::Slash))) if name == word);
        self.at += 2 * usize::from(found);
        found
    }

    fn fail<T>(&mut self, number: DiagnosticNumber, message: impl Into<String>) -> Parsed<T> {
        let span = self.span();
        self.fail_at(span, number, message, None)
    }

    fn fail_at<T>(
        &mut self,
        span: Span,
        number: DiagnosticNumber,
        message: impl Into<String>,
        help: Option<String>,
    ) -> Parsed<T> {
        self.diagnostics.push(MacroDiagnostic::new(self.source, span, number, message).help(help));
        Err(GivenUp)
    }

    fn expect(&mut self, sign: Sign) -> Parsed<()> {
        if self.eat(sign) {
            return Ok(());
        }
        self.fail(DiagnosticNumber::SYNTAX, format!("`{}` is expected here", sign.standard()))
    }

    fn done(&mut self) -> Parsed<()> {
        if self.at >= self.tokens.len() {
            return Ok(());
        }
        self.fail(DiagnosticNumber::SYNTAX, "unexpected text after a complete statement")
    }
}

#[cfg(test)]
mod tests;
