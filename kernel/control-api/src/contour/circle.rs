//! Circles about a pole.

/// Degrees from one angle to another in a direction; a full circle if they are the same.
pub fn angle_between(from: f64, to: f64, clockwise: bool) -> f64 {
    let way = to - from;
    let way = (if clockwise { -way } else { way }).rem_euclid(360.0);
    if (1e-9..=360.0 - 1e-9).contains(&way) { way } else { 360.0 }
}

/// Parts of the path, up to 1, at which the equal pieces of an arc of this many degrees end; none of them has more than
/// `largest`.
pub fn pieces(degrees: f64, largest: f64) -> impl Iterator<Item = f64> {
    let count = (degrees / largest - 1e-9).ceil().max(1.0) as u32;
    (1..=count).map(move |piece| f64::from(piece) / f64::from(count))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arcs_are_made_in_pieces_of_a_largest_angle() {
        for (degrees, expected) in [(90.0, vec![1.0]), (270.0, vec![1.0]), (360.0, vec![0.5, 1.0])] {
            assert_eq!(pieces(degrees, 270.0).collect::<Vec<_>>(), expected, "{degrees}");
        }
        assert_eq!((angle_between(0.0, 90.0, false), angle_between(0.0, 90.0, true)), (90.0, 270.0));
        assert_eq!(angle_between(45.0, 45.0, true), 360.0);
    }
}
