//! Watches a job that runs in a test: a stalled job fails the test instead of hanging it.
//!
//! Invariant: a job that makes progress, or works without visible progress, is left alone. A job counts as hung when
//! for two seconds no channel changed its place, its time or its state, and the process used next to no processor time;
//! or when for two minutes no channel changed anything, whatever the process used.
//! A hung job cannot be asked to stop, so the process ends with the state of every kernel.

use std::fmt::Write as _;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::mpsc::{RecvTimeoutError, TryRecvError, channel};
use std::time::Duration;

use counterpoint_kernel::control::JobControl;

/// Time between two looks.
const LOOK: Duration = Duration::from_millis(100);
/// Looks without a change after which a job counts as standing still.
const PATIENCE: u32 = 20;
/// Looks without a change after which a job counts as hung that uses the processor: it spins.
const MOST_LOOKS: u32 = 1200;
/// Processor time within these looks that is still nothing, in clock ticks of the system (100 a second).
const IDLE_TICKS: u64 = 10;

/// Runs `job` under watch.
///
/// # Panics
/// When the job panics. A hung job ends the process.
pub fn watched<R>(control: &JobControl, job: impl FnOnce() -> R) -> R {
    let (done, ended) = channel::<()>();
    std::thread::scope(|scope| {
        scope.spawn(move || {
            let (mut last, mut quiet, mut unchanged) = (places(control), 0, 0);
            let mut since = ticks();
            while let Err(RecvTimeoutError::Timeout) = ended.recv_timeout(LOOK) {
                let now = places(control);
                let used = ticks();
                unchanged = if now == last { unchanged + 1 } else { 0 };
                if unchanged >= MOST_LOOKS {
                    stands_still(&last);
                }
                if now != last || used.is_none_or(|used| used > since.unwrap_or(used) + IDLE_TICKS) {
                    (last, quiet, since) = (now, 0, used);
                    continue;
                }
                quiet += 1;
                if quiet >= PATIENCE {
                    stands_still(&last);
                }
            }
        });
        let result = job();
        drop(done);
        result
    })
}

/// Runs `job` under watch while a further thread looks at the progress as fast as it can.
///
/// # Panics
/// As [`watched`].
pub fn beside<R>(control: &JobControl, job: impl FnOnce() -> R) -> R {
    let (done, ended) = channel::<()>();
    std::thread::scope(|scope| {
        scope.spawn(move || {
            while let Err(TryRecvError::Empty) = ended.try_recv() {
                std::hint::black_box(places(control));
                std::thread::yield_now();
            }
        });
        let result = watched(control, job);
        drop(done);
        result
    })
}

/// State, block count, line and time of every channel.
fn places(control: &JobControl) -> Vec<(String, u64, u32, i64)> {
    let place = |p: &counterpoint_kernel::control::ChannelProgress| {
        let state = match p.waiting_for() {
            Some(wait) => format!("waits at {}", wait.key),
            None => format!("{:?}", p.state()),
        };
        (state, p.blocks.load(Relaxed), p.line.load(Relaxed), p.t_ns.load(Relaxed))
    };
    control.progress().iter().map(place).collect()
}

/// Processor time of this process in clock ticks; `None` where the system does not say.
fn ticks() -> Option<u64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
    Some(fields.get(11)?.parse::<u64>().ok()? + fields.get(12)?.parse::<u64>().ok()?)
}

fn stands_still(places: &[(String, u64, u32, i64)]) -> ! {
    let mut text = String::from("the job stands still: no event and no processor time for 2 s\n");
    for (index, (state, blocks, line, t)) in places.iter().enumerate() {
        let _ = writeln!(text, "  kernel {}: {state}, {blocks} blocks, line {line}, {t} ns", index + 1);
    }
    // Past the capture of the test harness, which shows nothing of a process that ends.
    let _ = std::io::Write::write_all(&mut std::io::stderr(), text.as_bytes());
    std::process::exit(101)
}
