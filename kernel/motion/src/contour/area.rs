//! An area inside a closed rim and outside islands, as a tool with a radius can clear it.
//!
//! The area lies on the left of all rings: the rim turns counter-clockwise, islands clockwise. If the first ring is the
//! rim of a blank, the tool may leave it, and the other rings are spigots that remain. *Invariant:* every path of the
//! tool's centre keeps its distance from all walls. Where a passage is narrower than that, the path goes around the
//! area that the tool reaches.

use super::element::{Element, NOISE, cross, distance};
use super::near::{at, turned};
use crate::arc::PlaneArc;

/// A ring that is not a closed contour with an area.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OpenRing;

/// Rim and islands.
#[derive(Debug, Clone, Default)]
pub struct ClearingArea {
    pub(super) rings: Vec<Vec<Element>>,
    /// How far beyond the first ring, which is not a wall, the tool goes.
    pub(super) beyond: Option<f64>,
    /// Radius of a tool that has cleared it before, and how far both stay away from the walls besides their radii.
    pub(super) earlier: Option<(f64, f64)>,
}

impl ClearingArea {
    /// Takes a ring more, the rim first; how many there are.
    ///
    /// # Errors
    /// It is not closed, or has no area.
    pub fn add(&mut self, contour: &[Element]) -> Result<usize, OpenRing> {
        let (Some(first), Some(last)) = (contour.first(), contour.last()) else { return Err(OpenRing) };
        let size = size(contour);
        if distance(first.from, last.to) > 1e-4 || size.abs() < NOISE {
            return Err(OpenRing);
        }
        let rim = self.rings.is_empty();
        let turned = if (size > 0.0) == rim { contour.to_vec() } else { backwards(contour) };
        self.rings.push(begun_within(turned));
        Ok(self.rings.len())
    }

    /// The first ring is the rim of a blank: the tool may be beyond it by an amount.
    pub fn leave(&mut self, beyond: f64) {
        self.beyond = Some(beyond);
    }

    /// A tool of a radius has cleared it before; both tools keep away from the walls by an amount besides their radii.
    pub fn follow(&mut self, radius: f64, away: f64) {
        self.earlier = Some((radius, away));
    }
}

/// Size of the area that a ring surrounds, positive if the ring turns counter-clockwise.
pub(super) fn size(ring: &[Element]) -> f64 {
    let piece = |piece: &Element| {
        let bow = piece.arc.map_or(0.0, |arc| arc.radius * arc.radius * (arc.sweep - libm::sin(arc.sweep)) / 2.0);
        cross(piece.from, piece.to) / 2.0 + bow
    };
    ring.iter().map(piece).sum()
}

/// A path or ring in the opposite direction.
#[must_use]
pub fn backwards(ring: &[Element]) -> Vec<Element> {
    ring.iter().rev().map(turned).collect()
}

/// The ring from the middle of its first straight piece on, so that its end has no corner.
fn begun_within(mut ring: Vec<Element>) -> Vec<Element> {
    let first = ring.iter().position(|piece| piece.arc.is_none()).unwrap_or(0);
    ring.rotate_left(first);
    let Some(piece) = ring.first().copied() else { return ring };
    let middle = at(&piece, 0.5);
    let halves = match piece.arc {
        None => [Element { to: middle, ..piece }, Element { from: middle, ..piece }],
        Some(arc) => {
            let half = PlaneArc { sweep: arc.sweep / 2.0, ..arc };
            let rest = PlaneArc { start_angle: arc.start_angle + half.sweep, ..half };
            [Element { to: middle, arc: Some(half), ..piece }, Element { from: middle, arc: Some(rest), ..piece }]
        }
    };
    let [before, behind] = halves;
    if let Some(slot) = ring.first_mut() {
        *slot = behind;
    }
    ring.push(before);
    ring
}
