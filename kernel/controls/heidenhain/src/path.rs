//! Path blocks: elements that the tables of a machine cannot express are reduced to straight lines and circles.
//!
//! Facts: programming manuals of the control (path functions, polar coordinates, corners). Decisions: a block that is
//! completely defined by its words is not changed; others become blocks with positions. Invariant: positions are in the
//! units of the program, in its frame.

use counterpoint_control_api::contour::{Point, direction, minus};
use counterpoint_control_api::host::InterpreterHost;
use counterpoint_fault as diag;
use counterpoint_fault::Halt;

use super::path_state::{AXES, PathBlock, PathBlockKind, PathBuilder, PathState, Position, actual, axis};
use super::words::{EvaluatedWord, LeftBlock, MADE, headed};

/// Executes a path block; returns the remaining blocks.
pub(super) fn walk(
    path: &mut PathState,
    host: &mut dyn InterpreterHost,
    step: &PathBlock,
    ahead: &[PathBlock],
) -> Result<Vec<LeftBlock>, Halt> {
    let actual = actual(host);
    let start = path.base.unwrap_or(actual);
    let mut walk = PathBuilder { path, host, step, ahead, actual, start, refused: None };
    let mut lines = walk.lines()?;
    walk.remember();
    walk.feeds(&mut lines);
    walk.refused.map_or(Ok(lines), Err)
}

