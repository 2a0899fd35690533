//! Waits of a channel for others, and acts that let others continue.
//!
//! Facts: reference channel-synchronisation.md 1.0 to 1.9. *Invariant:* a kernel waits only here and in shared
//! operations; `sync` defines the meaning of a wait.

use std::sync::Arc;

use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::coupled_axes::hears_of_couplings;
use counterpoint_event::SourcePlace;
use counterpoint_event::event::{Kind, Primitive, Release, Verdict, WaitArrival};
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, Halt};
use counterpoint_ports::control::ChannelActivity;
use counterpoint_sync::coordinator::turn::MeetOutcome;
use counterpoint_sync::order::Wake;
use counterpoint_sync::order::arrive::ArrivalReply;
use counterpoint_sync::order::idle::StartableProgram;
use counterpoint_sync::tag::Tag;
use counterpoint_sync::wait::{Finish, Terminal, WaitingChannel};
use counterpoint_sync::waits::ShortfallReason;
use counterpoint_sync::{Letter, wait};
use counterpoint_waits::is_passed_in_motion;

use super::Kernel;
use crate::channel::in_order;
use crate::channel::life::{emit_verdict, log_verdict};

impl Kernel<'_> {
    /// Selects the program of another channel, or none.
    pub(crate) fn select(&mut self, channel: u16, program: Option<StartableProgram>) -> Acted {
        self.flow.pass.effects = true;
        self.shared(|order| order.select(channel, program))?.map_err(|reason| not_startable(self, &reason))
    }

    /// Starts the selected programs of other channels.
    pub(crate) fn start(&mut self, channels: wait::ChannelSet) -> Acted {
        self.flow.pass.effects = true;
        let tag = self.channel.tag();
        self.shared(|order| order.start(tag, channels))?.map_err(|reason| not_startable(self, &reason))
    }

    /// Waits for other channels.
    pub fn wait(&mut self, wait: wait::Wait) -> Acted {
        self.compare_last_speed()?;
        if !self.channel.state.others.couplings.is_empty() {
            self.wait_coupled(wait)?;
        } else {
            self.wait_plainly(wait)?;
        }
        if wait.primitive == Primitive::Barrier && hears_of_couplings(&mut self.channel, &self.flow) {
            return self.learn_couplings();
        }
        Ok(())
    }

    /// The wait itself, regardless of couplings.
    pub(super) fn wait_plainly(&mut self, wait: wait::Wait) -> Acted {
        self.flow.pass.effects = true;
        if self.channel.emitter.has_pace()
            && is_passed_in_motion(self.channel.env.machine, &wait)
            && let Some(brakes) = self.channel.emitter.brakes_at(&mut self.channel.state.move_times())
        {
            return self.wait_in_motion(wait, brakes);
        }
        self.channel.come_to_rest();
        let first = match wait.primitive {
            Primitive::Lease => true,
            Primitive::Count | Primitive::Signal => wait.need != 0,
            Primitive::Barrier | Primitive::Flag if self.channel.env.options.lint => {
                self.shared(|order| order.waits.lists_differ(&wait))?
            }
            Primitive::Barrier | Primitive::Flag | Primitive::Order | Primitive::Join => false,
        };
        self.note_order(first, Some(wait.primitive))?;
        if self.ports.control.interferes() {
            self.comes_to_wait(&wait);
        }
        match wait.primitive {
            Primitive::Barrier | Primitive::Flag | Primitive::Order | Primitive::Count => arrive(self, wait),
            Primitive::Signal | Primitive::Join | Primitive::Lease => wait_unless_over(self, wait).map(|_| ()),
        }
    }

    /// Executes an act at which other channels may continue; it is shown as this wait would be.
    pub fn let_continue(&mut self, act: wait::WaitOp, shown: wait::Wait) -> Acted {
        self.channel.come_to_rest();
        self.flow.pass.effects = true;
        self.note_order(!matches!(act, wait::WaitOp::Signal(_)), None)?;
        let what = match act {
            wait::WaitOp::Set(_) | wait::WaitOp::Signal(_) => "set",
            wait::WaitOp::Clear(_) | wait::WaitOp::Remove { .. } => "clear",
            wait::WaitOp::Release(_) => "release",
            wait::WaitOp::Take(_) => "take",
            wait::WaitOp::Give { .. } => "give",
        };
        show(self, &shown, what);
        let tag = self.channel.tag();
        self.shared(|order| order.act(tag, act))?.map_err(|reason| impossible(self, &reason))
    }

    /// Sends a signal with values, or removes signals.
    pub(crate) fn signal(&mut self, act: wait::WaitOp, letter: Option<Letter>, shown: wait::Wait) -> Acted {
        self.channel.come_to_rest();
        self.flow.pass.effects = true;
        self.note_order(!matches!(act, wait::WaitOp::Signal(_)), None)?;
        show(self, &shown, if matches!(act, wait::WaitOp::Signal(_)) { "set" } else { "clear" });
        let tag = self.channel.tag();
        self.shared(|order| order.act_with(tag, act, letter))?.map_err(|reason| {
            let text = format!("250001 {reason}, in '{}'", self.channel.block_text());
            self.alarm(&diag::SIGNALS_FULL, text)
        })
    }

    /// Waits for signals: the values that came with them.
    pub(crate) fn await_signal(&mut self, wait: wait::Wait) -> Result<Vec<Letter>, Halt> {
        self.channel.come_to_rest();
        self.flow.pass.effects = true;
        self.note_order(wait.need != 0, None)?;
        if self.channel.reports.waits.rules.of(&wait).is_some_and(|rule| rule.signals.in_order) {
            let channel = self.channel.at.channel;
            if let Some(older) = self.shared(|order| order.waits.older_signal(channel, &wait))? {
                let awaited = wait.key.number;
                let text = format!(
                    "250002 signal {older} was sent before signal {awaited} and is not used yet, at '{}'",
                    self.channel.block_text()
                );
                self.diagnose(&diag::SIGNAL_ORDER, text);
            }
        }
        wait_for_signals(self, wait)
    }

    /// Takes signals if they are there: the values that came with them.
    pub(crate) fn read_signal(&mut self, wait: wait::Wait) -> Result<Option<Vec<Letter>>, Halt> {
        self.channel.come_to_rest();
        self.flow.pass.effects = true;
        self.note_order(true, None)?;
        let (waiting, _) = arrival(self, wait);
        let channel = self.channel.at.channel;
        self.shared(|order| order.pass(&waiting).then(|| order.waits.letters(channel)))
    }
}

