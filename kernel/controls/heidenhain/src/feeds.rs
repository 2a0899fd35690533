//! Feeds per revolution and per tooth: FU and FZ.
//!
//! Facts: programming manuals of the control: FU is in millimetres per revolution, FZ in millimetres per tooth, whose
//! number is CUT of the tool table (system data ID50 NR15), in inches in inch programs; both hold until another feed.
//! Decisions: they become the F word of M136, other feeds that of M137 from then on; a machine with registers of these
//! names gets them as they are. Invariant: a program without FU and FZ keeps its F words.

use counterpoint_control_api::host::InterpreterHost;
use counterpoint_fault as diag;
use counterpoint_fault::Halt;

use super::Heidenhain;
use super::eval::{Evaluator, IdentificationResult};
use super::path_state::{FASTEST, PathBlockKind};
use super::q_parameter::ParameterValue;
use super::words::{EvaluatedWord, shown};

/// M functions of feeds per revolution and per minute.
const PER_TURN: u16 = 136;
const PER_MINUTE: u16 = 137;

/// Units of a program and of its feeds.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Units {
    /// The program that runs counts in inches.
    pub(super) inches: bool,
    /// FU or FZ has been used.
    used: bool,
    /// M136 has been programmed.
    per_turn: bool,
    /// M116 has been programmed.
    pub(super) rotary_length: bool,
}

impl Units {
    /// An M function acts.
    fn function(&mut self, number: f64) {
        match number {
            136.0 => self.per_turn = true,
            137.0 => self.per_turn = false,
            116.0 => self.rotary_length = true,
            117.0 => self.rotary_length = false,
            _ => {}
        }
    }

    /// Units of the machine of a unit of F words in an inch program: tenths of an inch a minute, inches a revolution.
    fn feed_factor(self, inch: f64) -> f64 {
        if self.per_turn { inch } else { inch / 10.0 }
    }

    /// Converts a feed from units of the machine to units of the program.
    pub(super) fn of_program(self, feed: f64, host: &dyn InterpreterHost) -> f64 {
        if self.inches { feed / self.feed_factor(host.length_factor()) } else { feed }
    }

    /// The programmed feed, in units of the program.
    pub(super) fn programmed(self, host: &dyn InterpreterHost) -> f64 {
        self.of_program(host.feed(), host)
    }

    /// The M function that an F word needs, once a program has used a feed per revolution.
    pub(super) fn function_of_feed(self) -> Option<f64> {
        self.used.then_some(if self.per_turn { 136.0 } else { 137.0 })
    }

    /// The M function that an F word means.
    fn of_feed(self) -> u16 {
        if self.per_turn { PER_TURN } else { PER_MINUTE }
    }
}

impl Heidenhain {
    /// FU and FZ of a block become F words with their M function.
    pub(super) fn feed_units(
        &mut self,
        host: &mut dyn InterpreterHost,
        seen: &mut [EvaluatedWord],
    ) -> Result<(), Halt> {
        for word in &*seen {
            if let ("M", Some(number)) = (&*word.name, word.value) {
                self.units.function(number);
            }
        }
        for word in seen {
            let Some(value) = word.value else { continue };
            let value = match &*word.name {
                "F" if self.units.used => {
                    word.function = Some(self.units.of_feed());
                    continue;
                }
                "FU" if !host.is_register("FU") => value,
                "FZ" if !host.is_register("FZ") => value * self.teeth(host)?,
                _ => continue,
            };
            if !host.knows_code(b'M', 136.0) {
                let text = format!("the machine has no code M136 for the feed of '{}'", host.block_text());
                return Err(host.alarm(&diag::NO_FEED_PER_TURN, text));
            }
            self.begin_units();
            *word = EvaluatedWord { function: Some(PER_TURN), span: word.span, ..EvaluatedWord::made("F", value) };
        }
        Ok(())
    }

    /// The F word that FMAX is on a circle: the rate of the slower axis of the plane.
    pub(super) fn rapid_on_circle(
        &self,
        host: &mut dyn InterpreterHost,
        shape: PathBlockKind,
        seen: &[EvaluatedWord],
    ) -> Result<Option<EvaluatedWord>, Halt> {
        if !shape.is_arc() || !seen.iter().any(|word| word.is("FMAX")) {
            return Ok(None);
        }
        self.circle_rate(host).map(Some)
    }

    /// The F word of a circle at rapid.
    pub(super) fn circle_rate(&self, host: &mut dyn InterpreterHost) -> Result<EvaluatedWord, Halt> {
        if self.units.per_turn {
            let text =
                format!("a circle at rapid under M136 is not emulated in '{}'; program M137 before", host.block_text());
            return Err(host.alarm(&diag::STATEMENT_UNKNOWN, text));
        }
        let rates = self.plane_letters().map(|letter| host.rapid_rate(letter));
        let rate = rates.into_iter().flatten().fold(f64::INFINITY, f64::min);
        let per_minute = if self.units.inches { host.length_factor() / 10.0 } else { 1.0 };
        Ok(EvaluatedWord::made("F", if rate.is_finite() { rate / per_minute } else { FASTEST }))
    }

    /// Feeds that are kept have the unit that they had.
    fn begin_units(&mut self) {
        if std::mem::replace(&mut self.units.used, true) {
            return;
        }
        for feed in [&mut self.path.rates.last, &mut self.path.rates.of_tool].into_iter().flatten() {
            feed.function = Some(self.units.of_feed());
        }
    }

    /// Teeth of the tool in use.
    fn teeth(&mut self, host: &mut dyn InterpreterHost) -> Result<f64, Halt> {
        let tool = self.variables.control.tool.unwrap_or(0.0);
        let asked = format!("ID50 NR15 IDX{}", shown(tool));
        let answer = Evaluator::new(&mut self.variables, host).ask(&asked)?;
        match answer {
            IdentificationResult::Value(ParameterValue::Number(teeth)) if teeth > 0.0 => Ok(teeth),
            IdentificationResult::Unknown if self.tools.teeth(tool) > 0.0 => Ok(self.tools.teeth(tool)),
            _ => {
                let text = format!(
                    "the feed per tooth of '{}' needs the number of teeth of tool {}, which the identification macro does not give for '{asked}'",
                    host.block_text(),
                    shown(tool)
                );
                Err(host.alarm(&diag::NO_TEETH, text))
            }
        }
    }
}
