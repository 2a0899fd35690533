//! Programs inside a file: from a definition (`O2101`, `:2101`, `<NAME>`) to the next one.
//!
//! Facts: reference control-emulator.md 5.4 (`<name>`), 5.7. Invariant: a line that no program owns stands before the
//! first definition.

use super::source::Source;
use crate::machine::Machine;
use crate::machine::ident::codes;
use crate::machine::model::{CodeForm, Preprocessor};

/// One program of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Range {
    /// Number of its definition word.
    pub number: Option<u32>,
    /// First line, from 1.
    pub first: u32,
    /// Last line, inclusive.
    pub last: u32,
}

/// What tells programs in a text apart, of the machine that reads it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Shape {
    /// Programs may have names in angle brackets.
    names: bool,
}

impl Shape {
    /// As a machine reads its programs.
    #[must_use]
    pub fn of(machine: &Machine) -> Self {
        let format = &machine.format;
        let taken = [&format.comment, &format.message].into_iter().flatten().any(|(start, _)| start.starts_with('<'));
        Self { names: machine.preprocessor == Preprocessor::Fanuc && !taken }
    }

    /// The name that a line defines a program by.
    pub(super) fn name<'l>(&self, line: &'l [u8]) -> Option<&'l [u8]> {
        let at = line.iter().position(|byte| !matches!(byte, b' ' | b'\t' | b'/')).filter(|_| self.names)?;
        line.get(at + 1..program_name(line, at)? - 1)
    }
}

/// Where a program name in angle brackets that begins at `at` ends.
pub(crate) fn program_name(line: &[u8], at: usize) -> Option<usize> {
    const LONGEST: usize = 32;
    let rest = line.get(at..)?.strip_prefix(b"<")?;
    let length = rest.iter().take_while(|byte| byte.is_ascii_alphanumeric() || b"+-_.".contains(byte)).count();
    ((1..=LONGEST).contains(&length) && rest.get(length) == Some(&b'>')).then_some(at + length + 2)
}

/// Finds the programs of a file. Lines before the first definition word belong to the first program only if there
/// is no definition word at all.
pub(super) fn ranges(source: &Source, shape: &Shape) -> Vec<Range> {
    let mut found: Vec<Range> = Vec::new();
    let last = source.lines();
    for line in 1..=last {
        let text = source.line(line);
        let number = leading_number(text, b'O').or_else(|| leading_number(text, b':'));
        if number.is_some() || shape.name(text).is_some() {
            if let Some(previous) = found.last_mut() {
                previous.last = line - 1;
            }
            found.push(Range { number, first: line, last });
        }
    }
    if found.is_empty() && last > 0 {
        found.push(Range { number: None, first: 1, last });
    }
    found
}

/// The number after `letter` when the line begins with it (after blanks and optional-skip marks).
pub(super) fn leading_number(line: &[u8], letter: u8) -> Option<u32> {
    let mut bytes = line.iter().copied().skip_while(|b| matches!(b, b' ' | b'\t' | b'/')).peekable();
    if bytes.next()?.to_ascii_uppercase() != letter {
        return None;
    }
    let mut value: Option<u32> = None;
    for byte in bytes {
        match byte {
            b'0'..=b'9' => {
                value = Some(value.unwrap_or(0).checked_mul(10)?.checked_add(u32::from(byte - b'0'))?);
            }
            b' ' if value.is_none() => {}
            _ => break,
        }
    }
    value
}

/// The words by which programs of a machine call others, seen textually.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Callers {
    words: Vec<String>,
    /// First and last number of the programs that single words call.
    numbers: Vec<(u32, u32)>,
}

/// Programs that a text calls.
#[derive(Debug, Default)]
pub(super) struct Called {
    numbers: Vec<u32>,
    names: Vec<Vec<u8>>,
}

