//! Programs inside a file: from a definition word (`O2101`, `:2101`) to the next one.

use super::source::Source;

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

/// Finds the programs of a file. Lines before the first definition word belong to the first program only if there
/// is no definition word at all.
pub(super) fn ranges(source: &Source) -> Vec<Range> {
    let mut found: Vec<Range> = Vec::new();
    let last = source.lines();
    for line in 1..=last {
        let text = source.line(line);
        if let Some(number) = leading_number(text, b'O').or_else(|| leading_number(text, b':')) {
            if let Some(previous) = found.last_mut() {
                previous.last = line - 1;
            }
            found.push(Range { number: Some(number), first: line, last });
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

/// Numbers of the programs that a program text calls: `M98 P…`, `G65 P…`, `G66 P…`, seen textually.
#[must_use]
pub fn calls(source: &Source, range: Range) -> Vec<u32> {
    let mut out = Vec::new();
    for line in range.first..=range.last {
        let text = source.line(line).to_ascii_uppercase();
        let calls =
            [b"M98".as_slice(), b"G65", b"G66", b"M198"].iter().any(|code| memchr::memmem::find(&text, code).is_some());
        if !calls {
            continue;
        }
        for at in memchr::memchr_iter(b'P', &text) {
            if let Some(number) = leading_number(text.get(at..).unwrap_or_default(), b'P') {
                out.push(number);
                out.push(number % 10_000);
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn programs_of_a_file() {
        let source = Source::new("t", b"%\nO2101 (A)\nG1\nM99\nO2102\nM98 P0031000\nM30\n%".as_slice().into());
        let found = ranges(&source);
        assert_eq!(found.len(), 2);
        assert_eq!((found[0].number, found[0].first, found[0].last), (Some(2101), 2, 4));
        assert_eq!((found[1].number, found[1].first, found[1].last), (Some(2102), 5, 8));
        assert_eq!(calls(&source, found[1]), [31000, 1000]);
        assert_eq!(source.sequence_lines(10), [0_u32; 0]);
    }

    #[test]
    fn a_file_without_definition_is_one_program() {
        let source = Source::new("t", b"N10 G1\nN20 M30\n".as_slice().into());
        assert_eq!(ranges(&source), [Range { number: None, first: 1, last: 2 }]);
        assert_eq!(source.sequence_lines(20), [2]);
    }
}
