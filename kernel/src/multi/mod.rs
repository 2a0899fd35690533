//! Several kernels under a master.
//!
//! The thread that runs the job is the master kernel (#0): it starts the kernels, one thread each, brings their streams
//! together (as one ordered log, or only as results) and closes the job. Facts: reference control-emulator.md 2.1, 2.4, 8.

pub(crate) mod coordinator;
pub(crate) mod feed;
mod master;
pub(crate) mod merge;
pub(crate) mod shared;
pub(crate) mod tag;
pub(crate) mod verdict;
pub(crate) mod waits;

use std::sync::OnceLock;

use counterpoint_lang::pattern::Memory;
use crossbeam_channel::Sender;

use coordinator::Coordinator;
use feed::Feed;
use master::Master;
use merge::{End, Feeder, Merger, Message};
use shared::{Shared, Spindle};
use waits::Waits;

use crate::action::sync::Known;
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
use crate::job::{Job, Outcome, Sink, Spec};
use crate::log::event::{Event, FileId, Kind, Phase};
use crate::log::fold::Folds;
use crate::machine::model::Channel;
use crate::mcd::program::Range;

/// Runs a prepared job; returns when every kernel has ended and the whole log has been received.
pub(crate) fn run(job: &Job, files: &dyn Files, control: &Control, sink: &mut dyn Sink) -> Outcome {
    match sink.folds() {
        Some(folds) => folded(job, files, control, folds),
        None => ordered(job, files, control, sink),
    }
}

/// Runs a job whose events go into its results, channel by channel.
fn folded(job: &Job, files: &dyn Files, control: &Control, folds: &mut Folds) -> Outcome {
    let machine = &*job.spec().machine;
    let (plan, coordinator) = (Plan::new(machine, &job.spec().options.opskip), coordinator(job, None));
    let given = OnceLock::new();
    let shop = Shop { job, plan: &plan, coordinator: &coordinator, files, control, given: &given };
    let mut count = 0;
    let mut log = |event: &Event| {
        count += 1;
        folds.event(event);
        true
    };
    let kernel_0 = shop.master_startup(&mut log);
    log(&master(0, Kind::Lifecycle(Phase::MachineStart)));
    let starting = shop.starting(kernel_0.as_ref(), &mut log);
    let mut feeds: Vec<Feed> = folds.lanes().into_iter().map(|lane| Feed::new(lane.number, lane)).collect();
    let halts = shop.folded(starting, &mut feeds);
    let stop = coordinator.stop_tag();
    let (mut lanes, mut last, mut events) = (Vec::new(), (0, 0), 0);
    for feed in feeds {
        let (lane, count, end) = feed.close(stop);
        last = last.max(end);
        events += count;
        lanes.push(lane);
    }
    let ended: Vec<u16> = lanes.iter().filter(|lane| lane.ended()).map(|lane| lane.number).collect();
    folds.join(lanes);
    let mut log = |event: &Event| {
        count += 1;
        folds.event(event);
        true
    };
    close(shop, halts.iter().filter(|(channel, _)| !ended.contains(channel)), kernel_0, last, &mut log);
    Outcome { events: count + events, cancelled: control.cancelled(), sink_failed: false }
}

/// Runs a job whose events become one ordered log.
fn ordered(job: &Job, files: &dyn Files, control: &Control, sink: &mut dyn Sink) -> Outcome {
    let machine = &*job.spec().machine;
    let (mut merger, feeders, sender) = Merger::new(machine.channels.iter().map(|c| c.number));
    let (plan, coordinator) = (Plan::new(machine, &job.spec().options.opskip), coordinator(job, Some(sender)));
    let given = OnceLock::new();
    let shop = Shop { job, plan: &plan, coordinator: &coordinator, files, control, given: &given };
    let mut seq = 0;
    let mut log = |event: &Event| {
        seq += 1;
        sink.events(seq, std::slice::from_ref(event))
    };
    let mut refused = false;
    let mut note = |event: &Event| {
        refused |= !log(event);
        !refused
    };
    let kernel_0 = shop.master_startup(&mut note);
    let begun = note(&master(0, Kind::Lifecycle(Phase::MachineStart)));
    let starting = shop.starting(kernel_0.as_ref(), &mut note);
    if refused || !begun {
        coordinator.abort();
    }
    merger.next_seq = seq + 1;
    let halts = shop.ordered(starting, feeders, &mut merger, sink);
    refused |= !begun || merger.end() == End::Refused;
    let mut next = merger.next_seq;
    let mut log = |event: &Event| {
        if !refused {
            refused = !sink.events(next, std::slice::from_ref(event));
            next += 1;
        }
        !refused
    };
    let ended = merger.ended();
    close(shop, halts.iter().filter(|(channel, _)| !ended.contains(channel)), kernel_0, merger.last, &mut log);
    Outcome { events: next - 1, cancelled: control.cancelled(), sink_failed: refused }
}

fn coordinator(job: &Job, messages: Option<Sender<Message>>) -> Coordinator {
    let Spec { machine, options, .. } = job.spec();
    let shared = Shared { spindles: vec![Spindle::default(); machine.spindles.len()], ..Shared::default() };
    let waits = Waits::new(machine.channels.len(), machine.sync.release_ns);
    Coordinator::new(machine.channels.len(), usize::from(options.threads), shared, waits, messages)
}

