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
use counterpoint_ports::control::{Control, State as Doing};
use counterpoint_ports::step::{Command, Common, Console, Event, Go, Heard, Said, Seen, StepCalls, Stepper, Whom};
use decide::{Decision, Goal, Standing};

/// Between two looks at whether the job is to end.
const LOOK: Duration = Duration::from_millis(100);

/// A kernel that has not ended, as the scheduler sees it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Candidate {
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
    control: &'a Control,
    info: &'a Info,
    machine: &'a Machine,
    state: Mutex<State>,
}

/// A channel.
#[derive(Debug, Default)]
struct Channel {
    number: u16,
    /// Where it was seen last.
    seen: Option<Seen>,
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
struct State {
    channels: Vec<Channel>,
    goal: Goal,
    breakpoints: Breakpoints,
    /// The run stops at once: the channel that is the cause, and why.
    stop: Option<(u16, String)>,
    /// The channel that continued last, if it was too far ahead.
    ahead: Option<u16>,
    /// The operator has left.
    detached: bool,
}

impl State {
    fn channel(&mut self, number: u16) -> Option<&mut Channel> {
        self.channels.iter_mut().find(|channel| channel.number == number)
    }

    /// The channels that a command for one (0: for all) is about.
    fn these(&mut self, number: u16) -> impl Iterator<Item = &mut Channel> {
        self.channels.iter_mut().filter(move |channel| number == 0 || channel.number == number)
    }
}

impl<'a> Director<'a> {
    /// For a job that is before the first block of each channel.
    pub(crate) fn new(
        console: &'a dyn Console,
        control: &'a Control,
        (info, machine): (&'a Info, &'a Machine),
    ) -> Self {
        let channel = |number| Channel { number, ..Channel::default() };
        let state = State {
            channels: info.channels.iter().map(|of| channel(of.number)).collect(),
            goal: Goal::All,
            breakpoints: Breakpoints::default(),
            stop: None,
            ahead: None,
            detached: false,
        };
        Self { console, control, info, machine, state: Mutex::new(state) }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// State of a channel for the job.
    fn doing(&self, channel: u16) -> Doing {
        let index = self.info.channel_index(channel);
        index.and_then(|index| self.control.progress().get(index)).map_or(Doing::NotStarted, |now| now.state())
    }

    /// The kernel that continues; waits while the run is paused. `None`: none has anything to do.
    pub(crate) fn next(&self, kernels: &[Candidate], common: &mut Common<'_>) -> Option<usize> {
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
            let standing = Standing { kernels, waits: &|channel| self.doing(channel) == Doing::Waiting };
            match state.decide(&standing, self.info) {
                Decision::Run(at) => return Some(at),
                Decision::Stop(channel, reason) => self.stand(&mut state, (channel, reason), common),
            }
        }
    }

    /// Stops the run until a command lets it continue, the operator has left, or the job is to end.
    fn stand(&self, state: &mut State, (channel, reason): (u16, String), common: &mut Common<'_>) {
        state.goal = Goal::Stand;
        self.console.say(Said::Stopped(self.report(state, (channel, &reason), common)));
        while state.goal == Goal::Stand && !state.detached && !self.control.cancelled() {
            match self.console.wait(LOOK) {
                Heard::Command(command) => self.obey(state, command, common),
                Heard::Nothing => {}
                Heard::Gone => self.detach(state),
            }
        }
    }

    fn detach(&self, state: &mut State) {
        (state.detached, state.stop) = (true, None);
        self.control.end_steps();
    }

    /// Carries a command out and answers it.
    fn obey(&self, state: &mut State, command: Command, common: &mut Common<'_>) {
        let runs = command.runs();
        let answer = match self.carried_out(state, command) {
            Ok(Some(said)) => said,
            Ok(None) if runs || state.detached => return,
            Ok(None) => Said::State(self.report(state, (0, ""), common)),
            Err(refusal) => Said::Refused(refusal),
        };
        self.console.say(answer);
    }

