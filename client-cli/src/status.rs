//! `counterpoint status`: the data of a server about one job.

use counterpoint_proto::v1;
use counterpoint_server::utc::instant;

use crate::arguments::Status;
use crate::client::Client;
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
pub(crate) async fn status(arguments: Status) -> Result<u8, Error> {
    let client = Client::connect(&arguments.remote.server).await?;
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
mod tests {
    use super::*;

    #[test]
    fn what_is_not_known_is_left_out() {
        let job = v1::JobStatus {
            job_id: "01938f2c".to_owned(),
            state: v1::JobState::Running.into(),
            submitted_ms: 1000,
            started_ms: 3000,
            attempt: 1,
            labels: [("name".to_owned(), "bracket 17".to_owned()), ("shift".to_owned(), "early".to_owned())].into(),
            machine_guess: "T1 M6 (line 2)".to_owned(),
            suspect: true,
            operator_wait: Some(v1::OperatorWait {
                action: v1::OperatorAction::Answer.into(),
                since_ms: 4000,
                until_ms: 64_000,
            }),
            priority: v1::JobPriority::Normal.into(),
            ..Default::default()
        };
        let text = shown(&job, ("fanuc-mill", String::new()), 4500);
        assert_eq!(
            text.lines().collect::<Vec<_>>(),
            [
                "job           01938f2c",
                "labels        bracket 17 shift=early",
                "state         RUNNING",
                "machine       fanuc-mill, guessed from T1 M6 (line 2)",
                "submitted     1970-01-01 00:00:01 UTC",
                "started       1970-01-01 00:00:03 UTC",
                "ran           00:01.500",
                "waits         for an operator since 1970-01-01 00:00:04 UTC, until 1970-01-01 00:01:04 UTC: counterpoint attend \
                 01938f2c (needs the role operate)",
                "suspect       the server died while this job was at work: it runs alone at first, and other jobs wait",
            ]
        );
        assert_eq!(heading(&job), "job 01938f2c  bracket 17 shift=early  submitted 1970-01-01 00:00:01 UTC\n");
    }

    #[test]
    fn a_running_job_has_its_progress() {
        let channel = v1::ChannelProgress {
            name: "UPPER".to_owned(),
            state: v1::ChannelState::Waiting.into(),
            blocks: 500,
            line: 12,
            percent: 40.2,
            t_ns: 61_234_000_000,
            waiting_for: "M101 with 2".to_owned(),
            ..Default::default()
        };
        let progress = v1::Progress { position: 1200, channels: vec![channel], ..Default::default() };
        assert_eq!(
            running(Some(&progress)).lines().collect::<Vec<_>>(),
            ["UPPER         40 %, line 12, block 500  01:01.234  waits for M101 with 2", "events        1200",]
        );
        assert_eq!(running(None), "");
    }

    #[test]
    fn only_a_job_that_has_succeeded_has_a_cycle_time() {
        let shown_of = |state: v1::JobState, log_digest: &str| {
            let (state, log_digest) = (state.into(), log_digest.to_owned());
            let job =
                v1::JobStatus { state, log_digest, ended_ms: 1000, makespan_ns: 2_500_000_000, ..Default::default() };
            shown(&job, ("fanuc-mill", String::new()), 2000)
        };
        assert!(shown_of(v1::JobState::Succeeded, "aa").contains("\ncycle time    00:02.500\n"));
        assert!(shown_of(v1::JobState::Failed, "aa").contains("\nstopped after 00:02.500\n"));
        for absent in ["cycle time", "stopped after"] {
            let text = shown_of(v1::JobState::Cancelled, "");
            assert!(!text.contains(absent), "the job was not run: {text}");
        }
    }
}
