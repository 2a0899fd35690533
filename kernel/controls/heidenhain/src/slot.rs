//! Cycle 275: slots along a contour in circles.
//!
//! Facts: programming manuals of the control (the contour is the middle of the slot; Q436 is the path forward of a
//! circle, Q219 the width of the slot, at most twice the diameter of the tool; a slot as wide as the tool is milled
//! along its middle; the tool rises after the last circle and comes back to the start for the next infeed; Q366 = 2
//! plunges to and fro at the angle of the tool, along the line that the contour begins with; the walls are finished
//! from the start, in infeeds of Q338). Decisions: docs of the family, "Choices of contour cycles". *Invariant:* the
//! path of the tool stays inside of the slot.

use counterpoint_motion::arc::by_center;
use counterpoint_motion::contour::closed::ClosedContour;
use counterpoint_motion::contour::element::{Element, Spot, beside, distance, plus};
use counterpoint_motion::contour::shifted::rounded;
use counterpoint_motion::contour::trochoid::trochoid;

use super::Heidenhain;
use super::clearing::{CycleBlockWriter, levels, within_reason};
use super::moves::{Moves, RAPID};
use counterpoint_control_api::host::InterpreterHost;

/// Column ANGLE of the tool table.
const RAMP: u32 = 14;

/// Half a circle from the middle of the slot onto a wall, or back.
fn half_circle(at: Spot, heading: Spot, side: f64, amount: f64, arrives: bool) -> Element {
    let wall = beside(at, heading, side, amount);
    let (from, to) = if arrives { (at, wall) } else { (wall, at) };
    let center = plus(at, plus(wall, at, -1.0), 0.5);
    Element { from, to, arc: by_center(from, to, center, side > 0.0).ok() }
}

/// Once along both walls and round both ends, from beside the start of the middle.
fn round_the_slot(middle: &[Element], side: f64, amount: f64) -> Option<Vec<Element>> {
    let back = ClosedContour::open(middle.to_vec()).reversed();
    let turn = |end: &Element| {
        let (from, to) = (beside(end.to, end.end(), side, amount), beside(end.to, end.end(), -side, amount));
        Element { from, to, arc: by_center(from, to, end.to, side > 0.0).ok() }
    };
    let mut way = rounded(middle, side, amount)?;
    way.push(turn(middle.last()?));
    way.extend(rounded(back.elements(), side, amount)?);
    way.push(turn(back.elements().last()?));
    Some(way)
}

impl Heidenhain {
    /// The blocks of cycle 275.
    pub(super) fn mill_slot(&self, host: &dyn InterpreterHost) -> Result<Moves, String> {
        let middle = &self.only_contour()?.elements;
        let unit = host.length_factor();
        let cutter = self.cutter(host)?;
        let room = self.sl(219) * unit / 2.0 - cutter;
        let (surface, allowance, floor) = (self.sl(203), self.sl(368) * unit, self.sl(369));
        if room < -1e-6 {
            return Err("the tool does not fit into the slot Q219 of cycle 275".to_owned());
        }
        let as_wide = room < 1e-6;
        let clear = surface + self.sl(200);
        let bottom = surface + self.sl(201);
        let climbs = self.sl(351) >= 0.0;
        let mut blocks = CycleBlockWriter::of(self, host);
        blocks.rise_to(clear, RAPID);
        if self.sl(215) != 2.0 || as_wide {
            let circles =
                if as_wide { middle.clone() } else { self.circles(middle, (room, allowance, cutter), climbs, unit)? };
            let feed = self.at_edge(self.sl(207), room - allowance, cutter, 3.0);
            let all = levels(surface, bottom + floor, self.sl(202));
            within_reason(circles.len(), all.len())?;
            for level in all {
                self.plunge_along(host, &mut blocks, (middle, &circles), (level, self.sl(207)))?;
                for element in &circles {
                    let feed = if element.arc.is_some() && !as_wide { feed } else { self.sl(207) };
                    blocks.element(element, feed);
                }
                blocks.rise_to(clear, RAPID);
            }
        }
        if self.sl(215) != 1.0 && !as_wide {
            if allowance > 0.0 {
                self.finish_slot(&mut blocks, middle, room, climbs)?;
            }
            if floor > 0.0 {
                let circles = self.circles(middle, (room, 0.0, cutter), climbs, unit)?;
                self.plunge_along(host, &mut blocks, (middle, &circles), (bottom, self.finishing_feed()))?;
                for element in &circles {
                    blocks.element(element, self.at_edge(self.finishing_feed(), room, cutter, 2.0));
                }
                blocks.rise_to(clear, RAPID);
            }
        }
        if self.sl(204) > self.sl(200) {
            blocks.rise_to(surface + self.sl(204), RAPID);
        }
        Ok(blocks.moves)
    }

    fn finishing_feed(&self) -> f64 {
        if self.sl(385) > 0.0 { self.sl(385) } else { self.sl(207) }
    }

    /// A feed on circles of the middle of the tool inside of the material: that of the edge where Q439 says so.
    fn at_edge(&self, feed: f64, radius: f64, cutter: f64, from: f64) -> f64 {
        if self.sl(439) >= from && feed < RAPID { feed * radius / (radius + cutter) } else { feed }
    }

