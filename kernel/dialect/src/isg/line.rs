//! A block, read once.
//!
//! Facts: reference channel-synchronisation.md 1.7. Decisions: `G04` may have its time without an address; a text that
//! is neither word nor statement stays in the block for the tables of the machine. Invariant: items are in the order of
//! the text.

use super::cursor::{Cursor, Mistake, plain};
use super::expr::{Expr, Reader, Variable, is_function, is_value, is_variable};
use super::message;
use super::signals::{self, Statement};
use crate::words::{Span, span};

/// A block.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Line {
    /// Marks of optional skip before the block.
    pub(super) skips: Vec<Option<u8>>,
    /// Place of the block number with its letter.
    pub(super) number: Option<Span>,
    pub(super) items: Vec<Item>,
    /// The block in capitals, without comments.
    pub(super) plain: Box<[u8]>,
}

/// Part of a block.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Item {
    /// An address with its value.
    Word(Word),
    /// The time of a dwell without an address.
    Time(Expr, Span),
    /// `#TIME`.
    Dwell(Expr, Span),
    Set(Variable, Expr),
    /// A variable alone, between `#VAR` and `#ENDVAR`.
    Declare(Variable),
    Control(Control),
    Signal(Box<Statement>),
    /// `#MSG` with the values that its text shows.
    Message(String, Vec<Expr>),
    /// `LL NAME`, which is in the same file, or `L NAME`, a file.
    Call {
        local: bool,
        name: String,
    },
    /// M17 or M29.
    Return,
    /// Understood, and without effect here.
    Idle,
    /// For the tables of the machine.
    Text(Span),
}

impl Item {
    /// Whether the item leaves words in the block.
    pub(super) fn remains(&self) -> bool {
        matches!(self, Self::Word(_) | Self::Time(..) | Self::Dwell(..) | Self::Text(_))
    }
}

/// An address with its value.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Word {
    pub(super) letter: u8,
    pub(super) value: Expr,
    /// Place of the value if the program has a number there.
    pub(super) number: Option<Span>,
    pub(super) span: Span,
}

impl Word {
    /// Whether the number follows its letter, as in words of any control.
    pub(super) fn is_plain(&self) -> bool {
        self.number.is_some_and(|(start, _)| start == self.span.0 + 1)
    }
}

/// A control block.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Control {
    If(Expr, Option<Target>),
    ElseIf(Expr),
    Else,
    While(Expr),
    /// Variable, first value, last value, step.
    For(Variable, Expr, Expr, Expr),
    Until(Expr),
    Switch(Expr),
    Case(Expr),
    Goto(Target),
    Break,
    Continue,
    EndWhile,
    EndFor,
    /// With a condition the loop repeats while the condition is true.
    EndDo(Option<Expr>),
    /// Nothing happens at it: ENDIF, DO, REPEAT, DEFAULT, ENDSWITCH.
    Mark,
}

/// Where a jump leads.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Target {
    Number(Expr),
    Name(String),
}

/// Head of a block: skips, number, label.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Head {
    pub(super) skips: Vec<Option<u8>>,
    pub(super) number: Option<Span>,
    pub(super) label: Option<String>,
}

/// Reads the head of a block.
pub(super) fn head(cursor: &mut Cursor<'_>) -> Head {
    let mut head = Head::default();
    while cursor.take(b'/') {
        let level = cursor.run(|byte| byte.is_ascii_digit());
        head.skips.push(level.parse().ok());
    }
    if cursor.peek() == Some(b'N') && cursor.ahead(1).is_some_and(|byte| byte.is_ascii_digit()) {
        let start = cursor.at;
        cursor.at += 1;
        cursor.run(|byte| byte.is_ascii_digit());
        head.number = Some(span(start, cursor.at));
        if cursor.here() == Some(b':') {
            cursor.at += 1;
        }
    }
    if cursor.peek() == Some(b'[') {
        let mut ahead = cursor.clone();
        ahead.at += 1;
        let name = ahead.run(|byte| byte != b']').trim();
        if ahead.take(b']') && !name.is_empty() {
            head.label = Some(name.to_owned());
            cursor.at = ahead.at;
        }
    }
    head
}

