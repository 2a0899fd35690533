//! The tape editor: rules that change the text of a block as it was read, before anything else looks at it.
//!
//! Facts: reference control-emulator.md 5.2. Invariants: every active rule is applied once, to its first match, in list
//! order, each to the result of the rules before it. A rule of words (`visible`) sees neither comments nor quoted texts
//! and cuts no name in two. A block that no rule matches costs one search for the texts that the rules need, and no
//! memory. A file in which none of these texts occurs costs one search in all.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use aho_corasick::AhoCorasick;
use counterpoint_lang::pattern::{STEPS, SearchMemory, TextPattern};

pub use super::rules::TapeRuleSet;
use super::source::ProgramSource;
use super::visible::{RemarkDelimiters, Visible};
use counterpoint_lang::fault::Outcome;
use counterpoint_lang::pattern::Match;
use counterpoint_machine::model::TapeRule;
use counterpoint_ports::control::StopSignal;

/// Steps of the searches of all rules in one block.
const MOST_STEPS: u64 = 2 * STEPS;

/// Longest file in whose text rules are looked for at once, bytes. In a longer one they are looked for by block, since
/// a program may end long before its text.
const LONGEST_FILE: usize = 1 << 20;

/// Numbers of tape editors.
static NUMBERS: AtomicU64 = AtomicU64::new(0);

/// The rules of a machine, compiled once.
#[derive(Debug)]
pub struct Tape {
    /// No other tape editor has this number.
    number: u64,
    rules: Vec<CompiledTapeRule>,
    /// The texts that rules need, and whose they are.
    needed: Option<(AhoCorasick, Vec<u16>)>,
    /// Rules that need no text: they are always tried.
    always: TapeRuleSet,
    /// All of them.
    every: TapeRuleSet,
    /// Rules that are on at program start.
    pub start: TapeRuleSet,
    /// The text that rules of words do not see.
    marks: RemarkDelimiters,
}

/// A compiled rule.
#[derive(Debug)]
struct CompiledTapeRule {
    pattern: TextPattern,
    replace: String,
    /// Text without which it does not match; empty: it needs none.
    needs: String,
    /// It sees words only.
    words: bool,
}

/// Rules that may match a text.
struct Candidates {
    rules: TapeRuleSet,
    /// Whether the text that each needs occurs in the text is not known.
    unsure: bool,
}

/// State of the rules while they are applied.
#[derive(Debug)]
pub struct Within<'a> {
    /// Rules that are on.
    pub on: &'a TapeRuleSet,
    /// Bytes that a result may have.
    pub longest: usize,
    /// No further rule is applied when the job is to end.
    pub stop: &'a StopSignal,
}

/// Result of editing a block.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct EditResult {
    /// New text, `None` when nothing matched.
    pub text: Option<Vec<u8>>,
    /// A rule that gave up: it needs too many steps on this text.
    pub stuck: Option<usize>,
    /// A rule whose result is too long, and its length; nothing of the block is changed.
    pub long: Option<(usize, usize)>,
    /// Bytes that rules have looked at and made.
    pub work: usize,
}

impl Tape {
    /// Compiles the rules of a machine whose text has these marks; `None` when there is none.
    pub fn new(rules: &[TapeRule], marks: RemarkDelimiters) -> Option<Self> {
        let (mut compiled, mut texts, mut owners) = (Vec::new(), Vec::new(), Vec::new());
        let (mut always, mut every, mut start) =
            (TapeRuleSet::default(), TapeRuleSet::default(), TapeRuleSet::default());
        for (number, rule) in rules.iter().enumerate() {
            // The loader has checked the expression.
            let Ok(pattern) = TextPattern::new(&rule.find) else { continue };
            let number = number.min(255);
            let mut needs = pattern.required();
            // Blocks are bytes: a character beyond ASCII may be written in two ways.
            if needs.is_empty() || !needs.is_ascii() {
                needs.clear();
                always.set(number, true);
            } else {
                texts.push(needs.clone());
                owners.push(number as u16);
            }
            every.set(number, true);
            start.set(number, rule.on);
            compiled.push(CompiledTapeRule { pattern, replace: rule.replace.clone(), needs, words: rule.words });
        }
        if compiled.is_empty() {
            return None;
        }
        let needed = AhoCorasick::builder().kind(Some(aho_corasick::AhoCorasickKind::DFA)).build(&texts);
        let number = NUMBERS.fetch_add(1, Relaxed);
        let needed = match needed {
            Ok(automaton) => Some((automaton, owners)),
            Err(_) => {
                owners.iter().for_each(|&owner| always.set(usize::from(owner), true));
                None
            }
        };
        Some(Self { number, rules: compiled, needed, always, every, start, marks })
    }

