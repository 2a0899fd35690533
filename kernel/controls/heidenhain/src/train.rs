//! Contour trains: the blocks of cycles 25 and 276.
//!
//! Facts: programming manuals of the control (Q1 to Q15 of the cycles; cycle 270 for the paths to and from the contour;
//! 276 goes at the heights of the contour, whose first block gives all three coordinates, lowered by Q1 in infeeds of
//! Q10). Decisions: the tool has the height of the contour element that it is beside; paths of cycle 270 have the
//! height of the end that they lead to or from. Refused: residual material (Q18).

use counterpoint_motion::arc::by_center;
use counterpoint_motion::contour::closed::{ClosedContour, is_clear};
use counterpoint_motion::contour::element::{Element, distance, plus};
use counterpoint_motion::contour::heights::heights;
use counterpoint_motion::contour::shifted::rounded;

use super::Heidenhain;
use super::clearing::{CycleBlockWriter, levels, within_reason};
use super::moves::{Moves, RAPID};
use counterpoint_control_api::host::InterpreterHost;

/// The path of a train.
struct Train {
    arrives: Option<Element>,
    way: Vec<Element>,
    leaves: Option<Element>,
    /// The tool is left of the contour (+1), right of it, or on it.
    side: Option<f64>,
    amount: f64,
}

/// The same way backwards.
fn backwards(way: &[(Element, [f64; 2])]) -> Vec<(Element, [f64; 2])> {
    let elements: Vec<Element> = way.iter().map(|(element, _)| *element).collect();
    let back = ClosedContour::open(elements).reversed();
    back.elements().iter().zip(way.iter().rev()).map(|(element, (_, [from, to]))| (*element, [*to, *from])).collect()
}

impl Heidenhain {
    /// How a train that cycle 270 describes begins or ends: a point, and the element from there or to it.
    fn train_end(&self, element: &Element, side: f64, arrives: bool, factor: f64) -> Result<Option<Element>, String> {
        let (at, heading) = if arrives { (element.from, element.start()) } else { (element.to, element.end()) };
        // Away from the contour, and back along it where the tool arrives.
        let across = [-heading[1] * side, heading[0] * side];
        let along = if arrives { -1.0 } else { 1.0 };
        let apart = self.sl(394) * factor;
        let outer = match self.sl(390) {
            1.0 => {
                let radius = self.sl(392) * factor;
                let center = plus(at, across, radius);
                let turn = self.sl(393).to_radians() * side * along;
                let (sine, cosine) = (libm::sin(turn), libm::cos(turn));
                let spoke = plus(at, center, -1.0);
                let outer =
                    plus(center, [spoke[0] * cosine - spoke[1] * sine, spoke[0] * sine + spoke[1] * cosine], 1.0);
                let (from, to) = if arrives { (outer, at) } else { (at, outer) };
                if radius <= 0.0 || distance(from, to) < 1e-7 {
                    return Ok(None);
                }
                return Ok(Some(Element { from, to, arc: by_center(from, to, center, side < 0.0).ok() }));
            }
            2.0 => plus(at, heading, along * apart),
            3.0 => plus(at, across, apart),
            _ => return Err("Q390 of cycle 270 is 1, 2 or 3".to_owned()),
        };
        let (from, to) = if arrives { (outer, at) } else { (at, outer) };
        Ok((distance(from, to) > 1e-7).then_some(Element { from, to, arc: None }))
    }

    /// The path of a train.
    fn train(&self, host: &dyn InterpreterHost) -> Result<Train, String> {
        let contour = self.only_contour()?;
        let amount = self.cutter(host)? + self.sl(3) * host.length_factor();
        let described = self.cycles.contours.train;
        let is_left = match self.sl(391) {
            _ if !described => contour.is_left,
            1.0 => Some(true),
            2.0 => Some(false),
            _ => None,
        };
        let side = is_left.map(|left| if left { 1.0 } else { -1.0 });
        let way = match side {
            None => Some(contour.elements.clone()),
            Some(side) => rounded(&contour.elements, side, amount),
        };
        let way =
            way.ok_or_else(|| "the tool with its allowance does not fit into the contour of cycle 14".to_owned())?;
        let line = ClosedContour::open(contour.elements.clone());
        if side.is_some() && way.iter().any(|element| !is_clear(element, std::slice::from_ref(&line), amount)) {
            return Err("a contour that leaves less room than the tool with its allowance is not emulated".to_owned());
        }
        let (mut arrives, mut leaves) = (None, None);
        if described {
            // On the contour the tool leaves to its left.
            let (side, factor) = (side.unwrap_or(1.0), host.length_factor());
            arrives = way.first().map(|first| self.train_end(first, side, true, factor)).transpose()?.flatten();
            leaves = way.last().map(|last| self.train_end(last, side, false, factor)).transpose()?.flatten();
        }
        Ok(Train { arrives, way, leaves, side, amount: if side.is_some() { amount } else { 0.0 } })
    }

