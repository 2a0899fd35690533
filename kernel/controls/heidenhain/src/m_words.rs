//! M functions with words of their own: M94 with an axis, M103 with a share, M118 with distances, M138 with axes.
//!
//! Facts: programming manuals of the control: M94 acts on the axes it names, otherwise on all; F after M103 is a
//! percentage; coordinates after M118 limit the travel that a handwheel may add; M197 DL extends offsets outside a
//! corner; M112 T A and M124 T smooth corners and leave out points within a tolerance; M142 removes shift, mirror,
//! rotation and scale; M138 without axes uses all rotary axes again. M130 reads positions of its block without the
//! tilted plane. Decision: M138 with some of the axes, and M130 in a plane, are refused; M112 and M124 are reported and
//! change nothing. *Invariant:* none of these words moves an axis or is a feed.

use counterpoint_control_api::host::InterpreterHost;
use counterpoint_fault as diag;
use counterpoint_fault::Halt;

use super::Heidenhain;
use super::path_state::axis;
use super::words::{EvaluatedWord, LeftBlock};

/// Letters of rotary axes, as the register of M94 counts them from 1.
const ROTARY: [&str; 3] = ["A", "B", "C"];

fn is_function(word: &EvaluatedWord, number: f64) -> bool {
    word.is("M") && word.value == Some(number)
}

/// Takes the words after a function that are its own.
fn behind(seen: &mut Vec<EvaluatedWord>, at: usize, own: impl Fn(&EvaluatedWord) -> bool) -> Vec<EvaluatedWord> {
    let count = seen.iter().skip(at + 1).take_while(|word| own(word)).count();
    seen.drain(at + 1..at + 1 + count).collect()
}

impl Heidenhain {
    /// Takes the own words of M functions off a block; the blocks that come before it.
    pub(super) fn function_words(
        &mut self,
        host: &mut dyn InterpreterHost,
        seen: &mut Vec<EvaluatedWord>,
    ) -> Result<Vec<LeftBlock>, Halt> {
        let mut before = Vec::new();
        let place = |seen: &[EvaluatedWord], number: f64| seen.iter().position(|word| is_function(word, number));
        if let Some(at) = place(seen, 94.0).filter(|_| host.is_register("BELOW")) {
            let axes = behind(seen, at, |word| word.value.is_none() && ROTARY.contains(&&*word.name));
            if !axes.is_empty() {
                let function = seen.remove(at);
                let numbers = ROTARY.iter().zip(1_u8..).filter(|(letter, _)| axes.iter().any(|word| word.is(letter)));
                before.extend(
                    numbers.map(|(_, number)| vec![function.clone(), EvaluatedWord::made("BELOW", f64::from(number))]),
                );
            }
        }
        if let Some(at) = place(seen, 103.0).filter(|_| host.is_register("DOWN"))
            && let Some(word) = seen.get_mut(at + 1).filter(|word| word.is("F"))
            && let Some(share) = word.value
        {
            *word = EvaluatedWord::made("DOWN", share);
        }
        if let Some(at) = place(seen, 197.0).filter(|_| host.is_register("BEYOND"))
            && let Some(word) = seen.get_mut(at + 1).filter(|word| word.is("DL"))
            && let Some(by) = word.value
        {
            *word = EvaluatedWord::made("BEYOND", by);
        }
        for (number, what) in
            [(112.0, "corners that M112 smooths stay as they are"), (124.0, "points that M124 leaves out stay")]
        {
            let Some(at) = place(seen, number) else { continue };
            behind(seen, at, |word| word.value.is_some() && matches!(&*word.name, "T" | "A" | "E"));
            host.report(&diag::PATH_NOT_MADE, 4, format!("{what}, in '{}'", host.block_text()));
        }
        if let Some(at) = place(seen, 114.0)
            && seen.get(at + 1).is_some_and(|word| word.value.is_some() && ROTARY.contains(&&*word.name))
        {
            let text = format!(
                "angles of axes that the control does not move (M114 with an axis) are not emulated in '{}'",
                host.block_text()
            );
            return Err(host.alarm(&diag::STATEMENT_UNKNOWN, text));
        }
        if place(seen, 142.0).is_some() {
            before.extend(self.shifts.define(host, 247, &mut Vec::new()));
            self.cycles.defined = super::cycle_state::DefinedCycle::default();
        }
        if place(seen, 130.0).is_some() && host.plane_angles().is_some() {
            let text = format!(
                "positions of the system that is not tilted (M130) are not emulated in '{}'; program them in the plane",
                host.block_text()
            );
            return Err(host.alarm(&diag::STATEMENT_UNKNOWN, text));
        }
        if let Some(at) = place(seen, 118.0) {
            behind(seen, at, |word| axis(&word.name).is_some());
        }
        if let Some(at) = place(seen, 138.0) {
            let chosen = behind(seen, at, |word| word.value.is_none() && axis(&word.name).is_some());
            let of_machine = |letter: &&str| host.positions().iter().any(|(name, ..)| name.starts_with(*letter));
            let missing = |letter: &&str| !chosen.iter().any(|word| word.is(letter));
            if !chosen.is_empty() && ROTARY.iter().filter(|letter| of_machine(letter)).any(missing) {
                let text = format!(
                    "M138 with some of the rotary axes is not emulated in '{}'; name all of them or none",
                    host.block_text()
                );
                return Err(host.alarm(&diag::STATEMENT_UNKNOWN, text));
            }
        }
        Ok(before)
    }
}
