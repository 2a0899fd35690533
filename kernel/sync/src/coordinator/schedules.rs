//! The coordinator on threads whose schedules are tried out: `cargo test -p counterpoint-sync --features shuttle
//! schedules`.
//!
//! All possible next operations are explored in `order/explore.rs`; here are the locks, signals and bounds in memory.

use std::sync::Arc;

use ScheduleStep::{Act, At, Away, Begin, Do, Listen, Pass, Poll, Rest, Run, Stop};
use ScriptedWaitOp::{Call, Free, Remove, Send, Set, Share};
use counterpoint_event::event::Primitive;
use counterpoint_event::event::Primitive::{Barrier, Count, Flag, Join, Lease, Signal};

use super::Coordinator;
use super::switch::Port;
use super::turn::MeetOutcome;
use super::wait_method::WaitMethod;
use crate::channels::Channels;
use crate::order::arrive::ArrivalReply;
use crate::order::spin::LoopPass;
use crate::order::{Wake, spin};
use crate::shared::SharedState;
use crate::tag::Tag;
use crate::testing::{ScriptedWaitOp, info, listening, program, wait, waits};
use crate::wait::{Finish, Terminal, WaitingChannel};

/// Schedules that are tried for each test.
const SCHEDULES: usize = 1_000;

/// A step of a kernel.
#[derive(Debug, Clone, Copy)]
enum ScheduleStep {
    /// Blocks that take this time.
    Run(i64),
    /// An operation on shared state.
    Act,
    /// A wait of all kernels.
    At(Primitive, u32),
    /// The same, passed without a stop if all are there by then.
    Pass(Primitive, u32),
    /// A wait for a signal from any channel to all channels.
    Listen(u32),
    /// Something done for others.
    Do(ScriptedWaitOp, u32),
    /// The end of a program; the script continues when another kernel starts the next one.
    Rest,
    /// Starts this kernel.
    Begin(u16),
    /// A loop with ticks of two until this many operations have been executed.
    Poll(usize),
    /// A wait for the merger.
    Away,
    /// The end of the job.
    Stop,
}

