//! The shape of a blank: where levels have material, and how the tool goes between.
//!
//! Facts: programming manual of the control, LAP4: the tool cuts from the clearance before the blank to the clearance
//! after it, and goes at rapid where there is none. Decisions: nothing lies before the first point of the shape; behind
//! its last one there is material, so that the tool does not go there at rapid. *Invariant:* stretches of a level are
//! in order and do not touch.

use super::NOISE;
use super::parts::ContourParts;
use super::view::CutView;
use crate::contour::element::Element;

/// How far before and behind material the tool cuts.
const CLEARANCE: f64 = 2.0;

/// A blank, as a cycle sees it.
#[derive(Debug)]
pub(super) struct Blank {
    parts: ContourParts,
}

impl Blank {
    /// Of the pieces of its shape; none without one.
    pub(super) fn of(elements: &[Element], view: &CutView) -> Option<Self> {
        let parts = ContourParts::of(elements, view);
        (!parts.all.is_empty()).then_some(Self { parts })
    }

    /// The highest place.
    pub(super) fn highest(&self) -> f64 {
        self.parts.highest()
    }

    /// Where the tool cuts on a level between two places.
    pub(super) fn cuts(&self, level: f64, [from, to]: [f64; 2]) -> Vec<[f64; 2]> {
        let mut here = self.parts.all.first().map_or(from, |first| first.from[0]);
        let mut material = Vec::new();
        for stretch in self.parts.stretches(level) {
            material.push([here, stretch.begin.map_or(here, |begin| begin.along)]);
            here = here.max(stretch.end.along);
        }
        material.push([here, f64::INFINITY]);
        let mut cuts: Vec<[f64; 2]> = Vec::new();
        for [begin, end] in material {
            if end - begin < NOISE || begin > to - NOISE {
                continue;
            }
            let cut = [(begin - CLEARANCE).max(from), (end + CLEARANCE).min(to)];
            match cuts.last_mut() {
                Some(last) if cut[0] <= last[1] + NOISE => last[1] = cut[1],
                _ => cuts.push(cut),
            }
        }
        cuts
    }
}
