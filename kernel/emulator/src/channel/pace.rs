//! Moves at feed in continuous mode: when they are timed, and when their events leave.
//!
//! *Invariants:* events that other channels can see happen at rest, except those that follow the speed of a spindle;
//! the clock is set only between blocks or at rest, never while an action measures time with it. Facts and decisions:
//! docs/emulation.md, "Time".

use counterpoint_event::event::{Event, Kind, Motion, MotionKind};
use counterpoint_machine::ident::codes;
use counterpoint_sync::tag::Tag;

use super::Kernel;
use crate::state::channel::At;
use crate::state::channel::Channel;
use crate::state::modal::group;
use crate::state::pace::Stretch;
use counterpoint_sync::backlog::blank;

impl Kernel<'_> {
    /// The move as the look-ahead takes it; none if the path stops before and after it.
    #[inline(always)]
    pub(crate) fn paced(&self, seconds: f64, motion: &Motion) -> Option<Stretch> {
        if self.channel.pace.is_some() && self.channel.held.is_none() {
            continuous(&self.channel, seconds, motion)
        } else {
            None
        }
    }

    /// Adds the event of a move at feed whose time later ones decide. `ns`: its time if speeds changed at once.
    pub(crate) fn emit_move(&mut self, ns: i64, motion: &Motion, stretch: &Stretch) {
        if self.channel.pace.as_ref().is_some_and(|pace| pace.stops) {
            self.time_moves();
        }
        let at = &self.channel.at;
        let event = Event {
            t_ns: at.clock,
            micro: at.micro,
            dur_ns: ns,
            channel: at.channel,
            file: at.file,
            line: at.line,
            caller: at.caller,
            kind: Kind::Motion(*motion),
        };
        let exact = self.channel.block.flags.exact_stop
            || self.channel.state.modal.code(group::EXACT_STOP) == Some(codes::EXACTSTOP_ON);
        let axes = &self.channel.state.place.layout.axes;
        let Some(pace) = &mut self.channel.pace else { return };
        pace.add(event);
        pace.push(stretch, axes.iter().enumerate().filter_map(|(at, axis)| Some((at, axis.dynamics.corner_speed?))));
        if exact {
            pace.stop();
        }
        if pace.is_due() {
            self.time_moves();
        }
        self.hold_back();
    }

    /// Times the moves that can be timed, and lets their events out.
    #[inline(never)]
    fn time_moves(&mut self) {
        while let Some((count, more)) =
            self.channel.pace.as_mut().filter(|pace| pace.is_due()).and_then(|pace| pace.pop())
        {
            self.timed(count, more);
        }
    }

    /// When the path has to brake to stop where it is now, ns; none if it stops in any case.
    pub(super) fn brakes_at(&mut self) -> Option<i64> {
        while self.channel.pace.as_ref().is_some_and(|pace| pace.has_earlier() && !pace.stops) {
            let (count, more) = self.channel.pace.as_mut()?.pop()?;
            self.timed(count, more);
        }
        self.channel.pace.as_ref()?.brakes_at()
    }

    /// A move has been timed.
    fn timed(&mut self, count: usize, more: i64) {
        self.let_out(count);
        if more > 0 && self.plan.hooks.is_some() {
            self.book_more(more);
        }
    }

    /// Lets this many events out, which have their times.
    fn let_out(&mut self, count: usize) {
        let Some(pace) = &mut self.channel.pace else { return };
        let emitter = &mut self.ports.emitter;
        emitter.holds_back(None);
        for event in pace.events.drain(..count.min(pace.events.len())) {
            let tag = Tag { t: event.t_ns, micro: event.micro, channel: event.channel };
            let slot = match emitter.slot() {
                Some(slot) => Some(slot),
                None => {
                    emitter.flush(tag);
                    emitter.slot()
                }
            };
            if let Some(slot) = slot {
                *slot = event;
            }
        }
        self.hold_back();
    }

    /// Tells the emitter whether events are held back, and how many.
    pub(crate) fn hold_back(&mut self) {
        let held = self.channel.held.as_ref().map(|held| held.events.len());
        let paced = self.channel.pace.as_ref().filter(|pace| pace.is_active()).map(|pace| pace.events.len());
        let count = match (held, paced) {
            (None, None) => None,
            (held, paced) => Some(held.unwrap_or(0) + paced.unwrap_or(0)),
        };
        self.ports.emitter.holds_back(count);
    }

    /// Times the moves that can be timed, before a block; if these are all moves, sets the clock.
    #[inline(always)]
    pub(crate) fn keep_pace(&mut self) {
        if self.channel.pace.as_ref().is_some_and(|pace| pace.is_active()) {
            self.set_pace();
        }
    }

    #[inline(never)]
    fn set_pace(&mut self) {
        if let Some(pace) = self.channel.pace.as_mut().filter(|pace| pace.is_out_of_moves()) {
            pace.stop();
        }
        self.time_moves();
        if self.channel.pace.as_ref().is_some_and(|pace| pace.is_settled()) {
            self.set_clock();
        }
    }

    /// Lets the path stop here: all moves are timed, and the clock is right.
    #[inline(always)]
    pub(crate) fn come_to_rest(&mut self) {
        if self.channel.pace.as_ref().is_some_and(|pace| pace.is_active()) {
            self.rest_now();
        }
    }

    /// Releases events that wait for moves, if the path stops here in any case.
    pub(crate) fn let_out_stopped(&mut self) {
        if self.channel.pace.as_ref().is_some_and(|pace| pace.stops || pace.is_settled()) {
            self.come_to_rest();
        }
    }

    #[cold]
    #[inline(never)]
    fn rest_now(&mut self) {
        self.channel.stop_path();
        self.time_moves();
        self.set_clock();
    }

    /// Sets the clock to the end of the timed moves, and with it the moves that compensation holds back.
    fn set_clock(&mut self) {
        let Some(pace) = &mut self.channel.pace else { return };
        pace.shift();
        let (late, count) = (std::mem::take(&mut pace.late), pace.events.len());
        self.let_out(count);
        if late == 0 {
            return;
        }
        self.channel.at.clock = self.channel.at.clock.saturating_add(late);
        if let Some(held) = &mut self.channel.held {
            held.since.t += late;
            held.events.iter_mut().for_each(|event| event.t_ns += late);
        }
        if let Some(cutter) = self.channel.cutter() {
            cutter.waiting.iter_mut().for_each(|waiting| waiting.clock += late);
        }
        self.hold_back();
    }

    /// Adds an event of this block during the last move, ns.
    pub(super) fn emit_during(&mut self, t_ns: i64, micro: u32, kind: Kind) {
        let At { channel, file, line, caller, .. } = self.channel.at;
        if let Some(pace) = &mut self.channel.pace {
            pace.add_during(Event { t_ns, micro, dur_ns: 0, channel, file, line, caller, kind });
        }
        self.hold_back();
    }

    /// The place of an event after moves that are not timed.
    pub(super) fn paced_slot(&mut self) -> Option<&mut Event> {
        let count = self.ports.emitter.held_count() + 1;
        self.ports.emitter.holds_back(Some(count));
        self.channel.pace.as_mut()?.add(blank())
    }
}

#[inline(never)]
fn continuous(channel: &Channel<'_>, seconds: f64, motion: &Motion) -> Option<Stretch> {
    match motion.kind {
        MotionKind::Rapid | MotionKind::Thread => None,
        // The spindle leads.
        _ if channel.state.threads.rounds => None,
        _ => channel.stretch(seconds, motion),
    }
}