    /// Cycle 25.
    pub(super) fn follow_train(&self, host: &dyn InterpreterHost) -> Result<Moves, String> {
        let Train { arrives, way, leaves, side, .. } = self.train(host)?;
        let way: Vec<Element> = arrives.into_iter().chain(way).chain(leaves).collect();
        let back = ClosedContour::open(way.clone()).reversed();
        // Climbing is along a contour that the tool is left of.
        let forward = (self.sl(15) >= 0.0) == side.is_none_or(|side| side > 0.0);
        let mut ways = [&way[..], back.elements()];
        if !forward {
            ways.reverse();
        }
        let (surface, safe) = (self.sl(5), self.sl(7));
        let alternates = self.sl(15) == 0.0;
        let mut blocks = CycleBlockWriter::of(self, host);
        blocks.rise_to(safe, RAPID);
        for (at, level) in levels(surface, surface + self.sl(1), self.sl(10)).into_iter().enumerate() {
            let way = if alternates && at % 2 == 1 { ways[1] } else { ways[0] };
            let Some(first) = way.first() else { continue };
            if at == 0 || !alternates {
                blocks.over(first.from);
            }
            blocks.rise_to(level, self.sl(11));
            for element in way {
                blocks.element(element, self.sl(12));
            }
            if !alternates {
                blocks.rise_to(safe, RAPID);
            }
        }
        if alternates {
            blocks.rise_to(safe, RAPID);
        }
        Ok(blocks.moves)
    }

    /// Cycle 276.
    pub(super) fn follow_in_space(&self, host: &dyn InterpreterHost) -> Result<Moves, String> {
        if self.sl(18) != 0.0 {
            return Err("residual material (Q18) is not emulated in cycle 276: program Q18=0".to_owned());
        }
        let unit = host.length_factor();
        let high = host.contour_heights().ok_or_else(|| {
            "the first block of the contour of cycle 276 needs the coordinate of the tool axis".to_owned()
        })?;
        let contour: Vec<(Element, [f64; 2])> = self
            .only_contour()?
            .elements
            .iter()
            .copied()
            .zip(high.iter().map(|ends| ends.map(|end| end / unit)))
            .collect();
        let Train { arrives, way, leaves, side, amount } = self.train(host)?;
        let along = heights(&way, (side.unwrap_or(1.0), amount), &contour)
            .ok_or_else(|| "the heights beside the contour of cycle 276 are not known".to_owned())?;
        let flat =
            |element: Option<Element>, height: Option<f64>| element.zip(height).map(|(e, height)| (e, [height; 2]));
        let arrives = flat(arrives, along.first().map(|[from, _]| *from));
        let leaves = flat(leaves, along.last().map(|[_, to]| *to));
        let way: Vec<_> = arrives.into_iter().chain(way.into_iter().zip(along)).chain(leaves).collect();
        let back = backwards(&way);
        let forward = (self.sl(15) >= 0.0) == side.is_none_or(|side| side > 0.0);
        let mut ways = [&way[..], &back[..]];
        if !forward {
            ways.reverse();
        }
        let (safe, alternates) = (self.sl(7), self.sl(15) == 0.0);
        let mut blocks = CycleBlockWriter::of(self, host);
        blocks.rise_to(safe, RAPID);
        let all = levels(0.0, self.sl(1), self.sl(10));
        within_reason(way.len(), all.len())?;
        for (at, lower) in all.into_iter().enumerate() {
            let way = if alternates && at % 2 == 1 { ways[1] } else { ways[0] };
            let Some((first, [height, _])) = way.first() else { continue };
            if at == 0 || !alternates {
                blocks.over(first.from);
            }
            let mut here = height + lower;
            blocks.rise_to(here, self.sl(11));
            for (element, [from, to]) in way {
                if (from + lower - here).abs() > 1e-7 {
                    blocks.rise_to(from + lower, self.sl(12));
                }
                blocks.element_to(element, (from != to).then_some(to + lower), self.sl(12));
                here = to + lower;
            }
            if !alternates {
                blocks.rise_to(safe, RAPID);
            }
        }
        if alternates {
            blocks.rise_to(safe, RAPID);
        }
        Ok(blocks.moves)
    }
}
