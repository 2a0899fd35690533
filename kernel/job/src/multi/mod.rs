//! Several kernels under a master.
//!
//! The thread that runs the job is the master kernel (#0). It starts the kernels, one thread each, and combines their
//! results. It merges their events into the ordered log if a log is requested, and closes the job. Facts: reference
//! control-emulator.md 2.1, 2.4, 8.

mod again;
mod master;
mod one_thread;
mod rounds;

use counterpoint_sync::{backlog, channels, coordinator, merge, shared, stream};
use std::sync::OnceLock;

use again::At;
use backlog::Backlog;
use coordinator::Coordinator;
use coordinator::switch::Port;
use coordinator::wait_method::WaitMethod;
use master::Master;
use merge::{Feeder, MergeEnd, Merger};
use rounds::MachineRun;
use stream::EventStream;

use crate::prepared::Job;
use crate::step::Director;
use counterpoint_channel::channel_context::RunEnvironment;
use counterpoint_channel::emitter::{ChunkTarget, Emitter};
use counterpoint_emulator::channel::Kernel;
use counterpoint_emulator::channel::carried::{CarriedState, Lived};
use counterpoint_emulator::channel::components::PreparedComponent;
use counterpoint_emulator::channel::parts::{Ports, Setup};
use counterpoint_emulator::channel::plan::ExecutionPlan;
use counterpoint_event::RunEnd;
use counterpoint_event::event::{Event, Kind, Phase, SourcePlace};
use counterpoint_machine::model::Channel;
use counterpoint_ports::control::{ChannelActivity, ChannelProgress, JobControl};
use counterpoint_ports::files::JobFiles;
use counterpoint_ports::step::Stepper;
use counterpoint_program::shape::ProgramRange;
use counterpoint_sync::order::idle::StartableProgram;
use counterpoint_sync::sink::{LogSink, WrittenFiles};
use counterpoint_sync::tag::Tag;

/// Runs a prepared job; returns when every kernel has ended and the whole log has been received.
pub(crate) fn run(job: &Job, files: &dyn JobFiles, control: &JobControl, sink: &mut dyn LogSink) -> RunEnd {
    let machine = &*job.spec().machine;
    let (plan, plans) = job.plans();
    let components = job.components(&plans);
    let (given, mut round) = (OnceLock::new(), Some(MachineRun::default()));
    let director = control.console().map(|console| Director::new(console, control, (job.info(), machine)));
    let mut written = WrittenFiles::new();
    let mut log = LogOutput::new(sink);
    while let Some(mut now) = round.take() {
        let numbers = machine.channels.iter().map(|channel| channel.number);
        let (merging, sender) = match log.logged.then(|| Merger::new(numbers, job.info().room.waiting)) {
            Some((merger, feeders, sender)) => (Some((merger, feeders)), Some(sender)),
            None => (None, None),
        };
        let coordinator = now.coordinator(job, (director.is_some(), sender));
        let (coordinator, components, director) = (&coordinator, components.as_slice(), director.as_ref());
        let assembly = Assembly { job, plan: &plan, components, coordinator, files, control, director, given: &given };
        let starting = assembly.begin(&mut now, &mut |event| log.note(event));
        if log.refused {
            coordinator.abort();
        }
        let mut backlogs = log.backlogs(job);
        let lived = match merging {
            Some((mut merger, feeders)) => {
                merger.next_seq = log.seq + 1;
                let lived = assembly.kernels(starting, &mut backlogs, Some((&mut merger, feeders)), log.sink);
                log.seq = merger.next_seq - 1;
                log.refused |= merger.end() == MergeEnd::Refused;
                lived
            }
            None => assembly.kernels(starting, &mut backlogs, None, log.sink),
        };
        let last = log.close(backlogs, coordinator.stop_tag()).max(now.at);
        round = assembly.close(now, lived, last, &mut |event| log.note(event));
        round = round.filter(|_| !log.refused);
        written = coordinator.written();
    }
    let outcome = RunEnd { events: log.count, cancelled: control.cancelled(), sink_failed: log.refused };
    sink.files(written);
    outcome
}

/// Results and log between the runs of the kernels.
struct LogOutput<'s> {
    sink: &'s mut dyn LogSink,
    /// Whether the ordered log is requested.
    logged: bool,
    /// Number of the last event that the sink has received.
    seq: u64,
    /// Events so far.
    count: u64,
    /// The sink takes no more events.
    refused: bool,
}

impl<'s> LogOutput<'s> {
    fn new(sink: &'s mut dyn LogSink) -> Self {
        let logged = sink.is_logged();
        Self { sink, logged, seq: 0, count: 0, refused: false }
    }

    /// Adds an event while no kernel runs. Returns `false` when the log takes nothing more.
    fn note(&mut self, event: &Event) -> bool {
        if self.refused {
            return false;
        }
        self.count += 1;
        if let Some(builder) = self.sink.results() {
            builder.event(event);
        }
        if self.logged {
            self.seq += 1;
            self.refused = !self.sink.events(self.seq, std::slice::from_ref(event));
        }
        !self.refused
    }

