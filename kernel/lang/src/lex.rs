//! Tokens: logical lines, blanks-insensitive, both spellings.
//!
//! *Invariant:* lexing never fails and takes linear time; text that cannot be a token becomes a diagnostic and is left
//! out. Facts: reference macro-language.md 1.1 to 1.3.

mod scan;

use crate::diag::{DiagnosticNumber, MacroDiagnostic};
use crate::source::{MacroSource, Span};

/// Longest physical line, in characters.
pub const MAX_LINE: usize = 512;
/// Longest name.
pub const MAX_NAME: usize = 32;

/// Kind of a token.
#[derive(Clone, Debug, PartialEq)]
pub enum TokenKind {
    /// Number.
    Number(f64),
    /// Text constant without its quotes.
    Text(String),
    /// Word in upper case.
    Name(String),
    /// User name written with a leading `%`.
    Percent(String),
    /// `%G00` to `%G99`.
    Global(u8),
    /// `%L00` to `%L99`.
    Local(u8),
    /// `$P01` to `$P99`.
    Param(u8),
    /// `$NAME` in upper case, with the dollar sign.
    System(String),
    /// `#71`
    Keyword(i32),
    /// `#2000:1030`, `-1` for `*`.
    Record(i32, i32),
    /// Operator or punctuation.
    Sign(Sign),
}

macro_rules! signs {
    ($($name:ident $standard:literal $c:literal $about:literal;)*) => {
        /// Operators and punctuation.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Sign { $(#[doc = $about] $name),* }
        impl Sign {
            /// Spelling in the standard style.
            #[must_use]
            pub const fn standard(self) -> &'static str { match self { $(Sign::$name => $standard),* } }
            /// Spelling in the C style.
            #[must_use]
            pub const fn c(self) -> &'static str { match self { $(Sign::$name => $c),* } }
        }
    };
}

signs! {
    Slash "/" "/" "`/`";
    Join "//" "//" "`//`";
    Open "(" "(" "`(`";
    Close ")" ")" "`)`";
    OpenBrace "{" "{" "`{`";
    CloseBrace "}" "}" "`}`";
    Comma "," "," "`,`";
    Colon ":" ":" "`:`";
    Assign "=" "=" "`=`";
    AddAssign "+=" "+=" "`+=`";
    SubtractAssign "-=" "-=" "`-=`";
    MultiplyAssign "*=" "*=" "`*=`";
    DivideAssign "/=" "/=" "`/=`";
    Plus "+" "+" "`+`";
    Minus "-" "-" "`-`";
    Star "*" "*" "`*`";
    Power "**" "**" "`**`";
    Equal ".EQ." "==" "equal";
    NotEqual ".NE." "!=" "not equal";
    Greater ".GT." ">" "greater";
    Less ".LT." "<" "less";
    GreaterEqual ".GE." ">=" "greater or equal";
    LessEqual ".LE." "<=" "less or equal";
    Not ".NOT." "!" "logical not";
    And ".AND." "&&" "logical and";
    Or ".OR." "||" "logical or";
    Xor ".XOR." "^^" "exclusive or";
}

/// A token with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Spanned {
    /// Its kind.
    pub token: TokenKind,
    /// Where it is.
    pub span: Span,
}

/// One logical line: a statement, perhaps with a label and comments.
#[derive(Clone, Debug, Default)]
pub struct LogicalLine {
    /// Label without its colon, upper case.
    pub label: Option<(String, Span)>,
    /// Tokens of the statement.
    pub tokens: Vec<Spanned>,
    /// Comments with their `$$`, or the text after a continuation sign.
    pub comments: Vec<Span>,
    /// The whole line.
    pub span: Span,
}

