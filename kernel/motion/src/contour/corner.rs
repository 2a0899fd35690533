//! The path between two pieces of a contour: the offsets cut each other inside, and are joined outside.
//!
//! Facts: reference control-emulator.md 6.6. Decisions: docs/emulation.md, "Cutter radius". *Invariant:* every way is
//! finite; where the tool does not fit, the path goes beside the contour's points and says so.

use super::element::{Element, NOISE, Spot, beside, cross, distance, dot, plus};

/// The offset of a contour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Offset {
    /// +1 left of the path, −1 right.
    pub side: f64,
    /// Radius of the tool, length units.
    pub radius: f64,
    /// 0 by the angle, 1 sharp, 2 arc.
    pub corner: u8,
    /// Cosine of the largest turn that 0 makes sharp.
    pub limit: f64,
    /// Limits of 1 and 2; none for corners that are always sharp or round.
    pub shape: Option<CornerThresholds>,
}

/// Outside corners whose kind depends on the turn (Siemens G450, G451, DISC).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CornerThresholds {
    /// Cosine of the largest turn at which sharp corners continue to the intersection of the offsets; larger turns are
    /// round.
    pub sharp: f64,
    /// Cosine of the largest turn at which round corners are sharp.
    pub flat: f64,
    /// Distortion of round corners: 0 is a circle, 1 the intersection of the offsets.
    pub distortion: f64,
}

/// A move between the offsets of two pieces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Link {
    /// A straight line to a point.
    Line(Spot),
    /// Around a corner of the contour.
    Round {
        /// End.
        to: Spot,
        /// Centre.
        center: Spot,
        /// Clockwise in the plane.
        clockwise: bool,
    },
}

/// The end of one piece and the path to the next.
#[derive(Debug, Clone, PartialEq)]
pub struct CornerPath {
    /// Where the offset of the first piece ends.
    pub end: Spot,
    /// Moves to the start of the offset of the next piece.
    pub links: Vec<Link>,
    /// The tool does not fit in.
    pub hurts: bool,
}

impl Offset {
    /// Beside the end of a piece.
    pub fn at_end(&self, element: &Element) -> Spot {
        beside(element.to, element.end(), self.side, self.radius)
    }

    /// Beside the start of a piece.
    pub fn at_start(&self, element: &Element) -> Spot {
        beside(element.from, element.start(), self.side, self.radius)
    }

    /// Between two pieces; `here` is where the tool is before the first one.
    pub fn between(&self, first: &Element, second: &Element, here: Spot) -> CornerPath {
        let small = first.is_smaller(self.side, self.radius);
        let (end, start) = (self.at_end(first), self.at_start(second));
        if distance(end, start) < NOISE {
            return CornerPath { end, links: Vec::new(), hurts: small };
        }
        let turn = cross(first.end(), second.start()) * self.side;
        if turn > 0.0 && distance(first.end(), second.start()) < 2.0 - NOISE {
            return self.inside(first, second, here, small);
        }
        if let Some((meets, links)) = self.beyond(first, second) {
            return CornerPath { end: meets, links, hurts: small };
        }
        let mut links = self.outside(first.to, first.end(), second);
        // A straight piece continues to where its offset is left.
        let mut end = end;
        if let (None, Some(Link::Line(to))) = (&first.arc, links.first()) {
            end = *to;
            links.remove(0);
        }
        CornerPath { end, links, hurts: small }
    }

    /// Between two pieces; outside both offsets continue by a length before an arc joins them, at most to where they
    /// meet.
    pub fn extended(&self, first: &Element, second: &Element, here: Spot, by: f64) -> CornerPath {
        let (before, after) = (first.end(), second.start());
        let (end, start) = (self.at_end(first), self.at_start(second));
        let turn = cross(before, after) * self.side;
        let cosine = dot(before, after);
        if turn > -NOISE || cosine < NOISE - 1.0 || by < NOISE || distance(end, start) < NOISE {
            return self.between(first, second, here);
        }
        let slope = ((1.0 - cosine) / (1.0 + cosine)).sqrt();
        let meets = self.radius * slope;
        let own = by.min(meets);
        let (leaves, comes) = (plus(end, before, own), plus(start, after, -own));
        let mut links = Vec::new();
        if first.arc.is_some() {
            links.push(Link::Line(leaves));
        }
        if own < meets - NOISE {
            let out = plus(end, first.to, -1.0).map(|part| part / self.radius);
            let center = plus(leaves, out, own / slope - self.radius);
            links.push(Link::Round { to: comes, center, clockwise: self.side > 0.0 });
        }
        if second.arc.is_some() {
            links.push(Link::Line(start));
        }
        let end = if first.arc.is_some() { end } else { leaves };
        CornerPath { end, links, hurts: first.is_smaller(self.side, self.radius) }
    }

