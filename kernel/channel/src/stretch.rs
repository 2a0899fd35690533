//! A move at feed as the look-ahead sees it: its directions, and the limits of the axes along it.

use counterpoint_event::event::{MAX_AXES, Motion, MotionKind, Position};
use counterpoint_machine::ident::codes;
use counterpoint_machine::index::AxisSlot;
use counterpoint_machine::model::Dynamics;
use counterpoint_motion::lookahead::LookAheadMove;

use super::ChannelMemory;
use super::channel_axis::ChannelAxis;
use super::channel_context::ChannelContext;
use super::laws::take_law;
use super::modal::group;
use super::pace::{FeedMove, NOISE};
use super::times::MoveTimes;

/// The move for the look-ahead; `None` if the path stops before and after it.
#[inline(always)]
pub fn paced(channel: &ChannelContext<'_>, seconds: f64, motion: &Motion) -> Option<FeedMove> {
    if channel.emitter.times_moves() { continuous(channel, seconds, motion) } else { None }
}

#[inline(never)]
fn continuous(channel: &ChannelContext<'_>, seconds: f64, motion: &Motion) -> Option<FeedMove> {
    match motion.kind {
        MotionKind::Rapid | MotionKind::Thread => None,
        // The spindle leads.
        _ if channel.state.threads.rounds => None,
        _ => of_path(channel, seconds, motion),
    }
}

/// Adds the event of a move at feed whose time depends on later moves. `ns`: its time if speeds changed instantly.
#[inline(always)]
pub fn emit_move(channel: &mut ChannelContext<'_>, ns: i64, motion: &Motion, stretch: &FeedMove) {
    let law = take_law(&mut channel.state, channel.env.machine.time.rapid, motion);
    let ChannelContext { at, block, state: ChannelMemory { place, modal, times, spindle, .. }, emitter, .. } = channel;
    let exact = block.flags.exact_stop || modal.code(group::EXACT_STOP) == Some(codes::EXACTSTOP_ON);
    let mut times = MoveTimes { record: times, command: &spindle.command };
    let axes = place.layout.axes.iter().enumerate();
    let jumps = axes.filter_map(|(at, axis)| Some((at, axis.dynamics.corner_speed?)));
    emitter.emit_move((at, &mut times), (ns, motion), (stretch, exact, law), jumps);
}

/// A move as a piece of a path; none for a move without a path.
fn of_path(channel: &ChannelContext<'_>, seconds: f64, motion: &Motion) -> Option<FeedMove> {
    let axes = &channel.state.place.layout.axes;
    let changes = if channel.state.place.couples() {
        channel
            .state
            .place
            .changes(&channel.state.place.machine_point(&motion.from), &channel.state.place.machine_point(&motion.to))
    } else {
        channel.state.place.changes(&motion.from, &motion.to)
    };
    let along = Along { channel, changes: &changes, seconds };
    match motion.kind {
        MotionKind::ArcCw | MotionKind::ArcCcw => {
            let turn = if motion.kind == MotionKind::ArcCw { -1.0 } else { 1.0 };
            let plane = motion.plane_axes.map(|axis| axes.id(usize::from(axis)));
            match plane {
                [Some(first), Some(second)] => along.circle(motion, [first, second], turn),
                _ => along.line(motion.length),
            }
        }
        MotionKind::ArcSpace => along.line(motion.length),
        _ => along.line(0.0),
    }
}

/// A move that becomes a piece.
struct Along<'p, 'a> {
    channel: &'p ChannelContext<'a>,
    changes: &'p Position,
    seconds: f64,
}

/// The limits along a direction.
struct DirectionLimits {
    speed: f64,
    acceleration: f64,
    jerk: f64,
}

impl DirectionLimits {
    fn none() -> Self {
        Self { speed: f64::INFINITY, acceleration: f64::INFINITY, jerk: f64::INFINITY }
    }

