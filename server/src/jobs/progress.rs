//! Live progress of a job in wire form, read from the kernels' atomics.
//!
//! Invariant: reading never stops a kernel.

use std::sync::atomic::Ordering;

use counterpoint_kernel::control::{Progress, State};
use counterpoint_kernel::log::info::Channel;
use counterpoint_proto::v1;

use super::live::{Run, lock};

/// All channels of a run.
pub(crate) fn channels(run: &Run) -> Vec<v1::ChannelProgress> {
    let waits = lock(&run.waits).clone();
    let waits = waits.iter().map(String::as_str).chain(std::iter::repeat(""));
    (run.info.channels.iter().zip(run.control.progress()).zip(waits))
        .map(|((channel, progress), wait)| one(channel, progress, wait))
        .collect()
}

fn one(channel: &Channel, progress: &Progress, wait: &str) -> v1::ChannelProgress {
    let state = progress.state();
    let line = progress.line.load(Ordering::Relaxed);
    let (first, last) = channel.lines;
    let lines = (last + 1).saturating_sub(first);
    let here = progress.file.load(Ordering::Relaxed) == u32::from(channel.file) && (first..=last).contains(&line);
    let percent = match state {
        State::Ended => 100.0,
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
        waiting_for: if state == State::Waiting { wait.to_owned() } else { String::new() },
    }
}

fn wire(state: State) -> v1::ChannelState {
    match state {
        State::Ready => v1::ChannelState::Ready,
        State::Running => v1::ChannelState::Running,
        State::Waiting => v1::ChannelState::Waiting,
        State::Ended => v1::ChannelState::Ended,
        State::Alarmed => v1::ChannelState::Alarmed,
        State::NotStarted => v1::ChannelState::NotStarted,
        State::Stopped => v1::ChannelState::Stopped,
        State::Blocked => v1::ChannelState::Blocked,
    }
}