/// Logs how channels without an end in the log came to a stand, and the end of the master. How far a thread got beyond
/// a cut of the log is chance; only what is in the log counts.
fn close<'h>(
    shop: Shop<'_>,
    halts: impl Iterator<Item = &'h (u16, Halt)>,
    kernel_0: Option<Master>,
    (t_ns, micro): (i64, u32),
    log: &mut dyn FnMut(&Event) -> bool,
) {
    for &(channel, halt) in halts {
        let phase = if halt == Halt::Blocked { Phase::Blocked } else { Phase::Stopped };
        log(&Event { micro, channel, ..master(t_ns, Kind::Lifecycle(phase)) });
    }
    shop.master_shutdown(kernel_0, (t_ns, micro), log);
    log(&Event { micro, ..master(t_ns, Kind::Lifecycle(Phase::MachineEnd)) });
}

/// A kernel about to start.
struct Start<'a> {
    channel: &'a Channel,
    progress: &'a Progress,
    at: (FileId, Range, Box<str>),
}

/// Where the events of a kernel on its own thread go.
enum Way<'a> {
    Queue(Feeder),
    Lane(&'a mut Feed),
}

impl<'a> From<Way<'a>> for Target<'a> {
    fn from(way: Way<'a>) -> Self {
        match way {
            Way::Queue(feeder) => Self::Queue(feeder),
            Way::Lane(feed) => Self::Lane(feed),
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
    /// Programs of the kernels as Machine Startup left them, by kernel; nothing without a master.
    given: &'a OnceLock<Vec<String>>,
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
                Some(at) => starting.push(Start { channel, progress, at }),
                None => {
                    progress.set_state(State::NotStarted);
                    log(&Event { channel: channel.number, ..master(0, Kind::Lifecycle(Phase::NotStarted)) });
                    life::never_started(coordinator, channel.number);
                    coordinator.closed(channel.number);
                }
            }
        }
        starting
    }

    /// Every kernel feeds the results of its own channel.
    fn folded(self, starting: Vec<Start<'_>>, feeds: &mut [Feed]) -> Vec<(u16, Halt)> {
        let mut free: Vec<Option<&mut Feed>> = feeds.iter_mut().map(Some).collect();
        let mut work = Vec::new();
        for start in starting {
            let feed = free.iter_mut().find(|f| f.as_ref().is_some_and(|f| f.rank == start.channel.number));
            if let Some(feed) = feed.and_then(Option::take) {
                work.push((start, Way::Lane(feed)));
            }
        }
        // The only kernel needs no thread of its own.
        match work.len() {
            1 => work.into_iter().map(|(start, way)| self.alone(start, way.into())).collect(),
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
    ) -> Vec<(u16, Halt)> {
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
        self.together(work, || merger.run(sink, || self.coordinator.abort()))
    }

    /// Runs the only kernel of a job on this thread.
    fn alone<'k>(self, start: Start<'k>, target: Target<'k>) -> (u16, Halt)
    where
        'a: 'k,
    {
        let Start { channel, progress, at } = start;
        self.coordinator.set_single();
        (channel.number, self.kernel(channel, progress, target).live(at))
    }

    /// A thread for each kernel; meanwhile this one does something else.
    fn together(self, work: Vec<(Start<'_>, Way<'_>)>, meanwhile: impl FnOnce()) -> Vec<(u16, Halt)> {
        if let [(a, _), (b, _)] = &work[..] {
            self.coordinator.set_pair(a.channel.number, b.channel.number);
        }
        let (coordinator, control) = (self.coordinator, self.control);
        std::thread::scope(|scope| {
            let mut running = Vec::new();
            for (Start { channel, progress, at }, way) in work {
                let number = channel.number;
                let work = move || guarded(self.kernel(channel, progress, way.into()), at, coordinator);
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
            meanwhile();
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

impl<'a> Shop<'a> {
    fn kernel<'k>(self, channel: &'k Channel, progress: &'k Progress, target: Target<'k>) -> Kernel<'k>
    where
        'a: 'k,
    {
        let Self { job, plan, coordinator, files, control, given } = self;
        let machine = &*job.spec().machine;
        let spindle = channel.spindle.and_then(|number| machine.spindles.iter().position(|s| s.number == number));
        let shared = spindle.is_some_and(|index| crate::action::spindles::is_shared(machine, index));
        let mut kernel = Kernel {
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
            meetings: Known::default(),
            macros: None,
            stripped: Vec::new(),
            trace: Some(job.info().trace).filter(|letters| !letters.is_empty()),
            raised: rustc_hash::FxHashMap::default(),
            edited: None,
            cycle: crate::action::cycle::State::new(machine),
            states: Box::new(crate::action::states::States::new(machine, channel)),
            tape: (plan.tape.as_ref().map(|tape| tape.start).unwrap_or_default(), Memory::default()),
        }
        .with_macros(job.macros());
        for (program, at) in given.get().into_iter().flatten().zip(1..) {
            kernel.tell_program(at, program);
        }
        kernel
    }
}