impl Kernel<'_> {
    /// Reports once in a lint that the outcome of a wait depends on which channel comes first (`first`). Later waits of
    /// such channels are not checked, unless they are at one barrier with lists that never match.
    fn note_order(&mut self, first: bool, primitive: Option<Primitive>) -> Acted {
        if !first || !self.channel.env.options.lint {
            return Ok(());
        }
        if primitive != Some(Primitive::Barrier) {
            let channel = self.channel.at.channel;
            self.shared(|order| order.waits.order_matters = order.waits.order_matters.with(channel))?;
        }
        if !std::mem::replace(&mut self.channel.reports.waits.order_noted, true) {
            let text = format!(
                "the outcome depends on which channel comes first at '{}'; endless waits after it are not reported",
                self.channel.block_text()
            );
            self.diagnose(&diag::LINT_ORDER, text);
        }
        Ok(())
    }
}

/// A program of another channel cannot be selected or started.
fn not_startable(kernel: &mut Kernel<'_>, reason: &str) -> Halt {
    let text = format!("{reason}, in '{}'", kernel.channel.block_text());
    kernel.alarm(&diag::CHANNEL_NOT_STARTED, text)
}

/// The act of the channel at its wait is not possible.
pub(super) fn impossible(kernel: &mut Kernel<'_>, reason: &str) -> Halt {
    let text = format!("{reason}, in '{}'", kernel.channel.block_text());
    kernel.fatal(&diag::WAIT_IMPOSSIBLE, text)
}

