//! Calls and ends of the programs of a machine, as far as their text shows.
//!
//! Facts: reference control-emulator.md 5.7. Invariant: nothing is executed; a call whose number is computed is not
//! seen.

use rustc_hash::FxHashSet;

use super::shape::{ProgramRange, leading_number, program_name};
use super::source::ProgramSource;
use super::syntax::{NamedPrograms, Syntax};
use counterpoint_machine::Machine;
use counterpoint_machine::ident::codes;
use counterpoint_machine::rows::CodeForm;

/// The words by which programs of a machine call others and end, seen textually.
#[derive(Debug, Clone)]
pub struct Callers {
    words: Vec<String>,
    /// Words that end a program or return from it.
    ends: Vec<(u8, u32)>,
    /// Texts that do.
    end_texts: Vec<String>,
    /// First and last number of the programs that single words call.
    numbers: Vec<(u32, u32)>,
    /// Statements that call by name.
    named: Option<NamedPrograms>,
}

/// Programs that a text calls.
#[derive(Debug, Default)]
pub(super) struct CalledPrograms {
    numbers: FxHashSet<u32>,
    /// In capitals.
    names: FxHashSet<Vec<u8>>,
}

impl CalledPrograms {
    /// Whether it calls the program that begins in this line.
    pub(super) fn has(&self, source: &ProgramSource, range: ProgramRange) -> bool {
        match (range.number, source.name_at(range.first)) {
            (Some(number), _) => self.numbers.contains(&number),
            (None, Some(name)) => self.names.contains(&name.to_ascii_uppercase()),
            (None, None) => false,
        }
    }
}

impl Callers {
    /// Of a machine: words of its code table that call by number, calls of its pre-processor, words that call.
    pub fn of(machine: &Machine, syntax: &Syntax) -> Self {
        let mut words: Vec<String> = Vec::new();
        for row in machine.codes.iter().filter(|row| row.enable && row.id == codes::CALSUB_ID) {
            match &row.form {
                CodeForm::Text(text) => words.push(text.to_ascii_uppercase()),
                CodeForm::Register { register, min, .. } | CodeForm::RegisterAsData { register, min, .. } => {
                    // A row that comes before it takes the word away (M198 may be a waiting code).
                    let first = machine.tables.code(*register, *min).first();
                    let acts = first.map(|&row| machine.codes[row].id);
                    let letter = Some(&machine.registers[*register]).filter(|_| acts == Some(row.id));
                    words.extend(letter.map(|letter| format!("{}{min}", letter.name)));
                }
                CodeForm::NotApplicable => {}
            }
        }
        words.extend(syntax.call_words.iter().map(|word| (*word).to_owned()));
        let numbers = machine.subprograms.calls.iter().map(counterpoint_machine::model::WordCall::programs).collect();
        let (mut ends, mut end_texts) = (Vec::new(), Vec::new());
        let closing = [codes::END, codes::REWIND, codes::CALSUB_RETURN];
        for row in machine.codes.iter().filter(|row| row.enable && closing.contains(&row.id)) {
            match &row.form {
                CodeForm::Text(text) => end_texts.push(text.to_ascii_uppercase()),
                CodeForm::Register { register, min, .. } | CodeForm::RegisterAsData { register, min, .. } => {
                    let letter = machine.registers[*register].name.bytes().next();
                    ends.extend(letter.filter(|_| min.fract() == 0.0).map(|letter| (letter, *min as u32)));
                }
                CodeForm::NotApplicable => {}
            }
        }
        Self { words, ends, end_texts, numbers, named: syntax.named_programs }
    }

    /// Whether a line of a range ends a program or returns.
    pub fn ends_in(&self, source: &ProgramSource, range: ProgramRange) -> bool {
        source.walk(range.first, range.last).any(|line| {
            let text = source.words(line);
            let ends = |&(letter, number): &(u8, u32)| {
                let at = |at: usize| leading_number(text.get(at..).unwrap_or_default(), letter) == Some(number);
                memchr::memchr_iter(letter, &text).any(at)
            };
            self.ends.iter().any(ends)
                || self.end_texts.iter().any(|end| memchr::memmem::find(&text, end.as_bytes()).is_some())
        })
    }

