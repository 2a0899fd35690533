//! Cycles 7, 8, 10, 11 and 26: active shift, mirror, rotation and scale.
//!
//! Facts: programming manuals of the control: a datum shift by incremental values adds to the active shift, a rotation
//! by IROT to the active angle; cycle 8 mirrors the axes that it names and no other, none ends it; cycle 26 changes the
//! axes that it names, about a centre or the datum; cycle 247 takes all of them away. Decision: cycles 11 and 26 are
//! one scale, the later one counts for its axes. Invariant: the tables of the machine get absolute values, and all axes
//! of a mirror or scale.

use counterpoint_control_api::host::InterpreterHost;

use super::path_state::{AXES, axis};
use super::words::{EvaluatedWord, LeftBlock, Rest, shown};

/// X, Y and Z come first; every other axis has its own shift, mirror and scale, in any active plane.
pub(super) const SPACE: usize = 3;

/// The words of the tables that end a mirror.
const NO_MIRROR: &str = "MIRROR OFF";

/// Words for the centre of a scale.
const CENTER: [&str; 3] = ["CCX", "CCY", "CCZ"];

/// Active values.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Shifts {
    datum: [f64; AXES.len()],
    angle: f64,
    mirrored: [bool; AXES.len()],
    factors: [f64; AXES.len()],
}

impl Default for Shifts {
    fn default() -> Self {
        Self { datum: Default::default(), angle: 0.0, mirrored: Default::default(), factors: [1.0; AXES.len()] }
    }
}

impl Shifts {
    /// The shift of an axis, 0 for X.
    pub(super) fn datum(&self, axis: usize) -> Option<f64> {
        self.datum.get(axis).copied()
    }

    /// Takes the shift of an axis away: whether there was one.
    pub(super) fn take_datum(&mut self, axis: usize) -> bool {
        self.datum.get_mut(axis).is_some_and(|datum| std::mem::take(datum) != 0.0)
    }

    /// Copies the shifts, mirrors and scales of the axes other than X, Y and Z.
    pub(super) fn take_beside(&mut self, other: &Self) {
        let beside = |at: &usize| *at >= SPACE;
        for at in (0..AXES.len()).filter(beside) {
            if let (Some(slot), Some(value)) = (self.datum.get_mut(at), other.datum.get(at)) {
                *slot = *value;
            }
            if let (Some(slot), Some(value)) = (self.mirrored.get_mut(at), other.mirrored.get(at)) {
                *slot = *value;
            }
            if let (Some(slot), Some(value)) = (self.factors.get_mut(at), other.factors.get(at)) {
                *slot = *value;
            }
        }
    }

    /// The angle of the rotation.
    pub(super) fn angle(&self) -> f64 {
        self.angle
    }

    /// Which axes are mirrored, bit 0 for X.
    pub(super) fn mirror_bits(&self) -> u32 {
        self.mirrored.iter().rev().fold(0, |bits, mirrored| bits * 2 + u32::from(*mirrored))
    }

    /// The factor of an axis, 0 for X.
    pub(super) fn factor(&self, axis: usize) -> Option<f64> {
        self.factors.get(axis).copied()
    }

    /// The words of a cycle: records the values that they set, makes incremental values absolute and supplies omitted
    /// values. Returns the blocks that have to precede them.
    pub(super) fn define(
        &mut self,
        host: &dyn InterpreterHost,
        cycle: u32,
        seen: &mut Vec<EvaluatedWord>,
    ) -> Vec<LeftBlock> {
        match cycle {
            7 => self.shift(seen),
            8 => return self.mirror(seen),
            10 => self.turn(seen),
            11 | 26 => self.scale(host, cycle, seen),
            247 => return std::mem::take(self).undone(),
            _ => {}
        }
        Vec::new()
    }

    fn shift(&mut self, seen: &mut [EvaluatedWord]) {
        for word in seen {
            let (Some((at, incremental)), Some(value)) = (axis(&word.name), word.value) else { continue };
            let Some(slot) = self.datum.get_mut(at) else { continue };
            *slot = if incremental { *slot + value } else { value };
            if incremental {
                *word = EvaluatedWord::made(AXES.get(at).copied().unwrap_or_default(), *slot);
            }
        }
    }

