//! Words of a line with expressions: by letter, by special register, literal texts.
//!
//! Facts: reference control-emulator.md 1.2 (ALT string), 1.4 (special registers). Invariant: names are tried in the
//! order in which the scanner of plain lines tries them.

use super::cursor::{FanucParser, FanucSyntaxError};
use super::expr::{Expr, FanucOp, Op};
use super::statement::{FanucStatement, TemplateWord, WordName};
use counterpoint_program::key_words::WrittenNumber;
use counterpoint_program::prefix_registers::{stands, starts_value};
use counterpoint_program::shape::program_name;

impl FanucParser<'_> {
    /// Whether a special register with a value, or a text that looks like a word, begins here.
    pub(super) fn stands_long_name(&self) -> bool {
        self.names.literal_first.is_some_and(|first| {
            first.text(self.text, self.at).is_some() || first.registers_at(self.text, self.at).next().is_some()
        })
    }

    pub(super) fn words(&mut self) -> Result<FanucStatement, FanucSyntaxError> {
        let mut words = Vec::new();
        while let Some(byte) = self.peek() {
            let start = self.at;
            self.written = None;
            let (name, value) = match self.long_name() {
                Some(word) => word,
                None if byte.is_ascii_uppercase() => {
                    self.at += 1;
                    (WordName::Letter(byte), self.word_value()?)
                }
                None if byte == b'<' && self.name.is_none() && program_name(self.text, start).is_some() => {
                    self.at = program_name(self.text, start).unwrap_or(self.at);
                    self.name = Some((start as u32, self.at as u32));
                    continue;
                }
                None => return Err(self.error("a word")),
            };
            let written = self.written.take();
            let is_number = matches!(name, WordName::Letter(b'N' | b'O'));
            if is_number && value.as_constant().is_none() && self.names.formulas.digits_of_numbers {
                self.at = start;
                return Err(self.error("digits after N and O"));
            }
            words.push(TemplateWord { name, value, written, start: start as u32, end: self.at as u32 });
        }
        Ok(FanucStatement::Words(words))
    }

    /// A word that is more than a letter and a value.
    fn long_name(&mut self) -> Option<(WordName, Expr)> {
        let (names, text, start) = (self.names, self.text, self.at);
        if let Some((like_word, row)) = names.literal_first.and_then(|first| first.text(text, start)) {
            self.at += like_word.len();
            return Some((WordName::Text(row), Expr::constant(0.0)));
        }
        for prefix in names.literal_first.into_iter().flat_map(|first| first.registers_at(text, start)) {
            self.at = start + prefix.before.len();
            // Text after the number encloses an expression like brackets.
            let value = if prefix.after.is_empty() { self.word_value() } else { self.enclosed() };
            if let Ok(value) = value
                && text.get(self.at..).is_some_and(|rest| rest.starts_with(&prefix.after))
            {
                self.at += prefix.after.len();
                return Some((WordName::Register(prefix.register, prefix.incremental), value));
            }
            self.at = start;
        }
        if starts_value(text, start + 1) {
            return None;
        }
        let (plain, row) = names.texts(*text.get(start)?).iter().find(|(name, _)| stands(name, text, start))?;
        self.at += plain.len();
        Some((WordName::Text(*row), Expr::constant(0.0)))
    }

    /// The number whose digits stand from `start` to here; an expression in brackets is none.
    fn as_written(&self, start: usize, value: f64) -> Option<WrittenNumber> {
        let text = self.text.get(start..self.at)?.trim_ascii();
        if !text.iter().all(|byte| byte.is_ascii_digit() || *byte == b'.') {
            return None;
        }
        let point = text.iter().position(|byte| *byte == b'.');
        let digits = point.unwrap_or(text.len()).min(255) as u8;
        let fraction = point.map_or(0, |point| text.len() - point - 1).min(255) as u8;
        Some(WrittenNumber { value, point: point.is_some(), digits, fraction })
    }

    fn enclosed(&mut self) -> Result<Expr, FanucSyntaxError> {
        let mut ops = Vec::new();
        let sign = self.peek().filter(|byte| b"+-".contains(byte));
        let start = self.at + usize::from(sign.is_some());
        self.expression(&mut ops)?;
        self.written = match ops.as_slice() {
            [Op::Value(value)] => self.as_written(start, *value),
            _ => None,
        };
        self.checked(ops)
    }

    fn word_value(&mut self) -> Result<Expr, FanucSyntaxError> {
        let mut ops = Vec::new();
        let sign = self.at;
        let negative = match self.peek() {
            Some(sign @ (b'-' | b'+')) => {
                self.at += 1;
                sign == b'-'
            }
            _ => false,
        };
        self.blanks();
        let start = self.at;
        // Letters after the first letter of the word are a function only if the control has that function.
        if self.peek().is_some_and(|byte| byte.is_ascii_uppercase()) && !self.stands_function() {
            return Err(self.error("a value"));
        }
        self.primary(&mut ops)?;
        if self.names.formulas.bare_sums && self.peek().is_some_and(|byte| b"+-*/".contains(&byte)) {
            (self.at, ops) = (sign, Vec::new());
            self.expression(&mut ops)?;
            return self.checked(ops);
        }
        self.written = match ops.as_slice() {
            [Op::Value(value)] => self.as_written(start, if negative { -*value } else { *value }),
            _ => None,
        };
        if negative {
            match ops.as_mut_slice() {
                // A negated constant stays one.
                [Op::Value(value)] => *value = -*value,
                _ => ops.push(Op::Own(FanucOp::Minus)),
            }
        }
        self.checked(ops)
    }
}
