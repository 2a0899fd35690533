//! A spindle under constant surface speed that several channels use: its driver publishes the speed of each move.
//!
//! At the start of a move the driver publishes the change of the speed during the move. The time of a move of another
//! channel then follows this speed; a move that starts at the same instant counts. *Invariant:* if another channel changes the speed before the end of a time that was
//! computed with it, the channel reports that once.

use counterpoint_event::event::{FeedUnit, Motion, MotionKind};
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_motion::driven_speed::{DrivenSpeed, RadiusProgress};
use counterpoint_sync::races::AccessMode;
use counterpoint_sync::shared::{DrivingMove, SpindleCommand};
use counterpoint_sync::tag::Tag;

use super::Kernel;
use counterpoint_channel::at::nanoseconds;
use counterpoint_channel::shared_target::SharedTarget;
use counterpoint_motion::law::SpindleRotation;

/// Changes of the speed by less than this share do not count.
const STEADY: f64 = 0.01;

/// Radii that differ by less than this are equal.
const SAME_RADIUS: f64 = 1e-9;

impl Kernel<'_> {
    /// Publishes how a move that starts now drives the spindle; returns `false` if it does not.
    #[inline(always)]
    pub(super) fn drive_spindle(&mut self, seconds: f64, motion: &Motion) -> Result<bool, diag::Halt> {
        if self.channel.state.spindle.shared { self.share_course(seconds, motion) } else { Ok(false) }
    }

    #[inline(never)]
    fn share_course(&mut self, seconds: f64, motion: &Motion) -> Result<bool, diag::Halt> {
        let (command, channel) = (self.channel.state.spindle.command, self.channel.at.channel);
        let radii = [&motion.from, &motion.to].map(|place| self.channel.state.place.radius(place));
        let drives = command.css && command.driver == channel && command.radius <= 0.0 && command.surface > 0.0;
        let Some(id) = self.channel.state.spindle.id.filter(|_| drives && seconds > 0.0) else { return Ok(false) };
        if (radii[0] - radii[1]).abs() < SAME_RADIUS {
            return Ok(false);
        }
        let speed =
            self.channel.state.spindle.surface_speed(self.channel.env.machine, self.channel.state.secondary, &command);
        let by_revolution = motion.feed_unit == FeedUnit::PerRevolution;
        let progress = if by_revolution { RadiusProgress::ByRevolution } else { RadiusProgress::ByTime };
        let (begin, minutes) = (self.channel.now(), seconds / 60.0);
        let time = [begin, begin.saturating_add(nanoseconds(seconds))];
        let course = DrivingMove { time, driven: DrivenSpeed { speed, radii, minutes, progress } };
        let [first, last] = radii.map(|radius| speed.rpm(radius));
        let shared = self.access(SharedTarget::Spindle, AccessMode::Write, |shared| {
            // Another channel may have commanded the spindle meanwhile.
            let spindle = shared.spindles.get_mut(id.index()).filter(|spindle| spindle.command == command)?;
            (spindle.course, spindle.now) = (Some(course), last);
            if (last / first - 1.0).abs() > STEADY {
                spindle.changes.note(begin, channel);
            }
            Some(())
        })?;
        if shared.is_some() {
            self.channel.state.spindle.now = last;
        }
        Ok(shared.is_some())
    }

    /// Publishes the speed that this channel's X drives.
    #[inline(always)]
    pub(crate) fn follow_radius(&mut self) -> Acted {
        if self.channel.state.spindle.shared { self.share_speed() } else { Ok(()) }
    }

    #[inline(never)]
    fn share_speed(&mut self) -> Acted {
        let command = self.channel.state.spindle.command;
        let Some(id) = self.channel.state.spindle.id else { return Ok(()) };
        if !command.css || command.driver != self.channel.at.channel {
            return Ok(());
        }
        let rpm = self.turning_speed()?;
        let known = self.channel.state.spindle.now;
        if rpm != known {
            self.channel.state.spindle.now = rpm;
            let (now, channel) = (self.channel.now(), self.channel.at.channel);
            self.access(SharedTarget::Spindle, AccessMode::Write, |shared| {
                if let Some(spindle) = shared.spindles.get_mut(id.index()) {
                    (spindle.course, spindle.now) = (None, rpm);
                    if (rpm - known).abs() > STEADY * known {
                        spindle.changes.note(now, channel);
                    }
                }
            })?;
        }
        Ok(())
    }

    /// How the spindle turns during a time by revolutions that starts now, `None` when it is stopped. Unless this
    /// channel drives the spindle, it looks after all commands and moves that other channels begin at this instant, so
    /// the time does not depend on the numbers of the channels.
    pub fn speed_from_now(&mut self) -> Result<Option<SpindleRotation>, diag::Halt> {
        let drives = |kernel: &Self| {
            let SpindleCommand { css, driver, .. } = kernel.channel.state.spindle.command;
            css && driver == kernel.channel.at.channel
        };
        if !self.channel.state.spindle.shared {
            return self.spindle_speed();
        }
        if drives(self) {
            let speed = self.spindle_speed()?;
            if drives(self) {
                return Ok(speed);
            }
        }
        // Programs that are only checked take no time, so no instant of theirs ends.
        if !self.channel.env.options.lint {
            if self.channel.emitter.held_since().is_some_and(|since| since.t < self.channel.at.clock) {
                self.flush_lookahead()?;
            }
            self.channel.at.micro = self.channel.at.micro.max(Tag::LATE);
        }
        self.spindle_speed()
    }

    /// The same for a cut. In balance cutting it first waits for the cut of the other channel.
    pub fn speed_of_cut(&mut self) -> Result<Option<SpindleRotation>, diag::Halt> {
        if self.channel.state.others.balance.is_some() {
            self.pair_cut(MotionKind::Linear)?;
        }
        self.speed_from_now()
    }

    /// Before the channel waits or ends: checks the speed during its last move, unless that has been checked already.
    #[inline(always)]
    pub fn compare_last_speed(&mut self) -> Acted {
        if self.channel.state.spindle.assumed.is_some() { self.current().map(drop) } else { Ok(()) }
    }

    /// Closes the last time that was computed with a speed; `change` is the time at which another channel changed the
    /// speed before its end, and that channel.
    pub(super) fn end_assumption(&mut self, change: Option<(i64, u16)>) {
        let assumed = self.channel.state.spindle.assumed.take();
        let (Some(assumed), Some((at, channel))) = (assumed, change) else { return };
        self.channel.reports.plausible.changed_speed = true;
        let text = format!(
            "line {} turns by a spindle whose speed channel {channel} changes at {:.3} s; the line is timed until {:.3} s \
             without that change, so times after it are not those of the machine",
            assumed.line,
            at as f64 / 1e9,
            assumed.time[1].min(self.channel.now()) as f64 / 1e9,
        );
        self.diagnose(&diag::SPEED_CHANGED, text);
    }
}