/// Runs a kernel; its operations go into the list of variables, in their order.
fn kernel(core: &Coordinator, channel: u16, kernels: u16, script: &[ScheduleStep]) {
    let port = Port::new(core, WaitMethod::Thread);
    let (mut t, mut micro) = (0, 0);
    core.begin(channel);
    'script: for op in script {
        let tag = Tag { t, micro, channel };
        match op {
            Run(time) => {
                (t, micro) = (t + time, 0);
                if !core.publish(channel, t) {
                    break;
                }
            }
            Away => core.away(tag, shuttle::thread::yield_now),
            Poll(count) => {
                let lap = LoopPass { file: 0, lines: (1, 2), count: 1, reads: 1 };
                let mut begun = None;
                loop {
                    let tag = Tag { t, micro, channel };
                    let Ok(mut turn) = port.enter(tag, &mut (), |()| ()) else { break 'script };
                    if turn.shared.variables.len() >= *count {
                        break;
                    }
                    match turn.lap(tag, lap, begun, &"#100".into(), Some(2)) {
                        spin::PassOutcome::Pass(changes) => {
                            drop(turn);
                            begun = Some(changes);
                            (t, micro) = (t + 2, 0);
                            if !core.publish(channel, t) {
                                break 'script;
                            }
                        }
                        spin::PassOutcome::Rest => {
                            drop(turn);
                            match port.wait(channel, &mut (), |()| ()) {
                                Wake::Roused { tag, .. } => (t, micro) = (tag.t, tag.micro),
                                _ => break 'script,
                            }
                        }
                        spin::PassOutcome::Hopeless => {
                            turn.stop(tag);
                            break 'script;
                        }
                    }
                }
            }
            Act => match port.enter(tag, &mut (), |()| ()) {
                Ok(mut turn) => {
                    let key = turn.shared.variables.len() as u32;
                    turn.shared.variables.insert(key, t as f64 * 100.0 + f64::from(micro * 10 + u32::from(channel)));
                    turn.change();
                    micro += 1;
                }
                Err(_) => break,
            },
            Stop => {
                if let Ok(mut turn) = port.enter(tag, &mut (), |()| ()) {
                    turn.stop(tag);
                }
                break;
            }
            Do(deed, number) => match port.enter(tag, &mut (), |()| ()) {
                Ok(mut turn) => {
                    assert_eq!(turn.act(tag, deed.act(*number, kernels)), Ok(()));
                    micro += 1;
                }
                Err(_) => break,
            },
            Begin(other) => match port.enter(tag, &mut (), |()| ()) {
                Ok(mut turn) => {
                    assert_eq!(turn.start(tag, crate::wait::ChannelSet::default().with(*other)), Ok(()));
                    micro += 1;
                }
                Err(_) => break,
            },
            Rest => {
                match port.enter(tag, &mut (), |()| ()) {
                    Ok(mut turn) => {
                        turn.finish(tag, Finish { how: Terminal::Ended, file: 0, line: 0 });
                        turn.rest_idle(channel);
                    }
                    Err(_) => break,
                }
                match port.wait(channel, &mut (), |()| ()) {
                    Wake::Started { tag, .. } => (t, micro) = (tag.t, tag.micro),
                    _ => return core.done(channel, |_| ()),
                }
            }
            Pass(primitive, number) => {
                let waiting = WaitingChannel { wait: wait(*primitive, *number, kernels), tag, file: 0, line: 0 };
                let own = Finish { how: Terminal::Alarmed, file: 0, line: 0 };
                let Ok(mut turn) = port.enter(tag, &mut (), |()| ()) else { break };
                let after = turn.arrive_in_motion(waiting, own, &info()).0;
                drop(turn);
                // A kernel that passes is in motion for a while.
                if let ArrivalReply::Go { t: go, .. } = after {
                    (t, micro) = (go + 1, 0);
                    continue;
                }
                let Ok(mut turn) = port.enter(Tag { micro: u32::MAX, ..tag }, &mut (), |()| ()) else { break };
                let stops = turn.stops(tag, &info());
                drop(turn);
                match stops.map_err(|_| port.wait(channel, &mut (), |()| ())) {
                    Ok(Wake::Released { tag, .. }) => (t, micro) = (tag.t + 1, 0),
                    Err(Wake::Released { tag, .. }) => (t, micro) = (tag.t, tag.micro),
                    _ => break 'script,
                }
            }
            At(..) | Listen(_) => {
                let wait = match op {
                    At(primitive, number) => wait(*primitive, *number, kernels),
                    Listen(number) => listening(*number, kernels),
                    _ => unreachable!("no wait"),
                };
                let waiting = WaitingChannel { wait, tag, file: 0, line: 0 };
                let mut wake = match port.meet(waiting, &mut (), |()| (), |(), _| false) {
                    MeetOutcome::Woken(wake) => wake,
                    MeetOutcome::Turn(mut turn) => {
                        let own = Finish { how: Terminal::Alarmed, file: 0, line: 0 };
                        match turn.arrive(waiting, own, &info()).0 {
                            ArrivalReply::Go { t, micro, sync_point, short } => {
                                let tag = Tag { t, micro, channel };
                                Wake::Released { tag, sync_point, by: channel, all: true, short }
                            }
                            ArrivalReply::Stand(_) => Wake::Turn,
                            ArrivalReply::Alarm { .. } | ArrivalReply::Illegal { .. } => {
                                unreachable!("no wait is refused")
                            }
                        }
                    }
                };
                if wake == Wake::Turn {
                    wake = port.wait(channel, &mut (), |()| ());
                }
                match wake {
                    Wake::Released { tag, .. } => (t, micro) = (tag.t, tag.micro),
                    _ => break 'script,
                }
            }
        }
    }
    let tag = Tag { t, micro, channel };
    let finish = Finish { how: Terminal::Ended, file: 0, line: 0 };
    if let Ok(mut turn) = port.enter(tag, &mut (), |()| ()) {
        turn.finish(tag, finish);
    }
    core.done(channel, |_| ());
}

/// The operations of a job, in their order.
fn run(scripts: &'static [&'static [ScheduleStep]], threads: usize) -> Vec<f64> {
    let channels = Channels::new(1..=scripts.len() as u16);
    let core = Arc::new(Coordinator::new(channels, threads, SharedState::default(), waits(scripts.len() as u16), None));
    core.unordered(|order| (1..=scripts.len() as u16).for_each(|channel| order.preselect(channel, program())));
    let handles: Vec<_> = (1..)
        .zip(scripts)
        .map(|(channel, script)| {
            let core = Arc::clone(&core);
            shuttle::thread::spawn(move || kernel(&core, channel, scripts.len() as u16, script))
        })
        .collect();
    for handle in handles {
        assert!(handle.join().is_ok());
    }
    core.unordered(|order| (0..).map_while(|key| order.shared.variables.get(&key).copied()).collect())
}

fn tried(scripts: &'static [&'static [ScheduleStep]], expected: &'static [f64]) {
    // All threads at once, and fewer threads than kernels.
    for threads in [0, 2] {
        let job = move || assert_eq!(run(scripts, threads), expected, "{scripts:?} {threads}");
        shuttle::check_random(job, SCHEDULES);
        shuttle::check_pct(job, SCHEDULES, 3);
    }
}

#[test]
fn operations_of_two_kernels() {
    tried(&[&[Act, Run(2), Act, Act], &[Run(1), Act, Run(1), Act]], &[1.0, 102.0, 201.0, 202.0, 211.0]);
}

#[test]
fn barriers_of_two_kernels() {
    tried(
        &[
            &[Run(1), At(Barrier, 1), Act, Run(1), At(Barrier, 1), Act],
            &[Run(3), At(Barrier, 1), Run(2), Act, At(Barrier, 1), Act],
        ],
        &[311.0, 502.0, 521.0, 522.0],
    );
}

