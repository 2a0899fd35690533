//! Directions of the tool that follow the path (LEAD, TILT, ORIPATH), and directions along a cone (ORICONCW, ORICONCCW,
//! ORICONIO, ORICONTO).
//!
//! Facts: programming manual, job planning, chapters "three, four and five axis transformation" and "orientation along
//! the peripheral surface of a taper": LEAD is the angle to the surface normal in the plane of the path and the normal,
//! TILT turns about the path; the normal is A5 B5 C5 at the end of the block, otherwise A4 B4 C4, at first Z. A cone
//! has its axis at A6 B6 C6 or a full opening angle NUT, or goes through A7 B7 C7. Decisions: LEAD leans in the
//! direction of motion, TILT is right-handed about the path (to the right of it). Both act at the end of their block
//! and, under ORIPATH, at the end of each following block that moves. The normal may be 5 degrees from being
//! perpendicular to the path. A block along a cone becomes straight blocks of at most two degrees; clockwise is seen
//! against the axis; without an end the tool makes a full turn; a negative NUT is the path beyond half a turn.
//! *Invariant:* a move that is not straight along X, Y and Z has no direction of this kind and is refused.

use counterpoint_machine::ident::codes;
use counterpoint_motion::direction::{Cone, leaned};

use super::aims::{Aims, Angle, Vector};
use super::left::SiemensRemainder;
use super::modal::{is_curve, is_still};
use super::orientation::{AXES, DIRECTION};
use super::value::Data;
use super::{Outcome, Siemens, syntax};
use counterpoint_control_api::host::InterpreterHost;

/// Most degrees between a normal and the plane across the path.
const OFF: f64 = 5.0;
/// Most degrees that a piece of a cone turns.
const PIECE: f64 = 2.0;

/// How the tool turns along the path, as the codes of their group say.
#[derive(Debug, Default)]
pub(super) struct OrientationInterpolation {
    kind: OrientationMode,
    normal: Option<[f64; 3]>,
    /// LEAD and TILT under ORIPATH.
    angles: Option<[f64; 2]>,
    /// The direction at the end of the last cone, and where it went there.
    last: Option<[[f64; 3]; 2]>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum OrientationMode {
    #[default]
    Straight,
    Path,
    Clockwise,
    CounterClockwise,
    Through,
    Tangential,
}

/// Codes of the group.
const KINDS: [(&str, OrientationMode); 9] = [
    ("ORIAXES", OrientationMode::Straight),
    ("ORIVECT", OrientationMode::Straight),
    ("ORIPLANE", OrientationMode::Straight),
    ("ORIPATH", OrientationMode::Path),
    ("ORIPATHS", OrientationMode::Path),
    ("ORICONCW", OrientationMode::Clockwise),
    ("ORICONCCW", OrientationMode::CounterClockwise),
    ("ORICONIO", OrientationMode::Through),
    ("ORICONTO", OrientationMode::Tangential),
];

impl OrientationInterpolation {
    /// Whether blocks without a word of the direction may have one.
    pub(super) fn acts(&self) -> bool {
        self.kind != OrientationMode::Straight
    }

