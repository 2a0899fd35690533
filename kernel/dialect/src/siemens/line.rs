//! A block, read: its number, its label, its words and statements in their order.
//!
//! Facts: reference control-emulator.md 5.4. A name starts with two letters or underscores; a single letter is an
//! address. The meaning of a name — variable, word, subprogram, literal code — is decided when the block runs.
//! Invariant: text that is not a statement is kept unchanged.

use super::actions;
use super::cursor::{Cursor, begins_name, in_name};
use super::define::{self, Declaration, Header};
use super::expression::{Argument, Expression, Name, arguments, expression, indexed, unexpected};
use super::statement::{JUMPS, call, case, direction, jump, repeat};
use super::value::Data;
use crate::statement::{IDLE, Shared, Statements};
use crate::words::{Span, span};

/// A block.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Line {
    /// Its number as written without the letter.
    pub(super) number: Option<String>,
    /// In capital letters.
    pub(super) label: Option<String>,
    pub(super) items: Vec<Item>,
    /// Places in the block of the number with its letter, then of the items; empty if the text does not come from the
    /// block.
    pub(super) places: Vec<Span>,
    /// Its text has neither a mark of optional skip nor is it the head of a program: nothing is to be asked before it
    /// acts.
    pub(super) at_once: bool,
    /// Its text is such a one, and is for the interpreter whether plain words are or not.
    pub(super) is_statement: bool,
    /// A G function of the block makes a limit or a cutting speed of S.
    pub(super) speed_is_other: bool,
}

impl Line {
    /// The line with its places moved by `offset`, for a text that ends with the line.
    pub(super) fn at(self, offset: usize) -> Self {
        let offset = offset as u32;
        let places = self.places.into_iter().map(|(start, end)| (start + offset, end + offset)).collect();
        Self { places, ..self }
    }
}

/// A word or statement.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Item {
    /// A plain word, or text that is none.
    Text(String),
    /// `NAME=…`: a variable or a word.
    Set {
        name: Name,
        value: Assigned,
    },
    /// A name alone.
    Bare(String),
    /// A name with arguments.
    Function(String, Vec<Argument>),
    /// `P…` beside a call, with the word as it is written.
    Passes(Expression, String),
    /// `L…`
    Program(String),
    /// CALL, EXTCALL with a name; PCALL with arguments.
    CallText {
        name: Expression,
        section: Option<(String, String)>,
        arguments: Vec<Argument>,
    },
    /// MCALL
    Modal,
    /// M17, RET as written; whether it wants to go elsewhere.
    Return(String, bool),
    Define(String, String),
    Declare(Declaration),
    Redeclare(Declaration),
    Header(Header),
    External(Header),
    Message(Option<Argument>),
    /// A synchronised action.
    Synchronised(std::sync::Arc<actions::Action>),
    If(Expression, Option<Jump>),
    Case(Expression, Vec<(Expression, Jump)>, Option<Jump>),
    Goto(Jump),
    For(Name, Expression, Expression),
    While(Expression),
    Until(Expression),
    RepeatPart {
        first: Label,
        last: Option<Label>,
        passes: Option<Expression>,
        one_block: bool,
    },
    /// ELSE ENDIF LOOP ENDLOOP ENDFOR ENDWHILE REPEAT
    Structure(Structure),
    /// A statement that other controls have too, with its keyword as written.
    Shared {
        statement: &'static Shared,
        text: String,
        operands: Vec<Argument>,
    },
}

/// Statements of one word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Structure {
    Else,
    EndIf,
    Loop,
    EndLoop,
    EndFor,
    EndWhile,
    Repeat,
}

/// The text after `=`.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Assigned {
    /// An expression, and how it is written.
    One(Expression, String),
    /// `SET(…)` or a list in parentheses.
    List(Vec<Argument>),
    /// `REP(value[, number])`
    Fill(Vec<Argument>),
    /// `AC(…)` and the like.
    Positioned(Positioning, Expression, String),
}

/// How a position counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Positioning {
    Absolute,
    Incremental,
    Shortest,
    Positive,
    Negative,
    /// `QU(…)`: only the value counts.
    Value,
    /// `PM(…)`: a feed per minute.
    PerMinute,
    /// `PR(…)`: a feed per revolution.
    PerRevolution,
    /// `DAC(…)`, `RAC(…)`: a position as a diameter or a radius, in any mode of the program.
    AbsoluteAs(Width),
    /// `DIC(…)`, `RIC(…)`: a distance likewise.
    IncrementalAs(Width),
}

