//! The spindle of a channel: its commands, its rotation, and its state for other channels.
//!
//! Facts: reference channel-synchronisation.md 1.9 (a spindle that several channels command: the last writer in tag
//! order wins, with a warning when no sync point lies between). *Invariant:* a shared spindle is reached only through
//! shared operations; an own one is plain state of the channel.

use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::code_time::runs_beside;
use counterpoint_channel::shared_target::SharedTarget;
use counterpoint_event::event::SpindleChange as SpindleEvent;
use counterpoint_event::event::{Kind, SpindleDirection};
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_machine::index::SpindleId;
use counterpoint_motion::law::SpindleRotation;
use counterpoint_sync::races::AccessMode;
use counterpoint_sync::shared::SpindleCommand;

use super::report::report_spindle_conflict;
use super::{Kernel, chucks, paired_spindles};

/// Whether the spindle reverses its direction.
fn reverses(before: SpindleDirection, after: SpindleDirection) -> bool {
    use SpindleDirection::{Clockwise, CounterClockwise};
    matches!((before, after), (Clockwise, CounterClockwise) | (CounterClockwise, Clockwise))
}

impl Kernel<'_> {
    /// Changes the commanded state, logs it, and lets the spindle run up.
    pub fn command_spindle(&mut self, change: impl Fn(&mut SpindleCommand)) -> Acted {
        let Some(id) = self.channel.state.spindle.id else {
            let text =
                format!("channel {} has no spindle for '{}'", self.channel.at.channel, self.channel.block_text());
            self.diagnose(&diag::NO_SPINDLE, text);
            return Ok(());
        };
        self.flow.pass.effects = true;
        if self.channel.state.spindle.is_seen(self.channel.env.machine) {
            self.flush_lookahead()?;
            self.channel.come_to_rest();
        }
        let before = self.turning_speed()?;
        let old = self.channel.state.spindle.command;
        let channel = self.channel.at.channel;
        let mut conflict = 0;
        if self.channel.state.spindle.shared {
            let (now, was) = (self.channel.now(), (before, self.channel.state.spindle.range(self.channel.env.machine)));
            let done = self.access(SharedTarget::Spindle, AccessMode::Write, |shared| {
                let spindle = shared.spindles.get_mut(id.index())?;
                if let Some(coupling) = spindle.coupling {
                    return Some(Err(coupling.leader));
                }
                let changed = spindle.change(&change, was, (now, channel));
                let writer = spindle.written(channel);
                Some(Ok((spindle.command, if changed { writer } else { 0 })))
            })?;
            let (command, writer) = match done.unwrap_or(Ok((SpindleCommand::default(), 0))) {
                Ok(done) => done,
                Err(leader) => return paired_spindles::not_commanded(self, id, leader, change),
            };
            self.channel.state.spindle.command = command;
            conflict = writer;
        } else {
            change(&mut self.channel.state.spindle.command);
        }
        if conflict != 0 {
            report_spindle_conflict(self, conflict);
        }
        if self.channel.state.spindle.command != old {
            self.channel.reports.plausible.look_above = 0.0;
            self.announce(id, before, old.direction)?;
            chucks::after_command(self)?;
        } else if self.channel.state.spindle.is_seen(self.channel.env.machine) {
            paired_spindles::wait_for_speed(self, id)?;
        }
        self.follow_radius()
    }

    /// Changes the commanded state as a macro wants it: without an event and without time.
    pub fn set_spindle(&mut self, change: impl Fn(&mut SpindleCommand)) -> Acted {
        let Some(id) = self.channel.state.spindle.id else { return Ok(()) };
        if !self.channel.state.spindle.shared {
            change(&mut self.channel.state.spindle.command);
            return Ok(());
        }
        let was = (self.turning_speed()?, self.channel.state.spindle.range(self.channel.env.machine));
        let at = (self.channel.now(), self.channel.at.channel);
        let command = self.access(SharedTarget::Spindle, AccessMode::Write, |shared| {
            if let Some(spindle) = shared.spindles.get_mut(id.index()).filter(|spindle| spindle.coupling.is_none()) {
                spindle.change(change, was, at);
            }
            shared.spindle(id.index()).map(|spindle| spindle.command)
        })?;
        self.channel.state.spindle.command = command.unwrap_or_default();
        self.follow_radius()
    }

    /// Logs the state and takes the run-up time.
    fn announce(&mut self, id: SpindleId, before: f64, turned: SpindleDirection) -> Acted {
        let spindle = &self.channel.env.machine.spindles[id];
        let (number, overlap) = (spindle.number, spindle.overlap);
        let [_, max] = self.channel.state.spindle.range(self.channel.env.machine);
        let now = self.channel.state.spindle.command;
        let speed = if now.css { now.surface } else { now.rpm };
        let over_speed = (!now.css && now.rpm > max).then_some((id, now.rpm));
        if std::mem::replace(&mut self.channel.reports.plausible.over_speed, over_speed) != over_speed
            && over_speed.is_some()
        {
            let text = format!(
                "{} rev/min is above the maximum speed {max} of spindle {number} in '{}'",
                now.rpm,
                self.channel.block_text()
            );
            self.diagnose(&diag::SPINDLE_LIMIT, text);
        }
        let after = self.turning_speed()?;
        let followers = paired_spindles::followers(self, id)?;
        // A spindle that reverses stops first.
        let change = if reverses(turned, now.direction) { after + before } else { after - before };
        let ramps = followers.iter().map(|(id, of)| self.channel.env.machine.spindles[*id].ramp(change * of.ratio));
        let mut seconds = ramps.fold(spindle.ramp(change), f64::max);
        if change != 0.0 {
            seconds += self.channel.env.machine.time.spindle_speed;
        }
        let ns = counterpoint_channel::at::nanoseconds(seconds);
        paired_spindles::note_run_up(self, id, ns)?;
        let (direction, css, limit, angle) = (now.direction, now.css, now.limit, now.angle);
        let event = SpindleEvent { spindle: number, direction, css, speed, limit, angle };
        if ns > 0 && runs_beside(&mut self.channel, overlap, ('S', after.round()), ns) {
            self.channel.emit(0, Kind::Spindle(event));
        } else {
            self.channel.emit(ns, Kind::Spindle(event));
            self.channel.advance(ns);
        }
        paired_spindles::log_followers(self, &followers);
        Ok(())
    }

    /// Commanded state of the channel's spindle as of now.
    pub fn current(&mut self) -> Result<SpindleCommand, Halt> {
        if self.channel.state.spindle.shared
            && let Some(id) = self.channel.state.spindle.id
        {
            let ended = self.channel.state.spindle.ended_assumption(self.channel.now());
            let channel = self.channel.at.channel;
            let known = self.access(SharedTarget::Spindle, AccessMode::Read, |shared| {
                let spindle = shared.spindle(id.index())?;
                let change = ended.and_then(|(known, [begin, end])| {
                    spindle.changes.of_others(channel, known, end).filter(|(t, _)| *t >= begin)
                });
                let changes = (spindle.changes.count, spindle.changes.newest());
                Some((spindle.command, (spindle.now, spindle.ceiling), spindle.course, changes, change))
            })?;
            let (command, (now, ceiling), course, (changes, changed), change) = known.unwrap_or_default();
            let state = &mut self.channel.state.spindle;
            (state.command, state.now, state.course, state.ceiling) = (command, now, course, ceiling);
            (state.changes, state.changed) = (changes, changed);
            if ended.is_some() {
                self.end_assumption(change);
            }
        }
        Ok(self.channel.state.spindle.command)
    }

    /// How the spindle turns now, `None` when it is stopped.
    pub fn spindle_speed(&mut self) -> Result<Option<SpindleRotation>, Halt> {
        let command = self.current()?;
        // A synchronised tap turns the spindle itself.
        let turns = matches!(command.direction, SpindleDirection::Clockwise | SpindleDirection::CounterClockwise);
        if !turns && !self.channel.state.cycle.is_rigid() {
            return Ok(None);
        }
        let ChannelContext { env, state, .. } = &self.channel;
        let speed = state.spindle.surface_speed(env.machine, state.secondary, &command);
        if !command.css {
            let rpm = if command.rpm > 0.0 { command.rpm.max(command.least).min(speed.max) } else { command.rpm };
            return Ok((rpm > 0.0).then_some(SpindleRotation::Fixed(rpm)));
        }
        if command.surface <= 0.0 {
            return Ok(None);
        }
        if command.driver != self.channel.at.channel && command.radius <= 0.0 {
            return Ok(state.spindle.driven(self.channel.now()));
        }
        if command.radius > 0.0 {
            let rpm = speed.rpm(command.radius);
            return Ok((rpm > 0.0).then_some(SpindleRotation::Fixed(rpm)));
        }
        Ok(Some(SpindleRotation::Surface(speed)))
    }

    /// Speed that turns now, 0 when the spindle is stopped.
    pub(super) fn turning_speed(&mut self) -> Result<f64, Halt> {
        let radius = self.channel.state.place.radius(&self.channel.state.place.position);
        let rpm = self.spindle_speed()?.map_or(0.0, |turning| turning.rpm(radius));
        Ok(if rpm.is_finite() { rpm } else { 0.0 })
    }
}
