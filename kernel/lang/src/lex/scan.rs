//! Tokens of one squeezed logical line.
//!
//! *Invariant:* every pass of the loop consumes at least one character.

use super::{LogicalLine, MAX_NAME, Sign, Spanned, TokenKind};
use crate::diag::{DiagnosticNumber, MacroDiagnostic};
use crate::source::{MacroSource, Span};

struct TokenScanner<'a> {
    source: &'a MacroSource,
    text: &'a [(char, u32)],
    at: usize,
}

/// Scans the label and the tokens of a line.
pub(super) fn tokens(
    source: &MacroSource,
    text: &[(char, u32)],
    line: &mut LogicalLine,
    diagnostics: &mut Vec<MacroDiagnostic>,
) {
    let mut scanner = TokenScanner { source, text, at: 0 };
    scanner.label(line, diagnostics);
    while scanner.at < text.len() {
        let begin = scanner.at;
        match scanner.token() {
            Ok(token) => line.tokens.push(Spanned { token, span: scanner.span(begin) }),
            Err((number, message)) => {
                scanner.at = scanner.at.max(begin + 1);
                diagnostics.push(MacroDiagnostic::new(source, scanner.span(begin), number, message));
            }
        }
    }
}

type Fault = (DiagnosticNumber, String);

impl TokenScanner<'_> {
    fn peek(&self, ahead: usize) -> Option<char> {
        self.text.get(self.at + ahead).map(|(character, _)| *character)
    }

    fn span(&self, begin: usize) -> Span {
        let place = |at: usize| self.text.get(at).copied();
        let start = place(begin).map_or(0, |(_, offset)| offset);
        let end = place(self.at.saturating_sub(1).max(begin))
            .map_or(start, |(character, offset)| offset + u32::try_from(character.len_utf8()).unwrap_or(1));
        Span { start, end: end.min(u32::try_from(self.source.text.len()).unwrap_or(u32::MAX)) }
    }

    fn run(&self, from: usize) -> usize {
        let word = |(character, _): &&(char, u32)| character.is_ascii_alphanumeric() || *character == '_';
        self.text.iter().skip(from).take_while(word).count()
    }

    fn take(&mut self, count: usize) -> String {
        let taken = self.text.iter().skip(self.at).take(count).map(|(character, _)| character.to_ascii_uppercase());
        let taken = taken.collect();
        self.at += count;
        taken
    }

    fn label(&mut self, line: &mut LogicalLine, diagnostics: &mut Vec<MacroDiagnostic>) {
        let length = self.run(0);
        if length == 0 || self.peek(length) != Some(':') {
            return;
        }
        let name = self.take(length);
        let span = self.span(0);
        self.at += 1;
        if name.bytes().any(|byte| byte.is_ascii_alphabetic()) && length <= MAX_NAME {
            line.label = Some((name, span));
        } else {
            let message = format!("a label has at least one letter and at most {MAX_NAME} characters");
            diagnostics.push(MacroDiagnostic::new(self.source, span, DiagnosticNumber::BAD_LABEL, message));
        }
    }

    fn token(&mut self) -> Result<TokenKind, Fault> {
        let first = self.peek(0).unwrap_or(' ');
        match first {
            '\'' => Ok(self.quoted()),
            '0'..='9' => self.number(),
            '.' if self.peek(1).is_some_and(|c| c.is_ascii_digit()) => self.number(),
            '.' => self.dotted(),
            'A'..='Z' | 'a'..='z' => self.word().map(TokenKind::Name),
            '%' => self.percent(),
            '$' => self.system(),
            '#' => self.hash(),
            _ => self.sign(first),
        }
    }

    fn quoted(&mut self) -> TokenKind {
        let mut text = String::new();
        self.at += 1;
        while let Some(character) = self.peek(0) {
            self.at += 1;
            if character == '\'' {
                if self.peek(0) != Some('\'') {
                    break;
                }
                self.at += 1;
            }
            text.push(character);
        }
        TokenKind::Text(text)
    }

    /// Length of `.LETTERS.` here, 0 if there is none.
    fn operator_length(&self, from: usize) -> usize {
        if self.peek(from) != Some('.') {
            return 0;
        }
        let letters = self.text.iter().skip(self.at + from + 1).take(6).take_while(|(c, _)| c.is_ascii_alphabetic());
        let letters = letters.count();
        if letters > 0 && self.peek(from + 1 + letters) == Some('.') { letters + 2 } else { 0 }
    }

    fn digits(&self, from: usize) -> usize {
        self.text.iter().skip(self.at + from).take_while(|(c, _)| c.is_ascii_digit()).count()
    }

    fn number(&mut self) -> Result<TokenKind, Fault> {
        let mut length = self.digits(0);
        if self.peek(length) == Some('.') && self.operator_length(length) == 0 {
            length += 1;
            length += self.digits(length);
        }
        let text = self.take(length);
        match text.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(TokenKind::Number(number)),
            _ => Err((DiagnosticNumber::BAD_NUMBER, "this is not a number, or it is too large".into())),
        }
    }

    fn dotted(&mut self) -> Result<TokenKind, Fault> {
        let length = self.operator_length(0);
        if length == 0 {
            self.at += 1;
            return Err((
                DiagnosticNumber::STRANGE_CHARACTER,
                "a single point is neither a number nor an operator".into(),
            ));
        }
        let text = self.take(length);
        Ok(TokenKind::Sign(match text.as_str() {
            ".EQ." => Sign::Equal,
            ".NE." => Sign::NotEqual,
            ".GT." => Sign::Greater,
            ".LT." => Sign::Less,
            ".GE." => Sign::GreaterEqual,
            ".LE." => Sign::LessEqual,
            ".NOT." => Sign::Not,
            ".AND." => Sign::And,
            ".OR." => Sign::Or,
            ".XOR." => Sign::Xor,
            ".TRUE." => return Ok(TokenKind::System("$TRUE".into())),
            ".FALSE." => return Ok(TokenKind::System("$FALSE".into())),
            _ => return Err((DiagnosticNumber::STRANGE_CHARACTER, format!("unknown operator `{text}`"))),
        }))
    }

    fn word(&mut self) -> Result<String, Fault> {
        let name = self.take(self.run(self.at));
        let limit = if name.starts_with("CODE_") || name.starts_with("REG_") { 2 * MAX_NAME } else { MAX_NAME };
        if name.len() > limit {
            return Err((DiagnosticNumber::BAD_NAME, format!("names have at most {MAX_NAME} characters")));
        }
        Ok(name)
    }

    fn percent(&mut self) -> Result<TokenKind, Fault> {
        self.at += 1;
        if !self.peek(0).is_some_and(|c| c.is_ascii_alphabetic()) {
            return Err((DiagnosticNumber::BAD_NAME, "a name must follow `%`".into()));
        }
        let name = self.word()?;
        let rest = name.get(1..).unwrap_or("");
        let number = (matches!(rest.len(), 1 | 2)).then(|| rest.parse::<u8>().ok()).flatten();
        Ok(match (name.as_bytes().first(), number) {
            (Some(b'G'), Some(number)) => TokenKind::Global(number),
            (Some(b'L'), Some(number)) => TokenKind::Local(number),
            _ => TokenKind::Percent(name),
        })
    }

    fn system(&mut self) -> Result<TokenKind, Fault> {
        self.at += 1;
        if !self.peek(0).is_some_and(|c| c.is_ascii_alphabetic()) {
            return Err((
                DiagnosticNumber::STRANGE_CHARACTER,
                "a name, a second `$` or a blank must follow `$`".into(),
            ));
        }
        let name = self.word()?;
        if let Some(number) = name.strip_prefix('P').filter(|rest| rest.len() <= 2).and_then(|rest| rest.parse().ok()) {
            if number == 0 {
                return Err((DiagnosticNumber::BAD_NAME, "arguments are numbered from `$P1` to `$P99`".into()));
            }
            return Ok(TokenKind::Param(number));
        }
        Ok(TokenKind::System(format!("${name}")))
    }

    fn hash_part(&mut self) -> Option<i32> {
        if self.peek(0) == Some('*') {
            self.at += 1;
            return Some(-1);
        }
        let length = self.digits(0);
        self.take(length).parse().ok()
    }

    fn hash(&mut self) -> Result<TokenKind, Fault> {
        let fault =
            || (DiagnosticNumber::BAD_NUMBER, "a code is written `#71`, a record `#2000:1030` or `#*:*`".to_owned());
        self.at += 1;
        let first = self.hash_part().ok_or_else(fault)?;
        if self.peek(0) == Some(':') && self.peek(1).is_some_and(|c| c == '*' || c.is_ascii_digit()) {
            self.at += 1;
            return Ok(TokenKind::Record(first, self.hash_part().ok_or_else(fault)?));
        }
        if first < 0 { Err(fault()) } else { Ok(TokenKind::Keyword(first)) }
    }

    fn sign(&mut self, first: char) -> Result<TokenKind, Fault> {
        let two = match (first, self.peek(1)) {
            ('/', Some('/')) => Some(Sign::Join),
            ('+', Some('=')) => Some(Sign::AddAssign),
            ('-', Some('=')) => Some(Sign::SubtractAssign),
            ('*', Some('=')) => Some(Sign::MultiplyAssign),
            ('/', Some('=')) => Some(Sign::DivideAssign),
            ('*', Some('*')) => Some(Sign::Power),
            ('=', Some('=')) => Some(Sign::Equal),
            ('!', Some('=')) => Some(Sign::NotEqual),
            ('>', Some('=')) => Some(Sign::GreaterEqual),
            ('<', Some('=')) => Some(Sign::LessEqual),
            ('&', Some('&')) => Some(Sign::And),
            ('|', Some('|')) => Some(Sign::Or),
            ('^', Some('^')) => Some(Sign::Xor),
            _ => None,
        };
        if let Some(sign) = two {
            self.at += 2;
            return Ok(TokenKind::Sign(sign));
        }
        self.at += 1;
        Ok(TokenKind::Sign(match first {
            '/' => Sign::Slash,
            '(' => Sign::Open,
            ')' => Sign::Close,
            '{' => Sign::OpenBrace,
            '}' => Sign::CloseBrace,
            ',' => Sign::Comma,
            ':' => Sign::Colon,
            '=' => Sign::Assign,
            '+' => Sign::Plus,
            '-' => Sign::Minus,
            '*' => Sign::Star,
            '>' => Sign::Greater,
            '<' => Sign::Less,
            '!' => Sign::Not,
            _ => {
                let message = format!("illegal character `{}` outside a text", first.escape_default());
                return Err((DiagnosticNumber::STRANGE_CHARACTER, message));
            }
        }))
    }
}
