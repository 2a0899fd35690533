//! Stepping through a job: the next kernel, and the stops at which the run waits for a command.
//!
//! All kernels of such a job share one thread. They give it away before every block, and at breakpoints within a block,
//! so that the run stops as a whole. Invariants: only the order in which kernels take their turns is decided here, and
//! the log does not depend on it. So a stepped job has the log of an unstepped job (a reset excepted). A kernel that
//! waits here checks ten times a second whether the job is to end.

mod breakpoints;
mod decide;
mod report;

use counterpoint_event::SourcePlace;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use breakpoints::Breakpoints;
use counterpoint_event::info::Info;
use counterpoint_machine::Machine;
use counterpoint_ports::control::{ChannelActivity, JobControl};
use counterpoint_ports::step::{
    Common, Console, Go, Heard, KernelSnapshot, StepCalls, StepCommand, StepEvent, StepReply, Stepper, Whom,
};
use decide::{Decision, Standing, StepGoal};

/// Between two looks at whether the job is to end.
const LOOK: Duration = Duration::from_millis(100);

/// A kernel that has not ended, as the scheduler sees it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct KernelCandidate {
    pub(crate) channel: u16,
    /// It has something to do.
    pub(crate) ready: bool,
    /// It needs an empty chunk, which it gets when the others catch up.
    pub(crate) far_ahead: bool,
    /// It does nothing before this time, ns.
    pub(crate) bound: i64,
}

/// Chooses the kernel that continues, as the operator commands.
pub(crate) struct Director<'a> {
    console: &'a dyn Console,
    control: &'a JobControl,
    info: &'a Info,
    machine: &'a Machine,
    state: Mutex<StepState>,
}

/// A channel.
#[derive(Debug, Default)]
struct SteppedChannel {
    number: u16,
    /// Where it was seen last.
    seen: Option<KernelSnapshot>,
    /// It is before the block where it was seen; otherwise the block is in progress.
    at_block: bool,
    /// The breakpoints at that block have been looked at.
    looked: bool,
    /// Blocks that it still may begin in a step of all.
    left: u32,
    /// Deepest level of calls whose blocks count for the step; none: all count.
    deepest: Option<u32>,
    /// Feed hold.
    held: bool,
    /// It is to be reset.
    reset: bool,
    /// Number of the variables that were seen last.
    writes: Option<u64>,
}

/// State on which decisions are based.
struct StepState {
    channels: Vec<SteppedChannel>,
    goal: StepGoal,
    breakpoints: Breakpoints,
    /// The run stops at once: the channel that is the cause, and why.
    stop: Option<(u16, String)>,
    /// The channel that continued last, if it was too far ahead.
    ahead: Option<u16>,
    /// The operator has left.
    detached: bool,
}

impl StepState {
    fn channel(&mut self, number: u16) -> Option<&mut SteppedChannel> {
        self.channels.iter_mut().find(|channel| channel.number == number)
    }

    /// The channels that a command for one (0: for all) is about.
    fn these(&mut self, number: u16) -> impl Iterator<Item = &mut SteppedChannel> {
        self.channels.iter_mut().filter(move |channel| number == 0 || channel.number == number)
    }
}

impl<'a> Director<'a> {
    /// For a job that is before the first block of each channel.
    pub(crate) fn new(
        console: &'a dyn Console,
        control: &'a JobControl,
        (info, machine): (&'a Info, &'a Machine),
    ) -> Self {
        let channel = |number| SteppedChannel { number, ..SteppedChannel::default() };
        let state = StepState {
            channels: info.channels.iter().map(|of| channel(of.number)).collect(),
            goal: StepGoal::All,
            breakpoints: Breakpoints::default(),
            stop: None,
            ahead: None,
            detached: false,
        };
        Self { console, control, info, machine, state: Mutex::new(state) }
    }

    fn lock(&self) -> MutexGuard<'_, StepState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// State of a channel for the job.
    fn doing(&self, channel: u16) -> ChannelActivity {
        let index = self.info.channel_index(channel);
        index
            .and_then(|index| self.control.progress().get(index))
            .map_or(ChannelActivity::NotStarted, |now| now.state())
    }

