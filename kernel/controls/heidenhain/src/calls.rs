//! Calls of cycles: CYCL CALL, CYCL CALL POS, M99, M89, and the running cycle.
//!
//! Facts: programming manuals of the control (POS leads to its position first; M89 calls at every position up to M99; a
//! feed of the call is that of its path). Invariant: parameters that a call has changed have their values again when
//! the cycle is over.

use counterpoint_control_api::host;
use counterpoint_control_api::host::{InterpreterHost, ProgramPlace};
use counterpoint_fault as diag;
use counterpoint_fault::Halt;

use super::call_approach::{CallApproach, SECOND_CLEARANCE};
use super::cycle_state::RunningCycle;
use super::eval::Evaluator;
use super::moves::RAPID;
use super::path_state::{AXES, actual, axis};
use super::q_parameter::{ParameterKind, ParameterValue, QParameter};
use super::statement::CycleCallForm;
use super::words::{EvaluatedWord, HeidenhainWord, LeftBlock, headed};
use super::{Heidenhain, flow};

/// Q203, the surface.
const SURFACE: QParameter = QParameter { kind: ParameterKind::Q, index: 203 };

/// Q200, the clearance above it.
const CLEARANCE: QParameter = QParameter { kind: ParameterKind::Q, index: 200 };

/// Calls that the words of a block ask for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum CycleCallRequest {
    No,
    Once,
    Modally,
}

fn asks(seen: &[EvaluatedWord]) -> CycleCallRequest {
    let mut asked = CycleCallRequest::No;
    for word in seen {
        match (&*word.name, word.value) {
            ("M", Some(99.0)) | ("G", Some(79.0)) => return CycleCallRequest::Once,
            ("M", Some(89.0)) => asked = CycleCallRequest::Modally,
            _ => {}
        }
    }
    asked
}

impl Heidenhain {
    /// CYCL CALL.
    pub(super) fn call_cycle(
        &mut self,
        host: &mut dyn InterpreterHost,
        (kind, words): (CycleCallForm, &[HeidenhainWord]),
        place: ProgramPlace,
    ) -> Result<Vec<LeftBlock>, Halt> {
        let mut seen = Evaluator::new(&mut self.variables, host).seen(words)?;
        self.functions_of(&seen);
        self.feed_units(host, &mut seen)?;
        let text = match kind {
            CycleCallForm::Here => "CYCL CALL",
            CycleCallForm::Position => "CYCL CALL POS",
            CycleCallForm::Pattern => "CYCL CALL PAT",
        };
        if kind == CycleCallForm::Pattern && !host.is_code_text(text) {
            let Some(program) = self.cycles.defined.program.clone() else { return Err(self.not_understood(host)) };
            return Ok(match self.call_at_pattern(host, &program, &seen, place)? {
                Some(blocks) => blocks,
                None => return Err(self.not_understood(host)),
            });
        }
        let Some(program) = self.cycles.defined.program.clone().filter(|_| kind != CycleCallForm::Pattern) else {
            if !host.is_code_text(text) {
                return Err(no_cycle(host, text));
            }
            return Ok(vec![headed(text, seen)]);
        };
        if kind == CycleCallForm::Here {
            self.call_cycle_program(host, &program, None)?;
            return Ok(vec![seen]);
        }
        let (blocks, surface) = self.approach(host, seen);
        self.call_cycle_program(host, &program, Some(surface))?;
        Ok(blocks)
    }

    /// A number that the program has given a parameter, 0 before.
    pub(super) fn number(&self, name: QParameter) -> f64 {
        match self.variables.get(name) {
            Some(ParameterValue::Number(value)) => value,
            _ => 0.0,
        }
    }

    /// Q203.
    pub(super) fn surface(&self) -> f64 {
        self.number(SURFACE)
    }

    /// Q204.
    pub(super) fn second_clearance(&self) -> f64 {
        self.number(SECOND_CLEARANCE)
    }

    /// Blocks that lead to the position of CYCL CALL POS, and the surface there, which its word of the tool axis moves.
    /// From above the tool moves in the plane first, from below up to the clearance first. The feed of the block
    /// applies to this path alone.
    fn approach(&mut self, host: &mut dyn InterpreterHost, seen: Vec<EvaluatedWord>) -> (Vec<LeftBlock>, f64) {
        let along = self.variables.control.tool_axis.unwrap_or(2);
        let is_height =
            |word: &EvaluatedWord| word.value.is_some() && axis(&word.name).is_some_and(|(at, _)| at == along);
        let shift = seen.iter().find(|word| is_height(word)).and_then(|word| word.value).unwrap_or(0.0);
        let surface = self.surface() + shift;
        let way = CallApproach::of(host, &seen);
        let mut blocks = Vec::new();
        if actual(host).get(along).is_some_and(|height| *height < surface) {
            let letter = AXES.get(along).copied().unwrap_or("Z");
            blocks.push(way.block([EvaluatedWord::made(letter, surface + self.number(CLEARANCE))], false));
        }
        let others = seen.into_iter().filter(|word| !is_height(word) && !word.is_rate());
        blocks.push(way.block(others, false));
        blocks.extend(self.path.rates.last.clone().filter(|_| way.has_feed()).map(|feed| vec![feed]));
        (blocks, surface)
    }

