//! Many jobs: listed, followed, run again.

use std::time::{SystemTime, UNIX_EPOCH};

use counterpoint_client::JobUpdate;
use counterpoint_proto::v1;

use crate::arguments::{JobFilter, Jobs, Priority, RequestArgs, Rerun, State, Watch, When};
use crate::client::Client;
use crate::error::Error;
use crate::say;
use crate::text::{table, time};

/// Jobs of a page.
const PAGE: usize = 500;

/// Milliseconds since 1970.
fn now_ms() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    i64::try_from(since.as_millis()).unwrap_or(i64::MAX)
}

fn state(state: &State) -> i32 {
    match state {
        State::Queued => v1::JobState::Queued,
        State::Running => v1::JobState::Running,
        State::Succeeded => v1::JobState::Succeeded,
        State::Failed => v1::JobState::Failed,
        State::Cancelled => v1::JobState::Cancelled,
    }
    .into()
}

fn filter(arguments: &JobFilter) -> v1::JobFilter {
    v1::JobFilter {
        states: arguments.state.iter().map(state).collect(),
        machine: arguments.machine.clone().unwrap_or_default(),
        labels: arguments.labels.iter().cloned().collect(),
        from_ms: match arguments.since {
            None => 0,
            Some(When::At(ms)) => ms,
            Some(When::Span(ms)) => now_ms().saturating_sub(ms).max(1),
        },
        until_ms: 0,
    }
}

/// What a submit says besides programs and options.
pub(crate) fn request(arguments: &RequestArgs) -> v1::SubmitJobRequest {
    v1::SubmitJobRequest {
        request_id: arguments.request_id.clone().unwrap_or_else(counterpoint_client::request_id),
        labels: arguments.labels.iter().cloned().collect(),
        priority: match arguments.priority {
            None => v1::JobPriority::Unspecified,
            Some(Priority::Low) => v1::JobPriority::Low,
            Some(Priority::Normal) => v1::JobPriority::Normal,
            Some(Priority::High) => v1::JobPriority::High,
        }
        .into(),
        deadline_ms: match arguments.deadline {
            None => 0,
            Some(When::At(ms)) => ms,
            Some(When::Span(ms)) => now_ms().saturating_add(ms),
        },
        ..Default::default()
    }
}

/// Runs a job again.
pub(crate) async fn rerun(arguments: Rerun) -> Result<u8, Error> {
    let client = Client::connect(&arguments.remote.server).await?;
    let v1::SubmitJobRequest { request_id, labels, priority, deadline_ms, .. } = request(&arguments.request);
    let request = v1::RerunJobRequest { job_id: arguments.job, request_id, labels, priority, deadline_ms };
    let status = client.jobs().rerun_job(request).await?.into_inner().status;
    say::data(format!("{}\n", status.unwrap_or_default().job_id).as_bytes())?;
    Ok(0)
}

/// Lists jobs.
pub(crate) async fn list(arguments: Jobs) -> Result<u8, Error> {
    let client = Client::connect(&arguments.remote.server).await?;
    let most = arguments.limit.unwrap_or(usize::MAX);
    let mut request = v1::ListJobsRequest {
        filter: Some(filter(&arguments.filter)),
        newest_first: arguments.newest,
        ..Default::default()
    };
    let mut rows = Vec::new();
    while rows.len() < most {
        request.page_size = u32::try_from((most - rows.len()).min(PAGE)).unwrap_or(0);
        let page = client.jobs().list_jobs(request.clone()).await?.into_inner();
        rows.extend(page.jobs);
        if page.next_page_token.is_empty() {
            break;
        }
        request.page_token = page.next_page_token;
    }
    if arguments.json {
        let lines: String = rows.iter().map(|job| format!("{}\n", as_json(job))).collect();
        say::data(lines.as_bytes())?;
        return Ok(0);
    }
    let mut lines = vec![["job", "state", "machine", "cycle time", "programs"].map(str::to_owned).to_vec()];
    lines.extend(rows.iter().map(|job| {
        vec![job.job_id.clone(), state_name(job), job.machine.clone(), time(job.makespan_ns), programs(job)]
    }));
    say::data(table(&lines, 3).as_bytes())?;
    Ok(0)
}

/// Follows the states of jobs, reconnecting if necessary, until it is interrupted.
pub(crate) async fn watch(arguments: Watch) -> Result<u8, Error> {
    let client = Client::connect(&arguments.remote.server).await?;
    let mut watch = client.watch_jobs(filter(&arguments.filter));
    loop {
        let update = tokio::select! {
            update = watch.next() => update?,
            _ = tokio::signal::ctrl_c() => return Ok(0),
        };
        let line = match update {
            JobUpdate::Job(job) if arguments.json => as_json(&job).to_string(),
            JobUpdate::Job(job) => {
                format!("{}  {:<9}  {}  {}", job.job_id, state_name(&job), job.machine, programs(&job))
            }
            JobUpdate::Removed(job) if arguments.json => serde_json::json!({ "job": job, "removed": true }).to_string(),
            JobUpdate::Removed(job) => format!("{job}  REMOVED"),
            JobUpdate::Anew => {
                say::status_line("the server no longer knows all changes; the jobs that have not ended follow");
                continue;
            }
        };
        say::data(format!("{line}\n").as_bytes())?;
    }
}

fn state_name(job: &v1::JobStatus) -> String {
    let state = if job.paused { "PAUSED" } else { job.state().as_str_name().trim_start_matches("JOB_STATE_") };
    state.to_owned()
}

fn programs(job: &v1::JobStatus) -> String {
    job.programs.iter().map(|p| p.path.as_str()).collect::<Vec<_>>().join(" ")
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
        "ended_ms": job.ended_ms,
    });
    let mut add = |key: &str, value: serde_json::Value| {
        json.as_object_mut().map(|object| object.insert(key.to_owned(), value));
    };
    if job.cause() != v1::JobCause::Unspecified {
        add("cause", job.cause().as_str_name().trim_start_matches("JOB_CAUSE_").into());
    }
    if job.deadline_ms > 0 {
        add("deadline_ms", job.deadline_ms.into());
    }
    if job.paused {
        add("paused", true.into());
    }
    if !job.rerun_of.is_empty() {
        add("rerun_of", job.rerun_of.clone().into());
    }
    json
}
