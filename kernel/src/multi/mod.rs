//! Several kernels under a master.
//!
//! The thread that runs the job is the master kernel (#0): it starts the kernels, one thread each, merges their
//! streams into the log and closes the job. Facts: reference control-emulator.md 2.1, 2.4, 8.

pub(crate) mod coordinator;
pub(crate) mod merge;
pub(crate) mod shared;
pub(crate) mod tag;
pub(crate) mod verdict;
pub(crate) mod waits;

use coordinator::Coordinator;
use merge::{End, Feeder, Merger};
use shared::{Shared, Spindle};
use waits::Waits;

use crate::channel::plan::Plan;
use crate::channel::{
    Halt, Kernel,
    block::Block,
    emit::{Emitter, Target},
    flow::Flow,
    life, state,
    variables::ChannelVariables,
};
use crate::control::{Control, Progress, State};
use crate::files::Files;
use crate::job::{Job, Outcome, Sink};
use crate::log::event::{Diagnostic, Event, FileId, Kind, Phase, Verdict, VerdictKind};
use crate::machine::model::Channel;
use crate::mcd::program::Range;

/// Runs a prepared job; returns when every kernel has ended and the sink has the whole log.
pub(crate) fn run(job: &Job, files: &dyn Files, control: &Control, sink: &mut dyn Sink) -> Outcome {
    let spec = job.spec();
    let machine = &*spec.machine;
    let count = machine.channels.len();
    let plan = Plan::new(machine, &spec.options.opskip);
    let ranks = machine.channels.iter().map(|c| c.number);
    let (mut merger, feeders, sender) = Merger::new(ranks, spec.options.limits.events);
    let shared = Shared { spindles: vec![Spindle::default(); machine.spindles.len()], ..Shared::default() };
    let waits = Waits::new(count, machine.sync.release_ns);
    let coordinator = Coordinator::new(count, usize::from(spec.options.threads), shared, waits, sender);
    let mut refused = !merger.direct(&master(0, Kind::Lifecycle(Phase::MachineStart)), sink);
    let fallback = Progress::default();
    let mut starting = Vec::new();
    for (index, (channel, feeder)) in machine.channels.iter().zip(feeders).enumerate() {
        let progress = control.progress().get(index).unwrap_or(&fallback);
        match job.info().channel(channel.number).filter(|c| !c.program.is_empty()) {
            Some(start) => {
                let range = Range { number: None, first: start.lines.0, last: start.lines.1 };
                let name: Box<str> = start.program.clone().into();
                starting.push(Start { channel, progress, feeder, at: (start.file, range, name) });
            }
            None => {
                progress.set_state(State::NotStarted);
                let event = Event { channel: channel.number, ..master(0, Kind::Lifecycle(Phase::NotStarted)) };
                refused |= !merger.direct(&event, sink);
                life::never_started(&coordinator, channel.number);
                coordinator.closed(channel.number);
            }
        }
    }
    if refused {
        coordinator.abort();
    }
    let shared = Shop { job, plan: &plan, coordinator: &coordinator, files, control };
    let halts = if starting.len() == 1 {
        starting.into_iter().map(|start| shared.alone(start, &mut merger, sink)).collect()
    } else {
        shared.together(starting, &mut merger, sink)
    };
    refused |= merger.end() == End::Refused;
    let full = merger.end() == End::Full;
    if full {
        for event in full_log(&merger, spec.options.limits.events) {
            refused |= !merger.direct(&event, sink);
        }
    }
    let (t_ns, micro) = merger.last;
    // How far a thread got beyond a cut of the log is chance; only what is in the log counts.
    for (channel, halt) in halts {
        if merger.ended(channel) {
            continue;
        }
        let phase = if halt == Halt::Blocked && !full { Phase::Blocked } else { Phase::Stopped };
        if !refused {
            let event = Event { micro, channel, ..master(t_ns, Kind::Lifecycle(phase)) };
            refused = !merger.direct(&event, sink);
        }
    }
    if !refused {
        let close = Event { micro, ..master(t_ns, Kind::Lifecycle(Phase::MachineEnd)) };
        refused = !merger.direct(&close, sink);
    }
    Outcome { events: merger.next_seq - 1, cancelled: control.cancelled(), sink_failed: refused }
}

/// A kernel about to start.
struct Start<'a> {
    channel: &'a Channel,
    progress: &'a Progress,
    feeder: Feeder,
    at: (FileId, Range, Box<str>),
}

/// What all kernels of a job work with.
#[derive(Clone, Copy)]
struct Shop<'a> {
    job: &'a Job,
    plan: &'a Plan,
    coordinator: &'a Coordinator,
    files: &'a dyn Files,
    control: &'a Control,
}

