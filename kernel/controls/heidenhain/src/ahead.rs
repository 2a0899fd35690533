//! The path blocks after a path block that its end depends on.
//!
//! Facts: programming manuals of the control (corners and approaches are computed with the next element). Decisions:
//! blocks without motion may come between a line and its corner; after a corner the look ahead follows assignments and
//! jumps, and ends at a call; after an approach it also follows calls of labels and of programs with the same unit. Invariant: a look ahead leaves the parameters as they were.

use counterpoint_control_api::host::{InterpreterHost, ProgramPlace};
use counterpoint_event::FileId;
use counterpoint_fault::Halt;

use super::approach::goes_in_plane;
use super::eval::Evaluator;
use super::iso_blocks::IsoModes;
use super::path_state::{PathBlock, PathBlockKind};
use super::q_parameter::{ParameterValue, QParameter};
use super::statement::HeidenhainStatement;
use super::words::{EvaluatedWord, HeidenhainWord, Operand};
use super::{Heidenhain, HeidenhainLine};

/// Blocks between a line and the corner or the path block after it.
const NEAR: u32 = 50;

/// Cycles between an approach and its contour that do not move it.
const DWELL: u32 = 9;
const TOLERANCE: u32 = 32;

impl Heidenhain {
    /// Reads path blocks ahead: a corner with the block after it, or the first element of a contour.
    pub(super) fn ahead(
        &mut self,
        host: &mut dyn InterpreterHost,
        shape: PathBlockKind,
        next: u32,
        place: ProgramPlace,
    ) -> Result<Vec<PathBlock>, Halt> {
        // The line after an arc may say where the arc ends.
        let to_contour = matches!(shape, PathBlockKind::Approach(_));
        let is_free_arc = matches!(shape, PathBlockKind::FreeArc { .. });
        let cuts = !matches!(
            shape,
            PathBlockKind::Pole
                | PathBlockKind::FreePole
                | PathBlockKind::FreeSelect
                | PathBlockKind::Chamfer
                | PathBlockKind::Round
                | PathBlockKind::Depart(_)
        );
        if !to_contour && !is_free_arc && !cuts {
            return Ok(Vec::new());
        }
        if to_contour {
            let mut run = PathLookAhead { calls: Some(Vec::new()), ..PathLookAhead::new(self.modes, place) };
            let steps = self.steps_to_motion(host, &mut run, next);
            self.put_back(run);
            return steps;
        }
        self.note_select(host, 0, next, place);
        let Some(first) = self.following(host, next, place) else { return Ok(Vec::new()) };
        let is_corner = match &first.statement {
            HeidenhainStatement::Path { shape: PathBlockKind::Chamfer | PathBlockKind::Round, .. } => true,
            HeidenhainStatement::Path { shape: PathBlockKind::Iso, words, .. } => {
                words.iter().any(|word| matches!(g_number(word), Some(24.0 | 25.0)))
            }
            _ => false,
        };
        let elements = matches!(shape, PathBlockKind::FreeLine { .. } | PathBlockKind::FreeArc { .. });
        if !is_free_arc && !is_corner && !elements {
            return Ok(Vec::new());
        }
        let mut run = PathLookAhead::new(self.modes, place);
        let steps = self.steps_from(host, &mut run, (next, place), is_corner || elements);
        self.put_back(run);
        steps
    }

    /// Gives the parameters the values that they had before a look ahead.
    fn put_back(&mut self, run: PathLookAhead) {
        for (name, value) in run.before.into_iter().rev() {
            self.variables.put_back(name, value);
        }
    }

    /// The path blocks up to the first one that moves in the plane.
    fn steps_to_motion(
        &mut self,
        host: &mut dyn InterpreterHost,
        run: &mut PathLookAhead,
        from: u32,
    ) -> Result<Vec<PathBlock>, Halt> {
        let (mut steps, mut behind) = (Vec::new(), from);
        for _ in 0..NEAR {
            let Some((found, after)) = self.run_to_steps(host, run, behind)? else { break };
            let plane = self.path.plane;
            let arrived = found.iter().any(|step| goes_in_plane(step, plane));
            steps.extend(found);
            if arrived {
                break;
            }
            behind = after;
        }
        Ok(steps)
    }

    /// The next path block, and with `more` the path block after it, with a pole between them.
    fn steps_from(
        &mut self,
        host: &mut dyn InterpreterHost,
        run: &mut PathLookAhead,
        (from, place): (u32, ProgramPlace),
        more: bool,
    ) -> Result<Vec<PathBlock>, Halt> {
        let Some((mut steps, mut behind)) = self.run_to_steps(host, run, from)? else {
            return Ok(Vec::new());
        };
        if !more {
            return Ok(steps);
        }
        self.note_select(host, 1, behind, place);
        for count in 2..=3 {
            let Some((found, after)) = self.run_to_steps(host, run, behind)? else { break };
            self.note_select(host, count, after, place);
            let is_pole = matches!(found.as_slice(), [step] if step.shape == PathBlockKind::Pole);
            steps.extend(found);
            if !is_pole {
                break;
            }
            behind = after;
        }
        Ok(steps)
    }

