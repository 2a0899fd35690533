//! Diagnostics of a kernel, and the effect of those that are alarms of the control.
//!
//! Facts: reference control-emulator.md 7.5 (the emulated system continues in all cases until an end code). Decision: a
//! real control stops at its alarms; which of the two a machine does is data of its own (`[control] stops`, `stops` of
//! a number). Invariants: a diagnostic that stops the channel is in the log even if macros have switched it off; a job
//! with an alarm never counts as succeeded, however low the severity of the alarm is.

use counterpoint_channel::alarms::Alarms;
use counterpoint_channel::burden::{RESULT, shortened};
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::custom_diagnostics::customised;
use counterpoint_event::event::{Diagnostic, Kind, Unrecognised};
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, DiagnosticFacts, Halt};

use super::Kernel;
use crate::channel::parts::Ports;

impl Kernel<'_> {
    /// Logs a diagnostic at the current block. Beyond the limit of a channel one closing notice follows, then
    /// nothing but alarms. A diagnostic that is an alarm of the control stops the channel before the next code acts.
    pub fn diagnose(&mut self, facts: &DiagnosticFacts, text: impl Into<String>) {
        if facts.alarm && self.ports.control.cancelled() {
            // A cancelled search may not have looked everywhere.
            return;
        }
        let stops = self.channel.env.machine.stops_at(facts);
        if self.has_room(stops) {
            self.log_diagnostic(facts, text.into(), stops);
        } else if self.channel.env.machine.is_alarm(facts) {
            self.channel.reports.alarms.softened = self.channel.reports.alarms.softened.saturating_add(1);
        }
    }

    /// Reports unrecognised text of a block; `place` is the block in quotes, and possible mistakes in it.
    pub(crate) fn report_unrecognised(&mut self, text: &str, place: String) {
        let about = Unrecognised { text: text.into(), place: place.into() };
        let message = about.to_string();
        self.channel.reports.unrecognised = Some(Box::new(about));
        self.diagnose(&diag::NOT_RECOGNISED, message);
        self.channel.reports.unrecognised = None;
    }

    /// Counts a diagnostic; false if it is one too many.
    pub fn has_room(&mut self, alarm: bool) -> bool {
        let limit = self.channel.env.options.limits.diagnostics;
        self.channel.reports.diagnostics = self.channel.reports.diagnostics.saturating_add(1);
        if self.channel.reports.diagnostics > limit && !alarm {
            if self.channel.reports.diagnostics == limit + 1 {
                let text = format!(
                    "more than {limit} diagnostics in channel {}; further ones are not logged",
                    self.channel.at.channel
                );
                self.log_diagnostic(&diag::TOO_MANY_DIAGNOSTICS, text, false);
            }
            return false;
        }
        true
    }

    fn log_diagnostic(&mut self, facts: &DiagnosticFacts, text: String, stops: bool) {
        let errors = self.channel.reports.alarms.errors;
        if let Some((severity, text)) =
            customised(&mut self.channel, &self.macros, facts.number, (facts.severity, stops), text)
        {
            if let Some(hooks) = self.plan.hooks {
                (hooks.diagnostic)(self, (facts.number, severity), text, stops);
            } else {
                self.channel.reports.alarms.count(severity);
                let text = shortened(&text);
                self.channel.burden.result(text.len() + RESULT);
                let unrecognised = self.channel.reports.take_unrecognised(facts.number, text);
                let (number, text) = (facts.number, text.into());
                let race = self.channel.reports.take_race(number);
                let diagnostic = Diagnostic { number, severity, text, unrecognised, race, ..Diagnostic::default() };
                self.channel.emit(0, Kind::Diagnostic(Box::new(diagnostic)));
            }
        }
        self.channel.reports.alarms.stopping |= stops;
        let own = self.channel.env.machine.diagnostics.stops(facts.number);
        if self.channel.env.machine.is_alarm(facts)
            && own != Some(false)
            && self.channel.reports.alarms.errors == errors
        {
            self.channel.reports.alarms.softened = self.channel.reports.alarms.softened.saturating_add(1);
        }
    }

    /// Logs an alarm of the control and returns its effect: the channel stops, or the rest of the block is dropped.
    pub fn alarm(&mut self, facts: &DiagnosticFacts, text: impl Into<String>) -> Halt {
        self.diagnose(facts, text);
        halted(&self.ports, if self.channel.env.machine.stops_at(facts) { Halt::Alarm } else { Halt::Dropped })
    }

    /// Reports a call that does not find its program. Under lint the check continues after the call, unless other
    /// channels may wait in the missing program.
    #[cold]
    pub fn program_missing(&mut self, text: String) -> Acted {
        let stopping = self.channel.reports.alarms.stopping;
        let alarm = self.alarm(&diag::SUBPROGRAM_MISSING, text);
        let channels = self.channel.env.info.channels.iter().filter(|channel| !channel.program.is_empty()).count();
        if self.channel.env.options.lint && channels == 1 {
            self.channel.reports.alarms.stopping = stopping;
            return Ok(());
        }
        Err(alarm)
    }

    /// Logs an alarm that leaves nothing to continue with.
    pub fn fatal(&mut self, facts: &DiagnosticFacts, text: impl Into<String>) -> Halt {
        self.diagnose(facts, text);
        halted(&self.ports, Halt::Alarm)
    }

    /// An alarm after which the machine continues ends its block; earlier requests of the block are still executed.
    #[inline(always)]
    pub fn went_on(&mut self, done: Acted) -> Acted {
        if done == Err(Halt::Dropped) { self.goes_on() } else { done }
    }

    #[cold]
    fn goes_on(&mut self) -> Acted {
        match self.follow() {
            Err(Halt::Dropped) => Ok(()),
            done => done,
        }
    }
}

/// The halt that ends a block; if the job is to end, nothing is an alarm any more.
fn halted(ports: &Ports<'_>, halt: Halt) -> Halt {
    if ports.control.cancelled() { Halt::Stopped } else { halt }
}

/// Says that there were alarms, where the log would not show an error. Nothing changes this diagnostic.
pub fn report_softened(channel: &mut ChannelContext<'_>, halt: Halt) {
    let Alarms { errors, softened, .. } = channel.reports.alarms;
    if errors > 0 || softened == 0 && halt != Halt::Alarm {
        return;
    }
    let what = if halt == Halt::Alarm { "is stopped by an alarm" } else { "continued after an alarm" };
    let text = format!("channel {} {what} that the machine reports as less than an error", channel.at.channel);
    let (number, severity, text) = (diag::ALARM_SOFTENED.number, diag::ALARM_SOFTENED.severity, text.into());
    let diagnostic = Diagnostic { number, severity, text, ..Diagnostic::default() };
    channel.emit(0, Kind::Diagnostic(Box::new(diagnostic)));
}

/// Reports another channel that has commanded the spindle without a sync point in between.
pub(super) fn report_spindle_conflict(kernel: &mut Kernel<'_>, other: u16) {
    let text = format!(
        "channels {other} and {} both command the spindle without a sync point between them, here in '{}': the later \
         command takes effect",
        kernel.channel.at.channel,
        kernel.channel.block_text()
    );
    kernel.diagnose(&diag::SPINDLE_CONFLICT, text);
}
