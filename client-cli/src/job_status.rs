//! The status of a job as words, and as JSON.

use counterpoint_proto::v1;

use crate::arguments::NAME;
use crate::text::time;

/// Duration of the last run of a job, or of the current run so far, ms; none for a waiting job.
pub(crate) fn ran_ms(job: &v1::JobStatus, now_ms: i64) -> Option<i64> {
    let end = match (job.ended_ms, job.state()) {
        (0, v1::JobState::Running) => now_ms,
        (0, _) => return None,
        (ended, _) => ended,
    };
    (job.started_ms > 0).then(|| end.saturating_sub(job.started_ms).max(0))
}

/// The simulated time of an ended job; `None` if no run has finished.
pub(crate) fn simulated(job: &v1::JobStatus) -> Option<String> {
    (job.ended_ms > 0 && !job.log_digest.is_empty()).then(|| time(job.makespan_ns))
}

/// The name of the simulated time: only a job that has succeeded has a cycle time.
pub(crate) fn simulated_label(job: &v1::JobStatus) -> &'static str {
    if job.state() == v1::JobState::Succeeded { "cycle time" } else { "stopped after" }
}

/// The labels of a job, its name first: `bracket 17 order=4711`.
pub(crate) fn labels(job: &v1::JobStatus) -> String {
    let name = job.labels.get(NAME).cloned();
    let others = job.labels.iter().filter(|(key, _)| *key != NAME).map(|(key, value)| format!("{key}={value}"));
    name.into_iter().chain(others).collect::<Vec<_>>().join(" ")
}

pub(crate) fn state_name(job: &v1::JobStatus) -> String {
    let state = if job.paused { "PAUSED" } else { job.state().as_str_name().trim_start_matches("JOB_STATE_") };
    state.to_owned()
}

pub(crate) fn programs(job: &v1::JobStatus) -> String {
    job.programs.iter().map(|p| p.path.as_str()).collect::<Vec<_>>().join(" ")
}

pub(crate) fn as_json(job: &v1::JobStatus) -> serde_json::Value {
    let mut json = serde_json::json!({
        "job": job.job_id,
        "request_id": job.request_id,
        "state": job.state().as_str_name().trim_start_matches("JOB_STATE_"),
        "machine": job.machine,
        "programs": job.programs.iter().map(|p| p.path.as_str()).collect::<Vec<_>>(),
        "makespan_ns": job.makespan_ns,
        "events": job.events,
        "highest_severity": job.highest_severity,
        "verdict": job.verdict,
        "error": job.error,
        "log_digest": job.log_digest,
        "tenant": job.tenant,
        "labels": job.labels,
        "priority": job.priority().as_str_name().trim_start_matches("JOB_PRIORITY_"),
        "submitted_ms": job.submitted_ms,
        "started_ms": job.started_ms,
        "ended_ms": job.ended_ms,
        "attempt": job.attempt,
        "cpu_us": job.cpu_us,
    });
    let mut add = |key: &str, value: serde_json::Value| {
        json.as_object_mut().map(|object| object.insert(key.to_owned(), value));
    };
    if job.cause() != v1::JobCause::Unspecified {
        add("cause", job.cause().as_str_name().trim_start_matches("JOB_CAUSE_").into());
    }
    if job.limit() != v1::JobLimit::Unspecified {
        add("limit", job.limit().as_str_name().trim_start_matches("JOB_LIMIT_").into());
    }
    if !job.short_id.is_empty() {
        add("short_id", job.short_id.clone().into());
    }
    if job.deadline_ms > 0 {
        add("deadline_ms", job.deadline_ms.into());
    }
    if job.suspect {
        add("suspect", true.into());
    }
    if job.paused {
        add("paused", true.into());
    }
    if !job.rerun_of.is_empty() {
        add("rerun_of", job.rerun_of.clone().into());
    }
    if !job.reused_from.is_empty() {
        add("reused_from", job.reused_from.clone().into());
    }
    if job.reused_ended_ms > 0 {
        add("reused_ended_ms", job.reused_ended_ms.into());
    }
    json
}
