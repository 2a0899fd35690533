//! The console of a job: commands of the client that steps through it, on their way to the run, and the answers of the
//! run.
//!
//! Invariants: one client at a time; a run that is paused without a command for longer than the server's waiting time
//! continues by itself. Unread messages of a client hold back its next commands, so nothing here grows.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

use counterpoint_kernel::operator::{Console, Heard, StepCommand, StepReply};
use tokio::sync::mpsc;

use super::lock::lock;
use super::operator::end_ms;
use crate::clock::now_ms;

/// Where the commands for a job wait.
#[derive(Debug)]
pub(crate) struct Stepping {
    inner: Mutex<StepConsoleState>,
    /// For the run: a command came.
    came: Condvar,
    /// A command waits.
    pending: AtomicBool,
}

#[derive(Debug)]
struct StepConsoleState {
    commands: VecDeque<StepCommand>,
    /// To the client.
    client: Option<mpsc::UnboundedSender<StepReply>>,
    /// Place where the run is paused, if it is.
    stop: Option<StepReply>,
    /// When the run came to a stand, or the last command came.
    since: Instant,
    /// The same time, ms since 1970.
    since_ms: i64,
    /// The client wants no more stops, in later runs of the job neither.
    detached: bool,
    patience: Duration,
}

impl Stepping {
    pub(crate) fn new() -> Self {
        let (commands, since, since_ms) = (VecDeque::new(), Instant::now(), now_ms());
        let patience = Duration::ZERO;
        let inner = StepConsoleState { commands, client: None, stop: None, since, since_ms, detached: false, patience };
        Self { inner: Mutex::new(inner), came: Condvar::new(), pending: AtomicBool::new(false) }
    }

    /// Sets how long a run waits without a command.
    pub(crate) fn set_patience(&self, patience: Duration) {
        lock(&self.inner).patience = patience;
    }

    /// The job is run again from its start.
    pub(crate) fn begin_again(&self) {
        let mut inner = lock(&self.inner);
        inner.commands.clear();
        inner.stop = None;
    }

    /// A client comes; it learns where the run is. `None`: there is another one.
    pub(crate) fn come(&self) -> Option<mpsc::UnboundedReceiver<StepReply>> {
        let mut inner = lock(&self.inner);
        if inner.client.as_ref().is_some_and(|client| !client.is_closed()) {
            return None;
        }
        let (send, receive) = mpsc::unbounded_channel();
        if let Some(stop) = &inner.stop {
            let _ = send.send(stop.clone());
        }
        inner.client = Some(send);
        Some(receive)
    }

    /// The client commands something.
    pub(crate) fn command(&self, command: StepCommand) {
        let mut inner = lock(&self.inner);
        inner.detached |= command == StepCommand::Detach;
        inner.commands.push_back(command);
        inner.begin_wait();
        self.pending.store(true, Ordering::Release);
        drop(inner);
        self.came.notify_all();
    }

    /// Whether the run is paused, so that it takes no processor time until a command comes.
    pub(crate) fn waits_for_client(&self) -> bool {
        self.client_wait().is_some()
    }

    /// Start and end of the wait for a command, ms since 1970.
    pub(super) fn client_wait(&self) -> Option<(i64, i64)> {
        let inner = lock(&self.inner);
        let waits = inner.stop.is_some() && inner.commands.is_empty();
        waits.then(|| (inner.since_ms, end_ms(inner.since_ms, inner.patience)))
    }

    fn taken(&self, inner: &mut StepConsoleState) -> Heard {
        let command = inner.take();
        self.pending.store(!inner.commands.is_empty() || inner.detached, Ordering::Release);
        command.map_or(Heard::Nothing, Heard::Command)
    }
}

impl StepConsoleState {
    /// The run waits for the next command from now on.
    fn begin_wait(&mut self) {
        (self.since, self.since_ms) = (Instant::now(), now_ms());
    }

    fn take(&mut self) -> Option<StepCommand> {
        let command = self.commands.pop_front().or_else(|| self.detached.then_some(StepCommand::Detach))?;
        if command.runs() || command == StepCommand::Detach {
            self.stop = None;
        }
        Some(command)
    }
}

impl Console for Stepping {
    fn has_news(&self) -> bool {
        self.pending.load(Ordering::Acquire)
    }

    fn poll(&self) -> Heard {
        if !self.pending.load(Ordering::Acquire) {
            return Heard::Nothing;
        }
        let mut inner = lock(&self.inner);
        self.taken(&mut inner)
    }

    fn wait(&self, at_most: Duration) -> Heard {
        let mut inner = lock(&self.inner);
        if inner.commands.is_empty() && !inner.detached {
            let left = inner.patience.saturating_sub(inner.since.elapsed());
            if left.is_zero() {
                inner.stop = None;
                return Heard::Gone;
            }
            let waited = self.came.wait_timeout(inner, at_most.min(left));
            inner = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        self.taken(&mut inner)
    }

    fn say(&self, said: StepReply) {
        let mut inner = lock(&self.inner);
        if matches!(said, StepReply::Stopped(_)) {
            inner.stop = Some(said.clone());
            inner.begin_wait();
        }
        if let Some(client) = &inner.client {
            let _ = client.send(said);
        }
    }
}

#[cfg(test)]
mod tests {
    use counterpoint_kernel::operator::StepReport;

    use super::*;

    fn stopped(reason: &str) -> StepReply {
        StepReply::Stopped(StepReport { reason: reason.into(), ..StepReport::default() })
    }

    #[test]
    fn one_client_at_a_time_which_learns_where_the_run_stands() {
        let console = Stepping::new();
        console.set_patience(Duration::from_secs(3600));
        assert!(!console.waits_for_client());
        console.say(stopped("a"));
        assert!(console.waits_for_client());
        let mut first = console.come().unwrap();
        assert_eq!(first.try_recv(), Ok(stopped("a")));
        assert!(console.come().is_none());
        console.command(StepCommand::Show);
        assert!(!console.waits_for_client(), "it has something to do");
        console.command(StepCommand::Continue);
        assert_eq!(console.poll(), Heard::Command(StepCommand::Show));
        assert_eq!(console.wait(Duration::from_secs(3600)), Heard::Command(StepCommand::Continue));
        assert_eq!(console.poll(), Heard::Nothing);
        drop(first);
        let mut next = console.come().expect("the first one has gone");
        assert!(next.try_recv().is_err(), "the run does not stand");
        console.say(stopped("b"));
        assert_eq!(next.try_recv(), Ok(stopped("b")));
    }

    #[test]
    fn nobody_waits_for_ever() {
        let console = Stepping::new();
        console.say(stopped("a"));
        assert_eq!(console.wait(Duration::from_secs(3600)), Heard::Gone, "no patience at all");
        assert!(console.come().unwrap().try_recv().is_err(), "the run goes on");
        console.set_patience(Duration::from_secs(3600));
        console.say(stopped("b"));
        assert_eq!(console.wait(Duration::from_millis(1)), Heard::Nothing);
        console.begin_again();
        assert!(lock(&console.inner).stop.is_none());
        console.command(StepCommand::Detach);
        console.begin_again();
        console.say(stopped("c"));
        assert_eq!(console.poll(), Heard::Command(StepCommand::Detach), "a later run does not stand either");
        assert_eq!(console.wait(Duration::from_secs(3600)), Heard::Command(StepCommand::Detach));
    }
}
