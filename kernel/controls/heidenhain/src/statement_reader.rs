//! Reads statements.
//!
//! *Invariant:* reading changes nothing.

use super::formula;
use super::formula::{Formula, FormulaError, HeidenhainOp, expected, parameter};
use super::lex::HeidenhainCursor;
use super::path_state::PathBlockKind;
use super::statement::{CycleCallForm, HeidenhainStatement, Label};
use super::words::{HeidenhainWord, MADE, words};

/// Key words of statements that are not emulated.
const FOREIGN: [&str; 24] = [
    "PRESET",
    "PLANE",
    "FUNCTION",
    "GLOBAL",
    "TRANS",
    "PATTERN",
    "TCH",
    "SEL",
    "CONTOUR",
    "SPL",
    "MONITORING",
    "POLARKIN",
    "OPEN",
    "ACTIVATE",
    "SQL",
    "RAPTO",
    "WHILE",
    "FOR",
    "IF",
    "ELSE",
    "END",
    "CASE",
    "CALL",
    "GOTO",
];

/// Reads a block without number and comment.
pub(super) fn read(text: &str) -> Result<HeidenhainStatement, FormulaError> {
    let mut cursor = HeidenhainCursor::new(text);
    match cursor.peek() {
        None => return Ok(HeidenhainStatement::Nothing),
        Some(b'%') => return Ok(percent(&mut cursor)),
        Some(b'Q') => {
            let mut ahead = cursor.clone();
            if let Some(name) = parameter(&mut ahead)
                && ahead.take(b'=')
            {
                let several = || super::cycle_reader::parameters(cursor.clone()).map(HeidenhainStatement::Parameters);
                return match whole_formula(&mut ahead) {
                    Ok(formula) => Ok(HeidenhainStatement::Assign(name, formula)),
                    Err(wrong) => several().ok_or(wrong),
                };
            }
        }
        _ => {}
    }
    let first = cursor.next_byte().unwrap_or(b' ');
    if may_be_key_word(cursor.rest())
        && let Some(statement) = key_word(&mut cursor)?
    {
        return Ok(statement);
    }
    if let Some(statement) = super::iso::read(&mut cursor)? {
        return Ok(statement);
    }
    for (word, shape) in PathBlockKind::WORDS {
        if word.as_bytes().first() == Some(&first) && path_word(&mut cursor, word) {
            let words = words(&mut cursor);
            let words = if shape.is_free() { super::auxiliary::point_words(words) } else { words };
            return Ok(HeidenhainStatement::Path { shape, iso: false, words });
        }
    }
    let foreign = FOREIGN.iter().any(|word| cursor.clone().keyword(word));
    let words = words(&mut cursor);
    Ok(match foreign {
        true => HeidenhainStatement::Foreign(words),
        false => super::iso::path(words),
    })
}

/// Whether a block may begin with the keyword of a statement other than a path block. Most blocks cannot.
fn may_be_key_word(text: &str) -> bool {
    match text.as_bytes() {
        [b'L', second, ..] => *second == b'B',
        [b'C', second, ..] => matches!(second, b'A' | b'Y'),
        [first, ..] => matches!(first, b'F' | b'D' | b'S' | b'P' | b'B' | b'E' | b'T'),
        [] => false,
    }
}

/// The keyword of a path block: one letter has to be alone.
fn path_word(cursor: &mut HeidenhainCursor<'_>, word: &str) -> bool {
    let mut ahead = cursor.clone();
    if !ahead.keyword(word) {
        return false;
    }
    let alone = word.len() > 1 && !matches!(word, "CR" | "CT" | "CC")
        || matches!(ahead.next_byte(), None | Some(b' '))
            && !matches!(ahead.peek(), Some(b'0'..=b'9' | b'+' | b'-' | b'.' | b'=' | b'Q'));
    if alone {
        *cursor = ahead;
    }
    alone
}

/// A formula up to the end of the block.
pub(super) fn whole_formula(cursor: &mut HeidenhainCursor<'_>) -> Result<Formula, FormulaError> {
    let formula = formula::formula(cursor)?;
    if cursor.is_over() { Ok(formula) } else { Err(expected(cursor, "the end of the formula")) }
}

