//! The status of a job as words, and as JSON.

use counterpoint_proto::v1;
use counterpoint_server::utc::instant;

use crate::arguments::NAME;
use crate::text::time;
use crate::visible::visible;

/// Duration of the last run of a job, or of the current run so far, ms; none for a waiting job.
pub(crate) fn ran_ms(job: &v1::JobStatus, now_ms: i64) -> Option<i64> {
    let end = match (job.ended_ms, job.state()) {
        (0, v1::JobState::Running) => now_ms,
        (0, _) => return None,
        (ended, _) => ended,
    };
    (job.started_ms > 0).then(|| end.saturating_sub(job.started_ms).max(0))
}

/// The first error of a failed job with its place: `part.nc:3: 2900061 division by zero`.
pub(crate) fn first_error(job: &v1::JobStatus) -> Option<String> {
    let v1::JobError { number, text, file, line, channel } = job.first_error.as_ref()?;
    let place = match (file.is_empty(), line) {
        (true, _) if *channel > 0 => format!("channel {channel}: "),
        (true, _) => String::new(),
        (false, 0) => format!("{file}: "),
        (false, line) => format!("{file}:{line}: "),
    };
    let number = if *number > 0 { format!("{number} ") } else { String::new() };
    Some(format!("{place}{number}{text}"))
}

/// Why a job waits although workers may be free.
pub(crate) fn waits(job: &v1::JobStatus) -> Option<String> {
    let suspect = match job.waits_for_job.as_str() {
        "" => "a job of another tenant".to_owned(),
        id => format!("job {id}"),
    };
    let alone = || format!("waits while {suspect}, suspected of causing the last crash, runs alone");
    job.waits_for_suspect.then(alone).or_else(|| job.worker_wait.as_ref().map(waits_for_worker))
}

/// The wait of a queued job for a worker that jobs of the same tenant hold.
fn waits_for_worker(wait: &v1::WorkerWait) -> String {
    let v1::WorkerWait { workers, waiting_for_client, tenant_running } = *wait;
    let waiting = match waiting_for_client {
        1 => "1 of them waits for a client".to_owned(),
        count => format!("{count} of them wait for a client"),
    };
    let quota = format!("your tenant already uses its {workers} (tenant_running)");
    let held = match (tenant_running, waiting_for_client) {
        (false, count) if count == workers => {
            return "waits for a worker: all run jobs that wait for a client".to_owned();
        }
        (false, _) => format!("your jobs use all {workers}, and {waiting}"),
        (true, 0) => quota,
        (true, _) => format!("{quota}, and {waiting}"),
    };
    format!("waits for a worker: {held}")
}

/// The kind of client for which a running job waits: `an operator`, `a step command`.
pub(crate) fn awaited(wait: &v1::OperatorWait) -> &'static str {
    match wait.action() {
        v1::OperatorAction::Command => "a step command",
        v1::OperatorAction::Answer | v1::OperatorAction::Unspecified => "an operator",
    }
}

/// The wait of a running job for a client, and the command that ends the wait.
pub(crate) fn waits_for_client(job: &str, wait: &v1::OperatorWait) -> String {
    let command = match wait.action() {
        v1::OperatorAction::Command => "step",
        v1::OperatorAction::Answer | v1::OperatorAction::Unspecified => "attend",
    };
    // Older servers do not report the end.
    let until = if wait.until_ms > 0 { format!(", until {} UTC", instant(wait.until_ms)) } else { String::new() };
    let (client, since) = (awaited(wait), instant(wait.since_ms));
    format!("waits for {client} since {since} UTC{until}: counterpoint {command} {job} (needs the role operate)")
}

/// The action that a job needs in order to continue: the wait for a client, or the pause.
pub(crate) fn held(job: &str, wait: Option<&v1::OperatorWait>, paused: bool) -> Option<String> {
    match wait {
        _ if paused => Some(format!("paused: counterpoint resume {job}")),
        wait => wait.map(|wait| waits_for_client(job, wait)),
    }
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
    visible(&name.into_iter().chain(others).collect::<Vec<_>>().join(" ")).into_owned()
}

/// The state of a job. A job whose cancellation was requested is CANCELLING until its run has stopped.
pub(crate) fn state_name(job: &v1::JobStatus) -> String {
    let open = matches!(job.state(), v1::JobState::Queued | v1::JobState::Running);
    let state = match job.state().as_str_name().trim_start_matches("JOB_STATE_") {
        _ if open && job.cancel_requested => "CANCELLING",
        _ if job.paused => "PAUSED",
        state => state,
    };
    state.to_owned()
}

pub(crate) fn programs(job: &v1::JobStatus) -> String {
    visible(&job.programs.iter().map(|p| p.path.as_str()).collect::<Vec<_>>().join(" ")).into_owned()
}

/// A job as a line of JSON.
pub(crate) fn json_line(job: &v1::JobStatus) -> String {
    format!("{}\n", visible(&as_json(job).to_string()))
}

/// The same with the progress of the job.
pub(crate) fn json_line_with(job: &v1::JobStatus, progress: Option<&v1::Progress>) -> String {
    let mut json = as_json(job);
    if let (Some(object), Some(progress)) = (json.as_object_mut(), progress) {
        object.insert("events".to_owned(), progress.position.into());
        object.insert("progress".to_owned(), progress.channels.iter().map(channel_as_json).collect());
    }
    format!("{}\n", visible(&json.to_string()))
}

fn channel_as_json(channel: &v1::ChannelProgress) -> serde_json::Value {
    serde_json::json!({
        "channel": channel.channel,
        "name": channel.name,
        "state": channel.state().as_str_name().trim_start_matches("CHANNEL_STATE_"),
        "blocks": channel.blocks,
        "line": channel.line,
        "percent": channel.percent,
        "t_ns": channel.t_ns,
        "waiting_for": channel.waiting_for,
    })
}

fn as_json(job: &v1::JobStatus) -> serde_json::Value {
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
    if job.waits_for_suspect {
        add("waits_for_suspect", true.into());
    }
    if !job.waits_for_job.is_empty() {
        add("waits_for_job", job.waits_for_job.clone().into());
    }
    if job.paused {
        add("paused", true.into());
    }
    if let Some(wait) = &job.operator_wait {
        let action = wait.action().as_str_name().trim_start_matches("OPERATOR_ACTION_");
        add(
            "operator_wait",
            serde_json::json!({ "action": action, "since_ms": wait.since_ms, "until_ms": wait.until_ms }),
        );
    }
    if let Some(v1::WorkerWait { workers, waiting_for_client, tenant_running }) = job.worker_wait {
        let wait = serde_json::json!({
            "workers": workers, "waiting_for_client": waiting_for_client, "tenant_running": tenant_running,
        });
        add("worker_wait", wait);
    }
    if job.cancel_requested {
        add("cancel_requested", true.into());
    }
    if let Some(v1::JobError { number, text, file, line, channel }) = &job.first_error {
        let (number, line, channel) = (*number, *line, *channel);
        let error =
            serde_json::json!({ "number": number, "text": text, "file": file, "line": line, "channel": channel });
        add("first_error", error);
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

#[cfg(test)]
mod tests;
