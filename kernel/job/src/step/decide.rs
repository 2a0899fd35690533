//! Decides which kernel continues, or why the run stops.
//!
//! Invariant: a function of the operator's commands and of the kernels' positions in simulated time; never of the
//! clock.

use counterpoint_event::info::Info;
use counterpoint_ports::step::{Go, KernelSnapshot};

use super::{KernelCandidate, StepState, SteppedChannel};

/// The request of the operator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum StepGoal {
    /// The run is paused.
    Stand,
    /// To run until a breakpoint or the end.
    Free,
    /// This many blocks of whichever channel is furthest behind.
    Next(u32),
    /// This many blocks of one channel.
    One {
        channel: u16,
        blocks: u32,
        /// It was at a wait when the step began.
        stood: bool,
    },
    /// As many blocks of each channel as it has left.
    All,
}

impl SteppedChannel {
    /// Whether a block at this level counts for a step: not if it is inside a call that the step goes over or out of.
    fn counts(&self, level: u32) -> bool {
        self.deepest.is_none_or(|deepest| level <= deepest)
    }

    /// Whether the block at which the channel was last seen counts for a step.
    fn counts_here(&self) -> bool {
        self.seen.as_ref().is_none_or(|seen| self.counts(seen.level))
    }
}

/// The work.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Decision {
    /// This kernel continues.
    Run(usize),
    /// The run is paused: the channel that is the cause (0 = none), and why.
    Stop(u16, String),
}

/// Where the kernels are.
pub(super) struct Standing<'k> {
    pub(super) kernels: &'k [KernelCandidate],
    /// Whether a channel is at a wait.
    pub(super) waits: &'k dyn Fn(u16) -> bool,
}

/// Of the kernels that have work and may run, the one that is furthest behind. A kernel that is too far ahead comes
/// last.
pub(super) fn furthest_behind(kernels: &[KernelCandidate], may: impl Fn(u16) -> bool) -> Option<usize> {
    let able = kernels.iter().enumerate().filter(|(_, kernel)| kernel.ready && may(kernel.channel));
    able.min_by_key(|(_, kernel)| (kernel.far_ahead, kernel.bound, kernel.channel)).map(|(at, _)| at)
}

/// Whether the start of a block of a channel counts for the goal, and counts it. `first`: no other channel is further
/// behind.
fn passed(goal: &mut StepGoal, channel: &SteppedChannel, level: u32, first: bool) -> bool {
    match goal {
        StepGoal::Free => first,
        StepGoal::One { channel: wanted, .. } if *wanted == channel.number && !channel.counts(level) => true,
        StepGoal::All | StepGoal::Next(_) if !channel.counts(level) => first,
        StepGoal::Next(blocks) if first && *blocks > 0 => {
            *blocks -= 1;
            true
        }
        StepGoal::One { channel: wanted, blocks, .. } if *wanted == channel.number && *blocks > 0 => {
            *blocks -= 1;
            true
        }
        StepGoal::All => first && channel.left > 0,
        _ => false,
    }
}

impl StepState {
    /// Whether the channel may begin a block, or is within one.
    fn may(&self, number: u16) -> bool {
        let Some(channel) = self.channels.iter().find(|channel| channel.number == number) else { return true };
        let done = self.goal == StepGoal::All && channel.left == 0 && channel.counts_here();
        let held = channel.held && !channel.reset || done;
        !(channel.at_block && held)
    }

