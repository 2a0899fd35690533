//! Cycles 27, 28, 29 and 39: contours on the surface of a cylinder that a rotary table carries.
//!
//! Facts: programming manuals of the control (X of the contour is the way round, in degrees or as a length by Q17, Y
//! lies along the axis; 27 turns the table to each point; 28 mills both walls of a slot along its middle and keeps them
//! parallel, Q21 mills them again where a smaller tool distorts them; 29 goes around a ridge, 39 along a contour, both
//! from beside the first point; the axis of the table is perpendicular to the tool). Old programs write the letter of
//! the rotary axis instead of X. Decisions: docs of the family, "Choices of cylinder cycles". *Invariant:* the axis of
//! the cylinder is the zero of the plane and of the tool axis.

use counterpoint_control_api::host::InterpreterHost;
use counterpoint_motion::arc::{PlaneArc, by_center};
use counterpoint_motion::contour::closed::{ClosedContour, is_clear};
use counterpoint_motion::contour::element::{Element, Spot, distance, plus};
use counterpoint_motion::contour::shifted::rounded;

use super::Heidenhain;
use super::clearing::{CycleBlockWriter, levels, within_reason};
use super::moves::{Along, Moves, RAPID};
use super::path_state::{AXES, actual};
use super::sl_contours::Unrolled;

/// How far a chord may lie off its arc, millimetres.
const CHORD: f64 = 0.005;

/// Passes of Q21 at most.
const PASSES: u32 = 100;

/// A place of the tool: the point above which the table turns, and how far the tool is from there, both unrolled.
type Stand = (Spot, Spot);

/// A move of the tool and the table.
#[derive(Debug, Clone)]
enum CylinderMove {
    To(Stand),
    /// The table is above a point, the tool goes around beside it.
    Arc(Spot, Element),
}

impl CylinderMove {
    fn start(&self) -> Stand {
        match self {
            Self::To(stand) => *stand,
            Self::Arc(foot, element) => (*foot, element.from),
        }
    }
}

/// An element seen from outside, where the axis along the cylinder has this sense.
fn seen_from_outside(element: &Element, sense: f64) -> Element {
    let of = |[round, along]: Spot| [round, along * sense];
    let (from, to) = (of(element.from), of(element.to));
    let arc = element.arc.and_then(|arc| by_center(from, to, of(arc.center), arc.sweep * sense < 0.0).ok());
    Element { from, to, arc }
}

/// To the left of a direction.
fn left([x, y]: Spot) -> Spot {
    [-y, x]
}

/// Directions and points along an element, close enough that chords are the arc; `beside`: how much larger its radius
/// is elsewhere.
fn sampled(element: &Element, beside: f64) -> Vec<(Spot, Spot)> {
    let Some(arc) = &element.arc else { return vec![(element.from, element.start()), (element.to, element.end())] };
    let radius = arc.radius + beside.abs();
    let step = 2.0 * libm::acos((1.0 - CHORD / radius).max(0.0));
    let count = (arc.sweep.abs() / step).ceil().clamp(1.0, 10_000.0) as u32;
    let at = |place: u32| {
        let spot = match place {
            0 => element.from,
            _ if place == count => element.to,
            _ => {
                let turned = arc.start_angle + arc.sweep * f64::from(place) / f64::from(count);
                plus(arc.center, [libm::cos(turned), libm::sin(turned)], arc.radius)
            }
        };
        (spot, Element { from: spot, to: element.to, arc: Some(*arc) }.start())
    };
    (0..=count).map(at).collect()
}

