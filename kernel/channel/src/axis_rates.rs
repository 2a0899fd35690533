//! Rates of rotary axes that slow feed moves down: near the centre under polar interpolation, on a cylinder, and under
//! tool tip control.
//!
//! Facts: reference control-emulator.md 6.8 (both), channel-synchronisation.md 3 (rates); that the slower one counts is
//! a decision: docs/emulation.md, "Polar interpolation", "Cylindrical interpolation" and "Tool tip control".
//! Invariants: a time never becomes shorter; it is exact for lines and circles of the part, with the rotary axis at its
//! rate where the feed would ask for more. The rate at which linear axes follow rotary ones is that of the fastest of
//! some places of the move.

use std::f64::consts::TAU;

use counterpoint_event::event::{FeedUnit, Position};
use counterpoint_machine::ident::codes;
use counterpoint_machine::index::BySlot;
use counterpoint_motion::arc::PlaneArc;

use crate::channel_context::ChannelContext;
use crate::frames::polar::between;
use crate::modal::group;

/// Modal group of the edge.
const EDGE: u16 = 149;

/// Paths below this are none.
const NONE: f64 = 1e-9;

/// Steps along a move at whose ends the linear axes that follow the rotary ones are looked at.
const PLACES: u32 = 16;

/// A piece of a path on the part: its length, and degrees that it goes around the centre.
type Piece = (f64, f64);

/// Splits a line where the slower of rotary axis and feed changes. `tight`: path length at the feed while the axis
/// turns a radian.
fn of_line([ax, ay]: [f64; 2], [bx, by]: [f64; 2], tight: f64) -> Vec<Piece> {
    let (dx, dy) = (bx - ax, by - ay);
    let length = dx.hypot(dy);
    if length < NONE {
        return Vec::new();
    }
    // From the foot of the perpendicular along the path.
    let start = (ax * dx + ay * dy) / length;
    let across = (ax * dy - ay * dx).abs() / length;
    let reach = (across * tight - across * across).max(0.0).sqrt();
    let mut ends = [start, -reach, reach, start + length].map(|end| end.clamp(start, start + length));
    ends.sort_by(f64::total_cmp);
    let point = |along: f64| [across, along];
    let pieces = ends.windows(2).map(|ends| match ends {
        [from, to] => (to - from, between(point(*from), point(*to)).abs()),
        _ => (0.0, 0.0),
    });
    pieces.collect()
}

/// The same for a circle.
fn of_circle(made: &PlaneArc, tight: f64) -> Vec<Piece> {
    let PlaneArc { center: [cx, cy], radius, start_angle, sweep } = *made;
    let off = cx.hypot(cy);
    let begin = start_angle - libm::atan2(cy, cx);
    let turns = (sweep.abs() / TAU).floor();
    let rest = sweep.abs() - turns * TAU;
    // With u the cosine of the angle from the farthest point, one radian goes (r² + r c u) / (r² + c² + 2 r c u)
    // radians around the centre.
    let at = |share: f64| {
        let top = share * (radius * radius + off * off) - radius * radius;
        let cosine = top / (radius * off * (1.0 - 2.0 * share));
        (cosine.abs() < 1.0).then(|| libm::acos(cosine))
    };
    let share = radius / tight;
    let changes: Vec<f64> = [share, -share].into_iter().filter_map(at).flat_map(|angle| [angle, -angle]).collect();
    let pieces = |whole: f64| {
        let mut ends = vec![0.0, whole];
        ends.extend(changes.iter().map(|angle| ((angle - begin) * sweep.signum()).rem_euclid(TAU)));
        ends.retain(|end| *end <= whole);
        ends.sort_by(f64::total_cmp);
        let piece = |ends: &[f64]| match ends {
            [from, to] if to > from => {
                let arc = PlaneArc { start_angle: start_angle + from * sweep.signum(), ..*made };
                let round = crate::round_centre::part_round(&arc, (to - from) * sweep.signum());
                (radius * (to - from), round.abs())
            }
            _ => (0.0, 0.0),
        };
        ends.windows(2).map(piece).collect::<Vec<Piece>>()
    };
    let mut all = pieces(rest);
    if turns > 0.0 {
        all.extend(pieces(TAU).into_iter().map(|(way, round)| (way * turns, round * turns)));
    }
    all
}