/// Reads a block.
pub(super) fn read(text: &[u8]) -> Result<Line, Mistake> {
    let upper = plain(text);
    let mut cursor = Cursor::new(&upper);
    let head = head(&mut cursor);
    let (mut items, mut dwells) = (Vec::new(), false);
    while cursor.peek().is_some() {
        let item = item(&mut cursor, text, dwells)?;
        if let Item::Word(Word { letter: b'G', value, .. }) = &item {
            dwells |= value.as_constant() == Some(&4.0);
        }
        items.push(item);
    }
    Ok(Line { skips: head.skips, number: head.number, items, plain: upper.into() })
}

fn item(cursor: &mut Cursor<'_>, text: &[u8], dwells: bool) -> Result<Item, Mistake> {
    let start = cursor.at;
    match cursor.here() {
        Some(b'$') => {
            cursor.at += 1;
            control(cursor).map(Item::Control)
        }
        Some(b'#') => hash(cursor, text),
        _ if is_variable(cursor) => {
            let variable = Reader::new(cursor).variable()?;
            if cursor.peek() == Some(b'=') {
                cursor.at += 1;
                return Ok(Item::Set(variable, Reader::new(cursor).expression()?));
            }
            if dwells {
                cursor.at = start;
                return time(cursor);
            }
            Ok(Item::Declare(variable))
        }
        Some(b'L') if call_name(cursor).is_some() => {
            let (local, name, end) = call_name(cursor).unwrap_or_default();
            cursor.at = end;
            Ok(Item::Call { local, name })
        }
        Some(letter @ b'A'..=b'Z') => Ok(word(cursor, letter)?.unwrap_or_else(|| rest_of_text(cursor, start))),
        Some(b'0'..=b'9' | b'.') if dwells => time(cursor),
        _ => Ok(rest_of_text(cursor, start)),
    }
}

/// The time of a dwell.
fn time(cursor: &mut Cursor<'_>) -> Result<Item, Mistake> {
    let start = cursor.at;
    let time = Reader::new(cursor).sum()?;
    Ok(Item::Time(time, span(start, cursor.trimmed(start))))
}

/// An address with its value.
fn word(cursor: &mut Cursor<'_>, letter: u8) -> Result<Option<Item>, Mistake> {
    let mut ahead = cursor.clone();
    ahead.at += 1;
    let close = ahead.here();
    if close != Some(b'=') && !is_value(&ahead) {
        // A number may be apart from its address.
        let blank = matches!(close, Some(b' ' | b'\t'));
        if !blank || !matches!(ahead.peek(), Some(b'0'..=b'9' | b'.' | b'-' | b'=')) && !is_function(&ahead) {
            return Ok(None);
        }
    }
    ahead.take(b'=');
    ahead.peek();
    let (first, start) = (cursor.at, ahead.at);
    let value = Reader::new(&mut ahead).sum()?;
    let (end, spelled) = (ahead.trimmed(start), ahead.between(start).trim());
    // A number in brackets is an expression.
    let is_number = value.as_constant().is_some() && spelled.parse::<f64>().is_ok();
    cursor.at = ahead.at;
    if letter == b'M' && matches!(value.as_constant(), Some(17.0 | 29.0)) {
        return Ok(Some(Item::Return));
    }
    let number = is_number.then(|| span(start, end));
    Ok(Some(Item::Word(Word { letter, value, number, span: span(first, end) })))
}

/// Text up to a blank outside of brackets.
fn rest_of_text(cursor: &mut Cursor<'_>, start: usize) -> Item {
    let mut depth = 0_usize;
    cursor.at = start;
    while let Some(byte) = cursor.here() {
        match byte {
            b'[' => depth += 1,
            b']' => depth = depth.saturating_sub(1),
            b' ' | b'\t' if depth == 0 => break,
            _ => {}
        }
        cursor.at += 1;
    }
    Item::Text(span(start, cursor.at))
}

