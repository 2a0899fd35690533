//! Texts that the scanner searches for before it reads a word by its letter: special registers, second names of more
//! than a letter, and texts that look like words.
//!
//! Facts: reference control-emulator.md 1.2 (ALT string), 1.4 (special registers). Lines with expressions look for the
//! same (`dialect`). Invariant: longer texts are tried first, so that `C1=` is not hidden by a register `C`; only those
//! that begin with the byte in question are tried; a machine with neither has nothing here.

use super::by_first::{ByFirst, Literals};
use counterpoint_machine::Machine;
use counterpoint_machine::index::{CodeRowId, RegisterId};
use counterpoint_machine::rows::CodeForm;

/// Special registers and texts, prepared once.
#[derive(Debug)]
pub struct LiteralFirst {
    /// Literal texts that a register would read as a word, with their rows.
    texts: Literals,
    /// Special registers with a text before the number.
    registers: ByFirst<PrefixRegister>,
    /// Those without.
    bare: Vec<PrefixRegister>,
    /// Tools by name, in capital letters.
    tools: Vec<(Vec<u8>, u32)>,
    /// Bytes that any of them begins with.
    first: [u64; 4],
}

/// A register with text around its number.
#[derive(Debug)]
pub struct PrefixRegister {
    /// Text before the number.
    pub before: Vec<u8>,
    /// Text after the number.
    pub after: Vec<u8>,
    /// The register.
    pub register: RegisterId,
    /// Written with the second (incremental) name of the register.
    pub incremental: bool,
    /// A tool's name may be in place of the number.
    pub names: bool,
}

/// First character of a value at a place, without blanks and signs.
fn first_of_value(line: &[u8], at: usize) -> Option<u8> {
    line.get(at..)?.iter().copied().find(|byte| !b" \t+-".contains(byte))
}

/// Whether a number, a variable or a bracket is at a place, with or without a sign.
pub fn starts_value(line: &[u8], at: usize) -> bool {
    matches!(first_of_value(line, at), Some(b'0'..=b'9' | b'.' | b'#' | b'['))
}

/// Whether a variable or a bracket is at a place, with or without a sign.
pub fn starts_expression(line: &[u8], at: usize) -> bool {
    matches!(first_of_value(line, at), Some(b'#' | b'['))
}

impl PrefixRegister {
    /// Whether the text before the number is at a place, with something after it that may have a value.
    pub fn has_value(&self, line: &[u8], at: usize) -> bool {
        line.get(at..).is_some_and(|rest| rest.starts_with(&self.before)) && starts_value(line, at + self.before.len())
    }
}

impl LiteralFirst {
    /// The prefix registers of a machine, if it has any.
    pub fn new(machine: &Machine) -> Option<Box<Self>> {
        let mut registers = Vec::new();
        for (register, definition) in machine.registers.entries() {
            let regular = definition.is_regular();
            let after = definition.after.clone().into_bytes();
            let first = Some((&definition.before, false)).filter(|_| !regular);
            let second = definition.second.as_ref().map(|second| (second, true));
            // A letter is found as one.
            let second = second.filter(|(second, _)| !(regular && second.len() == 1));
            for (before, incremental) in [first, second].into_iter().flatten() {
                let before = before.clone().into_bytes();
                let names = definition.names;
                registers.push(PrefixRegister { before, after: after.clone(), register, incremental, names });
            }
        }
        registers.sort_by_key(|prefix| usize::MAX - prefix.before.len());
        let mut texts = Vec::new();
        for &row in &machine.tables.texts {
            if let CodeForm::Text(text) = &machine.codes[row].form
                && looks_like_word(text.as_bytes())
            {
                texts.push((text.clone().into_bytes(), row));
            }
        }
        if registers.is_empty() && texts.is_empty() {
            return None;
        }
        let mut first = [0u64; 4];
        let mut mark = |byte: u8| {
            if let Some(bits) = first.get_mut(usize::from(byte >> 6)) {
                *bits |= 1 << (byte & 63);
            }
        };
        texts.iter().filter_map(|(text, _)| text.first()).for_each(|&byte| mark(byte));
        for prefix in &registers {
            match prefix.before.first() {
                Some(&byte) => mark(byte),
                None => b"0123456789.+-".iter().for_each(|&byte| mark(byte)),
            }
        }
        let tools = machine.tool.names.iter().map(|(name, number)| (name.clone().into_bytes(), *number)).collect();
        let (bare, registers) = registers.into_iter().partition(|prefix: &PrefixRegister| prefix.before.is_empty());
        Some(Box::new(Self {
            texts: ByFirst::new(texts, |(text, _)| text),
            registers: ByFirst::new(registers, |prefix| &prefix.before),
            bare,
            tools,
            first,
        }))
    }

    /// A literal text at a place, with its row.
    pub fn text(&self, line: &[u8], at: usize) -> Option<(&[u8], CodeRowId)> {
        let found = self.texts(*line.get(at)?).iter().find(|(text, _)| stands(text, line, at));
        found.map(|(text, row)| (text.as_slice(), *row))
    }

    /// Special registers at a place, each with something after its text that may have a value.
    pub fn registers_at<'a>(&'a self, line: &'a [u8], at: usize) -> impl Iterator<Item = &'a PrefixRegister> {
        let byte = line.get(at).copied().unwrap_or_default();
        self.registers(byte).filter(move |prefix| prefix.has_value(line, at))
    }

    /// Literal texts that begin with a byte, with their rows.
    fn texts(&self, byte: u8) -> &[(Vec<u8>, CodeRowId)] {
        self.texts.of(byte)
    }

    /// Special registers whose text before the number begins with a byte, then those without such a text.
    pub(crate) fn registers(&self, byte: u8) -> impl Iterator<Item = &PrefixRegister> {
        self.registers.of(byte).iter().chain(&self.bare)
    }

    /// Whether a special register with a variable or an expression in place of its number is at a place.
    pub fn opens_statement(&self, line: &[u8], at: usize) -> bool {
        let Some(&byte) = line.get(at) else { return false };
        self.registers(byte)
            .any(|prefix| starts_expression(line, at + prefix.before.len()) && prefix.has_value(line, at))
    }

    /// The tool that a name between the texts of a register stands for, and where they end; letter case does not count.
    pub fn tool(&self, prefix: &PrefixRegister, line: &[u8], from: usize) -> Option<(u32, usize)> {
        let length = memchr::memmem::find(line.get(from..)?, &prefix.after)?;
        let name = line.get(from..from + length)?.trim_ascii();
        let (_, number) = self.tools.iter().find(|(known, _)| known.eq_ignore_ascii_case(name))?;
        Some((*number, from + length + prefix.after.len()))
    }

    /// Whether one of them may begin with this byte.
    #[inline(always)]
    pub fn may_start(&self, byte: u8) -> bool {
        self.first.get(usize::from(byte >> 6)).is_some_and(|bits| bits >> (byte & 63) & 1 != 0)
    }
}

/// A letter and a digit, a sign or a point.
fn looks_like_word(text: &[u8]) -> bool {
    matches!(text, [letter, next, ..] if letter.is_ascii_alphabetic() && !next.is_ascii_alphabetic())
}

/// Whether a literal text is at a place: one that ends in a digit is not the beginning of a longer number.
pub fn stands(text: &[u8], line: &[u8], at: usize) -> bool {
    let Some(rest) = line.get(at..).and_then(|rest| rest.strip_prefix(text)) else { return false };
    let digit_ends = text.last().is_some_and(u8::is_ascii_digit);
    !(digit_ends && matches!(rest.first(), Some(b'0'..=b'9' | b'.')))
}