    /// Calls the program of a cycle, with a surface of the call.
    pub(super) fn call_cycle_program(
        &mut self,
        host: &mut dyn InterpreterHost,
        program: &str,
        surface: Option<f64>,
    ) -> Result<(), Halt> {
        let stored = self.cycles.defined.stored;
        if stored && self.variables.control.tool_axis.is_some_and(|axis| axis != 2) {
            let text = format!(
                "cycles work along Z: tool axis {} is not emulated in '{}'",
                self.tool_letter(),
                host.block_text()
            );
            return Err(host.alarm(&diag::STATEMENT_UNKNOWN, text));
        }
        let needs = stored && program.parse().is_ok_and(|cycle| self.settings.spindle_cycles.contains(&cycle));
        if needs && !matches!(self.variables.control.spindle, Some(0 | 1)) {
            let text =
                format!("spindle ? (error 1000): cycle {program} with the spindle off in '{}'", host.block_text());
            return Err(host.alarm(&diag::CYCLE_SPINDLE, text));
        }
        let file = host.place().file;
        let known = self.cycles.defined.found.filter(|(caller, _)| *caller == file);
        let place = match known {
            Some((_, place)) => place,
            None => self.find_program(host, program, stored)?,
        };
        self.cycles.defined.found = Some((file, place));
        host.call(host::SubprogramCall { name: program.trim().into(), place, passes: 1, closes: true });
        self.calling = Some(flow::CalleeKind::Cycle);
        self.cycles.running.changed.clear();
        if let Some(moved) = surface {
            self.for_this_call(SURFACE, moved);
        }
        Ok(())
    }

    /// Changes a parameter until the cycle that has been called is over.
    pub(super) fn for_this_call(&mut self, name: QParameter, value: f64) {
        self.cycles.running.changed.push((name, self.number(name)));
        self.variables.set(name, ParameterValue::Number(value));
    }

    /// Feeds of a cycle that mean rapid.
    pub(super) fn rapid_feeds(&self, seen: &mut [EvaluatedWord]) {
        let rapid = |word: &&mut EvaluatedWord| word.is("F") && word.value.is_some_and(|feed| feed >= RAPID);
        for word in seen.iter_mut().filter(|_| self.cycles.running.depth > 0).filter(rapid) {
            *word = EvaluatedWord::text("FMAX");
        }
    }

    /// The program of a cycle has been called.
    pub(super) fn cycle_begins(&mut self) {
        if self.cycles.running.depth == 0 {
            self.cycles.running.depth = self.variables.calls.depth();
            self.cycles.running.feed.clone_from(&self.path.rates.last);
            let main = std::mem::replace(&mut self.variables.control.inch, self.units.inches);
            self.cycles.running.main_in_inches = main;
        }
    }

    /// A program or label has returned: a cycle is over, its parameters are those of its definition again.
    pub(super) fn cycle_returns(&mut self) {
        if self.cycles.running.depth > self.variables.calls.depth() {
            let RunningCycle { changed, feed, main_in_inches, .. } = std::mem::take(&mut self.cycles.running);
            self.path.rates.last = feed;
            self.variables.control.inch = main_in_inches;
            for (name, value) in changed {
                self.variables.set(name, ParameterValue::Number(value));
            }
        }
    }

    /// M99, M89, G79 of a block, and the effect of an earlier M89. A cycle that is a program is called. For any other
    /// cycle the call stays in the block; M89 acts as M99 in its own block and in all following blocks.
    pub(super) fn cycle_calls(
        &mut self,
        host: &mut dyn InterpreterHost,
        seen: &mut Vec<EvaluatedWord>,
        moves: bool,
    ) -> Result<(), Halt> {
        let asked = asks(seen);
        // Moves of the cycle itself call nothing.
        let modal = self.cycles.defined.modal && moves && self.cycles.running.depth == 0;
        if asked == CycleCallRequest::No && !modal {
            return Ok(());
        }
        match asked {
            CycleCallRequest::Once => self.cycles.defined.modal = false,
            CycleCallRequest::Modally => self.cycles.defined.modal = true,
            CycleCallRequest::No => {}
        }
        let program = self.cycles.defined.program.clone();
        seen.retain(|word| match (&*word.name, word.value) {
            ("M", Some(89.0)) => false,
            ("M", Some(99.0)) | ("G", Some(79.0)) => program.is_none(),
            _ => true,
        });
        match program {
            Some(program) => self.call_cycle_program(host, &program, None),
            None if !host.knows_code(b'M', 99.0) => Err(no_cycle(host, "M99 or M89")),
            None => {
                if asked != CycleCallRequest::Once {
                    seen.push(EvaluatedWord::made("M", 99.0));
                }
                Ok(())
            }
        }
    }
}

/// A call without a cycle, on a machine whose cycles are programs.
fn no_cycle(host: &mut dyn InterpreterHost, what: &str) -> Halt {
    let text = format!("no cycle is defined for {what} in '{}': program CYCL DEF before it", host.block_text());
    host.alarm(&diag::CYCLE_REFUSED, text)
}