impl Shop<'_> {
    /// The only kernel of a job runs on this thread and hands its events straight to the sink.
    fn alone<'a>(self, start: Start<'a>, merger: &'a mut Merger, sink: &'a mut dyn Sink) -> (u16, Halt)
    where
        Self: 'a,
    {
        let Start { channel, progress, at, .. } = start;
        let kernel = self.kernel(channel, progress, Target::Direct { merger, sink });
        (channel.number, kernel.live(at))
    }

    /// A thread for each kernel; this one merges their streams.
    fn together(self, starting: Vec<Start<'_>>, merger: &mut Merger, sink: &mut dyn Sink) -> Vec<(u16, Halt)> {
        let (coordinator, control) = (self.coordinator, self.control);
        std::thread::scope(|scope| {
            let mut running = Vec::new();
            for Start { channel, progress, feeder, at } in starting {
                let number = channel.number;
                let work = move || {
                    let kernel = self.kernel(channel, progress, Target::Queue(feeder));
                    guarded(kernel, at, coordinator)
                };
                match std::thread::Builder::new().name(format!("kernel-{number}")).spawn_scoped(scope, work) {
                    Ok(handle) => running.push((number, handle)),
                    Err(_) => {
                        // The operating system refuses a thread: the job cannot be run and counts as cancelled.
                        control.cancel();
                        coordinator.closed(number);
                        coordinator.done(&mut coordinator.lock(), number);
                    }
                }
            }
            merger.run(sink, || coordinator.abort());
            let join = |(number, handle): (u16, std::thread::ScopedJoinHandle<'_, Halt>)| match handle.join() {
                Ok(halt) => (number, halt),
                // A mistake of this program: the job's owner gets it, after all kernels have come to their end.
                Err(panic) => std::panic::resume_unwind(panic),
            };
            running.into_iter().map(join).collect()
        })
    }
}

/// Runs a kernel; if it panics, all others are stopped and the panic goes on to whoever joins.
fn guarded(kernel: Kernel<'_>, start: (FileId, Range, Box<str>), coordinator: &Coordinator) -> Halt {
    let rank = kernel.rank;
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| kernel.live(start))).unwrap_or_else(|panic| {
        coordinator.abort();
        coordinator.closed(rank);
        coordinator.done(&mut coordinator.lock(), rank);
        std::panic::resume_unwind(panic)
    })
}

fn master(t_ns: i64, kind: Kind) -> Event {
    Event { t_ns, micro: 0, dur_ns: 0, channel: 0, file: 0, line: 0, kind }
}

/// The verdict when the log holds as many events as it may.
fn full_log(merger: &Merger, limit: u64) -> [Event; 2] {
    let (t_ns, micro) = merger.last;
    let text: Box<str> = format!("the log has reached its limit of {limit} events").into();
    let facts = &crate::diag::LIMIT_REACHED;
    let diagnostic = Diagnostic { number: facts.number, severity: facts.severity, text: text.clone() };
    let verdict = Verdict { kind: VerdictKind::Limit, at_ns: t_ns, text, members: Vec::new() };
    [Kind::Diagnostic(Box::new(diagnostic)), Kind::Verdict(Box::new(verdict))]
        .map(|kind| Event { micro, ..master(t_ns, kind) })
}

impl<'a> Shop<'a> {
    fn kernel<'k>(self, channel: &'k Channel, progress: &'k Progress, target: Target<'k>) -> Kernel<'k>
    where
        'a: 'k,
    {
        let Self { job, plan, coordinator, files, control } = self;
        let machine = &*job.spec().machine;
        let spindle = channel.spindle.and_then(|number| machine.spindles.iter().position(|s| s.number == number));
        let shared =
            machine.channels.iter().filter(|c| c.spindle.is_some() && c.spindle == channel.spindle).count() > 1;
        Kernel {
            machine,
            info: job.info(),
            options: &job.spec().options,
            files,
            plan,
            coordinator,
            control,
            progress,
            emitter: Emitter::new(channel.number, coordinator, target),
            rank: channel.number,
            clock: 0,
            micro: 0,
            file: 0,
            line: 0,
            block: Block::default(),
            as_data: None,
            mode_changed: false,
            modal: state::Modal::new(machine),
            place: state::Place::new(machine, channel),
            spindle: state::SpindleState { index: spindle, shared, ..state::SpindleState::default() },
            flow: Flow::default(),
            variables: ChannelVariables::default(),
            secondary: false,
            blocks: 0,
            idle_blocks: 0,
            diagnostics: 0,
            stripped: Vec::new(),
        }
    }
}