/// A wait as it is in the log.
struct Logged {
    wait: Arc<WaitArrival>,
    since_ns: i64,
}

impl Logged {
    /// Logs that the channel waits from now on.
    fn new(kernel: &mut Kernel<'_>, wait: &wait::Wait, since_ns: i64) -> Self {
        let wait = kernel.channel.reports.waits.wait(wait);
        kernel.channel.burden.result(counterpoint_channel::burden::RESULT);
        kernel.channel.emit(0, Kind::Wait(wait.clone()));
        Self { wait, since_ns }
    }

    fn release(&self, meeting: u64, by: u16) -> Release {
        let (key, primitive) = (self.wait.key.clone(), self.wait.primitive);
        Release { key, primitive, since_ns: self.since_ns, meeting, mark: self.wait.mark.clone(), by }
    }
}

/// Where the channel arrives, and how it ends if the control refuses that.
fn arrival(kernel: &mut Kernel<'_>, wait: wait::Wait) -> (WaitingChannel, Finish) {
    let SourcePlace { file, line } = kernel.channel.at.user_place();
    (WaitingChannel { wait, tag: kernel.channel.tag(), file, line }, Finish { how: Terminal::Alarmed, file, line })
}

impl Kernel<'_> {
    /// Arrives when the path would have to brake, ns: if the others are there by then, it continues; otherwise it stops
    /// and waits.
    #[cold]
    #[inline(never)]
    fn wait_in_motion(&mut self, wait: wait::Wait, brakes: i64) -> Acted {
        if self.ports.control.interferes() {
            self.comes_to_wait(&wait);
        }
        let tag = Tag { t: brakes, micro: 0, channel: self.channel.at.channel };
        let logged = Logged { wait: self.channel.reports.waits.wait(&wait), since_ns: brakes };
        self.channel.burden.result(counterpoint_channel::burden::RESULT);
        self.channel.emitter.draw_in(brakes);
        self.channel.emitter.emit_during(&self.channel.at, (brakes, 0), Kind::Wait(logged.wait.clone()));
        let SourcePlace { file, line } = self.channel.at.user_place();
        let own = Finish { how: Terminal::Alarmed, file, line };
        let (waiting, info) = (WaitingChannel { wait, tag, file, line }, self.channel.env.info);
        let (after, warning) =
            in_order(&mut self.channel, &self.ports, tag, |order| order.arrive_in_motion(waiting, own, info))?;
        let (after, wake) = match after {
            ArrivalReply::Stand(_) => {
                // Channels that arrive at the same instant are in time.
                let stop = Tag { micro: u32::MAX, ..tag };
                match in_order(&mut self.channel, &self.ports, stop, |order| order.stops(stop, info))? {
                    Ok(wake) => (ArrivalReply::Stand(None), Some(wake)),
                    Err(verdict) => (ArrivalReply::Stand(verdict), None),
                }
            }
            after => (after, None),
        };
        let passed = match (&after, &wake) {
            (ArrivalReply::Go { t, micro, sync_point, short: None }, _) => {
                Some((*t, *micro, *sync_point, self.channel.at.channel))
            }
            (_, Some(Wake::Released { tag, sync_point, by, short: None, .. })) => {
                Some((tag.t, tag.micro, *sync_point, *by))
            }
            _ => None,
        };
        if let Some((t, micro, sync_point, by)) = passed.filter(|(t, ..)| *t == brakes && warning.is_none()) {
            let release = Kind::Release(logged.release(sync_point, by));
            self.channel.emitter.emit_during(&self.channel.at, (t, micro), release);
            return Ok(());
        }
        self.channel.come_to_rest();
        if let Some(text) = warning {
            self.diagnose(&diag::WAIT_LISTS, text);
        }
        match (after, wake) {
            (_, Some(wake)) => woken(self, wake, &logged),
            (ArrivalReply::Stand(verdict), None) => stand(self, verdict, &logged),
            (after, None) => follow(self, after, &logged),
        }
    }
}

