//! Moves at feed whose speeds are not decided yet, and the events from them on.
//!
//! In continuous mode a move may end as fast as the next moves allow, so its time is known only after them. Meanwhile
//! the clock of the channel runs as if speeds changed at once; the additional time of the moves is added when they are
//! timed. Facts: reference channel-synchronisation.md 3.
//!
//! *Invariants:* the clock of the channel plus [`Pace::late`] is never after the time of a future event; events leave
//! in their order; without accelerations nothing of this exists.

use std::collections::VecDeque;

use counterpoint_event::event::{Event, MAX_AXES, Motion, MotionKind, Position};
use counterpoint_event::info::Unit;
use counterpoint_machine::Machine;
use counterpoint_machine::index::AxisSlot;
use counterpoint_machine::model::{Channel as MachineChannel, Dynamics};
use counterpoint_motion::lookahead::{LookAhead, Piece, corner_speed};
use counterpoint_ports::options::{Options, TimeModel};
use counterpoint_sync::tag::Tag;

use super::channel::Channel;
use super::position::Axis;

/// Largest distance from a corner if nothing else limits the speed there, mm.
const DEVIATION: f64 = 0.01;

/// Events without a move after which the path stops: the control has no move to look ahead to, and nothing piles up.
const WITHOUT_MOVE: usize = 2000;

/// Parts of a direction below this count as none.
const NOISE: f64 = 1e-12;

/// Moves at feed that are not timed yet.
#[derive(Debug)]
pub(crate) struct Pace {
    look: LookAhead,
    /// Events from the first move on.
    pub(crate) events: VecDeque<Event>,
    /// For each move the events since that of the move before, its own the last of them; and those during the move.
    gaps: VecDeque<(usize, usize)>,
    /// Events since that of the last move.
    since: usize,
    /// Delay of later events against the clock, ns.
    pub(crate) late: i64,
    /// The path stops after the last move.
    pub(crate) stops: bool,
    /// Time of the last shared operation in motion, ns: the next one is later.
    pub(crate) acted: i64,
    /// How the last move ends.
    end: Option<End>,
    /// Largest distance from a corner, geometry units.
    deviation: Option<f64>,
    /// Least seconds of a move.
    block_time: f64,
}

/// How a move ends.
#[derive(Debug, Clone, Copy)]
struct End {
    direction: Position,
    acceleration: f64,
}

/// A move at feed: how it goes, and its directions at its ends, in geometry units.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stretch {
    pub(crate) piece: Piece,
    pub(crate) start: Position,
    pub(crate) end: Position,
}

impl Pace {
    /// Of a channel; none where speeds change at once.
    pub(crate) fn of(machine: &Machine, channel: &MachineChannel, options: &Options) -> Option<Box<Self>> {
        let time = &machine.time;
        let axes = || channel.axes.iter().map(|axis| &machine.axes[*axis].dynamics);
        let slow = axes().any(|axis| axis.acceleration.is_some()) || time.block_time > 0.0;
        if options.time == TimeModel::Simple || options.lint || !slow {
            return None;
        }
        let default = if machine.unit == Unit::Inch { DEVIATION / 25.4 } else { DEVIATION };
        let limited = axes().any(|axis| axis.corner_speed.is_some());
        let deviation = time.corner_deviation.or((!limited).then_some(default));
        let depth = time.look_ahead as usize;
        Some(Box::new(Self {
            look: LookAhead::new(depth),
            events: VecDeque::new(),
            gaps: VecDeque::with_capacity(depth + 2),
            since: 0,
            late: 0,
            stops: false,
            acted: -1,
            end: None,
            deviation,
            block_time: time.block_time,
        }))
    }

    /// Events wait for moves, or for the clock to be set.
    pub(crate) fn is_active(&self) -> bool {
        !self.look.is_empty() || self.late != 0 || !self.events.is_empty()
    }

    /// Whether all moves are timed.
    pub(crate) fn is_settled(&self) -> bool {
        self.look.is_empty()
    }

    /// Whether the first move can be timed.
    pub(crate) fn is_due(&self) -> bool {
        self.look.is_due() || self.stops && !self.look.is_empty()
    }

    /// Time and order of the first event that waits.
    pub(crate) fn first(&self) -> Option<(i64, u32)> {
        self.events.front().map(|event| (event.t_ns + self.late, event.micro))
    }

    /// Stops the path after its known moves.
    pub(crate) fn stop(&mut self) {
        if !self.look.is_empty() {
            self.stops = true;
        }
    }

