//! Several kernels under a master.
//!
//! The thread that runs the job is the master kernel (#0): it starts the kernels, one thread each, brings their streams
//! together (as one ordered log, or only as results) and closes the job. Facts: reference control-emulator.md 2.1, 2.4, 8.

mod master;
mod one_thread;
mod rounds;

use counterpoint_sync::{backlog, coordinator, merge, ranks, shared};
use std::sync::OnceLock;

use backlog::Backlog;
use coordinator::Coordinator;
use coordinator::switch::{Port, Switch};
use master::{At, Master};
use merge::{End, Feeder, Merger};
use rounds::Round;

use crate::prepared::Job;
use counterpoint_emulator::channel::Kernel;
use counterpoint_emulator::channel::carried::{Carried, Lived};
use counterpoint_emulator::channel::emit::{Emitter, Target};
use counterpoint_emulator::channel::parts::{Ports, Setup};
use counterpoint_emulator::channel::plan::Plan;
use counterpoint_emulator::state::channel::Environment;
use counterpoint_event::Outcome;
use counterpoint_event::event::{Event, FileId, Kind, Phase};
use counterpoint_machine::model::Channel;
use counterpoint_ports::control::{Control, Progress, State};
use counterpoint_ports::files::Files;
use counterpoint_program::shape::Range;
use counterpoint_results::builder::ResultsBuilder;
use counterpoint_sync::sink::{Sink, WrittenFiles};

/// Runs a prepared job; returns when every kernel has ended and the whole log has been received.
pub(crate) fn run(job: &Job, files: &dyn Files, control: &Control, sink: &mut dyn Sink) -> Outcome {
    let (outcome, written) = match sink.results() {
        Some(builder) => folded(job, files, control, builder),
        None => ordered(job, files, control, sink),
    };
    sink.files(written);
    outcome
}

/// Runs a job whose events go into its results, channel by channel.
fn folded(job: &Job, files: &dyn Files, control: &Control, builder: &mut ResultsBuilder) -> (Outcome, WrittenFiles) {
    let plan = Plan::new(
        &job.spec().machine,
        &job.spec().options.opskip,
        &counterpoint_emulator::action::ACTIONS,
        job.macros().map(|_| &counterpoint_emulator::hooks::POINTS),
    );
    let (given, mut count, mut round) = (OnceLock::new(), 0, Some(Round::default()));
    let mut written = WrittenFiles::new();
    while let Some(mut now) = round.take() {
        let coordinator = now.coordinator(job, None);
        let shop = Shop { job, plan: &plan, coordinator: &coordinator, files, control, given: &given };
        let mut log = |event: &Event| {
            count += 1;
            builder.event(event);
            true
        };
        let starting = shop.begin(&mut now, &mut log);
        let mut backlogs: Vec<Backlog> =
            builder.split().into_iter().map(|of| Backlog::new(of.number, of, job.info().room.waiting)).collect();
        let lived = shop.folded(starting, &mut backlogs);
        let stop = coordinator.stop_tag();
        let (mut channels, mut last) = (Vec::new(), now.at);
        for backlog in backlogs {
            let (results, events, end) = backlog.close(stop);
            last = last.max(end);
            count += events;
            channels.push(results);
        }
        let ended: Vec<u16> = channels.iter().filter(|channel| channel.ended()).map(|channel| channel.number).collect();
        builder.join(channels);
        let mut log = |event: &Event| {
            count += 1;
            builder.event(event);
            true
        };
        round = shop.close(now, lived, &ended, last, &mut log);
        written = coordinator.written();
    }
    (Outcome { events: count, cancelled: control.cancelled(), sink_failed: false }, written)
}

/// The ordered log on its way to the sink, between the runs of the kernels.
struct Log<'s> {
    sink: &'s mut dyn Sink,
    /// Events so far.
    count: u64,
    refused: bool,
}

impl Log<'_> {
    fn note(&mut self, event: &Event) -> bool {
        if !self.refused {
            self.count += 1;
            self.refused = !self.sink.events(self.count, std::slice::from_ref(event));
        }
        !self.refused
    }
}

