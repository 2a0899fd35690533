//! The message about the end of a job.

use std::time::Instant;

use serde_json::json;

use crate::ledger::record::{Cause, JobRecord, JobState};

/// A message.
#[derive(Debug, Clone)]
pub(super) struct WebhookMessage {
    /// The same for every attempt, and for a job whose end was reported before the server died.
    pub(super) id: String,
    pub(super) body: String,
    pub(super) made: Instant,
}

/// The cause of a failure, as the status of the job names it.
fn cause(cause: Cause) -> &'static str {
    match cause {
        Cause::Program => "PROGRAM",
        Cause::Machine => "MACHINE",
        Cause::Limit => "LIMIT",
        Cause::Host => "HOST",
    }
}

impl WebhookMessage {
    /// The message about a job that has ended.
    pub(super) fn of(record: &JobRecord) -> Self {
        let state = match record.state {
            JobState::Queued => "QUEUED",
            JobState::Running => "RUNNING",
            JobState::Succeeded => "SUCCEEDED",
            JobState::Failed => "FAILED",
            JobState::Cancelled => "CANCELLED",
        };
        let body = json!({
            "type": "job.ended",
            "timestamp_ms": record.ended_ms,
            "data": {
                "job_id": record.id,
                "request_id": record.request_id,
                "tenant": record.tenant,
                "machine": record.machine_name,
                "labels": record.asked.labels,
                "state": state,
                "cause": record.runs.cause.map(cause),
                "error": record.error,
                "first_error": record.first_error,
                "verdict": record.verdict,
                "limit": record.runs.reached.map(|limit| limit.name()),
                "reused_from": Some(&record.reuse.from).filter(|from| !from.is_empty()),
                "submitted_ms": record.submitted_ms,
                "started_ms": record.runs.started_ms,
                "ended_ms": record.ended_ms,
                "events": record.events,
                "makespan_ns": record.makespan_ns,
                "log_digest": record.log_digest,
            },
        });
        Self { id: format!("job_{}", record.id), body: body.to_string(), made: Instant::now() }
    }
}
