//! Directions of the tool by angles, and frames by two space angles or by the direction of the tool. The machine's
//! tables get directions, TRANS, ROT and AROT for them.
//!
//! Facts: programming manual, job planning, chapters "programming the tool orientation" and "frame generation by tool
//! orientation"; fundamentals, chapter "programmable frame rotations with solid angles". A direction is Z turned: with
//! RPY angles by C2 about Z, B2 about the new Y, A2 about the new X, with Euler angles by A2 about Z, B2 about the new
//! X; C2 then does nothing. Two space angles about axes A and B are those of the lines in which the plane cuts the old
//! planes; the axis of the second angle's line lies in its old plane. TOFRAME and TOROT, which TOFRAMEZ and TOROTZ also
//! mean, put Z along the tool, X stays in its old plane with Z. Decisions: Euler angles unless ORIRPY says otherwise;
//! angles that a block does not have are 0; TOFRAME and TOROT act on the programmable frame; ORIRESET, whose values are
//! places of the machine's rotary axes in their order, 0 where one is left out, moves them as the block's G function
//! says. *Invariant:* without a transformation for directions these words stay as unknown as on a control without the
//! option.

use super::aims::Vector;
use super::compiled::SiemensArgument;
use super::conversions::number;
use super::frame::SiemensFrame;
use super::left::SiemensRemainder;
use super::value::Data;
use super::{Outcome, Siemens, syntax};
use counterpoint_control_api::host::InterpreterHost;
use counterpoint_machine::ident::codes;

/// Addresses of a direction, as the machine's tables know it.
pub(super) const DIRECTION: [&str; 3] = ["A3", "B3", "C3"];
pub(super) const AXES: [&str; 3] = ["X", "Y", "Z"];
const ROTARY: [&str; 3] = ["A", "B", "C"];

type Rows = [[f64; 3]; 3];

/// A turn about an axis by degrees.
fn turn(axis: usize, degrees: f64) -> Rows {
    let (sine, cosine) = libm::sincos(degrees.to_radians());
    match axis {
        0 => [[1.0, 0.0, 0.0], [0.0, cosine, -sine], [0.0, sine, cosine]],
        1 => [[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]],
        _ => [[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]],
    }
}

/// One turn after another one, about the new axes.
fn then(outer: &Rows, inner: &Rows) -> Rows {
    let mut made = [[0.0; 3]; 3];
    for (row, made) in outer.iter().zip(&mut made) {
        for (factor, line) in row.iter().zip(inner) {
            for (slot, part) in made.iter_mut().zip(line) {
                *slot += factor * part;
            }
        }
    }
    made
}

/// Whether the machine has directions of the tool.
pub(super) fn has_directions(host: &dyn InterpreterHost) -> bool {
    host.is_register("A3=")
}

/// Angles of a turn about X, Y and Z, as ROT takes them.
fn angles_of(rows: &Rows) -> Option<[f64; 3]> {
    let [[a, b, c], [d, e, f], [g, h, i]] = *rows;
    let frame = SiemensFrame::from_numbers(&[a, b, c, 0.0, d, e, f, 0.0, g, h, i, 0.0])?;
    frame.parts().map(|parts| parts.angles)
}

/// Words with `=`.
pub(super) fn assigned(names: [&str; 3], values: [f64; 3]) -> String {
    let [a, b, c] = values.map(|value| Data::Real(value).word());
    let [x, y, z] = names;
    format!("{x}={a} {y}={b} {z}={c}")
}

fn words(key: &str, names: [&str; 3], values: [f64; 3]) -> String {
    let mut text = key.to_owned();
    for (name, value) in names.iter().zip(values) {
        text.push_str(&format!(" {name}{}", Data::Real(value).word()));
    }
    text
}

impl Siemens {
    /// Rewrites directions by angles and frames by directions.
    pub(super) fn orient(&mut self, host: &mut dyn InterpreterHost, left: &mut SiemensRemainder) -> Outcome<()> {
        if left.aims.is_none() && !self.held.turning.acts() && !may_orient(&left.words) {
            return Ok(());
        }
        let before = self.held.turning.acts();
        for word in left.words.split(' ').filter(|word| word.starts_with("ORI")) {
            match word {
                "ORIRPY" => self.held.rpy = true,
                "ORIEULER" => self.held.rpy = false,
                _ => self.held.turning.hear(host, word),
            }
        }
        if self.held.turning.acts() != before {
            self.watch(host);
        }
        let aims = left.aims.take();
        if let Some([a, b, c]) = aims.as_ref().and_then(|aims| aims.vector(Vector::Turned)) {
            let turned = if self.held.rpy {
                then(&then(&turn(2, c), &turn(1, b)), &turn(0, a))
            } else {
                then(&turn(2, a), &turn(0, b))
            };
            let direction = turned.map(|[_, _, along]| if along.abs() < 1e-12 { 0.0 } else { along });
            left.add(&assigned(DIRECTION, direction));
        }
        if aims.is_some() || self.held.turning.acts() {
            self.along(host, left, aims.as_deref())?;
        }
        let key = left.words.split(' ').find(|word| {
            matches!(*word, "ROTS" | "AROTS" | "TOFRAME" | "TOFRAMEZ" | "TOROT" | "TOROTZ" | "TOFRAMEOF" | "TOROTOF")
        });
        match key.map(str::to_owned).as_deref() {
            Some(key @ ("ROTS" | "AROTS")) if host.is_code_text("ROT") => self.space_angles(left, key),
            Some(key) if has_directions(host) => self.tool_frame(host, left, key),
            _ => Ok(()),
        }
    }

