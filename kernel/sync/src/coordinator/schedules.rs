//! The coordinator on threads whose schedules are tried out: `cargo test -p counterpoint-sync --features shuttle schedules`.
//!
//! What may happen next is explored whole in `order/explore.rs`; here are the locks, signals and bounds in memory.

use std::sync::Arc;

use super::Coordinator;
use super::switch::{Port, Switch};
use super::turn::Met;
use crate::order::Wake;
use crate::ranks::Ranks;
use crate::shared::Shared;
use crate::tag::Tag;
use crate::waits::{Arrival, Finish, Set, Spec, Style, Terminal, Waiting, Waits};
use counterpoint_event::event::Primitive;

/// Schedules that are tried for each test.
const SCHEDULES: usize = 1_000;

/// A step of a kernel.
#[derive(Debug, Clone, Copy)]
enum Op {
    /// Blocks that take this time.
    Run(i64),
    /// An operation on shared state.
    Act,
    /// A wait of all kernels.
    Meet,
    /// A wait for the merger.
    Away,
    /// The end of the job.
    Stop,
}

use Op::{Act, Away, Meet, Run, Stop};

/// Runs a kernel; its operations go into the list of variables, in their order.
fn kernel(core: &Coordinator, rank: u16, kernels: u16, script: &[Op]) {
    let port = Port::new(core, Switch::Thread);
    let parts: Set = (1..=kernels).collect();
    let (mut t, mut micro) = (0, 0);
    core.begin(rank);
    'script: for op in script {
        let tag = Tag { t, micro, rank };
        match op {
            Run(time) => {
                (t, micro) = (t + time, 0);
                if !core.publish(rank, t) {
                    break;
                }
            }
            Away => core.away(tag, shuttle::thread::yield_now),
            Act => match port.enter(tag, &mut (), |()| ()) {
                Ok(mut turn) => {
                    let key = turn.shared.variables.len() as u32;
                    turn.shared.variables.insert(key, t as f64 * 100.0 + f64::from(micro * 10 + u32::from(rank)));
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
            Meet => {
                let spec = Spec {
                    primitive: Primitive::Barrier,
                    letter: 'M',
                    number: 1,
                    named: parts,
                    parts,
                    style: Style::Listed,
                };
                let waiting = Waiting { spec, tag, file: 0, line: 0 };
                let mut wake = match port.meet(waiting.clone(), &mut (), |()| (), |(), _| false) {
                    Met::Woken(wake) => wake,
                    Met::Turn(mut turn) => match turn.waits.arrive(waiting) {
                        Arrival::Released { channels, t, micro } => {
                            let meeting = turn.release(channels, (t, micro), Some(rank));
                            Wake::Released { tag: Tag { t, micro, rank }, meeting, all: true }
                        }
                        Arrival::Blocked => {
                            turn.block(rank);
                            Wake::Turn
                        }
                        Arrival::Mismatch { .. } => unreachable!("there is one code only"),
                    },
                };
                if wake == Wake::Turn {
                    wake = port.wait(rank, &mut (), |()| ());
                }
                match wake {
                    Wake::Released { tag, .. } => (t, micro) = (tag.t, tag.micro),
                    _ => break 'script,
                }
            }
        }
    }
    let tag = Tag { t, micro, rank };
    let finish = Finish { how: Terminal::Ended, file: 0, line: 0 };
    if let Ok(mut turn) = port.enter(tag, &mut (), |()| ()) {
        turn.waits.finish(rank, finish);
    }
    core.done(rank, |_| ());
}

/// The operations of a job, in their order.
fn run(scripts: &'static [&'static [Op]], threads: usize) -> Vec<f64> {
    let ranks = Ranks::new(1..=scripts.len() as u16);
    let waits = Waits::new(ranks.clone(), 0);
    let core = Arc::new(Coordinator::new(ranks, threads, Shared::default(), waits, None));
    let handles: Vec<_> = (1..)
        .zip(scripts)
        .map(|(rank, script)| {
            let core = Arc::clone(&core);
            shuttle::thread::spawn(move || kernel(&core, rank, scripts.len() as u16, script))
        })
        .collect();
    for handle in handles {
        assert!(handle.join().is_ok());
    }
    core.unordered(|order| (0..).map_while(|key| order.shared.variables.get(&key).copied()).collect())
}

fn tried(scripts: &'static [&'static [Op]], expected: &'static [f64]) {
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
fn meetings_of_two_kernels() {
    tried(
        &[&[Run(1), Meet, Act, Run(1), Meet, Act], &[Run(3), Meet, Run(2), Act, Meet, Act]],
        &[311.0, 502.0, 521.0, 522.0],
    );
}

#[test]
fn a_partner_that_never_comes() {
    tried(&[&[Act, Meet, Act], &[Run(1), Act, Run(1), Act]], &[1.0, 102.0, 202.0]);
}

#[test]
fn a_stop_reaches_everybody() {
    tried(&[&[Meet, Act], &[Run(1), Act, Run(1), Stop], &[Run(1), Act, Run(5), Act]], &[102.0, 103.0]);
}

#[test]
fn three_kernels_of_which_one_is_away() {
    tried(
        &[&[Run(1), Away, Act, Meet, Act], &[Act, Run(2), Meet, Act], &[Away, Run(1), Act, Meet]],
        &[2.0, 101.0, 103.0, 211.0, 212.0],
    );
}
