//! One run of all kernels after the other: Machine Shutdown may start the machine again with another file.
//!
//! Facts: reference control-emulator.md 5.8. Invariant: between two rounds no kernel runs. The next round starts at the
//! time at which the log of the previous round ended, one microstep later, so the log stays in order.

use super::again::Again;
use super::channels::Channels;
use super::coordinator::Coordinator;
use super::master::Master;
use super::shared::{SharedSpindle, SharedState};
use super::{Assembly, KernelStart};
use crate::prepared::Job;
use counterpoint_emulator::channel::carried::{CarriedState, Lived};
use counterpoint_event::event::{Event, FileId, Kind, Phase};
use counterpoint_fault::Halt;
use counterpoint_machine::Machine;
use counterpoint_machine::model::ChuckAtStart;
use counterpoint_program::presets;
use counterpoint_program::spec::Spec;
use counterpoint_sync::chucks::{Chuck, ChuckPair, WorkPiece};
use counterpoint_sync::merge::MergerMessage;
use counterpoint_sync::races::RaceDetector;
use counterpoint_sync::tag::Tag;
use counterpoint_sync::waits::JobWaits;
use counterpoint_waits::{of_axis, rules};

/// How often Machine Shutdown may start the machine again.
const MOST: u32 = 1000;

/// A run of all kernels, and its initial data.
#[derive(Default)]
pub(super) struct MachineRun {
    /// How often the machine has been started again.
    number: u32,
    /// Time and microstep at which it begins.
    pub(super) at: (i64, u32),
    master: Option<Master>,
    again: Option<Again>,
    carried: Vec<CarriedState>,
    shared: Option<SharedState>,
    /// Meetings so far.
    sync_points: u64,
}

impl MachineRun {
    /// The coordinator of its kernels; those of a job with stepping share one thread.
    pub(super) fn coordinator(
        &mut self,
        job: &Job,
        (stepped, messages): (bool, Option<crossbeam_channel::Sender<MergerMessage>>),
    ) -> Coordinator {
        let Spec { machine, options, .. } = job.spec();
        let fresh = || SharedState {
            variables: kept_by_machine(machine).chain(presets(job)).collect(),
            spindles: vec![SharedSpindle::default(); machine.spindles.len()],
            chucks: chucks(machine),
            ..SharedState::default()
        };
        let shared = self.shared.take().unwrap_or_else(fresh);
        let channels = Channels::new(machine.channels.iter().map(|channel| channel.number));
        let mut waits = JobWaits::new(channels.clone(), rules(machine), machine.sync.release_ns);
        waits.timeless = options.lint;
        for (axis, master) in machine.axes.entries().filter_map(|(axis, row)| Some((axis, row.master?))) {
            waits.hold(master, of_axis(axis));
        }
        let threads = if stepped { 1 } else { usize::from(options.threads) };
        let coordinator = Coordinator::new(channels.clone(), threads, shared, waits, messages);
        let races = (!options.races.is_off() && channels.count() > 1).then(|| Box::new(RaceDetector::new(channels)));
        coordinator.unordered(|order| (order.sync_points, order.races) = (self.sync_points, races));
        coordinator
    }
}

/// The chucks of a machine when its programs begin.
fn chucks(machine: &Machine) -> Option<ChuckPair> {
    let (main, sub) = machine.chucks()?;
    let of = |spindle| match machine.spindles[spindle].chuck {
        Some(ChuckAtStart::Bar) => Chuck { open: false, piece: Some(WorkPiece::Bar) },
        Some(ChuckAtStart::Part) => Chuck { open: false, piece: Some(WorkPiece::Part) },
        Some(ChuckAtStart::Open) => Chuck { open: true, piece: None },
        Some(ChuckAtStart::Empty) | None => Chuck { open: false, piece: None },
    };
    Some(ChuckPair {
        main: of(main),
        sub: of(sub),
        joined: false,
        away: machine.spindles[sub].slide.is_none(),
        relief: 0.0,
    })
}

/// Values of common variables that the machine has kept.
fn kept_by_machine(machine: &Machine) -> impl Iterator<Item = (u32, f64)> {
    let shared = |number: u32| machine.variables.shared.iter().any(|&(first, last)| (first..=last).contains(&number));
    machine.variables.system.initial.iter().copied().filter(move |&(number, _)| shared(number))
}