/// The tool beside the middle of a path: the table is at the middle, the tool beside it. `share` is the radius of the
/// contact as a part of that of the surface.
fn beside_middle(way: &[Element], side: f64, amount: f64, share: f64) -> Vec<CylinderMove> {
    let of = |(spot, heading): (Spot, Spot)| {
        let foot = plus(spot, left(heading), -side * amount);
        let contact = left([heading[0] * share, heading[1]]);
        let size = distance(contact, [0.0; 2]);
        CylinderMove::To((foot, plus([0.0; 2], contact, side * amount / size)))
    };
    let mut moves = Vec::new();
    for element in way {
        // Round a corner of the middle.
        let corner = element.arc.filter(|arc| share == 1.0 && (arc.radius - amount).abs() < 1e-7);
        let stands =
            |arc: &PlaneArc| distance(plus(element.from, left(element.start()), -side * amount), arc.center) < 1e-6;
        match corner.filter(stands) {
            Some(arc) => {
                let [from, to] = [element.from, element.to].map(|spot| plus(spot, arc.center, -1.0));
                let beside = by_center(from, to, [0.0; 2], arc.sweep < 0.0).ok();
                moves.push(CylinderMove::Arc(arc.center, Element { from, to, arc: beside }));
            }
            None => moves.extend(sampled(element, amount).into_iter().map(of)),
        }
    }
    moves
}

/// The tool on a path, the table turned to each spot of it.
fn on_way(way: &[Element]) -> Vec<CylinderMove> {
    way.iter().flat_map(|element| sampled(element, 0.0)).map(|(spot, _)| CylinderMove::To((spot, [0.0; 2]))).collect()
}

/// Half a circle from a point beside a path onto it, or off it; the table does not move.
fn half_circle(foot: Spot, heading: Spot, side: f64, [near, far]: [f64; 2], arrives: bool) -> CylinderMove {
    let (near, far) = (plus([0.0; 2], left(heading), side * near), plus([0.0; 2], left(heading), side * far));
    let center = plus(near, plus(far, near, -1.0), 0.5);
    let (from, to) = if arrives { (far, near) } else { (near, far) };
    // It ends and begins in the direction of the path.
    let clockwise = side < 0.0;
    CylinderMove::Arc(foot, Element { from, to, arc: by_center(from, to, center, clockwise).ok() })
}

/// Half a turn about the end of a path, from one side of it to the other; the table does not move.
fn round_the_end(foot: Spot, heading: Spot, side: f64, amount: f64) -> CylinderMove {
    let from = plus([0.0; 2], left(heading), side * amount);
    let to = from.map(|part| -part);
    CylinderMove::Arc(foot, Element { from, to, arc: by_center(from, to, [0.0; 2], side > 0.0).ok() })
}

/// Blocks around a cylinder.
struct CylinderBlockWriter<'a> {
    blocks: CycleBlockWriter,
    unrolled: &'a Unrolled,
    /// Way of a degree of the table on the surface, and a unit of the program, geometry units.
    degree: f64,
    unit: f64,
    stands: Stand,
}

impl CylinderBlockWriter<'_> {
    fn at(&self, (foot, by): Stand) -> [Along; 2] {
        let &Unrolled { along, across, sense, round, .. } = self.unrolled;
        [(along, sense * (foot[1] + by[1]) / self.unit), (across, round * by[0] / self.unit)]
    }

    fn go(&mut self, stand: Stand, feed: f64) {
        let to = self.at(stand).into_iter().chain([(self.unrolled.rotary, stand.0[0] / self.degree)]);
        self.blocks.moves.line(to, true, feed);
        self.stands = stand;
    }

    fn follow(&mut self, moves: &[CylinderMove], feed: f64) {
        for one in moves {
            let (foot, by) = self.stands;
            let to = one.start();
            if distance(foot, to.0) > 1e-7 || distance(by, to.1) > 1e-7 {
                self.go(to, feed);
            }
            if let CylinderMove::Arc(foot, Element { to, arc: Some(arc), .. }) = one {
                // The axes along and across have the same relation to each other as on the surface.
                let (center, to) = (self.at((*foot, arc.center)), (*foot, *to));
                let end = self.at(to);
                self.blocks.moves.circle(center, end, arc.sweep < 0.0, feed);
                self.stands = to;
            }
        }
    }
}

