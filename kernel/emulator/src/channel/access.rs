//! The door to everything that channels share besides waits: common and named variables, GLOBALs, spindles, files.
//!
//! *Invariant:* every access of a channel passes here, with its target and whether it writes, so everything that
//! concerns all accesses is here. Facts: reference channel-synchronisation.md 2.4.

use counterpoint_channel::shared_target::SharedTarget;
use counterpoint_event::event::RaceWith;
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, DiagnosticFacts, Halt};
use counterpoint_ports::options::RacePolicy;
use counterpoint_sync::order::Order;
use counterpoint_sync::races::{AccessMode, AccessSite, Race, RaceVariable};
use counterpoint_sync::shared::SharedState;
use counterpoint_sync::verdict;

use super::Kernel;
use crate::channel::passes::is_polling;

/// Executes an access; a write may end loops in which other channels wait.
fn reach<R>(order: &mut Order, mode: AccessMode, operation: impl FnOnce(&mut SharedState) -> R) -> R {
    if mode == AccessMode::Write {
        order.change();
    }
    operation(&mut order.shared)
}

impl Kernel<'_> {
    /// Accesses shared data in tag order. An operator who steps through the job may stop it after a write.
    ///
    /// # Errors
    /// The job was stopped before, or a race is an alarm.
    pub fn access<R>(
        &mut self,
        door: SharedTarget<'_>,
        mode: AccessMode,
        operation: impl FnOnce(&mut SharedState) -> R,
    ) -> Result<R, Halt> {
        let result = self.access_in_order(door, mode, operation);
        if mode == AccessMode::Write && self.ports.control.interferes() && result.is_ok() {
            self.has_written(door);
        }
        result
    }

    fn access_in_order<R>(
        &mut self,
        door: SharedTarget<'_>,
        mode: AccessMode,
        operation: impl FnOnce(&mut SharedState) -> R,
    ) -> Result<R, Halt> {
        if mode == AccessMode::Write {
            self.flow.pass.effects = true;
        } else {
            self.flow.pass.polls(door);
        }
        if matches!(door, SharedTarget::Spindle) {
            return self.shared_in_motion(|order| reach(order, mode, operation));
        }
        // Accesses by the machine's own macros at the start and at the end of a kernel have no line.
        let judged = !self.channel.env.options.races.is_off() && !self.ports.coordinator.is_single();
        let judged = judged && self.channel.at.line != 0 && self.channel.at.channel != 0;
        let Some(variable) = judged.then(|| door.variable()).flatten() else {
            return self.shared_ahead(|order| reach(order, mode, operation));
        };
        let mode =
            if mode == AccessMode::Read && is_polling(&self.channel, &self.flow) { AccessMode::Poll } else { mode };
        let at = &self.channel.at;
        let place = at.user_place();
        let own = AccessSite { channel: at.channel, file: place.file, line: place.line };
        let (result, races) = self.shared_ahead(|order| {
            let races = order.races.as_mut().map(|races| races.access(&variable, own, mode)).unwrap_or_default();
            (reach(order, mode, operation), races)
        })?;
        for race in races {
            self.report_race(&variable, own, mode, race)?;
        }
        Ok(result)
    }

    fn report_race(&mut self, variable: &RaceVariable, own: AccessSite, mode: AccessMode, race: Race) -> Acted {
        let name = self.macros.variable_name(variable);
        let does = |wrote| if wrote { "writes" } else { "reads" };
        let place = |access: AccessSite| verdict::place(self.channel.env.info, access.file, access.line);
        let text = format!(
            "only timing decides the value of {name}: channel {} {} it at {}, channel {} {} it at {}; put a wait between them",
            race.earlier.channel,
            does(race.wrote),
            place(race.earlier),
            own.channel,
            does(mode == AccessMode::Write),
            place(own),
        );
        let (channel, line) = (race.earlier.channel, race.earlier.line);
        self.channel.reports.race = Some(Box::new(RaceWith { variable: name.into(), channel, line }));
        let done = if self.channel.env.options.races == RacePolicy::Alarm {
            Err(self.fatal(&DiagnosticFacts { severity: 12, alarm: true, ..diag::SHARED_RACE }, text))
        } else {
            self.diagnose(&diag::SHARED_RACE, text);
            Ok(())
        };
        self.channel.reports.race = None;
        done
    }
}
