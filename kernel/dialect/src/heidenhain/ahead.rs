//! The path blocks after a path block that its end depends on.
//!
//! Facts: programming manuals of the control (corners and approaches are computed with the next element). Decisions: after a
//! corner the look ahead follows assignments and jumps, and ends at a call. Invariant: a look ahead leaves the parameters as
//! they were.

use super::eval::Evaluator;
use super::formula::Name;
use super::iso_blocks::Modes;
use super::path::{Shape, Step};
use super::statement::Statement;
use super::variables::Value;
use super::words::Word;
use super::{Heidenhain, Line};
use crate::host::{Host, Place};
use counterpoint_fault::Halt;

/// Blocks between a line and the corner or the path block after it.
const NEAR: u32 = 50;

impl Heidenhain {
    /// Path blocks that a block has to know: a corner with what follows it, or the first element of a contour.
    pub(super) fn ahead(
        &mut self,
        host: &mut dyn Host,
        shape: Shape,
        next: u32,
        place: Place,
    ) -> Result<Vec<Step>, Halt> {
        // The line after an arc may say where the arc ends.
        let approach = matches!(shape, Shape::Approach(_) | Shape::FreeArc { .. });
        let cuts = !matches!(
            shape,
            Shape::Pole | Shape::FreePole | Shape::FreeSelect | Shape::Chamfer | Shape::Round | Shape::Depart(_)
        );
        if !approach && !cuts {
            return Ok(Vec::new());
        }
        self.note_select(host, 0, next, place);
        let Some((first, behind)) = self.following(host, next, place) else { return Ok(Vec::new()) };
        let is_corner = match &first.statement {
            Statement::Path { shape: Shape::Chamfer | Shape::Round, .. } => true,
            Statement::Path { shape: Shape::Iso, words, .. } => words.iter().any(|word| {
                &*word.name == "G"
                    && matches!(word.operand, super::words::Operand::Number(_, value) if value == 24.0 || value == 25.0)
            }),
            _ => false,
        };
        if !approach && !is_corner && !matches!(shape, Shape::FreeLine { .. }) {
            return Ok(Vec::new());
        }
        let mut steps = Vec::new();
        let mut modes = self.modes;
        if let Statement::Path { shape, iso, words } = &first.statement {
            for (shape, iso, words) in self.elements_ahead(host, &mut modes, (*shape, *iso, words)) {
                let mut seen = Evaluator::new(&mut self.variables, host).seen(&words)?;
                self.cycles.contours.unroll(&mut seen);
                // The line of a corner follows from what it was read from.
                let line = behind.saturating_sub(1);
                steps.push(Step { shape, iso, seen, line, number: first.number, rapid: None });
            }
        }
        let elements = matches!(shape, Shape::FreeLine { .. } | Shape::FreeArc { .. });
        if is_corner || elements {
            self.note_select(host, 1, behind, place);
            steps.extend(self.next_steps(host, modes, behind, place)?);
        }
        Ok(steps)
    }

    /// FSELECT behind as many elements that follow.
    fn note_select(&mut self, host: &mut dyn Host, behind: usize, from: u32, place: Place) {
        let mut line = from;
        while line <= place.range.last && line < from.saturating_add(NEAR) {
            let Ok(read) = self.line(host, line) else { return };
            match &read.statement {
                Statement::Nothing => line = read.next,
                Statement::Path { shape: Shape::FreeSelect, words, .. } => {
                    let number = words.iter().find_map(|word| match &word.operand {
                        super::words::Operand::Number(_, value) => Some(*value as usize),
                        _ => None,
                    });
                    self.path.free.selects.extend(number.map(|number| (behind, number, line)));
                    return;
                }
                _ => return,
            }
        }
    }