    /// ORIRESET: rotary axes go to the initial position of the tool; whether it is that.
    pub(super) fn reset_orientation(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
        arguments: &[SiemensArgument],
        left: &mut SiemensRemainder,
    ) -> Outcome<bool> {
        if name != "ORIRESET" || !has_directions(host) {
            return Ok(false);
        }
        if !host.is_active(codes::RTCP_ON) {
            // A direction without the transformation is the alarm of the control.
            left.add("C3=1");
            return Ok(true);
        }
        let axes = host.axes();
        let rotary: Vec<_> = axes.iter().filter(|axis| ROTARY.iter().any(|name| axis.is(name))).collect();
        if arguments.len() > rotary.len() {
            return syntax(format!("ORIRESET takes {} values", rotary.len()));
        }
        let relative = left.relative.unwrap_or_else(|| host.relative());
        let mut arguments = arguments.iter();
        for axis in rotary {
            let given = arguments.next().map(|argument| self.argument(host, argument)).transpose()?.flatten();
            let way = given.map_or(Ok(0.0), |value| number(&value))? - axis.machine;
            left.add(&format!("{}{}", axis.letter, Data::Real(if relative { way } else { axis.work + way }).word()));
        }
        left.moves = true;
        Ok(true)
    }

    /// ROTS and AROTS: a rotation by two space angles.
    fn space_angles(&mut self, left: &mut SiemensRemainder, key: &str) -> Outcome<()> {
        let mut given = [None; 3];
        for word in left.words.split(' ').filter(|word| *word != key && !is_number(word)) {
            let place = AXES.iter().zip(&mut given).find_map(|(name, slot)| Some((slot, word.strip_prefix(name)?)));
            let Some((slot, value)) = place else {
                return syntax(format!("{key} takes two space angles only, not {word}"));
            };
            *slot = value.strip_prefix('=').unwrap_or(value).parse::<f64>().ok();
        }
        let rows = match given {
            [Some(x), Some(y), None] => plane((0, x), (1, y)),
            [None, Some(y), Some(z)] => plane((1, y), (2, z)),
            [Some(x), None, Some(z)] => plane((2, z), (0, x)),
            [Some(x), None, None] => turn(0, x),
            [None, Some(y), None] => turn(1, y),
            [None, None, Some(z)] => turn(2, z),
            _ => return syntax(format!("{key} takes one or two space angles")),
        };
        let Some(angles) = angles_of(&rows) else { return syntax(format!("the angles of {key} give no plane")) };
        left.replace(words(if key == "ROTS" { "ROT" } else { "AROT" }, AXES, angles));
        Ok(())
    }

    /// TOFRAME and TOROT: the programmable frame along the tool, or no longer so.
    fn tool_frame(&mut self, host: &mut dyn InterpreterHost, left: &mut SiemensRemainder, key: &str) -> Outcome<()> {
        if left.words.split(' ').any(|word| word != key) {
            return syntax(format!("{key} stands in a block of its own"));
        }
        let frame = host.local_frame();
        let mut shift = [3, 7, 11].map(|at| frame.get(at).copied().unwrap_or(0.0));
        if key.starts_with("TOFRAME") && !key.ends_with("OF") {
            let axes = host.axes();
            let here = AXES.map(|name| axes.iter().find(|axis| axis.is(name)).map_or(0.0, |axis| axis.work));
            for (row, slot) in shift.iter_mut().enumerate() {
                let cells = here.iter().enumerate();
                *slot += cells.map(|(at, here)| frame.get(row * 4 + at).copied().unwrap_or(0.0) * here).sum::<f64>();
            }
        }
        self.held.additive = [0.0; 3];
        let trans = words("TRANS", AXES, shift);
        if key.ends_with("OF") {
            left.replace(trans);
            return Ok(());
        }
        let Some([x, y, z]) = host.tool_direction() else {
            return syntax(format!("{key} needs a direction of the tool"));
        };
        let angles = [-libm::asin(y.clamp(-1.0, 1.0)), libm::atan2(x, z), 0.0].map(f64::to_degrees);
        left.before.push(trans);
        left.replace(words("AROT", AXES, angles.map(|angle| if angle.abs() < 1e-9 { 0.0 } else { angle })));
        Ok(())
    }
}

/// Whether some word may be one of those above: the first two characters of each decide about most blocks.
fn may_orient(words: &str) -> bool {
    let mut begins = true;
    words.as_bytes().windows(2).any(|pair| {
        let first = std::mem::replace(&mut begins, pair.first() == Some(&b' '));
        first && matches!(pair, b"OR" | b"RO" | b"AR" | b"TO")
    })
}

/// Whether the word is the number of a block.
fn is_number(word: &str) -> bool {
    word.strip_prefix('N').is_some_and(|rest| !rest.is_empty() && rest.bytes().all(|byte| byte.is_ascii_digit()))
}

/// The plane with the lines of two space angles about axes.
fn plane((first, angle): (usize, f64), (second, other): (usize, f64)) -> Rows {
    let inner = libm::atan(libm::tan(angle.to_radians()) * libm::cos(other.to_radians())).to_degrees();
    then(&turn(second, other), &turn(first, inner))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_lines_of_two_space_angles_lie_in_the_plane() {
        let rows = plane((0, 30.0), (1, 20.0));
        let normal = rows.map(|[_, _, z]| z);
        let along = |[a, b, c]: [f64; 3]| normal[0] * a + normal[1] * b + normal[2] * c;
        let (sine, cosine) = libm::sincos(30_f64.to_radians());
        assert!(along([0.0, cosine, sine]).abs() < 1e-12);
        let (sine, cosine) = libm::sincos(20_f64.to_radians());
        assert!(along([cosine, 0.0, -sine]).abs() < 1e-12);
        // X stays in the old plane of Z and X.
        assert!(rows[1][0].abs() < 1e-12);
    }
}