/// Arrives, and waits until the others are there.
fn arrive(kernel: &mut Kernel<'_>, wait: wait::Wait) -> Acted {
    let logged = Logged::new(kernel, &wait, kernel.channel.at.clock);
    let (waiting, own) = arrival(kernel, wait);
    let info = kernel.channel.env.info;
    kernel.ports.control.disturb(kernel.channel.at.channel);
    let met = kernel.ports.coordinator.meet(
        waiting,
        kernel,
        |kernel| {
            kernel.channel.flush();
            kernel.ports.progress.stand(logged.wait.clone());
        },
        |kernel, look| kernel.channel.emitter.work(look),
    );
    kernel.ports.control.disturb(kernel.channel.at.channel);
    let (after, warning) = match met {
        MeetOutcome::Woken(wake) => return woken(kernel, wake, &logged),
        MeetOutcome::Turn(mut turn) => turn.arrive(waiting, own, info),
    };
    if let Some(text) = warning {
        kernel.diagnose(&diag::WAIT_LISTS, text);
    }
    match after {
        ArrivalReply::Stand(verdict) => stand(kernel, verdict, &logged),
        after => follow(kernel, after, &logged),
    }
}

/// Continues at once if the expected event has happened, without an entry in the list of sync points; waits otherwise.
///
/// Gives the values that came with signals that were there.
fn wait_unless_over(kernel: &mut Kernel<'_>, wait: wait::Wait) -> Result<Option<Vec<Letter>>, Halt> {
    let since_ns = kernel.channel.at.clock;
    let (waiting, own) = arrival(kernel, wait);
    let info = kernel.channel.env.info;
    let channel = kernel.channel.at.channel;
    let after = kernel.shared(|order| {
        if order.pass(&waiting) { Ok(order.waits.letters(channel)) } else { Err(order.arrive(waiting, own, info).0) }
    })?;
    match after {
        Ok(letters) => {
            show(kernel, &wait, "go");
            return Ok(Some(letters));
        }
        Err(ArrivalReply::Illegal { text }) => return Err(impossible(kernel, &text)),
        Err(after) => {
            let logged = Logged::new(kernel, &wait, since_ns);
            match after {
                ArrivalReply::Stand(verdict) => stand(kernel, verdict, &logged)?,
                after => follow(kernel, after, &logged)?,
            }
        }
    }
    Ok(None)
}

/// Waits for something that comes by itself.
pub(super) fn wait_until(kernel: &mut Kernel<'_>, wait: wait::Wait, after: ArrivalReply) -> Acted {
    let logged = Logged::new(kernel, &wait, kernel.channel.at.clock);
    follow(kernel, after, &logged)
}

/// Waits for signals: the values that came with them.
fn wait_for_signals(kernel: &mut Kernel<'_>, wait: wait::Wait) -> Result<Vec<Letter>, Halt> {
    if let Some(letters) = wait_unless_over(kernel, wait)? {
        return Ok(letters);
    }
    let channel = kernel.channel.at.channel;
    kernel.shared(|order| order.waits.letters(channel))
}

/// Executes the effect of an arrival that leaves nothing to wait for.
fn follow(kernel: &mut Kernel<'_>, after: ArrivalReply, logged: &Logged) -> Acted {
    match after {
        ArrivalReply::Go { t, micro, sync_point, short } => {
            kernel.ports.progress.set_state(ChannelActivity::Running);
            let release = logged.release(sync_point, kernel.channel.at.channel);
            go_on(kernel, (t, micro), release);
            report_short(kernel, short);
            Ok(())
        }
        ArrivalReply::Alarm { text, verdict } => {
            let halt = kernel.fatal(&diag::WAIT_MISMATCH, text);
            log_verdict(&mut kernel.channel, verdict);
            Err(halt)
        }
        ArrivalReply::Illegal { text } => Err(impossible(kernel, &text)),
        ArrivalReply::Stand(_) => Ok(()),
    }
}