    /// Adds the limits of an axis; `part` is its share of the path.
    fn axis(&mut self, axis: &ChannelAxis, part: f64) {
        let part = part.abs();
        if part > NOISE {
            let Dynamics { acceleration, jerk, .. } = axis.dynamics;
            self.speed = self.speed.min(axis.rapid / part);
            self.acceleration = self.acceleration.min(acceleration.map_or(f64::INFINITY, |a| a / part));
            self.jerk = self.jerk.min(jerk.map_or(f64::INFINITY, |j| j / part));
        }
    }

    fn piece(&self, length: f64, speed: f64) -> LookAheadMove {
        let speed = speed.min(self.speed);
        LookAheadMove { length, speed, acceleration: self.acceleration, jerk: self.jerk, corner: f64::INFINITY }
    }
}

impl Along<'_, '_> {
    /// A path of at least this length that is straight or has unknown directions.
    fn line(&self, length: f64) -> Option<FeedMove> {
        let chord = self.changes.iter().map(|change| change * change).sum::<f64>().sqrt();
        let length = chord.max(length);
        if !(length > NOISE && chord > NOISE && self.seconds > 0.0 && self.seconds.is_finite()) {
            return None;
        }
        let mut direction = *self.changes;
        direction.iter_mut().for_each(|part| *part /= chord);
        let mut limits = DirectionLimits::none();
        for (axis, part) in self.channel.state.place.layout.axes.iter().zip(direction) {
            limits.axis(axis, part);
        }
        Some(FeedMove { piece: limits.piece(length, length / self.seconds), start: direction, end: direction })
    }

    /// A circle in a plane, with or without a rise.
    fn circle(&self, motion: &Motion, plane: [AxisSlot; 2], turn: f64) -> Option<FeedMove> {
        use counterpoint_machine::index::BySlot;
        let axes = &self.channel.state.place.layout.axes;
        let length = motion.length;
        if !(length > NOISE && self.seconds > 0.0 && self.seconds.is_finite()) {
            return None;
        }
        let scale = plane.map(|axis| axes[axis].scale);
        let spoke = |point: &Position| {
            let [x, y] = [0, 1].map(|at| {
                let (axis, center) = (plane.get(at), motion.center.get(at).copied().unwrap_or(0.0));
                axis.map_or(0.0, |axis| point.at(*axis) - center) * scale.get(at).copied().unwrap_or(1.0)
            });
            [x, y]
        };
        let [x, y] = spoke(&motion.from);
        let radius = x.hypot(y);
        let mut rise = *self.changes;
        plane.iter().for_each(|axis| *rise.at_mut(*axis) = 0.0);
        let up = rise.iter().map(|part| part * part).sum::<f64>();
        let flat = (length * length - up).max(0.0).sqrt();
        if radius <= NOISE || flat <= NOISE {
            return self.line(length);
        }
        let direction = |point: &Position| {
            let [x, y] = spoke(point);
            let radius = x.hypot(y).max(NOISE);
            let mut out = [0.0; MAX_AXES];
            for (axis, slot) in out.iter_mut().enumerate() {
                *slot = rise.get(axis).copied().unwrap_or(0.0) / length;
            }
            *out.at_mut(plane[0]) = -turn * y / radius * flat / length;
            *out.at_mut(plane[1]) = turn * x / radius * flat / length;
            out
        };
        let mut limits = DirectionLimits::none();
        for (axis, part) in axes.iter().zip(&rise) {
            limits.axis(axis, part / length);
        }
        for axis in plane {
            limits.axis(&axes[axis], flat / length);
        }
        // The axes must provide the centripetal acceleration of the circle.
        let inward = plane.iter().filter_map(|axis| axes[*axis].dynamics.acceleration).fold(f64::INFINITY, f64::min);
        let round = (inward * radius).sqrt() * length / flat;
        let piece = limits.piece(length, round.min(length / self.seconds));
        Some(FeedMove { piece, start: direction(&motion.from), end: direction(&motion.to) })
    }
}