/// Values of common variables that the programs of the job bring with them.
fn presets(job: &Job) -> impl Iterator<Item = (u32, f64)> {
    let machine = &*job.spec().machine;
    let programs = job.info().channels.iter().filter(|channel| !channel.program.is_empty());
    let mut files: Vec<(FileId, usize, &Machine)> = programs
        .map(|channel| {
            let begins = machine.of_channel(channel.number);
            (channel.file, machine.reader_for(begins.preprocessor), begins)
        })
        .collect();
    files.dedup_by_key(|(file, reader, _)| (*file, *reader));
    let sources =
        files.into_iter().filter_map(|(file, reader, begins)| Some((job.sources().read_by(reader, file)?, begins)));
    sources.flat_map(|(source, begins)| presets::of(machine, begins, source))
}

impl<'a> Assembly<'a> {
    /// Starts the machine, or starts it again: the kernels that have something to do.
    pub(super) fn begin(self, round: &mut MachineRun, log: &mut dyn FnMut(&Event) -> bool) -> Vec<KernelStart<'a>> {
        let Some(again) = round.again.take() else {
            round.master = self.master_startup(log);
            log(&super::master(0, Kind::Lifecycle(Phase::MachineStart)));
            return self.starting(round.master.as_ref(), log);
        };
        let mut starting = Vec::new();
        for (index, channel) in self.job.spec().machine.channels.iter().enumerate() {
            let progress = self.control.progress().get(index).unwrap_or(self.control.spare());
            let carried = round.carried.iter().position(|carried| carried.channel == channel.number);
            let carried = carried.map(|at| round.carried.swap_remove(at));
            match again.programs.iter().find(|(number, _)| *number == channel.number) {
                Some((_, at)) => {
                    let reset = carried.is_some().then_some(again.reset);
                    let before = Some((round.at, carried));
                    starting.push(KernelStart { channel, progress, at: Some(at.clone()), before, reset });
                }
                None => {
                    // It may get a program the next time.
                    round.carried.extend(carried);
                    self.coordinator.never_started(channel.number);
                }
            }
        }
        starting
    }

    /// Ends the round: logs how channels without an end in the log were stopped, and runs Machine Shutdown. The
    /// progress of a thread beyond a cut of the log is random; only the content of the log counts. Returns the next
    /// round, if there is one.
    pub(super) fn close(
        self,
        mut round: MachineRun,
        lived: Vec<Lived>,
        (t_ns, micro): (i64, u32),
        log: &mut dyn FnMut(&Event) -> bool,
    ) -> Option<MachineRun> {
        let stop = self.coordinator.stop_tag();
        self.coordinator.unordered(|order| order.shared.files.close(stop));
        let ended = |one: &Lived| one.ended.is_some_and(|tag| tag <= stop);
        let all = lived.iter().all(|one| matches!(one.halt, Halt::ProgramEnd(_)) && ended(one));
        for Lived { channel, halt, .. } in lived.iter().filter(|one| !ended(one)) {
            let phase = if *halt == Halt::Blocked { Phase::Blocked } else { Phase::Stopped };
            log(&Event { micro, channel: *channel, ..super::master(t_ns, Kind::Lifecycle(phase)) });
        }
        let wrong = match () {
            () if !all || self.control.cancelled() => Some("not every channel has reached the end of its program"),
            () if round.number >= MOST => Some("it has already been restarted 1000 times"),
            () => None,
        };
        let again = self.master_shutdown(&mut round.master, wrong, (t_ns, micro), log);
        self.coordinator.unordered(|order| order.shared.files.close(Tag::END));
        let Some(again) = again.filter(|_| !self.control.cancelled()) else {
            log(&Event { micro, ..super::master(t_ns, Kind::Lifecycle(Phase::MachineEnd)) });
            return None;
        };
        let mut carried = round.carried;
        carried.extend(lived.into_iter().filter_map(|one| one.left).map(|left| *left));
        let (shared, sync_points) =
            self.coordinator.unordered(|order| (std::mem::take(&mut order.shared), order.sync_points));
        Some(MachineRun {
            number: round.number + 1,
            at: (t_ns, micro.saturating_add(1)),
            master: round.master,
            again: Some(again),
            carried,
            shared: Some(shared),
            sync_points,
        })
    }
}