/// Splits a source into logical lines; empty lines are kept.
#[must_use]
pub fn lex(source: &MacroSource) -> (Vec<LogicalLine>, Vec<MacroDiagnostic>) {
    let mut diagnostics = Vec::new();
    let mut lines = Vec::new();
    let mut squeezed = Vec::new();
    let mut physical = source.text.split_inclusive('\n').scan(0u32, |start, text| {
        let at = *start;
        *start += u32::try_from(text.len()).unwrap_or(0);
        Some((at, text.trim_end_matches(['\n', '\r'])))
    });
    while let Some((start, text)) = physical.next() {
        let mut line = LogicalLine { span: span(start, text), ..LogicalLine::default() };
        squeezed.clear();
        let mut next = squeeze(source, start, text, &mut squeezed, &mut line, &mut diagnostics);
        while next {
            let Some((start, text)) = physical.next() else { break };
            line.span.end = span(start, text).end;
            next = squeeze(source, start, text, &mut squeezed, &mut line, &mut diagnostics);
        }
        scan::tokens(source, &squeezed, &mut line, &mut diagnostics);
        lines.push(line);
    }
    (lines, diagnostics)
}

fn span(start: u32, text: &str) -> Span {
    Span { start, end: start + u32::try_from(text.len()).unwrap_or(0) }
}

/// Appends the characters that count; says whether the line continues in the next one.
fn squeeze(
    source: &MacroSource,
    start: u32,
    text: &str,
    out: &mut Vec<(char, u32)>,
    line: &mut LogicalLine,
    diagnostics: &mut Vec<MacroDiagnostic>,
) -> bool {
    if text.len() > MAX_LINE && text.chars().count() > MAX_LINE {
        let message = format!("this line is longer than {MAX_LINE} characters; continue in the next line after a `$`");
        diagnostics.push(MacroDiagnostic::new(
            source,
            Span { start, end: start + 1 },
            DiagnosticNumber::LINE_TOO_LONG,
            message,
        ));
    }
    let mut quoted: Option<u32> = None;
    let mut characters = text.char_indices().peekable();
    while let Some((offset, character)) = characters.next() {
        let at = start + u32::try_from(offset).unwrap_or(0);
        if character == '\'' {
            quoted = if quoted.is_some() { None } else { Some(at) };
        } else if quoted.is_none() {
            match character {
                ' ' | '\t' => continue,
                '$' => match characters.peek() {
                    Some((_, '$')) => {
                        line.comments.push(Span { start: at, end: span(start, text).end });
                        return false;
                    }
                    None => return true,
                    Some((_, ' ' | '\t')) => {
                        let rest = text.get(offset + 1..).unwrap_or("");
                        if !rest.trim().is_empty() {
                            let lead = rest.len() - rest.trim_start().len();
                            let begin = at + 1 + u32::try_from(lead).unwrap_or(0);
                            line.comments.push(Span { start: begin, end: begin + len(rest.trim()) });
                        }
                        return true;
                    }
                    Some(_) => {}
                },
                _ => {}
            }
        }
        out.push((character, at));
    }
    if let Some(open) = quoted {
        let end = span(start, text).end;
        let message = "this text has no closing quote; a quote inside a text is written twice";
        diagnostics.push(MacroDiagnostic::new(source, Span { start: open, end }, DiagnosticNumber::OPEN_TEXT, message));
        out.push(('\'', end));
    }
    false
}

