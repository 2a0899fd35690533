//! The remaining words of a block, as the machine reads them.
//!
//! *Invariant:* a word has its place in the text of the program; a word that the pre-processor makes has that of the
//! whole block.

use std::borrow::Cow;

use super::words::{EvaluatedWord, LeftBlock, MADE, Rest};
use super::{Heidenhain, HeidenhainLine};
use counterpoint_control_api::host::InterpreterHost;
use counterpoint_control_api::interpreter::Remaining;
use counterpoint_control_api::words::{Leaving, LeftValue, Span, span};

/// Leaves a word of a block that has this place in its text.
fn leave_word(leaving: &mut Leaving<'_>, word: &EvaluatedWord, whole: Span) {
    let (first, _) = whole;
    let place = if word.span == MADE { whole } else { (word.span.0 + first, word.span.1 + first) };
    if let Some(function) = word.function {
        let function = f64::from(function);
        leaving.word("M", Some(LeftValue::Computed(function)), || Cow::Owned(format!("M{function}")), place);
    }
    let value = word.value.map(|value| match &word.rest {
        Rest::Written(number) => LeftValue::Written(number, value),
        _ => LeftValue::Computed(value),
    });
    leaving.word(&word.name, value, || word.own_text(), place);
}

/// Leaves blocks of words, one after another, in the block of the kernel.
pub(super) fn leave(
    own: &mut Heidenhain,
    host: &mut dyn InterpreterHost,
    line: &HeidenhainLine,
    blocks: impl IntoIterator<Item = LeftBlock>,
) -> Remaining {
    let taken = own.lines.taken.take();
    let joined = taken.as_deref().or(line.joined.as_deref());
    let whole = taken.as_ref().map_or(line.place, |taken| span(0, taken.len()));
    let mut leaving = Leaving::new(host, &mut own.meanings);
    let mut any = false;
    for block in blocks.into_iter().filter(|block| !block.is_empty()) {
        match (std::mem::replace(&mut any, true), line.number) {
            (true, _) => leaving.host.end_block(),
            (false, Some(number)) if leaving.host.is_register("N") => {
                leave_word(&mut leaving, &EvaluatedWord::made("N", f64::from(number)), whole);
            }
            (false, _) => {}
        }
        block.iter().for_each(|word| leave_word(&mut leaving, word, whole));
        leaving.end();
    }
    if !any {
        return Remaining::Nothing;
    }
    if let Some(joined) = joined {
        leaving.host.join_lines(joined.as_bytes());
    }
    Remaining::Words
}
