//! Backtracking over the steps with a stack of its own.
//!
//! *Invariant:* every pass of the loop costs one step of the budget, so time and stack are bounded by it.

use super::{BYTES_PER_STEP, CharClass, Match, PatternStep, TextPattern};
use crate::diag::DiagnosticNumber;
use crate::fault::{MacroFault, Outcome};

const NONE: usize = usize::MAX;

#[derive(Debug)]
enum Back {
    /// Go on with a step at a place.
    Branch(usize, usize),
    /// A slot had another value.
    Slot(usize, usize),
    /// A run may give back characters down to a place: step, lowest place, place.
    Run(usize, usize, usize),
}

/// A search in a text, with the memory that all attempts share.
pub(super) struct PatternSearch<'a> {
    pattern: &'a TextPattern,
    text: &'a str,
    slots: Vec<usize>,
    stack: Vec<Back>,
    /// The last match.
    pub(super) found: Match,
}

impl<'a> PatternSearch<'a> {
    pub(super) fn new(pattern: &'a TextPattern, text: &'a str) -> PatternSearch<'a> {
        PatternSearch { pattern, text, slots: vec![NONE; pattern.slots], stack: Vec::new(), found: Match::default() }
    }

    /// Finds the leftmost match that begins at byte `from` or later, and leaves it in `found`.
    pub(super) fn find(&mut self, from: usize, budget: &mut u64) -> Outcome<bool> {
        // Places of groups that the expression does not have are never noted.
        let (noted, loops) = (2 * self.pattern.groups + 2, super::FIRST_LOOP);
        let mut start = from;
        while start <= self.text.len() {
            if let Some(first) = &self.pattern.first {
                match ahead(self.text, start, first) {
                    Some(place) => start = place,
                    None => return Ok(false),
                }
            }
            self.slots.iter_mut().take(noted).for_each(|slot| *slot = NONE);
            self.slots.iter_mut().skip(loops).for_each(|slot| *slot = NONE);
            self.stack.clear();
            *budget = budget.saturating_sub(self.slots.len() as u64 / 64);
            if attempt(self.pattern, self.text, start, &mut self.slots, &mut self.stack, budget)? {
                captured(&self.slots, self.pattern.groups, &mut self.found);
                return Ok(true);
            }
            if self.pattern.anchored {
                return Ok(false);
            }
            start += character(self.text, start).map_or(1, char::len_utf8);
        }
        Ok(false)
    }
}

/// Choices that a stack has room for at most while it is kept.
const MOST_KEPT: usize = 4096;

/// Slots and stack of a search, kept for the next one.
#[derive(Debug, Default)]
pub(super) struct MatcherMemory {
    slots: Vec<usize>,
    stack: Vec<Back>,
}

/// Finds the leftmost match; allocates nothing once the memory has grown.
pub(super) fn find_with(
    pattern: &TextPattern,
    text: &str,
    budget: &mut u64,
    memory: &mut super::SearchMemory,
) -> Outcome<Option<Match>> {
    let MatcherMemory { mut slots, stack } = std::mem::take(&mut memory.0);
    slots.clear();
    slots.resize(pattern.slots, NONE);
    let mut search = PatternSearch { pattern, text, slots, stack, found: Match::default() };
    let found = search.find(0, budget);
    if search.stack.capacity() > MOST_KEPT {
        search.stack = Vec::new();
    }
    let PatternSearch { slots, stack, found: place, .. } = search;
    memory.0 = MatcherMemory { slots, stack };
    Ok(found?.then_some(place))
}

/// Place of the next character of a class.
fn ahead(text: &str, from: usize, class: &CharClass) -> Option<usize> {
    let rest = text.get(from..)?;
    let found = match class {
        CharClass::One(one) => rest.find(*one),
        class => rest.char_indices().find(|(_, character)| class.holds(*character)).map(|(at, _)| at),
    };
    Some(from + found?)
}

fn captured(slots: &[usize], groups: usize, found: &mut Match) {
    for (group, pair) in found.groups.iter_mut().zip(slots.chunks_exact(2)).take(groups + 1) {
        *group = match pair {
            [start, end] if *start != NONE && *end != NONE => Some((*start, *end)),
            _ => None,
        };
    }
}

#[inline]
fn character(text: &str, at: usize) -> Option<char> {
    match text.as_bytes().get(at) {
        Some(byte) if byte.is_ascii() => Some(char::from(*byte)),
        _ => text.get(at..)?.chars().next(),
    }
}