impl Called {
    /// It calls the program that begins in this line.
    pub(super) fn has(&self, source: &Source, range: Range) -> bool {
        match (range.number, source.name_at(range.first)) {
            (Some(number), _) => self.numbers.contains(&number),
            (None, Some(name)) => self.names.iter().any(|called| called.eq_ignore_ascii_case(name)),
            (None, None) => false,
        }
    }
}

impl Callers {
    /// Of a machine: words of its code table that call by number, calls of its pre-processor, words that call.
    pub(crate) fn of(machine: &Machine) -> Self {
        let mut words: Vec<String> = Vec::new();
        for row in machine.codes.iter().filter(|row| row.enable && row.id == codes::CALSUB_ID) {
            match &row.form {
                CodeForm::Text(text) => words.push(text.to_ascii_uppercase()),
                CodeForm::Register { register, min, .. } | CodeForm::RegisterAsData { register, min, .. } => {
                    // A row that comes before it takes the word away (M198 may be a waiting code).
                    let first = machine.tables.code(*register, *min).first();
                    let acts = first.and_then(|&row| machine.codes.get(usize::from(row))).map(|row| row.id);
                    let letter = machine.registers.get(usize::from(*register)).filter(|_| acts == Some(row.id));
                    words.extend(letter.map(|letter| format!("{}{min}", letter.name)));
                }
                CodeForm::NotApplicable => {}
            }
        }
        if machine.preprocessor == Preprocessor::Fanuc {
            words.extend(["G65", "G66"].map(str::to_owned));
        }
        let numbers = machine.subprograms.calls.iter().map(crate::machine::model::WordCall::programs).collect();
        Self { words, numbers }
    }

    /// Programs that the lines of a range call.
    pub(super) fn called(&self, source: &Source, range: Range, into: &mut Called) {
        for line in range.first..=range.last {
            let text = source.line(line).to_ascii_uppercase();
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
                into.names.extend(name.map(<[u8]>::to_vec));
            }
        }
    }

    /// A word by itself calls this program.
    pub(super) fn by_word(&self, range: Range) -> bool {
        let within = |number: u32| self.numbers.iter().any(|(first, last)| (first..=last).contains(&&number));
        range.number.is_some_and(within)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;

    #[test]
    fn programs_of_a_file() {
        let source = Source::new("t", b"%\nO2101 (A)\nG1\nM99\nO2102\nM98 P0031000\nM30\n%".as_slice().into());
        let found = source.programs();
        assert_eq!(found.len(), 2);
        assert_eq!((found[0].number, found[0].first, found[0].last), (Some(2101), 2, 4));
        assert_eq!((found[1].number, found[1].first, found[1].last), (Some(2102), 5, 8));
        let callers = Callers { words: vec!["M98".to_owned()], numbers: Vec::new() };
        let mut called = Called::default();
        callers.called(&source, found[1], &mut called);
        assert_eq!(called.numbers, [31000, 1000]);
        assert_eq!(source.sequence_lines(10), [0_u32; 0]);
    }

    #[test]
    fn programs_by_name() {
        let text = b"O1\nM98 <Face.2>\n<FACE.2> (second)\nM99\n<a b>\n<>\n".as_slice();
        let source = Source::shaped("t", text.into(), Arc::new(Shape { names: true }));
        let found = source.programs();
        assert_eq!(found, [Range { number: Some(1), first: 1, last: 2 }, Range { number: None, first: 3, last: 6 }]);
        assert_eq!(source.named("face.2"), Some(found[1]));
        assert_eq!(source.named("face"), None);
        let callers = Callers { words: vec!["M98".to_owned()], numbers: Vec::new() };
        let mut called = Called::default();
        callers.called(&source, found[0], &mut called);
        assert!(called.has(&source, found[1]));
    }

    #[test]
    fn a_file_without_definition_is_one_program() {
        let source = Source::new("t", b"N10 G1\nN20 M30\n".as_slice().into());
        assert_eq!(source.programs(), [Range { number: None, first: 1, last: 2 }]);
        assert_eq!(source.sequence_lines(20), [2]);
    }
}
