//! The tape editor: rules that change the text of a block as it was read, before anything else looks at it.
//!
//! Facts: reference control-emulator.md 5.2. Invariants: every rule that is on is applied once, to its first match, in
//! list order, each to what the rules before it left; a block that no rule matches costs one search for the texts that
//! the rules need, and no memory.

use aho_corasick::AhoCorasick;
use counterpoint_lang::pattern::{Memory, Pattern, STEPS};

use crate::machine::model::TapeRule;

/// Steps of the searches of all rules on one block.
const MOST_STEPS: u64 = 2 * STEPS;

/// Rules by number, from 0; a machine has 256 at most.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Rules([u64; 4]);

impl Rules {
    /// Switches a rule.
    pub(crate) fn set(&mut self, rule: usize, on: bool) {
        if let Some(bits) = self.0.get_mut(rule / 64) {
            let bit = 1 << (rule % 64);
            *bits = if on { *bits | bit } else { *bits & !bit };
        }
    }

    /// A rule is on.
    pub(crate) fn has(&self, rule: usize) -> bool {
        self.0.get(rule / 64).is_some_and(|bits| bits & 1 << (rule % 64) != 0)
    }

    /// The first rule from `from` on that is in both.
    fn next(&self, from: usize, and: &Self) -> Option<usize> {
        (from / 64..4).find_map(|word| {
            let both = self.0.get(word)? & and.0.get(word)?;
            let wanted = if word == from / 64 { both & (u64::MAX << (from % 64)) } else { both };
            (wanted != 0).then(|| word * 64 + wanted.trailing_zeros() as usize)
        })
    }
}

/// The rules of a machine, compiled once.
#[derive(Debug)]
pub(crate) struct Tape {
    rules: Vec<(Pattern, String)>,
    /// The texts that rules need, and whose they are.
    needed: Option<(AhoCorasick, Vec<u16>)>,
    /// Rules that need no text: they are always tried.
    always: Rules,
    /// Rules that are on at program start.
    pub(crate) start: Rules,
}

/// What became of a block.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Edited {
    /// New text, `None` when nothing matched.
    pub(crate) text: Option<Vec<u8>>,
    /// A rule that gave up: it needs too many steps on this text.
    pub(crate) stuck: Option<usize>,
    /// A rule whose result is too long, and its length; nothing of the block is changed.
    pub(crate) long: Option<(usize, usize)>,
    /// Bytes that rules have looked at and made.
    pub(crate) work: usize,
}

impl Tape {
    /// Compiles the rules; `None` when there is none.
    pub(crate) fn new(rules: &[TapeRule]) -> Option<Self> {
        let (mut compiled, mut texts, mut owners) = (Vec::new(), Vec::new(), Vec::new());
        let (mut always, mut start) = (Rules::default(), Rules::default());
        for (number, rule) in rules.iter().enumerate() {
            // The loader has checked the expression.
            let Ok(pattern) = Pattern::new(&rule.find) else { continue };
            let number = number.min(255);
            let text = pattern.required();
            // Blocks are bytes: a character beyond ASCII may be written in two ways.
            if text.is_empty() || !text.is_ascii() {
                always.set(number, true);
            } else {
                texts.push(text);
                owners.push(number as u16);
            }
            start.set(number, rule.on);
            compiled.push((pattern, rule.replace.clone()));
        }
        if compiled.is_empty() {
            return None;
        }
        let needed = AhoCorasick::builder().kind(Some(aho_corasick::AhoCorasickKind::DFA)).build(&texts);
        match needed {
            Ok(automaton) => Some(Self { rules: compiled, needed: Some((automaton, owners)), always, start }),
            Err(_) => {
                owners.iter().for_each(|&owner| always.set(usize::from(owner), true));
                Some(Self { rules: compiled, needed: None, always, start })
            }
        }
    }

    /// Rules that may match a text.
    fn candidates(&self, text: &[u8]) -> Rules {
        let mut candidates = self.always;
        if let Some((automaton, owners)) = &self.needed {
            for found in automaton.find_overlapping_iter(text) {
                if let Some(&owner) = owners.get(found.pattern().as_usize()) {
                    candidates.set(usize::from(owner), true);
                }
            }
        }
        candidates
    }

    /// Applies the rules that are on; no result may have more bytes than `longest`.
    #[inline]
    pub(crate) fn edit(&self, line: &[u8], on: &Rules, longest: usize, memory: &mut Memory) -> Edited {
        let candidates = self.candidates(line);
        match candidates.next(0, on) {
            None => Edited::default(),
            Some(first) => self.apply(line, (first, candidates), (on, longest), memory),
        }
    }

    fn apply(&self, line: &[u8], start: (usize, Rules), limits: (&Rules, usize), memory: &mut Memory) -> Edited {
        match std::str::from_utf8(line) {
            Ok(text) => {
                let (text, edited) = self.rewrite(text, start, limits, memory);
                Edited { text: text.map(String::into_bytes), ..edited }
            }
            Err(_) => {
                // Eight-bit text: one character a byte.
                let text: String = line.iter().copied().map(char::from).collect();
                let (text, edited) = self.rewrite(&text, start, limits, memory);
                Edited { text: text.map(|text| bytes(&text)), ..edited }
            }
        }
    }

