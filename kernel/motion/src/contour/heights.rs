//! Heights along a path beside a contour that has some.
//!
//! Decisions: a point beside the contour is as high as the point of the contour that it lies beside; around a corner
//! outside the path stays as high as the corner. *Invariant:* a path that is not beside the contour has no heights.

use super::element::{Element, beside, distance};
use super::near::at;

/// How far a point may lie off the contour.
const OFF: f64 = 1e-4;

/// Heights of the ends of each element of a path that lies on one side of a contour by an amount; those of the elements
/// of the contour are given. None where an element of the path lies beside nothing.
#[must_use]
pub fn heights(way: &[Element], (side, amount): (f64, f64), contour: &[(Element, [f64; 2])]) -> Option<Vec<[f64; 2]>> {
    let mut first = 0;
    let mut out = Vec::with_capacity(way.len());
    for element in way {
        let foot = |share: f64| {
            let spot = at(element, share);
            let heading = Element { from: spot, ..*element };
            beside(spot, if share < 1.0 { heading.start() } else { element.end() }, -side, amount)
        };
        let share_of = |own: &Element, share: f64| own.share(foot(share)).clamp(0.0, 1.0);
        let is_beside = |(own, _): &(Element, [f64; 2])| {
            [0.5, 0.25, 0.75].iter().all(|share| distance(at(own, share_of(own, *share)), foot(*share)) < OFF)
        };
        first += contour.get(first..)?.iter().position(is_beside)?;
        let (own, [from, to]) = contour.get(first)?;
        out.push([0.0, 1.0].map(|share| from + (to - from) * share_of(own, share)));
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::super::shifted::rounded;
    use super::*;

    fn line(from: [f64; 2], to: [f64; 2]) -> Element {
        Element { from, to, arc: None }
    }

    #[test]
    fn spots_are_as_high_as_what_they_lie_beside() {
        let contour = [line([0.0, 0.0], [10.0, 0.0]), line([10.0, 0.0], [10.0, 10.0])];
        let high = [(contour[0], [0.0, -5.0]), (contour[1], [-6.0, -8.0])];
        // Inside, the path ends 2 before the corner; then it begins 2 after it.
        let inside = rounded(&contour, 1.0, 2.0).unwrap();
        assert_eq!(heights(&inside, (1.0, 2.0), &high), Some(vec![[0.0, -4.0], [-6.4, -8.0]]));
        // Outside, the arc around the corner is as high as the end of the first element.
        let outside = rounded(&contour, -1.0, 2.0).unwrap();
        assert_eq!(heights(&outside, (-1.0, 2.0), &high), Some(vec![[0.0, -5.0], [-5.0, -5.0], [-6.0, -8.0]]));
        assert_eq!(heights(&outside, (-1.0, 3.0), &high), None);
    }
}
