//! Circles that go forward along a path: trochoidal milling.
//!
//! Decisions: full circles about places of the path that are a step apart, and between two of them a piece beside the
//! path, on the side where the circle goes forward, so that there is no corner on a straight path. The last step is the
//! remainder. *Invariant:* no point is farther from the path than the radius, except by the deviation of a chord at a
//! corner of the path.

use super::element::{Element, NOISE, Spot, beside, distance};
use super::near::at;
use crate::arc::by_center;

/// Most circles.
const MOST: f64 = 100_000.0;

/// Circles of a radius about places of a path that are a step apart, from the first place to the last one; none where
/// there are too many or a length is none.
#[must_use]
pub fn trochoid(way: &[Element], radius: f64, step: f64, clockwise: bool) -> Option<Vec<Element>> {
    let whole: f64 = way.iter().map(Element::length).sum();
    let counts = radius > NOISE && step > NOISE && whole > NOISE;
    if !counts || whole / step > MOST {
        return None;
    }
    // Against the clock the circle goes forward on the right of its centre.
    let side = if clockwise { 1.0 } else { -1.0 };
    let mut out = Vec::new();
    let mut last: Option<(usize, Spot)> = None;
    let circles = (whole / step - NOISE).ceil().max(1.0) as u32;
    for circle in 0..=circles {
        let (place, center, heading) = along(way, (f64::from(circle) * step).min(whole))?;
        let here = beside(center, heading, side, radius);
        if let Some((before, from)) = last
            && distance(from, here) > NOISE
        {
            let of_way = way.get(place)?.arc.filter(|_| before == place);
            let arc = of_way.and_then(|arc| by_center(from, here, arc.center, arc.sweep < 0.0).ok());
            out.push(Element { from, to: here, arc });
        }
        out.push(Element { from: here, to: here, arc: Some(by_center(here, here, center, clockwise).ok()?) });
        last = Some((place, here));
    }
    Some(out)
}

/// The place of a path at a length from its start: the number of its element, the point, the direction there.
fn along(way: &[Element], length: f64) -> Option<(usize, Spot, Spot)> {
    let mut left = length;
    let last = way.len().checked_sub(1)?;
    for (place, element) in way.iter().enumerate() {
        let own = element.length();
        if left <= own + NOISE || place == last {
            let spot = at(element, (left / own).clamp(0.0, 1.0));
            let heading = Element { from: spot, to: element.to, arc: element.arc };
            let is_end = distance(spot, element.to) < NOISE;
            return Some((place, spot, if is_end { element.end() } else { heading.start() }));
        }
        left -= own;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(from: Spot, to: Spot) -> Element {
        Element { from, to, arc: None }
    }

    #[test]
    fn circles_lie_a_step_apart_and_go_forward_on_the_right() {
        let made = trochoid(&[line([0.0, 0.0], [5.0, 0.0])], 2.0, 2.0, false).unwrap();
        let starts: Vec<Spot> =
            made.iter().filter(|element| element.arc.is_some()).map(|element| element.from).collect();
        assert_eq!(starts, [[0.0, -2.0], [2.0, -2.0], [4.0, -2.0], [5.0, -2.0]]);
        assert!(made.windows(2).all(|pair| distance(pair[0].to, pair[1].from) < 1e-9));
        // No corner on a straight path.
        assert!(made.windows(2).all(|pair| distance(pair[0].end(), pair[1].start()) < 1e-9));
        let with_the_clock = trochoid(&[line([0.0, 0.0], [5.0, 0.0])], 2.0, 2.0, true).unwrap();
        assert_eq!(with_the_clock[0].from, [0.0, 2.0]);
    }

    #[test]
    fn no_circle_leaves_a_slot_that_bends() {
        let quarter = by_center([10.0, 0.0], [20.0, 10.0], [10.0, 10.0], false).unwrap();
        let way = [line([0.0, 0.0], [10.0, 0.0]), Element { from: [10.0, 0.0], to: [20.0, 10.0], arc: Some(quarter) }];
        let made = trochoid(&way, 3.0, 1.5, false).unwrap();
        for element in made.iter().filter(|element| element.from != element.to && element.arc.is_some()) {
            assert!((distance(element.from, [10.0, 10.0]) - 13.0).abs() < 1e-9);
            assert!(element.arc.unwrap().sweep > 0.0);
        }
    }

    #[test]
    fn nothing_without_lengths() {
        assert!(trochoid(&[], 2.0, 1.0, false).is_none());
        assert!(trochoid(&[line([0.0, 0.0], [5.0, 0.0])], 0.0, 1.0, false).is_none());
        assert!(trochoid(&[line([0.0, 0.0], [5.0, 0.0])], 2.0, 0.0, false).is_none());
        assert!(trochoid(&[line([0.0, 0.0], [5.0, 0.0])], 2.0, 1e-6, false).is_none());
    }
}
