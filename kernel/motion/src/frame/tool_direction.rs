//! Directions of a tool in the forms in which programs write them.
//!
//! *Invariant:* angles that are not finite give no direction. Facts: reference control-emulator.md 6.8,
//! system-variables.md 12.

use super::affine::Point;
use super::plane::{UNITS, turned, turned_about_fixed};

/// Direction of the tip that the three words of a form (`$TCPFMT`) mean; `tip`: the programmed tip.
pub fn direction_by_words(format: u8, [a, b, c]: Point, tip: Point) -> Option<Point> {
    let map = match format {
        2 => return Some([a, b, c]),
        3 => {
            let [p, q, r] = tip;
            return Some([a - p, b - q, c - r]);
        }
        // About the fixed X, then Y, then Z.
        4 => turned_about_fixed([0, 1, 2], [a, b, c])?,
        // About Z, then the X that has turned, then the Z that has turned.
        5 => turned([2, 0, 2], [a, b, c])?,
        // About X, then the Y and the Z that have turned.
        6 => turned([0, 1, 2], [a, b, c])?,
        _ => return None,
    };
    Some(map.direction(UNITS[2]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forms_of_the_direction() {
        let of = |format, values| {
            let direction = direction_by_words(format, values, [1.0, 2.0, 3.0]).unwrap();
            direction.map(|value| (value * 1e9).round() / 1e9)
        };
        assert_eq!(of(2, [0.0, 0.0, 5.0]), [0.0, 0.0, 5.0]);
        assert_eq!(of(3, [1.0, 2.0, 13.0]), [0.0, 0.0, 10.0]);
        assert_eq!(of(4, [90.0, 0.0, 0.0]), [0.0, -1.0, 0.0]);
        assert_eq!(of(4, [0.0, 90.0, 90.0]), [0.0, 1.0, 0.0]);
        assert_eq!(of(5, [90.0, 90.0, 0.0]), [1.0, 0.0, 0.0]);
        assert_eq!(of(6, [90.0, 90.0, 0.0]), [1.0, 0.0, 0.0]);
        assert_eq!(direction_by_words(4, [f64::NAN, 0.0, 0.0], [0.0; 3]), None);
    }
}
