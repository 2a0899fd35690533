//! FN functions and their ISO forms D00 to D38.
//!
//! Facts: Heidenhain pre-processor pages (FN 0 to FN 14 with their examples, D00 to D14), programming manuals (FN 16 to
//! FN 18, FN 20, FN 38). Invariant: a function that is not emulated is a statement of its own, never nothing.

use counterpoint_control_api::numeric::{NumericFunction, NumericOperator};
use counterpoint_control_api::statement::{ALARM, SharedStatement};

use super::formula;
use super::formula::{Formula, FormulaError, HeidenhainOp, Op, expected, parameter, with};
use super::lex::HeidenhainCursor;
use super::q_parameter::QParameter;
use super::statement::{BranchCondition, HeidenhainStatement, Test};
use super::words::{HeidenhainWord, MADE, words};

/// Functions that other controls also have as statements: number, keyword, action.
const STATEMENTS: [(u32, &str, &SharedStatement); 1] = [(14, "ERROR", &ALARM)];

fn shared(number: u32) -> Option<(&'static str, &'static SharedStatement)> {
    STATEMENTS.iter().find(|(known, ..)| *known == number).map(|(_, key, statement)| (*key, *statement))
}

/// Behind `FN`: number, colon, function.
pub(super) fn read(cursor: &mut HeidenhainCursor<'_>) -> Result<HeidenhainStatement, FormulaError> {
    let Some(number) = cursor.whole() else { return Err(expected(cursor, "the number of the function")) };
    cursor.take(b':');
    let statement = match number {
        0..=8 | 13 => {
            let name = name(cursor)?;
            if !cursor.take(b'=') {
                return Err(expected(cursor, "an equal sign"));
            }
            HeidenhainStatement::Assign(name, calculated(number, cursor)?)
        }
        9..=12 => return branch(number, cursor),
        15 => HeidenhainStatement::Send(text_of(cursor, &["PRINT"])),
        16 => HeidenhainStatement::Print(text_of(cursor, &["F-PRINT"])),
        18 => {
            cursor.keyword("SYSREAD");
            let to = name(cursor)?;
            if !cursor.take(b'=') {
                return Err(expected(cursor, "an equal sign"));
            }
            read_system(to, cursor)?
        }
        17 => {
            cursor.keyword("SYSWRITE");
            write_system(cursor)?
        }
        20 => return Ok(HeidenhainStatement::Nothing),
        38 => HeidenhainStatement::Send(text_of(cursor, &["SEND"])),
        _ => match shared(number) {
            Some((key, statement)) => {
                if !cursor.keyword(key) || !cursor.take(b'=') {
                    return Err(expected(cursor, "the key word of the function and an equal sign"));
                }
                let operands = (0..statement.operands).map(|_| formula::operand(cursor)).collect::<Result<_, _>>()?;
                HeidenhainStatement::Shared(statement, operands)
            }
            None => return Ok(foreign(&format!("FN {number}"), cursor)),
        },
    };
    ended(statement, cursor)
}

/// An ISO function by its number: `D01 Q2 P01 +5.5 P02 Q1`.
pub(super) fn read_iso(number: u32, cursor: &mut HeidenhainCursor<'_>) -> Result<HeidenhainStatement, FormulaError> {
    let statement = match number {
        0..=8 | 13 => {
            let name = name(cursor)?;
            let first = operand(1, cursor)?;
            let formula = match (number, with_one(number)) {
                (0, _) => first,
                (_, Some(function)) => with([first], Op::Apply(function)),
                _ => with([first, operand(2, cursor)?], of_two(number)),
            };
            HeidenhainStatement::Assign(name, formula)
        }
        9..=12 => {
            let (first, second) = (operand(1, cursor)?, operand(2, cursor)?);
            place(3, cursor)?;
            return Ok(HeidenhainStatement::Branch(
                BranchCondition::Compare(first, test(number), second),
                target(cursor)?,
            ));
        }
        15 | 38 => HeidenhainStatement::Send(text_of(cursor, &[])),
        16 => HeidenhainStatement::Print(text_of(cursor, &["P01"])),
        18 => {
            let to = name(cursor)?;
            read_system(to, cursor)?
        }
        17 => write_system(cursor)?,
        20 => return Ok(HeidenhainStatement::Nothing),
        _ => match shared(number) {
            Some((_, statement)) => {
                let operands =
                    (1..=statement.operands as u32).map(|at| operand(at, cursor)).collect::<Result<_, _>>()?;
                HeidenhainStatement::Shared(statement, operands)
            }
            None => return Ok(foreign(&format!("D{number:02}"), cursor)),
        },
    };
    ended(statement, cursor)
}

fn ended(
    statement: HeidenhainStatement,
    cursor: &mut HeidenhainCursor<'_>,
) -> Result<HeidenhainStatement, FormulaError> {
    if cursor.is_over() { Ok(statement) } else { Err(expected(cursor, "the end of the block")) }
}

fn foreign(head: &str, cursor: &mut HeidenhainCursor<'_>) -> HeidenhainStatement {
    let head = words(&mut HeidenhainCursor::new(head)).into_iter();
    let mut all: Vec<HeidenhainWord> = head.map(|word| HeidenhainWord { span: MADE, ..word }).collect();
    all.extend(words(cursor));
    HeidenhainStatement::Foreign(all)
}

fn name(cursor: &mut HeidenhainCursor<'_>) -> Result<QParameter, FormulaError> {
    parameter(cursor).ok_or_else(|| expected(cursor, "a parameter"))
}

