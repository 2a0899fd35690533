//! Regular expressions in the dialect of the line editor `ed`.
//!
//! *Invariant:* matching uses no recursion and stops with a fault when its step budget is used up, so no expression and
//! no text can hang or crash a macro. Facts: reference macro-language.md 4. Choices of this project: a star on a group
//! works; a star with nothing before it is literal; replacing all substitutes an empty match once per position, never
//! directly after a match; splitting ignores empty matches.

mod compile;
mod edit;
mod literal;
mod matcher;

use crate::fault::Outcome;

/// Steps one search may take.
pub const STEPS: u64 = 2_000_000;
/// Most instructions of one expression, and most characters of its text.
pub const MAX_PROGRAM: usize = 20_000;
/// Number of the first place that loops note; those before belong to the whole and nine groups.
const FIRST_LOOP: usize = 20;
/// Characters per step of a search while characters are only copied or compared.
const BYTES_PER_STEP: usize = 16;

/// A set of characters.
#[derive(Clone, Debug, PartialEq, Eq)]
enum CharClass {
    One(char),
    Any,
    Set(Box<CharSet>),
}

/// Ranges of characters, and which of the first 128 characters belong to the set after negation.
#[derive(Clone, Debug, PartialEq, Eq)]
struct CharSet {
    ranges: Vec<(char, char)>,
    negated: bool,
    ascii: u128,
}

impl CharSet {
    fn new(mut ranges: Vec<(char, char)>, negated: bool) -> CharSet {
        // In order and apart, so that a character is found by halving.
        ranges.sort_unstable();
        ranges.dedup_by(|next, kept| {
            let joins = next.0 <= kept.1;
            if joins {
                kept.1 = kept.1.max(next.1);
            }
            joins
        });
        let mut set = CharSet { ranges, negated, ascii: 0 };
        set.ascii = (0..128u8).filter(|byte| set.lists(char::from(*byte))).fold(0, |bits, byte| bits | 1u128 << byte);
        set
    }

    fn lists(&self, character: char) -> bool {
        let at = self.ranges.partition_point(|(low, _)| *low <= character);
        let range = at.checked_sub(1).and_then(|at| self.ranges.get(at));
        range.is_some_and(|(_, high)| character <= *high) != self.negated
    }
}

impl CharClass {
    #[inline]
    fn holds(&self, character: char) -> bool {
        match self {
            CharClass::One(one) => *one == character,
            CharClass::Any => true,
            CharClass::Set(set) if character.is_ascii() => set.ascii >> (u32::from(character) & 127) & 1 != 0,
            CharClass::Set(set) => set.lists(character),
        }
    }
}

impl CharClass {
    /// Ranges that it holds.
    fn ranges(&self) -> usize {
        if let CharClass::Set(set) = self { set.ranges.len() } else { 0 }
    }
}

impl PatternStep {
    /// Bytes that it takes besides itself.
    fn size(&self) -> usize {
        match self {
            PatternStep::One(class) | PatternStep::Run(class, ..) => class.ranges() * 8,
            _ => 0,
        }
    }
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum PatternStep {
    One(CharClass),
    /// Longest run of a class, giving back one by one.
    Run(CharClass, u32, u32),
    Reference(usize),
    Start,
    End,
    WordStart,
    WordEnd,
    Save(usize),
    /// Try the next step first, then the target.
    Split(usize),
    Jump(usize),
    /// Remembers where a pass of a group's loop began.
    Mark(usize),
    /// Ends a loop whose pass consumed nothing.
    Moved(usize),
    Done,
}

/// Memory of searches.
#[derive(Debug, Default)]
pub struct SearchMemory(matcher::MatcherMemory);

/// A compiled expression.
#[derive(Clone, Debug)]
pub struct TextPattern {
    steps: Vec<PatternStep>,
    /// Places noted during a search: two for the whole and each group, one for each loop.
    slots: usize,
    /// Groups.
    groups: usize,
    /// The first characters of every match.
    first: Option<CharClass>,
    anchored: bool,
}

/// Byte ranges of a match: the whole, then the groups 1 to 9.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Match {
    /// Start and end of the whole and of each group that took part.
    pub groups: [Option<(usize, usize)>; 10],
}

