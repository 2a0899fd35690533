//! The control handle of a running job: cancel, live progress, the source of answers to dialogs, the resources that the
//! job has used and reached, and the test hook that disturbs scheduling.

use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU8, AtomicU32, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Duration;

pub use crate::StopSignal;
use crate::dialog::operator::DialogOperator;
pub use crate::state::ChannelActivity;
use crate::step::Console;
use crate::system::System;
use counterpoint_event::event::WaitArrival;

/// Shared between the runner and the watcher of a job. Reading progress never slows a kernel.
#[derive(Default)]
pub struct JobControl {
    stop: StopSignal,
    /// One entry per channel in ascending channel number.
    progress: Box<[ChannelProgress]>,
    /// Takes the place of a missing one.
    spare: ChannelProgress,
    jitter: Option<Box<dyn Fn(u16) + Send + Sync>>,
    operator: Option<Arc<dyn DialogOperator>>,
    system: Option<Arc<dyn System>>,
    console: Option<Arc<dyn Console>>,
    used: ThreadCpuTime,
    reached: OnceLock<Limit>,
    outside: AtomicBool,
}

/// Processor time of the threads that a run has started.
#[derive(Default)]
struct ThreadCpuTime {
    clock: Option<fn() -> Duration>,
    ns: AtomicU64,
}

/// A limit of the job that ended its run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// Simulated time.
    SimulatedTime,
    /// Blocks of a channel.
    Blocks,
    /// Consecutive blocks of a channel that take no time.
    ZeroTimeBlocks,
    /// Events of a channel.
    Events,
    /// Memory of the job.
    Memory,
    /// Steps of the macros of a channel.
    MacroSteps,
}

/// Adds the processor time of its life when it is dropped.
struct Meter<'a>(&'a AtomicU64, fn() -> Duration, Duration);

impl Drop for Meter<'_> {
    fn drop(&mut self) {
        let Self(ns, clock, begin) = self;
        let used = clock().saturating_sub(*begin).as_nanos();
        ns.fetch_add(u64::try_from(used).unwrap_or(u64::MAX), Ordering::Relaxed);
    }
}

impl JobControl {
    /// For a job of `channels` channels.
    #[must_use]
    pub fn new(channels: usize) -> Self {
        Self { progress: (0..channels).map(|_| ChannelProgress::default()).collect(), ..Self::default() }
    }

    /// The holder of `stop` can also cancel the job.
    #[must_use]
    pub fn with_stop(mut self, stop: StopSignal) -> Self {
        self.stop = stop;
        self.stop.set_stepped(self.console.is_some());
        self
    }

    /// Calls `jitter(channel)` around every shared operation, so that tests can delay kernels at will.
    #[must_use]
    pub fn with_jitter(mut self, jitter: impl Fn(u16) + Send + Sync + 'static) -> Self {
        self.jitter = Some(Box::new(jitter));
        self
    }

    /// Adds an operator who answers dialogs without a prepared answer.
    #[must_use]
    pub fn with_operator(mut self, operator: Arc<dyn DialogOperator>) -> Self {
        self.operator = Some(operator);
        self
    }

    /// The operator who answers dialogs.
    #[must_use]
    pub fn operator(&self) -> Option<&dyn DialogOperator> {
        self.operator.as_deref()
    }

    /// Macros may start commands of the operating system.
    #[must_use]
    pub fn with_system(mut self, system: Arc<dyn System>) -> Self {
        self.system = Some(system);
        self
    }

    /// The starter of commands for macros; none unless the owner of the server allows it.
    #[must_use]
    pub fn system(&self) -> Option<&dyn System> {
        self.system.as_deref()
    }

    /// Starts stepping through the job. It runs in the sequential mode and stops before its first block.
    #[must_use]
    pub fn with_console(mut self, console: Arc<dyn Console>) -> Self {
        self.console = Some(console);
        self.stop.set_stepped(true);
        self
    }

    /// The operator who steps through the job.
    #[must_use]
    pub fn console(&self) -> Option<&dyn Console> {
        self.console.as_deref()
    }

    /// Ends stepping through the job.
    pub fn end_steps(&self) {
        self.stop.set_stepped(false);
    }

    /// Waits while the job is suspended and is not to end.
    #[inline(always)]
    pub fn wait_while_suspended(&self) {
        self.stop.wait_while_suspended();
    }

    /// Whether the job is to end, is suspended, or is stepped through: one test for all.
    #[must_use]
    #[inline(always)]
    pub fn interferes(&self) -> bool {
        self.stop.interferes()
    }

