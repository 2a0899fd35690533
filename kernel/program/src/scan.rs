//! From the text of a line to words.
//!
//! Facts: reference control-emulator.md 1.2, 1.4. Invariant: one pass over the line, nothing copied; text that is not a
//! word of a register is kept as unknown text.

mod marks;
mod numbers;
mod passed;

use crate::block::{Block, Word, irregular};
use crate::by_first::{ByFirst, Literals};
use crate::key_words::{Formulas, StatementVocabulary, WrittenNumber, key_word};
use crate::line_up::LineUp;
use crate::prefix_registers::{self, LiteralFirst};
use crate::shape::program_name;
use crate::syntax::Syntax;
use counterpoint_fault as diag;
use counterpoint_machine::Machine;
use counterpoint_machine::index::{CodeRowId, IdTable, RegisterId};
use counterpoint_machine::rows::{CodeForm, Register};
use numbers::{Read, parse_digits, parse_number};

/// Result of scanning a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ScanResult {
    /// Plain words, now in the block.
    Words,
    /// A statement, or words with expressions: it needs the pre-processor.
    Statement,
}

/// Data of the machine for the scanner, prepared once.
#[derive(Debug)]
pub struct LineScanner {
    comment: Option<(Vec<u8>, Vec<u8>)>,
    message: Option<(Vec<u8>, Vec<u8>)>,
    opskip: Option<u8>,
    opskip_default: u8,
    eob: Option<u8>,
    /// Literal text codes: text and row.
    texts: Literals,
    /// First character of words at which systems line up, and their row.
    line_up: Option<(u8, CodeRowId)>,
    /// How numbers of each register are read, in primary and in secondary units.
    reads: IdTable<RegisterId, [Read; 2]>,
    syntax: &'static Syntax,
    /// Active optional-skip levels, bit n.
    levels: u16,
    sequence: Option<RegisterId>,
    /// Register of program numbers, which a colon may stand for at the start of a block.
    definition: Option<RegisterId>,
    /// How expressions are written.
    formulas: Formulas,
    letters: [Option<(RegisterId, bool)>; 128],
    /// Special registers, and texts that would be read as words; `None` on most machines.
    literal_first: Option<Box<LiteralFirst>>,
}

impl LineScanner {
    /// For a machine, the syntax of its pre-processor and the active optional-skip levels.
    pub fn new(machine: &Machine, syntax: &'static Syntax, opskip: &[u8]) -> Self {
        let pair =
            |p: &Option<(String, String)>| p.as_ref().map(|(a, b)| (a.clone().into_bytes(), b.clone().into_bytes()));
        let ascii = |c: Option<char>| c.and_then(|c| u8::try_from(c).ok());
        let mut letters = machine.tables.letter;
        for lower in b'a'..=b'z' {
            let upper = letters.get(usize::from(lower - 32)).copied().flatten();
            if let Some(slot) = letters.get_mut(usize::from(lower))
                && slot.is_none()
            {
                *slot = upper;
            }
        }
        let register_of = |id| machine.data.iter().find(|row| row.id == id && row.enable).and_then(|row| row.register);
        let sequence = register_of(counterpoint_machine::ident::data::SEQNO);
        // Elsewhere the colon is the letter of main blocks.
        let definition = register_of(counterpoint_machine::ident::data::DEFSUB_ID).filter(|_| syntax.numbered_programs);
        Self {
            comment: pair(&machine.format.comment),
            message: pair(&machine.format.message),
            opskip: ascii(machine.format.opskip_mark),
            opskip_default: machine.format.opskip_default,
            eob: ascii(machine.format.eob),
            line_up: line_up(machine),
            texts: literals(machine),
            reads: machine.registers.map(|_, register| reads(machine, register)),
            syntax,
            levels: levels(machine, opskip),
            sequence,
            definition,
            formulas: Formulas {
                brackets: machine.habits.brackets,
                bare_sums: machine.habits.bare_sums,
                bare_conditions: machine.habits.bare_conditions,
                full_angles: machine.habits.full_angles,
                loops: machine.habits.loops,
                one_then: machine.habits.one_then,
                macro_then: machine.habits.macro_then,
                digits_of_numbers: machine.habits.digits_of_numbers,
            },
            letters,
            literal_first: LiteralFirst::new(machine),
        }
    }

