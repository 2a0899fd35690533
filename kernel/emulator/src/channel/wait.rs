//! Waits of a channel for others: arrivals, the start by one head, and what follows.
//!
//! Facts: reference channel-synchronisation.md 1.0, 1.3. Invariant: a kernel waits only here and in shared operations; codes
//! that do not match alarm when two waits meet.

use std::sync::Arc;

use counterpoint_fault::{Acted, Halt};

use super::Kernel;
use counterpoint_event::event::{Kind, Release, Wait};
use counterpoint_fault as diag;
use counterpoint_ports::control::State;
use counterpoint_sync::coordinator::turn::Met;
use counterpoint_sync::order::Wake;
use counterpoint_sync::order::arrive::After;
use counterpoint_sync::waits::{Finish, Set, Spec, Terminal, Waiting};

impl Kernel<'_> {
    /// Arrives at a wait, and waits until the others are there.
    pub(crate) fn arrive(&mut self, spec: Spec) -> Acted {
        arrive(self, spec)
    }

    /// A start by one of the heads: the one that it is named after lets the other one continue, now or when it comes; the
    /// other one waits, unless the first one has been here before.
    pub(crate) fn start_by_head(&mut self, by: u16, heads: Set) -> Acted {
        self.flow.pass.effects = true;
        if self.channel.at.channel == by { give(self, heads) } else { wait(self, by, heads) }
    }
}

/// Arrives, and waits until the others are there.
fn arrive(kernel: &mut Kernel<'_>, spec: Spec) -> Acted {
    let since_ns = kernel.channel.at.clock;
    let wait = kernel.channel.reports.waits.wait(&spec);
    kernel.channel.burden.result(crate::state::burden::RESULT);
    kernel.emit(0, Kind::Wait(wait.clone()));
    kernel.flow.pass.effects = true;
    let tag = kernel.tag();
    let (file, line, info) = (kernel.channel.at.file, kernel.channel.at.line, kernel.channel.env.info);
    let waiting = Waiting { spec, tag, file, line };
    let release = |meeting| released(&wait, since_ns, meeting);
    kernel.ports.control.disturb(kernel.channel.at.channel);
    let met = kernel.ports.coordinator.meet(
        waiting.clone(),
        kernel,
        |kernel| {
            kernel.flush();
            kernel.ports.progress.stand(wait.clone());
        },
        |kernel, look| kernel.ports.emitter.work(look),
    );
    kernel.ports.control.disturb(kernel.channel.at.channel);
    let after = match met {
        Met::Woken(wake) => return woken(kernel, wake, release),
        Met::Turn(mut turn) => {
            let own = Finish { how: Terminal::Alarmed, file, line };
            turn.arrive(waiting, own, info)
        }
    };
    match after {
        After::Go { t, micro, meeting } => {
            kernel.ports.progress.set_state(State::Running);
            go_on(kernel, (t, micro), release(meeting));
            Ok(())
        }
        After::Alarm { text, verdict } => {
            let halt = kernel.fatal(&diag::WAIT_MISMATCH, text);
            if let Some(verdict) = verdict {
                kernel.emit_verdict(verdict);
            }
            Err(halt)
        }
        After::Stand(verdict) => {
            if let Some(verdict) = verdict {
                kernel.emit_verdict(verdict);
            }
            let wake = stand(kernel, &wait);
            woken(kernel, wake, release)
        }
    }
}

/// The event of a channel that continues after a wait.
fn released(wait: &Wait, since_ns: i64, meeting: u64) -> Release {
    let Wait { key, primitive, mark, .. } = wait;
    Release { key: key.clone(), primitive: *primitive, since_ns, meeting, mark: mark.clone() }
}

/// Continues after a wait.
fn woken(kernel: &mut Kernel<'_>, wake: Wake, release: impl FnOnce(u64) -> Release) -> Acted {
    match wake {
        Wake::Released { tag, meeting, all } => {
            kernel.ports.progress.set_state(State::Running);
            if all {
                kernel.ports.emitter.all_reached(tag.t);
            }
            go_on(kernel, (tag.t, tag.micro), release(meeting));
            Ok(())
        }
        Wake::Alarm { tag, text } => {
            (kernel.channel.at.clock, kernel.channel.at.micro) = (tag.t, tag.micro);
            Err(kernel.fatal(&diag::WAIT_MISMATCH, text))
        }
        Wake::Over if kernel.ports.control.cancelled() => Err(Halt::Stopped),
        Wake::Over => Err(Halt::Blocked),
        Wake::Stopped | Wake::Turn => Err(Halt::Stopped),
    }
}

/// Waits until another channel ends the wait that this one is blocked at.
fn stand(kernel: &mut Kernel<'_>, wait: &Arc<Wait>) -> Wake {
    let (coordinator, rank) = (kernel.ports.coordinator, kernel.channel.at.channel);
    let wake = coordinator.wait(rank, kernel, |kernel| {
        kernel.flush();
        kernel.ports.progress.stand(wait.clone());
    });
    kernel.ports.control.disturb(kernel.channel.at.channel);
    wake
}

/// Continues after a meeting.
fn go_on(kernel: &mut Kernel<'_>, (t, micro): (i64, u32), release: Release) {
    if t > kernel.channel.at.clock {
        kernel.channel.at.idle_blocks = 0;
        kernel.macros.variables.store.idle += t - kernel.channel.at.clock;
    }
    (kernel.channel.at.clock, kernel.channel.at.micro) = (t, micro);
    kernel.emit(0, Kind::Release(release));
}

/// Lets the other head go on, now or when it comes.
fn give(kernel: &mut Kernel<'_>, heads: Set) -> Acted {
    tell(kernel, &Spec::start(kernel.channel.at.channel, heads), "set");
    let tag = kernel.tag();
    kernel.shared(|order| {
        if let Some(released) = order.waits.start(tag, heads) {
            let meeting = order.count_meeting(Set::default().with(tag.rank).with(released.rank));
            order.resume(released.rank, Wake::Released { tag: released, meeting, all: false });
        }
    })
}

/// Waits for the other head, unless it has been here before.
fn wait(kernel: &mut Kernel<'_>, by: u16, heads: Set) -> Acted {
    let spec = Spec::start(by, heads);
    let (since_ns, tag) = (kernel.channel.at.clock, kernel.tag());
    let (file, line, info) = (kernel.channel.at.file, kernel.channel.at.line, kernel.channel.env.info);
    let waiting = Waiting { spec: spec.clone(), tag, file, line };
    let stands = kernel.shared(|order| {
        if order.waits.started(by) {
            return None;
        }
        order.waits.stand(waiting);
        let verdict = if order.waits.hopeful(tag.rank) { None } else { order.judge(tag.t, info) };
        order.block(tag.rank);
        Some(verdict)
    })?;
    let Some(verdict) = stands else {
        tell(kernel, &spec, "go");
        return Ok(());
    };
    let wait = kernel.channel.reports.waits.wait(&spec);
    kernel.channel.burden.result(crate::state::burden::RESULT);
    kernel.emit(0, Kind::Wait(wait.clone()));
    if let Some(verdict) = verdict {
        kernel.emit_verdict(verdict);
    }
    let wake = stand(kernel, &wait);
    let release = |meeting| released(&wait, since_ns, meeting);
    woken(kernel, wake, release)
}

fn tell(kernel: &mut Kernel<'_>, spec: &Spec, what: &str) {
    kernel.emit(0, Kind::mode(format!("sync mark={} {what}", spec.text())));
}
