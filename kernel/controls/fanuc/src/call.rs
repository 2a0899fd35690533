//! Arguments of macro calls: G65, G66 and G66.1, and words that call like them.
//!
//! Facts: reference control-emulator.md 5.4. Decisions: every letter is an argument, also a letter without a register
//! of the machine, wherever it is in the block. Words that cannot be arguments (further G words, a second P) remain
//! text.

use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_machine::index::RegisterId;
use counterpoint_machine::model::{MacroWords, Triples};
use counterpoint_program::key_words::WrittenNumber;

use super::access::{Abandoned, eval};
use super::expr::{is_vacant, number};
use super::statement::{FanucStatement, TemplateWord, WordName};
use super::vocabulary::macro_call;
use counterpoint_control_api::host::{InterpreterHost, MadeWord};
use counterpoint_control_api::interpreter::{MacroArguments, MacroCall};

/// How a G word calls, if the call has arguments.
fn with_arguments(g: f64) -> Option<MacroCall> {
    macro_call(g).filter(|call| *call != MacroCall::End)
}

/// Reads the words of a call; the word that calls by itself is not one of them.
pub(super) fn arguments(
    host: &mut dyn InterpreterHost,
    words: &[TemplateWord],
    mut own: Option<(RegisterId, f64)>,
) -> Result<MacroArguments, Halt> {
    let mut read = MacroArguments::default();
    let mut triples = TripleCounter::of(host.triples());
    let calls = |word: &TemplateWord| {
        let value = word.value.as_constant().copied().filter(|_| word.name == WordName::Letter(b'G'));
        value.is_some_and(|value| with_arguments(value).is_some())
    };
    let by_code = own.is_some();
    let rule = Some(host.macro_words()).filter(|_| !by_code && words.iter().any(calls));
    for word in words {
        let span = (word.start, word.end);
        let WordName::Letter(letter) = word.name else {
            host.keep_text(span);
            continue;
        };
        let register = host.register(letter);
        let value = match (reads_like(host, letter), word.written) {
            // An argument keeps all its digits.
            (Some(register), Some(number)) => host.read(register, WrittenNumber { fraction: 0, ..number }),
            _ => match eval(host, &word.value) {
                Ok(value) => value,
                Err(Abandoned::Halt(halt)) => return Err(halt),
                Err(Abandoned::Text) => {
                    host.keep_text(span);
                    continue;
                }
            },
        };
        let plain = match (letter, word.written) {
            // Numbers of programs and passes are whole.
            (b'P' | b'L', None) => number(value).round(),
            _ => number(value),
        };
        if own.is_some() && own == register.map(|(register, _)| (register, plain)) {
            own = None;
            continue;
        }
        let call = with_arguments(plain).filter(|_| read.call.is_none() && letter == b'G');
        match rule {
            Some(MacroWords::Behind) if call.is_none() => check_place(host, letter, read.call.is_some())?,
            Some(MacroWords::ActBefore) if call.is_none() && read.call.is_none() && !matches!(letter, b'N' | b'O') => {
                match register {
                    // A word without a value drops.
                    _ if is_vacant(value) => {}
                    Some((register, incremental)) => {
                        host.push(MadeWord { register, incremental, value, written: word.written, span });
                    }
                    None => host.keep_text(span),
                }
                continue;
            }
            _ => {}
        }
        match letter {
            b'G' if call.is_some() => read.call = call,
            // Beside a code that calls by itself another code acts before it.
            b'G' if by_code && host.knows_code(letter, plain) => {
                if let Some((register, incremental)) = register {
                    host.push(MadeWord { register, incremental, value, written: word.written, span });
                }
            }
            b'N' | b'O' => {}
            b'P' if read.program.is_none() => {
                (read.program, read.program_number) = (Some(plain), as_written(register, word));
            }
            b'L' => (read.count, read.count_number) = (Some(plain), as_written(register, word)),
            letter @ b'I'..=b'K' => {
                read.values.push((triples.variable(letter - b'I'), value));
            }
            letter => match variable(letter) {
                Some(variable) => read.values.push((variable, value)),
                None => host.keep_text(span),
            },
        }
    }
    Ok(read)
}

/// The number of a word as written, with its register.
fn as_written(register: Option<(RegisterId, bool)>, word: &TemplateWord) -> Option<(RegisterId, WrittenNumber)> {
    register.map(|(register, _)| register).zip(word.written)
}

