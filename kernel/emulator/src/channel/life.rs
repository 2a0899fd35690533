//! Beginning and end of a kernel, its limits, and hopeless polling.

use std::sync::Arc;

use counterpoint_channel::at::BlockPlace;
use counterpoint_channel::channel_context::ChannelContext;
use counterpoint_channel::custom_diagnostics::customised;
use counterpoint_channel::flow::{ProgramFlow, RunningProgram};
use counterpoint_channel::macros::runtime::Runtime;
use counterpoint_channel::queued_codes::initial_codes;
use counterpoint_channel::tool_data::report_order;
use counterpoint_event::SourcePlace;
use counterpoint_event::event::{Diagnostic, Event, FileId, Kind, Phase, Verdict, VerdictKind, VerdictMember};
use counterpoint_fault as diag;
use counterpoint_fault::{Acted, DiagnosticFacts, Halt};
use counterpoint_machine::ident::data;
use counterpoint_ports::control::{ChannelActivity, Limit};
use counterpoint_program::shape::ProgramRange;
use counterpoint_sync::order::Wake;
use counterpoint_sync::tag::Tag;
use counterpoint_sync::verdict;
use counterpoint_sync::wait::{Finish, Terminal};

use super::Kernel;
use super::carried::Lived;
use crate::channel::frame::initial_frame;
use crate::channel::parts::Ports;
use crate::channel::report::report_softened;

/// Blocks after which a kernel looks at the memory that it takes.
const WEIGHED_EVERY: u64 = 64;

/// How a program has ended.
struct Ending {
    halt: Halt,
    /// Tag of the end in the log, if the program has ended.
    ended: Option<Tag>,
    /// Another channel may start the next one.
    idle: bool,
}

fn terminal(halt: Halt) -> (Terminal, Phase, ChannelActivity) {
    match halt {
        Halt::ProgramEnd(_) => (Terminal::Ended, Phase::ProgramEnd, ChannelActivity::Ended),
        Halt::Alarm | Halt::Dropped => (Terminal::Alarmed, Phase::Alarmed, ChannelActivity::Alarmed),
        Halt::Stopped => (Terminal::Stopped, Phase::Stopped, ChannelActivity::Stopped),
        Halt::Blocked => (Terminal::Stopped, Phase::Blocked, ChannelActivity::Blocked),
    }
}

