//! Webhooks: messages about the ends of jobs to targets that the administrator lists.
//!
//! One thread sends the messages of all targets; each target has its own bounded queue and order. Messages and their
//! signatures follow the Standard Webhooks specification. *Invariants:* no job waits for a target; a message that is
//! not delivered is counted; a message goes only to a listed target and only about its tenants; no redirect is
//! followed.

mod delivery;
mod endpoint;
mod message;
mod post;
mod target;

use std::collections::BTreeMap;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use tokio::sync::{mpsc, watch};

use crate::ledger::record::JobRecord;
use crate::metrics::{Metrics, WebhookOutcome};
use crate::options::Webhook;
use crate::pace::LogRateLimit;
use delivery::Retries;
use message::WebhookMessage;
use target::WebhookTarget;

/// Messages that may wait for one target.
const WAITING: usize = 1000;
/// Time for the remaining messages when the server stops.
const CLOSING: Duration = Duration::from_secs(1);

static DROPPED: LogRateLimit = LogRateLimit::new();

/// A target with its queue.
#[derive(Debug)]
struct TargetQueue {
    target: Arc<WebhookTarget>,
    messages: mpsc::Sender<WebhookMessage>,
}

/// Sends messages until it is closed.
#[derive(Debug)]
pub(crate) struct Webhooks {
    lines: Mutex<Vec<TargetQueue>>,
    metrics: Arc<Metrics>,
    /// Signals the thread that no more messages come.
    closing: watch::Sender<bool>,
    /// Disconnected when the thread has ended.
    done: Mutex<Receiver<()>>,
}

impl Webhooks {
    /// Starts the thread, if there are targets.
    ///
    /// # Errors
    /// A target that cannot be used, or no thread.
    pub(crate) fn start(
        table: &BTreeMap<String, Webhook>,
        insecure: bool,
        metrics: &Arc<Metrics>,
    ) -> Result<Self, String> {
        Self::start_with(table, insecure, metrics, Retries::default())
    }

    fn start_with(
        table: &BTreeMap<String, Webhook>,
        insecure: bool,
        metrics: &Arc<Metrics>,
        retries: Retries,
    ) -> Result<Self, String> {
        let (alive, done) = channel();
        let (closing, closed) = watch::channel(false);
        let mut lines = Vec::new();
        let mut receivers = Vec::new();
        for (name, webhook) in table {
            let target =
                WebhookTarget::new(name, webhook, insecure).map_err(|reason| format!("webhooks.{name}: {reason}"))?;
            let (messages, receiver) = mpsc::channel(WAITING);
            let target = Arc::new(target);
            receivers.push((target.clone(), receiver));
            lines.push(TargetQueue { target, messages });
        }
        if !lines.is_empty() {
            let wrong = |error: std::io::Error| format!("webhooks: {error}");
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(wrong)?;
            let metrics = metrics.clone();
            let work = move || {
                let mut tasks = tokio::task::JoinSet::new();
                for (target, receiver) in receivers {
                    let deliveries =
                        delivery::Deliveries { target, retries, metrics: metrics.clone(), closed: closed.clone() };
                    tasks.spawn_on(deliveries.run(receiver), runtime.handle());
                }
                runtime.block_on(tasks.join_all());
                drop(alive);
            };
            std::thread::Builder::new().name("webhooks".to_owned()).spawn(work).map_err(wrong)?;
        }
        Ok(Self { lines: Mutex::new(lines), metrics: metrics.clone(), closing, done: Mutex::new(done) })
    }

    /// Queues the messages about a job that has ended.
    pub(crate) fn ended(&self, record: &JobRecord) {
        let lines = self.lines.lock().unwrap_or_else(PoisonError::into_inner);
        for line in lines.iter().filter(|line| line.target.wants(record)) {
            let name = &line.target.name;
            // Before the message is sent, so the thread never counts below zero.
            line.target.waiting.fetch_add(1, Ordering::Relaxed);
            self.metrics.webhooks_waiting(name, 1);
            if line.messages.try_send(WebhookMessage::of(record)).is_ok() {
                continue;
            }
            line.target.waiting.fetch_sub(1, Ordering::Relaxed);
            self.metrics.webhooks_waiting(name, -1);
            self.metrics.webhook(name, WebhookOutcome::Dropped);
            if let Some(left_out) = DROPPED.pass() {
                tracing::warn!(webhook = name, left_out, "a webhook is dropped: too many wait for its target");
            }
        }
    }

    /// Accepts no more messages and sends each remaining message once, all within a second. Returns the number of
    /// undelivered messages.
    pub(crate) fn close(&self) -> usize {
        let lines = std::mem::take(&mut *self.lines.lock().unwrap_or_else(PoisonError::into_inner));
        if lines.is_empty() {
            return 0;
        }
        let targets: Vec<_> = lines.into_iter().map(|line| line.target).collect();
        self.closing.send_replace(true);
        let done = self.done.lock().unwrap_or_else(PoisonError::into_inner);
        // The thread ends when each message has been tried.
        let _ = done.recv_timeout(CLOSING);
        for target in &targets {
            let messages = target.undelivered();
            if messages > 0 {
                let webhook = &target.name;
                tracing::warn!(webhook, messages, "the server stops before these webhooks are delivered");
            }
        }
        targets.iter().map(|target| target.undelivered()).sum()
    }
}

#[cfg(test)]
mod tests;
