//! TRANS DATUM, MIRROR, ROTATION and SCALE: cycles 7, 8, 10 and 11 by other names.
//!
//! Facts: user's manual of the TNC7, NC functions for coordinate transformation. *Invariant:* each is reduced to its
//! cycle, so that both act on the same values.

use counterpoint_control_api::host::InterpreterHost;
use counterpoint_fault::Halt;

use super::Heidenhain;
use super::cycle_reader::head;
use super::eval::Evaluator;
use super::path_state::AXES;
use super::shifts::SPACE;
use super::shifts::cycle as cycle_words;
use super::words::{EvaluatedWord, HeidenhainWord, LeftBlock, Operand};

impl Heidenhain {
    /// A statement that begins with TRANS.
    pub(super) fn transform(
        &mut self,
        host: &mut dyn InterpreterHost,
        words: &[HeidenhainWord],
    ) -> Result<Vec<LeftBlock>, Halt> {
        let name = |at: usize| words.get(at).map_or("", |word| &*word.name);
        let rest = words.get(2..).unwrap_or_default();
        let (cycle, values) = match (name(1), name(2)) {
            ("DATUM", _) => return self.shift_datum(host, words),
            ("MIRROR", "AXIS") if rest.len() > 1 => (8, rest.get(1..).unwrap_or_default().to_vec()),
            ("MIRROR", "RESET") if rest.len() == 1 => (8, Vec::new()),
            ("ROTATION", "ROT" | "IROT") if rest.len() == 1 => (10, rest.to_vec()),
            ("ROTATION", "RESET") if rest.len() == 1 => (10, vec![number("ROT", 0.0)]),
            ("SCALE", "SCL") if rest.len() == 1 => (11, rest.to_vec()),
            ("SCALE", "RESET") if rest.len() == 1 => (11, vec![number("SCL", 1.0)]),
            _ => return Err(self.not_understood(host)),
        };
        let mut all = vec![head(cycle)];
        all.extend(values);
        let mut seen = Evaluator::new(&mut self.variables, host).seen(&all)?;
        let mut blocks = self.shifts.define(host, cycle, &mut seen);
        if !seen.is_empty() {
            blocks.push(seen);
        }
        Ok(blocks)
    }

    /// TRANS DATUM: cycle 7 by another name.
    fn shift_datum(
        &mut self,
        host: &mut dyn InterpreterHost,
        words: &[HeidenhainWord],
    ) -> Result<Vec<LeftBlock>, Halt> {
        let (form, values) = words.get(2..).and_then(<[HeidenhainWord]>::split_first).unzip();
        let mut all = vec![head(7)];
        match form.map(|word| &*word.name) {
            Some("AXIS") => all.extend_from_slice(values.unwrap_or_default()),
            Some("RESET") => {
                let zero = |name: &str| HeidenhainWord::made(name, Operand::Number("0".into(), 0.0));
                let shifted = |at: &usize| *at < SPACE || self.shifts.datum(*at).is_some_and(|datum| datum != 0.0);
                let letters = AXES.iter().enumerate().filter(|(at, _)| shifted(at));
                all.extend(letters.map(|(_, letter)| zero(letter)));
            }
            Some("TABLE") => {
                let seen = Evaluator::new(&mut self.variables, host).seen(values.unwrap_or_default())?;
                let Some(row) = seen.iter().find(|word| word.is("TABLINE")).and_then(|word| word.value) else {
                    return Err(self.not_understood(host));
                };
                let table = seen.iter().map(EvaluatedWord::own_text).find(|text| text.starts_with('"'));
                let mut words = self.datum_row(host, row, table.as_deref())?;
                self.take_shifts(&words);
                self.shifts.define(host, 7, &mut words);
                return Ok(vec![cycle_words(7, words)]);
            }
            _ => return Err(self.not_understood(host)),
        }
        let mut seen = Evaluator::new(&mut self.variables, host).seen(&all)?;
        self.take_shifts(&seen);
        self.shifts.define(host, 7, &mut seen);
        Ok(vec![seen])
    }
}

fn number(name: &str, value: f64) -> HeidenhainWord {
    HeidenhainWord::made(name, Operand::Number(format!("{value}").into(), value))
}