impl Kernel<'_> {
    /// Runs the channel until its program has ended and no other channel can start it again. `again` restarts it with
    /// another file, with (`true`) or without resetting modal state. Without a program it waits for a start.
    pub fn live(mut self, start: Option<(FileId, ProgramRange, Arc<str>)>, again: Option<bool>) -> Lived {
        self.ports.coordinator.begin(self.channel.at.channel);
        let mut ending =
            Ending { halt: Halt::ProgramEnd(None), ended: Some(self.channel.tag()), idle: start.is_none() };
        let (mut next, mut again) = (start, again);
        loop {
            if let Some(start) = next.take() {
                ending = self.run(start, again);
            }
            next = if ending.idle { self.wait_for_start() } else { None };
            if next.is_none() {
                break;
            }
            again = (!self.flow.frames.is_empty()).then_some(false);
        }
        leave_others(&mut self.channel, &self.ports, ending.halt);
        self.lived(ending.halt, ending.ended)
    }

    /// Runs a program.
    fn run(&mut self, start: (FileId, ProgramRange, Arc<str>), again: Option<bool>) -> Ending {
        let (file, range, name) = start;
        self.ports.progress.set_state(ChannelActivity::Running);
        self.channel.at.go_to(BlockPlace { file, line: 0, caller: SourcePlace::NONE });
        self.channel.emit(0, Kind::Lifecycle(Phase::ProgramStart));
        let begun = match again {
            Some(reset) => self.begin_again(file, range, name, reset),
            None => self.begin(file, range, name),
        };
        let halt = match begun {
            Ok(()) if self.channel.env.options.lint => (self.plan.lint)(self),
            Ok(()) => self.program(),
            Err(halt) => halt,
        };
        let mut halt = self.plan.hooks.map_or(halt, |hooks| (hooks.program.end)(self, halt));
        if let Halt::ProgramEnd(_) = halt {
            // No later block checks the limit for the last block, or for moves whose time was not known yet.
            self.channel.come_to_rest();
            if let Err(limit) = self.check_limits() {
                halt = limit;
            }
        }
        if let Some(hooks) = self.plan.hooks {
            (hooks.program.close)(self, halt);
        }
        self.finish(halt)
    }

    /// Waits until another channel starts a program here; none if no channel can do so any more.
    fn wait_for_start(&mut self) -> Option<(FileId, ProgramRange, Arc<str>)> {
        let (coordinator, channel) = (self.ports.coordinator, self.channel.at.channel);
        let wake = coordinator.wait(channel, self, |kernel| kernel.channel.flush());
        self.ports.control.disturb(channel);
        let Wake::Started { tag, program } = wake else { return None };
        if tag.t > self.channel.at.clock {
            self.channel.at.idle_blocks = 0;
            self.channel.state.times.add_waiting(tag.t - self.channel.at.clock);
        }
        (self.channel.at.clock, self.channel.at.micro) = (tag.t, tag.micro);
        if !self.flow.frames.is_empty() {
            // A start begins with the codes of a reset and without local frames, regardless of the state at the end of
            // the program before; the tool and its offsets stay.
            let number = self.channel.state.remembered.value(data::COMP_DIAM);
            self.channel.state.forget_words(self.channel.env.machine);
            if let Some(number) = number {
                self.channel.state.remembered.remember(data::COMP_DIAM, number);
            }
            (self.channel.state.place.frames, self.channel.state.place.clamped) = (None, 0);
            self.channel.reset_feed_group();
            initial_codes(&mut self.channel);
        }
        let range = ProgramRange { number: None, first: program.lines.0, last: program.lines.1 };
        Some((program.file, range, (*program.name).into()))
    }

    fn begin(&mut self, file: FileId, range: ProgramRange, name: Arc<str>) -> Acted {
        let again = !self.flow.frames.is_empty();
        self.flow.frames.push(RunningProgram::main(file, range, name));
        initial_codes(&mut self.channel);
        if again {
            self.reframe();
        } else {
            initial_frame(&mut self.channel);
        }
        self.load(file)?;
        self.report_leader(file, range);
        self.interpreter_start();
        self.plan.hooks.map_or(Ok(()), |hooks| (hooks.program.start)(self))
    }

    /// Logs the end state and publishes it to the other channels.
    fn finish(&mut self, halt: Halt) -> Ending {
        let (how, phase, state) = terminal(halt);
        let can_start = matches!(halt, Halt::ProgramEnd(_)) && self.channel.env.machine.sync.starts_channels();
        let mut idle = can_start && self.channel.env.machine.channels.len() > 1;
        if matches!(halt, Halt::ProgramEnd(_) | Halt::Alarm) {
            report_order(&mut self.channel, &mut self.macros);
            self.report_separate();
            self.report_swallowed();
        }
        report_softened(&mut self.channel, halt);
        if let Halt::ProgramEnd(Some(stop)) = halt {
            self.channel.emit(0, Kind::Stop(stop));
        }
        let mut ended = None;
        if matches!(halt, Halt::ProgramEnd(_) | Halt::Alarm) {
            self.channel.emit(0, Kind::Lifecycle(phase));
            ended = Some(self.channel.tag());
            let SourcePlace { file, line } = self.channel.at.user_place();
            let finish = Finish { how, file, line };
            let (tag, info) = (self.channel.tag(), self.channel.env.info);
            // A reset ends one channel, even where an alarm would end all.
            let stop_all = halt == Halt::Alarm
                && !self.channel.reports.reset
                && self.channel.env.machine.sync.alarm_scope == counterpoint_machine::model::AlarmScope::All;
            let verdict = self.shared(|order| {
                order.finish(tag, finish);
                if stop_all {
                    order.stop(tag);
                    return None;
                }
                if idle {
                    // A start can still let this channel meet the wait of another.
                    order.rest_idle(tag.channel);
                }
                order.judge(tag.t, info)
            });
            idle &= verdict.is_ok();
            if let Ok(Some(verdict)) = verdict {
                emit_verdict(&mut self.channel, &self.macros, verdict);
            }
        }
        self.ports.progress.t_ns.store(self.channel.at.clock, std::sync::atomic::Ordering::Relaxed);
        self.ports.progress.set_state(state);
        Ending { halt, ended, idle: idle && ended.is_some() }
    }

    /// Limits of the job that one channel can reach.
    #[inline(always)]
    pub fn check_limits(&mut self) -> Acted {
        let limits = &self.channel.env.options.limits;
        // All at once, as a block is seldom beyond any of them.
        let within = (self.channel.now() <= limits.simulated_ns)
            & (self.channel.at.blocks + self.channel.burden.blocks() <= limits.blocks)
            & (self.channel.emitter.count() <= limits.events)
            & (self.channel.at.idle_blocks <= limits.zero_time_blocks)
            & (self.channel.burden.steps <= limits.macro_steps);
        if within && !self.channel.at.blocks.is_multiple_of(WEIGHED_EVERY) { Ok(()) } else { self.check_each_limit() }
    }

    #[cold]
    #[inline(never)]
    fn check_each_limit(&mut self) -> Acted {
        let limits = &self.channel.env.options.limits;
        let (limit, reason) = if self.channel.now() > limits.simulated_ns {
            let reason = format!("the simulated time passed {:.3} s", limits.simulated_ns as f64 / 1e9);
            (Limit::SimulatedTime, reason)
        } else if self.channel.at.blocks + self.channel.burden.blocks() > limits.blocks {
            (Limit::Blocks, format!("more than {} blocks", limits.blocks))
        } else if self.channel.emitter.count() > limits.events {
            (Limit::Events, format!("more than {} events in its log", limits.events))
        } else if self.channel.at.idle_blocks > limits.zero_time_blocks {
            (
                Limit::ZeroTimeBlocks,
                format!("{} blocks in a row without a move, dwell or wait", limits.zero_time_blocks),
            )
        } else if self.channel.burden.steps > limits.macro_steps {
            (Limit::MacroSteps, format!("more than {} steps of macros", limits.macro_steps))
        } else if let Some(reason) =
            self.channel.at.blocks.is_multiple_of(WEIGHED_EVERY).then(|| self.overburdened()).flatten()
        {
            (Limit::Memory, format!("the memory of the job is exhausted: {reason}"))
        } else {
            return Ok(());
        };
        Err(self.limit(&reason, Some(limit)))
    }

    /// Stops the whole job here, at a limit or because it can never continue, and reports the activity of each channel.
    pub(crate) fn limit(&mut self, reason: &str, limit: Option<Limit>) -> Halt {
        let place = match limit {
            // Found at the start of the next block.
            Some(Limit::SimulatedTime) => self.channel.at.timed,
            _ => self.channel.at.user_place(),
        };
        self.stop_all(reason, limit, place)
    }

    /// The same, at a line of the loop that never ends or at the block.
    fn stop_all(&mut self, reason: &str, limit: Option<Limit>, place: SourcePlace) -> Halt {
        let kind = limit.map_or(VerdictKind::PartnerSpinning, |_| VerdictKind::Limit);
        let (own_channel, tag, info) = (self.channel.at.channel, self.channel.tag(), self.channel.env.info);
        if limit.is_some() {
            self.report_polled();
        }
        let own = match limit {
            Some(_) => what_it_did(&self.channel, &self.flow, reason, ":", place),
            None => what_it_did(&self.channel, &self.flow, reason, "", self.channel.at.user_place()),
        };
        let SourcePlace { file, line } = place;
        let verdict = self.shared(|order| {
            let mut sentences = vec![own];
            let mut members = Vec::new();
            for channel in order.waits.places.channels() {
                if channel == own_channel {
                    members.push(VerdictMember { channel, file, line, waiting_for: Vec::new() });
                } else if let Some((sentence, member)) = order.polling(channel, info) {
                    sentences.push(sentence);
                    members.push(member);
                } else if let Some(sentence) = verdict::waiting_sentence(channel, &order.waits, info) {
                    sentences.push(sentence);
                    members.push(verdict::member(channel, &order.waits));
                }
            }
            order.stop(tag);
            Verdict { kind, at_ns: tag.t, text: sentences.join("; ").into(), members }
        });
        match verdict {
            Ok(verdict) => {
                // Only the kernel that stops the others gets here.
                if let Some(limit) = limit {
                    self.ports.control.reach(limit);
                }
                emit_verdict(&mut self.channel, &self.macros, verdict);
                Halt::Stopped
            }
            Err(halt) => halt,
        }
    }

    /// A loop that only reads shared variables is hopeless once no other channel can change them.
    pub(crate) fn spinning(&mut self, line: u32, names: &str) -> Halt {
        let at = self.channel.at.caller.or(SourcePlace::new(self.channel.at.file, line));
        let place = verdict::place(self.channel.env.info, at.file, at.line);
        let reason = format!("polls {names} at {place}, and no channel is left to change that");
        self.stop_all(&reason, None, at)
    }
}

