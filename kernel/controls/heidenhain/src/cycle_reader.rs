//! Reads definitions of cycles: CYCL DEF and its parameters.

use std::borrow::Cow;

use super::formula::{FormulaError, expected};
use super::lex::HeidenhainCursor;
use super::statement::HeidenhainStatement;
use super::words::{HeidenhainWord, Operand, words};

/// Behind `CYCL DEF`.
pub(super) fn read(cursor: &mut HeidenhainCursor<'_>) -> Result<HeidenhainStatement, FormulaError> {
    let Some((number, _)) = cursor.number() else { return Err(expected(cursor, "the number of the cycle")) };
    // Some programs have a blank before the number of the part: `CYCL DEF 9 .0`.
    let before = cursor.clone();
    let number = match cursor.number() {
        Some((part, _)) if part.starts_with('.') && !number.contains('.') => Cow::Owned(format!("{number}{part}")),
        _ => {
            *cursor = before;
            Cow::Borrowed(&*number)
        }
    };
    let (cycle, part) = match number.split_once('.') {
        Some((cycle, part)) => (cycle, Some(part)),
        None => (&*number, None),
    };
    let whole = |digits: &str, cursor: &HeidenhainCursor<'_>| -> Result<u32, FormulaError> {
        digits.parse().map_err(|_| expected(cursor, "the number of the cycle"))
    };
    let cycle = whole(cycle, cursor)?;
    match part {
        None => {
            // Behind the title, the parameters.
            let all = words(cursor);
            let first = all.iter().position(is_parameter).unwrap_or(all.len());
            Ok(HeidenhainStatement::CycleDefinition(
                std::iter::once(head(cycle)).chain(all.into_iter().skip(first)).collect(),
            ))
        }
        Some(part) => {
            let part = whole(part, cursor)?;
            let text = cursor.rest().trim().to_owned();
            Ok(HeidenhainStatement::CyclePart { cycle, part, words: words(cursor), text })
        }
    }
}

/// `CYCL DEF` with the number.
pub(super) fn head(cycle: u32) -> HeidenhainWord {
    HeidenhainWord::made("CYCL DEF ", Operand::Number(cycle.to_string().into(), f64::from(cycle)))
}

fn is_parameter(word: &HeidenhainWord) -> bool {
    word.name.starts_with('Q') && word.name.ends_with('=')
}

/// Parameters of a cycle alone: several, each with its value.
pub(super) fn parameters(mut cursor: HeidenhainCursor<'_>) -> Option<Vec<HeidenhainWord>> {
    let all = words(&mut cursor);
    let is = |word: &HeidenhainWord| is_parameter(word) && !matches!(word.operand, Operand::None | Operand::Sign(_));
    (all.len() > 1 && all.iter().all(is)).then_some(all)
}