    /// The kernel that continues; waits while the run is paused. `None`: none has anything to do.
    pub(crate) fn next(&self, kernels: &[KernelCandidate], common: &mut Common<'_>) -> Option<usize> {
        loop {
            let mut state = self.lock();
            if state.detached || self.control.cancelled() {
                return decide::furthest_behind(kernels, |_| true);
            }
            while !state.detached {
                match self.console.poll() {
                    Heard::Command(command) => self.obey(&mut state, command, common),
                    Heard::Nothing => break,
                    Heard::Gone => self.detach(&mut state),
                }
            }
            if state.detached {
                return decide::furthest_behind(kernels, |_| true);
            }
            if !kernels.iter().any(|kernel| kernel.ready) {
                return None;
            }
            let standing = Standing { kernels, waits: &|channel| self.doing(channel) == ChannelActivity::Waiting };
            match state.decide(&standing, self.info) {
                Decision::Run(at) => return Some(at),
                Decision::Stop(channel, reason) => self.stand(&mut state, (channel, reason), common),
            }
        }
    }

    /// Stops the run until a command lets it continue, the operator has left, or the job is to end.
    fn stand(&self, state: &mut StepState, (channel, reason): (u16, String), common: &mut Common<'_>) {
        state.goal = StepGoal::Stand;
        self.console.say(StepReply::Stopped(self.report(state, (channel, &reason), common)));
        while state.goal == StepGoal::Stand && !state.detached && !self.control.cancelled() {
            match self.console.wait(LOOK) {
                Heard::Command(command) => self.obey(state, command, common),
                Heard::Nothing => {}
                Heard::Gone => self.detach(state),
            }
        }
    }

    fn detach(&self, state: &mut StepState) {
        (state.detached, state.stop) = (true, None);
        self.control.end_steps();
    }

    /// Carries a command out and answers it.
    fn obey(&self, state: &mut StepState, command: StepCommand, common: &mut Common<'_>) {
        let runs = command.runs();
        let answer = match self.carried_out(state, command) {
            Ok(Some(said)) => said,
            Ok(None) if runs || state.detached => return,
            Ok(None) => StepReply::State(self.report(state, (0, ""), common)),
            Err(refusal) => StepReply::Refused(refusal),
        };
        self.console.say(answer);
    }

    fn carried_out(&self, state: &mut StepState, command: StepCommand) -> Result<Option<StepReply>, String> {
        if command.runs() && state.goal != StepGoal::Stand {
            return Err("the run has not stopped yet: pause it first".to_owned());
        }
        match command {
            StepCommand::Step { whom, blocks, calls: StepCalls::Out } => self.step_out(state, whom, blocks.max(1))?,
            StepCommand::Step { whom, blocks, calls } => {
                self.step(state, whom, blocks.max(1))?;
                for channel in &mut state.channels {
                    let level = channel.seen.as_ref().map_or(0, |seen| seen.level);
                    channel.deepest = (calls == StepCalls::Over).then_some(level);
                }
            }
            StepCommand::Continue => state.goal = StepGoal::Free,
            StepCommand::Pause if state.goal == StepGoal::Stand => {}
            StepCommand::Pause => state.stop = Some((0, "paused by the operator".to_owned())),
            StepCommand::Add(breakpoint) => {
                return Ok(Some(StepReply::Added(
                    state.breakpoints.add(breakpoint, |spot| breakpoints::may_hit(spot, self.info, self.machine))?,
                )));
            }
            StepCommand::Remove(id) => state.breakpoints.remove(id)?,
            StepCommand::Hold(channel) => {
                self.known(channel)?;
                state.these(channel).for_each(|channel| channel.held = true);
            }
            StepCommand::Resume(channel) => {
                self.known(channel)?;
                state.these(channel).for_each(|channel| channel.held = false);
            }
            StepCommand::Reset(channel) => {
                if channel == 0 {
                    return Err("a reset is for one channel: reset 1".to_owned());
                }
                self.runs(channel)?;
                if self.doing(channel) == ChannelActivity::Waiting {
                    return Err(format!(
                        "channel {channel} is waiting; reset it after its partner has arrived, before its next block"
                    ));
                }
                state.these(channel).for_each(|channel| channel.reset = true);
            }
            StepCommand::Show => {}
            StepCommand::Detach => self.detach(state),
        }
        Ok(None)
    }

    /// A block that is in progress is the first one of a step.
    fn step(&self, state: &mut StepState, whom: Whom, blocks: u32) -> Result<(), String> {
        let under_way = |channel: &SteppedChannel, waits: bool| {
            let doing = self.doing(channel.number);
            channel.seen.is_some()
                && !channel.at_block
                && (doing == ChannelActivity::Running || waits && doing == ChannelActivity::Waiting)
        };
        state.goal = match whom {
            // At a breakpoint within a block.
            Whom::Next => {
                StepGoal::Next(blocks - u32::from(state.channels.iter().any(|channel| under_way(channel, false))))
            }
            Whom::All => {
                for channel in &mut state.channels {
                    channel.left = blocks - u32::from(under_way(channel, true));
                }
                StepGoal::All
            }
            Whom::One(channel) => {
                self.runs(channel)?;
                if state.channel(channel).is_some_and(|channel| channel.held) {
                    return Err(format!("channel {channel} is on feed hold: resume it first"));
                }
                let under_way = state.channel(channel).is_some_and(|channel| under_way(channel, true));
                let blocks = blocks - u32::from(under_way);
                StepGoal::One { channel, blocks, stood: self.doing(channel) == ChannelActivity::Waiting }
            }
        };
        Ok(())
    }

