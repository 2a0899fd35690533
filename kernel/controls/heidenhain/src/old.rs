//! Cycles 1 to 6 and 15 to 18: the lines of their definitions.
//!
//! Facts: programming and technical manuals of the control (lines of the cycles; system data ID30 by their numbers).
//! Decisions: a value is identified by its line and its letter, since the words are in the language of the programmer;
//! DR+ is 1, DR− is −1. Invariant: a definition says all data, those that it does not have are 0.

use super::path_state::AXES;
use super::words::EvaluatedWord;

/// System data ID30 by their numbers, from 1.
pub(super) type Data = [f64; 15];

pub(super) const CLEARANCE: usize = 1;
pub(super) const DEPTH: usize = 2;
pub(super) const INFEED: usize = 3;
pub(super) const PLUNGE_FEED: usize = 4;
const SIDES: [usize; 2] = [5, 6];
const SLOT: [usize; 2] = [7, 8];
const RADIUS: usize = 9;
pub(super) const FEED: usize = 10;
pub(super) const DIRECTION: usize = 11;
const DWELL: usize = 12;
const PITCH: usize = 13;
pub(super) const ALLOWANCE: usize = 14;
pub(super) const ANGLE: usize = 15;

/// Meaning of the numbers in lines that have no letter for them.
const LINES: [(u32, &[&[usize]]); 10] = [
    (1, &[&[CLEARANCE], &[DEPTH], &[INFEED], &[DWELL]]),
    (2, &[&[CLEARANCE], &[DEPTH], &[DWELL]]),
    (3, &[&[CLEARANCE], &[DEPTH], &[INFEED]]),
    (4, &[&[CLEARANCE], &[DEPTH], &[INFEED]]),
    (5, &[&[CLEARANCE], &[DEPTH], &[INFEED], &[RADIUS]]),
    (6, &[&[CLEARANCE, DEPTH], &[INFEED, ALLOWANCE], &[ANGLE]]),
    (15, &[&[CLEARANCE, DEPTH], &[INFEED, ALLOWANCE]]),
    (16, &[&[CLEARANCE, DEPTH], &[INFEED]]),
    (17, &[&[CLEARANCE], &[DEPTH], &[PITCH]]),
    (18, &[&[DEPTH], &[PITCH]]),
];

/// The lines whose F is that of milling, of cycles that have two.
fn mills(cycle: u32, line: u32) -> bool {
    matches!(cycle, 3..=5) && line > 3 || matches!(cycle, 6 | 16) && line > 2
}

/// The content of the lines of a definition.
pub(super) fn data<'s>(cycle: u32, lines: impl Iterator<Item = (u32, &'s [EvaluatedWord])>, plane: [usize; 2]) -> Data {
    let mut data = Data::default();
    let own = LINES.iter().find(|(known, _)| *known == cycle).map_or(&[][..], |(_, own)| own);
    for (line, words) in lines {
        let by_line = (line as usize).checked_sub(1).and_then(|at| own.get(at)).map_or(&[][..], |own| own);
        let mut by_line = by_line.iter().copied();
        for word in words {
            let side = plane.iter().position(|axis| AXES.get(*axis).is_some_and(|letter| word.is(letter)));
            let place = match (&*word.name, side) {
                ("DR", _) => Some(DIRECTION),
                ("F", _) if mills(cycle, line) => Some(FEED),
                ("F", _) => Some(PLUNGE_FEED),
                ("RADIUS", _) => Some(RADIUS),
                (_, Some(side)) if cycle == 3 => SLOT.get(side).copied(),
                (_, Some(side)) => SIDES.get(side).copied(),
                _ if word.value.is_none() => None,
                _ => by_line.next(),
            };
            let value =
                if word.is("DR") { Some(if word.turns() == Some(true) { -1.0 } else { 1.0 }) } else { word.value };
            if let (Some(slot), Some(value)) = (place.and_then(|place| data.get_mut(place - 1)), value) {
                *slot = value;
            }
        }
    }
    data
}