    /// Whether the next move is too far away for the path to continue.
    pub(crate) fn is_out_of_moves(&self) -> bool {
        self.since > WITHOUT_MOVE
    }

    /// An event is added.
    pub(crate) fn add(&mut self, event: Event) -> Option<&mut Event> {
        self.events.push_back(event);
        self.since += 1;
        self.events.back_mut()
    }

    /// The event that was added last is a move; all moves before a stop are timed.
    pub(crate) fn push(&mut self, stretch: &Stretch, jumps: impl Iterator<Item = (usize, f64)>) {
        let Stretch { mut piece, start, end } = *stretch;
        if self.block_time > 0.0 {
            piece.speed = piece.speed.min(piece.length / self.block_time);
        }
        piece.corner = match &self.end {
            Some(before) if !self.look.is_empty() => self.corner(before, &start, piece.acceleration, jumps),
            _ => 0.0,
        };
        self.look.push(piece);
        self.gaps.push_back((std::mem::take(&mut self.since), 0));
        self.end = Some(End { direction: end, acceleration: piece.acceleration });
    }

    /// Largest speed at the corner between two moves.
    fn corner(
        &self,
        before: &End,
        start: &Position,
        acceleration: f64,
        jumps: impl Iterator<Item = (usize, f64)>,
    ) -> f64 {
        let mut speed = f64::INFINITY;
        if let Some(deviation) = self.deviation {
            let cosine = before.direction.iter().zip(start).map(|(a, b)| a * b).sum::<f64>();
            let acceleration = acceleration.min(before.acceleration);
            speed = corner_speed(cosine, acceleration, deviation);
        }
        for (axis, jump) in jumps {
            let [a, b] = [&before.direction, start].map(|of| of.get(axis).copied().unwrap_or(0.0));
            if (a - b).abs() > NOISE {
                speed = speed.min(jump / (a - b).abs());
            }
        }
        speed
    }

    /// Times the first move: its events and those before it, with the time beyond its own, ns.
    pub(crate) fn pop(&mut self) -> Option<(usize, i64)> {
        let seconds = self.look.pop()?;
        let (count, during) = self.gaps.pop_front()?;
        if self.look.is_empty() {
            self.stops = false;
        }
        for event in self.events.iter_mut().take(count + during) {
            event.t_ns += self.late;
        }
        let Some(own) = self.events.get_mut(count.saturating_sub(1)) else { return Some((count + during, 0)) };
        let real = super::channel::nanoseconds(seconds).max(own.dur_ns);
        let more = real - own.dur_ns;
        own.dur_ns = real;
        self.late = self.late.saturating_add(more);
        Some((count + during, more))
    }

    /// Places the events since the last move that take no time into the move, at this time, ns.
    pub(crate) fn draw_in(&mut self, t_ns: i64) {
        let since = std::mem::take(&mut self.since);
        for event in self.events.iter_mut().rev().take(since) {
            event.t_ns = t_ns - self.late;
        }
        if let Some((_, during)) = self.gaps.back_mut() {
            *during += since;
        }
    }

    /// Adds an event during the last move, at its time.
    pub(crate) fn add_during(&mut self, event: Event) {
        if let Some((_, during)) = self.gaps.back_mut() {
            *during += 1;
        }
        self.events.push_back(Event { t_ns: event.t_ns - self.late, ..event });
    }

    /// Shifts the remaining events, after all moves, to their time.
    pub(crate) fn shift(&mut self) {
        for event in &mut self.events {
            event.t_ns += self.late;
        }
        self.since = 0;
    }

    /// When the path has to brake to stop at its end, ns; none unless the last move is the only one that is not timed,
    /// the path continues, and no shared operation has come at that time or after it.
    pub(crate) fn brakes_at(&self) -> Option<i64> {
        let (count, _) = self.gaps.front().filter(|_| !self.stops)?;
        let own = self.events.get(count.checked_sub(1)?)?;
        let brakes = own.t_ns + self.late + super::channel::nanoseconds(self.look.brakes_after()?);
        Some(brakes).filter(|brakes| *brakes > self.acted)
    }

    /// More than the last move is not timed.
    pub(crate) fn has_earlier(&self) -> bool {
        self.look.len() > 1
    }
}

