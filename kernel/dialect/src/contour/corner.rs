//! Corners between straight lines.
//!
//! *Invariant:* a corner takes no more of a line than there is of it.

use counterpoint_motion::contour::blend::{Cut, TooLong, blend};
use counterpoint_motion::contour::element::Element;

use super::plane::{Point, direction, minus, turn};

/// What a corner needs of both its lines, and how it turns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Corner {
    /// Where the first line ends.
    pub(crate) from: Point,
    /// Where the second line begins.
    pub(crate) to: Point,
    /// The rounding is clockwise.
    pub(crate) clockwise: bool,
}

/// A chamfer of this length on both lines, or a rounding with this radius.
///
/// # Errors
/// Why there is none.
pub(crate) fn corner(
    before: Point,
    corner: Point,
    after: Point,
    chamfer: bool,
    size: f64,
) -> Result<Corner, &'static str> {
    let (Some(in_), Some(out)) = (direction(minus(corner, before)), direction(minus(after, corner))) else {
        return Err("a corner needs a line before it and a line after it");
    };
    if !(size > 0.0 && size.is_finite()) {
        return Err("a corner needs a length or radius above zero");
    }
    if turn(in_, out).abs() < 1e-9 {
        return Err("lines of one direction have no corner");
    }
    let mut first = Element { from: before, to: corner, arc: None };
    let mut second = Element { from: corner, to: after, arc: None };
    let cut = if chamfer { Cut::Legs(size) } else { Cut::Round(size) };
    match blend(&mut first, &mut second, cut) {
        Ok(_) => Ok(Corner { from: first.to, to: second.from, clockwise: turn(in_, out) < 0.0 }),
        Err(TooLong) => Err("the corner is larger than its lines"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_take_room_of_both_lines() {
        let made = corner([0.0, 0.0], [10.0, 0.0], [10.0, 10.0], false, 2.0).unwrap();
        assert_eq!((made.from, made.to, made.clockwise), ([8.0, 0.0], [10.0, 2.0], false));
        let made = corner([0.0, 0.0], [10.0, 0.0], [10.0, -10.0], true, 1.0).unwrap();
        assert_eq!((made.from, made.to, made.clockwise), ([9.0, 0.0], [10.0, -1.0], true));
        assert!(corner([0.0, 0.0], [1.0, 0.0], [1.0, 10.0], false, 2.0).is_err());
        assert!(corner([0.0, 0.0], [1.0, 0.0], [2.0, 0.0], false, 0.1).is_err());
    }
}
