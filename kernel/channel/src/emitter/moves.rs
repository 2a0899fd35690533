//! Moves at feed in continuous mode: when they are timed, and when their events are sent.
//!
//! *Invariants:* events that other channels can see happen at rest, except those that follow the speed of a spindle;
//! the clock is set only between blocks or at rest, never while an action measures time with it. Facts and decisions:
//! docs/emulation.md, "Time".

use counterpoint_event::event::{Event, Kind, Motion, MotionLaw};
use counterpoint_sync::backlog::blank;
use counterpoint_sync::tag::Tag;

use super::Emitter;
use crate::at::ExecutionPoint;
use crate::pace::{FeedMove, FeedPlanner};
use crate::times::MoveTimes;

impl Emitter<'_> {
    /// Whether the times of moves depend on later moves.
    pub fn has_pace(&self) -> bool {
        self.pace.is_some()
    }

    /// Whether the time of a move now depends on later moves.
    #[inline(always)]
    pub fn times_moves(&self) -> bool {
        self.pace.is_some() && self.buffer.is_none()
    }

    /// Whether events wait for the times of moves.
    #[inline(always)]
    pub fn has_moves(&self) -> bool {
        self.pace.as_ref().is_some_and(|pace| pace.is_active())
    }

    /// Delay of later events against the clock, ns.
    #[inline(always)]
    pub fn late(&self) -> i64 {
        self.pace.as_ref().map_or(0, |pace| pace.late)
    }

    /// Removes the look-ahead for a move that ends with its block; `put_pace` restores it.
    pub fn take_pace(&mut self) -> Option<Box<FeedPlanner>> {
        self.pace.take()
    }

    /// Restores the look-ahead.
    pub fn put_pace(&mut self, pace: Option<Box<FeedPlanner>>) {
        self.pace = pace;
    }

    /// Stops the path before the next event.
    #[inline(always)]
    pub fn stop_path(&mut self) {
        if let Some(pace) = &mut self.pace {
            pace.stop();
        }
    }

    /// Whether the path stops after its known moves in any case.
    pub fn path_stops(&self) -> bool {
        self.pace.as_ref().is_some_and(|pace| pace.stops || pace.is_settled())
    }

    /// Adds the event of a move at feed whose time depends on later moves. `ns`: its time if speeds changed instantly;
    /// `jumps`: the change of speed that an axis may make at a corner; `exact`: the path stops after the move;
    /// `law`: the law of the move without the ramp, if the job records laws.
    #[inline(always)]
    pub fn emit_move(
        &mut self,
        (at, times): (&ExecutionPoint, &mut MoveTimes<'_>),
        (ns, motion): (i64, &Motion),
        (stretch, exact, law): (&FeedMove, bool, Option<MotionLaw>),
        jumps: impl Iterator<Item = (usize, f64)>,
    ) {
        if self.pace.as_ref().is_some_and(|pace| pace.stops) {
            self.time_moves(times);
        }
        let ExecutionPoint { channel, clock, micro, file, line, caller, .. } = *at;
        let kind = Kind::Motion(*motion);
        let Some(pace) = &mut self.pace else { return };
        pace.add(Event { t_ns: clock, micro, dur_ns: ns, channel, file, line, caller, kind });
        law.into_iter().for_each(|law| pace.keep_law(law));
        pace.push(stretch, jumps);
        if exact {
            pace.stop();
        }
        if pace.is_due() {
            self.time_moves(times);
        }
        self.hold_back();
    }

    /// Times the moves that can be timed, and releases their events.
    #[inline(never)]
    fn time_moves(&mut self, times: &mut MoveTimes<'_>) {
        while let Some(timed) = self.pace.as_mut().filter(|pace| pace.is_due()).and_then(|pace| pace.pop()) {
            self.let_out(timed.count, timed.law);
            times.extend(timed.more);
        }
    }

    /// Time at which the path must brake to stop after its known moves, ns; `None` if it stops in any case.
    pub fn brakes_at(&mut self, times: &mut MoveTimes<'_>) -> Option<i64> {
        while self.pace.as_ref().is_some_and(|pace| pace.has_earlier() && !pace.stops) {
            let timed = self.pace.as_mut()?.pop()?;
            self.let_out(timed.count, timed.law);
            times.extend(timed.more);
        }
        self.pace.as_ref()?.brakes_at()
    }

    /// Releases this many timed events. `law`: the index of a motion among them, and the law that follows the motion.
    fn let_out(&mut self, count: usize, law: Option<(usize, MotionLaw)>) {
        let Some(mut pace) = self.pace.take() else { return };
        self.holds_back(None);
        for (place, event) in pace.events.drain(..count.min(pace.events.len())).enumerate() {
            match law {
                Some((of, law)) if of == place => {
                    let head = Event { kind: Kind::Law(law), ..event };
                    self.let_one_out(event);
                    self.let_one_out(head);
                }
                _ => self.let_one_out(event),
            }
        }
        self.pace = Some(pace);
        self.hold_back();
    }

    #[inline(always)]
    fn let_one_out(&mut self, event: Event) {
        let slot = match self.slot() {
            Some(slot) => Some(slot),
            None => {
                self.flush(Tag { t: event.t_ns, micro: event.micro, channel: event.channel });
                self.slot()
            }
        };
        if let Some(slot) = slot {
            *slot = event;
        }
    }

    /// Takes events only if none are held back.
    pub(super) fn hold_back(&mut self) {
        let held = self.buffer.as_ref().map(|buffer| buffer.events.len());
        let paced = self.pace.as_ref().filter(|pace| pace.is_active()).map(|pace| pace.events.len());
        let count = match (held, paced) {
            (None, None) => None,
            (held, paced) => Some(held.unwrap_or(0) + paced.unwrap_or(0)),
        };
        self.holds_back(count);
    }

    /// Times the moves that can be timed; sets the clock if no move is left. Returns the delay of the clock, ns.
    pub fn keep_pace(&mut self, at: &mut ExecutionPoint, times: &mut MoveTimes<'_>) -> i64 {
        if let Some(pace) = self.pace.as_mut().filter(|pace| pace.is_out_of_moves()) {
            pace.stop();
        }
        self.time_moves(times);
        if self.pace.as_ref().is_some_and(|pace| pace.is_settled()) { self.set_clock(at) } else { 0 }
    }

    /// Stops the path here: times all moves and sets the clock. Returns the delay of the clock, ns.
    pub fn rest(&mut self, at: &mut ExecutionPoint, times: &mut MoveTimes<'_>) -> i64 {
        self.stop_path();
        self.time_moves(times);
        self.set_clock(at)
    }

    /// Sets the clock to the end of the timed moves, and delays the events that compensation holds back.
    fn set_clock(&mut self, at: &mut ExecutionPoint) -> i64 {
        let Some(pace) = &mut self.pace else { return 0 };
        pace.shift();
        let (late, count) = (std::mem::take(&mut pace.late), pace.events.len());
        self.let_out(count, None);
        if late == 0 {
            return 0;
        }
        at.clock = at.clock.saturating_add(late);
        if let Some(buffer) = &mut self.buffer {
            buffer.since.t += late;
            buffer.events.iter_mut().for_each(|event| event.t_ns += late);
        }
        self.hold_back();
        late
    }

    /// Adds an event of this block at this time, ns, during the last move.
    pub fn emit_during(&mut self, at: &ExecutionPoint, (t_ns, micro): (i64, u32), kind: Kind) {
        let ExecutionPoint { channel, file, line, caller, .. } = *at;
        if let Some(pace) = &mut self.pace {
            pace.add_during(Event { t_ns, micro, dur_ns: 0, channel, file, line, caller, kind });
        }
        self.hold_back();
    }

    /// Moves the events since the last move that take no time into that move, at this time, ns. The next shared
    /// operation is later.
    pub fn draw_in(&mut self, t_ns: i64) {
        if let Some(pace) = &mut self.pace {
            pace.draw_in(t_ns);
            pace.acted = t_ns;
        }
    }

    /// A shared operation happens at this time, ns, while the path continues.
    pub fn act_in_motion(&mut self, t_ns: i64) {
        if let Some(pace) = &mut self.pace {
            pace.acted = t_ns;
        }
    }

    /// The place of an event after moves that are not timed.
    pub(super) fn slot_after_moves(&mut self) -> Option<&mut Event> {
        self.held += 1;
        self.room = 0;
        self.pace.as_mut()?.add(blank())
    }
}
