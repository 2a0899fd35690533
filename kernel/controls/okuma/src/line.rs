//! A block of the pre-processor, read.
//!
//! Facts: reference control-emulator.md 5.4, 5.5. Decisions: marks of optional skip are at the start of the block and
//! directly after its sequence number or name, and the last mark decides about the text after it; everywhere else `/`
//! divides.

use super::cursor::{OkumaCursor, OkumaSyntaxError};
use super::expr::{Expr, OkumaExpressionReader, OkumaOp, OkumaVariable, name_text, number_text};
use super::lap::LapRole;
use super::names::{self, LocalVariableName, normal};
use super::text::PreparedText;
use counterpoint_control_api::statement::{RETURN, SharedStatement, Statements};
use counterpoint_control_api::words::{Span, part, span};

/// Key words of statements that other controls have too.
const STATEMENTS: Statements<&str> = &[("RTS", &RETURN)];

/// A block.
#[derive(Debug, Default)]
pub(super) struct OkumaLine {
    /// Marks and the sequence number or name before everything else.
    pub(super) head: Vec<BlockPrefix>,
    pub(super) statement: OkumaStatement,
    /// The block with blanks in place of comments and messages.
    pub(super) plain: Box<[u8]>,
    pub(super) messages: Vec<String>,
    /// A comment has no end.
    pub(super) open: bool,
    /// Its relation to contours.
    pub(super) lap: Option<LapRole>,
    /// Its text starts with no mark of optional skip and is for the interpreter, whether plain words are or not.
    pub(super) executes: bool,
    /// It leaves no text and needs none: a jump, a loop or values for variables.
    pub(super) alone: bool,
}

/// The text before a statement.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum BlockPrefix {
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
pub(super) enum OkumaStatement {
    /// Changes neither path nor time.
    Drawing,
    /// Nothing more.
    #[default]
    Nothing,
    /// It continues with a line above it that does not exist.
    Continued,
    /// Go to a block, if something is true.
    Goto(Option<Expr>, OkumaJumpTarget),
    /// `WHILE [condition] DO n`, or `DO n`, which is left by a jump.
    Loop(Option<Expr>, u8),
    /// `END n`
    EndLoop(u8),
    Call(OkumaCall),
    ModIn(OkumaCall),
    ModOut,
    /// A statement that other controls have too, with its operands.
    Shared(&'static SharedStatement, Box<[Expr]>),
    /// Words and assignments.
    Items(Vec<OkumaItem>),
}

/// A block to go to.
#[derive(Debug, PartialEq)]
pub(super) enum OkumaJumpTarget {
    /// By its sequence number or name, without N.
    Named(String),
    /// By a number that is computed.
    Computed(Expr),
}

/// A call of a subprogram.
#[derive(Debug, PartialEq)]
pub(super) struct OkumaCall {
    /// Its name, with O.
    pub(super) name: String,
    /// How often it is repeated.
    pub(super) repeats: Option<Expr>,
    pub(super) arguments: Vec<(LocalVariableName, Expr)>,
}

/// A part of a block.
#[derive(Debug, PartialEq)]
pub(super) enum OkumaItem {
    /// Text for the machine's tables.
    Plain(Span),
    /// An offset of the tool in the spindle: `HA`, `DB`.
    OfTool(String, Span),
    /// A value for a word or a variable.
    Set {
        /// Name of the word or variable, in capitals.
        name: String,
        /// The variable that it could be; none for the letter of a word with its value in brackets.
        variable: Option<OkumaVariable>,
        value: Expr,
        /// Place of the value, if it is only a number.
        number: Option<Span>,
        span: Span,
    },
    /// A text for a variable of the control: `VUACM[1]='NO PART'`.
    Text { variable: OkumaVariable, text: String, span: Span },
}

/// The parts that are removed from blocks.
#[derive(Debug, Clone, Copy)]
pub(super) struct LineReadOptions {
    /// CALL, MODIN and MODOUT.
    pub(super) subprograms: bool,
    /// Statements for the screen and the tool management.
    pub(super) drawing: bool,
    /// HA to DC alone are offsets of the tool in the spindle.
    pub(super) offsets: bool,
}

/// Reads a block.
pub(super) fn read(prepared: PreparedText, wanted: LineReadOptions) -> Result<OkumaLine, OkumaSyntaxError> {
    let PreparedText { plain, upper, messages, open } = prepared;
    let mut reading = OkumaLineReader { plain: &plain, cursor: OkumaCursor::new(&upper), offsets: wanted.offsets };
    if let Some(header) = reading.of_the_file() {
        return Ok(OkumaLine { statement: header, plain: plain.into(), messages, open, ..OkumaLine::default() });
    }
    let head = reading.head();
    let statement = reading.statement(wanted)?;
    Ok(OkumaLine { head, statement, plain: plain.into(), messages, open, ..OkumaLine::default() })
}

/// A block that is being read.
struct OkumaLineReader<'a> {
    plain: &'a [u8],
    cursor: OkumaCursor<'a>,
    /// HA to DC alone are offsets.
    offsets: bool,
}

