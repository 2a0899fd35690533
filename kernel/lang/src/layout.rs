//! The two styles of writing: standard (upper case, dotted operators) and C (lower case, C operators).

use crate::diag::MacroDiagnostic;
use crate::lex::{self, LogicalLine, MAX_LINE, Sign, TokenKind};
use crate::source::MacroSource;

/// A style of writing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SourceStyle {
    /// Upper case, `.EQ.`
    Standard,
    /// Lower case, `==`
    C,
}

/// Writes a file in a style: two blanks of indentation per block, one statement per line, comments kept.
///
/// # Errors
/// The diagnostics of a file that cannot be read.
pub fn format(text: &str, style: SourceStyle) -> Result<String, Vec<MacroDiagnostic>> {
    let source = MacroSource::new("", text);
    let (_, diagnostics) = crate::parse::parse(&source);
    if diagnostics.iter().any(MacroDiagnostic::is_error) {
        return Err(diagnostics);
    }
    let (lines, _) = lex::lex(&source);
    let (mut out, mut depth) = (String::new(), 0usize);
    for line in &lines {
        let (before, after) = shifts(line);
        // A comment on a line of its own gets the place that the next formatting keeps.
        let outer = "  ".repeat(depth.min(20));
        depth = depth.saturating_sub(before);
        let indent = "  ".repeat(depth.min(20));
        for comment in line.comments.iter().take(line.comments.len().saturating_sub(1)) {
            comment_line(&mut out, &outer, source.slice(*comment));
        }
        let last = line.comments.last().map(|comment| source.slice(*comment));
        let statement = tokens(line, style);
        if statement.is_empty() {
            match last {
                Some(comment) => comment_line(&mut out, &indent, comment),
                None => out.push('\n'),
            }
        } else {
            if let Some(comment) = last.filter(|_| statement.iter().map(String::len).sum::<usize>() > 400) {
                comment_line(&mut out, &outer, comment);
                statement_line(&mut out, &indent, &statement, None);
            } else {
                statement_line(&mut out, &indent, &statement, last);
            }
        }
        depth += after;
    }
    Ok(out)
}

fn dollars(comment: &str) -> String {
    let comment = comment.trim_end();
    if comment.starts_with("$$") { comment.to_owned() } else { format!("$$ {comment}") }
}

fn comment_line(out: &mut String, indent: &str, comment: &str) {
    let comment = dollars(comment);
    if indent.len() + comment.chars().count() <= MAX_LINE {
        out.push_str(indent);
    }
    out.push_str(&comment);
    out.push('\n');
}

fn statement_line(out: &mut String, indent: &str, statement: &[String], comment: Option<&str>) {
    let comment = comment.map(|comment| format!(" {}", dollars(comment))).unwrap_or_default();
    out.push_str(indent);
    let mut width = indent.len();
    let room = MAX_LINE.saturating_sub(comment.chars().count() + 8).max(100);
    for (position, token) in statement.iter().enumerate() {
        let length = token.chars().count();
        if width + length > room && position > 0 {
            out.push_str("$\n");
            width = 0;
        }
        out.push_str(token);
        width += length;
    }
    out.push_str(&comment);
    out.push('\n');
}

/// Steps of indentation before and after a line.
fn shifts(line: &LogicalLine) -> (usize, usize) {
    let word = |at: usize| match line.tokens.get(at).map(|spanned| &spanned.token) {
        Some(TokenKind::Name(name)) => name.as_str(),
        _ => "",
    };
    let slash = line.tokens.get(1).is_some_and(|spanned| spanned.token == TokenKind::Sign(Sign::Slash));
    let alone = line.tokens.len() == 1;
    match (word(0), slash, alone) {
        ("IF" | "WHILE" | "DO", true, _) | ("REPEAT", _, true) => (0, 1),
        ("CASE", true, _) => (0, 2),
        ("ELSEIF" | "WHEN", true, _) | ("ELSE", _, true) => (1, 1),
        ("UNTIL", true, _) | ("ENDIF" | "ENDWHILE" | "ENDW" | "ENDDO", _, true) => (1, 0),
        ("ENDCASE" | "ENDC", _, true) => (2, 0),
        ("ENDOF", true, _) => (if word(2) == "CASE" { 2 } else { 1 }, 0),
        ("ENDMAC", _, true) | ("MACRO", true, _) => (usize::MAX, 0),
        _ => (0, 0),
    }
}

/// A statement in standard style on one line, for the trace.
#[must_use]
pub fn standard_line(text: &str) -> String {
    let source = MacroSource::new("", text);
    let (lines, _) = lex::lex(&source);
    lines.iter().flat_map(|line| tokens(line, SourceStyle::Standard)).collect()
}

fn tokens(line: &LogicalLine, style: SourceStyle) -> Vec<String> {
    let cased = |text: &str| if style == SourceStyle::C { text.to_lowercase() } else { text.to_owned() };
    let mut out = Vec::new();
    if let Some((label, _)) = &line.label {
        out.push(format!("{}:{}", cased(label), if line.tokens.is_empty() { "" } else { " " }));
    }
    for (position, spanned) in line.tokens.iter().enumerate() {
        let command =
            position == 1 && matches!(line.tokens.first().map(|first| &first.token), Some(TokenKind::Name(_)));
        out.push(match &spanned.token {
            TokenKind::Number(number) => number_text(*number),
            TokenKind::Text(text) => format!("'{}'", text.replace('\'', "''")),
            TokenKind::Name(name) => cased(name),
            TokenKind::Percent(name) => cased(&format!("%{name}")),
            TokenKind::Global(number) => cased(&format!("%G{number:02}")),
            TokenKind::Local(number) => cased(&format!("%L{number:02}")),
            TokenKind::Param(number) => cased(&format!("$P{number}")),
            TokenKind::System(name) if name == "$TRUE" && style == SourceStyle::Standard => ".TRUE.".to_owned(),
            TokenKind::System(name) if name == "$FALSE" && style == SourceStyle::Standard => ".FALSE.".to_owned(),
            TokenKind::System(name) => cased(name),
            TokenKind::Keyword(code) => format!("#{code}"),
            TokenKind::Record(class, subclass) => format!("#{}:{}", star(*class), star(*subclass)),
            TokenKind::Sign(Sign::Slash) if command => "/".to_owned(),
            TokenKind::Sign(sign) if style == SourceStyle::C => c_sign(*sign),
            TokenKind::Sign(sign) => sign.standard().to_owned(),
        });
    }
    out
}

fn c_sign(sign: Sign) -> String {
    match sign {
        Sign::Equal
        | Sign::NotEqual
        | Sign::Greater
        | Sign::Less
        | Sign::GreaterEqual
        | Sign::LessEqual
        | Sign::And
        | Sign::Or
        | Sign::Xor => format!(" {} ", sign.c()),
        _ => sign.c().to_owned(),
    }
}

fn star(number: i32) -> String {
    if number < 0 { "*".to_owned() } else { number.to_string() }
}

fn number_text(number: f64) -> String {
    let text = format!("{number}");
    match text.strip_prefix("0.") {
        Some(fraction) => format!(".{fraction}"),
        None => text,
    }
}