fn len(text: &str) -> u32 {
    u32::try_from(text.len()).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tokens(text: &str) -> Vec<TokenKind> {
        let (lines, diagnostics) = lex(&MacroSource::new("t", text));
        assert_eq!(diagnostics, []);
        lines.into_iter().flat_map(|line| line.tokens).map(|spanned| spanned.token).collect()
    }

    fn numbers(text: &str) -> Vec<DiagnosticNumber> {
        lex(&MacroSource::new("t", text)).1.into_iter().map(|diagnostic| diagnostic.number).collect()
    }

    #[test]
    fn both_spellings_give_the_same_tokens() {
        assert_eq!(tokens("IF/.NOT.A.EQ.1.OR.B.NE.2.AND.C.GT.D.XOR..TRUE."), tokens("if/!a==1||b!=2&&c>d^^$true"));
        assert_eq!(tokens("X.LE.1.LT.2.GE.3"), tokens("x<=1<2>=3"));
    }

    #[test]
    fn blanks_count_only_inside_texts() {
        assert_eq!(tokens("E N D O F / I F"), tokens("ENDOF/IF"));
        assert_eq!(
            tokens("A = 'x  Y'"),
            [TokenKind::Name("A".into()), TokenKind::Sign(Sign::Assign), TokenKind::Text("x  Y".into())]
        );
        assert_eq!(tokens("A='it''s'").last(), Some(&TokenKind::Text("it's".into())));
    }

    #[test]
    fn a_point_after_digits_may_begin_an_operator() {
        assert_eq!(tokens("0.OR.X"), tokens("0 .OR. X"));
        assert_eq!(tokens("1.LT.$XC"), tokens("1 < $XC"));
        assert_eq!(tokens("X.OR..NOT.Y"), tokens("X||!Y"));
        assert_eq!(tokens("23.45"), [TokenKind::Number(23.45)]);
        assert_eq!(tokens(".003"), [TokenKind::Number(0.003)]);
        assert_eq!(tokens("12.*3.").first(), Some(&TokenKind::Number(12.0)));
    }

    #[test]
    fn comments_and_continuation() {
        let (lines, _) = lex(&MacroSource::new("t", "A=1+ $ why\n  2 $$ done\n$$ alone\n\nB='$$ no'"));
        assert_eq!(lines.len(), 4);
        assert_eq!(lines[0].tokens.len(), 5);
        assert_eq!(lines[0].comments.len(), 2);
        assert_eq!((lines[1].tokens.len(), lines[1].comments.len()), (0, 1));
        assert_eq!(lines[3].comments.len(), 0);
    }

    #[test]
    fn names_of_every_kind() {
        let comma = TokenKind::Sign(Sign::Comma);
        let mut seen = tokens("%G2,%L07,$P3,%ON,ZTOP,$XM,#71,#2000:1030,#28000:*,#*:*");
        seen.retain(|token| *token != comma);
        assert_eq!(
            seen,
            [
                TokenKind::Global(2),
                TokenKind::Local(7),
                TokenKind::Param(3),
                TokenKind::Percent("ON".into()),
                TokenKind::Name("ZTOP".into()),
                TokenKind::System("$XM".into()),
                TokenKind::Keyword(71),
                TokenKind::Record(2000, 1030),
                TokenKind::Record(28000, -1),
                TokenKind::Record(-1, -1),
            ]
        );
    }

    #[test]
    fn labels() {
        let (lines, _) = lex(&MacroSource::new("t", "10AGAIN: A=1\nB:\nC(1:2)=3"));
        assert_eq!(lines[0].label.as_ref().unwrap().0, "10AGAIN");
        assert_eq!(lines[1].label.as_ref().unwrap().0, "B");
        assert!(lines[2].label.is_none());
    }

    #[test]
    fn what_is_no_token_is_told() {
        assert_eq!(numbers("A='x"), [DiagnosticNumber::OPEN_TEXT]);
        assert_eq!(numbers("A=?"), [DiagnosticNumber::STRANGE_CHARACTER]);
        assert_eq!(numbers("10: A=1"), [DiagnosticNumber::BAD_LABEL]);
        assert_eq!(numbers(&format!("A='{}'", "1".repeat(600))), [DiagnosticNumber::LINE_TOO_LONG]);
        assert_eq!(numbers(&format!("{}=1", "A".repeat(33))), [DiagnosticNumber::BAD_NAME]);
        assert_eq!(numbers("A=.FOO.B"), [DiagnosticNumber::STRANGE_CHARACTER]);
        assert_eq!(numbers(&format!("A={}", "9".repeat(400))), [DiagnosticNumber::BAD_NUMBER]);
    }
}