    /// The results that the kernels feed, by channel.
    fn backlogs(&mut self, job: &Job) -> Vec<Backlog> {
        let room = job.info().room.waiting;
        match self.sink.results() {
            Some(builder) => builder.split().into_iter().map(|of| Backlog::new(of.number, Some(of), room)).collect(),
            None => job.info().channels.iter().map(|channel| Backlog::new(channel.number, None, room)).collect(),
        }
    }

    /// Combines the results that the kernels have fed, up to the stop of the job. Returns time and microstep of the
    /// last event.
    fn close(&mut self, backlogs: Vec<Backlog>, stop: Tag) -> (i64, u32) {
        let (mut channels, mut last) = (Vec::new(), (0, 0));
        for closed in backlogs.into_iter().map(|backlog| backlog.close(stop)) {
            last = last.max(closed.last);
            self.count += closed.events;
            channels.extend(closed.results);
        }
        if let Some(builder) = self.sink.results() {
            builder.join(channels);
        }
        last
    }
}

/// A kernel about to start.
struct KernelStart<'a> {
    channel: &'a Channel,
    progress: &'a ChannelProgress,
    /// Its program; without one it waits until another channel starts it.
    at: Option<At>,
    /// After a restart of the machine: time and microstep, and the state that the kernel carries over.
    before: Option<((i64, u32), Option<CarriedState>)>,
    /// The kernel continues with another file, with or without resetting modal state.
    reset: Option<bool>,
}

/// The receivers of a kernel: the results of its channel, and the log if there is one.
type Feeds<'a> = (&'a mut Backlog, Option<Feeder>);

/// Data that all kernels of a job share.
#[derive(Clone, Copy)]
struct Assembly<'a> {
    job: &'a Job,
    plan: &'a ExecutionPlan,
    components: &'a [PreparedComponent<'a>],
    coordinator: &'a Coordinator,
    files: &'a dyn JobFiles,
    control: &'a JobControl,
    /// Chooses the next kernel in a job with stepping.
    director: Option<&'a Director<'a>>,
    /// Programs and channels of the kernels as Machine Startup left them, by kernel; nothing without a master.
    given: &'a OnceLock<Vec<master::KernelInput>>,
}