/// Meaning of a value across the axis of turning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Width {
    Diameter,
    Radius,
}

/// Where a jump looks for its target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Direction {
    Forward,
    Back,
    Either,
    /// GOTOC: a missing target is ignored.
    Silent,
    /// GOTOS: the beginning of the program.
    Start,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Jump {
    pub(super) direction: Direction,
    pub(super) target: Label,
}

/// A label, a block number, or an expression that gives one of them.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Label {
    Number(u32),
    Name(String),
    Value(Expression),
}

/// Key words that are alone.
const STRUCTURES: [(&str, Structure); 7] = [
    ("ELSE", Structure::Else),
    ("ENDIF", Structure::EndIf),
    ("LOOP", Structure::Loop),
    ("ENDLOOP", Structure::EndLoop),
    ("ENDFOR", Structure::EndFor),
    ("ENDWHILE", Structure::EndWhile),
    ("REPEAT", Structure::Repeat),
];

const POSITIONINGS: [(&str, Positioning); 16] = [
    ("AC", Positioning::Absolute),
    ("IC", Positioning::Incremental),
    ("DC", Positioning::Shortest),
    ("ACP", Positioning::Positive),
    ("ACN", Positioning::Negative),
    ("CAC", Positioning::Absolute),
    ("CDC", Positioning::Shortest),
    ("CACP", Positioning::Positive),
    ("CACN", Positioning::Negative),
    ("QU", Positioning::Value),
    ("PM", Positioning::PerMinute),
    ("PR", Positioning::PerRevolution),
    ("DAC", Positioning::AbsoluteAs(Width::Diameter)),
    ("DIC", Positioning::IncrementalAs(Width::Diameter)),
    ("RAC", Positioning::AbsoluteAs(Width::Radius)),
    ("RIC", Positioning::IncrementalAs(Width::Radius)),
];

/// Key words of statements that other controls have too.
const STATEMENTS: Statements<&str> = &[
    ("STOPRE", &IDLE),
    ("SBLOF", &IDLE),
    ("SBLON", &IDLE),
    ("DISPLOF", &IDLE),
    ("DISPLON", &IDLE),
    ("ACTBLOCNO", &IDLE),
    ("ENDLABEL", &IDLE),
];

/// Number and label at the start of a block; the cursor stops after them.
pub(super) fn head(cursor: &mut Cursor<'_>) -> (Option<String>, Option<String>) {
    let mut number = None;
    cursor.blanks();
    let first = cursor.byte(0).to_ascii_uppercase();
    if (first == b'N' || first == b':') && cursor.byte(1).is_ascii_digit() {
        let from = cursor.at();
        cursor.step();
        let digits = cursor.digits();
        if in_name(cursor.byte(0)) && first == b'N' && cursor.byte(0) == b'_' {
            cursor.back_to(from);
        } else {
            number = Some(digits.to_owned());
        }
    }
    let from = cursor.at();
    if let Some(name) = cursor.name()
        && cursor.takes(":")
    {
        return (number, Some(name.to_ascii_uppercase()));
    }
    cursor.back_to(from);
    (number, None)
}

/// Reads a block without comment and marks of optional skip.
pub(super) fn read(text: &str) -> Result<Line, String> {
    let mut cursor = Cursor::new(text);
    cursor.blanks();
    let start = cursor.at();
    let (number, label) = head(&mut cursor);
    let end = start + 1 + number.as_ref().map_or(0, String::len);
    let mut line = Line { number, label, places: vec![span(start, end)], ..Line::default() };
    loop {
        cursor.blanks();
        if cursor.is_at_end() {
            line.speed_is_other = line.items.iter().any(super::spindles::changes_speed);
            return if line.items.len() > 1 { alone(line) } else { Ok(line) };
        }
        let start = cursor.at();
        let item = item(&mut cursor)?;
        line.items.push(item);
        line.places.push(span(start, start + cursor.since(start).trim_end().len()));
    }
}