    /// An axis has no value; the mirror is at the datum.
    fn mirror(&mut self, seen: &mut Vec<EvaluatedWord>) -> Vec<LeftBlock> {
        let before = std::mem::take(&mut self.mirrored);
        for word in &mut *seen {
            let Some(at) = AXES.iter().position(|axis| word.is(axis)).filter(|_| word.value.is_none()) else {
                continue;
            };
            if let Some(slot) = self.mirrored.get_mut(at) {
                *slot = true;
                *word = EvaluatedWord::made(AXES.get(at).copied().unwrap_or_default(), 0.0);
            }
        }
        if !self.mirrored.contains(&true) {
            // A word that is not an axis stays, so that the tables refuse it.
            if seen.iter().all(|word| axis(&word.name).is_none()) {
                seen.clear();
            }
        } else if self.mirrored == before {
            return Vec::new();
        }
        if before.contains(&true) { vec![vec![EvaluatedWord::text(NO_MIRROR)]] } else { Vec::new() }
    }

    fn turn(&mut self, seen: &mut [EvaluatedWord]) {
        for word in seen {
            let Some(value) = word.value else { continue };
            match &*word.name {
                "ROT" => self.angle = value,
                "IROT" => {
                    self.angle += value;
                    let sign = if self.angle < 0.0 { "" } else { "+" };
                    let rest = Rest::Written(format!("{sign}{}", shown(self.angle)).into());
                    *word = EvaluatedWord { rest, span: word.span, ..EvaluatedWord::made("ROT", self.angle) };
                }
                _ => {}
            }
        }
    }

    fn scale(&mut self, host: &dyn InterpreterHost, cycle: u32, seen: &mut Vec<EvaluatedWord>) {
        for word in &*seen {
            match (AXES.iter().position(|axis| word.is(axis)), word.value) {
                (Some(at), Some(value)) => {
                    if let Some(slot) = self.factors.get_mut(at) {
                        *slot = value;
                    }
                }
                (_, Some(value)) if word.is("SCL") => {
                    self.factors = [1.0; AXES.len()];
                    self.factors.iter_mut().take(SPACE).for_each(|factor| *factor = value);
                }
                _ => {}
            }
        }
        if cycle == 26 {
            for (letter, factor) in AXES.into_iter().zip(self.factors) {
                if !seen.iter().any(|word| word.is(letter)) && factor != 1.0 {
                    seen.push(EvaluatedWord::made(letter, factor));
                }
            }
        }
        // Where the tables have words for the centre, one that is not there would be the place of the tool.
        for letter in CENTER {
            if host.is_register(letter) && !seen.iter().any(|word| word.is(letter)) {
                seen.push(EvaluatedWord::made(letter, 0.0));
            }
        }
    }

    /// The blocks that take all of it away.
    fn undone(self) -> Vec<LeftBlock> {
        let mut blocks = Vec::new();
        let shifted = AXES.iter().zip(self.datum).filter(|(_, datum)| *datum != 0.0);
        let words: Vec<EvaluatedWord> = shifted.map(|(letter, _)| EvaluatedWord::made(letter, 0.0)).collect();
        if !words.is_empty() {
            blocks.push(cycle(7, words));
        }
        if self.mirrored.contains(&true) {
            blocks.push(vec![EvaluatedWord::text(NO_MIRROR)]);
        }
        if self.angle != 0.0 {
            blocks.push(cycle(10, [EvaluatedWord::made("ROT", 0.0)]));
        }
        if self.factors != [1.0; AXES.len()] {
            blocks.push(cycle(11, [EvaluatedWord::made("SCL", 1.0)]));
        }
        blocks
    }
}

/// The definition of a cycle with its words.
pub(super) fn cycle(number: u32, words: impl IntoIterator<Item = EvaluatedWord>) -> LeftBlock {
    std::iter::once(EvaluatedWord::made("CYCL DEF ", f64::from(number))).chain(words).collect()
}