fn before(text: &str, at: usize) -> Option<char> {
    text.get(..at)?.chars().next_back()
}

fn is_word(character: Option<char>) -> bool {
    character.is_some_and(|c| c.is_alphanumeric() || c == '_')
}

fn attempt(
    pattern: &TextPattern,
    text: &str,
    start: usize,
    slots: &mut [usize],
    stack: &mut Vec<Back>,
    budget: &mut u64,
) -> Outcome<bool> {
    let (mut step, mut at) = (0usize, start);
    loop {
        if *budget == 0 {
            return Err(MacroFault::new(
                DiagnosticNumber::BACKTRACKING,
                "this regular expression needs too many steps on this text",
            ));
        }
        *budget -= 1;
        let mut good = true;
        match pattern.steps.get(step) {
            None | Some(PatternStep::Done) => return Ok(true),
            Some(PatternStep::One(class)) => match character(text, at).filter(|c| class.holds(*c)) {
                Some(c) => at += c.len_utf8(),
                None => good = false,
            },
            Some(PatternStep::Run(class, least, most)) => match run(text, at, class, *least, *most, budget) {
                Some((low, high)) => {
                    at = high;
                    if low < high {
                        stack.push(Back::Run(step + 1, low, high));
                    }
                }
                None => good = false,
            },
            Some(PatternStep::Reference(group)) => match referred(text, slots, *group) {
                Some(part) => {
                    *budget = budget.saturating_sub((part.len() / BYTES_PER_STEP) as u64);
                    good = text.get(at..).is_some_and(|rest| rest.starts_with(part));
                    at += if good { part.len() } else { 0 };
                }
                None => good = false,
            },
            Some(PatternStep::Start) => good = at == 0,
            Some(PatternStep::End) => good = at == text.len(),
            Some(PatternStep::WordStart) => good = !is_word(before(text, at)) && is_word(character(text, at)),
            Some(PatternStep::WordEnd) => good = is_word(before(text, at)) && !is_word(character(text, at)),
            Some(PatternStep::Save(slot) | PatternStep::Mark(slot)) => {
                if let Some(place) = slots.get_mut(*slot) {
                    // Without a choice to go back to, a failure forgets all places anyway.
                    if !stack.is_empty() {
                        stack.push(Back::Slot(*slot, *place));
                    }
                    *place = at;
                }
            }
            Some(PatternStep::Moved(slot)) => good = slots.get(*slot) != Some(&at),
            Some(PatternStep::Split(target)) => stack.push(Back::Branch(*target, at)),
            Some(PatternStep::Jump(target)) => {
                step = *target;
                continue;
            }
        }
        if good {
            step += 1;
        } else if !back(text, slots, stack, &mut step, &mut at) {
            return Ok(false);
        }
    }
}

/// Longest run of a class from `at`: the lowest place to give back to and the end.
fn run(text: &str, at: usize, class: &CharClass, least: u32, most: u32, budget: &mut u64) -> Option<(usize, usize)> {
    let (mut count, mut place) = (0u32, at);
    let mut low = if least == 0 { Some(at) } else { None };
    while count < most
        && let Some(c) = character(text, place).filter(|c| class.holds(*c))
    {
        place += c.len_utf8();
        count += 1;
        if count == least {
            low = Some(place);
        }
    }
    *budget = budget.saturating_sub(u64::from(count) / BYTES_PER_STEP as u64);
    low.map(|low| (low, place))
}

fn referred<'a>(text: &'a str, slots: &[usize], group: usize) -> Option<&'a str> {
    text.get(*slots.get(2 * group)?..*slots.get(2 * group + 1)?)
}

/// Undoes up to the last choice; false if there is none.
fn back(text: &str, slots: &mut [usize], stack: &mut Vec<Back>, step: &mut usize, at: &mut usize) -> bool {
    while let Some(last) = stack.pop() {
        match last {
            Back::Slot(slot, value) => {
                if let Some(place) = slots.get_mut(slot) {
                    *place = value;
                }
            }
            Back::Branch(target, place) => {
                (*step, *at) = (target, place);
                return true;
            }
            Back::Run(target, low, high) => {
                let place = high - before(text, high).map_or(1, char::len_utf8);
                if place > low {
                    stack.push(Back::Run(target, low, place));
                }
                (*step, *at) = (target, place);
                return true;
            }
        }
    }
    false
}