    /// Circles that leave the allowance at the walls.
    fn circles(
        &self,
        middle: &[Element],
        (room, allowance, cutter): (f64, f64, f64),
        climbs: bool,
        unit: f64,
    ) -> Result<Vec<Element>, String> {
        if room > cutter + 1e-6 {
            return Err("the slot Q219 of cycle 275 is wider than twice the diameter of the tool".to_owned());
        }
        if room - allowance < 1e-6 {
            return Err("the allowance Q368 leaves no room for the circles of cycle 275".to_owned());
        }
        if self.sl(436) <= 0.0 {
            return Err("the infeed Q436 of cycle 275 is not above 0".to_owned());
        }
        trochoid(middle, room - allowance, self.sl(436) * unit, !climbs)
            .ok_or_else(|| "the slot of cycle 275 has no length, or too many circles".to_owned())
    }

    /// To the start of circles and down to a level, to and fro along the first line where Q366 says so.
    fn plunge_along(
        &self,
        host: &dyn InterpreterHost,
        blocks: &mut CycleBlockWriter,
        (middle, circles): (&[Element], &[Element]),
        (level, mills): (f64, f64),
    ) -> Result<(), String> {
        let (Some(line), Some(first)) = (middle.first(), circles.first()) else { return Ok(()) };
        let (surface, feed, unit) = (self.sl(203), self.sl(206), host.length_factor());
        if self.sl(366) != 2.0 {
            blocks.over(line.from);
            blocks.rise_to(surface + self.sl(200), RAPID);
            blocks.rise_to(level, feed);
            if distance(line.from, first.from) > 1e-7 {
                blocks.line(first.from, mills);
            }
            return Ok(());
        }
        let tool = self.variables.control.tool.unwrap_or_else(|| f64::from(host.tool()));
        let angle = self.tools.column(host, tool as u32, RAMP).unwrap_or(0.0);
        if angle <= 0.0 || angle >= 90.0 || line.arc.is_some() {
            return Err("cycle 275 plunges to and fro (Q366=2) by ANGLE of the tool (ID50 NR14), along a line that the contour begins with".to_owned());
        }
        // From where the last infeed ended, in as many ways there and back as the angle takes.
        let top = (level + self.sl(202)).min(surface).max(level);
        blocks.over(line.from);
        blocks.rise_to(surface + self.sl(200), RAPID);
        blocks.rise_to(top, feed);
        let drop = top - level;
        let steepest = libm::tan(angle.to_radians()) * distance(line.from, line.to) / unit;
        let pairs = (drop / (2.0 * steepest) - 1e-9).ceil().clamp(1.0, 10_000.0);
        let leg = drop / (2.0 * pairs) / libm::tan(angle.to_radians()) * unit;
        let there = plus(line.from, line.start(), leg);
        for pair in 0..pairs as u32 {
            let at = |ways: f64| top - drop * (2.0 * f64::from(pair) + ways) / (2.0 * pairs);
            blocks.ramp(there, at(1.0), feed);
            blocks.ramp(line.from, at(2.0), feed);
        }
        if distance(line.from, first.from) > 1e-7 {
            blocks.line(first.from, mills);
        }
        Ok(())
    }

    /// The walls, from the start of the middle.
    fn finish_slot(
        &self,
        blocks: &mut CycleBlockWriter,
        middle: &[Element],
        room: f64,
        climbs: bool,
    ) -> Result<(), String> {
        let (Some(first), Some(last)) = (middle.first(), middle.last()) else { return Ok(()) };
        // A tool that climbs has its wall on the right.
        let side = if climbs { -1.0 } else { 1.0 };
        let fits =
            |way: Option<Vec<Element>>| way.ok_or_else(|| "the walls of the slot of cycle 275 do not fit".to_owned());
        let closes = distance(first.from, last.to) < 1e-3;
        let ways = match closes {
            false => vec![(fits(round_the_slot(middle, side, room))?, *first, *first)],
            true => {
                let back = ClosedContour::open(middle.to_vec()).reversed();
                let there = fits(rounded(middle, side, room))?;
                let other = fits(rounded(back.elements(), side, room))?;
                let of = |way: &[Element]| way.first().copied().zip(way.last().copied());
                let ends = of(middle).zip(of(back.elements()));
                let Some(((a, b), (c, d))) = ends else { return Ok(()) };
                vec![(there, a, b), (other, c, d)]
            }
        };
        let feed = self.finishing_feed();
        let clear = self.sl(203) + self.sl(200);
        let all = levels(self.sl(203), self.sl(203) + self.sl(201), self.sl(338));
        within_reason(ways.iter().map(|(way, ..)| way.len()).sum(), all.len())?;
        for level in all {
            for (way, begins, ends) in &ways {
                blocks.over(begins.from);
                blocks.rise_to(clear, RAPID);
                blocks.rise_to(level, self.sl(206));
                blocks.element(&half_circle(begins.from, begins.start(), side, room, true), feed);
                for element in way {
                    blocks.element(element, feed);
                }
                let (at, heading) = if closes { (ends.to, ends.end()) } else { (ends.from, ends.start()) };
                blocks.element(&half_circle(at, heading, side, room, false), feed);
                blocks.rise_to(clear, RAPID);
            }
        }
        Ok(())
    }
}
