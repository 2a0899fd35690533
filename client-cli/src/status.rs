//! `counterpoint status`: the data of a server about one job.

use counterpoint_proto::v1;
use counterpoint_server::utc::instant;

use crate::arguments::StatusArgs;
use crate::client::ServerSession;
use crate::error::Error;
use crate::job_status::{
    first_error, json_line_with, labels, programs, ran_ms, simulated, simulated_label, state_name, waits,
    waits_for_client,
};
use crate::jobs::now_ms;
use crate::outcome::errors;
use crate::progress::describe;
use crate::text::time;
use crate::{job_names, reused, say};

/// The state of a job that was at work when the server died.
const SUSPECT: &str = "the server died while this job was at work: it runs alone at first, and other jobs wait";

/// The label of a wait, and the verb of its text.
const WAITS: &str = "waits";

/// Executes the command.
pub(crate) async fn status(arguments: StatusArgs) -> Result<u8, Error> {
    let client = ServerSession::connect(&arguments.remote.server).await?;
    let job_id = job_names::whole(&client, &arguments.job).await?;
    let answer = client.jobs().get_job(v1::GetJobRequest { job_id }).await?.into_inner();
    let status = answer.status.unwrap_or_default();
    if arguments.json {
        say::data(json_line_with(&status, answer.progress.as_ref()).as_bytes())?;
    } else {
        let source = reused::source(&client, &status).await?;
        let text = shown(&status, (&answer.pinned_machine, source), now_ms());
        say::data((text + &running(answer.progress.as_ref())).as_bytes())?;
    }
    Ok(0)
}

/// The head of the report of a job: the job and, if it was not run, the source of its results.
pub(crate) fn heading(status: &v1::JobStatus) -> String {
    let labels = labels(status);
    let labelled = if labels.is_empty() { String::new() } else { format!("  {labels}") };
    let note = reused::note(status).map(|note| format!("{note}\n")).unwrap_or_default();
    format!("job {}{labelled}  submitted {} UTC\n{note}", status.job_id, instant(status.submitted_ms))
}

/// One line for each channel of a running job, and the number of events so far.
fn running(progress: Option<&v1::Progress>) -> String {
    let Some(progress) = progress else { return String::new() };
    let channel = |c: &v1::ChannelProgress| {
        let state = describe(c, progress.cancel_requested);
        format!("{:<13} {:.0} %, line {}, {state}\n", c.name, c.percent, c.line)
    };
    let events = format!("{:<13} {}\n", "events", progress.position);
    progress.channels.iter().map(channel).chain([events]).collect()
}

/// The text of a wait without the verb, which is the label of its row.
fn waiting(wait: Option<String>) -> String {
    let wait = wait.unwrap_or_default();
    wait.strip_prefix(WAITS).map(|rest| rest.trim_start().to_owned()).unwrap_or(wait)
}

/// One line for each known fact.
fn shown(job: &v1::JobStatus, (pinned, source): (&str, String), now_ms: i64) -> String {
    let machine = if job.machine_guess.is_empty() {
        pinned.to_owned()
    } else {
        format!("{pinned}, guessed from {}", job.machine_guess)
    };
    let utc = |ms: i64| if ms > 0 { format!("{} UTC", instant(ms)) } else { String::new() };
    let count = |number: u32| if number > 1 { number.to_string() } else { String::new() };
    let cause = job.cause().as_str_name().trim_start_matches("JOB_CAUSE_").to_lowercase();
    let priority = job.priority().as_str_name().trim_start_matches("JOB_PRIORITY_").to_lowercase();
    let rows = [
        ("job", job.job_id.clone()),
        ("labels", labels(job)),
        ("state", state_name(job)),
        ("machine", machine),
        ("programs", programs(job)),
        ("priority", if priority == "normal" { String::new() } else { priority }),
        ("submitted", utc(job.submitted_ms)),
        ("started", utc(job.started_ms)),
        ("ended", utc(job.ended_ms)),
        ("ran", ran_ms(job, now_ms).map(|ms| time(ms.saturating_mul(1_000_000))).unwrap_or_default()),
        ("deadline", utc(job.deadline_ms)),
        ("attempts", count(job.attempt)),
        (WAITS, waiting(waits(job))),
        (WAITS, waiting(job.operator_wait.as_ref().map(|wait| waits_for_client(&job.job_id, wait)))),
        ("suspect", if job.suspect { SUSPECT.to_owned() } else { String::new() }),
        ("rerun of", job.rerun_of.clone()),
        ("results of", source),
        (simulated_label(job), simulated(job).unwrap_or_default()),
        ("cause", if cause == "unspecified" { String::new() } else { cause }),
        ("verdict", job.verdict.clone()),
        ("error", job.error.clone()),
        ("first error", first_error(job).unwrap_or_default()),
        ("errors", errors(job).unwrap_or_default()),
        ("host", job.host_failure.clone()),
    ];
    let line = |(key, value): &(&str, String)| format!("{key:<13} {value}\n");
    rows.iter().filter(|(_, value)| !value.is_empty()).map(line).collect()
}

#[cfg(test)]
mod tests;
