//! Words with values that an interpreter leaves in its block.
//!
//! *Invariant:* a word has the place of the text from which it is made, so diagnostics quote the text of the program.

use std::borrow::Cow;

use crate::host::{InterpreterHost, WordHost};
use counterpoint_machine::index::{CodeRowId, RegisterId};
use rustc_hash::FxHashMap;

/// Start and end of a part of a block.
pub type Span = (u32, u32);

/// Makes a span of the start and the end of a part.
pub fn span(start: usize, end: usize) -> Span {
    (start as u32, end as u32)
}

/// The text at a place.
pub fn part(text: &[u8], (start, end): Span) -> Cow<'_, str> {
    String::from_utf8_lossy(text.get(start as usize..end as usize).unwrap_or_default())
}

/// A word with a value, as it is `spelled` or computed.
#[derive(Debug, Clone, Copy)]
pub struct Valued<'a> {
    /// Name of the word.
    pub name: &'a str,
    /// Its value.
    pub value: f64,
    /// The value as the program writes it.
    pub spelled: Option<&'a str>,
    /// Its place in the block.
    pub span: Span,
}

impl Valued<'_> {
    /// Adds the word to the block; false if no register of the machine has its name.
    pub fn push<W: WordHost + ?Sized>(&self, words: &mut W) -> bool {
        let register = words.register_named(self.name);
        if let Some(register) = register {
            words.push_value(register, self.value, self.spelled, self.span);
        }
        register.is_some()
    }
}

/// Maximum number of names whose meanings are remembered.
const MOST_MEANINGS: usize = 500;

/// Meanings of words on the machine, which are looked up once.
#[derive(Debug, Default)]
pub struct Meanings {
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
    if known.len() < MOST_MEANINGS {
        known.insert(text.into(), found);
    }
    found
}

/// The value of a word.
#[derive(Debug, Clone, Copy)]
pub enum LeftValue<'a> {
    /// As the program writes it.
    Written(&'a str, f64),
    /// The number that replaces what the program writes.
    Replaced(&'a str),
    /// A computed number.
    Computed(f64),
}

/// Words that an interpreter leaves in the block of the kernel.
///
/// *Invariant:* a word is left as a value or as a row of the code table wherever its text alone decides its meaning.
pub struct Leaving<'a> {
    /// The kernel.
    pub host: &'a mut dyn InterpreterHost,
    meanings: &'a mut Meanings,
    /// Texts that may together be a name of the machine, with their place.
    run: String,
    run_place: Span,
}

impl<'a> Leaving<'a> {
    /// For one block.
    pub fn new(host: &'a mut dyn InterpreterHost, meanings: &'a mut Meanings) -> Self {
        Self { host, meanings, run: String::new(), run_place: (0, 0) }
    }

    /// Leaves a word; `text` returns its full text.
    pub fn word<'t>(&mut self, name: &str, value: Option<LeftValue<'_>>, text: impl Fn() -> Cow<'t, str>, place: Span) {
        if self.joins_run(name, &text) || !self.alone(name, value, &text, place) {
            let is_first = self.run.is_empty();
            if !is_first {
                self.run.push(' ');
            }
            self.run.push_str(&text());
            let (start, end) = self.run_place;
            self.run_place = if is_first { place } else { (start.min(place.0), end.max(place.1)) };
        }
    }

    /// Whether the texts before a word may be a name of the machine together with it.
    fn joins_run<'t>(&mut self, name: &str, text: impl Fn() -> Cow<'t, str>) -> bool {
        if self.run.is_empty() {
            return false;
        }
        let begins = |with: &str| self.host.begins_name(&format!("{} {with}", self.run));
        let joins = begins(name) || begins(&text());
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

    /// Leaves a word if its text alone decides its meaning; otherwise returns false.
    fn alone<'t>(
        &mut self,
        name: &str,
        value: Option<LeftValue<'_>>,
        text: impl Fn() -> Cow<'t, str>,
        place: Span,
    ) -> bool {
        let (host, meanings) = (&mut *self.host, &mut *self.meanings);
        if let Some(value) = value
            && let Some(register) = kept(&mut meanings.registers, name, || host.value_register(name))
        {
            match value {
                LeftValue::Written(number, value) => host.push_value(register, value, Some(number), place),
                LeftValue::Replaced(number) => return host.push_number(register, number, &text(), place),
                LeftValue::Computed(value) => host.push_computed(register, value, place),
            }
            return true;
        }
        let text = text();
        // Few numbers are part of a literal text.
        if value.is_some() && !host.is_code_text(&text) {
            return false;
        }
        let row = kept(&mut meanings.texts, &text, || host.separate_text(&text));
        if let Some(row) = row {
            host.push_literal(row, place);
        }
        row.is_some()
    }

    /// Ends the words of a block; more words form a block of their own after [`WordHost::end_block`].
    pub fn end(&mut self) {
        self.end_run();
    }
}
