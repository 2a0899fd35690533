//! Spindles: direction, speed, constant surface speed, speed limit.
//!
//! Facts: reference control-emulator.md 3.3, 6.3; channel-synchronisation.md 1.9 (a spindle that several channels
//! command: the last writer in tag order wins, with a warning when no meeting lies between). A shared spindle is
//! reached only through shared operations; an own one is plain state of the kernel.

use counterpoint_fault::{Acted, Halt};
use counterpoint_motion::surface_speed::Speed;

use super::spindles::{commanded, no_head};
use crate::channel::Kernel;
use crate::diag;
use crate::log::event::{Direction, Kind, Spindle as SpindleEvent};
use crate::log::info::Unit;
use crate::machine::ident::data;
use crate::multi::shared::Command;
use crate::multi::waits::Set;

/// How the spindle turns during a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Turning {
    /// Steady rev/min.
    Fixed(f64),
    /// By this channel's own X.
    Surface(Speed),
}

/// Start, stop, orient, lock. `number` 0 = the spindle of codes without a number.
pub(super) fn turn(kernel: &mut Kernel<'_>, number: u16, direction: Direction, coolant: Option<bool>) -> Acted {
    if let Some(on) = coolant {
        super::coolant::with_spindle(kernel, on);
    }
    commanded(kernel, number, |kernel| {
        let angle = match direction {
            Direction::Oriented => kernel.take(data::SPINDLE_ORIENT).map_or(0.0, |d| d.value),
            _ => 0.0,
        };
        let css = kernel.current()?.css;
        let speed = take_speed(kernel, css);
        command(kernel, |c| {
            c.direction = direction;
            c.angle = angle;
            set_speed(c, css, speed);
        })
    })
}

/// Takes off the block what a code without a spindle would have used.
pub(super) fn drop_data(kernel: &mut Kernel<'_>) {
    for id in [data::SPINDLE_ORIENT, data::SPINDLE_RPM, data::SPINDLE_CSS] {
        kernel.take(id);
    }
}

/// Constant surface speed on.
pub(super) fn css(kernel: &mut Kernel<'_>) -> Acted {
    let speed = take_speed(kernel, true);
    let driver = kernel.channel.state.others.spindles.driver.unwrap_or(kernel.channel.at.channel);
    command(kernel, |c| {
        c.css = true;
        c.driver = driver;
        set_speed(c, true, speed);
    })
}

/// Revolutions per minute on.
pub(super) fn rpm(kernel: &mut Kernel<'_>) -> Acted {
    let speed = take_speed(kernel, false);
    let held = held_speed(kernel)?;
    command(kernel, |c| {
        if c.css && speed.is_none() {
            // Leaving surface speed without a new S keeps the speed that is turning.
            c.rpm = held;
        }
        c.css = false;
        c.radius = 0.0;
        set_speed(c, false, speed);
    })
}

/// Speed limit.
pub(super) fn limit(kernel: &mut Kernel<'_>) -> Acted {
    let Some(value) = kernel.take(data::SPINDLE_RPM_MAX).map(|d| d.value) else {
        let text = format!("a speed limit needs its value in '{}'", kernel.block_text());
        kernel.diagnose(&diag::DATA_MISSING, text);
        return Ok(());
    };
    command(kernel, |c| c.limit = value)
}

/// The channel whose X drives constant surface speed.
pub(super) fn driver(kernel: &mut Kernel<'_>, channel: u16) -> Acted {
    if !kernel.channel.env.machine.channels.iter().any(|known| known.number == channel) {
        return no_head(kernel, f64::from(channel));
    }
    kernel.channel.state.others.spindles.driver = Some(channel);
    command(kernel, |c| c.driver = channel)
}

/// The radius at which the surface speed counts, whatever X is; zero or less = at X again.
pub(super) fn radial(kernel: &mut Kernel<'_>) -> Acted {
    let Some(radius) = kernel.take(data::SPINDLE_CSS_RADIAL).map(|d| d.value) else {
        let text = format!("a radius of constant surface speed needs its value in '{}'", kernel.block_text());
        kernel.diagnose(&diag::DATA_MISSING, text);
        return Ok(());
    };
    command(kernel, |c| c.radius = radius.max(0.0))
}

/// Stops, orients or reverses the spindle inside of a cycle; it stays as it is when it stands.
pub(super) fn turn_inside(kernel: &mut Kernel<'_>, direction: Direction) -> Acted {
    if kernel.channel.state.spindle.index.is_none() {
        return Ok(());
    }
    command(kernel, |c| c.direction = direction)
}