/// The same for a circle on a cylinder, with ways around it instead of degrees. `round`: which coordinate is the way
/// round; `share`: part of the feed that the axis makes at its rate.
fn on_cylinder(made: &PlaneArc, round: usize, share: f64) -> Vec<Piece> {
    let PlaneArc { radius, start_angle, sweep, .. } = *made;
    // Where the tangent has its share of the way round, and where that changes its sign.
    let first = if round == 0 { 0.0 } else { TAU / 4.0 };
    let mut marks = vec![first, first + TAU / 2.0];
    if share < 1.0 {
        let turned = libm::asin(share);
        marks.extend([first + turned, first - turned, first + TAU / 2.0 + turned, first + TAU / 2.0 - turned]);
    }
    let whole = sweep.abs();
    let mut ends = vec![0.0, whole];
    let turns = (whole / TAU).floor() as u32;
    for mark in marks {
        let once = ((mark - start_angle) * sweep.signum()).rem_euclid(TAU);
        ends.extend((0..=turns).map(|turn| once + f64::from(turn) * TAU).filter(|end| *end < whole));
    }
    ends.sort_by(f64::total_cmp);
    let across = |way: f64| {
        let angle = start_angle + way * sweep.signum();
        if round == 0 { radius * libm::cos(angle) } else { radius * libm::sin(angle) }
    };
    let pieces = ends.windows(2).map(|ends| match ends {
        [from, to] => (radius * (to - from), (across(*to) - across(*from)).abs()),
        _ => (0.0, 0.0),
    });
    pieces.collect()
}

/// Seconds of a feed move that rotary axes may slow down; `made`: the circle on the part.
#[cold]
pub fn at_rates(
    channel: &ChannelContext<'_>,
    seconds: f64,
    from: &Position,
    to: &Position,
    made: Option<&PlaneArc>,
) -> f64 {
    if let Some(tip) = channel.state.place.tip() {
        let seconds = match channel.state.others.tip.follow {
            Some(limit) => {
                let place = &channel.state.place;
                let ways = (0..=PLACES).map(|at| tip.following(place, [from, to], f64::from(at) / f64::from(PLACES)));
                seconds.max(ways.fold(0.0, f64::max) / limit * 60.0)
            }
            None => seconds,
        };
        let turns = channel.state.place.layout.axes.iter().zip(from.iter().zip(to)).filter(|(axis, _)| axis.rotary);
        return turns
            .map(|(axis, (a, b))| (b - a).abs() / axis.rapid)
            .filter(|t| t.is_finite())
            .fold(seconds, f64::max);
    }
    let Some(polar) = channel.state.place.polar() else { return seconds };
    let rate = channel.state.place.layout.axes[polar.rotary].rapid;
    let [start, end] = [from, to].map(|point| polar.part(&channel.state.place, point));
    let length = made.map_or_else(|| (end[0] - start[0]).hypot(end[1] - start[1]), PlaneArc::length);
    let turned = (to.at(polar.rotary) - from.at(polar.rotary)).abs();
    if !(rate > 0.0 && seconds > 0.0 && seconds.is_finite() && turned.is_finite()) {
        return seconds;
    }
    let slowest = turned / rate;
    if length < NONE || !length.is_finite() {
        return seconds.max(slowest);
    }
    let speed = length / seconds;
    if let Some(per_degree) = polar.per_degree() {
        let Some(made) = made else { return seconds.max(slowest) };
        // The first coordinate is the path along the cylinder, or the way round.
        let round = usize::from(polar.axes()[1] == polar.rotary);
        let pieces = on_cylinder(made, round, rate * per_degree / speed);
        let slowed = pieces.iter().map(|(way, turned)| (way / speed).max(turned / per_degree / rate)).sum::<f64>();
        return if slowed.is_finite() && slowed > seconds * (1.0 + 1e-12) { slowed } else { seconds };
    }
    let tight = speed / rate.to_radians();
    let pieces = made.map_or_else(|| of_line(start, end, tight), |made| of_circle(made, tight));
    let time = pieces.iter().map(|(way, round)| (way / speed).max(round / rate)).sum::<f64>();
    // In the centre the axis turns while the tool stands.
    let round = pieces.iter().map(|(_, round)| round).sum::<f64>();
    let still = (turned - round).max(0.0) / rate;
    let still = if still * rate < 1e-6 { 0.0 } else { still };
    let slowed = time + still;
    if slowed.is_finite() && slowed > seconds * (1.0 + 1e-12) { slowed } else { seconds }
}