    /// Records FSELECT after this number of following elements.
    fn note_select(&mut self, host: &mut dyn InterpreterHost, behind: usize, from: u32, place: ProgramPlace) {
        let mut line = from;
        while line <= place.range.last && line < from.saturating_add(NEAR) {
            let Ok(read) = self.line(host, line) else { return };
            match &read.statement {
                HeidenhainStatement::Nothing => line = read.next,
                HeidenhainStatement::Path { shape: PathBlockKind::FreeSelect, words, .. } => {
                    let number = words.iter().find_map(|word| match &word.operand {
                        Operand::Number(_, value) => Some(*value as usize),
                        _ => None,
                    });
                    self.path.free.selects.extend(number.map(|number| (behind, number, line)));
                    return;
                }
                _ => return,
            }
        }
    }

    /// The path blocks of a block. In an ISO program on a machine with conversational words there may be several.
    fn elements_ahead(
        &mut self,
        host: &dyn InterpreterHost,
        modes: &mut IsoModes,
        (shape, iso, words): (PathBlockKind, bool, &[HeidenhainWord]),
    ) -> Vec<(PathBlockKind, bool, Vec<HeidenhainWord>)> {
        let elements = if shape == PathBlockKind::Iso && self.is_translated(host) { modes.read(words) } else { None };
        match elements {
            Some(elements) => elements.into_iter().map(|(shape, words)| (shape, false, words)).collect(),
            None => vec![(shape, iso, words.to_vec())],
        }
    }

    /// The path blocks of the next block with motion in program order, with the line after it.
    fn run_to_steps(
        &mut self,
        host: &mut dyn InterpreterHost,
        run: &mut PathLookAhead,
        from: u32,
    ) -> Result<Option<(Vec<PathBlock>, u32)>, Halt> {
        let mut line = from;
        for _ in 0..NEAR {
            let Some(read) = Some(line).filter(|line| *line <= run.last) else { return Ok(None) };
            let Ok(read) = self.line_in(host, run.file, read) else { return Ok(None) };
            line = match &read.statement {
                HeidenhainStatement::Nothing
                | HeidenhainStatement::Label(_)
                | HeidenhainStatement::Path { shape: PathBlockKind::FreeSelect, .. } => read.next,
                HeidenhainStatement::Assign(name, formula) => {
                    let value = Evaluator::new(&mut self.variables, host).value(formula)?;
                    run.before.push((*name, self.variables.get(*name)));
                    if !self.variables.set(*name, value) {
                        return Ok(None);
                    }
                    read.next
                }
                HeidenhainStatement::Branch(condition, to) if self.holds(host, condition)? => {
                    let label = self.label_of(host, to)?;
                    let Some(line) = self.find_label_in(host, run.file, &label) else { return Ok(None) };
                    line
                }
                HeidenhainStatement::Branch(..) => read.next,
                HeidenhainStatement::Stop(_)
                | HeidenhainStatement::ToolDefinition { .. }
                | HeidenhainStatement::CyclePart { cycle: DWELL | TOLERANCE, .. }
                    if run.calls.is_some() =>
                {
                    read.next
                }
                HeidenhainStatement::CallLabel { label, .. } if run.calls.is_some() => {
                    let label = self.label_of(host, label)?;
                    let Some(line) = self.find_label_in(host, run.file, &label) else { return Ok(None) };
                    run.enter(None, read.next);
                    line
                }
                HeidenhainStatement::CallProgram(name) if run.calls.is_some() => {
                    let name = self.text(host, name)?;
                    let Some((file, range)) = self.find_program(host, &name, false)? else { return Ok(None) };
                    run.enter(Some((file, range.last)), read.next);
                    range.first
                }
                // Positions of a program with another unit are not those of this one.
                HeidenhainStatement::Begin { inch, .. }
                    if run.is_in_program() && inch.is_none_or(|inch| inch == (host.length_factor() != 1.0)) =>
                {
                    read.next
                }
                HeidenhainStatement::EndOfLabel => {
                    let Some(line) = run.leave(false) else { return Ok(None) };
                    line
                }
                HeidenhainStatement::End => {
                    let Some(line) = run.leave(true) else { return Ok(None) };
                    line
                }
                HeidenhainStatement::Words(words)
                | HeidenhainStatement::Path { shape: PathBlockKind::Iso, words, .. }
                    if is_still(words) =>
                {
                    // Its modes apply to the following blocks.
                    if self.is_translated(host) {
                        run.modes.read(words);
                    } else {
                        let said = words.iter().filter(|word| &*word.name == "G").cloned().collect::<Vec<_>>();
                        run.said.extend(Evaluator::new(&mut self.variables, host).seen(&said)?);
                    }
                    read.next
                }
                HeidenhainStatement::Path { shape, iso, words } => {
                    let mut steps = Vec::new();
                    for (shape, iso, words) in self.elements_ahead(host, &mut run.modes, (*shape, *iso, words)) {
                        let mut seen = run.said.clone();
                        seen.extend(Evaluator::new(&mut self.variables, host).seen(&words)?);
                        self.cycles.contours.unroll(&mut seen);
                        // The line of a corner follows the place where the corner was read.
                        let line = read.next.saturating_sub(1);
                        steps.push(PathBlock { shape, iso, seen, line, number: read.number, rapid: None });
                    }
                    return Ok(Some((steps, read.next)));
                }
                _ => return Ok(None),
            };
        }
        Ok(None)
    }