/// Leaves the other channels for good.
fn leave_others(channel: &mut ChannelContext<'_>, ports: &Ports<'_>, halt: Halt) {
    let (how, ..) = terminal(halt);
    channel.come_to_rest();
    channel.flush();
    let SourcePlace { file, line } = channel.at.user_place();
    let (channel, finish) = (channel.at.channel, Finish { how, file, line });
    ports.coordinator.done(channel, |order| {
        if order.waits.places.end(channel).is_none() && halt != Halt::Blocked {
            order.waits.finish(channel, finish);
        }
    });
}

/// Logs a verdict as an event of the master, with its diagnostic.
pub(crate) fn emit_verdict(channel: &mut ChannelContext<'_>, macros: &Runtime, verdict: Verdict) {
    let facts: &DiagnosticFacts = match verdict.kind {
        VerdictKind::Limit => &diag::LIMIT_REACHED,
        _ => &diag::DEADLOCK,
    };
    let (file, line) = verdict.members.first().map_or((0, 0), |m| (m.file, m.line));
    let custom = customised(channel, macros, facts.number, (facts.severity, true), verdict.text.to_string());
    let (severity, text) = custom.unwrap_or((facts.severity, String::new()));
    let diagnostic = Diagnostic { number: facts.number, severity, text: text.into(), ..Diagnostic::default() };
    log_of_master(channel, (file, line), Kind::Diagnostic(Box::new(diagnostic)));
    log_verdict(channel, verdict);
}