    /// Runs the channels to the block after the return from this number of calls.
    fn step_out(&self, state: &mut StepState, whom: Whom, calls: u32) -> Result<(), String> {
        let inside = |channel: &SteppedChannel| channel.seen.as_ref().map_or(0, |seen| seen.level);
        let runs = |channel: &SteppedChannel| {
            matches!(self.doing(channel.number), ChannelActivity::Running | ChannelActivity::Waiting)
        };
        let meant = |channel: &SteppedChannel| match whom {
            Whom::One(number) => channel.number == number,
            Whom::Next | Whom::All => runs(channel) && inside(channel) > 0,
        };
        let whom = match whom {
            Whom::One(_) | Whom::All => whom,
            Whom::Next => {
                let behind = state.channels.iter().filter(|channel| meant(channel));
                let behind = behind.min_by_key(|channel| channel.seen.as_ref().map(|seen| seen.t_ns));
                behind.map_or(Whom::All, |channel| Whom::One(channel.number))
            }
        };
        if let Whom::One(number) = whom {
            self.runs(number)?;
        }
        if !state.channels.iter().any(|channel| meant(channel) && inside(channel) > 0) {
            return Err(match whom {
                Whom::One(number) => format!("channel {number} is in its main program: there is no call to leave"),
                Whom::Next | Whom::All => "every channel is in its main program: there is no call to leave".to_owned(),
            });
        }
        self.step(state, whom, 1)?;
        for channel in &mut state.channels {
            channel.left = 0;
            channel.deepest = inside(channel).checked_sub(calls).or(Some(0));
        }
        if let StepGoal::One { blocks, .. } = &mut state.goal {
            *blocks = 0;
        }
        Ok(())
    }

    /// The machine has this channel, or all are meant.
    fn known(&self, channel: u16) -> Result<(), String> {
        if channel == 0 || self.info.channel(channel).is_some() {
            return Ok(());
        }
        let numbers: Vec<String> = self.info.channels.iter().map(|channel| channel.number.to_string()).collect();
        Err(format!("the job has no channel {channel}; it has {}", numbers.join(", ")))
    }

    /// The channel has not ended.
    fn runs(&self, channel: u16) -> Result<(), String> {
        self.known(channel)?;
        match self.doing(channel) {
            ChannelActivity::NotStarted => Err(format!("channel {channel} has no program that runs")),
            ChannelActivity::Ready | ChannelActivity::Running | ChannelActivity::Waiting => Ok(()),
            ChannelActivity::Ended | ChannelActivity::Alarmed | ChannelActivity::Stopped | ChannelActivity::Blocked => {
                Err(format!("channel {channel} has ended"))
            }
        }
    }
}

impl Stepper for Director<'_> {
    fn stands(&self, place: &KernelSnapshot, first: bool, variables: (u64, &dyn Fn() -> Vec<(u32, f64)>)) -> bool {
        let news = self.console.has_news();
        self.lock().stands(place, (first, news), self.info, variables)
    }

    fn breaks_at(&self, place: SourcePlace) -> bool {
        let state = self.lock();
        !state.detached && state.breakpoints.is_at(place, self.info)
    }

    fn listens(&self) -> bool {
        let state = self.lock();
        !state.detached && !state.breakpoints.is_empty()
    }

    fn comes_to(&self, event: StepEvent<'_>, seen: &mut dyn FnMut() -> KernelSnapshot) -> bool {
        let mut state = self.lock();
        if state.detached {
            return false;
        }
        let Some(reason) = state.breakpoints.hit_by(event) else { return false };
        let seen = seen();
        let number = seen.channel;
        if let Some(channel) = state.channel(number) {
            (channel.seen, channel.writes) = (Some(seen), None);
        }
        state.stop = Some((number, format!("channel {number} {reason}")));
        true
    }

    fn hold_alone(&self, channel: u16, common: &mut Common<'_>) {
        let bound = self.lock().channel(channel).and_then(|one| one.seen.as_ref()).map_or(0, |seen| seen.t_ns);
        self.next(&[KernelCandidate { channel, ready: true, far_ahead: false, bound }], common);
    }

    fn goes(&self, channel: u16) -> Go {
        self.lock().goes(channel)
    }
}