impl Channel<'_> {
    /// The time as far as it is known, ns: while moves wait for theirs, it may be later.
    #[inline(always)]
    pub(crate) fn now(&self) -> i64 {
        self.at.clock + self.pace.as_ref().map_or(0, |pace| pace.late)
    }

    /// No shared operation of this channel comes before.
    #[inline(always)]
    pub(crate) fn bound(&self) -> i64 {
        let since = self.held.as_ref().map_or(self.at.clock, |held| held.since.t);
        match &self.pace {
            None => since,
            Some(pace) => pace.first().map_or(since + pace.late, |(t, _)| t),
        }
    }

    /// No event that is sent later is before this tag.
    pub(crate) fn promise(&self) -> Tag {
        let tag = self.held.as_ref().map_or_else(|| self.at.tag(), |held| held.since);
        match self.pace.as_deref() {
            None => tag,
            Some(pace) => match pace.first() {
                Some((t, micro)) => Tag { t, micro, ..tag },
                None => Tag { t: tag.t + pace.late, ..tag },
            },
        }
    }

    /// Stops the path before the next event.
    #[inline(always)]
    pub(crate) fn stop_path(&mut self) {
        if let Some(pace) = &mut self.pace {
            pace.stop();
        }
    }

    /// A move at feed as the look-ahead sees it; none for a move without a path.
    pub(crate) fn stretch(&self, seconds: f64, motion: &Motion) -> Option<Stretch> {
        let axes = &self.state.place.layout.axes;
        let changes = if self.couples() {
            self.changes(&self.machine_point(&motion.from), &self.machine_point(&motion.to))
        } else {
            self.changes(&motion.from, &motion.to)
        };
        let along = Along { channel: self, changes: &changes, seconds };
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
}

/// A move that becomes a piece.
struct Along<'a> {
    channel: &'a Channel<'a>,
    changes: &'a Position,
    seconds: f64,
}

/// The limits along a direction.
struct Limits {
    speed: f64,
    acceleration: f64,
    jerk: f64,
}

impl Limits {
    fn none() -> Self {
        Self { speed: f64::INFINITY, acceleration: f64::INFINITY, jerk: f64::INFINITY }
    }

    /// Adds an axis with its part of the path.
    fn axis(&mut self, axis: &Axis, part: f64) {
        let part = part.abs();
        if part > NOISE {
            let Dynamics { acceleration, jerk, .. } = axis.dynamics;
            self.speed = self.speed.min(axis.rapid / part);
            self.acceleration = self.acceleration.min(acceleration.map_or(f64::INFINITY, |a| a / part));
            self.jerk = self.jerk.min(jerk.map_or(f64::INFINITY, |j| j / part));
        }
    }

    fn piece(&self, length: f64, speed: f64) -> Piece {
        let speed = speed.min(self.speed);
        Piece { length, speed, acceleration: self.acceleration, jerk: self.jerk, corner: f64::INFINITY }
    }
}

impl Along<'_> {
    /// A straight path, or one whose directions are not known, of this length at least.
    fn line(&self, length: f64) -> Option<Stretch> {
        let chord = self.changes.iter().map(|change| change * change).sum::<f64>().sqrt();
        let length = chord.max(length);
        if !(length > NOISE && chord > NOISE && self.seconds > 0.0 && self.seconds.is_finite()) {
            return None;
        }
        let mut direction = *self.changes;
        direction.iter_mut().for_each(|part| *part /= chord);
        let mut limits = Limits::none();
        for (axis, part) in self.channel.state.place.layout.axes.iter().zip(direction) {
            limits.axis(axis, part);
        }
        Some(Stretch { piece: limits.piece(length, length / self.seconds), start: direction, end: direction })
    }

    /// A circle in a plane, perhaps with a rise.
    fn circle(&self, motion: &Motion, plane: [AxisSlot; 2], turn: f64) -> Option<Stretch> {
        use counterpoint_machine::index::BySlot as _;
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
        let mut limits = Limits::none();
        for (axis, part) in axes.iter().zip(&rise) {
            limits.axis(axis, part / length);
        }
        for axis in plane {
            limits.axis(&axes[axis], flat / length);
        }
        // Round the circle the axes must bear its centripetal acceleration.
        let inward = plane.iter().filter_map(|axis| axes[*axis].dynamics.acceleration).fold(f64::INFINITY, f64::min);
        let round = (inward * radius).sqrt() * length / flat;
        let piece = limits.piece(length, round.min(length / self.seconds));
        Some(Stretch { piece, start: direction(&motion.from), end: direction(&motion.to) })
    }
}