    /// The next path block as the program comes to it, with the one after it where it is a pole; assignments on the way are taken
    /// back.
    fn next_steps(
        &mut self,
        host: &mut dyn Host,
        mut modes: Modes,
        from: u32,
        place: Place,
    ) -> Result<Vec<Step>, Halt> {
        let (mut before, mut steps) = (Vec::new(), Vec::new());
        let mut next = Some(from);
        let mut done = Ok(());
        while let Some(line) = next.take() {
            match self.run_to_steps(host, &mut modes, (line, place), &mut before) {
                Ok(Some((found, behind))) => {
                    self.note_select(host, steps.len() + 2, behind, place);
                    let is_pole = found.len() == 1 && found.first().is_some_and(|step| step.shape == Shape::Pole);
                    next = (is_pole && steps.is_empty()).then_some(behind);
                    steps.extend(found);
                }
                Ok(None) => {}
                Err(halt) => done = Err(halt),
            }
        }
        for (name, value) in before.into_iter().rev() {
            self.variables.put_back(name, value);
        }
        done.map(|()| steps)
    }

    /// The path blocks of a block, which are several in an ISO program on a machine of conversational words.
    fn elements_ahead(
        &mut self,
        host: &dyn Host,
        modes: &mut Modes,
        (shape, iso, words): (Shape, bool, &[Word]),
    ) -> Vec<(Shape, bool, Vec<Word>)> {
        let elements = if shape == Shape::Iso && self.is_translated(host) { modes.read(words) } else { None };
        match elements {
            Some(elements) => elements.into_iter().map(|(shape, words)| (shape, false, words)).collect(),
            None => vec![(shape, iso, words.to_vec())],
        }
    }

    fn run_to_steps(
        &mut self,
        host: &mut dyn Host,
        modes: &mut Modes,
        (from, place): (u32, Place),
        before: &mut Vec<(Name, Option<Value>)>,
    ) -> Result<Option<(Vec<Step>, u32)>, Halt> {
        let mut line = from;
        for _ in 0..NEAR {
            let Some(read) = Some(line).filter(|line| *line <= place.range.last) else { return Ok(None) };
            let Ok(read) = self.line(host, read) else { return Ok(None) };
            line = match &read.statement {
                Statement::Nothing | Statement::Label(_) | Statement::Path { shape: Shape::FreeSelect, .. } => {
                    read.next
                }
                Statement::Assign(name, formula) => {
                    let value = Evaluator::new(&mut self.variables, host).value(formula)?;
                    before.push((*name, self.variables.get(*name)));
                    if !self.variables.set(*name, value) {
                        return Ok(None);
                    }
                    read.next
                }
                Statement::Branch(condition, to) if self.holds(host, condition)? => {
                    let label = self.label_of(host, to)?;
                    let Some(line) = self.find_label(host, &label) else { return Ok(None) };
                    line
                }
                Statement::Branch(..) => read.next,
                Statement::Path { shape, iso, words } => {
                    let mut steps = Vec::new();
                    for (shape, iso, words) in self.elements_ahead(host, modes, (*shape, *iso, words)) {
                        let mut seen = Evaluator::new(&mut self.variables, host).seen(&words)?;
                        self.cycles.contours.unroll(&mut seen);
                        steps.push(Step { shape, iso, seen, line: 0, number: read.number, rapid: None });
                    }
                    return Ok(Some((steps, read.next)));
                }
                _ => return Ok(None),
            };
        }
        Ok(None)
    }

    /// The next path block from a line on, with the line after it.
    fn following(&mut self, host: &mut dyn Host, from: u32, place: Place) -> Option<(std::sync::Arc<Line>, u32)> {
        let mut line = from;
        while line <= place.range.last && line < from.saturating_add(NEAR) {
            let read = self.line(host, line).ok()?;
            match &read.statement {
                Statement::Nothing | Statement::Path { shape: Shape::FreeSelect, .. } => line = read.next,
                Statement::Path { .. } => {
                    let next = read.next;
                    return Some((read, next));
                }
                _ => return None,
            }
        }
        None
    }
}
