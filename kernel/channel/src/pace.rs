//! Moves at feed whose speeds are not decided yet, and the events from them on.
//!
//! In continuous mode a move may end as fast as the next moves allow, so its time is known only after them. Meanwhile
//! the clock of the channel runs as if speeds changed at once; the additional time of the moves is added when they are
//! timed. Facts: reference channel-synchronisation.md 3.
//!
//! *Invariants:* the clock of the channel plus [`FeedPlanner::late`] is never after the time of a future event; events leave
//! in their order; without accelerations nothing of this exists.

use std::collections::VecDeque;

use counterpoint_event::event::{Event, MotionLaw, Position, UnknownLaw};
use counterpoint_event::info::MachineUnit;
use counterpoint_machine::Machine;
use counterpoint_machine::model::Channel as MachineChannel;
use counterpoint_motion::law::{PathLaw, SpeedRamp};
use counterpoint_motion::lookahead::{LookAhead, LookAheadMove, corner_speed};
use counterpoint_ports::options::{JobOptions, TimeModel};

/// Largest distance from a corner if nothing else limits the speed there, mm.
const DEVIATION: f64 = 0.01;

/// Events without a move after which the path stops: the control has no move to look ahead to, and nothing piles up.
const WITHOUT_MOVE: usize = 2000;

/// Parts of a direction below this count as none.
pub(super) const NOISE: f64 = 1e-12;

/// Moves at feed that are not timed yet.
#[derive(Debug)]
pub struct FeedPlanner {
    look: LookAhead,
    /// Events from the first move on.
    pub events: VecDeque<Event>,
    /// For each move the events since that of the move before, its own the last of them; and those during the move.
    gaps: VecDeque<(usize, usize)>,
    /// Events since that of the last move.
    since: usize,
    /// Delay of later events against the clock, ns.
    pub late: i64,
    /// The path stops after the last move.
    pub stops: bool,
    /// Time of the last shared operation in motion, ns: the next one is later.
    pub acted: i64,
    /// How the last move ends.
    end: Option<MoveEnd>,
    /// Largest distance from a corner, geometry units.
    deviation: Option<f64>,
    /// Least seconds of a move.
    block_time: f64,
    /// The laws of the moves, without their ramps, if the job records laws.
    laws: Option<VecDeque<MotionLaw>>,
}

/// The events of a move that has just been timed.
#[derive(Debug, Clone, Copy)]
pub struct TimedMove {
    /// Events up to the next move.
    pub count: usize,
    /// Time in addition to the time of the move at its feed, ns.
    pub more: i64,
    /// The index of the move in the events, and its law, if the job records laws.
    pub law: Option<(usize, MotionLaw)>,
}

/// How a move ends.
#[derive(Debug, Clone, Copy)]
struct MoveEnd {
    direction: Position,
    acceleration: f64,
}

/// A move at feed: how it goes, and its directions at its ends, in geometry units.
#[derive(Debug, Clone, Copy)]
pub struct FeedMove {
    /// Its length, rates and limits, for look-ahead.
    pub piece: LookAheadMove,
    /// Direction where it begins.
    pub start: Position,
    /// Direction where it ends.
    pub end: Position,
}

/// The law of a move that the look-ahead has timed; if the machine has a jerk, the speed has no ramp.
fn with_ramp(law: MotionLaw, ramp: Option<SpeedRamp>) -> MotionLaw {
    match (law, ramp) {
        (MotionLaw::Path(path), Some(_)) => MotionLaw::Path(PathLaw { ramp, ..path }),
        (MotionLaw::Path(_), None) => MotionLaw::Unknown(UnknownLaw::Jerk),
        (law, _) => law,
    }
}