#[test]
fn a_partner_that_never_comes() {
    tried(&[&[Act, At(Barrier, 1), Act], &[Run(1), Act, Run(1), Act]], &[1.0, 102.0, 202.0]);
}

#[test]
fn a_stop_reaches_everybody() {
    tried(&[&[At(Barrier, 1), Act], &[Run(1), Act, Run(1), Stop], &[Run(1), Act, Run(5), Act]], &[102.0, 103.0]);
}

#[test]
fn three_kernels_of_which_one_is_away() {
    tried(
        &[
            &[Run(1), Away, Act, At(Barrier, 1), Act],
            &[Act, Run(2), At(Barrier, 1), Act],
            &[Away, Run(1), Act, At(Barrier, 1)],
        ],
        &[2.0, 101.0, 103.0, 211.0, 212.0],
    );
}

#[test]
fn flags_of_two_kernels() {
    tried(
        &[&[Run(1), At(Flag, 1), Act, Run(1), Do(Set, 2), Act], &[At(Flag, 1), Act, At(Flag, 2), Run(3), Act]],
        &[111.0, 112.0, 211.0, 502.0],
    );
}

#[test]
fn waits_that_kernels_pass_in_motion() {
    tried(
        &[
            &[Run(1), Pass(Flag, 1), Act, Run(1), Pass(Flag, 2), Act],
            &[Run(1), Pass(Flag, 1), Act, Run(3), At(Flag, 2), Act],
        ],
        &[201.0, 202.0, 511.0, 512.0],
    );
}

#[test]
fn a_stop_reaches_a_kernel_that_arrives_in_motion() {
    tried(&[&[Run(1), Pass(Barrier, 1), Act], &[Run(1), Act, Stop], &[Run(2), At(Barrier, 1)]], &[102.0]);
}

#[test]
fn order_numbers_of_two_kernels() {
    let orders: &[&[ScheduleStep]] = &[
        &[Run(1), At(Primitive::Order, 1), Act, Run(1), At(Primitive::Order, 3), Act],
        &[At(Primitive::Order, 2), Act, Run(2), At(Primitive::Order, 3), Act],
    ];
    tried(orders, &[111.0, 212.0, 411.0, 412.0]);
}

#[test]
fn counts_of_three_kernels() {
    tried(&[&[At(Count, 1), Act], &[Run(1), At(Count, 1), Act], &[Run(2), Act]], &[111.0, 112.0, 203.0]);
}

#[test]
fn signals_of_two_kernels() {
    tried(
        &[&[At(Signal, 1), Act, At(Signal, 1), Act], &[Run(1), Do(Send, 1), Run(1), Do(Send, 1), Act]],
        &[111.0, 211.0, 212.0],
    );
}

#[test]
fn a_signal_to_everybody_of_three_kernels() {
    tried(
        &[&[Run(1), Do(Call, 1), Run(2), Act], &[Listen(1), Act], &[Listen(1), Act, Run(1), Act]],
        &[112.0, 113.0, 203.0, 301.0],
    );
}

#[test]
fn polls_of_three_kernels() {
    tried(&[&[Poll(1), Act], &[Run(5), Act, Run(4), Act], &[Poll(2), Act]], &[502.0, 601.0, 603.0, 902.0]);
}

#[test]
fn polls_that_never_end() {
    tried(&[&[Poll(9), Act], &[Run(5), Act, Poll(7)], &[Run(9), Act, At(Barrier, 1)]], &[502.0, 903.0]);
}

/// Who has waited longest gets the one signal; a signal that is removed ends no wait.
#[test]
fn a_signal_that_three_kernels_share() {
    tried(
        &[
            &[Run(2), Do(Share, 1), Run(1), Do(Share, 2), Do(Remove, 2), Run(1), Do(Share, 1), Act],
            &[Run(1), Listen(1), Act],
            &[Listen(1), Act, Run(2), Listen(2), Act],
        ],
        &[213.0, 411.0, 412.0],
    );
}

#[test]
fn a_join_of_two_kernels() {
    tried(&[&[At(Join, 0), Act], &[Run(2), Act]], &[202.0, 221.0]);
}

#[test]
fn a_lease_of_three_kernels() {
    tried(
        &[
            &[At(Lease, 1), Run(2), Do(Free, 1), Act],
            &[Run(1), At(Lease, 1), Act, Do(Free, 1)],
            &[Run(1), At(Lease, 1), Act, Run(1), Do(Free, 1)],
        ],
        &[211.0, 212.0, 233.0],
    );
}

#[test]
fn a_kernel_is_started_twice() {
    tried(
        &[
            &[Run(1), Begin(2), Run(3), Act, Begin(2), Begin(3)],
            &[Rest, Act, Run(1), Rest, Act],
            &[Run(1), Rest, Run(1), Act],
        ],
        &[112.0, 401.0, 422.0, 503.0],
    );
}