    /// Rules that may match a text. Where needed texts come up very often they are not looked for any further.
    fn candidates(&self, text: &[u8]) -> Candidates {
        let mut rules = self.always;
        if let Some((automaton, owners)) = &self.needed {
            for (count, found) in automaton.find_overlapping_iter(text).enumerate() {
                if count > text.len() + 64 {
                    return Candidates { rules: self.every, unsure: true };
                }
                if let Some(&owner) = owners.get(found.pattern().as_usize()) {
                    rules.set(usize::from(owner), true);
                }
            }
        }
        Candidates { rules, unsure: false }
    }

    /// Whether no rule that is on can match anywhere in the file: the text that it needs does not come up.
    #[inline]
    pub fn leaves_alone(&self, source: &ProgramSource, on: &TapeRuleSet) -> bool {
        if source.text().bytes().len() > LONGEST_FILE {
            return false;
        }
        let rules = source.tape_rules(self.number, |text| self.candidates(text).rules);
        rules.is_some_and(|rules| rules.is_apart(on))
    }

    /// Applies the rules that are on, within limits.
    #[inline]
    pub fn edit(&self, line: &[u8], limits: &Within<'_>, memory: &mut SearchMemory) -> EditResult {
        let candidates = self.candidates(line);
        match candidates.rules.next(0, limits.on) {
            None => EditResult::default(),
            Some(first) => self.apply(line, (first, candidates), limits, memory),
        }
    }

    fn apply(
        &self,
        line: &[u8],
        start: (usize, Candidates),
        limits: &Within<'_>,
        memory: &mut SearchMemory,
    ) -> EditResult {
        match std::str::from_utf8(line) {
            Ok(text) => {
                let (text, edited) = self.rewrite(text, start, limits, memory);
                EditResult { text: text.map(String::into_bytes), ..edited }
            }
            Err(_) => {
                // Eight-bit text: one character a byte.
                let text: String = line.iter().copied().map(char::from).collect();
                let (text, edited) = self.rewrite(&text, start, limits, memory);
                EditResult { text: text.map(|text| bytes(&text)), ..edited }
            }
        }
    }

    fn rewrite(
        &self,
        line: &str,
        (first, Candidates { mut rules, mut unsure }): (usize, Candidates),
        &Within { on, longest, stop }: &Within<'_>,
        memory: &mut SearchMemory,
    ) -> (Option<String>, EditResult) {
        let (mut text, mut edited): (Option<String>, _) = (None, EditResult::default());
        let (mut next, mut left) = (Some(first), MOST_STEPS);
        while let Some(number) = next.filter(|_| !stop.asked_once_resumed()) {
            let now = text.as_deref().unwrap_or(line);
            let rule = self.rules.get(number);
            edited.work += if unsure { now.len() } else { 0 };
            if let Some(rule) = rule.filter(|rule| !unsure || now.contains(&rule.needs)) {
                let CompiledTapeRule { replace, .. } = rule;
                let given = STEPS.min(left);
                let mut budget = given;
                edited.work += now.len();
                match self.find(rule, now, &mut budget, memory) {
                    Ok(None) => {}
                    Ok(Some(found)) => {
                        let (start, end) = found.whole();
                        let filled = TextPattern::filled(replace, now, &found);
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
                        // The texts of later rules are searched for when it is their turn.
                        (rules, unsure) = (self.every, true);
                        text = Some(changed);
                    }
                    Err(_) => edited.stuck = Some(number),
                }
                left -= given - budget;
                edited.work += usize::try_from(given - budget).unwrap_or(usize::MAX);
            }
            next = rules.next(number + 1, on);
        }
        (text.filter(|text| text != line), edited)
    }

    /// The first match of a rule; for a rule of words, the first match that consists of words.
    fn find(
        &self,
        rule: &CompiledTapeRule,
        text: &str,
        budget: &mut u64,
        memory: &mut SearchMemory,
    ) -> Outcome<Option<Match>> {
        if !rule.words {
            return rule.pattern.find_with(text, budget, memory);
        }
        let Visible { text, .. } = self.marks.visible(text);
        let mut found = rule.pattern.find_with(&text, budget, memory)?;
        while let Some(whole) = found.as_ref().map(Match::whole).filter(|whole| !self.marks.is_of_words(&text, *whole))
        {
            let behind = text.get(whole.0..).and_then(|rest| rest.chars().next()).map_or(1, char::len_utf8);
            found = rule.pattern.find(&text, whole.0 + behind, budget)?;
        }
        Ok(found)
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
        tape_of(rules, true)
    }

    fn tape_of(rules: &[(&str, &str)], words: bool) -> Tape {
        let rule = |(find, replace): &(&str, &str)| TapeRule {
            find: (*find).into(),
            replace: (*replace).into(),
            on: true,
            words,
            line: 0,
            file: String::new(),
        };
        Tape::new(&rules.iter().map(rule).collect::<Vec<_>>(), RemarkDelimiters::of([(";", "")], true)).unwrap()
    }