/// Continues after a wait.
fn woken(kernel: &mut Kernel<'_>, wake: Wake, logged: &Logged) -> Acted {
    match wake {
        Wake::Released { tag, sync_point, by, all, short } => {
            kernel.ports.progress.set_state(ChannelActivity::Running);
            if all {
                kernel.channel.emitter.all_reached(tag.t);
            }
            go_on(kernel, (tag.t, tag.micro), logged.release(sync_point, by));
            report_short(kernel, short);
            Ok(())
        }
        Wake::Alarm { tag, text } => {
            (kernel.channel.at.clock, kernel.channel.at.micro) = at_rest_after(&kernel.channel, (tag.t, tag.micro));
            Err(kernel.fatal(&diag::WAIT_MISMATCH, text))
        }
        Wake::Over if kernel.ports.control.cancelled() => Err(Halt::Stopped),
        Wake::Over => Err(Halt::Blocked),
        Wake::Stopped | Wake::Turn | Wake::Started { .. } | Wake::Roused { .. } => Err(Halt::Stopped),
    }
}

/// Waits until another channel ends the wait that this one is blocked at.
fn stand(kernel: &mut Kernel<'_>, verdict: Option<Verdict>, logged: &Logged) -> Acted {
    if let Some(verdict) = verdict {
        emit_verdict(&mut kernel.channel, &kernel.macros, verdict);
    }
    let (coordinator, channel) = (kernel.ports.coordinator, kernel.channel.at.channel);
    let wake = coordinator.wait(channel, kernel, |kernel| {
        kernel.channel.flush();
        kernel.ports.progress.stand(logged.wait.clone());
    });
    kernel.ports.control.disturb(channel);
    woken(kernel, wake, logged)
}

/// Continues after a sync point.
fn go_on(kernel: &mut Kernel<'_>, released: (i64, u32), release: Release) {
    let (t, micro) = at_rest_after(&kernel.channel, released);
    if t > kernel.channel.at.clock {
        kernel.channel.at.timed = kernel.channel.at.user_place();
        kernel.channel.at.idle_blocks = 0;
        kernel.channel.state.times.add_waiting(t - kernel.channel.at.clock);
    }
    (kernel.channel.at.clock, kernel.channel.at.micro) = (t, micro);
    kernel.channel.emit(0, Kind::Release(release));
}

/// Reports that a counted wait has synchronised nothing.
fn report_short(kernel: &mut Kernel<'_>, short: Option<ShortfallReason>) {
    let Some(short) = short else { return };
    let block = kernel.channel.block_text();
    let text = match short {
        ShortfallReason::Ended => format!("no partner is left for '{block}'; the channel continues without waiting"),
        ShortfallReason::Elsewhere => {
            format!("the partner of '{block}' waits at an order number; the channel continues without waiting")
        }
    };
    kernel.diagnose(&diag::COUNT_WITHOUT_PARTNER, text);
}

/// Logs the act of the channel at a mark without waiting.
fn show(kernel: &mut Kernel<'_>, wait: &wait::Wait, what: &str) {
    let text = kernel.channel.reports.waits.rules.text(wait);
    kernel.channel.emit(0, Kind::mode(format!("sync mark={text} {what}")));
}

/// When a channel continues that is released at a time, but no earlier than it has come to rest.
fn at_rest_after(channel: &ChannelContext<'_>, (t, micro): (i64, u32)) -> (i64, u32) {
    let at = &channel.at;
    if t < at.clock { (at.clock, at.micro) } else { (t, micro) }
}
