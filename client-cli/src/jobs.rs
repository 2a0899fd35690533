//! Lists of jobs, jobs that are run again, and the selection of jobs.

use std::time::{SystemTime, UNIX_EPOCH};

use counterpoint_proto::v1;
use counterpoint_server::utc::{date_and_time, instant};

use crate::arguments::{JobFilter, JobListArgs, JobPriority, RequestArgs, Rerun, StateFilter, TimePoint, WaitArgs};
use crate::client::{ServerSession, SubmittedJob};
use crate::error::Error;
use crate::job_status::{awaited, json_line, labels, programs, ran_ms, simulated, state_name, waits};
use crate::say::{DIM, styled};
use crate::text::{table, time};
use crate::{job_names, say};

/// Jobs of a page.
const PAGE: usize = 500;

/// Milliseconds since 1970.
pub(crate) fn now_ms() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    i64::try_from(since.as_millis()).unwrap_or(i64::MAX)
}

fn state(state: &StateFilter) -> i32 {
    match state {
        StateFilter::Queued => v1::JobState::Queued,
        StateFilter::Paused => v1::JobState::Paused,
        StateFilter::Running => v1::JobState::Running,
        StateFilter::Succeeded => v1::JobState::Succeeded,
        StateFilter::Failed => v1::JobState::Failed,
        StateFilter::Cancelled => v1::JobState::Cancelled,
    }
    .into()
}

/// A filter on the wire.
pub(crate) fn filter(arguments: &JobFilter) -> v1::JobFilter {
    v1::JobFilter {
        states: arguments.state.iter().map(state).collect(),
        machine: arguments.machine.clone().unwrap_or_default(),
        labels: arguments.labels.iter().cloned().collect(),
        from_ms: match arguments.since {
            None => 0,
            Some(TimePoint::At(ms)) => ms,
            Some(TimePoint::Span(ms)) => now_ms().saturating_sub(ms).max(1),
        },
        ..v1::JobFilter::default()
    }
}

/// Content of a submit besides programs and options.
pub(crate) fn request(arguments: &RequestArgs) -> v1::SubmitJobRequest {
    v1::SubmitJobRequest {
        request_id: arguments.request_id.clone().unwrap_or_else(counterpoint_client::request_id),
        labels: arguments.labels.iter().cloned().collect(),
        priority: match arguments.priority {
            None => v1::JobPriority::Unspecified,
            Some(JobPriority::Low) => v1::JobPriority::Low,
            Some(JobPriority::Normal) => v1::JobPriority::Normal,
            Some(JobPriority::High) => v1::JobPriority::High,
        }
        .into(),
        deadline_ms: match arguments.deadline {
            None => 0,
            Some(TimePoint::At(ms)) => ms,
            Some(TimePoint::Span(ms)) => now_ms().saturating_add(ms),
        },
        ..Default::default()
    }
}

/// Refuses a deadline that has passed. A repeated request keeps its deadline: it returns the job that it created.
pub(crate) fn check_deadline(arguments: &RequestArgs) -> Result<(), Error> {
    match arguments.deadline {
        Some(TimePoint::At(ms)) if ms <= now_ms() && arguments.request_id.is_none() => {
            let (deadline, now) = (instant(ms), instant(now_ms()));
            Err(Error::Usage(format!("--deadline: {deadline} UTC has passed, it is {now}: the job would not run")))
        }
        _ => Ok(()),
    }
}

/// Reports that the job had ended before the command: the server accepts it, and nothing changes.
pub(crate) async fn say_ended(client: &ServerSession, job: &str) -> Result<(), Error> {
    use v1::JobState::{Cancelled, Failed, Succeeded};
    let request = v1::GetJobRequest { job_id: job.to_owned() };
    let status = client.jobs().get_job(request).await?.into_inner().status.unwrap_or_default();
    if matches!(status.state(), Succeeded | Failed | Cancelled) {
        let state = status.state().as_str_name().trim_start_matches("JOB_STATE_");
        say::status_line(format!("job {job} has already ended: {state}"));
    }
    Ok(())
}

/// Runs a job again.
pub(crate) async fn rerun(arguments: Rerun) -> Result<u8, Error> {
    check_deadline(&arguments.request)?;
    let client = ServerSession::connect(&arguments.remote.server).await?;
    let job_id = job_names::whole(&client, &arguments.job).await?;
    let v1::SubmitJobRequest { request_id, labels, priority, deadline_ms, .. } = request(&arguments.request);
    let request = v1::RerunJobRequest { job_id, request_id, labels, priority, deadline_ms };
    let v1::RerunJobResponse { status, duplicate } = client.jobs().rerun_job(request).await?.into_inner();
    say_id(&SubmittedJob::of(status.unwrap_or_default(), duplicate), arguments.json)?;
    Ok(0)
}

