//! The remaining words of a block, as the machine reads them.
//!
//! *Invariant:* a word has its place in the text of the program; a word that the pre-processor makes has that of the
//! whole block. A word is left as a value or as a row of the code table wherever its text alone decides its meaning.

use rustc_hash::FxHashMap;

use super::words::{MADE, Rest, Seen};
use super::{Heidenhain, Line};
use crate::host::Host;
use crate::interpreter::Remaining;
use crate::words::{Span, span};
use counterpoint_machine::index::{CodeRowId, RegisterId};

/// Most names whose meaning is remembered.
const MOST: usize = 500;

/// Meanings of words on the machine.
#[derive(Debug, Default)]
pub(super) struct Meanings {
    /// The register of a name whose values are always numbers, and whether the name is its incremental form.
    registers: FxHashMap<Box<str>, Option<(RegisterId, bool)>>,
    /// The row of a text that is a literal text of its own.
    texts: FxHashMap<Box<str>, Option<CodeRowId>>,
}

fn kept<T: Copy>(known: &mut FxHashMap<Box<str>, T>, text: &str, find: impl FnOnce() -> T) -> T {
    if let Some(found) = known.get(text) {
        return *found;
    }
    let found = find();
    if known.len() < MOST {
        known.insert(text.into(), found);
    }
    found
}

impl Meanings {
    fn register(&mut self, host: &dyn Host, name: &str) -> Option<(RegisterId, bool)> {
        kept(&mut self.registers, name, || host.value_register(name))
    }

    fn text(&mut self, host: &dyn Host, text: &str) -> Option<CodeRowId> {
        kept(&mut self.texts, text, || host.separate_text(text))
    }
}

/// The remaining words of a block on their way into the block of the kernel.
struct Leaving<'a> {
    host: &'a mut dyn Host,
    meanings: &'a mut Meanings,
    /// The place of the whole block in its text.
    whole: Span,
    /// Texts that are the machine's together, with their place.
    run: String,
    run_place: Span,
}

impl Leaving<'_> {
    /// The place of a word in the text of the block.
    fn place(&self, (start, end): Span) -> Span {
        let (first, _) = self.whole;
        if (start, end) == MADE { self.whole } else { (start + first, end + first) }
    }

    fn word(&mut self, word: &Seen) {
        if let Some(function) = word.function {
            self.word(&Seen { span: word.span, ..Seen::made("M", f64::from(function)) });
        }
        if self.joins_run(word) || !self.alone(word) {
            let place = self.place(word.span);
            let is_first = self.run.is_empty();
            if !is_first {
                self.run.push(' ');
            }
            self.run.push_str(&word.own_text());
            self.run_place =
                if is_first { place } else { (self.run_place.0.min(place.0), self.run_place.1.max(place.1)) };
        }
    }

    /// Whether the texts before it may be a name of the machine together with it.
    fn joins_run(&mut self, word: &Seen) -> bool {
        if self.run.is_empty() {
            return false;
        }
        let joins = self.host.begins_name(&format!("{} {}", self.run, word.own_text()))
            || self.host.begins_name(&format!("{} {}", self.run, word.name));
        if !joins {
            self.end_run();
        }
        joins
    }

    /// Leaves the texts that belong together.
    fn end_run(&mut self) {
        if !self.run.is_empty() {
            self.host.push_written(&self.run, self.run_place);
            self.run.clear();
        }
    }

    /// Leaves a word whose text alone decides its meaning; whether it is one.
    fn alone(&mut self, word: &Seen) -> bool {
        let place = self.place(word.span);
        if let Some(value) = word.value
            && let Some(register) = self.meanings.register(&*self.host, &word.name)
        {
            match &word.rest {
                Rest::Written(number) => self.host.push_value(register, value, Some(number), place),
                _ => self.host.push_computed(register, value, place),
            }
            return true;
        }
        let text = word.own_text();
        // Few numbers are part of a literal text.
        if word.value.is_some() && !self.host.is_code_text(&text) {
            return false;
        }
        let row = self.meanings.text(&*self.host, &text);
        if let Some(row) = row {
            self.host.push_literal(row, place);
        }
        row.is_some()
    }
}

/// Leaves blocks of words, one after another, in the block of the kernel.
pub(super) fn leave(
    own: &mut Heidenhain,
    host: &mut dyn Host,
    line: &Line,
    blocks: impl IntoIterator<Item = Vec<Seen>>,
) -> Remaining {
    let (run, run_place) = (String::new(), MADE);
    let taken = own.lines.taken.take();
    let joined = taken.as_deref().or(line.joined.as_deref());
    let whole = taken.as_ref().map_or(line.place, |taken| span(0, taken.len()));
    let mut leaving = Leaving { host, meanings: &mut own.meanings, whole, run, run_place };
    let mut any = false;
    for block in blocks.into_iter().filter(|block| !block.is_empty()) {
        match (std::mem::replace(&mut any, true), line.number) {
            (true, _) => leaving.host.end_block(),
            (false, Some(number)) if leaving.host.is_register("N") => {
                leaving.word(&Seen::made("N", f64::from(number)));
            }
            (false, _) => {}
        }
        block.iter().for_each(|word| leaving.word(word));
        leaving.end_run();
    }
    if !any {
        return Remaining::Nothing;
    }
    if let Some(joined) = joined {
        leaving.host.join_lines(joined.as_bytes());
    }
    Remaining::Words
}