/// Runs a job whose events become one ordered log.
fn ordered(job: &Job, files: &dyn Files, control: &Control, sink: &mut dyn Sink) -> (Outcome, WrittenFiles) {
    let machine = &*job.spec().machine;
    let plan = Plan::new(
        machine,
        &job.spec().options.opskip,
        &counterpoint_emulator::action::ACTIONS,
        job.macros().map(|_| &counterpoint_emulator::hooks::POINTS),
    );
    let (given, mut round) = (OnceLock::new(), Some(Round::default()));
    let mut written = WrittenFiles::new();
    let mut log = Log { sink, count: 0, refused: false };
    while let Some(mut now) = round.take() {
        let (mut merger, feeders, sender) =
            Merger::new(machine.channels.iter().map(|c| c.number), job.info().room.waiting);
        let coordinator = now.coordinator(job, Some(sender));
        let shop = Shop { job, plan: &plan, coordinator: &coordinator, files, control, given: &given };
        let starting = shop.begin(&mut now, &mut |event| log.note(event));
        if log.refused {
            coordinator.abort();
        }
        (merger.next_seq, merger.last) = (log.count + 1, now.at);
        let lived = shop.ordered(starting, feeders, &mut merger, log.sink);
        log.refused |= merger.end() == End::Refused;
        log.count = merger.next_seq - 1;
        round = shop.close(now, lived, &merger.ended(), merger.last, &mut |event| log.note(event));
        round = round.filter(|_| !log.refused);
        written = coordinator.written();
    }
    (Outcome { events: log.count, cancelled: control.cancelled(), sink_failed: log.refused }, written)
}

/// A kernel about to start.
struct Start<'a> {
    channel: &'a Channel,
    progress: &'a Progress,
    at: (FileId, Range, Box<str>),
    /// When the machine is started again: time and microstep, and what the kernel was before.
    before: Option<((i64, u32), Option<Carried>)>,
    /// The kernel goes on with another file, as if it were the first one or not.
    reset: Option<bool>,
}

/// Where the events of a kernel on its own thread go.
enum Way<'a> {
    Queue(Feeder),
    Results(&'a mut Backlog),
}

impl<'a> From<Way<'a>> for Target<'a> {
    fn from(way: Way<'a>) -> Self {
        match way {
            Way::Queue(feeder) => Self::Queue(feeder),
            Way::Results(backlog) => Self::Results(backlog),
        }
    }
}

/// What all kernels of a job work with.
#[derive(Clone, Copy)]
struct Shop<'a> {
    job: &'a Job,
    plan: &'a Plan,
    coordinator: &'a Coordinator,
    files: &'a dyn Files,
    control: &'a Control,
    /// Programs and channels of the kernels as Machine Startup left them, by kernel; nothing without a master.
    given: &'a OnceLock<Vec<master::Given>>,
}