/// Refuses other words beside statements of loops and branches, and axis words beside statements that take none.
fn alone(line: Line) -> Result<Line, String> {
    if let Some((statement, axis)) = super::own_block::axis_beside_statement(&line.items) {
        return Err(format!("{statement} takes no axis word; program {axis} in a block of its own"));
    }
    let is_structure = |item: &&Item| {
        matches!(
            item,
            Item::If(_, None)
                | Item::Structure(_)
                | Item::For(..)
                | Item::While(_)
                | Item::Until(_)
                | Item::RepeatPart { .. }
        )
    };
    match line.items.iter().find(is_structure) {
        Some(_) => Err("a loop, branch or repetition must be alone in its block; behind the condition of IF only a jump (GOTOF, GOTOB) may stand".to_owned()),
        None => Ok(line),
    }
}

pub(super) fn item(cursor: &mut Cursor<'_>) -> Result<Item, String> {
    let (first, second) = (cursor.byte(0), cursor.byte(1));
    let named = first == b'$' || first == b'_' || second == b'_';
    if begins_name(first) && (named || second.is_ascii_alphabetic()) {
        let from = cursor.at();
        let name = cursor.name().unwrap_or_default().to_ascii_uppercase();
        return statement(cursor, &name, from);
    }
    if first.is_ascii_alphabetic() {
        return address(cursor, first.to_ascii_uppercase());
    }
    let from = cursor.at();
    if first == b'"' && cursor.quoted().is_some() {
        return Ok(Item::Text(cursor.since(from).to_owned()));
    }
    while !cursor.is_at_end() && !matches!(cursor.byte(0), b' ' | b'\t') {
        cursor.step();
    }
    Ok(Item::Text(cursor.since(from).to_owned()))
}

/// A word by its letter.
fn address(cursor: &mut Cursor<'_>, letter: u8) -> Result<Item, String> {
    let from = cursor.at();
    cursor.step();
    let extension = cursor.digits().to_owned();
    let name = format!("{}{extension}", char::from(letter));
    let behind = cursor.at();
    if cursor.byte(0) == b'[' {
        if let Ok(name) = indexed(cursor, &name)
            && cursor.assigns()
        {
            return assignment(cursor, name);
        }
        cursor.back_to(behind);
    } else if cursor.assigns() {
        let name = indexed(cursor, &name)?;
        if let ("P", []) = (name.name.as_str(), name.index.as_slice()) {
            cursor.takes("=");
            let value = expression(cursor)?;
            return Ok(Item::Passes(value, cursor.since(from).to_owned()));
        }
        return assignment(cursor, name);
    }
    if letter == b'L' && !extension.is_empty() && cursor.byte(0) == b'(' {
        return Ok(Item::Function(name, arguments(cursor)?));
    }
    if extension.is_empty() {
        // A blank between letter and number belongs to the word.
        cursor.blanks();
        if matches!(cursor.byte(0), b'+' | b'-') {
            cursor.step();
        }
        if cursor.decimal().is_none() {
            cursor.back_to(behind);
        }
    } else if cursor.byte(0) == b'.' {
        cursor.step();
        cursor.digits();
    }
    let text = cursor.since(from);
    Ok(match letter {
        b'L' if !extension.is_empty() && text.len() == name.len() => Item::Program(name),
        b'P' => match extension.parse() {
            Ok(passes) => Item::Passes(Expression::constant(Data::Int(passes)), text.to_owned()),
            Err(_) => Item::Text(text.to_owned()),
        },
        b'M' if extension.parse() == Ok(17) && text.len() == name.len() => Item::Return(name, false),
        _ => Item::Text(text.to_owned()),
    })
}

fn assignment(cursor: &mut Cursor<'_>, name: Name) -> Result<Item, String> {
    cursor.takes("=");
    cursor.blanks();
    let from = cursor.at();
    let before = cursor.clone();
    if let Some(key) = cursor.name().map(str::to_ascii_uppercase)
        && cursor.byte(0) == b'('
    {
        match key.as_str() {
            "SET" => return Ok(Item::Set { name, value: Assigned::List(arguments(cursor)?) }),
            "REP" => return Ok(Item::Set { name, value: Assigned::Fill(arguments(cursor)?) }),
            _ => {}
        }
        // `CIC` is the incremental path along coded positions.
        let way = if key == "IC" || key == "CIC" {
            Some(Positioning::Incremental)
        } else {
            POSITIONINGS.iter().find(|(text, _)| *text == key).map(|(_, way)| *way)
        };
        if let Some(way) = way {
            cursor.takes("(");
            let value = expression(cursor)?;
            if !cursor.takes(")") {
                return Err(format!("a ')' is missing, {}", unexpected(cursor)));
            }
            return Ok(Item::Set { name, value: Assigned::Positioned(way, value, key) });
        }
    }
    *cursor = before;
    if let Some(list) = define::list(cursor)? {
        return Ok(Item::Set { name, value: Assigned::List(list) });
    }
    let value = expression(cursor)?;
    Ok(Item::Set { name, value: Assigned::One(value, cursor.since(from).trim().to_owned()) })
}