    fn carried_out(&self, state: &mut State, command: Command) -> Result<Option<Said>, String> {
        if command.runs() && state.goal != Goal::Stand {
            return Err("the run has not stopped yet: pause it first".to_owned());
        }
        match command {
            Command::Step { whom, blocks, calls: StepCalls::Out } => self.step_out(state, whom, blocks.max(1))?,
            Command::Step { whom, blocks, calls } => {
                self.step(state, whom, blocks.max(1))?;
                for channel in &mut state.channels {
                    let level = channel.seen.as_ref().map_or(0, |seen| seen.level);
                    channel.deepest = (calls == StepCalls::Over).then_some(level);
                }
            }
            Command::Continue => state.goal = Goal::Free,
            Command::Pause if state.goal == Goal::Stand => {}
            Command::Pause => state.stop = Some((0, "paused by the operator".to_owned())),
            Command::Add(breakpoint) => {
                return Ok(Some(Said::Added(
                    state.breakpoints.add(breakpoint, |spot| breakpoints::may_hit(spot, self.info, self.machine))?,
                )));
            }
            Command::Remove(id) => state.breakpoints.remove(id)?,
            Command::Hold(channel) => {
                self.known(channel)?;
                state.these(channel).for_each(|channel| channel.held = true);
            }
            Command::Resume(channel) => {
                self.known(channel)?;
                state.these(channel).for_each(|channel| channel.held = false);
            }
            Command::Reset(channel) => {
                if channel == 0 {
                    return Err("a reset is for one channel: reset 1".to_owned());
                }
                self.runs(channel)?;
                if self.doing(channel) == Doing::Waiting {
                    return Err(format!(
                        "channel {channel} is waiting; reset it after its partner has arrived, before its next block"
                    ));
                }
                state.these(channel).for_each(|channel| channel.reset = true);
            }
            Command::Show => {}
            Command::Detach => self.detach(state),
        }
        Ok(None)
    }

    /// A block that is in progress is the first one of a step.
    fn step(&self, state: &mut State, whom: Whom, blocks: u32) -> Result<(), String> {
        let under_way = |channel: &Channel, waits: bool| {
            let doing = self.doing(channel.number);
            channel.seen.is_some() && !channel.at_block && (doing == Doing::Running || waits && doing == Doing::Waiting)
        };
        state.goal = match whom {
            // At a breakpoint within a block.
            Whom::Next => {
                Goal::Next(blocks - u32::from(state.channels.iter().any(|channel| under_way(channel, false))))
            }
            Whom::All => {
                for channel in &mut state.channels {
                    channel.left = blocks - u32::from(under_way(channel, true));
                }
                Goal::All
            }
            Whom::One(channel) => {
                self.runs(channel)?;
                if state.channel(channel).is_some_and(|channel| channel.held) {
                    return Err(format!("channel {channel} is on feed hold: resume it first"));
                }
                let under_way = state.channel(channel).is_some_and(|channel| under_way(channel, true));
                let blocks = blocks - u32::from(under_way);
                Goal::One { channel, blocks, stood: self.doing(channel) == Doing::Waiting }
            }
        };
        Ok(())
    }

    /// Runs the channels to the block after the return from this number of calls.
    fn step_out(&self, state: &mut State, whom: Whom, calls: u32) -> Result<(), String> {
        let inside = |channel: &Channel| channel.seen.as_ref().map_or(0, |seen| seen.level);
        let runs = |channel: &Channel| matches!(self.doing(channel.number), Doing::Running | Doing::Waiting);
        let meant = |channel: &Channel| match whom {
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
        if let Goal::One { blocks, .. } = &mut state.goal {
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
            Doing::NotStarted => Err(format!("channel {channel} has no program that runs")),
            Doing::Ready | Doing::Running | Doing::Waiting => Ok(()),
            Doing::Ended | Doing::Alarmed | Doing::Stopped | Doing::Blocked => {
                Err(format!("channel {channel} has ended"))
            }
        }
    }
}

impl Stepper for Director<'_> {
    fn stands(&self, place: &Seen, first: bool, variables: (u64, &dyn Fn() -> Vec<(u32, f64)>)) -> bool {
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

    fn comes_to(&self, event: Event<'_>, seen: &mut dyn FnMut() -> Seen) -> bool {
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
        self.next(&[Candidate { channel, ready: true, far_ahead: false, bound }], common);
    }

    fn goes(&self, channel: u16) -> Go {
        self.lock().goes(channel)
    }
}
