//! The moves of a turning cycle as motions of its block.
//!
//! *Invariant:* a move that changes no coordinate makes no motion.

use counterpoint_channel::modal::plane;
use counterpoint_channel::turning::LathePlane;
use counterpoint_event::event::{FeedUnit, Position};
use counterpoint_fault::{Acted, Halt};
use counterpoint_machine::ident::codes;
use counterpoint_motion::arc as geometry;
use counterpoint_motion::turning::{CycleMove, MoveSink};

use crate::context::{ActionContext, CircleSteps};
use crate::motion::{feed_to_point, rapid_to_point};
use crate::{cutter, dwell, turned};
use counterpoint_channel::circular_move::CircularMove;

/// A cycle that is being cut.
pub(crate) struct Cutting<'x, 'k, 'a> {
    act: &'x mut ActionContext<'k, 'a>,
    plane: LathePlane,
    feed: (Option<f64>, FeedUnit),
    /// Its own feed, and those of changes.
    feeds: [Option<f64>; 3],
    /// Those of the pieces of its contour, and the one of pieces without.
    pieces: Vec<Option<f64>>,
    level: Option<f64>,
}

impl<'x, 'k, 'a> Cutting<'x, 'k, 'a> {
    /// A cycle at this feed.
    pub(crate) fn new(act: &'x mut ActionContext<'k, 'a>, plane: &LathePlane, feed: (Option<f64>, FeedUnit)) -> Self {
        Self { act, plane: *plane, feed, feeds: [feed.0, None, None], pieces: Vec::new(), level: feed.0 }
    }

    /// With feeds of changes, and those of the pieces of the contour.
    pub(crate) fn with_feeds(self, [first, second]: [Option<f64>; 2], pieces: Vec<Option<f64>>) -> Self {
        Self { feeds: [self.feed.0, first, second], pieces, ..self }
    }

    fn arc(&mut self, [from, to]: [Position; 2], (center, clockwise): ([f64; 2], bool), coded: u8) -> Acted {
        let (feed, unit) = self.feed;
        let [start, end] = [from, to].map(|position| self.plane.point(&position));
        let Ok(made) = geometry::by_center(start, end, center, clockwise) else {
            return feed_to_point(self.act, coded, to, feed, unit);
        };
        let circle = CircularMove { made, coded, from, to, axes: self.plane.axes, turns: 0, feed, unit, screw: None };
        round(self.act, &circle)
    }
}

/// A circle in the plane of turning.
pub(crate) fn round(act: &mut ActionContext<'_, '_>, circle: &CircularMove) -> Acted {
    match plane(codes::PLANE_ZX) {
        Some(plane) if act.channel().state.place.frames.is_some() => turned::circle(act, plane, circle),
        _ => act.circle_to(circle),
    }
}

impl MoveSink for Cutting<'_, '_, '_> {
    type Stop = Halt;

    fn pass(&mut self) -> Acted {
        self.act.count_as_block()
    }

    fn use_feed(&mut self, number: usize) {
        let own = self.feeds.iter().take(number + 1).rev().copied().flatten().next();
        self.level = own.or(self.level);
        self.feed.0 = self.level;
    }

    fn piece(&mut self, index: usize) {
        let own = self.pieces.get(index).copied().flatten();
        self.feed.0 = own.or(self.level);
    }

    fn pause(&mut self, seconds: f64) -> Acted {
        dwell::of_cycle(self.act, seconds)
    }

    fn beside(&mut self, side: Option<f64>) -> Acted {
        cutter::beside(self.act, side)
    }

    fn go(&mut self, to: CycleMove) -> Acted {
        let (CycleMove::Rapid(point) | CycleMove::Feed(point) | CycleMove::Arc { to: point, .. }) = to;
        let from = self.act.channel().state.place.programmed();
        let target = self.plane.position(from, point);
        let coded = self.plane.moved(&from, &target);
        if coded == 0 {
            return Ok(());
        }
        let (feed, unit) = self.feed;
        self.act.channel_mut().state.others.spindles.fixed_stops.in_turning_cycle = true;
        let done = match to {
            CycleMove::Rapid(_) => rapid_to_point(self.act, coded, target),
            CycleMove::Feed(_) => feed_to_point(self.act, coded, target, feed, unit),
            CycleMove::Arc { center, clockwise, .. } => self.arc([from, target], (center, clockwise), coded),
        };
        self.act.channel_mut().state.others.spindles.fixed_stops.in_turning_cycle = false;
        done
    }
}

/// Goes to a programmed point at rapid, in the plane of turning.
pub(crate) fn go_back(act: &mut ActionContext<'_, '_>, to: &Position) -> Acted {
    let Some(plane) = act.channel().state.lathe_plane() else { return Ok(()) };
    let point = plane.point(to);
    Cutting::new(act, &plane, (None, FeedUnit::Rapid)).go(CycleMove::Rapid(point))
}