/// The path of a cycle at each level from its plunge point, and its continuation.
struct CylinderPasses {
    start: Stand,
    ways: Vec<CylinderMove>,
    /// The tool rises between levels.
    rises: bool,
    /// Moves that follow at the last level.
    again: Vec<CylinderMove>,
}

impl Heidenhain {
    /// The contour that is read next lies on a cylinder.
    ///
    /// # Errors
    /// The machine has no table that is perpendicular to the tool.
    pub(super) fn unroll(&mut self, host: &dyn InterpreterHost) -> Result<(), String> {
        if self.shifts.mirror_bits() != 0 || (0..3).any(|axis| self.shifts.factor(axis) != Some(1.0)) {
            return Err("a cylinder that is mirrored or scaled (cycles 8, 11, 26) is not emulated".to_owned());
        }
        let table = host.part_table();
        let named =
            |(name, direction): &(String, [f64; 3])| Some((AXES.into_iter().find(|axis| axis == name)?, *direction));
        let Some((rotary, direction)) = table.as_ref().and_then(named) else {
            return Err("a cylinder needs a rotary table that carries the part, without M128".to_owned());
        };
        let letters = self.plane_letters();
        let height = super::path_state::AXES.iter().position(|letter| *letter == self.tool_letter());
        let lies = |letter: &str| {
            let place = super::path_state::AXES.iter().position(|known| *known == letter)?;
            direction.get(place).copied().filter(|part| part.abs() > 1.0 - 1e-6).map(f64::signum)
        };
        let first = lies(letters[0]);
        let found = first.map(|sense| (sense, true)).or_else(|| Some((lies(letters[1])?, false)));
        let Some((sense, along_first)) = found.filter(|_| height.is_some_and(|height| height == 2)) else {
            return Err(format!(
                "the axis {rotary} of the table that carries the part is not square to the tool along an axis of the plane: tilt the plane first"
            ));
        };
        let [along, across] = if along_first { letters } else { [letters[1], letters[0]] };
        // The tool goes around right-handed about the axis: along X about Y, against Y about X.
        let round = if along_first { -sense } else { sense };
        let scale = if self.sl(17) == 0.0 { self.sl(16).to_radians() } else { 1.0 };
        self.cycles.contours.unrolled = Some(Unrolled { rotary, along, across, sense, round, scale, by_name: None });
        Ok(())
    }

    /// The blocks of a cylinder cycle.
    pub(super) fn round_cylinder(&self, host: &dyn InterpreterHost, cycle: u32) -> Result<Moves, String> {
        let Some(unrolled) = &self.cycles.contours.unrolled else {
            return Err("the contour is not unrolled".to_owned());
        };
        let contour = self.only_contour()?;
        let way: Vec<Element> =
            contour.elements.iter().map(|element| seen_from_outside(element, unrolled.sense)).collect();
        let unit = host.length_factor();
        let (surface, cutter) = (self.sl(16), self.cutter(host)?);
        if surface <= 0.0 {
            return Err("the radius Q16 of the cylinder is not above 0".to_owned());
        }
        let (depth, allowance) = (self.sl(1), self.sl(3) * unit);
        if depth > 0.0 || depth + surface <= 0.0 {
            return Err("the depth Q1 is not below the surface, or beyond the axis of the cylinder".to_owned());
        }
        let ground = (surface + depth) / surface;
        let passes = match cycle {
            27 => Self::turned_along(&way, contour.is_left, cutter + allowance)?,
            28 => self.slot_walls(&way, contour.is_left, (cutter, allowance), ground, unit)?,
            29 => {
                let half = self.sl(20) * unit / 2.0;
                Self::ridge(&way, contour.is_left, [half + cutter + allowance, half + 2.0 * cutter])?
            }
            _ => Self::wall(&way, contour.is_left, [cutter + allowance, 2.0 * cutter])?,
        };
        let all = levels(surface, surface + depth, self.sl(10));
        within_reason(passes.ways.len() + passes.again.len(), all.len())?;
        let mut blocks = CycleBlockWriter::of(self, host);
        let height = self.variables.control.tool_axis.unwrap_or(2);
        let before = actual(host).get(height).copied().unwrap_or(0.0);
        let clear = surface + self.sl(6);
        if before < clear {
            blocks.rise_to(clear, RAPID);
        }
        let (feed, plunge) = (self.sl(12), self.sl(11));
        let mut round =
            CylinderBlockWriter { blocks, unrolled, degree: surface.to_radians() * unit, unit, stands: passes.start };
        round.go(passes.start, RAPID);
        round.blocks.rise_to(clear, RAPID);
        if !self.units.rotary_length {
            round.blocks.moves.function(116);
        }
        for (place, level) in all.iter().enumerate() {
            if place > 0 && passes.rises {
                round.blocks.rise_to(clear, RAPID);
                round.go(passes.start, RAPID);
            }
            round.blocks.rise_to(*level, plunge);
            round.follow(&passes.ways, feed);
        }
        round.follow(&passes.again, feed);
        round.blocks.rise_to(before.max(clear), RAPID);
        if !self.units.rotary_length {
            round.blocks.moves.function(117);
        }
        Ok(round.blocks.moves)
    }