    #[test]
    fn a_file_is_left_alone_if_no_rule_that_is_on_finds_its_text() {
        let source = |text: &'static str| ProgramSource::new("a.mpf", text.into());
        let mut own = tape(&[("SPOS *=", "M19 SPOS="), ("WAITS", "")]);
        let on = own.start;
        assert!(own.leaves_alone(&source("G0 X1\nM30\n"), &on));
        assert!(!own.leaves_alone(&source("G0 X1\nSPOS=3\n"), &on));
        let mut off = on;
        off.set(0, false);
        assert!(own.leaves_alone(&source("G0 X1\nSPOS=3\n"), &off));
        // The findings of one tape editor do not apply to another; a rule without a text of its own is always tried.
        let other = tape(&[("WAITM", "")]);
        let shared = source("WAITM\n");
        assert!(own.leaves_alone(&shared, &on));
        assert!(!other.leaves_alone(&shared, &other.start));
        own = tape(&[("^", "N1 ")]);
        assert!(!own.leaves_alone(&source("M30\n"), &own.start));
    }

    fn within(tape: &Tape, line: &[u8], on: &TapeRuleSet) -> EditResult {
        tape.edit(line, &Within { on, longest: 1000, stop: &StopSignal::default() }, &mut SearchMemory::default())
    }

    #[test]
    fn no_rule_is_applied_when_the_job_is_to_end() {
        let (tape, stop) = (tape(&[("A", "B")]), StopSignal::default());
        stop.ask();
        let limits = Within { on: &tape.start, longest: 1000, stop: &stop };
        assert_eq!(tape.edit(b"A", &limits, &mut SearchMemory::default()), EditResult::default());
    }

    fn edit(tape: &Tape, line: &str) -> Option<String> {
        let edited = within(tape, line.as_bytes(), &tape.start);
        assert_eq!(edited.stuck, None);
        edited.text.map(|text| String::from_utf8(text).unwrap())
    }

    #[test]
    fn no_rule_makes_a_block_longer_than_it_may_be() {
        let rules: Vec<(&str, &str)> = vec![("\\(X.*\\)", "\\1\\1"); 24];
        let tape = tape(&rules);
        let edited = within(&tape, b"X0123456", &tape.start);
        assert_eq!((edited.text, edited.long), (None, Some((6, 1024))));
        assert!(edited.work < 20_000, "{}", edited.work);
    }

    #[test]
    fn texts_that_come_up_everywhere_are_not_counted() {
        let rules: Vec<(String, String)> = (1..100).map(|n| ("X".repeat(n), format!("{n}"))).collect();
        let rules: Vec<(&str, &str)> = rules.iter().map(|(f, r)| (f.as_str(), r.as_str())).collect();
        let tape = tape_of(&rules, false);
        let candidates = tape.candidates("X".repeat(200).as_bytes());
        assert!(candidates.unsure && candidates.rules == tape.every);
        // Each takes its own off: 1 + 2 + 3 … up to 19 of them.
        assert_eq!(edit(&tape, &"X".repeat(200)).map(|text| text.matches('X').count()), Some(10));
        assert_eq!(edit(&tape, "Y"), None);
    }

    #[test]
    fn each_rule_once_at_its_first_match_in_order() {
        let tape = tape(&[("^%$", ""), ("A", "B"), ("B", "C"), ("\\(X\\)\\([0-9]*\\)", "\\1=\\2")]);
        assert_eq!(edit(&tape, "%").as_deref(), Some(""));
        assert_eq!(edit(&tape, "% 1"), None);
        assert_eq!(edit(&tape, "A A").as_deref(), Some("C A"));
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
        assert_eq!(within(&tape, b"G1", &on).text, None);
        assert_eq!(within(&tape, b"G101", &on).text.as_deref(), Some(&b"G7"[..]));
    }

    #[test]
    fn eight_bit_text_stays_as_it_is() {
        let tape = tape(&[("G1", "G0")]);
        let edited = within(&tape, b"G1 (\xe4\xff)", &tape.start);
        assert_eq!(edited.text.as_deref(), Some(&b"G0 (\xe4\xff)"[..]));
    }

    #[test]
    fn a_rule_of_words_sees_no_text_and_no_part_of_a_name() {
        let tape = tape(&[("SPOS *=", "M19 SPOS="), ("\\(G7[0-2][^0-9].*\\)L", "\\1Q"), ("WAITS *$", "")]);
        assert_eq!(edit(&tape, "MSG(\"SPOS=90\")"), None);
        assert_eq!(edit(&tape, "X1 ; SPOS=90"), None);
        assert_eq!(edit(&tape, "ADISPOS=1 ZSPOS=2"), None);
        assert_eq!(edit(&tape, "ADISPOS=1 SPOS=2 ; SPOS=3").as_deref(), Some("ADISPOS=1 M19 SPOS=2 ; SPOS=3"));
        assert_eq!(edit(&tape, "G71 D1 L2 ; L3").as_deref(), Some("G71 D1 Q2 ; L3"));
        assert_eq!(edit(&tape, "WAITS ; here").as_deref(), Some("; here"));
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