    fn inside(&self, first: &Element, second: &Element, here: Spot, small: bool) -> CornerPath {
        let (end, start) = (self.at_end(first), self.at_start(second));
        let fits = |spot: &Spot| first.share(*spot) >= first.share(here) - 1e-6 && second.share(*spot) <= 1.0 + 1e-6;
        let near = |a: &Spot, b: &Spot| distance(*a, first.to).total_cmp(&distance(*b, first.to));
        let crossings = self.crossings(first, second);
        let cut = crossings.into_iter().flatten().filter(|spot| spot.iter().all(|part| part.is_finite()));
        match cut.filter(fits).min_by(near) {
            Some(cut) if !small => CornerPath { end: cut, links: Vec::new(), hurts: false },
            _ => CornerPath { end, links: vec![Link::Line(start)], hurts: true },
        }
    }

    /// Where the offsets of two pieces meet.
    pub(super) fn crossings(&self, first: &Element, second: &Element) -> [Option<Spot>; 2] {
        let round = |element: &Element| {
            let arc = element.arc.as_ref()?;
            Some((arc.center, element.offset_radius(self.side, self.radius)?))
        };
        let slack = off_circle(first, first.to) + off_circle(second, second.from);
        match (first.arc.is_some(), second.arc.is_some()) {
            (false, false) => [lines((self.at_end(first), first.end()), (self.at_start(second), second.start())), None],
            (false, true) => {
                round(second).map_or([None; 2], |c| line_circle(self.at_end(first), first.end(), c, slack))
            }
            (true, false) => {
                round(first).map_or([None; 2], |c| line_circle(self.at_start(second), second.start(), c, slack))
            }
            (true, true) => round(first).zip(round(second)).map_or([None; 2], |(a, b)| circles(a, b, slack)),
        }
    }

    /// Whether an outside corner of this turn is sharp.
    fn is_sharp(&self, cosine: f64) -> bool {
        match (self.corner, &self.shape) {
            (0, _) => cosine >= self.limit - 1e-9,
            (1, Some(shape)) => cosine >= shape.sharp - 1e-9,
            (2, Some(shape)) => cosine > shape.flat + 1e-9,
            (corner, _) => corner == 1,
        }
    }

    /// Whether the path goes around the corner after the first piece.
    pub fn goes_around(&self, first: &Element, second: &Element) -> bool {
        let (before, after) = (first.end(), second.start());
        let turn = cross(before, after) * self.side;
        let opposite = distance(before, after) >= 2.0 - NOISE;
        (turn < 0.0 || opposite)
            && distance(self.at_end(first), self.at_start(second)) >= NOISE
            && !self.is_sharp(dot(before, after))
    }

    /// The outside intersection of the offsets of two pieces, with circles extended as circles; there is no link to it
    /// from the end of a line.
    fn beyond(&self, first: &Element, second: &Element) -> Option<(Spot, Vec<Link>)> {
        self.shape?;
        if first.arc.is_none() && second.arc.is_none() || !self.is_sharp(dot(first.end(), second.start())) {
            return None;
        }
        let corner = first.to;
        let middle = plus(self.at_end(first), self.at_start(second), 1.0);
        let outwards = plus(middle, corner, -2.0);
        let near = |a: &Spot, b: &Spot| distance(*a, corner).total_cmp(&distance(*b, corner));
        let crossings = self.crossings(first, second).into_iter().flatten();
        let meets = crossings
            .filter(|spot| spot.iter().all(|part| part.is_finite()) && dot(plus(*spot, corner, -1.0), outwards) > 0.0)
            .min_by(near)?;
        Some((meets, Vec::new()))
    }

