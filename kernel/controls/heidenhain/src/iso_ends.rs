//! Soft approach and departure of ISO programs: G26 after the first block with G41 or G42, G27 before the block with
//! G40.
//!
//! Facts: programming manual (DIN/ISO), tangential approach and departure. Decision: the paths are those of APPR LCT
//! and DEP LCT, a line and an arc that are tangent to each other and to the contour. Invariant: a G26 or G27 without
//! such a block is an alarm.

use counterpoint_control_api::contour::PathShape;
use counterpoint_control_api::host::{InterpreterHost, ProgramPlace};
use counterpoint_fault::Halt;

use super::iso_blocks::Element;
use super::path_state::PathBlockKind;
use super::statement::HeidenhainStatement;
use super::words::{HeidenhainWord, LeftBlock, Operand, shown};
use super::{Heidenhain, HeidenhainLine};

fn is_g(word: &HeidenhainWord, number: f64) -> bool {
    matches!(word.operand, Operand::Number(_, value) if &*word.name == "G" && value == number)
}

fn is_radius(word: &HeidenhainWord) -> bool {
    &*word.name == "R"
}

fn is_compensation_off(word: &HeidenhainWord) -> bool {
    matches!(word.operand, Operand::Number(_, value) if is_radius(word) && value == 0.0)
}

impl Heidenhain {
    /// The path blocks of a block, the line to the first or from the last point of a contour with its arc.
    pub(super) fn softened(
        &mut self,
        host: &mut dyn InterpreterHost,
        mut elements: Vec<Element>,
        line: &HeidenhainLine,
        place: ProgramPlace,
    ) -> Result<Vec<Element>, Halt> {
        let [(shape, words)] = elements.as_mut_slice() else { return Ok(elements) };
        if *shape != PathBlockKind::Line {
            return Ok(elements);
        }
        if let Some(radius) = self.modes.leaves.take() {
            let Some(off) = words.iter_mut().find(|word| is_compensation_off(word)) else {
                return Err(self.not_understood(host));
            };
            off.operand = Operand::Number(shown(radius).into(), radius);
            *shape = PathBlockKind::Depart(PathShape::LineAndCircle);
        } else if words.iter().any(|word| matches!(&*word.name, "RL" | "RR"))
            && let Some(radius) = self.approach_radius(host, line.next, place)
        {
            words.push(radius);
            *shape = PathBlockKind::Approach(PathShape::LineAndCircle);
            self.modes.softened = true;
        }
        Ok(elements)
    }

    /// The radius of a G26 in the next block.
    fn approach_radius(
        &mut self,
        host: &mut dyn InterpreterHost,
        next: u32,
        place: ProgramPlace,
    ) -> Option<HeidenhainWord> {
        let mut at = next;
        while at <= place.range.last {
            let read = self.line(host, at).ok()?;
            match &read.statement {
                HeidenhainStatement::Nothing if read.next > at => at = read.next,
                HeidenhainStatement::Path { words, .. } | HeidenhainStatement::Words(words)
                    if words.iter().any(|word| is_g(word, 26.0)) =>
                {
                    return words.iter().find(|word| is_radius(word)).cloned();
                }
                _ => return None,
            }
        }
        None
    }

    /// G26 and G27 themselves.
    pub(super) fn soft_end(
        &mut self,
        host: &mut dyn InterpreterHost,
        function: u32,
        others: &[HeidenhainWord],
    ) -> Result<Vec<LeftBlock>, Halt> {
        let [word] = others else { return Err(self.not_understood(host)) };
        let softened = std::mem::take(&mut self.modes.softened);
        if !is_radius(word) || function == 26 && !softened {
            return Err(self.not_understood(host));
        }
        if function == 27 {
            let seen = super::eval::Evaluator::new(&mut self.variables, host).seen(others)?;
            self.modes.leaves = seen.iter().find(|word| word.is("R")).and_then(|word| word.value);
        }
        Ok(Vec::new())
    }
}
