//! A block of the pre-processor, read.
//!
//! Facts: reference control-emulator.md 5.4, 5.5. Decisions: marks of optional skip are at the start of the block and
//! directly after its sequence number or name, and the last mark decides about the text after it; everywhere else `/`
//! divides.

use super::cursor::{Cursor, Mistake};
use super::expr::{Expr, Own, Reader, Variable, name_text, number_text};
use super::lap::Lap;
use super::names::{self, Local, normal};
use super::text::Prepared;
use crate::statement::{RETURN, Shared, Statements};
use crate::words::{Span, part, span};

/// Key words of statements that other controls have too.
const STATEMENTS: Statements<&str> = &[("RTS", &RETURN)];

/// A block.
#[derive(Debug, Default)]
pub(super) struct Line {
    /// Marks and the sequence number or name before everything else.
    pub(super) head: Vec<Head>,
    pub(super) statement: Statement,
    /// The block with blanks in place of comments and messages.
    pub(super) plain: Box<[u8]>,
    pub(super) messages: Vec<String>,
    /// A comment has no end.
    pub(super) open: bool,
    /// Its relation to contours.
    pub(super) lap: Option<Lap>,
    /// Its text starts with no mark of optional skip and is for the interpreter, whether plain words are or not.
    pub(super) executes: bool,
    /// It leaves no text and needs none: a jump, a loop or values for variables.
    pub(super) alone: bool,
}

/// The text before a statement.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Head {
    /// A mark of optional skip with its level.
    Mark(Option<u8>),
    /// A sequence number.
    Number(Span),
    /// A sequence name.
    Name(Span),
    /// The name of a program.
    Program(Span),
}

/// The content of a block.
#[derive(Debug, Default, PartialEq)]
pub(super) enum Statement {
    /// Changes neither path nor time.
    Drawing,
    /// Nothing more.
    #[default]
    Nothing,
    /// It continues with a line above it that does not exist.
    Continued,
    /// Go to a block, if something is true.
    Goto(Option<Expr>, Target),
    /// `WHILE [condition] DO n`, or `DO n`, which is left by a jump.
    Loop(Option<Expr>, u8),
    /// `END n`
    EndLoop(u8),
    Call(Call),
    ModIn(Call),
    ModOut,
    /// A statement that other controls have too, with its operands.
    Shared(&'static Shared, Box<[Expr]>),
    /// Words and assignments.
    Items(Vec<Item>),
}

/// A block to go to.
#[derive(Debug, PartialEq)]
pub(super) enum Target {
    /// By its sequence number or name, without N.
    Named(String),
    /// By a number that is computed.
    Computed(Expr),
}

/// A call of a subprogram.
#[derive(Debug, PartialEq)]
pub(super) struct Call {
    /// Its name, with O.
    pub(super) name: String,
    /// How often it is repeated.
    pub(super) repeats: Option<Expr>,
    pub(super) arguments: Vec<(Local, Expr)>,
}

/// A part of a block.
#[derive(Debug, PartialEq)]
pub(super) enum Item {
    /// Text for the machine's tables.
    Plain(Span),
    /// An offset of the tool in the spindle: `HA`, `DB`.
    OfTool(String, Span),
    /// A value for a word or a variable.
    Set {
        /// Name of the word or variable, in capitals.
        name: String,
        /// The variable that it could be; none for the letter of a word with its value in brackets.
        variable: Option<Variable>,
        value: Expr,
        /// Place of the value, if it is only a number.
        number: Option<Span>,
        span: Span,
    },
    /// A text for a variable of the control: `VUACM[1]='NO PART'`.
    Text { variable: Variable, text: String, span: Span },
}

/// The parts that are removed from blocks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wanted {
    /// CALL, MODIN and MODOUT.
    pub(super) subprograms: bool,
    /// Statements for the screen and the tool management.
    pub(super) drawing: bool,
    /// HA to DC alone are offsets of the tool in the spindle.
    pub(super) offsets: bool,
}

/// Reads a block.
pub(super) fn read(prepared: Prepared, wanted: Wanted) -> Result<Line, Mistake> {
    let Prepared { plain, upper, messages, open } = prepared;
    let mut reading = Reading { plain: &plain, cursor: Cursor::new(&upper), offsets: wanted.offsets };
    if let Some(header) = reading.of_the_file() {
        return Ok(Line { statement: header, plain: plain.into(), messages, open, ..Line::default() });
    }
    let head = reading.head();
    let statement = reading.statement(wanted)?;
    Ok(Line { head, statement, plain: plain.into(), messages, open, ..Line::default() })
}

