//! Processor time and priority of threads, and the cores they share.
//!
//! Invariant: the clock of a thread never goes back and stops while the thread waits, where the system can
//! tell.

use std::num::NonZero;
use std::sync::OnceLock;
use std::time::Duration;

/// Nice value of threads that run jobs: beside a thread of nice value 0 they get a quarter of a core.
#[cfg(target_os = "linux")]
const BEHIND_CALLERS: i32 = 5;

/// Processor time that this thread has used so far.
#[cfg(unix)]
pub(crate) fn of_this_thread() -> Duration {
    use rustix::time::{ClockId, clock_gettime};
    let now = clock_gettime(ClockId::ThreadCPUTime);
    let nanos = u32::try_from(now.tv_nsec).unwrap_or(0);
    Duration::new(u64::try_from(now.tv_sec).unwrap_or(0), nanos)
}

/// Where no such clock is to be had, time by the clock.
#[cfg(not(unix))]
pub(crate) fn of_this_thread() -> Duration {
    static BEGIN: OnceLock<std::time::Instant> = OnceLock::new();
    BEGIN.get_or_init(std::time::Instant::now).elapsed()
}

/// Processor cores that this process may use. Asking the system reads files of its control group, so it is asked once.
pub(crate) fn cores() -> usize {
    static CORES: OnceLock<usize> = OnceLock::new();
    *CORES.get_or_init(|| std::thread::available_parallelism().map_or(1, NonZero::get))
}

/// Gives the threads that answer callers precedence over this thread and those that it starts, if the system has thread
/// priorities. So a server whose cores all run jobs still accepts others at once.
pub(crate) fn run_after_callers() {
    #[cfg(target_os = "linux")]
    if let Err(error) = rustix::process::setpriority_process(None, BEHIND_CALLERS) {
        tracing::debug!(%error, "jobs run with the priority of calls");
    }
}

/// Microseconds of a time.
pub(crate) fn micros(time: Duration) -> u64 {
    u64::try_from(time.as_micros()).unwrap_or(u64::MAX)
}