    /// The next path block from a line on, after blocks without motion; nothing is evaluated.
    fn following(
        &mut self,
        host: &mut dyn InterpreterHost,
        from: u32,
        place: ProgramPlace,
    ) -> Option<std::sync::Arc<HeidenhainLine>> {
        let mut line = from;
        while line <= place.range.last && line < from.saturating_add(NEAR) {
            let read = self.line(host, line).ok()?;
            match &read.statement {
                HeidenhainStatement::Nothing
                | HeidenhainStatement::Label(_)
                | HeidenhainStatement::Assign(..)
                | HeidenhainStatement::Path { shape: PathBlockKind::FreeSelect, .. } => line = read.next,
                HeidenhainStatement::Words(words)
                | HeidenhainStatement::Path { shape: PathBlockKind::Iso, words, .. }
                    if is_still(words) =>
                {
                    line = read.next;
                }
                HeidenhainStatement::Path { .. } => return Some(read),
                _ => return None,
            }
        }
        None
    }
}

/// The state of a look ahead.
struct PathLookAhead {
    modes: IsoModes,
    /// G words of blocks without motion that are not converted to modes.
    said: Vec<EvaluatedWord>,
    /// Parameters changed by assignments in between, with their previous values.
    before: Vec<(QParameter, Option<ParameterValue>)>,
    /// The file that it reads, and the last line of the program there.
    file: FileId,
    last: u32,
    /// The calls that it is in; none if it ends at a call.
    calls: Option<Vec<LookAheadReturn>>,
}

/// Where a look ahead continues after a call.
struct LookAheadReturn {
    file: FileId,
    last: u32,
    line: u32,
    /// A program was called, not a label.
    program: bool,
}

impl PathLookAhead {
    fn new(modes: IsoModes, place: ProgramPlace) -> Self {
        let (file, last) = (place.file, place.range.last);
        Self { modes, said: Vec::new(), before: Vec::new(), file, last, calls: None }
    }

    /// Enters a label, or a program with its file and last line.
    fn enter(&mut self, program: Option<(FileId, u32)>, line: u32) {
        let caller = LookAheadReturn { file: self.file, last: self.last, line, program: program.is_some() };
        self.calls.get_or_insert_default().push(caller);
        (self.file, self.last) = program.unwrap_or((self.file, self.last));
    }

    /// Leaves a label or a program; the line after its call.
    fn leave(&mut self, program: bool) -> Option<u32> {
        let caller = self.calls.as_mut()?.pop_if(|caller| caller.program == program)?;
        (self.file, self.last) = (caller.file, caller.last);
        Some(caller.line)
    }

    fn is_in_program(&self) -> bool {
        self.calls.iter().flatten().any(|caller| caller.program)
    }
}

/// Number of a G word.
fn g_number(word: &HeidenhainWord) -> Option<f64> {
    match word.operand {
        Operand::Number(_, value) if &*word.name == "G" => Some(value),
        _ => None,
    }
}

/// Whether a block between a line and its corner neither moves nor calls. It sets a speed, a feed or the radius of a
/// soft approach or departure, or has switching M functions, or motion words and G90 and G91 without a position.
fn is_still(words: &[HeidenhainWord]) -> bool {
    let soft = words.iter().any(|word| matches!(g_number(word), Some(26.0 | 27.0)));
    let soft = soft && words.iter().all(|word| matches!(&*word.name, "G" | "R"));
    soft || !words.is_empty()
        && words.iter().all(|word| match (&*word.name, &word.operand) {
            ("S" | "F", _) => true,
            ("M", Operand::Number(_, number)) => *number < 89.0 && !matches!(*number, 2.0 | 6.0 | 30.0),
            ("G", Operand::Number(_, number)) => matches!(*number, 0.0 | 1.0 | 90.0 | 91.0),
            _ => false,
        })
}
