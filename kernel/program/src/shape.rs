//! How a machine separates the programs of a text: from a definition (`O2101`, `:2101`, `<NAME>`, `ONAME` on Okuma
//! controls) to the next one.
//!
//! Facts: reference control-emulator.md 5.4 (`<name>`), 5.7. Invariant: a shape looks at one line at a time.

use super::spot;
use super::syntax::{PLAIN, Syntax};
use counterpoint_machine::Machine;
use counterpoint_machine::model::is_rewind_stop;

/// One program of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ProgramRange {
    /// Number of its definition word.
    pub number: Option<u32>,
    /// First line, from 1.
    pub first: u32,
    /// Last line, inclusive.
    pub last: u32,
}

/// The rules for separating programs in a text, of the machine that reads it.
#[derive(Debug, Clone)]
pub struct ProgramDelimiters {
    syntax: &'static Syntax,
    /// Programs may have names in angle brackets.
    names: bool,
    /// Comments and messages, start and end.
    remarks: Vec<(Vec<u8>, Vec<u8>)>,
    rws: Vec<u8>,
    /// Text may be beside the rewind-stop.
    rws_inline: bool,
    eob: Option<u8>,
}

impl Default for ProgramDelimiters {
    fn default() -> Self {
        Self {
            syntax: &PLAIN,
            names: false,
            remarks: vec![(b"(".to_vec(), b")".to_vec())],
            rws: b"%".to_vec(),
            rws_inline: false,
            eob: None,
        }
    }
}

impl ProgramDelimiters {
    /// The default, with names in angle brackets.
    #[cfg(test)]
    pub(super) fn with_angle_names() -> Self {
        Self { names: true, ..Self::default() }
    }

    /// The syntax with which a machine reads its programs, including that of its pre-processor.
    #[must_use]
    pub fn of(machine: &Machine, syntax: &'static Syntax) -> Self {
        let format = &machine.format;
        let remarks = [&format.comment, &format.message].into_iter().flatten();
        let taken = remarks.clone().any(|(start, _)| start.starts_with('<'));
        Self {
            syntax,
            names: syntax.angle_names && !taken,
            remarks: remarks.map(|(start, end)| (start.clone().into(), end.clone().into())).collect(),
            rws: format.rws.clone().into(),
            rws_inline: format.rws_inline,
            eob: format.eob.and_then(|eob| u8::try_from(eob).ok()),
        }
    }

    /// The syntax of the pre-processor of the machine.
    #[must_use]
    pub fn syntax(&self) -> &'static Syntax {
        self.syntax
    }

    /// Where the blocks of a line begin.
    pub(super) fn block_starts(&self, line: &[u8]) -> impl Iterator<Item = usize> {
        spot::starts(line, self.eob, self.remarks.iter())
    }

    /// Whether a line is a rewind-stop.
    pub(super) fn is_stop(&self, line: &[u8]) -> bool {
        is_rewind_stop(&self.rws, self.rws_inline, line)
    }

    /// Whether something is in a line besides blanks, comments and a rewind-stop.
    pub(super) fn has_text(&self, line: &[u8]) -> bool {
        let blank = |byte: &u8| byte.is_ascii_whitespace() || Some(*byte) == self.eob;
        let header = self.syntax.named_programs.is_some_and(|names| (names.is_header)(line));
        !self.is_stop(line) && !header && !self.words(line).iter().all(blank)
    }

    /// A line without its comments and messages, in capitals.
    pub(super) fn words(&self, line: &[u8]) -> Vec<u8> {
        let (mut out, mut at) = (Vec::with_capacity(line.len()), 0);
        while let Some(&byte) = line.get(at) {
            let rest = line.get(at..).unwrap_or_default();
            let remark = self.remarks.iter().find(|(start, _)| !start.is_empty() && rest.starts_with(start));
            let Some((start, end)) = remark else {
                out.push(byte.to_ascii_uppercase());
                at += 1;
                continue;
            };
            let inside = at + start.len();
            let close = memchr::memmem::find(line.get(inside..).unwrap_or_default(), end).filter(|_| !end.is_empty());
            at = close.map_or(line.len(), |close| inside + close + end.len());
        }
        out
    }

    /// Every line that defines a program by its number has one of these; none if definitions have another form.
    pub(super) fn definition_letters(&self) -> Option<[u8; 3]> {
        self.syntax.named_programs.is_none().then_some([b'O', b'o', b':'])
    }

    /// Whether names in angle brackets may define programs.
    pub(super) fn has_angle_names(&self) -> bool {
        self.names
    }

    /// Few lines begin as a definition does; of the others nothing more is asked.
    #[inline]
    pub(super) fn may_define(&self, line: &[u8]) -> bool {
        let first = line.iter().find(|byte| !matches!(byte, b' ' | b'\t' | b'/'));
        self.syntax.named_programs.is_some() || matches!(first, Some(b'O' | b'o' | b':' | b'<'))
    }

    /// The number that a line defines a program by.
    pub(super) fn number(&self, line: &[u8]) -> Option<u32> {
        let number = leading_number(line, b'O').or_else(|| leading_number(line, b':'));
        number.filter(|_| self.syntax.numbered_programs)
    }

    /// The name that a line defines a program by.
    pub(super) fn name<'l>(&self, line: &'l [u8]) -> Option<&'l [u8]> {
        if let Some(names) = self.syntax.named_programs {
            return (names.defined)(line);
        }
        let at = line.iter().position(|byte| !matches!(byte, b' ' | b'\t' | b'/')).filter(|_| self.names)?;
        line.get(at + 1..program_name(line, at)? - 1)
    }
}

/// Where a program name in angle brackets that begins at `at` ends.
pub fn program_name(line: &[u8], at: usize) -> Option<usize> {
    const LONGEST: usize = 32;
    let rest = line.get(at..)?.strip_prefix(b"<")?;
    let length = rest.iter().take_while(|byte| byte.is_ascii_alphanumeric() || b"+-_.".contains(byte)).count();
    ((1..=LONGEST).contains(&length) && rest.get(length) == Some(&b'>')).then_some(at + length + 2)
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