    /// The syntax of the pre-processor.
    pub fn syntax(&self) -> &'static Syntax {
        self.syntax
    }

    /// Whether the machine has a pre-processor.
    pub fn has_preprocessor(&self) -> bool {
        self.syntax.has_preprocessor()
    }

    /// Statements are mixed with words: custom macro.
    #[inline(always)]
    pub fn has_custom_macro(&self) -> bool {
        self.syntax.key_words.is_some()
    }

    /// Whether the levels of optional skip that are on include this one; `None` is the one that a mark without number
    /// means.
    pub fn skips(&self, level: Option<u8>) -> bool {
        self.levels & 1 << level.unwrap_or(self.opskip_default).min(15) != 0
    }

    /// Whether the machine has operator messages.
    pub fn has_messages(&self) -> bool {
        self.message.is_some()
    }

    /// Active optional-skip levels, bit by level.
    pub fn levels(&self) -> u16 {
        self.levels
    }

    /// Register of the sequence number.
    pub fn sequence(&self) -> Option<RegisterId> {
        self.sequence
    }

    /// Names of words of lines with expressions, other than letters.
    pub fn names(&self) -> StatementVocabulary<'_> {
        StatementVocabulary {
            literal_first: self.literal_first.as_deref(),
            texts: Some(&self.texts),
            formulas: self.formulas,
            key_words: self.syntax.key_words.unwrap_or_default(),
        }
    }

    /// Register of a letter, with its incremental flag.
    pub fn register(&self, letter: u8) -> Option<(RegisterId, bool)> {
        self.letters.get(usize::from(letter)).copied().flatten()
    }

    /// Splits `line` into `block` (which is cleared first); `watched` leaves all of it to another pre-processor.
    #[inline(always)]
    pub fn scan(&self, line: &[u8], secondary: bool, block: &mut Block, watched: bool) -> ScanResult {
        if self.syntax.needs_interpreter.is_some_and(|needs| watched || needs(line)) {
            return ScanResult::Statement;
        }
        self.split(line, secondary, block, self.has_custom_macro())
    }

    /// The same, with or without the pre-processor.
    #[inline(never)]
    pub fn scan_as(&self, line: &[u8], secondary: bool, block: &mut Block, preprocess: bool) -> ScanResult {
        if preprocess && self.syntax.needs_interpreter.is_some_and(|needs| needs(line)) {
            return ScanResult::Statement;
        }
        self.split(line, secondary, block, preprocess && self.has_custom_macro())
    }

    #[inline(always)]
    fn split(&self, line: &[u8], secondary: bool, block: &mut Block, statements: bool) -> ScanResult {
        block.clear();
        self.split_from(line, 0, secondary, block, statements)
    }

    /// Adds the words of a part of a line to the block. The part contains no text for the pre-processor.
    #[inline(never)]
    pub fn scan_part(&self, line: &[u8], (start, end): (u32, u32), secondary: bool, block: &mut Block) {
        let part = line.get(..end as usize).unwrap_or(line);
        self.split_from(part, start as usize, secondary, block, false);
    }

    #[inline(always)]
    fn split_from(
        &self,
        line: &[u8],
        start: usize,
        secondary: bool,
        block: &mut Block,
        statements: bool,
    ) -> ScanResult {
        let mut at = start;
        while let Some(&byte) = line.get(at) {
            if byte == b' ' || byte == b'\t' {
                at += 1;
                continue;
            }
            // Few bytes of a plain block begin one, so the question is asked here.
            if let Some(literal_first) = &self.literal_first
                && literal_first.may_start(byte)
            {
                if statements && literal_first.opens_statement(line, at) {
                    return ScanResult::Statement;
                }
                if let Some(next) = self.literal_first(literal_first, line, at, secondary, block) {
                    at = next;
                    continue;
                }
            }
            if let Some((register, incremental)) = self.register(byte) {
                match self.word(line, at + 1, (at, register, incremental), secondary, block) {
                    Some(next) => {
                        at = next;
                        continue;
                    }
                    None if statements && self.opens_statement(line, at) => return ScanResult::Statement,
                    None => {}
                }
            } else if statements && (byte == b'#' || self.opens_statement(line, at)) {
                return ScanResult::Statement;
            }
            at = self.other(line, at, byte, block);
        }
        ScanResult::Words
    }

    /// Anything that is not a word: returns where to continue.
    fn other(&self, line: &[u8], at: usize, byte: u8, block: &mut Block) -> usize {
        if let Some(next) = self.skip(line, at, byte, block) {
            return next;
        }
        if let Some((_, row)) = self.line_up.filter(|(mark, _)| *mark == byte)
            && let Some((word, end)) = LineUp::parse(line, at, byte)
        {
            block.line_up = Some(word);
            block.push_text(row, (at as u32, end as u32));
            return end;
        }
        for (text, row) in self.texts.of(byte) {
            if prefix_registers::stands(text, line, at) {
                let end = at + text.len().max(1);
                block.push_text(*row, (at as u32, end as u32));
                return end;
            }
        }
        if byte == b':'
            && let Some(register) = self.definition
            && block.words.is_empty()
            && let Some(end) = self.word(line, at + 1, (at, register, false), false, block)
        {
            return end;
        }
        if byte == b'<'
            && self.has_custom_macro()
            && block.name().is_none()
            && let Some(end) = program_name(line, at)
        {
            block.set_name((at as u32, end as u32));
            return end;
        }
        if byte < 32 || byte == 127 {
            block.flags.irregular |= irregular::BYTES;
            return at + 1;
        }
        // Unknown text runs to the next blank or the start of a word.
        let mut end = if self.syntax.keeps_names { marks::name_end(line, at) } else { at }.max(at + 1);
        while let Some(&next) = line.get(end) {
            if next <= b' ' || Some(next) == self.opskip || self.starts_comment(line, end) || starts_word(line, end) {
                break;
            }
            end += 1;
        }
        block.push_unrecognised((at as u32, end as u32));
        end
    }

    /// A special register or a text that looks like a word at `at`: where to continue.
    fn literal_first(
        &self,
        literal_first: &LiteralFirst,
        line: &[u8],
        at: usize,
        secondary: bool,
        block: &mut Block,
    ) -> Option<usize> {
        let byte = *line.get(at)?;
        if let Some((text, row)) = literal_first.text(line, at) {
            let end = at + text.len();
            block.push_text(row, (at as u32, end as u32));
            return Some(end);
        }
        for prefix in literal_first.registers(byte) {
            if !line.get(at..)?.starts_with(&prefix.before) {
                continue;
            }
            let (words, sequence) = (block.words.len(), block.sequence);
            let from = at + prefix.before.len();
            if prefix.names
                && let Some((tool, end)) = literal_first.tool(prefix, line, from)
            {
                let (register, incremental, value) = (prefix.register, prefix.incremental, f64::from(tool));
                let (start, end) = (at as u32, end as u32);
                block.push(Word { register, incremental, used: false, made: false, value, start, end });
                return Some(end as usize);
            }
            let Some(end) = self.word(line, from, (at, prefix.register, prefix.incremental), secondary, block) else {
                continue;
            };
            if line.get(end..).is_some_and(|rest| rest.starts_with(&prefix.after)) {
                return Some(end + prefix.after.len());
            }
            block.words.truncate(words);
            block.sequence = sequence;
        }
        None
    }

    /// Whether there is a letter, `#` or `[` where a number was expected, or keywords: text for the pre-processor.
    fn opens_statement(&self, line: &[u8], at: usize) -> bool {
        prefix_registers::starts_expression(line, at + 1)
            || key_word(self.names(), line, at)
            || self.formulas.bare_sums && self.opens_sum(line, at + 1)
    }

    /// Whether a number at this place of the line, after blanks, is the first of a sum or product.
    #[cold]
    fn opens_sum(&self, line: &[u8], at: usize) -> bool {
        let blanks = line.iter().skip(at).take_while(|byte| matches!(byte, b' ' | b'\t')).count();
        parse_number(line, at + blanks).is_some_and(|(_, end)| goes_on_as_sum(line, end))
    }

    /// Value of a number as a register reads it, and its irregularities ([`irregular`]).
    #[inline(always)]
    pub fn reading(&self, register: RegisterId, number: WrittenNumber, secondary: bool) -> (f64, u8) {
        self.read(register, secondary).value(number)
    }

    /// How numbers of a register are read.
    #[inline(always)]
    fn read(&self, register: RegisterId, secondary: bool) -> &Read {
        let [primary, other] = &self.reads[register];
        if secondary { other } else { primary }
    }

    /// Value of a word's text after its letter, if that text is only a number.
    #[must_use]
    pub fn read_again(&self, register: RegisterId, text: &[u8], secondary: bool) -> Option<f64> {
        self.reading_of(register, text, secondary).map(|(value, _)| value)
    }

    /// The same with the irregularities of the number ([`irregular`]).
    #[must_use]
    pub fn reading_of(&self, register: RegisterId, text: &[u8], secondary: bool) -> Option<(f64, u8)> {
        let text = text.trim_ascii();
        let (number, end) = parse_number(text, 0)?;
        (end == text.len()).then(|| self.reading(register, number, secondary))
    }

    /// Value of a computed number as a register reads it, and its irregularities; none if that depends on its digits.
    #[must_use]
    pub fn reading_of_value(&self, register: RegisterId, value: f64, secondary: bool) -> Option<(f64, u8)> {
        let read = self.read(register, secondary);
        let number = WrittenNumber { value, point: value.fract() != 0.0, digits: 0, fraction: 0 };
        read.takes_values().then(|| read.value(number))
    }

    /// A word that begins at `at`, if a number follows its letter or text, which ends at `from`.
    #[inline(always)]
    fn word(
        &self,
        line: &[u8],
        from: usize,
        (at, register, incremental): (usize, RegisterId, bool),
        secondary: bool,
        block: &mut Block,
    ) -> Option<usize> {
        let mut cursor = from;
        while matches!(line.get(cursor), Some(b' ' | b'\t')) {
            cursor += 1;
        }
        let (digits, end) = parse_digits(line, cursor)?;
        if self.formulas.bare_sums && goes_on_as_sum(line, end) {
            return None;
        }
        let (value, irregular) = self.read(register, secondary).value_of_digits(digits);
        block.flags.irregular |= irregular;
        if Some(register) == self.sequence && block.sequence.is_none() && value >= 0.0 {
            block.sequence = Some(value as u32);
            return Some(end);
        }
        block.push(Word { register, incremental, used: false, made: false, value, start: at as u32, end: end as u32 });
        Some(end)
    }
}

