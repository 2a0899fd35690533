//! The messages of one target, in their order, until each is delivered or given up.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use tokio::sync::{mpsc, watch};
use tokio::time::{sleep, timeout};

use super::message::WebhookMessage;
use super::post::post;
use super::target::WebhookTarget;
use crate::clock::now_ms;
use crate::metrics::{Metrics, WebhookOutcome};
use crate::pace::LogRateLimit;

static NOT_DELIVERED: LogRateLimit = LogRateLimit::new();

/// Times between attempts, and the limit after which a message is given up.
#[derive(Debug, Clone, Copy)]
pub(super) struct Retries {
    /// Longest time of an attempt.
    pub(super) attempt: Duration,
    /// Pause after the first attempt; it doubles after each further one.
    pub(super) pause: Duration,
    pub(super) longest_pause: Duration,
    /// Age at which a message is given up.
    pub(super) age: Duration,
}

impl Default for Retries {
    fn default() -> Self {
        let seconds = Duration::from_secs;
        Self { attempt: seconds(10), pause: seconds(1), longest_pause: seconds(60), age: seconds(3600) }
    }
}

/// The deliveries to one target.
pub(super) struct Deliveries {
    pub(super) target: Arc<WebhookTarget>,
    pub(super) retries: Retries,
    pub(super) metrics: Arc<Metrics>,
    /// Set when the server stops: each remaining message is tried once.
    pub(super) closed: watch::Receiver<bool>,
}

impl Deliveries {
    /// Delivers messages until the queue is closed and empty.
    pub(super) async fn run(mut self, mut messages: mpsc::Receiver<WebhookMessage>) {
        while let Some(message) = messages.recv().await {
            let outcome = self.deliver(&message).await;
            self.metrics.webhook(&self.target.name, outcome);
            self.metrics.webhooks_waiting(&self.target.name, -1);
            self.target.waiting.fetch_sub(1, Ordering::Relaxed);
        }
    }

    async fn deliver(&mut self, message: &WebhookMessage) -> WebhookOutcome {
        let mut pause = self.retries.pause;
        loop {
            let attempt = timeout(self.retries.attempt, post(&self.target, message, now_ms() / 1000)).await;
            let reason = match attempt {
                Ok(Ok(status)) if status.is_success() => return WebhookOutcome::Delivered,
                Ok(Ok(status)) if is_final(status) => {
                    self.report(message, &format!("the target answered {status}; it is not sent again"));
                    return WebhookOutcome::Refused;
                }
                Ok(Ok(status)) => format!("the target answered {status}"),
                Ok(Err(error)) => error,
                Err(_) => format!("no answer within {} s", self.retries.attempt.as_secs()),
            };
            let over = message.made.elapsed() + pause > self.retries.age;
            let closed = *self.closed.borrow();
            if closed {
                self.target.left.fetch_add(1, Ordering::Relaxed);
            }
            if over || closed {
                self.report(message, &format!("{reason}; it is given up"));
                return WebhookOutcome::GivenUp;
            }
            self.report(message, &format!("{reason}; it is sent again"));
            tokio::select! {
                () = sleep(pause) => {}
                _ = self.closed.changed() => {}
            }
            pause = (pause * 2).min(self.retries.longest_pause);
        }
    }

    fn report(&self, message: &WebhookMessage, reason: &str) {
        if let Some(left_out) = NOT_DELIVERED.pass() {
            let target = &self.target.name;
            tracing::warn!(webhook = target, id = message.id, left_out, "a webhook is not delivered: {reason}");
        }
    }
}

/// Whether the same message would get the same answer again.
fn is_final(status: hyper::StatusCode) -> bool {
    status.is_client_error() && !matches!(status.as_u16(), 408 | 425 | 429) || status.is_redirection()
}
