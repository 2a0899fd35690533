//! A contour cut into parts that rise or fall in both directions, and where a level meets them.
//!
//! *Invariant:* parts follow each other without gaps; a level meets a part at most once.

use std::f64::consts::FRAC_PI_2;

use super::view::CutView;
use super::{BACK, ContourError, NOISE};
use crate::contour::element::{Element, Spot, angle};

/// A quarter of an arc at most, or a line, in the view of the cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ContourPart {
    pub(super) from: Spot,
    pub(super) to: Spot,
    /// Centre, and whether it turns clockwise in the view.
    pub(super) arc: Option<(Spot, bool)>,
}

impl ContourPart {
    /// Where it meets a level between its ends.
    pub(super) fn meets(&self, level: f64) -> f64 {
        let ([from, low], [to, high]) = (self.from, self.to);
        if (high - low).abs() < NOISE {
            return from;
        }
        let Some(([center, middle], _)) = self.arc else {
            let share = ((level - low) / (high - low)).clamp(0.0, 1.0);
            return from + (to - from) * share;
        };
        let radius = libm::hypot(from - center, low - middle);
        let half = (radius * radius - (level - middle) * (level - middle)).max(0.0).sqrt();
        let side = if (from + to) / 2.0 >= center { half } else { -half };
        (center + side).clamp(from.min(to), from.max(to))
    }
}

/// A place on a contour: the part, and how far along the cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ContourPosition {
    pub(super) part: usize,
    pub(super) along: f64,
}

/// A stretch along a level in which the contour is nowhere above it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LevelStretch {
    /// Where it begins on the contour; none if the level is open at the start of the cycle.
    pub(super) begin: Option<ContourPosition>,
    pub(super) end: ContourPosition,
}

/// The parts of a contour.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ContourParts {
    pub(super) all: Vec<ContourPart>,
    /// Parts of the last piece.
    last: usize,
}

impl ContourParts {
    /// These parts, of no piece that leaves the contour.
    pub(super) fn made_of(all: Vec<ContourPart>) -> Self {
        Self { all, last: 0 }
    }

    /// The parts of pieces.
    pub(super) fn of(elements: &[Element], view: &CutView) -> Self {
        let (mut all, mut before) = (Vec::new(), 0);
        for element in elements {
            before = all.len();
            let (from, to) = (view.see(element.from), view.see(element.to));
            match &element.arc {
                None => all.push(ContourPart { from, to, arc: None }),
                Some(arc) => {
                    let over = if view.turns_over() { -arc.sweep } else { arc.sweep };
                    quarters(&mut all, (from, to), view.see(arc.center), (arc.radius, over));
                }
            }
        }
        Self { last: all.len() - before, all }
    }

    /// The lowest point.
    pub(super) fn lowest(&self) -> f64 {
        self.all.iter().fold(f64::INFINITY, |low, part| low.min(part.from[1]).min(part.to[1]))
    }

    /// The highest point.
    pub(super) fn highest(&self) -> f64 {
        self.all.iter().fold(f64::NEG_INFINITY, |high, part| high.max(part.from[1]).max(part.to[1]))
    }

    /// Refuses a contour that cannot be cut from a start point. `leaves`: the last piece may end beyond that point.
    pub(super) fn check(&self, [start, top]: Spot, leaves: bool) -> Result<(), ContourError> {
        let Some(first) = self.all.first() else { return Err(ContourError::Nothing) };
        let finite = |spot: &Spot| spot.iter().all(|part| part.is_finite());
        if !self.all.iter().all(|part| finite(&part.from) && finite(&part.to)) {
            return Err(ContourError::Nothing);
        }
        let mut reached = first.from[0];
        for part in &self.all {
            if part.to[0] < reached - BACK {
                return Err(ContourError::TurnsBack);
            }
            reached = reached.max(part.to[0]);
        }
        let shaping = self.all.len().saturating_sub(if leaves { self.last } else { 0 });
        let above = self.all.iter().take(shaping).any(|part| part.from[1] > top + BACK || part.to[1] > top + BACK);
        if above || first.from[0] < start - BACK { Err(ContourError::BeyondStart) } else { Ok(()) }
    }

    /// The stretches of a level, in order.
    pub(super) fn stretches(&self, level: f64) -> Vec<LevelStretch> {
        let mut found = Vec::new();
        let Some(first) = self.all.first() else { return found };
        let mut begin = (first.from[1] <= level + NOISE).then_some(None);
        for (index, part) in self.all.iter().enumerate() {
            let mark = || ContourPosition { part: index, along: part.meets(level) };
            match begin {
                Some(at) if part.to[1] > level + NOISE => {
                    found.push(LevelStretch { begin: at, end: mark() });
                    begin = None;
                }
                None if part.to[1] <= level + NOISE => begin = Some(Some(mark())),
                _ => {}
            }
        }
        if let (Some(at), Some(last)) = (begin, self.all.last()) {
            found
                .push(LevelStretch { begin: at, end: ContourPosition { part: self.all.len() - 1, along: last.to[0] } });
        }
        found
    }

    /// The first of the parts that fall without a stop up to this one.
    pub(super) fn descent(&self, part: usize) -> usize {
        let falls = |index: usize| self.all.get(index).is_some_and(|part| part.from[1] > part.to[1] + NOISE);
        (0..part).rev().take_while(|&index| falls(index)).last().unwrap_or(part)
    }

    /// Whether no part between these rises.
    pub(super) fn falls(&self, from: usize, to: usize) -> bool {
        let parts = self.all.get(from..=to).unwrap_or_default();
        parts.iter().all(|part| part.to[1] <= part.from[1] + NOISE)
    }
}

/// The quarters of an arc.
fn quarters(all: &mut Vec<ContourPart>, (from, to): (Spot, Spot), center: Spot, (radius, sweep): (f64, f64)) {
    let start = angle(center, from);
    let clockwise = sweep < 0.0;
    let turn = sweep.signum();
    let mut here = from;
    let mut quarter = if clockwise { (start / FRAC_PI_2).ceil() - 1.0 } else { (start / FRAC_PI_2).floor() + 1.0 };
    // A full circle has five at most.
    for _ in 0..5 {
        let way = (quarter * FRAC_PI_2 - start) * turn;
        if way >= sweep.abs() - 1e-9 {
            break;
        }
        if way > 1e-9 {
            let corner = corner(quarter, center, radius);
            all.push(ContourPart { from: here, to: corner, arc: Some((center, clockwise)) });
            here = corner;
        }
        quarter += turn;
    }
    all.push(ContourPart { from: here, to, arc: Some((center, clockwise)) });
}

/// The point of a circle at a whole quarter.
fn corner(quarter: f64, [along, across]: Spot, radius: f64) -> Spot {
    match quarter.rem_euclid(4.0) as u8 {
        0 => [along + radius, across],
        1 => [along, across + radius],
        2 => [along - radius, across],
        _ => [along, across - radius],
    }
}