    /// A word of the block is a code of the group.
    pub(super) fn hear(&mut self, host: &dyn InterpreterHost, word: &str) {
        if let Some((_, kind)) = KINDS.iter().find(|(name, _)| *name == word)
            && host.is_code_text(word)
        {
            *self = Self { kind: *kind, angles: None, normal: self.normal, last: self.last };
        }
    }
}

/// A straight move of the block.
struct ProgrammedLine {
    /// Where X, Y and Z begin, as the program counts.
    from: [f64; 3],
    /// By how much they move; none is not programmed.
    by: [Option<f64>; 3],
    relative: bool,
}

impl ProgrammedLine {
    fn way(&self) -> [f64; 3] {
        self.by.map(|by| by.unwrap_or(0.0))
    }
}

impl Siemens {
    /// Gives the block the direction that LEAD, TILT and the codes of the group ask for.
    pub(super) fn along(
        &mut self,
        host: &mut dyn InterpreterHost,
        left: &mut SiemensRemainder,
        aims: Option<&Aims>,
    ) -> Outcome<()> {
        let of = |vector| aims.and_then(|aims| aims.vector(vector));
        if let Some(normal) = of(Vector::NormalAtEnd).or(of(Vector::NormalAtStart)) {
            self.held.turning.normal = Some(normal);
        }
        let angles = [Angle::Lead, Angle::Tilt].map(|angle| aims.and_then(|aims| aims.angle(angle)));
        let cone = [Vector::Axis, Vector::Between].map(of);
        let opening = aims.and_then(|aims| aims.angle(Angle::Opening));
        let kind = self.held.turning.kind;
        let on_cone = !matches!(kind, OrientationMode::Straight | OrientationMode::Path);
        if !on_cone && (cone != [None; 2] || opening.is_some()) {
            return syntax("A6, B6, C6, A7, B7, C7 and NUT need ORICONCW, ORICONCCW, ORICONIO or ORICONTO");
        }
        if on_cone {
            return self.on_cone(host, left, cone, opening);
        }
        let asked = angles != [None; 2];
        let held = self.held.turning.angles.filter(|_| kind == OrientationMode::Path);
        if !asked && (held.is_none() || direction(&left.words).is_some()) {
            return Ok(());
        }
        let [lead, tilt] = held.unwrap_or_default();
        let lean = [angles[0].unwrap_or(lead), angles[1].unwrap_or(tilt)];
        if kind == OrientationMode::Path {
            self.held.turning.angles = Some(lean);
        }
        if direction(&left.words).is_some() {
            return syntax("a block has a direction of the tool or LEAD and TILT");
        }
        let way = match straight(host, left)? {
            Some(_) if host.keeps_moves_back() => {
                return syntax("LEAD and TILT under G41 or G42 are not emulated");
            }
            Some(way) if way.way() != [0.0; 3] => way.way(),
            _ if !asked || kind == OrientationMode::Path => return Ok(()),
            _ => return syntax("LEAD and TILT need a move of X, Y or Z"),
        };
        let normal = self.held.turning.normal.unwrap_or([0.0, 0.0, 1.0]);
        let Some(direction) = leaned(normal, way, lean, OFF) else {
            return syntax("the normal of the surface (A5, B5, C5) is not perpendicular to the path");
        };
        left.replace(format!("{} {}", left.words, aimed(direction)));
        Ok(())
    }