/// Prints the id of a job, and whether an earlier call with the same request id created the job.
pub(crate) fn say_id(submitted: &SubmittedJob, json: bool) -> Result<(), Error> {
    say_notes(submitted);
    let SubmittedJob { job, duplicate, .. } = submitted;
    let text = match (json, duplicate) {
        (true, true) => serde_json::json!({ "job": job, "duplicate": true }).to_string(),
        (true, false) => serde_json::json!({ "job": job }).to_string(),
        (false, _) => job.clone(),
    };
    say::data(format!("{text}\n").as_bytes())
}

/// Reports that an earlier call created the job, and the machine that the server guessed.
pub(crate) fn say_notes(submitted: &SubmittedJob) {
    if submitted.duplicate {
        say::status_line("not submitted again: the server has accepted this request id before, for this job");
    }
    if let Some((machine, signs)) = &submitted.guess {
        say::status_line(styled(DIM, format!("machine {machine}, guessed by the server from {signs}")));
    }
}

/// At most `most` jobs of a list, page by page.
pub(crate) async fn listed(
    client: &ServerSession,
    mut request: v1::ListJobsRequest,
    most: usize,
) -> Result<Vec<v1::JobStatus>, Error> {
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
    Ok(rows)
}

/// Ids of the jobs to wait for: the named ones, those that match the filter, or all that have not ended.
pub(crate) async fn to_wait_for(client: &ServerSession, arguments: &WaitArgs) -> Result<Vec<String>, Error> {
    if !arguments.jobs.is_empty() {
        let mut ids = Vec::new();
        for job in &arguments.jobs {
            ids.push(job_names::whole(client, job).await?);
        }
        return Ok(ids);
    }
    let mut filter = filter(&arguments.filter);
    if arguments.all {
        filter.states = [v1::JobState::Queued, v1::JobState::Running].map(i32::from).to_vec();
    }
    let request = v1::ListJobsRequest { filter: Some(filter), ..Default::default() };
    let ids: Vec<String> = listed(client, request, usize::MAX).await?.into_iter().map(|job| job.job_id).collect();
    if ids.is_empty() && !arguments.all {
        let text = "no job matches the filter; try the filter with `counterpoint jobs`";
        return Err(Error::Usage(text.to_owned()));
    }
    Ok(ids)
}

/// Lists jobs.
pub(crate) async fn list(arguments: JobListArgs) -> Result<u8, Error> {
    let client = ServerSession::connect(&arguments.remote.server).await?;
    let request = v1::ListJobsRequest {
        filter: Some(filter(&arguments.filter)),
        newest_first: !arguments.oldest,
        short_ids: true,
        ..Default::default()
    };
    let rows = listed(&client, request, arguments.limit.unwrap_or(usize::MAX)).await?;
    if arguments.json {
        let lines: String = rows.iter().map(json_line).collect();
        say::data(lines.as_bytes())?;
        return Ok(0);
    }
    let head = ["job", "state", "submitted UTC", "started", "ran", "cycle time", "machine", "labels", "programs"];
    let mut lines = vec![head.map(str::to_owned).to_vec()];
    let now = now_ms();
    lines.extend(rows.iter().map(|job| row(job, arguments.long, now)));
    say::data(table(&lines, head.len()).as_bytes())?;
    let waiting = rows.iter().filter(|job| waits(job).is_some()).count();
    if let Some(wait) = rows.iter().find_map(waits) {
        say::status_line(format!("waiting jobs in this list: {waiting}; each {wait}"));
    }
    Ok(0)
}

/// A job of the list.
fn row(job: &v1::JobStatus, long: bool, now_ms: i64) -> Vec<String> {
    // An earlier server has no short ids.
    let id = if long || job.short_id.is_empty() { &job.job_id } else { &job.short_id };
    let ((day, submitted), (started_day, started)) = (date_and_time(job.submitted_ms), date_and_time(job.started_ms));
    let started = match job.started_ms {
        0 => "-".to_owned(),
        _ if started_day == day => started,
        _ => format!("{started_day} {started}"),
    };
    let ran = match ran_ms(job, now_ms) {
        _ if !job.reused_from.is_empty() => "reused".to_owned(),
        Some(ms) => time(ms.saturating_mul(1_000_000)),
        None => "-".to_owned(),
    };
    // The time at which a failed job stopped is not a cycle time.
    let cycle = simulated(job).filter(|_| job.state() == v1::JobState::Succeeded).unwrap_or_else(|| "-".to_owned());
    let (labels, submitted) = (labels(job), format!("{day} {submitted}"));
    let waits = job.operator_wait.as_ref().map(|wait| format!(" (waits for {})", awaited(wait))).unwrap_or_default();
    let state = state_name(job) + if job.suspect { " (suspect)" } else { "" } + &waits;
    vec![id.clone(), state, submitted, started, ran, cycle, job.machine.clone(), labels, programs(job)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_shows_the_wait_for_a_client() {
        let job = v1::JobStatus {
            job_id: "01938f2c".to_owned(),
            state: v1::JobState::Running.into(),
            operator_wait: Some(v1::OperatorWait {
                action: v1::OperatorAction::Command.into(),
                since_ms: 4000,
                until_ms: 64_000,
            }),
            ..Default::default()
        };
        assert_eq!(row(&job, true, 5000)[1], "RUNNING (waits for a step command)");
    }
}