    /// Programs that the lines of a range call.
    pub(super) fn called(&self, source: &ProgramSource, range: ProgramRange, into: &mut CalledPrograms) {
        for line in source.walk(range.first, range.last) {
            let text = source.words(line);
            if let Some(name) = self.named.and_then(|names| (names.called)(&text)) {
                match name.parse() {
                    Ok(number) => into.numbers.insert(number),
                    Err(_) => into.names.insert(name.to_ascii_uppercase().into()),
                };
                continue;
            }
            if !self.words.iter().any(|word| memchr::memmem::find(&text, word.as_bytes()).is_some()) {
                continue;
            }
            for at in memchr::memchr_iter(b'P', &text) {
                if let Some(number) = leading_number(text.get(at..).unwrap_or_default(), b'P') {
                    into.numbers.extend([number, number % 10_000]);
                }
            }
            for at in memchr::memchr_iter(b'<', &text) {
                let name = program_name(&text, at).and_then(|end| text.get(at + 1..end - 1));
                into.names.extend(name.map(<[u8]>::to_ascii_uppercase));
            }
        }
    }

    /// Whether the program says itself that it is a subprogram.
    pub(super) fn returns(&self, source: &ProgramSource, range: ProgramRange) -> bool {
        self.named
            .is_some_and(|names| source.walk(range.first, range.last).any(|line| (names.returns)(source.line(line))))
    }

    /// Channel and number of a program of a job archive.
    pub(super) fn in_archive(&self, source: &ProgramSource, range: ProgramRange) -> Option<(u16, u32)> {
        let named = self.named.and_then(|names| names.in_archive)?;
        source.walk(range.first, range.last).find_map(|line| named(source.line(line)))
    }

    /// Whether a word by itself calls this program.
    pub(super) fn by_word(&self, range: ProgramRange) -> bool {
        let within = |number: u32| self.numbers.iter().any(|(first, last)| (first..=last).contains(&&number));
        range.number.is_some_and(within)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::shape::ProgramDelimiters;
    use crate::spot::BlockStart;
    use counterpoint_ports::control::StopSignal;

    fn callers() -> Callers {
        let ends = vec![(b'M', 2), (b'M', 30)];
        Callers { words: vec!["M98".to_owned()], ends, end_texts: Vec::new(), numbers: Vec::new(), named: None }
    }

    #[test]
    fn text_before_the_first_definition() {
        let programs = |text: &str| ProgramSource::new("t", text.to_owned().into()).programs().to_vec();
        let heading = ProgramRange { number: None, first: 1, last: 2 };
        assert_eq!(programs("G0 X1\nM30\nO2\nM99")[0], heading);
        assert_eq!(programs("(only a comment)\n\n%\n(another)\nO2\nM99").len(), 1);
        assert_eq!(programs("LEADER\n%\nO2\nM99").len(), 1);
        assert_eq!(programs("%\n(part) G0 X1\nO2\nM99")[0], ProgramRange { number: None, first: 2, last: 2 });
        let source = ProgramSource::new("t", "G0 X1 (M30)\nM20\nM02\n".to_owned().into());
        assert!(callers().ends_in(&source, ProgramRange { number: None, first: 1, last: 3 }));
        assert!(!callers().ends_in(&source, heading));
    }

    #[test]
    fn programs_of_a_file() {
        let source = ProgramSource::new("t", b"%\nO2101 (A)\nG1\nM99\nO2102\nM98 P0031000\nM30\n%".as_slice().into());
        let found = source.programs();
        assert_eq!(found.len(), 2);
        assert_eq!((found[0].number, found[0].first, found[0].last), (Some(2101), 2, 4));
        assert_eq!((found[1].number, found[1].first, found[1].last), (Some(2102), 5, 8));
        let callers = callers();
        let mut called = CalledPrograms::default();
        callers.called(&source, found[1], &mut called);
        assert_eq!(called.numbers, FxHashSet::from_iter([31000, 1000]));
        assert!(source.sequences(10).is_empty());
    }

    #[test]
    fn programs_by_name() {
        let text = b"O1\nM98 <Face.2>\n<FACE.2> (second)\nM99\n<a b>\n<>\n".as_slice();
        let source = ProgramSource::shaped(
            "t",
            text.into(),
            Arc::new(ProgramDelimiters::with_angle_names()),
            StopSignal::default(),
        );
        let found = source.programs();
        assert_eq!(
            found,
            [ProgramRange { number: Some(1), first: 1, last: 2 }, ProgramRange { number: None, first: 3, last: 6 }]
        );
        assert_eq!(source.named("face.2"), Some(found[1]));
        assert_eq!(source.named("face"), None);
        let callers = callers();
        let mut called = CalledPrograms::default();
        callers.called(&source, found[0], &mut called);
        assert!(called.has(&source, found[1]));
    }

    #[test]
    fn a_file_without_definition_is_one_program() {
        let source = ProgramSource::new("t", b"N10 G1\nN20 M30\n".as_slice().into());
        assert_eq!(source.programs(), [ProgramRange { number: None, first: 1, last: 2 }]);
        assert_eq!(source.sequences(20), [BlockStart::line(2)]);
    }
}