    /// A change of direction along a cone: blocks of a few degrees.
    fn on_cone(
        &mut self,
        host: &mut dyn InterpreterHost,
        left: &mut SiemensRemainder,
        [axis, between]: [Option<[f64; 3]>; 2],
        opening: Option<f64>,
    ) -> Outcome<()> {
        let end = direction(&left.words);
        if end.is_none() && axis.is_none() && between.is_none() && opening.is_none() {
            return Ok(());
        }
        if !host.is_active(codes::RTCP_ON) {
            // A direction without the transformation is the alarm of the control.
            if end.is_none() {
                left.add("C3=1");
            }
            return Ok(());
        }
        if host.is_active(codes::FEED_1T) || host.keeps_moves_back() {
            return syntax("directions along a cone under G93, G41 or G42 are not emulated");
        }
        let identity = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        let cells = host.local_frame().into_iter().zip(identity).enumerate();
        let turns = cells.filter(|(at, _)| at % 4 < 3).any(|(_, (cell, expected))| (cell - expected).abs() > 1e-9);
        if turns {
            return syntax("directions along a cone in a frame that is turned, scaled or mirrored are not emulated");
        }
        let Some(start) = host.tool_direction() else { return syntax("a cone needs a direction of the tool") };
        let cone = match (self.held.turning.kind, axis, between, opening, end) {
            (OrientationMode::Through, None, Some(between), None, Some(end)) => Cone::through(start, between, end),
            (OrientationMode::Through, ..) => return syntax("ORICONIO takes A3, B3, C3 and A7, B7, C7"),
            (OrientationMode::Tangential, None, None, None, Some(end)) => match self.held.turning.last {
                Some([here, way]) if same(here, start) => Cone::tangential(start, way, end),
                _ => return syntax("ORICONTO needs a change of direction on a cone before it"),
            },
            (OrientationMode::Tangential, ..) => return syntax("ORICONTO takes A3, B3, C3"),
            (kind, Some(axis), None, None, end) => Cone::about(axis, start, end, kind == OrientationMode::Clockwise),
            (kind, None, None, Some(opening), Some(end)) => {
                if !(opening.abs() > 0.0 && opening.abs() <= 180.0) {
                    return syntax(format!("NUT is above 0 and at most 180, not {opening}"));
                }
                Cone::opened(opening.abs(), [start, end], kind == OrientationMode::Clockwise, opening > 0.0)
            }
            _ => return syntax("ORICONCW and ORICONCCW take A6, B6, C6, or NUT with A3, B3, C3"),
        };
        let Some(cone) = cone else {
            return syntax("the first and the last direction do not lie on such a cone");
        };
        let way = straight(host, left)?;
        self.held.turning.last = Some([cone.at(1.0), cone.way_at_end()]);
        left.moves = true;
        in_pieces(left, &cone, way.as_ref());
        Ok(())
    }
}

/// The block as straight blocks; codes that act at the end of a block stay with the last one.
fn in_pieces(left: &mut SiemensRemainder, cone: &Cone, way: Option<&ProgrammedLine>) {
    let is_aim =
        |word: &str| DIRECTION.iter().any(|name| word.strip_prefix(name).is_some_and(|rest| rest.starts_with('=')));
    let is_place = |word: &str| AXES.iter().any(|name| word.starts_with(name));
    let all = left.take_words();
    let words: Vec<&str> = all.split(' ').filter(|word| !is_aim(word) && !is_place(word)).collect();
    let (last, first): (Vec<&str>, Vec<&str>) = words.into_iter().partition(|word| ends(word));
    let count = (cone.turn.abs() / PIECE - 1e-3).ceil().max(1.0);
    let mut text = first.join(" ");
    for piece in 1..=count as u32 {
        let part = f64::from(piece) / count;
        if let Some(way) = way {
            for ((name, from), by) in AXES.iter().zip(way.from).zip(way.by) {
                let Some(by) = by else { continue };
                let value = if way.relative { by / count } else { from + by * part };
                text.push_str(&format!(" {name}{}", Data::Real(value).word()));
            }
        }
        text.push(' ');
        text.push_str(&aimed(cone.at(part)));
        let block = std::mem::take(&mut text).trim().to_owned();
        if f64::from(piece) < count {
            left.before.push(block);
        } else {
            left.replace(block);
        }
    }
    last.into_iter().for_each(|word| left.add(word));
}

/// Directions that the axes can reach as the same one.
fn same(a: [f64; 3], b: [f64; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6)
}

/// Whether an M function acts at the end of its block.
fn ends(word: &str) -> bool {
    let number = word.strip_prefix('M').and_then(|number| number.parse::<u32>().ok());
    number.is_some_and(|number| matches!(number, 0..=2 | 5 | 9 | 17 | 30))
}

fn aimed(direction: [f64; 3]) -> String {
    let clean = direction.map(|part| if part.abs() < 1e-12 { 0.0 } else { part });
    super::orientation::assigned(DIRECTION, clean)
}

/// The direction that the words of the block have.
fn direction(words: &str) -> Option<[f64; 3]> {
    let mut found = None;
    for word in words.split(' ') {
        let Some((at, value)) = DIRECTION.iter().enumerate().find_map(|(at, name)| {
            word.strip_prefix(name)?.strip_prefix('=')?.parse::<f64>().ok().map(|value| (at, value))
        }) else {
            continue;
        };
        if let Some(slot) = found.get_or_insert([0.0; 3]).get_mut(at) {
            *slot = value;
        }
    }
    found
}

/// The straight move of the block; none without X, Y and Z.
fn straight(host: &dyn InterpreterHost, left: &SiemensRemainder) -> Outcome<Option<ProgrammedLine>> {
    let axes = host.axes();
    let relative = left.relative.unwrap_or_else(|| host.relative());
    let mut goes_straight = host.moves_straight();
    let from = AXES.map(|name| axes.iter().find(|axis| axis.is(name)).map_or(0.0, |axis| axis.work));
    let (mut by, mut is_polar) = ([None; 3], false);
    for word in left.words.split(' ') {
        if is_still(word) {
            return Ok(None);
        }
        goes_straight |= matches!(word, "G0" | "G00" | "G1" | "G01");
        goes_straight &= !is_curve(word) && !matches!(word, "CIP" | "CT" | "INVCW" | "INVCCW");
        let value = AXES.iter().zip(from).zip(&mut by).find_map(|((name, from), slot)| {
            let rest = word.strip_prefix(name)?;
            Some((from, slot, rest.strip_prefix('=').unwrap_or(rest).parse::<f64>().ok()?))
        });
        if let Some((from, slot, value)) = value {
            *slot = Some(if relative { value } else { value - from });
        }
        is_polar |= word.starts_with("AP=") || word.starts_with("RP=");
    }
    if is_polar || !goes_straight && by != [None; 3] {
        return syntax("directions that follow the way or a cone need a straight move by X, Y and Z");
    }
    Ok((by != [None; 3]).then_some(ProgrammedLine { from, by, relative }))
}