/// `L NAME` or `LL NAME`: whether it is local, the name, where it ends.
fn call_name(cursor: &Cursor<'_>) -> Option<(bool, String, usize)> {
    let mut ahead = cursor.clone();
    ahead.at += 1;
    let local = ahead.here() == Some(b'L');
    ahead.at += usize::from(local);
    if !matches!(ahead.here(), Some(b' ' | b'\t')) {
        return None;
    }
    ahead.peek();
    let name = ahead.run(|byte| !b" \t\r()[];,#$\"".contains(&byte)).to_owned();
    // `L 5` is a word.
    name.starts_with(|c: char| !c.is_ascii_digit() && c != '-' && c != '=').then_some((local, name, ahead.at))
}

fn target(cursor: &mut Cursor<'_>) -> Result<Target, Mistake> {
    if cursor.take(b'[') {
        let name = cursor.run(|byte| byte != b']').trim().to_owned();
        cursor.expect(b']', "']'")?;
        return Ok(Target::Name(name));
    }
    cursor.expect(b'N', "N with a number, or a label in brackets")?;
    Ok(Target::Number(Reader::new(cursor).sum()?))
}

fn control(cursor: &mut Cursor<'_>) -> Result<Control, Mistake> {
    let start = cursor.at;
    let word = cursor.run(|byte| byte.is_ascii_alphabetic());
    let control = match word {
        "IF" => {
            let condition = Reader::new(cursor).expression()?;
            let jumps = cursor.key("$GOTO");
            Control::If(condition, if jumps { Some(target(cursor)?) } else { None })
        }
        "ELSEIF" => Control::ElseIf(Reader::new(cursor).expression()?),
        "ELSE" => Control::Else,
        "WHILE" => Control::While(Reader::new(cursor).expression()?),
        "UNTIL" => Control::Until(Reader::new(cursor).expression()?),
        "SWITCH" => Control::Switch(Reader::new(cursor).expression()?),
        "CASE" => {
            let value = Reader::new(cursor).expression()?;
            cursor.take(b':');
            Control::Case(value)
        }
        "DEFAULT" => {
            cursor.take(b':');
            Control::Mark
        }
        "FOR" => {
            cursor.peek();
            let variable = Reader::new(cursor).variable()?;
            cursor.expect(b'=', "'='")?;
            let mut value = |comma: bool| {
                if comma {
                    cursor.expect(b',', "','")?;
                }
                Reader::new(cursor).expression()
            };
            Control::For(variable, value(false)?, value(true)?, value(true)?)
        }
        "GOTO" => Control::Goto(target(cursor)?),
        "BREAK" => Control::Break,
        "CONTINUE" => Control::Continue,
        "ENDWHILE" => Control::EndWhile,
        "ENDFOR" => Control::EndFor,
        "ENDDO" if cursor.peek().is_some() => Control::EndDo(Some(Reader::new(cursor).expression()?)),
        "ENDDO" => Control::EndDo(None),
        "ENDIF" | "DO" | "REPEAT" | "ENDSWITCH" => Control::Mark,
        _ => return Err(Mistake::syntax(format!("${word} at column {start} is no statement"))),
    };
    cursor.end()?;
    Ok(control)
}