    fn rewrite(
        &self,
        line: &str,
        (first, mut candidates): (usize, Rules),
        (on, longest): (&Rules, usize),
        memory: &mut Memory,
    ) -> (Option<String>, Edited) {
        let (mut text, mut edited): (Option<String>, _) = (None, Edited::default());
        let (mut next, mut left) = (Some(first), MOST_STEPS);
        while let Some(number) = next {
            let now = text.as_deref().unwrap_or(line);
            if let Some((pattern, replace)) = self.rules.get(number) {
                let given = STEPS.min(left);
                let mut budget = given;
                edited.work += now.len();
                match pattern.find_with(now, &mut budget, memory) {
                    Ok(None) => {}
                    Ok(Some(found)) => {
                        let (start, end) = found.whole();
                        let filled = Pattern::filled(replace, now, &found);
                        let length = now.len() - (end - start) + filled.len();
                        if length > longest.max(line.len()) {
                            edited.long = Some((number, length));
                            return (None, edited);
                        }
                        edited.work += length;
                        let mut changed = String::with_capacity(length);
                        changed += now.get(..start).unwrap_or_default();
                        changed += &filled;
                        changed += now.get(end..).unwrap_or_default();
                        candidates = self.candidates(changed.as_bytes());
                        text = Some(changed);
                    }
                    Err(_) => edited.stuck = Some(number),
                }
                left -= given - budget;
                edited.work += usize::try_from(given - budget).unwrap_or(usize::MAX);
            }
            next = candidates.next(number + 1, on);
        }
        (text.filter(|text| text != line), edited)
    }
}

/// Characters back to bytes.
fn bytes(text: &str) -> Vec<u8> {
    let mut out = Vec::with_capacity(text.len());
    for c in text.chars() {
        match u8::try_from(u32::from(c)) {
            Ok(byte) => out.push(byte),
            Err(_) => out.extend_from_slice(c.encode_utf8(&mut [0; 4]).as_bytes()),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tape(rules: &[(&str, &str)]) -> Tape {
        let rule = |(find, replace): &(&str, &str)| TapeRule {
            find: (*find).into(),
            replace: (*replace).into(),
            on: true,
            line: 0,
            file: String::new(),
        };
        Tape::new(&rules.iter().map(rule).collect::<Vec<_>>()).unwrap()
    }

    fn edit(tape: &Tape, line: &str) -> Option<String> {
        let edited = tape.edit(line.as_bytes(), &tape.start, 1000, &mut Memory::default());
        assert_eq!(edited.stuck, None);
        edited.text.map(|text| String::from_utf8(text).unwrap())
    }

    #[test]
    fn no_rule_makes_a_block_longer_than_it_may_be() {
        let rules: Vec<(&str, &str)> = vec![("\\(X.*\\)", "\\1\\1"); 24];
        let tape = tape(&rules);
        let edited = tape.edit(b"X0123456", &tape.start, 1000, &mut Memory::default());
        assert_eq!((edited.text, edited.long), (None, Some((6, 1024))));
        assert!(edited.work < 20_000, "{}", edited.work);
    }

    #[test]
    fn each_rule_once_at_its_first_match_in_order() {
        let tape = tape(&[("^%$", ""), ("A", "B"), ("B", "C"), ("\\(X\\)\\([0-9]*\\)", "\\1=\\2")]);
        assert_eq!(edit(&tape, "%").as_deref(), Some(""));
        assert_eq!(edit(&tape, "% 1"), None);
        assert_eq!(edit(&tape, "AA").as_deref(), Some("CA"));
        assert_eq!(edit(&tape, "G1 X12 X3").as_deref(), Some("G1 X=12 X3"));
        assert_eq!(edit(&tape, "G1 Z12"), None);
    }

    #[test]
    fn rules_without_a_literal_are_tried_always() {
        let tape = tape(&[("[0-9][0-9]*$", "#"), ("Q", "")]);
        assert_eq!(edit(&tape, "G1 X12").as_deref(), Some("G1 X#"));
        assert_eq!(edit(&tape, "G1 X"), None);
    }

    #[test]
    fn a_rule_that_is_off_does_nothing_and_later_rules_see_what_earlier_ones_made() {
        let tape = tape(&[("G1", "G101"), ("101", "7")]);
        let mut on = tape.start;
        assert_eq!(edit(&tape, "G1").as_deref(), Some("G7"));
        on.set(0, false);
        assert_eq!(tape.edit(b"G1", &on, 1000, &mut Memory::default()).text, None);
        assert_eq!(tape.edit(b"G101", &on, 1000, &mut Memory::default()).text.as_deref(), Some(&b"G7"[..]));
    }

    #[test]
    fn eight_bit_text_stays_as_it_is() {
        let tape = tape(&[("G1", "G0")]);
        let edited = tape.edit(b"G1 (\xe4\xff)", &tape.start, 1000, &mut Memory::default());
        assert_eq!(edited.text.as_deref(), Some(&b"G0 (\xe4\xff)"[..]));
    }

    #[test]
    fn more_than_one_word_of_rules() {
        let rules: Vec<(String, String)> = (0..130).map(|n| (format!("K{n:03}"), format!("L{n}"))).collect();
        let rules: Vec<(&str, &str)> = rules.iter().map(|(f, r)| (f.as_str(), r.as_str())).collect();
        let tape = tape(&rules);
        assert_eq!(edit(&tape, "K129 K063 K064").as_deref(), Some("L129 L63 L64"));
        assert_eq!(edit(&tape, "K130"), None);
    }
}