impl<'a> Assembly<'a> {
    /// The kernels that have a program or may be started; logs those that have none.
    fn starting(self, kernel_0: Option<&Master>, log: &mut dyn FnMut(&Event) -> bool) -> Vec<KernelStart<'a>> {
        let Self { job, coordinator, control, .. } = self;
        let mut starting = Vec::new();
        for (index, channel) in job.spec().machine.channels.iter().enumerate() {
            let progress = control.progress().get(index).unwrap_or(control.spare());
            let own = job.info().channel(channel.number).filter(|c| !c.program.is_empty()).map(|start| {
                let range = ProgramRange { number: None, first: start.lines.0, last: start.lines.1 };
                (start.file, range, start.program.clone().into())
            });
            let given =
                kernel_0.and_then(|master| master.programs.iter().find(|(number, _)| *number == channel.number));
            let at = given.map_or(own, |(_, at)| at.clone()).filter(|_| kernel_0.is_none_or(|master| master.good));
            if let Some((file, range, name)) = &at {
                let (lines, name) = ((range.first, range.last), (**name).into());
                coordinator
                    .unordered(|order| order.preselect(channel.number, StartableProgram { file: *file, lines, name }));
            } else {
                progress.set_state(ChannelActivity::NotStarted);
                log(&Event { channel: channel.number, ..master(0, Kind::Lifecycle(Phase::NotStarted)) });
            }
            starting.push(KernelStart { channel, progress, at, before: None, reset: None });
        }
        // Other channels start those without a program, if the control can do so and a channel runs.
        let can_start = job.spec().machine.sync.starts_channels() && starting.iter().any(|start| start.at.is_some());
        starting.retain(|start| {
            match &start.at {
                None if can_start => coordinator.idle(start.channel.number),
                None => coordinator.never_started(start.channel.number),
                Some(_) => {}
            }
            can_start || start.at.is_some()
        });
        starting
    }

    /// Runs the kernels. Each feeds the backlog of its channel; the log, if there is one, is merged on this thread.
    fn kernels(
        self,
        starting: Vec<KernelStart<'_>>,
        backlogs: &mut [Backlog],
        merging: Option<(&mut Merger, Vec<Feeder>)>,
        sink: &mut dyn LogSink,
    ) -> Vec<Lived> {
        let mut free: Vec<Option<&mut Backlog>> = backlogs.iter_mut().map(Some).collect();
        let mut work = Vec::new();
        for start in starting {
            let backlog = free.iter_mut().find(|b| b.as_ref().is_some_and(|b| b.channel == start.channel.number));
            work.extend(backlog.and_then(Option::take).map(|backlog| (start, backlog)));
        }
        let (merger, mut feeders) = merging.map_or((None, Vec::new()), |(merger, feeders)| (Some(merger), feeders));
        if work.len() == 1
            && let Some((start, backlog)) = work.pop()
        {
            // The only kernel needs no thread of its own, and no merging.
            return vec![match merger {
                Some(merger) => self.alone(start, EventStream::only(backlog, merger, sink)),
                None => self.alone(start, EventStream::new(backlog, None)),
            }];
        }
        let work = work.into_iter().map(|(start, backlog)| {
            let feeder = feeders.iter().position(|feeder| feeder.channel == start.channel.number);
            (start, (backlog, feeder.map(|at| feeders.swap_remove(at))))
        });
        let work: Vec<_> = work.collect();
        let abort = || self.coordinator.abort();
        match (merger, self.coordinator.on_one_thread()) {
            (Some(merger), true) => self.in_turns(work, || merger.pump(sink, abort)),
            (Some(merger), false) => self.together(work, || merger.run(sink, abort)),
            (None, true) => self.in_turns(work, || ()),
            (None, false) => self.together(work, || ()),
        }
    }

    /// Runs the only kernel of a job on this thread.
    fn alone<'k>(self, start: KernelStart<'k>, stream: EventStream<'k>) -> Lived
    where
        'a: 'k,
    {
        self.coordinator.set_single();
        let (kernel, at, reset) = self.started(start, stream, WaitMethod::Thread);
        kernel.live(at, reset)
    }

    /// A kernel as it starts, with its program.
    fn started<'k>(
        self,
        start: KernelStart<'k>,
        stream: EventStream<'k>,
        switch: WaitMethod<'k>,
    ) -> (Kernel<'k>, Option<At>, Option<bool>)
    where
        'a: 'k,
    {
        let KernelStart { channel, progress, at, before, reset } = start;
        let mut kernel = self.kernel(channel, progress, ChunkTarget::Stream(stream), switch);
        if let Some((now, carried)) = before {
            (kernel.channel.at.clock, kernel.channel.at.micro) = now;
            if let Some(carried) = carried {
                kernel.take_over(carried);
            }
        }
        (kernel, at, reset)
    }

    /// Runs a thread for each kernel; meanwhile this thread does other work.
    fn together(self, work: Vec<(KernelStart<'_>, Feeds<'_>)>, meanwhile: impl FnOnce()) -> Vec<Lived> {
        let (coordinator, control) = (self.coordinator, self.control);
        std::thread::scope(|scope| {
            let mut running = Vec::new();
            for (start, (backlog, feeder)) in work {
                let number = start.channel.number;
                let work = move || {
                    control.measured(|| {
                        let (kernel, at, reset) =
                            self.started(start, EventStream::new(backlog, feeder), WaitMethod::Thread);
                        guarded(kernel, at, reset, coordinator)
                    })
                };
                let mut thread = std::thread::Builder::new().name(format!("kernel-{number}"));
                if self.job.has_macros() {
                    thread = thread.stack_size(counterpoint_channel::macros::STACK);
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
                // A mistake of this program: the job's owner gets it, after all kernels have ended.
                Err(panic) => std::panic::resume_unwind(panic),
            };
            running.into_iter().map(join).collect()
        })
    }
}

/// Runs a kernel; if it panics, all others are stopped and the panic continues in the joining thread.
fn guarded(kernel: Kernel<'_>, at: Option<At>, reset: Option<bool>, coordinator: &Coordinator) -> Lived {
    let channel = kernel.channel.at.channel;
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| kernel.live(at, reset))).unwrap_or_else(|panic| {
        coordinator.abort();
        coordinator.done(channel, |_| ());
        std::panic::resume_unwind(panic)
    })
}

fn master(t_ns: i64, kind: Kind) -> Event {
    Event { t_ns, micro: 0, dur_ns: 0, channel: 0, file: 0, line: 0, caller: SourcePlace::NONE, kind }
}

impl<'a> Assembly<'a> {
    fn kernel<'k>(
        self,
        channel: &'k Channel,
        progress: &'k ChannelProgress,
        target: ChunkTarget<'k>,
        switch: WaitMethod<'k>,
    ) -> Kernel<'k>
    where
        'a: 'k,
    {
        let Self { job, plan, components, coordinator, files, control, director, given } = self;
        let own = components.iter().find(|component| component.channels.contains(&channel.number));
        let whole = &*job.spec().machine;
        let (machine, plan, macros) =
            own.map_or((whole, plan, job.macros()), |own| (own.machine, own.plan, own.macros));
        let coordinator = Port::new(coordinator, switch);
        let env = RunEnvironment {
            machine,
            whole,
            info: job.info(),
            sources: job.sources().seen_by(channel.number, whole.reader_for(machine.preprocessor)),
            options: &job.spec().options,
            files,
            trace: Some(job.info().trace).filter(|letters| !letters.is_empty()),
        };
        let emitter = Emitter::new(channel.number, coordinator, target);
        let stepper = director.map(|director| director as &dyn Stepper);
        let ports = Ports { coordinator, control, progress, stepper };
        let mut kernel = Kernel::new(Setup { env, emitter, ports, plan, components }, channel);
        counterpoint_macro_host::set_up(&mut kernel, macros);
        for ((program, name, channel), at) in given.get().into_iter().flatten().zip(1..) {
            counterpoint_macro_host::set_program_of(&mut kernel, at, program, name, *channel);
        }
        kernel
    }
}