/// Logs a verdict on channels whose alarms have already reported the rest.
pub(crate) fn log_verdict(channel: &mut ChannelContext<'_>, verdict: Verdict) {
    let place = verdict.members.first().map_or((0, 0), |m| (m.file, m.line));
    log_of_master(channel, place, Kind::Verdict(Box::new(verdict)));
}

fn log_of_master(channel: &mut ChannelContext<'_>, (file, line): (FileId, u32), kind: Kind) {
    let (t_ns, micro) = (channel.at.clock, channel.at.micro);
    channel.emitter.push(Event { t_ns, micro, dur_ns: 0, channel: 0, file, line, caller: SourcePlace::NONE, kind });
}

fn what_it_did(
    channel: &ChannelContext<'_>,
    flow: &ProgramFlow,
    reason: &str,
    colon: &str,
    place: SourcePlace,
) -> String {
    let pass = flow.pass.last();
    let name = channel.env.info.place_name(place.file, place.line);
    if pass.count > 1 && !channel.at.caller.is_some() {
        let (_, first, last) = pass.key;
        format!(
            "channel {}{colon} {reason}; it looped {} times over lines {first}-{last} of {name}",
            channel.at.channel, pass.count
        )
    } else {
        format!(
            "channel {}{colon} {reason} at {}",
            channel.at.channel,
            verdict::place(channel.env.info, place.file, place.line)
        )
    }
}
