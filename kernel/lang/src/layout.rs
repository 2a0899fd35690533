//! The two styles of writing: standard (upper case, dotted operators) and C (lower case, C operators).

use crate::diag::Diagnostic;
use crate::lex::{self, Line, MAX_LINE, Sign, Token};
use crate::source::Source;

/// A style of writing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// Upper case, `.EQ.`
    Standard,
    /// Lower case, `==`
    C,
}

/// Writes a file in a style: two blanks of indentation per block, one statement per line, comments kept.
///
/// # Errors
/// The diagnostics of a file that cannot be read.
pub fn format(text: &str, style: Style) -> Result<String, Vec<Diagnostic>> {
    let source = Source::new("", text);
    let (_, diagnostics) = crate::parse::parse(&source);
    if diagnostics.iter().any(Diagnostic::is_error) {
        return Err(diagnostics);
    }
    let (lines, _) = lex::lex(&source);
    let (mut out, mut depth) = (String::new(), 0usize);
    for line in &lines {
        let (before, after) = shifts(line);
        // A comment that gets a line of its own stands where it will stand when it is formatted again.
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
fn shifts(line: &Line) -> (usize, usize) {
    let word = |at: usize| match line.tokens.get(at).map(|spanned| &spanned.token) {
        Some(Token::Name(name)) => name.as_str(),
        _ => "",
    };
    let slash = line.tokens.get(1).is_some_and(|spanned| spanned.token == Token::Sign(Sign::Slash));
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
    let source = Source::new("", text);
    let (lines, _) = lex::lex(&source);
    lines.iter().flat_map(|line| tokens(line, Style::Standard)).collect()
}

fn tokens(line: &Line, style: Style) -> Vec<String> {
    let cased = |text: &str| if style == Style::C { text.to_lowercase() } else { text.to_owned() };
    let mut out = Vec::new();
    if let Some((label, _)) = &line.label {
        out.push(format!("{}:{}", cased(label), if line.tokens.is_empty() { "" } else { " " }));
    }
    for (position, spanned) in line.tokens.iter().enumerate() {
        let command = position == 1 && matches!(line.tokens.first().map(|first| &first.token), Some(Token::Name(_)));
        out.push(match &spanned.token {
            Token::Number(number) => number_text(*number),
            Token::Text(text) => format!("'{}'", text.replace('\'', "''")),
            Token::Name(name) => cased(name),
            Token::Percent(name) => cased(&format!("%{name}")),
            Token::Global(number) => cased(&format!("%G{number:02}")),
            Token::Local(number) => cased(&format!("%L{number:02}")),
            Token::Param(number) => cased(&format!("$P{number}")),
            Token::System(name) if name == "$TRUE" && style == Style::Standard => ".TRUE.".to_owned(),
            Token::System(name) if name == "$FALSE" && style == Style::Standard => ".FALSE.".to_owned(),
            Token::System(name) => cased(name),
            Token::Keyword(code) => format!("#{code}"),
            Token::Record(class, subclass) => format!("#{}:{}", star(*class), star(*subclass)),
            Token::Sign(Sign::Slash) if command => "/".to_owned(),
            Token::Sign(sign) if style == Style::C => c_sign(*sign),
            Token::Sign(sign) => sign.standard().to_owned(),
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