fn text_of(cursor: &mut HeidenhainCursor<'_>, words: &[&str]) -> String {
    for word in words {
        cursor.take_text(word);
    }
    cursor.all().to_owned()
}

/// `P01`, `P1`, `p02` before an operand.
fn place(number: u32, cursor: &mut HeidenhainCursor<'_>) -> Result<(), FormulaError> {
    let mut ahead = cursor.clone();
    if ahead.take(b'P') && ahead.whole() == Some(number) {
        *cursor = ahead;
        return Ok(());
    }
    Err(expected(cursor, "the next operand, P01, P02 or P03"))
}

fn operand(number: u32, cursor: &mut HeidenhainCursor<'_>) -> Result<Formula, FormulaError> {
    place(number, cursor)?;
    formula::operand(cursor)
}

/// Functions of one operand.
fn with_one(number: u32) -> Option<NumericFunction> {
    match number {
        5 => Some(NumericFunction::Sqrt),
        6 => Some(NumericFunction::Sin),
        7 => Some(NumericFunction::Cos),
        _ => None,
    }
}

fn of_two(number: u32) -> Op {
    Op::Combine(match number {
        1 => NumericOperator::Add,
        2 => NumericOperator::Sub,
        3 => NumericOperator::Mul,
        4 => NumericOperator::Div,
        8 => NumericOperator::Legs,
        _ => NumericOperator::Angle,
    })
}

/// The text after the equal sign of FN 0 to FN 8 and FN 13.
fn calculated(number: u32, cursor: &mut HeidenhainCursor<'_>) -> Result<Formula, FormulaError> {
    if number == 0 {
        return formula::formula(cursor);
    }
    if let Some(function) = with_one(number) {
        let key = [(5, "SQRT"), (6, "SIN"), (7, "COS")].into_iter().find(|(n, _)| *n == number).map_or("", |(_, k)| k);
        if !cursor.keyword(key) {
            return Err(expected(cursor, "SQRT, SIN or COS"));
        }
        return Ok(with([formula::operand(cursor)?], Op::Apply(function)));
    }
    let first = formula::operand(cursor)?;
    let key = match number {
        1 => "+",
        2 => "-",
        3 => "*",
        4 => "DIV",
        8 => "LEN",
        _ => "ANG",
    };
    // A division may be written by its sign, too.
    if !(cursor.take_text(key) || number == 4 && cursor.take(b'/')) {
        return Err(expected(cursor, "the sign of the operation"));
    }
    Ok(with([first, formula::operand(cursor)?], of_two(number)))
}

fn test(number: u32) -> Test {
    match number {
        9 => Test::Equal,
        10 => Test::NotEqual,
        11 => Test::Greater,
        _ => Test::Less,
    }
}

fn branch(number: u32, cursor: &mut HeidenhainCursor<'_>) -> Result<HeidenhainStatement, FormulaError> {
    if !cursor.keyword("IF") {
        return Err(expected(cursor, "IF"));
    }
    let first = formula::operand(cursor)?;
    let condition = if cursor.keyword("IS") {
        let defined = !cursor.keyword("UNDEFINED");
        if defined && !cursor.keyword("DEFINED") {
            return Err(expected(cursor, "DEFINED or UNDEFINED"));
        }
        match first.as_own() {
            Some(HeidenhainOp::Variable(name)) => BranchCondition::Defined(*name, defined),
            _ => return Err(expected(cursor, "a parameter before IS")),
        }
    } else {
        let key = match number {
            9 => "EQU",
            10 => "NE",
            11 => "GT",
            _ => "LT",
        };
        if !cursor.take_text(key) {
            return Err(expected(cursor, "EQU, NE, GT or LT, as the function has it"));
        }
        BranchCondition::Compare(first, test(number), formula::operand(cursor)?)
    };
    if !cursor.keyword("GOTO") {
        return Err(expected(cursor, "GOTO"));
    }
    Ok(HeidenhainStatement::Branch(condition, target(cursor)?))
}

/// `ID270 NR1 IDX2`: system, number, index.
fn place_of_system(cursor: &mut HeidenhainCursor<'_>) -> Result<(Formula, Formula, Option<Formula>), FormulaError> {
    if !cursor.take_text("ID") {
        return Err(expected(cursor, "ID"));
    }
    let id = formula::operand(cursor)?;
    if !cursor.take_text("NR") {
        return Err(expected(cursor, "NR"));
    }
    let number = formula::operand(cursor)?;
    let index = if cursor.take_text("IDX") { Some(formula::operand(cursor)?) } else { None };
    Ok((id, number, index))
}

fn read_system(to: QParameter, cursor: &mut HeidenhainCursor<'_>) -> Result<HeidenhainStatement, FormulaError> {
    let (id, number, index) = place_of_system(cursor)?;
    Ok(HeidenhainStatement::SysRead { to, id, number, index })
}

fn write_system(cursor: &mut HeidenhainCursor<'_>) -> Result<HeidenhainStatement, FormulaError> {
    let (id, number, index) = place_of_system(cursor)?;
    if !cursor.take(b'=') {
        return Err(expected(cursor, "an equal sign"));
    }
    Ok(HeidenhainStatement::SysWrite { id, number, index, value: formula::operand(cursor)? })
}

/// A label that a statement goes to: `LBL 5`, `LBL "NAME"`, `LBL QS5`.
pub(super) fn target(cursor: &mut HeidenhainCursor<'_>) -> Result<Formula, FormulaError> {
    cursor.keyword("LBL");
    let target = formula::operand(cursor)?;
    if cursor.is_over() { Ok(target) } else { Err(expected(cursor, "the end of the block")) }
}