/// An S word that no code took: changes the speed (reference control-emulator.md 3.3).
pub(crate) fn speed_word(kernel: &mut Kernel<'_>) -> Acted {
    kernel.settle()?;
    let css = kernel.current()?.css;
    match take_speed(kernel, css) {
        Some(speed) if !kernel.channel.env.machine.habits.speed_word => {
            kernel.channel.state.others.spindles.waiting = Some(speed);
            Ok(())
        }
        Some(speed) => command(kernel, |c| set_speed(c, css, Some(speed))),
        None => Ok(()),
    }
}

/// The speed of the block, else one that was left for the next spindle code (reference control-emulator.md 1.5).
fn take_speed(kernel: &mut Kernel<'_>, css: bool) -> Option<f64> {
    let word = kernel.take(if css { data::SPINDLE_CSS } else { data::SPINDLE_RPM }).map(|d| d.value);
    let waiting = kernel.channel.state.others.spindles.waiting.take();
    word.or(waiting)
}

/// `css`: m/min or ft/min becomes length units per minute.
fn set_speed(command: &mut Command, css: bool, speed: Option<f64>) {
    match speed {
        Some(value) if css => command.surface = value,
        Some(value) => command.rpm = value,
        None => {}
    }
}

/// Speed that turns now, rev/min.
fn held_speed(kernel: &mut Kernel<'_>) -> Result<f64, Halt> {
    let position = kernel.channel.state.place.position;
    let radius = kernel.channel.radius(&position);
    Ok(match kernel.spindle_speed()? {
        Some(Turning::Fixed(rpm)) => rpm,
        Some(Turning::Surface(surface)) => surface.rpm(radius),
        None => kernel.channel.state.spindle.command.rpm,
    })
}

/// Changes the commanded state, logs it, and lets the spindle run up.
fn command(kernel: &mut Kernel<'_>, change: impl Fn(&mut Command)) -> Acted {
    let Some(index) = kernel.channel.state.spindle.index else {
        let text = format!("channel {} has no spindle for '{}'", kernel.channel.at.channel, kernel.block_text());
        kernel.diagnose(&diag::NO_SPINDLE, text);
        return Ok(());
    };
    kernel.flow.pass.effects = true;
    let before = kernel.turning_speed()?;
    let old = kernel.channel.state.spindle.command;
    let rank = kernel.channel.at.channel;
    let mut conflict = 0;
    if kernel.channel.state.spindle.shared {
        let (now, writer) = kernel.shared(|order| {
            let Some(spindle) = order.shared.spindles.get_mut(index) else { return (Command::default(), 0) };
            let old = spindle.command;
            change(&mut spindle.command);
            if old.driver == rank && spindle.command.driver != rank {
                // Until its new driver moves the spindle goes on as it turns.
                spindle.now = before;
            }
            let changed = old != spindle.command;
            let other = spindle.writer != 0 && spindle.writer != rank && !spindle.ordered.has(rank);
            let writer = if changed && other { spindle.writer } else { 0 };
            spindle.writer = rank;
            spindle.ordered = Set::default().with(rank);
            (spindle.command, writer)
        })?;
        kernel.channel.state.spindle.command = now;
        conflict = writer;
    } else {
        change(&mut kernel.channel.state.spindle.command);
    }
    if conflict != 0 {
        let text = format!(
            "channels {conflict} and {rank} both command the spindle without a meeting between them, here in '{}': the later one in time holds",
            kernel.block_text()
        );
        kernel.diagnose(&diag::SPINDLE_CONFLICT, text);
    }
    if kernel.channel.state.spindle.command != old {
        announce(kernel, index, before)?;
    }
    kernel.follow_radius()
}

/// Changes the commanded state as a macro wants it: without an event and without time.
pub(crate) fn set_command(kernel: &mut Kernel<'_>, change: impl Fn(&mut Command)) -> Acted {
    let Some(index) = kernel.channel.state.spindle.index else { return Ok(()) };
    if !kernel.channel.state.spindle.shared {
        change(&mut kernel.channel.state.spindle.command);
        return Ok(());
    }
    let now = kernel.shared(|order| {
        order.shared.spindles.get_mut(index).map(|spindle| {
            change(&mut spindle.command);
            spindle.command
        })
    })?;
    kernel.channel.state.spindle.command = now.unwrap_or_default();
    kernel.follow_radius()
}