/// Feed of a move in the work frame, along which the feed counts a length: one that goes down keeps to its share.
#[cold]
pub fn feed_down(
    channel: &ChannelContext<'_>,
    feed: Option<f64>,
    unit: FeedUnit,
    changes: &Position,
    length: f64,
) -> Option<f64> {
    let share = channel.state.place.frames.as_deref().and_then(|frames| frames.feeds.down);
    let (Some(share), Some(full)) = (share, feed) else { return feed };
    let role = match channel.state.modal.code(group::PLANE) {
        Some(codes::PLANE_ZX) => 1,
        Some(codes::PLANE_YZ) => 0,
        _ => 2,
    };
    let tool = channel.state.place.layout.cartesian.get(role).copied().flatten();
    let way = tool.map_or(0.0, |axis| -changes.at(axis));
    if !matches!(unit, FeedUnit::PerMinute | FeedUnit::PerRevolution) || way <= 0.0 {
        return feed;
    }
    // Straight down the path is the length, except for rounding.
    let times = if length - way < way * 1e-12 { 1.0 } else { length / way };
    Some(full.min(full * share * times))
}

/// Feed of the tool's centre beside an arc; `times`: the ratio of the radius of the centre's path to the radius of the
/// contour.
pub fn edge_feed(channel: &ChannelContext<'_>, feed: Option<f64>, unit: FeedUnit, times: f64) -> Option<f64> {
    let counts = match channel.state.modal.code(EDGE) {
        Some(codes::FEED_AT_EDGE) => true,
        Some(codes::FEED_AT_EDGE_INSIDE) => times < 1.0,
        _ => false,
    };
    let counts = counts && matches!(unit, FeedUnit::PerMinute | FeedUnit::PerRevolution);
    feed.map(|feed| if counts { feed * times } else { feed })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sums(pieces: &[Piece]) -> Piece {
        pieces.iter().fold((0.0, 0.0), |(way, round), piece| (way + piece.0, round + piece.1))
    }

    #[test]
    fn pieces_on_a_cylinder() {
        let made = PlaneArc { center: [0.0, 0.0], radius: 10.0, start_angle: 0.3, sweep: -TAU * 1.25 };
        for round in [0, 1] {
            for share in [0.5, 2.0] {
                let (way, turned) = sums(&on_cylinder(&made, round, share));
                assert!((way - 10.0 * TAU * 1.25).abs() < 1e-9);
                // A whole turn goes four radii round, and the rest of a quarter its own part.
                let part = |angle: f64| if round == 0 { angle.cos() } else { angle.sin() };
                let (from, to) = (part(0.3), part(0.3 - TAU / 4.0));
                let rest = if round == 0 { (1.0 - from) + (1.0 - to) } else { from - to };
                assert!((turned - 10.0 * (4.0 + rest)).abs() < 1e-9, "{round} {share} {turned}");
            }
        }
        // A quarter from where the tangent goes round at the full feed: slow until 30 degrees are left.
        let quarter = PlaneArc { start_angle: 0.0, sweep: TAU / 4.0, ..made };
        let pieces = on_cylinder(&quarter, 1, 0.5);
        let slow = pieces.iter().find(|(way, _)| *way > 10.0).copied().unwrap_or_default();
        assert!(
            (slow.0 - 10.0 * TAU / 6.0).abs() < 1e-9 && (slow.1 - 10.0 * (TAU / 6.0).sin()).abs() < 1e-9,
            "{pieces:?}"
        );
    }

    #[test]
    fn pieces_of_a_line() {
        // 3 past the centre, 5 per radian: slower within √(3 · 5 − 9) of the foot.
        let pieces = of_line([3.0, -4.0], [3.0, 4.0], 5.0);
        let inner = 2.0 * 6_f64.sqrt();
        assert!((pieces[1].0 - inner).abs() < 1e-12 && (sums(&pieces).0 - 8.0).abs() < 1e-12, "{pieces:?}");
        assert!((pieces[1].1 - 2.0 * (6_f64.sqrt() / 3.0).atan().to_degrees()).abs() < 1e-9, "{pieces:?}");
        // Straight through the centre half a turn is made in no way at all.
        let through = of_line([-5.0, 0.0], [5.0, 0.0], 1.0);
        assert_eq!(sums(&through), (10.0, 0.0));
        assert!(of_line([1.0, 1.0], [1.0, 1.0], 1.0).is_empty());
    }

    #[test]
    fn pieces_of_a_circle() {
        let around = |center, radius| PlaneArc { center, radius, start_angle: 0.3, sweep: -3.0 * TAU };
        let own = sums(&of_circle(&around([0.0, 0.0], 2.0), 10.0));
        assert!((own.0 - 6.0 * TAU).abs() < 1e-9 && (own.1 - 1080.0).abs() < 1e-6, "{own:?}");
        // A circle that does not go around the centre goes there and back.
        let beside = sums(&of_circle(&around([5.0, 0.0], 2.0), 4.0));
        assert!(beside.1 > 0.0 && (beside.0 - 6.0 * TAU).abs() < 1e-9, "{beside:?}");
    }
}
