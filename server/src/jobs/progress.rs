//! Live progress of a job in wire form, read from the kernels' atomics.
//!
//! Invariant: reading never stops a kernel.

use std::sync::atomic::Ordering;

use counterpoint_kernel::control::{ChannelActivity, ChannelProgress};
use counterpoint_kernel::log::event::WaitArrival;
use counterpoint_kernel::log::info::JobChannel;
use counterpoint_proto::v1;

use super::Core;
use super::describe::state;
use super::live::{LiveJob, PreparedRun};

/// The progress of a job; `position` is the number of the last event that its receiver knows.
pub(crate) fn now(core: &Core, live: &LiveJob, position: u64) -> v1::Progress {
    v1::Progress {
        state: state(live.state()).into(),
        position,
        channels: live.run().map(|run| channels(&run)).unwrap_or_default(),
        queued_before: u32::try_from(core.queued_before(&live.id)).unwrap_or(u32::MAX),
        cancel_requested: live.peek(|record| record.cancel && !record.state.ended()),
        operator_wait: live.operator_wait(),
        paused: live.peek(|record| record.paused && !record.state.ended()),
    }
}

/// All channels of a run.
fn channels(run: &PreparedRun) -> Vec<v1::ChannelProgress> {
    run.info.channels.iter().zip(run.control.progress()).map(|(channel, progress)| one(channel, progress)).collect()
}

fn one(channel: &JobChannel, progress: &ChannelProgress) -> v1::ChannelProgress {
    let state = progress.state();
    let line = progress.line.load(Ordering::Relaxed);
    let (first, last) = channel.lines;
    let lines = (last + 1).saturating_sub(first);
    let here = progress.file.load(Ordering::Relaxed) == u32::from(channel.file) && (first..=last).contains(&line);
    let percent = match state {
        ChannelActivity::Ended => 100.0,
        _ if here && lines > 0 => f64::from(line - first + 1) * 100.0 / f64::from(lines),
        _ => 0.0,
    };
    v1::ChannelProgress {
        channel: u32::from(channel.number),
        name: channel.name.clone(),
        state: wire(state).into(),
        blocks: progress.blocks.load(Ordering::Relaxed),
        line,
        lines,
        percent,
        t_ns: progress.t_ns.load(Ordering::Relaxed),
        waiting_for: progress.waiting_for().map_or_else(String::new, |wait| waits(channel.number, &wait)),
    }
}

/// `M101 with 2, 3`.
fn waits(channel: u16, wait: &WaitArrival) -> String {
    let others = wait.participants.iter().filter(|&&c| c != channel);
    let others: Vec<String> = others.map(ToString::to_string).collect();
    format!("{} with {}", wait.key, others.join(", "))
}

/// A state on the wire.
pub(crate) fn wire(state: ChannelActivity) -> v1::ChannelState {
    match state {
        ChannelActivity::Ready => v1::ChannelState::Ready,
        ChannelActivity::Running => v1::ChannelState::Running,
        ChannelActivity::Waiting => v1::ChannelState::Waiting,
        ChannelActivity::Ended => v1::ChannelState::Ended,
        ChannelActivity::Alarmed => v1::ChannelState::Alarmed,
        ChannelActivity::NotStarted => v1::ChannelState::NotStarted,
        ChannelActivity::Stopped => v1::ChannelState::Stopped,
        ChannelActivity::Blocked => v1::ChannelState::Blocked,
    }
}
