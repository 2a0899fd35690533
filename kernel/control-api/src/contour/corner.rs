//! Corners between two elements of a contour.
//!
//! *Invariant:* a corner takes no more of an element than there is of it.

use counterpoint_motion::contour::blend::{CornerBlend, TooLong, blend};
use counterpoint_motion::contour::element::{Element, NOISE};

use super::plane::{Point, minus, turn};

/// Data of both elements that a corner needs, and its direction of rotation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CornerGeometry {
    /// Where the first element ends.
    pub from: Point,
    /// Where the second element begins.
    pub to: Point,
    /// Direction of the second element where it begins.
    pub heading: Point,
    /// The rounding is clockwise.
    pub clockwise: bool,
}

/// A chamfer of this length on both elements, or a rounding with this radius.
///
/// # Errors
/// Why there is none.
pub fn corner(first: Element, second: Element, chamfer: bool, size: f64) -> Result<CornerGeometry, &'static str> {
    if first.length() < NOISE || second.length() < NOISE {
        return Err("a corner needs an element before it and one after it");
    }
    if !(size > 0.0 && size.is_finite()) {
        return Err("a corner needs a length or radius above zero");
    }
    let (mut first, mut second) = (first, second);
    let turns = turn(first.end(), second.start());
    if turns.abs() < 1e-9 {
        return Err("elements of one direction have no corner");
    }
    let cut = if chamfer { CornerBlend::Legs(size) } else { CornerBlend::Round(size) };
    match blend(&mut first, &mut second, cut) {
        Ok(_) if minus(first.to, second.from).iter().all(|way| way.abs() < NOISE) => {
            Err("the corner is larger than its elements")
        }
        Ok(_) => {
            Ok(CornerGeometry { from: first.to, to: second.from, heading: second.start(), clockwise: turns < 0.0 })
        }
        Err(TooLong) => Err("the corner is larger than its elements"),
    }
}

/// A line.
pub fn line(from: Point, to: Point) -> Element {
    Element { from, to, arc: None }
}

/// An arc about a centre; a whole circle where it ends at its start.
pub fn arc(from: Point, to: Point, center: Point, clockwise: bool) -> Element {
    Element { from, to, arc: counterpoint_motion::arc::by_center(from, to, center, clockwise).ok() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_take_room_of_both_elements() {
        let between =
            |a: Point, b: Point, c: Point, chamfer: bool, size: f64| corner(line(a, b), line(b, c), chamfer, size);
        let made = between([0.0, 0.0], [10.0, 0.0], [10.0, 10.0], false, 2.0).unwrap();
        assert_eq!((made.from, made.to, made.clockwise), ([8.0, 0.0], [10.0, 2.0], false));
        let made = between([0.0, 0.0], [10.0, 0.0], [10.0, -10.0], true, 1.0).unwrap();
        assert_eq!((made.from, made.to, made.clockwise), ([9.0, 0.0], [10.0, -1.0], true));
        assert!(between([0.0, 0.0], [1.0, 0.0], [1.0, 10.0], false, 2.0).is_err());
        assert!(between([0.0, 0.0], [1.0, 0.0], [2.0, 0.0], false, 0.1).is_err());
    }

    #[test]
    fn a_rounding_between_a_line_and_an_arc() {
        // From the line along X onto the circle of radius 10 about 20, 0: the centre is 2 above the line and 12 from
        // 20, 0.
        let second = arc([10.0, 0.0], [20.0, 10.0], [20.0, 0.0], true);
        let made = corner(line([0.0, 0.0], [10.0, 0.0]), second, false, 2.0).unwrap();
        let way = 20.0 - 140.0_f64.sqrt();
        assert!((made.from[0] - way).abs() < 1e-9 && made.from[1] == 0.0, "{made:?}");
        assert!((made.to[1] - 2.0 * 10.0 / 12.0).abs() < 1e-9 && !made.clockwise);
    }
}