impl OkumaLineReader<'_> {
    /// The place from byte `start` to byte `end`, without blanks at the end.
    fn place(&self, start: usize, end: usize) -> Span {
        span(start, start + self.plain.get(start..end).unwrap_or_default().trim_ascii_end().len())
    }

    /// A line that begins with `$`: the name of the file (`$NAME.MIN%`), or the rest of the line above.
    fn of_the_file(&mut self) -> Option<OkumaStatement> {
        let is = self.cursor.peek() == Some(b'$');
        is.then(|| if is_header(self.plain) { OkumaStatement::Nothing } else { OkumaStatement::Continued })
    }

    fn head(&mut self) -> Vec<BlockPrefix> {
        let mut head = Vec::new();
        let mut has_name = false;
        loop {
            match self.cursor.peek() {
                Some(b'/') => {
                    self.cursor.at += 1;
                    let level = self.cursor.here().filter(|byte| (b'1'..=b'9').contains(byte));
                    self.cursor.at += usize::from(level.is_some());
                    head.push(BlockPrefix::Mark(level.map(|digit| digit - b'0')));
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
    fn named(&mut self, letter: u8) -> Option<BlockPrefix> {
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
            true => BlockPrefix::Program(place),
            false if digits > 0 => BlockPrefix::Number(place),
            false => BlockPrefix::Name(place),
        })
    }

    fn statement(&mut self, wanted: LineReadOptions) -> Result<OkumaStatement, OkumaSyntaxError> {
        let cursor = &mut self.cursor;
        if cursor.peek().is_none() {
            return Ok(OkumaStatement::Nothing);
        }
        if cursor.word("MSG") || cursor.word("NMSG") {
            cursor.end()?;
            return Ok(OkumaStatement::Nothing);
        }
        if let Some((_, shared)) = STATEMENTS.iter().find(|(word, _)| cursor.word(word)) {
            return Ok(OkumaStatement::Shared(shared, operands(cursor, shared.operands)?));
        }
        if cursor.word("NOEX") {
            return self.items();
        }
        if wanted.drawing && super::drawing::is_drawing(cursor) {
            return Ok(OkumaStatement::Drawing);
        }
        if cursor.key_word("GOTO") {
            let target = self.target()?;
            return Ok(OkumaStatement::Goto(None, target));
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
                return Ok(OkumaStatement::ModOut);
            }
            if cursor.key_word("MODIN") {
                return self.call().map(OkumaStatement::ModIn);
            }
            if cursor.key_word("CALL") {
                return self.call().map(OkumaStatement::Call);
            }
        } else if ["MODOUT", "MODIN", "CALL"].into_iter().any(|word| cursor.key_word(word)) {
            cursor.at = start;
            let (start, end) = cursor.rest();
            return Ok(OkumaStatement::Items(vec![OkumaItem::Plain(span(start, end))]));
        }
        self.items()
    }

    /// A statement of a loop, if one follows. DO and END alone with a number are not names of variables.
    fn loops(&mut self) -> Result<Option<OkumaStatement>, OkumaSyntaxError> {
        let cursor = &mut self.cursor;
        let start = cursor.at;
        if cursor.key_word("WHILE") {
            if cursor.peek() == Some(b'[') {
                cursor.at += 1;
                let condition = OkumaExpressionReader::new(cursor).expression()?;
                cursor.expect(b']', "']'")?;
                if !cursor.key_word("DO") {
                    return Err(OkumaSyntaxError::Expected("DO after the condition", cursor.at + 1));
                }
                let Some(number) = loop_number(cursor) else {
                    return Err(OkumaSyntaxError::Expected("the number of the loop", cursor.at + 1));
                };
                return Ok(Some(OkumaStatement::Loop(Some(condition), number)));
            }
        } else if cursor.key_word("DO") {
            if let Some(number) = loop_number(cursor) {
                return Ok(Some(OkumaStatement::Loop(None, number)));
            }
        } else if cursor.key_word("END")
            && let Some(number) = loop_number(cursor)
        {
            return Ok(Some(OkumaStatement::EndLoop(number)));
        }
        cursor.at = start;
        Ok(None)
    }

    fn condition(&mut self) -> Result<OkumaStatement, OkumaSyntaxError> {
        let cursor = &mut self.cursor;
        let condition = if cursor.peek() == Some(b'[') {
            cursor.at += 1;
            let condition = OkumaExpressionReader::new(cursor).expression()?;
            cursor.expect(b']', "']'")?;
            condition
        } else {
            let name = name_text(cursor);
            Expr::own(OkumaOp::Variable(OkumaExpressionReader::new(cursor).variable(name)?))
        };
        cursor.key_word("GOTO");
        let target = self.target()?;
        Ok(OkumaStatement::Goto(Some(condition), target))
    }

    fn target(&mut self) -> Result<OkumaJumpTarget, OkumaSyntaxError> {
        let cursor = &mut self.cursor;
        cursor.expect(b'N', "a sequence name")?;
        let target = if cursor.here() == Some(b'[') {
            cursor.at += 1;
            let number = OkumaExpressionReader::new(cursor).expression()?;
            cursor.expect(b']', "']'")?;
            OkumaJumpTarget::Computed(number)
        } else {
            let name = cursor.run(|byte| byte.is_ascii_digit() || byte.is_ascii_uppercase());
            if name.is_empty() {
                return Err(OkumaSyntaxError::Expected("a sequence name", cursor.at + 1));
            }
            OkumaJumpTarget::Named(normal(name))
        };
        cursor.end()?;
        Ok(target)
    }

    fn call(&mut self) -> Result<OkumaCall, OkumaSyntaxError> {
        let cursor = &mut self.cursor;
        cursor.expect(b'O', "the name of a program")?;
        let start = cursor.at - 1;
        if cursor.run(|byte| byte.is_ascii_digit() || byte.is_ascii_uppercase()).is_empty() {
            return Err(OkumaSyntaxError::Expected("the name of a program", cursor.at + 1));
        }
        let name = cursor.between(start).to_owned();
        let (mut repeats, mut arguments) = (None, Vec::new());
        loop {
            while cursor.take(b',') {}
            if cursor.peek().is_none() {
                return Ok(OkumaCall { name, repeats, arguments });
            }
            let start = cursor.at;
            cursor.run(|byte| byte.is_ascii_uppercase());
            if cursor.between(start) == "Q" && repeats.is_none() {
                let digits = !cursor.take(b'=') && matches!(cursor.peek(), Some(b'0'..=b'9'));
                repeats = Some(match digits {
                    true => Expr::constant(number_text(cursor).parse().unwrap_or(f64::MAX)),
                    false => OkumaExpressionReader::new(cursor).expression()?,
                });
                continue;
            }
            cursor.run(|byte| byte.is_ascii_digit());
            let Some(local) = names::local(cursor.between(start)) else {
                return Err(OkumaSyntaxError::Expected("a local variable", start + 1));
            };
            cursor.expect(b'=', "'='")?;
            arguments.push((local, OkumaExpressionReader::new(cursor).expression()?));
        }
    }

    /// Words and assignments.
    fn items(&mut self) -> Result<OkumaStatement, OkumaSyntaxError> {
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
        Ok(OkumaStatement::Items(items))
    }

    fn flush(&self, plain: &mut Option<usize>, end: usize, items: &mut Vec<OkumaItem>) {
        if let Some(start) = plain.take() {
            items.push(OkumaItem::Plain(self.place(start, end)));
        }
    }

    /// The next item, or none after passing over a word of plain text.
    fn item(&mut self, start: usize) -> Result<Option<OkumaItem>, OkumaSyntaxError> {
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
            let variable = OkumaExpressionReader::new(&mut self.cursor).variable(name)?;
            if self.cursor.take(b'=') {
                if self.cursor.peek() == Some(b'\'') {
                    return self.text(start, variable).map(Some);
                }
                return self.set(start, name, Some(variable)).map(Some);
            }
            return Err(OkumaSyntaxError::Expected("'='", self.cursor.at + 1));
        }
        if self.offsets && names::is_offset(name) {
            return Ok(Some(OkumaItem::OfTool(name.to_owned(), span(start, self.cursor.at))));
        }
        // The rest of a number, as in.
        self.cursor.run(|byte| !byte.is_ascii_uppercase() && !matches!(byte, b' ' | b',' | b'=' | b'['));
        Ok(None)
    }

    /// A text between apostrophes.
    fn text(&mut self, start: usize, variable: OkumaVariable) -> Result<OkumaItem, OkumaSyntaxError> {
        self.cursor.at += 1;
        let from = self.cursor.at;
        self.cursor.run(|byte| byte != b'\'');
        let text = part(self.plain, span(from, self.cursor.at)).into_owned();
        self.cursor.expect(b'\'', "an apostrophe")?;
        Ok(OkumaItem::Text { variable, text, span: span(start, self.cursor.at) })
    }

    fn set(
        &mut self,
        start: usize,
        name: &str,
        variable: Option<OkumaVariable>,
    ) -> Result<OkumaItem, OkumaSyntaxError> {
        self.cursor.peek();
        let from = self.cursor.at;
        let value = OkumaExpressionReader::new(&mut self.cursor).expression()?;
        let (place, written) = (self.place(start, self.cursor.at), self.place(from, self.cursor.at));
        let is_digit = |byte: u8| byte.is_ascii_digit() || matches!(byte, b'.' | b'-' | b'+');
        let is_number = value.as_constant().is_some() && part(self.plain, written).bytes().all(is_digit);
        let number = is_number.then_some(written);
        Ok(OkumaItem::Set { name: name.to_owned(), variable, value, number, span: place })
    }
}

/// This many operands in brackets, with commas between them, and the end of the block.
fn operands(cursor: &mut OkumaCursor<'_>, count: usize) -> Result<Box<[Expr]>, OkumaSyntaxError> {
    let operands = if count > 0 { OkumaExpressionReader::new(cursor).list()? } else { Box::default() };
    if operands.len() != count {
        return Err(OkumaSyntaxError::Operands(count, cursor.at + 1));
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
fn loop_number(cursor: &mut OkumaCursor<'_>) -> Option<u8> {
    cursor.peek();
    let number = cursor.run(|byte| byte.is_ascii_digit()).parse().ok()?;
    cursor.peek().is_none().then_some(number)
}

#[cfg(test)]
mod tests;
