//! A block, read once.
//!
//! Facts: reference channel-synchronisation.md 1.7. Decisions: `G04` may have its time without an address; a text that
//! is neither word nor statement stays in the block for the tables of the machine. Invariant: items are in the order of
//! the text.

use super::cursor::{IsgCursor, IsgSyntaxError, plain};
use super::expr::{Expr, IsgExpressionReader, IsgVariable, is_function, is_value, is_variable};
use super::message;
use super::signals::{self, SignalStatement};
use counterpoint_control_api::words::{Span, span};

/// A block.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct IsgLine {
    /// Marks of optional skip before the block.
    pub(super) skips: Vec<Option<u8>>,
    /// Place of the block number with its letter.
    pub(super) number: Option<Span>,
    pub(super) items: Vec<IsgItem>,
    /// The block in capitals, without comments.
    pub(super) plain: Box<[u8]>,
}

/// Part of a block.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum IsgItem {
    /// An address with its value.
    Word(IsgWord),
    /// The time of a dwell without an address.
    Time(Expr, Span),
    /// `#TIME`.
    Dwell(Expr, Span),
    Set(IsgVariable, Expr),
    /// A variable alone, between `#VAR` and `#ENDVAR`.
    Declare(IsgVariable),
    Control(ControlStatement),
    Signal(Box<SignalStatement>),
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

impl IsgItem {
    /// Whether the item leaves words in the block.
    pub(super) fn remains(&self) -> bool {
        matches!(self, Self::Word(_) | Self::Time(..) | Self::Dwell(..) | Self::Text(_))
    }
}

/// An address with its value.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct IsgWord {
    pub(super) letter: u8,
    pub(super) value: Expr,
    /// Place of the value if the program has a number there.
    pub(super) number: Option<Span>,
    pub(super) span: Span,
}

impl IsgWord {
    /// Whether the number follows its letter, as in words of any control.
    pub(super) fn is_plain(&self) -> bool {
        self.number.is_some_and(|(start, _)| start == self.span.0 + 1)
    }
}

/// A control block.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum ControlStatement {
    If(Expr, Option<IsgJumpTarget>),
    ElseIf(Expr),
    Else,
    While(Expr),
    /// Variable, first value, last value, step.
    For(IsgVariable, Expr, Expr, Expr),
    Until(Expr),
    Switch(Expr),
    Case(Expr),
    Goto(IsgJumpTarget),
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
pub(super) enum IsgJumpTarget {
    Number(Expr),
    Name(String),
}

/// Head of a block: skips, number, label.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct BlockHead {
    pub(super) skips: Vec<Option<u8>>,
    pub(super) number: Option<Span>,
    pub(super) label: Option<String>,
}