/// Logs the state and takes the run-up time.
fn announce(kernel: &mut Kernel<'_>, index: usize, before: f64) -> Acted {
    let Some(spindle) = kernel.channel.env.machine.spindles.get(index) else { return Ok(()) };
    let (number, max, run_up) = (spindle.number, spindle.max, spindle.run_up);
    let now = kernel.channel.state.spindle.command;
    let speed = if now.css { now.surface } else { now.rpm };
    if !now.css && now.rpm > max {
        let text = format!(
            "{} rev/min is above the largest speed {max} of spindle {number} in '{}'",
            now.rpm,
            kernel.block_text()
        );
        kernel.diagnose(&diag::SPINDLE_LIMIT, text);
    }
    let after = kernel.turning_speed()?;
    let mut seconds = 0.0;
    if run_up > 0.0 && max > 0.0 {
        seconds = run_up * (after - before).abs() / max;
    }
    if after != before {
        seconds += kernel.channel.env.machine.time.spindle_speed;
    }
    let ns = crate::state::channel::nanoseconds(seconds);
    let (direction, css, limit, angle) = (now.direction, now.css, now.limit, now.angle);
    let event = SpindleEvent { spindle: number, direction, css, speed, limit, angle };
    kernel.emit(ns, Kind::Spindle(event));
    kernel.advance(ns);
    Ok(())
}

impl Kernel<'_> {
    /// Commanded state of the channel's spindle as of now.
    pub(super) fn current(&mut self) -> Result<Command, Halt> {
        if self.channel.state.spindle.shared
            && let Some(index) = self.channel.state.spindle.index
        {
            let (command, now) = self.shared(|order| {
                order.shared.spindles.get(index).map_or((Command::default(), 0.0), |s| (s.command, s.now))
            })?;
            self.channel.state.spindle.command = command;
            self.channel.state.spindle.now = now;
        }
        Ok(self.channel.state.spindle.command)
    }

    /// How the spindle turns now, `None` when it stands.
    pub(crate) fn spindle_speed(&mut self) -> Result<Option<Turning>, Halt> {
        let command = self.current()?;
        if !matches!(command.direction, Direction::Clockwise | Direction::CounterClockwise) {
            return Ok(None);
        }
        let (max, min) = self
            .channel
            .state
            .spindle
            .index
            .and_then(|i| self.channel.env.machine.spindles.get(i))
            .map_or((f64::INFINITY, 0.0), |s| (if s.max > 0.0 { s.max } else { f64::INFINITY }, s.min));
        let max = max.min(command.limit);
        if !command.css {
            let rpm = command.rpm.min(max);
            return Ok((rpm > 0.0).then_some(Turning::Fixed(rpm)));
        }
        if command.surface <= 0.0 {
            return Ok(None);
        }
        if command.driver != self.channel.at.channel && command.radius <= 0.0 {
            return Ok((self.channel.state.spindle.now > 0.0).then_some(Turning::Fixed(self.channel.state.spindle.now)));
        }
        let factor = match (self.channel.env.machine.unit, self.channel.state.secondary) {
            (Unit::Mm, false) | (Unit::Inch, true) => 1000.0,
            (Unit::Mm, true) | (Unit::Inch, false) => 12.0,
        };
        let to_machine = match (self.channel.env.machine.unit, self.channel.state.secondary) {
            (Unit::Mm, true) => 25.4,
            (Unit::Inch, true) => 1.0 / 25.4,
            _ => 1.0,
        };
        let speed = Speed { surface: command.surface * factor * to_machine, max, min };
        if command.radius > 0.0 {
            let rpm = speed.rpm(command.radius);
            return Ok((rpm > 0.0).then_some(Turning::Fixed(rpm)));
        }
        Ok(Some(Turning::Surface(speed)))
    }

    /// Speed that turns now, 0 when the spindle stands.
    fn turning_speed(&mut self) -> Result<f64, Halt> {
        let radius = self.channel.radius(&self.channel.state.place.position);
        Ok(match self.spindle_speed()? {
            Some(Turning::Fixed(rpm)) => rpm,
            Some(Turning::Surface(surface)) => {
                let rpm = surface.rpm(radius);
                if rpm.is_finite() { rpm } else { 0.0 }
            }
            None => 0.0,
        })
    }

    /// Tells other channels the speed that this channel's X drives.
    pub(super) fn follow_radius(&mut self) -> Acted {
        let command = self.channel.state.spindle.command;
        let Some(index) = self.channel.state.spindle.index.filter(|_| self.channel.state.spindle.shared) else {
            return Ok(());
        };
        if !command.css || command.driver != self.channel.at.channel {
            return Ok(());
        }
        let rpm = self.turning_speed()?;
        if rpm != self.channel.state.spindle.now {
            self.channel.state.spindle.now = rpm;
            self.shared(|order| {
                if let Some(spindle) = order.shared.spindles.get_mut(index) {
                    spindle.now = rpm;
                }
            })?;
        }
        Ok(())
    }
}