    /// Cycle 27.
    fn turned_along(way: &[Element], is_left: Option<bool>, amount: f64) -> Result<CylinderPasses, String> {
        let too_small = || "the tool with its allowance does not fit into the contour of the cylinder".to_owned();
        let side = is_left.map(|left| if left { 1.0 } else { -1.0 });
        let beside = match (side, way.first().zip(way.last())) {
            (None, _) => way.to_vec(),
            (Some(side), Some((first, last))) => {
                let closes = distance(first.from, last.to) < 1e-3;
                let is_smooth = distance(first.start(), last.end()) < 1e-6;
                let closed = ClosedContour::new(way.to_vec()).filter(|_| closes && !is_smooth);
                let beside = match closed {
                    Some(closed) => closed.beside(side, amount).map(|way| way.elements().to_vec()),
                    None => rounded(way, side, amount),
                };
                let beside = beside.ok_or_else(too_small)?;
                let contour = ClosedContour::open(way.to_vec());
                if beside.iter().any(|element| !is_clear(element, std::slice::from_ref(&contour), amount)) {
                    return Err(too_small());
                }
                beside
            }
            (Some(_), None) => Vec::new(),
        };
        let ways = on_way(&beside);
        let start = ways.first().ok_or_else(too_small)?.start();
        Ok(CylinderPasses { start, ways, rises: true, again: Vec::new() })
    }

    /// Cycle 28: one wall forward along the middle, the other wall back.
    fn slot_walls(
        &self,
        way: &[Element],
        is_left: Option<bool>,
        (cutter, allowance): (f64, f64),
        ground: f64,
        unit: f64,
    ) -> Result<CylinderPasses, String> {
        let amount = self.sl(20) * unit / 2.0 - cutter - allowance;
        if amount < -1e-6 {
            return Err("the tool with its allowance does not fit into the slot Q20".to_owned());
        }
        let amount = amount.max(0.0);
        // The wall lies to the right of a tool that climbs.
        let side = if is_left == Some(false) { 1.0 } else { -1.0 };
        let walls = |share: f64| -> Result<Vec<CylinderMove>, String> {
            let fits = |way: Option<Vec<Element>>| {
                way.ok_or_else(|| "the slot Q20 has no room beside the way of its middle".to_owned())
            };
            let there = if amount > 0.0 { fits(rounded(way, side, amount))? } else { way.to_vec() };
            let middle_back = ClosedContour::open(way.to_vec()).reversed();
            let back = match amount > 0.0 {
                true => fits(rounded(middle_back.elements(), side, amount))?,
                false => middle_back.elements().to_vec(),
            };
            let mut stands = beside_middle(&there, side, amount, share);
            stands.extend(beside_middle(&back, side, amount, share));
            stands.extend(stands.first().cloned());
            Ok(stands)
        };
        let ways = walls(1.0)?;
        let start = ways.first().ok_or_else(|| "the slot has no middle".to_owned())?.start();
        let mut again = Vec::new();
        for pass in 1..=self.passes(way, amount, ground, unit) {
            let all = self.passes(way, amount, ground, unit);
            again.extend(walls(1.0 - (1.0 - ground) * f64::from(pass) / f64::from(all))?);
        }
        Ok(CylinderPasses { start, ways, rises: false, again })
    }