impl<'a> Shop<'a> {
    /// The kernels that have a program; logs those that have none.
    fn starting(self, kernel_0: Option<&Master>, log: &mut dyn FnMut(&Event) -> bool) -> Vec<Start<'a>> {
        let Self { job, coordinator, control, .. } = self;
        let mut starting = Vec::new();
        for (index, channel) in job.spec().machine.channels.iter().enumerate() {
            let progress = control.progress().get(index).unwrap_or(control.spare());
            let own = job.info().channel(channel.number).filter(|c| !c.program.is_empty()).map(|start| {
                let range = Range { number: None, first: start.lines.0, last: start.lines.1 };
                (start.file, range, start.program.clone().into())
            });
            let given =
                kernel_0.and_then(|master| master.programs.iter().find(|(number, _)| *number == channel.number));
            let at = given.map_or(own, |(_, at)| at.clone()).filter(|_| kernel_0.is_none_or(|master| master.good));
            match at {
                Some(at) => starting.push(Start { channel, progress, at, before: None, reset: None }),
                None => {
                    progress.set_state(State::NotStarted);
                    log(&Event { channel: channel.number, ..master(0, Kind::Lifecycle(Phase::NotStarted)) });
                    coordinator.never_started(channel.number);
                }
            }
        }
        starting
    }

    /// Every kernel feeds the results of its own channel.
    fn folded(self, starting: Vec<Start<'_>>, backlogs: &mut [Backlog]) -> Vec<Lived> {
        let mut free: Vec<Option<&mut Backlog>> = backlogs.iter_mut().map(Some).collect();
        let mut work = Vec::new();
        for start in starting {
            let backlog = free.iter_mut().find(|b| b.as_ref().is_some_and(|b| b.rank == start.channel.number));
            if let Some(backlog) = backlog.and_then(Option::take) {
                work.push((start, Way::Results(backlog)));
            }
        }
        // The only kernel needs no thread of its own.
        match work.len() {
            1 => work.into_iter().map(|(start, way)| self.alone(start, way.into())).collect(),
            _ if self.coordinator.on_one_thread() => self.in_turns(work, || ()),
            _ => self.together(work, || ()),
        }
    }

    /// Kernels send their events to this thread, which merges them; the only kernel of a job runs on this thread and
    /// hands its events straight to the sink.
    fn ordered(
        self,
        mut starting: Vec<Start<'a>>,
        feeders: Vec<Feeder>,
        merger: &mut Merger,
        sink: &mut dyn Sink,
    ) -> Vec<Lived> {
        if starting.len() == 1
            && let Some(start) = starting.pop()
        {
            return vec![self.alone(start, Target::Direct { merger, sink })];
        }
        let feeders = feeders.into_iter().filter_map(|feeder| {
            let at = starting.iter().position(|start| start.channel.number == feeder.rank)?;
            Some((starting.swap_remove(at), Way::Queue(feeder)))
        });
        let work: Vec<_> = feeders.collect();
        if self.coordinator.on_one_thread() {
            return self.in_turns(work, || merger.pump(sink, || self.coordinator.abort()));
        }
        self.together(work, || merger.run(sink, || self.coordinator.abort()))
    }

    /// Runs the only kernel of a job on this thread.
    fn alone<'k>(self, start: Start<'k>, target: Target<'k>) -> Lived
    where
        'a: 'k,
    {
        self.coordinator.set_single();
        let (kernel, at, reset) = self.started(start, target, Switch::Thread);
        kernel.live(at, reset)
    }

    /// A kernel as it starts, with its program.
    fn started<'k>(self, start: Start<'k>, target: Target<'k>, switch: Switch<'k>) -> (Kernel<'k>, At, Option<bool>)
    where
        'a: 'k,
    {
        let Start { channel, progress, at, before, reset } = start;
        let mut kernel = self.kernel(channel, progress, target, switch);
        if let Some((now, carried)) = before {
            (kernel.channel.at.clock, kernel.channel.at.micro) = now;
            if let Some(carried) = carried {
                kernel.take_over(carried);
            }
        }
        (kernel, at, reset)
    }

    /// A thread for each kernel; meanwhile this one does something else.
    fn together(self, work: Vec<(Start<'_>, Way<'_>)>, meanwhile: impl FnOnce()) -> Vec<Lived> {
        let (coordinator, control) = (self.coordinator, self.control);
        std::thread::scope(|scope| {
            let mut running = Vec::new();
            for (start, way) in work {
                let number = start.channel.number;
                let work = move || {
                    let (kernel, at, reset) = self.started(start, way.into(), Switch::Thread);
                    guarded(kernel, at, reset, coordinator)
                };
                let mut thread = std::thread::Builder::new().name(format!("kernel-{number}"));
                if self.job.macros().is_some() {
                    thread = thread.stack_size(counterpoint_emulator::macros::STACK);
                }
                match thread.spawn_scoped(scope, work) {
                    Ok(handle) => running.push(handle),
                    Err(_) => {
                        // The operating system refuses a thread: the job cannot be run and counts as cancelled.
                        control.cancel();
                        coordinator.done(number, |_| ());
                    }
                }
            }
            meanwhile();
            let join = |handle: std::thread::ScopedJoinHandle<'_, Lived>| match handle.join() {
                Ok(lived) => lived,
                // A mistake of this program: the job's owner gets it, after all kernels have come to their end.
                Err(panic) => std::panic::resume_unwind(panic),
            };
            running.into_iter().map(join).collect()
        })
    }
}

/// Runs a kernel; if it panics, all others are stopped and the panic goes on to whoever joins.
fn guarded(kernel: Kernel<'_>, at: At, reset: Option<bool>, coordinator: &Coordinator) -> Lived {
    let rank = kernel.channel.at.channel;
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| kernel.live(at, reset))).unwrap_or_else(|panic| {
        coordinator.abort();
        coordinator.done(rank, |_| ());
        std::panic::resume_unwind(panic)
    })
}

fn master(t_ns: i64, kind: Kind) -> Event {
    Event { t_ns, micro: 0, dur_ns: 0, channel: 0, file: 0, line: 0, kind }
}

impl<'a> Shop<'a> {
    fn kernel<'k>(
        self,
        channel: &'k Channel,
        progress: &'k Progress,
        target: Target<'k>,
        switch: Switch<'k>,
    ) -> Kernel<'k>
    where
        'a: 'k,
    {
        let Self { job, plan, coordinator, files, control, given } = self;
        let coordinator = Port::new(coordinator, switch);
        let env = Environment {
            machine: &job.spec().machine,
            info: job.info(),
            sources: job.sources(),
            options: &job.spec().options,
            files,
            trace: Some(job.info().trace).filter(|letters| !letters.is_empty()),
        };
        let emitter = Emitter::new(channel.number, coordinator, target);
        let ports = Ports { coordinator, control, progress, emitter };
        let mut kernel = Kernel::new(Setup { env, ports, plan }, channel).with_macros(job.macros());
        for ((program, name, channel), at) in given.get().into_iter().flatten().zip(1..) {
            kernel.set_program_of(at, program, name, *channel);
        }
        kernel
    }
}