/// A block that is being read.
struct Reading<'a> {
    plain: &'a [u8],
    cursor: Cursor<'a>,
    /// HA to DC alone are offsets.
    offsets: bool,
}

impl Reading<'_> {
    /// The place from byte `start` to byte `end`, without blanks at the end.
    fn place(&self, start: usize, end: usize) -> Span {
        span(start, start + self.plain.get(start..end).unwrap_or_default().trim_ascii_end().len())
    }

    /// A line that begins with `$`: the name of the file (`$NAME.MIN%`), or the rest of the line above.
    fn of_the_file(&mut self) -> Option<Statement> {
        let is = self.cursor.peek() == Some(b'$');
        is.then(|| if is_header(self.plain) { Statement::Nothing } else { Statement::Continued })
    }

    fn head(&mut self) -> Vec<Head> {
        let mut head = Vec::new();
        let mut has_name = false;
        loop {
            match self.cursor.peek() {
                Some(b'/') => {
                    self.cursor.at += 1;
                    let level = self.cursor.here().filter(|byte| (b'1'..=b'9').contains(byte));
                    self.cursor.at += usize::from(level.is_some());
                    head.push(Head::Mark(level.map(|digit| digit - b'0')));
                }
                Some(letter @ (b'N' | b'O')) if !has_name => match self.named(letter) {
                    Some(name) => {
                        head.push(name);
                        has_name = true;
                    }
                    None => break,
                },
                _ => break,
            }
        }
        head
    }

    /// The sequence number or name, or the name of a program.
    fn named(&mut self, letter: u8) -> Option<Head> {
        let mut ahead = self.cursor.clone();
        let start = ahead.at;
        ahead.at += 1;
        let name = ahead.run(|byte| byte.is_ascii_digit() || byte.is_ascii_uppercase());
        let digits = name.bytes().take_while(u8::is_ascii_digit).count();
        let program = letter == b'O';
        if name.is_empty() || matches!(ahead.here(), Some(b'=' | b'[')) && digits == 0 {
            return None;
        }
        if matches!(self.plain.get(start..ahead.at), Some(word) if names::is_statement(word, ahead.clone().peek().is_some()))
        {
            return None;
        }
        // N10G0X5: a number ends where a letter begins.
        if !program && digits > 0 {
            ahead.at = start + 1 + digits;
        }
        self.cursor = ahead;
        let place = span(start, self.cursor.at);
        Some(match program {
            true => Head::Program(place),
            false if digits > 0 => Head::Number(place),
            false => Head::Name(place),
        })
    }

    fn statement(&mut self, wanted: Wanted) -> Result<Statement, Mistake> {
        let cursor = &mut self.cursor;
        if cursor.peek().is_none() {
            return Ok(Statement::Nothing);
        }
        if cursor.word("MSG") || cursor.word("NMSG") {
            cursor.end()?;
            return Ok(Statement::Nothing);
        }
        if let Some((_, shared)) = STATEMENTS.iter().find(|(word, _)| cursor.word(word)) {
            return Ok(Statement::Shared(shared, operands(cursor, shared.operands)?));
        }
        if cursor.word("NOEX") {
            return self.items();
        }
        if wanted.drawing && super::drawing::is_drawing(cursor) {
            return Ok(Statement::Drawing);
        }
        if cursor.key_word("GOTO") {
            let target = self.target()?;
            return Ok(Statement::Goto(None, target));
        }
        if let Some(statement) = self.loops()? {
            return Ok(statement);
        }
        let cursor = &mut self.cursor;
        let start = cursor.at;
        if cursor.key_word("IF") {
            if cursor.peek() == Some(b'[') || cursor.key_word("VPBR") {
                cursor.at = start + 2;
                return self.condition();
            }
            cursor.at = start;
        }
        if wanted.subprograms {
            if cursor.word("MODOUT") {
                cursor.end()?;
                return Ok(Statement::ModOut);
            }
            if cursor.key_word("MODIN") {
                return self.call().map(Statement::ModIn);
            }
            if cursor.key_word("CALL") {
                return self.call().map(Statement::Call);
            }
        } else if ["MODOUT", "MODIN", "CALL"].into_iter().any(|word| cursor.key_word(word)) {
            cursor.at = start;
            let (start, end) = cursor.rest();
            return Ok(Statement::Items(vec![Item::Plain(span(start, end))]));
        }
        self.items()
    }

    /// A statement of a loop, if one follows. DO and END alone with a number are not names of variables.
    fn loops(&mut self) -> Result<Option<Statement>, Mistake> {
        let cursor = &mut self.cursor;
        let start = cursor.at;
        if cursor.key_word("WHILE") {
            if cursor.peek() == Some(b'[') {
                cursor.at += 1;
                let condition = Reader::new(cursor).expression()?;
                cursor.expect(b']', "']'")?;
                if !cursor.key_word("DO") {
                    return Err(Mistake::Expected("DO after the condition", cursor.at + 1));
                }
                let Some(number) = loop_number(cursor) else {
                    return Err(Mistake::Expected("the number of the loop", cursor.at + 1));
                };
                return Ok(Some(Statement::Loop(Some(condition), number)));
            }
        } else if cursor.key_word("DO") {
            if let Some(number) = loop_number(cursor) {
                return Ok(Some(Statement::Loop(None, number)));
            }
        } else if cursor.key_word("END")
            && let Some(number) = loop_number(cursor)
        {
            return Ok(Some(Statement::EndLoop(number)));
        }
        cursor.at = start;
        Ok(None)
    }

    fn condition(&mut self) -> Result<Statement, Mistake> {
        let cursor = &mut self.cursor;
        let condition = if cursor.peek() == Some(b'[') {
            cursor.at += 1;
            let condition = Reader::new(cursor).expression()?;
            cursor.expect(b']', "']'")?;
            condition
        } else {
            let name = name_text(cursor);
            Expr::own(Own::Variable(Reader::new(cursor).variable(name)?))
        };
        cursor.key_word("GOTO");
        let target = self.target()?;
        Ok(Statement::Goto(Some(condition), target))
    }

    fn target(&mut self) -> Result<Target, Mistake> {
        let cursor = &mut self.cursor;
        cursor.expect(b'N', "a sequence name")?;
        let target = if cursor.here() == Some(b'[') {
            cursor.at += 1;
            let number = Reader::new(cursor).expression()?;
            cursor.expect(b']', "']'")?;
            Target::Computed(number)
        } else {
            let name = cursor.run(|byte| byte.is_ascii_digit() || byte.is_ascii_uppercase());
            if name.is_empty() {
                return Err(Mistake::Expected("a sequence name", cursor.at + 1));
            }
            Target::Named(normal(name))
        };
        cursor.end()?;
        Ok(target)
    }

    fn call(&mut self) -> Result<Call, Mistake> {
        let cursor = &mut self.cursor;
        cursor.expect(b'O', "the name of a program")?;
        let start = cursor.at - 1;
        if cursor.run(|byte| byte.is_ascii_digit() || byte.is_ascii_uppercase()).is_empty() {
            return Err(Mistake::Expected("the name of a program", cursor.at + 1));
        }
        let name = cursor.between(start).to_owned();
        let (mut repeats, mut arguments) = (None, Vec::new());
        loop {
            while cursor.take(b',') {}
            if cursor.peek().is_none() {
                return Ok(Call { name, repeats, arguments });
            }
            let start = cursor.at;
            cursor.run(|byte| byte.is_ascii_uppercase());
            if cursor.between(start) == "Q" && repeats.is_none() {
                let digits = !cursor.take(b'=') && matches!(cursor.peek(), Some(b'0'..=b'9'));
                repeats = Some(match digits {
                    true => Expr::constant(number_text(cursor).parse().unwrap_or(f64::MAX)),
                    false => Reader::new(cursor).expression()?,
                });
                continue;
            }
            cursor.run(|byte| byte.is_ascii_digit());
            let Some(local) = names::local(cursor.between(start)) else {
                return Err(Mistake::Expected("a local variable", start + 1));
            };
            cursor.expect(b'=', "'='")?;
            arguments.push((local, Reader::new(cursor).expression()?));
        }
    }

    /// Words and assignments.
    fn items(&mut self) -> Result<Statement, Mistake> {
        let mut items = Vec::new();
        let mut plain: Option<usize> = None;
        while let Some(byte) = self.cursor.peek() {
            let start = self.cursor.at;
            if byte == b',' {
                self.flush(&mut plain, start, &mut items);
                self.cursor.at += 1;
                continue;
            }
            if let Some(item) = self.item(start)? {
                self.flush(&mut plain, start, &mut items);
                items.push(item);
                continue;
            }
            plain.get_or_insert(start);
        }
        let end = self.cursor.at;
        self.flush(&mut plain, end, &mut items);
        Ok(Statement::Items(items))
    }

    fn flush(&self, plain: &mut Option<usize>, end: usize, items: &mut Vec<Item>) {
        if let Some(start) = plain.take() {
            items.push(Item::Plain(self.place(start, end)));
        }
    }

    /// The next item, or none after passing over a word of plain text.
    fn item(&mut self, start: usize) -> Result<Option<Item>, Mistake> {
        let name = name_text(&mut self.cursor);
        if name.is_empty() {
            self.cursor.at += 1;
            self.cursor.run(|byte| !byte.is_ascii_uppercase() && !matches!(byte, b' ' | b','));
            return Ok(None);
        }
        let letter = name.len() == 1;
        let opens = self.cursor.here() == Some(b'[');
        if letter && opens && name != "V" {
            return self.set(start, name, None).map(Some);
        }
        let mut ahead = self.cursor.clone();
        if opens || ahead.peek() == Some(b'=') {
            let variable = Reader::new(&mut self.cursor).variable(name)?;
            if self.cursor.take(b'=') {
                if self.cursor.peek() == Some(b'\'') {
                    return self.text(start, variable).map(Some);
                }
                return self.set(start, name, Some(variable)).map(Some);
            }
            return Err(Mistake::Expected("'='", self.cursor.at + 1));
        }
        if self.offsets && names::is_offset(name) {
            return Ok(Some(Item::OfTool(name.to_owned(), span(start, self.cursor.at))));
        }
        // The rest of a number, as in.
        self.cursor.run(|byte| !byte.is_ascii_uppercase() && !matches!(byte, b' ' | b',' | b'=' | b'['));
        Ok(None)
    }

    /// A text between apostrophes.
    fn text(&mut self, start: usize, variable: Variable) -> Result<Item, Mistake> {
        self.cursor.at += 1;
        let from = self.cursor.at;
        self.cursor.run(|byte| byte != b'\'');
        let text = part(self.plain, span(from, self.cursor.at)).into_owned();
        self.cursor.expect(b'\'', "an apostrophe")?;
        Ok(Item::Text { variable, text, span: span(start, self.cursor.at) })
    }

    fn set(&mut self, start: usize, name: &str, variable: Option<Variable>) -> Result<Item, Mistake> {
        self.cursor.peek();
        let from = self.cursor.at;
        let value = Reader::new(&mut self.cursor).expression()?;
        let (place, written) = (self.place(start, self.cursor.at), self.place(from, self.cursor.at));
        let is_digit = |byte: u8| byte.is_ascii_digit() || matches!(byte, b'.' | b'-' | b'+');
        let is_number = value.as_constant().is_some() && part(self.plain, written).bytes().all(is_digit);
        let number = is_number.then_some(written);
        Ok(Item::Set { name: name.to_owned(), variable, value, number, span: place })
    }
}

/// This many operands in brackets, with commas between them, and the end of the block.
fn operands(cursor: &mut Cursor<'_>, count: usize) -> Result<Box<[Expr]>, Mistake> {
    let operands = if count > 0 { Reader::new(cursor).list()? } else { Box::default() };
    if operands.len() != count {
        return Err(Mistake::Operands(count, cursor.at + 1));
    }
    cursor.end()?;
    Ok(operands)
}

/// Whether a line has the name of its file: `$NAME.MIN%`.
pub(super) fn is_header(line: &[u8]) -> bool {
    let line = line.trim_ascii();
    line.first() == Some(&b'$') && line.last() == Some(&b'%')
}

/// Whether a line continues the previous line: `$` before its words.
pub(super) fn is_continued(line: &[u8]) -> bool {
    line.trim_ascii_start().first() == Some(&b'$') && !is_header(line)
}

/// The number of a loop, with which its block ends.
fn loop_number(cursor: &mut Cursor<'_>) -> Option<u8> {
    cursor.peek();
    let number = cursor.run(|byte| byte.is_ascii_digit()).parse().ok()?;
    cursor.peek().is_none().then_some(number)
}

#[cfg(test)]
mod tests;