    /// Measures the threads of the run with a clock of the processor time of the thread that asks.
    #[must_use]
    pub fn with_cpu_clock(mut self, clock: fn() -> Duration) -> Self {
        self.used.clock = Some(clock);
        self
    }

    /// Does the work of a thread that the run has started, and measures it.
    pub fn measured<T>(&self, work: impl FnOnce() -> T) -> T {
        let _meter = self.used.clock.map(|clock| Meter(&self.used.ns, clock, clock()));
        work()
    }

    /// Processor time of the threads that the run has started and that have ended; zero without a clock.
    #[must_use]
    pub fn cpu(&self) -> Duration {
        Duration::from_nanos(self.used.ns.load(Ordering::Relaxed))
    }

    /// A limit has ended the run.
    pub fn reach(&self, limit: Limit) {
        let _ = self.reached.set(limit);
    }

    /// The limit that has ended the run.
    #[must_use]
    pub fn reached(&self) -> Option<Limit> {
        self.reached.get().copied()
    }

    /// Records that the run depends on more than the job: it has asked an operator, or started a command of the
    /// operating system.
    pub fn note_outside(&self) {
        self.outside.store(true, Ordering::Relaxed);
    }

    /// Whether the run depends on more than the job. Otherwise another run would give the same log.
    #[must_use]
    pub fn used_outside(&self) -> bool {
        self.outside.load(Ordering::Relaxed)
    }

    /// Asks the job to stop; it ends soon after with its channels `STOPPED`.
    pub fn cancel(&self) {
        self.stop.ask();
    }

    /// Whether [`cancel`](Self::cancel) was called.
    #[must_use]
    #[inline(always)]
    pub fn cancelled(&self) -> bool {
        self.stop.asked()
    }

    /// The same for long work of a block: waits while the job is suspended.
    #[must_use]
    #[inline(always)]
    pub fn cancelled_once_resumed(&self) -> bool {
        self.stop.asked_once_resumed()
    }

    /// The request itself, to be checked where there is no control.
    #[must_use]
    pub fn stop(&self) -> &StopSignal {
        &self.stop
    }

    /// Live progress by channel, ascending channel number.
    #[must_use]
    pub fn progress(&self) -> &[ChannelProgress] {
        &self.progress
    }

    /// Progress without a reader.
    pub fn spare(&self) -> &ChannelProgress {
        &self.spare
    }

    /// Calls the hook of tests around a shared operation of a channel.
    pub fn disturb(&self, channel: u16) {
        if let Some(jitter) = &self.jitter {
            jitter(channel);
        }
    }
}

impl std::fmt::Debug for JobControl {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("JobControl").field("cancelled", &self.cancelled()).finish_non_exhaustive()
    }
}

/// Where one channel stands, as far as its kernel has run (which may be ahead of the ordered log).
#[derive(Debug, Default)]
#[repr(align(64))]
pub struct ChannelProgress {
    /// Blocks processed.
    pub blocks: AtomicU64,
    /// Simulated time, ns.
    pub t_ns: AtomicI64,
    /// Line in the file being executed.
    pub line: AtomicU32,
    /// File being executed.
    pub file: AtomicU32,
    /// [`ChannelActivity`] as a number.
    pub state: AtomicU8,
    standing: Mutex<Option<Arc<WaitArrival>>>,
}

impl ChannelProgress {
    /// Current state.
    #[must_use]
    pub fn state(&self) -> ChannelActivity {
        match self.state.load(Ordering::Relaxed) {
            1 => ChannelActivity::Running,
            2 => ChannelActivity::Waiting,
            3 => ChannelActivity::Ended,
            4 => ChannelActivity::Alarmed,
            5 => ChannelActivity::NotStarted,
            6 => ChannelActivity::Stopped,
            7 => ChannelActivity::Blocked,
            _ => ChannelActivity::Ready,
        }
    }

    /// The wait of the channel, if its state is [`ChannelActivity::Waiting`].
    #[must_use]
    pub fn waiting_for(&self) -> Option<Arc<WaitArrival>> {
        let standing = self.standing.lock().unwrap_or_else(PoisonError::into_inner);
        standing.as_ref().filter(|_| self.state() == ChannelActivity::Waiting).cloned()
    }

    /// The state of the channel has changed.
    pub fn set_state(&self, state: ChannelActivity) {
        self.state.store(state as u8, Ordering::Relaxed);
    }

    /// Records that the channel is at a wait.
    pub fn stand(&self, wait: Arc<WaitArrival>) {
        *self.standing.lock().unwrap_or_else(PoisonError::into_inner) = Some(wait);
        self.set_state(ChannelActivity::Waiting);
    }
}