/// Where the next I, J or K of a call goes.
struct TripleCounter {
    rule: Triples,
    /// Triple of the next value of each letter; with values in order that of all.
    next: [u8; 3],
    /// The letter before, 0 to 2.
    last: Option<u8>,
}

impl TripleCounter {
    /// Last of the ten triples.
    const LAST: u8 = 9;

    fn of(rule: Triples) -> Self {
        Self { rule, next: [0; 3], last: None }
    }

    /// Local variable of a letter, 0 for I to 2 for K.
    fn variable(&mut self, letter: u8) -> u8 {
        let [first, ..] = self.next;
        let triple = match self.rule {
            Triples::First => 0,
            Triples::InOrder if self.last.is_some_and(|last| letter <= last) => first.saturating_add(1),
            Triples::InOrder => first,
            Triples::ByLetter => self.next.get(usize::from(letter)).copied().unwrap_or(0),
        };
        let triple = triple.min(Self::LAST);
        self.last = Some(letter);
        match self.rule {
            Triples::ByLetter => {
                if let Some(next) = self.next.get_mut(usize::from(letter)) {
                    *next = triple + 1;
                }
            }
            _ => self.next = [triple; 3],
        }
        4 + triple * 3 + letter
    }
}

/// Register that defines the number format of an argument: that of its letter, or of the axis that the letter
/// continues.
fn reads_like(host: &dyn InterpreterHost, letter: u8) -> Option<RegisterId> {
    let axis = match letter {
        b'U'..=b'W' => letter - b'U' + b'X',
        letter => letter,
    };
    host.register(letter).or_else(|| host.register(axis)).map(|(register, _)| register)
}

/// Arguments come after the word that calls, and a G word is never one.
fn check_place(host: &mut dyn InterpreterHost, letter: u8, after: bool) -> Acted {
    if matches!(letter, b'N' | b'O') {
        return Ok(());
    }
    let letter = char::from(letter);
    if !after {
        let text = format!("{letter} comes before the macro call in '{}'", host.block_text());
        return Err(host.alarm(&diag::CALL_NOT_FIRST, text));
    }
    if letter == 'G' {
        let text = format!("G cannot be an argument of the macro call in '{}'", host.block_text());
        return Err(host.alarm(&diag::CALL_G_WORD, text));
    }
    Ok(())
}

/// The words of a block, also after THEN.
pub(super) fn words_of(statement: &FanucStatement) -> Option<&[TemplateWord]> {
    match statement {
        FanucStatement::Words(words) => Some(words),
        FanucStatement::IfThen(_, inner) => words_of(inner),
        _ => None,
    }
}

/// Local variable of an argument letter (argument list I of the control).
fn variable(letter: u8) -> Option<u8> {
    Some(match letter {
        b'A' => 1,
        b'B' => 2,
        b'C' => 3,
        b'D' => 7,
        b'E' => 8,
        b'F' => 9,
        b'H' => 11,
        b'M' => 13,
        b'Q' => 17,
        b'R' => 18,
        b'S' => 19,
        b'T' => 20,
        b'U' => 21,
        b'V' => 22,
        b'W' => 23,
        b'X' => 24,
        b'Y' => 25,
        b'Z' => 26,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::{TripleCounter, Triples};

    fn variables(rule: Triples, letters: &str) -> Vec<u8> {
        let mut places = TripleCounter::of(rule);
        letters.bytes().map(|letter| places.variable(letter - b'I')).collect()
    }

    #[test]
    fn triples_are_filled_by_letter_in_order_or_once() {
        for (letters, by_letter, in_order, first) in [
            ("IJK", [4, 5, 6], [4, 5, 6], [4, 5, 6]),
            ("KJI", [6, 5, 4], [6, 8, 10], [6, 5, 4]),
            ("KIJ", [6, 4, 5], [6, 7, 8], [6, 4, 5]),
            ("IIJ", [4, 7, 5], [4, 7, 8], [4, 4, 5]),
            ("IKJ", [4, 6, 5], [4, 6, 8], [4, 6, 5]),
        ] {
            assert_eq!(variables(Triples::ByLetter, letters), by_letter, "{letters}");
            assert_eq!(variables(Triples::InOrder, letters), in_order, "{letters}");
            assert_eq!(variables(Triples::First, letters), first, "{letters}");
        }
        assert_eq!(variables(Triples::InOrder, "KKKKKKKKKKKK").last(), Some(&33));
    }
}