    /// Passes that bring both walls within Q21 of the walls cut by a tool as wide as the slot. At each depth such a
    /// tool touches them in another direction.
    fn passes(&self, way: &[Element], amount: f64, ground: f64, unit: f64) -> u32 {
        let tolerance = self.sl(21) * unit;
        if tolerance <= 0.0 || amount <= tolerance / 2.0 {
            return 0;
        }
        let lies = |[round, along]: Spot| {
            let by = libm::atan2(along, round * ground) - libm::atan2(along, round);
            libm::remainder(by, std::f64::consts::TAU).abs()
        };
        let headings = way.iter().flat_map(|element| sampled(element, amount)).map(|(_, heading)| lies(heading));
        let most = headings.fold(0.0, f64::max);
        // Between two passes the direction is off by half of the angle between them.
        let off = |passes: u32| amount * (1.0 - libm::cos(most / (2.0 * f64::from(passes))));
        if most < 1e-9 { 0 } else { (1..PASSES).find(|passes| off(*passes) <= tolerance).unwrap_or(PASSES) }
    }

    /// Cycle 29: around the ridge, from beside its first point.
    fn ridge(way: &[Element], is_left: Option<bool>, [near, far]: [f64; 2]) -> Result<CylinderPasses, String> {
        let side = if is_left == Some(false) { -1.0 } else { 1.0 };
        let fits = |way: Option<Vec<Element>>| way.ok_or_else(|| "the way round the ridge does not fit".to_owned());
        let (Some(first), Some(last)) = (way.first(), way.last()) else {
            return Err("the ridge has no middle".to_owned());
        };
        let there = fits(rounded(way, side, near))?;
        let back = fits(rounded(ClosedContour::open(way.to_vec()).reversed().elements(), side, near))?;
        let far = far.max(near + 1e-3);
        let mut ways = vec![half_circle(first.from, first.start(), side, [near, far], true)];
        ways.extend(beside_middle(&there, side, near, 1.0));
        ways.push(round_the_end(last.to, last.end(), side, near));
        ways.extend(beside_middle(&back, side, near, 1.0));
        ways.push(round_the_end(first.from, first.start().map(|part| -part), side, near));
        ways.push(half_circle(first.from, first.start(), side, [near, far], false));
        let start = (first.from, plus([0.0; 2], left(first.start()), side * far));
        Ok(CylinderPasses { start, ways, rises: false, again: Vec::new() })
    }

    /// Cycle 39: along the contour, from beside its first point.
    fn wall(way: &[Element], is_left: Option<bool>, [near, far]: [f64; 2]) -> Result<CylinderPasses, String> {
        let (Some(first), Some(last)) = (way.first(), way.last()) else {
            return Err("the contour has no element".to_owned());
        };
        let Some(is_left) = is_left else {
            return Err("the contour of cycle 39 needs RL or RR".to_owned());
        };
        let side = if is_left { 1.0 } else { -1.0 };
        let along = rounded(way, side, near)
            .ok_or_else(|| "the tool with its allowance does not fit into the contour of the cylinder".to_owned())?;
        let far = far.max(near + 1e-3);
        let mut ways = vec![half_circle(first.from, first.start(), side, [near, far], true)];
        ways.extend(beside_middle(&along, side, near, 1.0));
        ways.push(half_circle(last.to, last.end(), side, [near, far], false));
        let start = (first.from, plus([0.0; 2], left(first.start()), side * far));
        Ok(CylinderPasses { start, ways, rises: true, again: Vec::new() })
    }
}
