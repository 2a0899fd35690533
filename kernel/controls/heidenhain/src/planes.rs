//! Tilted planes: PLANE and cycle 19.
//!
//! Facts: programming manuals of the control (PLANE functions, cycle 19, Q120 to Q122), reference heidenhain-cycles.md 6.
//! Decisions: cycle 19 has spatial angles, a missing one is 0, and moves the axes, by the point DIST behind the tip, where it
//! has a feed; a shift that was programmed before the plane is none of the plane, but one that is set to 0 in the plane is gone
//! (as programs of three machines reset their shifts before PLANE RESET). Invariant: the tables of the machine get
//! words with letters only.

use counterpoint_control_api::host::InterpreterHost;
use counterpoint_fault as diag;
use counterpoint_fault::Halt;

use super::Heidenhain;
use super::eval::Evaluator;
use super::foreign_axes::refuse_axes;
use super::path_state::{AXES, axis};
use super::q_parameter::{ParameterKind, ParameterValue, QParameter};
use super::shifts::{SPACE, Shifts, cycle};
use super::words::{EvaluatedWord, HeidenhainWord, LeftBlock, headed};

/// The remains of planes.
#[derive(Debug, Default)]
pub(super) struct Planes {
    /// A plane has been made or ended, Q120 to Q122 are not yet set.
    asked: bool,
    /// Shifts from before the plane, while there is one.
    before: Option<Shifts>,
    /// Axes whose shift from before was removed in the plane, bit by axis.
    taken: u32,
}

/// The behaviour of the rotary axes.
const BEHAVIOUR: [&str; 3] = ["MOVE", "TURN", "STAY"];

/// Words of a coordinate of the points of a plane, as the tables of the machine have them.
fn point_word(point: f64, axis: &str) -> Option<String> {
    let point = ["PA", "PB", "PC"].iter().enumerate().find(|(at, _)| *at as f64 + 1.0 == point)?.1;
    ["X", "Y", "Z"].contains(&axis).then(|| format!("{point}{axis}"))
}

/// `P1X+0` is read as two words.
fn points(seen: Vec<EvaluatedWord>) -> Vec<EvaluatedWord> {
    let mut out: Vec<EvaluatedWord> = Vec::with_capacity(seen.len());
    for word in seen {
        let name = out.last().filter(|last| last.is("P")).and_then(|last| point_word(last.value?, &word.name));
        match (name, word.value) {
            (Some(name), Some(_)) => {
                out.pop();
                out.push(word.renamed(&name));
            }
            _ => out.push(word),
        }
    }
    out
}

impl Heidenhain {
    /// PLANE: the remaining words.
    pub(super) fn plane(
        &mut self,
        host: &mut dyn InterpreterHost,
        words: &[HeidenhainWord],
    ) -> Result<Vec<LeftBlock>, Halt> {
        let mut seen = Evaluator::new(&mut self.variables, host).seen(words)?;
        if !seen.iter().any(|word| BEHAVIOUR.iter().any(|name| word.is(name))) {
            let text = format!("PLANE needs MOVE, TURN or STAY in '{}'", host.block_text());
            return Err(host.alarm(&diag::STATEMENT_UNKNOWN, text));
        }
        if seen.iter().any(|word| word.is("POINTS")) {
            seen = points(seen);
        }
        let max =
            |pair: &[EvaluatedWord]| matches!(pair, [way, max] if way.is("MB") && way.value.is_none() && max.is("MAX"));
        if let Some(at) = seen.windows(2).position(max) {
            // Up to the end of travel.
            seen.splice(at..at + 2, [EvaluatedWord::made("MB", -1.0)]);
        }
        let resets = seen.iter().any(|word| word.is("RESET"));
        if resets {
            refuse_axes(host, "PLANE RESET", &seen)?;
        }
        let taken = self.plane_begins(resets, seen.iter().any(|word| word.is("RELATIV")));
        Ok(std::iter::once(seen).chain(taken).collect())
    }

    /// Cycle 7 in a plane: a shift of 0 takes that of before away too, which comes back with no PLANE RESET.
    pub(super) fn take_shifts(&mut self, seen: &[EvaluatedWord]) {
        let Some(before) = &mut self.planes.before else { return };
        for word in seen.iter().filter(|word| word.value == Some(0.0)) {
            let Some((at, false)) = axis(&word.name).filter(|(at, _)| *at < SPACE) else { continue };
            if before.take_datum(at) {
                self.planes.taken |= 1 << at;
            }
        }
    }

    /// From here on, shifts of the program belong to the plane. After a reset, the earlier shifts apply again. Returns
    /// a block that restores the shifts that were removed.
    fn plane_begins(&mut self, reset: bool, added: bool) -> Option<LeftBlock> {
        self.planes.asked = true;
        if reset {
            let taken = std::mem::take(&mut self.planes.taken);
            if let Some(before) = self.planes.before.take().filter(|before| taken != 0 || *before != Shifts::default())
            {
                let ended = std::mem::replace(&mut self.shifts, before);
                self.shifts.take_beside(&ended);
            }
            if taken != 0 {
                let axes = AXES.iter().enumerate().filter(|(at, _)| taken & 1 << at != 0);
                return Some(cycle(7, axes.map(|(_, letter)| EvaluatedWord::made(letter, 0.0))));
            }
        } else {
            let before = std::mem::take(&mut self.shifts);
            self.shifts.take_beside(&before);
            if !added || self.planes.before.is_none() {
                self.planes.before.get_or_insert(before);
            }
        }
        None
    }

    /// Cycle 19 as the PLANE function that it is; none where the machine has none.
    pub(super) fn plane_cycle(&mut self, host: &dyn InterpreterHost, seen: &[EvaluatedWord]) -> Option<Vec<LeftBlock>> {
        let value = |name: &str| seen.iter().find(|word| word.is(name)).and_then(|word| word.value);
        let angles = ["A", "B", "C"].map(value);
        let ends = angles.iter().all(Option::is_none);
        if !host.is_code_text(if ends { "PLANE RESET STAY" } else { "PLANE SPATIAL" }) {
            return None;
        }
        let taken = self.plane_begins(ends, false);
        if ends {
            return Some(std::iter::once(headed("PLANE RESET STAY", [])).chain(taken).collect());
        }
        let words = ["SPA", "SPB", "SPC"].into_iter().zip(angles);
        let mut plane =
            headed("PLANE SPATIAL", words.map(|(name, angle)| EvaluatedWord::made(name, angle.unwrap_or(0.0))));
        match seen.iter().find(|word| word.is("F") || word.is("FMAX")) {
            None => plane.push(EvaluatedWord::text("STAY")),
            Some(feed) => {
                let back = EvaluatedWord::made("DIST", value("DIST").unwrap_or(0.0));
                plane.extend([EvaluatedWord::text("MOVE"), back, feed.clone()]);
            }
        }
        Some(vec![plane])
    }

    /// Q120 to Q122 after a plane: the positions of A, B and C that turn into it.
    pub(super) fn plane_angles(&mut self, host: &dyn InterpreterHost) {
        if !std::mem::take(&mut self.planes.asked) {
            return;
        }
        let angles = host.plane_angles().unwrap_or_default();
        for (index, letter) in (120..).zip(["A", "B", "C"]) {
            let angle =
                angles.iter().find(|(name, _)| name.eq_ignore_ascii_case(letter)).map_or(0.0, |(_, angle)| *angle);
            self.variables.set(QParameter { kind: ParameterKind::Q, index }, ParameterValue::Number(angle));
        }
    }
}