/// Statements with `#`.
fn hash(cursor: &mut Cursor<'_>, text: &[u8]) -> Result<Item, Mistake> {
    let start = cursor.at;
    cursor.at += 1;
    let word = cursor.run(|byte| byte.is_ascii_alphabetic());
    let item = match word {
        "SIGNAL" | "WAIT" if signals::is_one(word, cursor) => Item::Signal(Box::new(signals::read(word, cursor)?)),
        "TIME" => {
            let time = Reader::new(cursor).sum()?;
            Item::Dwell(time, span(start, cursor.trimmed(start)))
        }
        "VAR" | "ENDVAR" => Item::Idle,
        "FLUSH" => {
            let _ = cursor.word("WAIT") || cursor.word("CONTINUE");
            Item::Idle
        }
        "MSG" => {
            let (text, values) = message::read(cursor, text)?;
            Item::Message(text, values)
        }
        _ => {
            cursor.at = start;
            cursor.run(|_| true);
            Item::Text(span(start, cursor.at))
        }
    };
    cursor.end()?;
    Ok(item)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn items(text: &str) -> Vec<Item> {
        read(text.as_bytes()).unwrap().items
    }

    fn spelled(text: &str) -> Vec<(char, Option<&str>)> {
        let number = |(start, end): Span| text.get(start as usize..end as usize).unwrap();
        let word = |item: Item| match item {
            Item::Word(word) => (char::from(word.letter), word.number.map(number)),
            other => panic!("{other:?}"),
        };
        items(text).into_iter().map(word).collect()
    }

    #[test]
    fn words_with_values() {
        let line = "N10 G01 X10.5 Y-3 Z[P1+2] F=V.E.FEED";
        let expected = [('G', Some("01")), ('X', Some("10.5")), ('Y', Some("-3")), ('Z', None), ('F', None)];
        assert_eq!(spelled(line), expected);
        assert_eq!(spelled("X[8.1] Y-[1] Z-.5"), [('X', None), ('Y', None), ('Z', Some("-.5"))]);
        assert_eq!(spelled("XP1 YSIN[30] Z 4"), [('X', None), ('Y', None), ('Z', Some("4"))]);
        assert!(matches!(items("G04 2.5")[..], [Item::Word(_), Item::Time(..)]));
        assert!(matches!(items("G04 P1")[..], [Item::Word(_), Item::Time(..)]));
        assert!(matches!(items("M17")[..], [Item::Return]));
    }

    #[test]
    fn words_have_their_places() {
        let text = "N5 G1 x=P1 + 2 (a) Y 4 FOO[1] ; b";
        let place = |item: &Item| match item {
            Item::Word(word) => (word.span, word.is_plain()),
            Item::Text(span) => (*span, false),
            other => panic!("{other:?}"),
        };
        let part = |((start, end), plain): (Span, bool)| (text.get(start as usize..end as usize).unwrap(), plain);
        let found: Vec<_> = items(text).iter().map(place).map(part).collect();
        assert_eq!(found, [("G1", true), ("x=P1 + 2", false), ("Y 4", false), ("FOO[1]", false)]);
    }

    #[test]
    fn heads() {
        let line = read(b"/2 N10: [LOOP] G0").unwrap();
        assert_eq!((line.skips, line.number, line.items.len()), (vec![Some(2)], Some((3, 6)), 1));
        assert_eq!(head(&mut Cursor::new(b"[AGAIN]")).label.as_deref(), Some("AGAIN"));
    }

    #[test]
    fn statements() {
        assert!(matches!(items("$IF P1 > 3 $GOTO N50")[..], [Item::Control(Control::If(_, Some(Target::Number(_))))]));
        assert!(matches!(items("$FOR P1 = 1, 10, 2")[..], [Item::Control(Control::For(..))]));
        assert!(matches!(items("$GOTO [END]")[..], [Item::Control(Control::Goto(Target::Name(_)))]));
        assert!(matches!(items("V.P.COUNT = 3")[..], [Item::Set(..)]));
        assert!(matches!(items("#TIME 2.5")[..], [Item::Dwell(..)]));
        assert_eq!(items("LL UP1"), [Item::Call { local: true, name: "UP1".to_owned() }]);
        assert_eq!(items("L sub.nc"), [Item::Call { local: false, name: "SUB.NC".to_owned() }]);
        assert_eq!(items("#MSG [\"Part (done)\"]"), [Item::Message("Part (done)".to_owned(), Vec::new())]);
        assert_eq!(items("#HSC ON [A 1]"), [Item::Text((0, 13))]);
        assert!(read(b"$WHILE P1 < 3 X5").is_err() && read(b"$FOO").is_err());
    }
}