impl Match {
    /// Start and end of the whole match.
    #[must_use]
    pub fn whole(&self) -> (usize, usize) {
        self.groups.first().copied().flatten().unwrap_or((0, 0))
    }
}

impl TextPattern {
    /// Compiles an expression.
    ///
    /// # Errors
    /// A malformed or oversized expression.
    pub fn new(text: &str) -> Outcome<TextPattern> {
        compile::compile(text)
    }

    /// Bytes that it takes, about.
    pub(crate) fn size(&self) -> usize {
        self.steps.iter().map(|step| 48 + step.size()).sum()
    }

    /// The longest text that every match contains, empty when there is none.
    #[must_use]
    pub fn required(&self) -> String {
        literal::required(self)
    }

    /// As [`find`](Self::find), with memory that is used again.
    ///
    /// # Errors
    /// The step budget is used up.
    pub fn find_with(&self, text: &str, budget: &mut u64, memory: &mut SearchMemory) -> Outcome<Option<Match>> {
        matcher::find_with(self, text, budget, memory)
    }

    /// `template` with the groups of a match filled in.
    #[must_use]
    pub fn filled(template: &str, text: &str, found: &Match) -> String {
        let mut out = String::with_capacity(template.len() + 16);
        edit::fill(&mut out, template, text, found);
        out
    }

    /// Finds the leftmost match that begins at byte `from` or later.
    ///
    /// # Errors
    /// The step budget is used up.
    pub fn find(&self, text: &str, from: usize, budget: &mut u64) -> Outcome<Option<Match>> {
        let mut search = matcher::PatternSearch::new(self, text);
        Ok(search.find(from, budget)?.then_some(search.found))
    }

    /// Replaces all matches (`which` 0) or the `which`-th one.
    ///
    /// # Errors
    /// The step budget is used up.
    pub fn replace(&self, text: &str, with: &str, which: usize) -> Outcome<String> {
        edit::replace(self, text, (with, which), usize::MAX, &mut STEPS.clone())
    }

    /// The same within a budget of steps, for a result of at most this many bytes.
    ///
    /// # Errors
    /// The step budget is used up, or the result is too long.
    pub fn replace_within(
        &self,
        text: &str,
        (with, which): (&str, usize),
        most: usize,
        budget: &mut u64,
    ) -> Outcome<String> {
        edit::replace(self, text, (with, which), most, budget)
    }

    /// Text of the `which`-th match (1-based), or `template` with its groups filled in.
    ///
    /// # Errors
    /// The step budget is used up.
    pub fn nth(&self, text: &str, template: Option<&str>, which: usize) -> Outcome<Option<String>> {
        edit::nth(self, text, (template, which), &mut STEPS.clone())
    }

    /// The same within a budget of steps.
    ///
    /// # Errors
    /// The step budget is used up.
    pub fn nth_within(
        &self,
        text: &str,
        (template, which): (Option<&str>, usize),
        budget: &mut u64,
    ) -> Outcome<Option<String>> {
        edit::nth(self, text, (template, which), budget)
    }

    /// Pieces between matches, at most `limit` if that is not 0.
    ///
    /// # Errors
    /// The step budget is used up.
    pub fn split(&self, text: &str, limit: usize) -> Outcome<Vec<String>> {
        edit::split(self, text, (limit, usize::MAX), &mut STEPS.clone())
    }

    /// The same within a budget of steps, into this many pieces at most.
    ///
    /// # Errors
    /// The step budget is used up, or there are more pieces.
    pub fn split_within(&self, text: &str, (limit, most): (usize, usize), budget: &mut u64) -> Outcome<Vec<String>> {
        edit::split(self, text, (limit, most), budget)
    }
}

#[cfg(test)]
mod tests;