impl PathBuilder<'_> {
    /// Refuses the block: the control raises an alarm if a path block cannot be made.
    pub(super) fn refuse(&mut self, why: &str) {
        if self.refused.is_none() {
            let text = format!("{why}, in '{}'", self.host.block_text());
            self.refused = Some(self.host.alarm(&diag::PATH_REFUSED, text));
        }
    }

    fn lines(&mut self) -> Result<Vec<LeftBlock>, Halt> {
        self.note_words();
        let step = self.step;
        if step.seen.iter().any(|word| word.is("G") && matches!(word.value, Some(26.0 | 27.0))) {
            self.refuse("G26 and G27 stand in a block of their own, with R alone");
            return Ok(Vec::new());
        }
        if step.shape == PathBlockKind::FreeSelect {
            self.select();
            return Ok(Vec::new());
        }
        let shape = if step.shape == PathBlockKind::Iso { self.iso_shape() } else { step.shape };
        // Only the next block with motion can make a corner.
        let corner = if shape == PathBlockKind::Iso { None } else { self.path.corner.take() };
        Ok(match shape {
            PathBlockKind::Line | PathBlockKind::Space => self.line(),
            PathBlockKind::Arc | PathBlockKind::Radius => self.circle(shape),
            PathBlockKind::Tangent => {
                let end = self.target();
                self.tangent(end)
            }
            PathBlockKind::PolarLine | PathBlockKind::PolarArc | PathBlockKind::PolarTangent
                if self.path.poles.upright.is_some() =>
            {
                self.path.poles.upright.map_or_else(Vec::new, |upright| self.upright_polar(upright, shape))
            }
            PathBlockKind::PolarLine => self.polar_line(),
            PathBlockKind::PolarArc => self.polar_arc(),
            PathBlockKind::PolarTangent => match self.polar_end() {
                Some((end, _)) => self.tangent(end),
                None => Vec::new(),
            },
            PathBlockKind::Pole => self.pole(),
            PathBlockKind::Chamfer | PathBlockKind::Round => self.corner(corner),
            PathBlockKind::Approach(way) => self.approach(way),
            PathBlockKind::Depart(way) => self.depart(way),
            PathBlockKind::FreePole => self.free_pole(),
            PathBlockKind::FreeSelect => Vec::new(),
            PathBlockKind::FreeLine { tangent } => self.free_line(tangent)?,
            PathBlockKind::FreeArc { tangent } => self.free_arc(tangent)?,
            PathBlockKind::Iso => vec![self.verbatim(Vec::new())],
        })
    }

    /// Words for later blocks.
    fn note_words(&mut self) {
        for word in &self.step.seen {
            let path = &mut *self.path;
            match (&*word.name, word.value) {
                ("G", Some(17.0)) => path.plane = [0, 1],
                ("G", Some(18.0)) => path.plane = [2, 0],
                ("G", Some(19.0)) => path.plane = [1, 2],
                ("G", Some(90.0)) => path.increments = false,
                ("G", Some(91.0)) => path.increments = true,
                ("G", Some(40.0)) | ("R", Some(0.0)) if word.is("G") || word.is_off() => path.side.is_left = None,
                ("RL", None) | ("G", Some(41.0)) => path.side.is_left = Some(true),
                ("RR", None) | ("G", Some(42.0)) => path.side.is_left = Some(false),
                ("DR", None) => path.clockwise = Some(word.turns() == Some(true)),
                _ => {}
            }
        }
    }

    /// The block as it is, with words of the pre-processor after.
    pub(super) fn verbatim(&mut self, more: Vec<EvaluatedWord>) -> LeftBlock {
        let mut head = self.step.shape.head();
        let mut own = None;
        let has_motion = self.step.seen.iter().any(|word| {
            word.is("G") && word.value.is_some_and(|value| matches!(value as u32, 0..=3 | 5..=7 | 10..=16))
        });
        let moves = self.step.seen.iter().any(|word| axis(&word.name).is_some() && word.value.is_some());
        if self.step.shape == PathBlockKind::Iso && !has_motion && moves {
            match self.path.mode {
                // Axis words of a conversational block without a keyword are a straight line.
                None => head = self.line_code(),
                Some(mode) if self.path.restate => {
                    own = Some(EvaluatedWord::made("G", f64::from(self.plain_mode(mode))))
                }
                Some(_) => {}
            }
        }
        if has_motion || moves {
            self.path.restate = false;
        }
        let words = own.into_iter().chain(self.step.seen.iter().cloned()).chain(more);
        headed(head, words)
    }

    pub(super) fn line_code(&self) -> &'static str {
        match self.step.iso && self.path.mode.is_some() {
            true if matches!(self.path.mode, Some(0 | 10)) => "G0",
            true => "G1",
            false if self.host.is_code_text("L") => "L",
            false => "G1",
        }
    }

    pub(super) fn flat(&self, position: &Position) -> Point {
        self.path.plane.map(|axis| position.get(axis).copied().unwrap_or(0.0))
    }

    pub(super) fn put(&self, position: &mut Position, point: Point) {
        for (axis, value) in self.path.plane.into_iter().zip(point) {
            if let Some(slot) = position.get_mut(axis) {
                *slot = value;
            }
        }
    }

    /// Where the words of a block lead to from a point.
    pub(super) fn target_of(&self, seen: &[EvaluatedWord], start: &Position) -> Position {
        let mut end = *start;
        // The words of a later block decide whether it counts in increments.
        let own = seen.iter().rfind(|word| word.is("G") && matches!(word.value, Some(90.0 | 91.0)));
        let increments = own.map_or(self.path.increments, |word| word.value == Some(91.0));
        for word in seen {
            let (Some((axis, incremental)), Some(value)) = (axis(&word.name), word.value) else { continue };
            if let (Some(slot), Some(from)) = (end.get_mut(axis), start.get(axis)) {
                *slot = if incremental || increments { from + value } else { value };
            }
        }
        end
    }

    pub(super) fn target(&self) -> Position {
        self.target_of(&self.step.seen, &self.start)
    }

    /// Axes that the block names.
    pub(super) fn coded(&self) -> [bool; AXES.len()] {
        let mut coded = [false; AXES.len()];
        for word in &self.step.seen {
            if let (Some((axis, _)), Some(_)) = (axis(&word.name), word.value)
                && let Some(slot) = coded.get_mut(axis)
            {
                *slot = true;
            }
        }
        coded
    }

    /// Words of the plane and of the axes that the block names, for a position.
    pub(super) fn positions(&self, from: &Position, to: &Position) -> Vec<EvaluatedWord> {
        let coded = self.coded();
        let mut out = Vec::new();
        for (at, letter) in AXES.iter().enumerate() {
            if coded.get(at) == Some(&true) || self.path.plane.contains(&at) {
                let (Some(from), Some(to)) = (from.get(at), to.get(at)) else { continue };
                let named =
                    |word: &&EvaluatedWord| word.value.is_some() && axis(&word.name).is_some_and(|(own, _)| own == at);
                let span = self.step.seen.iter().find(named).map_or(MADE, |word| word.span);
                out.push(EvaluatedWord {
                    span,
                    ..EvaluatedWord::made(letter, if self.path.increments { to - from } else { *to })
                });
            }
        }
        out
    }

    /// Words of the block that are neither positions nor used by the pre-processor.
    pub(super) fn others(&self, used: &[&str]) -> Vec<EvaluatedWord> {
        let motion = |word: &EvaluatedWord| {
            word.is("G") && word.value.is_some_and(|value| matches!(value as u32, 0..=3 | 5..=7 | 10..=16 | 24..=29))
        };
        let position = |word: &EvaluatedWord| word.value.is_some() && axis(&word.name).is_some();
        let is_used = |word: &EvaluatedWord| used.contains(&&*word.name);
        let seen = self.step.seen.iter();
        seen.filter(|word| !motion(word) && !position(word) && !is_used(word)).cloned().collect()
    }

    /// A straight line to a position.
    pub(super) fn straight(&mut self, to: &Position, others: Vec<EvaluatedWord>) -> LeftBlock {
        let code = self.line_code();
        self.path.restate = true;
        let words = self.positions(&self.actual, to);
        headed(code, words.into_iter().chain(others))
    }

    pub(super) fn head_for(&mut self, vector: Point) {
        if let Some(heading) = direction(vector) {
            self.path.heading = Some(heading);
        }
    }

    fn line(&mut self) -> Vec<LeftBlock> {
        let end = self.target();
        let (start, to) = (self.flat(&self.start), self.flat(&end));
        let base = self.path.base.take();
        let own = counterpoint_control_api::contour::line(self.flat(&self.actual), to);
        let line = match self.corner_ahead(own, &end) {
            Some(corner_start) => {
                let mut short = end;
                self.put(&mut short, corner_start);
                self.path.base = Some(end);
                self.straight(&short, self.others(&[]))
            }
            None if base.is_some() && self.has_increments() => self.straight(&end, self.others(&[])),
            None => self.verbatim(Vec::new()),
        };
        self.head_for(minus(to, start));
        self.ends_at(to);
        self.path.round = false;
        let mut line = line;
        if std::mem::take(&mut self.path.side.ends)
            && !self.step.seen.iter().any(|word| word.is("RL") || word.is("RR") || word.is_off())
            && !self.step.iso
        {
            line.push(EvaluatedWord::text("R0"));
        }
        vec![line]
    }

    pub(super) fn has_increments(&self) -> bool {
        self.path.increments || self.step.seen.iter().any(|word| axis(&word.name).is_some_and(|(_, by)| by))
    }
}