/// A statement that begins with keywords.
fn key_word(cursor: &mut HeidenhainCursor<'_>) -> Result<Option<HeidenhainStatement>, FormulaError> {
    if cursor.keyword("FN") {
        return super::functions::read(cursor).map(Some);
    }
    Ok(Some(if cursor.keyword("DECLARE STRING") || cursor.keyword("DECLAR STRING") {
        let name = parameter(cursor).ok_or_else(|| expected(cursor, "a parameter"))?;
        if !cursor.take(b'=') {
            return Err(expected(cursor, "an equal sign"));
        }
        HeidenhainStatement::Assign(name, whole_formula(cursor)?)
    } else if cursor.keyword("LBL") {
        return label(cursor).map(Some);
    } else if cursor.keyword("CALL LBL") {
        let label = formula::operand(cursor)?;
        let repeat = if cursor.keyword("REP") { Some(repeat(cursor)?) } else { None };
        if !cursor.is_over() {
            return Err(expected(cursor, "REP or the end of the block"));
        }
        HeidenhainStatement::CallLabel { label, repeat }
    } else if cursor.keyword("CALL PGM") {
        HeidenhainStatement::CallProgram(program_name(cursor)?)
    } else if cursor.keyword("CALL SELECTED PGM") {
        HeidenhainStatement::CallSelected
    } else if cursor.keyword("SEL PGM") {
        HeidenhainStatement::SelectProgram(program_name(cursor)?)
    } else if cursor.keyword("SEL PATTERN") {
        HeidenhainStatement::SelectPoints(program_name(cursor)?)
    } else if cursor.keyword("SEL CONTOUR") {
        HeidenhainStatement::SelectContour(program_name(cursor)?)
    } else if cursor.keyword("SEL TABLE") {
        HeidenhainStatement::SelectDatums(program_name(cursor)?)
    } else if cursor.keyword("PRESET SELECT") {
        HeidenhainStatement::SelectPreset(words(cursor))
    } else if cursor.keyword("BEGIN PGM") {
        let inch = cursor.all().split_whitespace().last().and_then(|unit| match unit {
            "INCH" => Some(true),
            "MM" => Some(false),
            _ => None,
        });
        HeidenhainStatement::Begin { iso: false, inch, words: Vec::new() }
    } else if cursor.keyword("END PGM") {
        HeidenhainStatement::End
    } else if cursor.keyword("BLK FORM") {
        HeidenhainStatement::Nothing
    } else if cursor.keyword("TOOL CALL") {
        let named = matches!(cursor.peek(), Some(b'0'..=b'9' | b'"' | b'Q'));
        let tool = if named { Some(formula::operand(cursor)?) } else { None };
        HeidenhainStatement::ToolCall { tool, words: words(cursor) }
    } else if cursor.keyword("TOOL DEF") {
        let tool = formula::operand(cursor)?;
        HeidenhainStatement::ToolDefinition { tool, words: words(cursor) }
    } else if cursor.keyword("CYCL DEF") {
        return super::cycle_reader::read(cursor).map(Some);
    } else if cursor.keyword("CYCL CALL") {
        let kind = if cursor.keyword("POS") {
            CycleCallForm::Position
        } else if cursor.keyword("PAT") {
            CycleCallForm::Pattern
        } else {
            CycleCallForm::Here
        };
        HeidenhainStatement::CycleCall { kind, words: words(cursor) }
    } else if cursor.keyword("SL") {
        HeidenhainStatement::Contour(cursor.all().trim().to_owned())
    } else if cursor.keyword("STOP") {
        HeidenhainStatement::Stop(words(cursor))
    } else {
        return Ok(None);
    }))
}

/// Number of repeats of a section; `REP 3`, and `REP 3/2` of listings that show the remaining repeats.
pub(super) fn repeat(cursor: &mut HeidenhainCursor<'_>) -> Result<Formula, FormulaError> {
    let repeat = formula::operand(cursor)?;
    if cursor.take(b'/') {
        cursor.whole();
    }
    Ok(repeat)
}

pub(super) fn label(cursor: &mut HeidenhainCursor<'_>) -> Result<HeidenhainStatement, FormulaError> {
    let label = match cursor.quoted() {
        Some(name) => Label::Name(name.to_owned()),
        None => Label::Number(cursor.whole().ok_or_else(|| expected(cursor, "the number or name of a label"))?),
    };
    if !cursor.is_over() {
        return Err(expected(cursor, "the end of the block"));
    }
    Ok(if label == Label::Number(0) { HeidenhainStatement::EndOfLabel } else { HeidenhainStatement::Label(label) })
}

/// Name of a program: a text, a text parameter, or unchanged text.
pub(super) fn program_name(cursor: &mut HeidenhainCursor<'_>) -> Result<Formula, FormulaError> {
    let mut ahead = cursor.clone();
    if let Some(name) = parameter(&mut ahead)
        && ahead.is_over()
    {
        return Ok(Formula::own(HeidenhainOp::Variable(name)));
    }
    let name = match cursor.quoted() {
        Some(name) => name,
        None => cursor.all(),
    };
    if name.trim().is_empty() {
        return Err(expected(cursor, "the name of a program"));
    }
    Ok(formula::text(name.trim()))
}

/// `%NAME G71` begins an ISO program, or ends it after a number; `%NAME` calls one.
fn percent(cursor: &mut HeidenhainCursor<'_>) -> HeidenhainStatement {
    cursor.take(b'%');
    let text = cursor.all();
    let (name, unit) = text.rsplit_once(' ').map_or((text, ""), |(name, unit)| (name.trim(), unit));
    let words = || {
        words(&mut HeidenhainCursor::new(unit)).into_iter().map(|word| HeidenhainWord { span: MADE, ..word }).collect()
    };
    match unit {
        "G70" => HeidenhainStatement::Begin { iso: true, inch: Some(true), words: words() },
        "G71" => HeidenhainStatement::Begin { iso: true, inch: Some(false), words: words() },
        _ if text.is_empty() => HeidenhainStatement::Nothing,
        _ => {
            let name = if unit.is_empty() { name } else { text };
            HeidenhainStatement::CallProgram(formula::text(name.trim_matches('"')))
        }
    }
}