impl FeedPlanner {
    /// Of a channel; none where speeds change at once.
    pub fn of(machine: &Machine, channel: &MachineChannel, options: &JobOptions) -> Option<Box<Self>> {
        let time = &machine.time;
        let axes = || channel.axes.iter().map(|axis| &machine.axes[*axis].dynamics);
        let slow = axes().any(|axis| axis.acceleration.is_some()) || time.block_time > 0.0;
        if options.timing.model == TimeModel::Simple || options.lint || !slow {
            return None;
        }
        let default = if machine.unit == MachineUnit::Inch { DEVIATION / 25.4 } else { DEVIATION };
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
            laws: options.timing.law.then(VecDeque::new),
        }))
    }

    /// Events wait for moves, or for the clock to be set.
    pub fn is_active(&self) -> bool {
        !self.look.is_empty() || self.late != 0 || !self.events.is_empty()
    }

    /// Whether all moves are timed.
    pub fn is_settled(&self) -> bool {
        self.look.is_empty()
    }

    /// Whether the first move can be timed.
    pub fn is_due(&self) -> bool {
        self.look.is_due() || self.stops && !self.look.is_empty()
    }

    /// Time and order of the first event that waits.
    pub fn first(&self) -> Option<(i64, u32)> {
        self.events.front().map(|event| (event.t_ns + self.late, event.micro))
    }

    /// Stops the path after its known moves.
    pub fn stop(&mut self) {
        if !self.look.is_empty() {
            self.stops = true;
        }
    }

    /// Whether the next move is too far away for the path to continue.
    pub fn is_out_of_moves(&self) -> bool {
        self.since > WITHOUT_MOVE
    }

    /// An event is added.
    pub fn add(&mut self, event: Event) -> Option<&mut Event> {
        self.events.push_back(event);
        self.since += 1;
        self.events.back_mut()
    }

    /// Keeps the law of the next move, if the job records laws.
    pub fn keep_law(&mut self, law: MotionLaw) {
        if let Some(laws) = &mut self.laws {
            laws.push_back(law);
        }
    }

    /// The event that was added last is a move; all moves before a stop are timed.
    pub fn push(&mut self, stretch: &FeedMove, jumps: impl Iterator<Item = (usize, f64)>) {
        let FeedMove { mut piece, start, end } = *stretch;
        if self.block_time > 0.0 {
            piece.speed = piece.speed.min(piece.length / self.block_time);
        }
        piece.corner = match &self.end {
            Some(before) if !self.look.is_empty() => self.corner(before, &start, piece.acceleration, jumps),
            _ => 0.0,
        };
        self.look.push(piece);
        self.gaps.push_back((std::mem::take(&mut self.since), 0));
        self.end = Some(MoveEnd { direction: end, acceleration: piece.acceleration });
    }

    /// Largest speed at the corner between two moves.
    fn corner(
        &self,
        before: &MoveEnd,
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

    /// Times the first move.
    pub fn pop(&mut self) -> Option<TimedMove> {
        let (seconds, law) = match &mut self.laws {
            None => (self.look.pop()?, None),
            Some(laws) => {
                let (seconds, ramp) = self.look.pop_with_ramp()?;
                (seconds, laws.pop_front().map(|law| with_ramp(law, ramp)))
            }
        };
        let (count, during) = self.gaps.pop_front()?;
        let timed = |more| TimedMove { count: count + during, more, law: Some(count.saturating_sub(1)).zip(law) };
        if self.look.is_empty() {
            self.stops = false;
        }
        for event in self.events.iter_mut().take(count + during) {
            event.t_ns += self.late;
        }
        let Some(own) = self.events.get_mut(count.saturating_sub(1)) else { return Some(timed(0)) };
        let real = super::at::nanoseconds(seconds).max(own.dur_ns);
        let more = real - own.dur_ns;
        own.dur_ns = real;
        self.late = self.late.saturating_add(more);
        Some(timed(more))
    }

    /// Places the events since the last move that take no time into the move, at this time, ns.
    pub fn draw_in(&mut self, t_ns: i64) {
        let since = std::mem::take(&mut self.since);
        for event in self.events.iter_mut().rev().take(since) {
            event.t_ns = t_ns - self.late;
        }
        if let Some((_, during)) = self.gaps.back_mut() {
            *during += since;
        }
    }

    /// Adds an event during the last move, at its time.
    pub fn add_during(&mut self, event: Event) {
        if let Some((_, during)) = self.gaps.back_mut() {
            *during += 1;
        }
        self.events.push_back(Event { t_ns: event.t_ns - self.late, ..event });
    }

    /// Shifts the remaining events, after all moves, to their time.
    pub fn shift(&mut self) {
        for event in &mut self.events {
            event.t_ns += self.late;
        }
        self.since = 0;
    }

    /// When the path has to brake to stop at its end, ns; none unless the last move is the only one that is not timed,
    /// the path continues, and no shared operation has come at that time or after it.
    pub fn brakes_at(&self) -> Option<i64> {
        let (count, _) = self.gaps.front().filter(|_| !self.stops)?;
        let own = self.events.get(count.checked_sub(1)?)?;
        let brakes = own.t_ns + self.late + super::at::nanoseconds(self.look.brakes_after()?);
        Some(brakes).filter(|brakes| *brakes > self.acted)
    }

    /// More than the last move is not timed.
    pub fn has_earlier(&self) -> bool {
        self.look.len() > 1
    }
}