    /// From beside the end of a piece around its corner to the next piece.
    pub fn outside(&self, corner: Spot, before: Spot, next: &Element) -> Vec<Link> {
        let after = next.start();
        let end = beside(corner, before, self.side, self.radius);
        let start = self.at_start(next);
        let cosine = dot(before, after);
        if !self.is_sharp(cosine) {
            let distortion = self.shape.map_or(0.0, |shape| shape.distortion);
            return round(self, (corner, before, after), (end, start), distortion);
        }
        let mut links = if cosine >= -1e-9 || self.shape.is_some() {
            // Both offsets continue to where they meet.
            let [a, b] = [end, start].map(|spot| plus(spot, corner, -1.0));
            vec![Link::Line(plus(corner, plus(a, b, 1.0), 1.0 / (1.0 + cosine)))]
        } else {
            // A sharp corner is cut off: both continue by the radius.
            vec![Link::Line(plus(end, before, self.radius)), Link::Line(plus(start, after, -self.radius))]
        };
        if next.arc.is_some() {
            links.push(Link::Line(start));
        }
        links
    }
}

/// Path around a corner from beside the end of a piece to beside the start of the next: a circle, or two pairs of arcs
/// in place of a conic.
///
/// The conic is tangent to both offsets. Its highest point is on the line from the highest point of the circle to the
/// intersection of the offsets.
fn round(
    offset: &Offset,
    (corner, before, after): (Spot, Spot, Spot),
    (end, start): (Spot, Spot),
    by: f64,
) -> Vec<Link> {
    let clockwise = offset.side > 0.0;
    let circle = vec![Link::Round { to: start, center: corner, clockwise }];
    let [out, other] = [end, start].map(|spot| plus(spot, corner, -1.0));
    let both = plus(out, other, 1.0);
    let size = distance(both, [0.0; 2]);
    if by < NOISE || size < 1e-3 * offset.radius {
        return circle;
    }
    let middle = both.map(|part| part / size);
    let peak = plus(corner, middle, offset.radius);
    let meets = plus(corner, middle, 2.0 * offset.radius * offset.radius / size);
    if by > 1.0 - NOISE {
        return vec![Link::Line(meets), Link::Line(start)];
    }
    let top = plus(peak, plus(meets, peak, -1.0), by);
    let along = if clockwise { [middle[1], -middle[0]] } else { [-middle[1], middle[0]] };
    let (first, second) = ((end, before), (top, along));
    let halves = [biarc(first, second, clockwise), biarc(second, (start, after), clockwise)];
    let links: Option<Vec<[Link; 2]>> = halves.into_iter().collect();
    links.map_or(circle, |links| links.into_iter().flatten().collect())
}

/// Two arcs that touch each other and both directions; they meet at the centre of the circle within the ends and the
/// point where the directions meet, so both turn the same way.
fn biarc((from, one): (Spot, Spot), (to, other): (Spot, Spot), clockwise: bool) -> Option<[Link; 2]> {
    let way = plus(to, from, -1.0);
    let turn = cross(one, other);
    let [first, second] = [cross(way, other) / turn, cross(one, way) / turn];
    let chord = distance(from, to);
    let apex = plus(from, one, first);
    let sum = plus(plus(from.map(|part| part * second), apex, chord), to, first);
    let joint = sum.map(|part| part / (first + second + chord));
    let center = |at: Spot, along: Spot| {
        let inwards = if clockwise { [along[1], -along[0]] } else { [-along[1], along[0]] };
        let chord = plus(joint, at, -1.0);
        let radius = dot(chord, chord) / (2.0 * dot(chord, inwards));
        let center = plus(at, inwards, radius);
        (radius.is_finite() && radius > NOISE).then_some(center)
    };
    let link = |to: Spot, center: Spot| Link::Round { to, center, clockwise };
    Some([link(joint, center(from, one)?), link(to, center(to, other)?)])
}

/// Where two lines meet.
fn lines((a, along): (Spot, Spot), (b, other): (Spot, Spot)) -> Option<Spot> {
    let by = cross(along, other);
    (by.abs() > 1e-12).then(|| plus(a, along, cross(plus(b, a, -1.0), other) / by))
}