fn statement(cursor: &mut Cursor<'_>, name: &str, from: usize) -> Result<Item, String> {
    cursor.blanks_before_brackets();
    if actions::begins(name, cursor) {
        return actions::action(cursor, name);
    }
    if let Some((_, structure)) = STRUCTURES.iter().find(|(text, _)| *text == name) {
        if *structure == Structure::Repeat {
            return repeat(cursor, false);
        }
        return Ok(Item::Structure(*structure));
    }
    if let Some((_, direction)) = JUMPS.iter().find(|(text, _)| *text == name) {
        return Ok(Item::Goto(jump(cursor, *direction)?));
    }
    if let Some((_, statement)) = STATEMENTS.iter().find(|(text, _)| *text == name) {
        let text = cursor.since(from).to_owned();
        let operands = if statement.operands > 0 { arguments(cursor)? } else { Vec::new() };
        if operands.len() != statement.operands {
            return Err(format!("{name} takes {} arguments, not {}", statement.operands, operands.len()));
        }
        return Ok(Item::Shared { statement, text, operands });
    }
    Ok(match name {
        "REPEATB" => return repeat(cursor, true),
        "IF" => {
            let condition = expression(cursor)?;
            let before = cursor.clone();
            let direction = cursor.name().and_then(direction);
            match direction {
                Some(direction) => Item::If(condition, Some(jump(cursor, direction)?)),
                None => {
                    *cursor = before;
                    Item::If(condition, None)
                }
            }
        }
        "CASE" => return case(cursor),
        "FOR" => {
            let Some(variable) = cursor.name() else { return Err(unexpected(cursor)) };
            let variable = indexed(cursor, &variable.to_ascii_uppercase())?;
            if !cursor.assigns() || !cursor.takes("=") {
                return Err(unexpected(cursor));
            }
            let first = expression(cursor)?;
            if !cursor.word("TO") {
                return Err(format!("TO is missing, {}", unexpected(cursor)));
            }
            Item::For(variable, first, expression(cursor)?)
        }
        "WHILE" => Item::While(expression(cursor)?),
        "UNTIL" => Item::Until(expression(cursor)?),
        "DEF" => Item::Declare(define::declaration(cursor)?),
        "REDEF" => Item::Redeclare(define::declaration(cursor)?),
        "DEFINE" => {
            let Some(name) = cursor.name() else { return Err(unexpected(cursor)) };
            if !cursor.word("AS") {
                return Err(format!("AS is missing, {}", unexpected(cursor)));
            }
            let text = cursor.rest().trim().to_owned();
            while !cursor.is_at_end() {
                cursor.step();
            }
            Item::Define(name.to_ascii_uppercase(), text)
        }
        "PROC" => Item::Header(define::header(cursor)?),
        "EXTERN" => Item::External(define::header(cursor)?),
        "MSG" => Item::Message(if cursor.byte(0) == b'(' { arguments(cursor)?.into_iter().next() } else { None }),
        "MCALL" => Item::Modal,
        "RET" => {
            let elsewhere = cursor.byte(0) == b'(' && !arguments(cursor)?.is_empty();
            Item::Return(cursor.since(from).to_owned(), elsewhere)
        }
        "CALL" | "EXTCALL" | "PCALL" => return call(cursor, name),
        _ if cursor.byte(0) == b'(' => Item::Function(name.to_owned(), arguments(cursor)?),
        _ => {
            let behind = cursor.at();
            match indexed(cursor, name) {
                Ok(target) if cursor.assigns() => return assignment(cursor, target),
                _ => cursor.back_to(behind),
            }
            if cursor.byte(0) == b'[' {
                while !cursor.is_at_end() && !matches!(cursor.byte(0), b' ' | b'\t') {
                    cursor.step();
                }
                return Ok(Item::Text(cursor.since(from).to_owned()));
            }
            Item::Bare(cursor.since(from).to_owned())
        }
    })
}