    /// Decides the next step of the run.
    pub(super) fn decide(&mut self, standing: &Standing<'_>, info: &Info) -> Decision {
        if let Some((channel, reason)) = self.stop.take() {
            return Decision::Stop(channel, reason);
        }
        let kernels = standing.kernels;
        let mut chosen = None;
        if let StepGoal::One { channel, stood, .. } = self.goal {
            let Some(at) = kernels.iter().position(|kernel| kernel.channel == channel) else {
                return Decision::Stop(channel, format!("channel {channel} has ended"));
            };
            let kernel = kernels.get(at).filter(|kernel| kernel.ready && !kernel.far_ahead);
            if kernel.is_none() && !stood && (standing.waits)(channel) {
                return Decision::Stop(channel, format!("channel {channel} is waiting"));
            }
            chosen = kernel.filter(|kernel| self.may(kernel.channel)).map(|_| at);
        }
        let Some(at) = chosen.or_else(|| furthest_behind(kernels, |channel| self.may(channel))) else {
            let reason = if self.goal == StepGoal::All { "step" } else { "no channel can continue" };
            return Decision::Stop(0, self.with_holds(reason));
        };
        let Some(kernel) = kernels.get(at) else { return Decision::Run(at) };
        // A channel that is too far ahead continues when the others catch up; held channels and those whose step is
        // complete do not.
        let limited = self.goal == StepGoal::All || self.channels.iter().any(|one| one.held);
        if kernel.far_ahead && limited && self.ahead == Some(kernel.channel) {
            self.ahead = None;
            let reason = format!("channel {} cannot run further ahead of the others", kernel.channel);
            return Decision::Stop(kernel.channel, self.with_holds(&reason));
        }
        self.ahead = kernel.far_ahead.then_some(kernel.channel);
        match self.before(kernel.channel, info) {
            Some(reason) => Decision::Stop(kernel.channel, reason),
            None => Decision::Run(at),
        }
    }

    /// A reason, and which channels are on feed hold.
    fn with_holds(&self, reason: &str) -> String {
        let held: Vec<String> =
            self.channels.iter().filter(|one| one.held && one.at_block).map(|one| one.number.to_string()).collect();
        if held.is_empty() { reason.to_owned() } else { format!("{reason}; on feed hold: {}", held.join(", ")) }
    }

    /// Why the run is paused before the block that a channel is to begin.
    fn before(&mut self, number: u16, info: &Info) -> Option<String> {
        let channel = self.channels.iter_mut().find(|channel| channel.number == number)?;
        if !channel.at_block {
            return None;
        }
        let seen = channel.seen.as_ref()?;
        if !std::mem::replace(&mut channel.looked, true)
            && let Some(reason) = self.breakpoints.hit_before(seen, info)
        {
            return Some(format!("channel {number} {reason}"));
        }
        let counts = channel.counts_here();
        match self.goal {
            StepGoal::Next(0) if counts => Some("step".to_owned()),
            StepGoal::One { channel, blocks: 0, .. } if channel == number && counts => Some("step".to_owned()),
            _ => None,
        }
    }

    /// A kernel is before a block; whether it begins it at once, which is if [`decide`](Self::decide) and
    /// [`goes`](Self::goes) would come to that.
    pub(super) fn stands(
        &mut self,
        place: &KernelSnapshot,
        (first, news): (bool, bool),
        info: &Info,
        (writes, variables): (u64, &dyn Fn() -> Vec<(u32, f64)>),
    ) -> bool {
        let waits = news || self.detached || self.stop.is_some() || self.breakpoints.may_stop_before(place, info);
        let several = self.channels.len() > 1;
        let Some(channel) = self.channels.iter_mut().find(|channel| channel.number == place.channel) else {
            return false;
        };
        let passes = !waits && !channel.held && !channel.reset && passed(&mut self.goal, channel, place.level, first);
        (channel.at_block, channel.looked) = (!passes, passes);
        if passes {
            self.ahead = None;
            channel.left = channel.left.saturating_sub(u32::from(channel.counts(place.level)));
        }
        let seen = channel.seen.get_or_insert_default();
        // Others may stop the run while this block is in progress.
        if (several || !passes) && channel.writes != Some(writes) {
            (seen.variables, channel.writes) = (variables(), Some(writes));
        }
        (seen.channel, seen.file, seen.line, seen.level) = (place.channel, place.file, place.line, place.level);
        (seen.t_ns, seen.position) = (place.t_ns, place.position);
        seen.words.clone_from(&place.words);
        passes
    }

    /// A kernel continues with its block.
    pub(super) fn goes(&mut self, number: u16) -> Go {
        let Some(channel) = self.channels.iter_mut().find(|channel| channel.number == number) else { return Go::On };
        let counted = u32::from(channel.counts_here());
        match &mut self.goal {
            StepGoal::Next(blocks) => *blocks = blocks.saturating_sub(counted),
            StepGoal::One { channel, blocks, .. } if *channel == number => *blocks = blocks.saturating_sub(counted),
            _ => {}
        }
        channel.at_block = false;
        channel.left = channel.left.saturating_sub(counted);
        if std::mem::take(&mut channel.reset) { Go::Reset } else { Go::On }
    }
}