/// How far an end of a piece is from its circle: programs round the ends of arcs.
fn off_circle(element: &Element, end: Spot) -> f64 {
    element.arc.as_ref().map_or(0.0, |arc| (distance(arc.center, end) - arc.radius).abs())
}

/// Where a line meets a circle, which it may miss by `slack`: offsets of a tangential transition, whose end is rounded,
/// do.
fn line_circle(a: Spot, along: Spot, (center, radius): (Spot, f64), slack: f64) -> [Option<Spot>; 2] {
    let foot = dot(plus(center, a, -1.0), along);
    let nearest = plus(a, along, foot);
    let off = distance(nearest, center);
    let half = radius * radius - off * off;
    if half < -NOISE && off > radius + slack {
        return [None; 2];
    }
    let half = half.max(0.0).sqrt();
    [Some(plus(nearest, along, half)), Some(plus(nearest, along, -half))]
}

/// Where two circles meet, which may miss each other by `slack`.
fn circles((a, one): (Spot, f64), (b, other): (Spot, f64), slack: f64) -> [Option<Spot>; 2] {
    let apart = distance(a, b);
    if apart < NOISE {
        return [None; 2];
    }
    let along = plus(b, a, -1.0).map(|part| part / apart);
    let foot = (one * one - other * other + apart * apart) / (2.0 * apart);
    let half = one * one - foot * foot;
    let gap = (apart - one - other).max((one - other).abs() - apart);
    if half < -NOISE && gap > slack {
        return [None; 2];
    }
    let half = half.max(0.0).sqrt();
    let middle = plus(a, along, foot);
    let aside = [-along[1], along[0]];
    [Some(plus(middle, aside, half)), Some(plus(middle, aside, -half))]
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::arc::PlaneArc;

    fn line(from: Spot, to: Spot) -> Element {
        Element { from, to, arc: None }
    }

    fn left(corner: u8) -> Offset {
        Offset { side: 1.0, radius: 2.0, corner, limit: 0.0, shape: None }
    }

    #[test]
    fn inside_the_offsets_cut_each_other() {
        let corner = left(0).between(&line([0.0, 0.0], [10.0, 0.0]), &line([10.0, 0.0], [10.0, 10.0]), [0.0, 2.0]);
        assert_eq!(corner, CornerPath { end: [8.0, 2.0], links: Vec::new(), hurts: false });
    }

    #[test]
    fn a_tangential_transition_may_miss_by_what_the_end_of_the_arc_is_rounded() {
        // A quarter circle about [0, 10], whose end is a thousandth farther from the centre than its start.
        let arc = PlaneArc { center: [0.0, 10.0], radius: 10.0, start_angle: -PI / 2.0, sweep: PI / 2.0 };
        let first = Element { from: [0.0, 0.0], to: [10.001, 10.0], arc: Some(arc) };
        for x in [10.001, 10.0, 9.995] {
            let corner = left(0).between(&first, &line([10.001, 10.0], [x, 30.0]), [0.0, 2.0]);
            assert!(!corner.hurts && corner.links.is_empty(), "{x}: {corner:?}");
            assert!(distance(corner.end, [8.0, 10.0]) < 0.13, "{x}: {corner:?}");
        }
        // The same from one arc into another one that turns the same way.
        let arc = PlaneArc { center: [5.0, 10.0], radius: 5.001, start_angle: 0.0, sweep: PI / 2.0 };
        let second = Element { from: [10.001, 10.0], to: [5.0, 15.001], arc: Some(arc) };
        let corner = left(0).between(&first, &second, [0.0, 2.0]);
        assert!(!corner.hurts, "{corner:?}");
    }

    #[test]
    fn outside_they_are_joined_sharp_or_round() {
        let (first, second) = (line([0.0, 0.0], [10.0, 0.0]), line([10.0, 0.0], [10.0, -10.0]));
        let sharp = left(1).between(&first, &second, [0.0, 2.0]);
        assert_eq!(sharp, CornerPath { end: [12.0, 2.0], links: Vec::new(), hurts: false });
        let round = left(2).between(&first, &second, [0.0, 2.0]);
        let link = Link::Round { to: [12.0, 0.0], center: [10.0, 0.0], clockwise: true };
        assert_eq!(round, CornerPath { end: [10.0, 2.0], links: vec![link], hurts: false });
    }

    #[test]
    fn round_corners_are_distorted_into_arcs_that_touch_each_other() {
        let shape = CornerThresholds { sharp: -0.2, flat: 1.0, distortion: 0.0 };
        for (turn, by) in [(20.0_f64, 0.1), (90.0, 0.5), (90.0, 0.9), (150.0, 0.3), (179.0, 0.5)] {
            for side in [1.0, -1.0] {
                let (sine, cosine) = (turn * -side).to_radians().sin_cos();
                let (first, second) = (line([-9.0, 0.0], [0.0, 0.0]), line([0.0, 0.0], [9.0 * cosine, 9.0 * sine]));
                let offset = Offset {
                    side,
                    radius: 2.0,
                    corner: 2,
                    limit: 0.0,
                    shape: Some(CornerThresholds { distortion: by, ..shape }),
                };
                let corner = offset.between(&first, &second, [-9.0, 2.0 * side]);
                assert_eq!(corner.links.len(), 4, "{turn} {by}");
                let mut here = (corner.end, [1.0, 0.0]);
                for link in &corner.links {
                    let Link::Round { to, center, clockwise } = *link else { panic!("{link:?}") };
                    let radius = distance(here.0, center);
                    assert!((radius - distance(to, center)).abs() < 1e-9 * radius.max(1.0), "{turn} {by}");
                    let along = |spot: Spot| {
                        let [x, y] = plus(spot, center, -1.0).map(|part| part / radius);
                        if clockwise { [y, -x] } else { [-y, x] }
                    };
                    assert!(distance(along(here.0), here.1) < 1e-6, "{turn} {by}");
                    here = (to, along(to));
                }
                assert!(distance(here.1, second.start()) < 1e-6, "{turn} {by}");
                // The highest point is part of the path from the circle to the intersection of the paths.
                let Link::Round { to: top, .. } = corner.links[1] else { panic!() };
                let meets = 2.0 / (turn / 2.0).to_radians().cos();
                assert!((distance(top, [0.0; 2]) - (2.0 + by * (meets - 2.0))).abs() < 1e-9, "{turn} {by}");
            }
        }
    }

    #[test]
    fn sharp_corners_end_at_their_limit() {
        let offset = Offset { shape: Some(CornerThresholds { sharp: -0.17, flat: 0.98, distortion: 0.0 }), ..left(1) };
        let to = |turn: f64| line([0.0, 0.0], [9.0 * turn.to_radians().cos(), -9.0 * turn.to_radians().sin()]);
        let first = line([-9.0, 0.0], [0.0, 0.0]);
        for turn in [5.0, 60.0, 99.0] {
            let corner = offset.between(&first, &to(turn), [-9.0, 2.0]);
            let meets = 2.0 * (turn / 2.0).to_radians().tan();
            assert!(corner.links.is_empty() && distance(corner.end, [meets, 2.0]) < 1e-9, "{turn}: {corner:?}");
            assert!(!offset.goes_around(&first, &to(turn)));
        }
        for turn in [100.0, 179.0, 180.0] {
            assert!(offset.goes_around(&first, &to(turn)), "{turn}");
            assert!(matches!(offset.between(&first, &to(turn), [-9.0, 2.0]).links[..], [Link::Round { .. }]));
        }
        assert!(!Offset { corner: 2, ..offset }.goes_around(&first, &to(5.0)));
        assert!(!offset.goes_around(&first, &to(-100.0)));
    }

    #[test]
    fn a_pocket_smaller_than_the_tool_is_told() {
        let corner = left(0).between(&line([0.0, 0.0], [10.0, 0.0]), &line([10.0, 0.0], [10.0, 1.0]), [0.0, 2.0]);
        assert!(corner.hurts);
        let back = left(0).between(&line([0.0, 0.0], [10.0, 0.0]), &line([10.0, 0.0], [0.0, 0.0]), [0.0, 2.0]);
        assert!(!back.hurts && back.links.len() == 1);
    }
}