/// Reads the head of a block.
pub(super) fn head(cursor: &mut IsgCursor<'_>) -> BlockHead {
    let mut head = BlockHead::default();
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
pub(super) fn read(text: &[u8]) -> Result<IsgLine, IsgSyntaxError> {
    let upper = plain(text);
    let mut cursor = IsgCursor::new(&upper);
    let head = head(&mut cursor);
    let (mut items, mut dwells) = (Vec::new(), false);
    while cursor.peek().is_some() {
        let item = item(&mut cursor, text, dwells)?;
        if let IsgItem::Word(IsgWord { letter: b'G', value, .. }) = &item {
            dwells |= value.as_constant() == Some(&4.0);
        }
        items.push(item);
    }
    Ok(IsgLine { skips: head.skips, number: head.number, items, plain: upper.into() })
}

fn item(cursor: &mut IsgCursor<'_>, text: &[u8], dwells: bool) -> Result<IsgItem, IsgSyntaxError> {
    let start = cursor.at;
    match cursor.here() {
        Some(b'$') => {
            cursor.at += 1;
            control(cursor).map(IsgItem::Control)
        }
        Some(b'#') => hash(cursor, text),
        _ if is_variable(cursor) => {
            let variable = IsgExpressionReader::new(cursor).variable()?;
            if cursor.peek() == Some(b'=') {
                cursor.at += 1;
                return Ok(IsgItem::Set(variable, IsgExpressionReader::new(cursor).expression()?));
            }
            if dwells {
                cursor.at = start;
                return time(cursor);
            }
            Ok(IsgItem::Declare(variable))
        }
        Some(b'L') if call_name(cursor).is_some() => {
            let (local, name, end) = call_name(cursor).unwrap_or_default();
            cursor.at = end;
            Ok(IsgItem::Call { local, name })
        }
        Some(letter @ b'A'..=b'Z') => Ok(word(cursor, letter)?.unwrap_or_else(|| rest_of_text(cursor, start))),
        Some(b'0'..=b'9' | b'.') if dwells => time(cursor),
        _ => Ok(rest_of_text(cursor, start)),
    }
}

/// The time of a dwell.
fn time(cursor: &mut IsgCursor<'_>) -> Result<IsgItem, IsgSyntaxError> {
    let start = cursor.at;
    let time = IsgExpressionReader::new(cursor).sum()?;
    Ok(IsgItem::Time(time, span(start, cursor.trimmed(start))))
}

/// An address with its value.
fn word(cursor: &mut IsgCursor<'_>, letter: u8) -> Result<Option<IsgItem>, IsgSyntaxError> {
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
    let value = IsgExpressionReader::new(&mut ahead).sum()?;
    let (end, spelled) = (ahead.trimmed(start), ahead.between(start).trim());
    // A number in brackets is an expression.
    let is_number = value.as_constant().is_some() && spelled.parse::<f64>().is_ok();
    cursor.at = ahead.at;
    if letter == b'M' && matches!(value.as_constant(), Some(17.0 | 29.0)) {
        return Ok(Some(IsgItem::Return));
    }
    let number = is_number.then(|| span(start, end));
    Ok(Some(IsgItem::Word(IsgWord { letter, value, number, span: span(first, end) })))
}

/// Text up to a blank outside of brackets.
fn rest_of_text(cursor: &mut IsgCursor<'_>, start: usize) -> IsgItem {
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
    IsgItem::Text(span(start, cursor.at))
}

/// `L NAME` or `LL NAME`: whether it is local, the name, where it ends.
fn call_name(cursor: &IsgCursor<'_>) -> Option<(bool, String, usize)> {
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

fn target(cursor: &mut IsgCursor<'_>) -> Result<IsgJumpTarget, IsgSyntaxError> {
    if cursor.take(b'[') {
        let name = cursor.run(|byte| byte != b']').trim().to_owned();
        cursor.expect(b']', "']'")?;
        return Ok(IsgJumpTarget::Name(name));
    }
    cursor.expect(b'N', "N with a number, or a label in brackets")?;
    Ok(IsgJumpTarget::Number(IsgExpressionReader::new(cursor).sum()?))
}

fn control(cursor: &mut IsgCursor<'_>) -> Result<ControlStatement, IsgSyntaxError> {
    let start = cursor.at;
    let word = cursor.run(|byte| byte.is_ascii_alphabetic());
    let control = match word {
        "IF" => {
            let condition = IsgExpressionReader::new(cursor).expression()?;
            let jumps = cursor.key("$GOTO");
            ControlStatement::If(condition, if jumps { Some(target(cursor)?) } else { None })
        }
        "ELSEIF" => ControlStatement::ElseIf(IsgExpressionReader::new(cursor).expression()?),
        "ELSE" => ControlStatement::Else,
        "WHILE" => ControlStatement::While(IsgExpressionReader::new(cursor).expression()?),
        "UNTIL" => ControlStatement::Until(IsgExpressionReader::new(cursor).expression()?),
        "SWITCH" => ControlStatement::Switch(IsgExpressionReader::new(cursor).expression()?),
        "CASE" => {
            let value = IsgExpressionReader::new(cursor).expression()?;
            cursor.take(b':');
            ControlStatement::Case(value)
        }
        "DEFAULT" => {
            cursor.take(b':');
            ControlStatement::Mark
        }
        "FOR" => {
            cursor.peek();
            let variable = IsgExpressionReader::new(cursor).variable()?;
            cursor.expect(b'=', "'='")?;
            let mut value = |comma: bool| {
                if comma {
                    cursor.expect(b',', "','")?;
                }
                IsgExpressionReader::new(cursor).expression()
            };
            ControlStatement::For(variable, value(false)?, value(true)?, value(true)?)
        }
        "GOTO" => ControlStatement::Goto(target(cursor)?),
        "BREAK" => ControlStatement::Break,
        "CONTINUE" => ControlStatement::Continue,
        "ENDWHILE" => ControlStatement::EndWhile,
        "ENDFOR" => ControlStatement::EndFor,
        "ENDDO" if cursor.peek().is_some() => {
            ControlStatement::EndDo(Some(IsgExpressionReader::new(cursor).expression()?))
        }
        "ENDDO" => ControlStatement::EndDo(None),
        "ENDIF" | "DO" | "REPEAT" | "ENDSWITCH" => ControlStatement::Mark,
        _ => return Err(IsgSyntaxError::syntax(format!("${word} at column {start} is no statement"))),
    };
    cursor.end()?;
    Ok(control)
}

/// Statements with `#`.
fn hash(cursor: &mut IsgCursor<'_>, text: &[u8]) -> Result<IsgItem, IsgSyntaxError> {
    let start = cursor.at;
    cursor.at += 1;
    let word = cursor.run(|byte| byte.is_ascii_alphabetic());
    let item = match word {
        "SIGNAL" | "WAIT" if signals::is_one(word, cursor) => IsgItem::Signal(Box::new(signals::read(word, cursor)?)),
        "TIME" => {
            let time = IsgExpressionReader::new(cursor).sum()?;
            IsgItem::Dwell(time, span(start, cursor.trimmed(start)))
        }
        "VAR" | "ENDVAR" => IsgItem::Idle,
        "FLUSH" => {
            let _ = cursor.word("WAIT") || cursor.word("CONTINUE");
            IsgItem::Idle
        }
        "MSG" => {
            let (text, values) = message::read(cursor, text)?;
            IsgItem::Message(text, values)
        }
        _ => {
            cursor.at = start;
            cursor.run(|_| true);
            IsgItem::Text(span(start, cursor.at))
        }
    };
    cursor.end()?;
    Ok(item)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn items(text: &str) -> Vec<IsgItem> {
        read(text.as_bytes()).unwrap().items
    }

    fn spelled(text: &str) -> Vec<(char, Option<&str>)> {
        let number = |(start, end): Span| text.get(start as usize..end as usize).unwrap();
        let word = |item: IsgItem| match item {
            IsgItem::Word(word) => (char::from(word.letter), word.number.map(number)),
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
        assert!(matches!(items("G04 2.5")[..], [IsgItem::Word(_), IsgItem::Time(..)]));
        assert!(matches!(items("G04 P1")[..], [IsgItem::Word(_), IsgItem::Time(..)]));
        assert!(matches!(items("M17")[..], [IsgItem::Return]));
    }

    #[test]
    fn words_have_their_places() {
        let text = "N5 G1 x=P1 + 2 (a) Y 4 FOO[1] ; b";
        let place = |item: &IsgItem| match item {
            IsgItem::Word(word) => (word.span, word.is_plain()),
            IsgItem::Text(span) => (*span, false),
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
        assert_eq!(head(&mut IsgCursor::new(b"[AGAIN]")).label.as_deref(), Some("AGAIN"));
    }

    #[test]
    fn statements() {
        assert!(matches!(
            items("$IF P1 > 3 $GOTO N50")[..],
            [IsgItem::Control(ControlStatement::If(_, Some(IsgJumpTarget::Number(_))))]
        ));
        assert!(matches!(items("$FOR P1 = 1, 10, 2")[..], [IsgItem::Control(ControlStatement::For(..))]));
        assert!(matches!(items("$GOTO [END]")[..], [IsgItem::Control(ControlStatement::Goto(IsgJumpTarget::Name(_)))]));
        assert!(matches!(items("V.P.COUNT = 3")[..], [IsgItem::Set(..)]));
        assert!(matches!(items("#TIME 2.5")[..], [IsgItem::Dwell(..)]));
        assert_eq!(items("LL UP1"), [IsgItem::Call { local: true, name: "UP1".to_owned() }]);
        assert_eq!(items("L sub.nc"), [IsgItem::Call { local: false, name: "SUB.NC".to_owned() }]);
        assert_eq!(items("#MSG [\"Part (done)\"]"), [IsgItem::Message("Part (done)".to_owned(), Vec::new())]);
        assert_eq!(items("#HSC ON [A 1]"), [IsgItem::Text((0, 13))]);
        assert!(read(b"$WHILE P1 < 3 X5").is_err() && read(b"$FOO").is_err());
    }
}