/// Whether a number that ends here has another one added, taken away or multiplied.
fn goes_on_as_sum(line: &[u8], end: usize) -> bool {
    matches!(line.get(end), Some(b'+' | b'-' | b'*'))
        && line.get(end + 1).is_some_and(|next| next.is_ascii_digit() || *next == b'.')
}

/// The literal texts of a machine, longest first.
fn literals(machine: &Machine) -> Literals {
    let text = |&row: &CodeRowId| match &machine.codes[row].form {
        CodeForm::Text(text) => Some((text.clone().into_bytes(), row)),
        _ => None,
    };
    ByFirst::new(machine.tables.texts.iter().filter_map(text).collect(), |(text, _)| text)
}

/// First character of words at which systems line up, and their row of the code table.
fn line_up(machine: &Machine) -> Option<(u8, CodeRowId)> {
    let form = machine.sync.waits.iter().find(|row| row.line_up)?.form.as_ref()?;
    let CodeForm::Text(text) = form else { return None };
    let row = machine.tables.texts.iter().find(|&&row| machine.codes[row].form == *form)?;
    Some((*text.as_bytes().first()?, *row))
}

/// How numbers of a register are read in primary and in secondary units.
fn reads(machine: &Machine, register: &Register) -> [Read; 2] {
    let asked = |facts: &diag::DiagnosticFacts, bit| if machine.diagnostics.is_alarm(facts.number) { bit } else { 0 };
    let sign = if register.signed { 0 } else { asked(&diag::MINUS_SIGN, irregular::SIGN) };
    let pointed = if register.pointed { 0 } else { asked(&diag::DECIMAL_POINT, irregular::POINT) };
    [register.format, register.secondary].map(|format| Read::new(format, (sign, pointed)))
}

/// Active optional-skip levels; 0 stands for that of a mark without a digit (reference control-emulator.md 5.5).
fn levels(machine: &Machine, opskip: &[u8]) -> u16 {
    let level = |&level: &u8| if level == 0 { machine.format.opskip_default } else { level };
    opskip.iter().map(level).filter(|&level| level < 16).fold(0, |bits, level| bits | 1 << level)
}

fn starts_word(line: &[u8], at: usize) -> bool {
    line.get(at).is_some_and(u8::is_ascii_alphabetic)
        && matches!(line.get(at + 1), Some(b'0'..=b'9' | b'.' | b'-' | b'+' | b'#' | b'['))
}

/// Position of a text in a line, searched from a start position.
fn find(line: &[u8], from: usize, text: &[u8]) -> Option<usize> {
    memchr::memmem::find(line.get(from..)?, text).map(|at| at + from)
}
