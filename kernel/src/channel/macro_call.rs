//! Calls of macros with arguments: G65, G66 and G66.1, and words that call like them.
//!
//! Facts: reference control-emulator.md 5.4. Decisions: every letter is an argument, also one that the machine has no
//! register for, wherever it stands on the block; what can be none (further G words, a second P) is told as left over.

use super::Kernel;
use super::flow::Callee;
use super::flow::Pending;
use super::macros::Left;
use super::modal_call::ModalCall;
use crate::diag;
use crate::dialect::fanuc::{Name, Statement, TemplateWord, number};
use crate::state::block::irregular;
use counterpoint_fault::Acted;
use counterpoint_fault::Halt;

/// What the words of a call say.
#[derive(Debug, Default)]
struct Words {
    program: Option<f64>,
    count: Option<f64>,
    /// The call is modal, and for each block.
    way: Option<(bool, bool)>,
    /// Values by variable number.
    arguments: Vec<(u8, f64)>,
}

impl Kernel<'_> {
    /// A block whose words are the arguments of a macro.
    pub(crate) fn macro_call(&mut self) -> Acted {
        let own = self.flow.word_call.take();
        let line = if self.plan.hooks.is_some() || self.channel.text.edited.is_some() {
            let text = self.text_bytes().into_owned();
            self.compiled(&text, false)?
        } else {
            let (sources, at) = (self.channel.env.sources, &self.channel.at);
            self.compiled(sources.get(at.file).map_or(&[][..], |source| source.line(at.line)), false)?
        };
        line.name.into_iter().for_each(|span| self.channel.block.set_name(span));
        let Some(words) = words_of(&line.statement) else { return Ok(()) };
        // Arguments are no words of their registers.
        let odd = self.channel.block.flags.irregular & !irregular::NUMBERS;
        let mut words = self.call_words(words, own.as_deref().map(|call| (call.register, call.by.value)))?;
        self.channel.block.flags.irregular = odd;
        let mut by = None;
        let what = match own {
            Some(call) => {
                (words.way, by) = (Some(call.way), Some(call.by));
                Some(Callee::Program(call.program))
            }
            None if words.way.is_some() => match words.program {
                Some(p) if (1.0..=f64::from(u32::MAX)).contains(&p) => Some(Callee::Program(p as u32)),
                Some(_) => None,
                None => self.take_name().map(Callee::Named),
            },
            // A block that only gives the arguments: P and L are none of them either.
            None => self.flow.modal_call.as_deref().map(|call| call.what.clone()),
        };
        let Some(what) = what else {
            let text = format!("macro call without a program number P in '{}'", self.block_text());
            return Err(self.alarm(&diag::MACRO_CALL, text));
        };
        let passes = match (words.way, words.count, self.flow.modal_call.as_deref()) {
            (None, _, Some(call)) => call.passes,
            (_, Some(count), _) => self.passes(count).max(1),
            _ => 1,
        };
        let arguments = words.arguments;
        match words.way {
            Some((true, each)) => {
                let level = self.call_level();
                self.flow.modal_call = Some(Box::new(ModalCall { what, passes, arguments, each, level, by }));
            }
            _ => {
                let by = by.map(Box::new);
                self.ask(Pending::Call { what, passes, arguments: Some(arguments), by });
            }
        }
        self.leftovers()
    }

    /// Reads the words of a call; the word that calls by itself is none of them.
    fn call_words(&mut self, words: &[TemplateWord], mut own: Option<(u8, f64)>) -> Result<Words, Halt> {
        let mut read = Words::default();
        let mut levels = [0_u8; 3];
        let calls = |word: &TemplateWord| {
            let value = word.value.as_constant().filter(|_| word.name == Name::Letter(b'G'));
            value.is_some_and(|value| Self::way_of_call(value).is_some())
        };
        let strict = self.channel.env.machine.subprograms.strict && own.is_none() && words.iter().any(calls);
        for word in words {
            let Name::Letter(letter) = word.name else {
                self.channel.block.unrecognised.push((word.start, word.end));
                continue;
            };
            let register = self.plan.scanner.register(letter);
            let value = match (register, word.written) {
                (Some((register, _)), Some(number)) => self.read_by_register(register, number),
                _ => match self.eval(&word.value) {
                    Ok(value) => value,
                    Err(Left::Halt(halt)) => return Err(halt),
                    Err(Left::Text) => {
                        self.channel.block.unrecognised.push((word.start, word.end));
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
            let calls = read.way.is_none() && letter == b'G' && Self::way_of_call(plain).is_some();
            if strict && !calls {
                self.check_place(letter, read.way.is_some())?;
            }
            match letter {
                b'G' if calls => {
                    read.way = Self::way_of_call(plain);
                }
                b'N' | b'O' => {}
                b'P' if read.program.is_none() => read.program = Some(plain),
                b'L' => read.count = Some(plain),
                letter @ b'I'..=b'K' => {
                    let slot = letter - b'I';
                    let Some(level) = levels.get_mut(usize::from(slot)) else { continue };
                    read.arguments.push((4 + *level * 3 + slot, value));
                    *level = level.saturating_add(1).min(9);
                }
                letter => match argument(letter) {
                    Some(variable) => read.arguments.push((variable, value)),
                    None => self.channel.block.unrecognised.push((word.start, word.end)),
                },
            }
        }
        Ok(read)
    }
}

impl Kernel<'_> {
    /// Arguments come behind the word that calls, and G words are none.
    fn check_place(&mut self, letter: u8, behind: bool) -> Acted {
        if matches!(letter, b'N' | b'O') {
            return Ok(());
        }
        let letter = char::from(letter);
        if !behind {
            let text = format!("{letter} stands before the macro call in '{}'", self.block_text());
            return Err(self.alarm(&diag::CALL_NOT_FIRST, text));
        }
        if letter == 'G' {
            let text = format!("G is no argument of the macro call in '{}'", self.block_text());
            return Err(self.alarm(&diag::CALL_G_WORD, text));
        }
        Ok(())
    }
}

/// The words of a block, also behind THEN.
fn words_of(statement: &Statement) -> Option<&[TemplateWord]> {
    match statement {
        Statement::Words(words) => Some(words),
        Statement::IfThen(_, inner) => words_of(inner),
        _ => None,
    }
}

/// Local variable of an argument letter (argument list I of the control).
fn argument(letter: u8) -> Option<u8> {
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
