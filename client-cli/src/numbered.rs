//! Files named `O` and digits in a folder with many of them: only those that the job may call are taken.
//!
//! *Invariant:* a file is left out only if no text of the job computes the number of a call, no text has its number,
//! and no code of a machine calls it.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use crate::subprograms::after_count;

/// With at most this many such files in a folder, all of them are taken.
pub(crate) const FEW: usize = 100;

/// Numbers of the programs that codes of a machine call: custom G, M, T and S codes of Fanuc-like controls.
const OF_CODES: RangeInclusive<u32> = 8000..=9999;

/// A block that computes the number of the program it calls.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Computed {
    /// Name of the file inside the job.
    pub(crate) file: String,
    /// Its line, from 1.
    pub(crate) line: usize,
    /// Files beside it that are named by program numbers; all of them were taken.
    pub(crate) files: usize,
}

/// Files by number that no text of the job has called so far.
#[derive(Debug, Default)]
pub(crate) struct Numbered {
    files: BTreeMap<u32, Vec<String>>,
    /// Number of files at the start.
    count: usize,
    pub(crate) computed: Option<Computed>,
}

impl Numbered {
    pub(crate) fn new(files: BTreeMap<u32, Vec<String>>) -> Self {
        let count = files.values().map(Vec::len).sum();
        Self { files, count, computed: None }
    }

    /// Removes and returns the files that codes of a machine may call.
    pub(crate) fn take_of_codes(&mut self) -> Vec<String> {
        let numbers: Vec<u32> = self.files.range(OF_CODES).map(|(number, _)| *number).collect();
        numbers.iter().filter_map(|number| self.files.remove(number)).flatten().collect()
    }

    /// Removes and returns the files that a text may call: all of them if it computes the number of a call.
    pub(crate) fn take_called(&mut self, file: &str, text: &[u8]) -> Vec<String> {
        if self.files.is_empty() {
            return Vec::new();
        }
        if let Some(line) = computed_call(text) {
            let all: Vec<String> = std::mem::take(&mut self.files).into_values().flatten().collect();
            self.computed = Some(Computed { file: file.to_owned(), line, files: self.count });
            return all;
        }
        let mut called = Vec::new();
        for number in numbers(text) {
            called.extend(self.files.remove(&number).unwrap_or_default());
        }
        called
    }
}

/// Numbers in a text that may be program numbers: all except sequence numbers, variables and fractions. If a number has
/// more than four digits, also its last four: some controls put a repeat count before them (`P0051234`).
fn numbers(text: &[u8]) -> impl Iterator<Item = u32> {
    let mut rest = text;
    let mut before = b' ';
    std::iter::from_fn(move || {
        loop {
            let at = rest.iter().position(u8::is_ascii_digit)?;
            before = at.checked_sub(1).and_then(|at| rest.get(at)).copied().unwrap_or(before);
            let digits = rest.get(at..)?;
            let length = digits.iter().position(|byte| !byte.is_ascii_digit()).unwrap_or(digits.len());
            let (digits, after) = digits.split_at(length);
            rest = after;
            let skipped = matches!(before, b'N' | b'n' | b'#' | b'.');
            before = b'0';
            if !skipped {
                return Some(digits);
            }
        }
    })
    .flat_map(|digits| {
        let value = |digits: &[u8]| std::str::from_utf8(digits).ok().and_then(|digits| digits.parse().ok());
        [value(digits), after_count(digits).and_then(value)].into_iter().flatten()
    })
}

/// The first line that computes the number of the program it calls: `M98 P#1`, `G65 P[#2+1]`, `CALL O[…]`.
fn computed_call(text: &[u8]) -> Option<usize> {
    const CALLS: [&[u8]; 5] = [b"M98", b"M198", b"G65", b"G66", b"CALL"];
    text.split(|byte| *byte == b'\n')
        .position(|line| {
            let line = line.to_ascii_uppercase();
            let calls = CALLS.iter().any(|word| memchr::memmem::find(&line, word).is_some());
            calls && has_computed_number(&line)
        })
        .map(|at| at + 1)
}

/// Whether a line has a computed number after P or O.
fn has_computed_number(line: &[u8]) -> bool {
    let in_word = |at: usize| at.checked_sub(1).and_then(|at| line.get(at)).is_some_and(u8::is_ascii_alphabetic);
    memchr::memchr2_iter(b'P', b'O', line).filter(|at| !in_word(*at)).any(|at| {
        let rest = line.get(at + 1..).unwrap_or_default().trim_ascii_start();
        let rest = rest.strip_prefix(b"-").or(rest.strip_prefix(b"H")).unwrap_or(rest).trim_ascii_start();
        matches!(rest.first(), Some(b'#' | b'[' | b'='))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn many() -> Numbered {
        Numbered::new((1..=300).chain(9000..=9010).map(|n| (n, vec![format!("O{n:04}.nc")])).collect())
    }

    #[test]
    fn called_numbers_are_taken_and_sequence_numbers_are_not() {
        for (text, called) in [
            ("M98 P0100", "O0100.nc"),
            ("N200 M98P0030012", "O0012.nc"),
            ("CALL O77\nG65 P 5 A1", "O0005.nc O0077.nc"),
            ("N10 #12=1 X.25\nGOTO 300", "O0300.nc"),
            ("M98 <O0009>", "O0009.nc"),
            ("", ""),
        ] {
            let mut files = many().take_called("main.nc", text.as_bytes());
            files.sort();
            assert!(called.split(' ').filter(|name| !name.is_empty()).all(|name| files.iter().any(|f| f == name)));
            let most = called.split(' ').count() + 2;
            assert!(files.len() <= most, "{text}: {files:?}");
        }
        let mut files = many();
        assert_eq!(files.take_of_codes().len(), 11);
        assert!(files.take_called("a.nc", b"N10 N20\nN30").is_empty());
    }

    #[test]
    fn a_computed_call_takes_all() {
        for text in ["G0 X1\nM98 P#1", "G4 P#1\ng65 p[#2+1] A1", "\nM198 P#100"] {
            let mut files = many();
            assert_eq!(files.take_called("main.nc", text.as_bytes()).len(), 311, "{text}");
            let computed = files.computed.unwrap();
            assert_eq!((computed.file.as_str(), computed.line, computed.files), ("main.nc", 2, 311));
        }
        for text in ["G4 P#1", "M98 P100 (no #)", "G10 L2 P[#1]"] {
            let mut files = many();
            files.take_called("main.nc", text.as_bytes());
            assert_eq!(files.computed, None, "{text}");
        }
    }
}
