//! The states of many jobs, followed until the command is interrupted.
//!
//! *Invariant:* the end of each job that matches the filter and had not ended at the start is printed, unless the job
//! has been deleted before. This also holds if the server no longer knows the changes since the cursor.

use std::collections::{HashMap, HashSet, VecDeque};

use counterpoint_client::JobUpdate;
use counterpoint_proto::v1;

use crate::arguments::WatchArgs;
use crate::client::ServerSession;
use crate::error::Error;
use crate::job_status::{json_line, programs, state_name, waits_for_client};
use crate::jobs::{filter, listed};
use crate::say;

/// Number of printed ends that are remembered regardless of their age.
const REMEMBERED: usize = 100_000;
/// Longest time between two ends that are delivered in reverse order, ms.
const OUT_OF_ORDER_MS: i64 = 3_600_000;

/// States of jobs that have not ended, for a filter. The server counts suspended jobs as running.
const OPEN: [v1::JobState; 3] = [v1::JobState::Queued, v1::JobState::Running, v1::JobState::Paused];

/// Time in the id of a job, ms since 1970: the server's time when it accepted the job; 0 if the id has none. Ids are in
/// the order of acceptance.
fn accepted_ms(job: &str) -> i64 {
    let digits: String = job.chars().filter(|c| *c != '-').take(12).collect();
    i64::from_str_radix(&digits, 16).unwrap_or(0)
}

/// The jobs that a watch has seen.
#[derive(Debug, Default)]
struct WatchedJobs {
    /// The newest job at the start, or when the server was last asked for ends. All jobs up to it that are not open
    /// have ended, and their ends were printed if they belong to the watch.
    newest: String,
    /// Jobs that had not ended when they were last seen.
    open: HashSet<String>,
    /// Later ends that were printed, with their times.
    ended: HashMap<String, i64>,
    /// Number of ends beyond which the oldest are forgotten.
    most: usize,
    /// Time of the last end.
    last_ms: i64,
    /// Jobs that ended before this time were printed.
    forgotten_ms: i64,
}

impl WatchedJobs {
    /// Records a job that was printed or is open.
    fn note(&mut self, job: &v1::JobStatus) {
        if job.ended_ms == 0 {
            self.open.insert(job.job_id.clone());
            return;
        }
        self.open.remove(&job.job_id);
        self.ended.insert(job.job_id.clone(), job.ended_ms);
        self.last_ms = self.last_ms.max(job.ended_ms);
        if self.ended.len() > self.most.max(REMEMBERED) {
            self.forgotten_ms = self.last_ms.saturating_sub(OUT_OF_ORDER_MS);
            self.ended.retain(|_, ended_ms| *ended_ms >= self.forgotten_ms);
            self.most = 2 * self.ended.len();
        }
    }

    /// Jobs accepted before this time, ms, cannot have ended without a line.
    fn since_ms(&self) -> i64 {
        let oldest = self.open.iter().map(|job| accepted_ms(job)).min();
        accepted_ms(&self.newest).min(oldest.unwrap_or(i64::MAX))
    }

    /// The ends among these jobs that were not printed. The list has all jobs since [`WatchedJobs::since_ms`].
    fn missed(&mut self, jobs: Vec<v1::JobStatus>) -> VecDeque<v1::JobStatus> {
        let new = |job: &v1::JobStatus| {
            let later = job.job_id > self.newest && job.ended_ms >= self.forgotten_ms;
            later && !self.ended.contains_key(&job.job_id)
        };
        let ended = jobs.iter().filter(|job| job.ended_ms != 0);
        let missed = ended.filter(|job| self.open.contains(&job.job_id) || new(job)).cloned().collect();
        let newest = jobs.iter().map(|job| &job.job_id).max();
        self.newest = newest.into_iter().chain([&self.newest]).max().cloned().unwrap_or_default();
        self.open = jobs.iter().filter(|job| job.ended_ms == 0).map(|job| job.job_id.clone()).collect();
        self.ended.retain(|job, _| *job > self.newest);
        self.last_ms = jobs.iter().map(|job| job.ended_ms).fold(self.last_ms, i64::max);
        missed
    }

    fn removed(&mut self, job: &str) {
        self.open.remove(job);
    }
}

/// The jobs of a server at the start of a watch.
async fn at_start(client: &ServerSession, filter: &v1::JobFilter) -> Result<WatchedJobs, Error> {
    // The newest job comes first: a job that is accepted after this call is later than it.
    let newest = v1::ListJobsRequest { newest_first: true, ..Default::default() };
    let newest = listed(client, newest, 1).await?.pop().map(|job| job.job_id).unwrap_or_default();
    let open = v1::JobFilter { states: OPEN.map(i32::from).to_vec(), ..filter.clone() };
    let request = v1::ListJobsRequest { filter: Some(open), ..Default::default() };
    let mut seen = WatchedJobs { newest, ..WatchedJobs::default() };
    listed(client, request, usize::MAX).await?.iter().for_each(|job| seen.note(job));
    Ok(seen)
}

/// The ends that were not printed, in the order of acceptance.
async fn missed(
    client: &ServerSession,
    filter: &v1::JobFilter,
    seen: &mut WatchedJobs,
) -> Result<VecDeque<v1::JobStatus>, Error> {
    let from_ms = filter.from_ms.max(seen.since_ms());
    let filter = v1::JobFilter { states: Vec::new(), from_ms, ..filter.clone() };
    let request = v1::ListJobsRequest { filter: Some(filter), ..Default::default() };
    Ok(seen.missed(listed(client, request, usize::MAX).await?))
}

/// The line of a job.
fn line(job: &v1::JobStatus, json: bool) -> String {
    if json {
        return json_line(job).trim_end().to_owned();
    }
    let line = format!("{}  {:<9}  {}  {}", job.job_id, state_name(job), job.machine, programs(job));
    let waits = job.operator_wait.as_ref().map(|wait| format!("  {}", waits_for_client(&job.job_id, wait)));
    line + if job.reused_from.is_empty() { "" } else { "  (reused)" } + &waits.unwrap_or_default()
}

/// Follows the states of jobs, reconnecting if necessary, until it is interrupted.
pub(crate) async fn watch_all(arguments: WatchArgs) -> Result<u8, Error> {
    let client = ServerSession::connect(&arguments.remote.server).await?;
    let filter = filter(&arguments.filter);
    let wanted = |job: &v1::JobStatus| filter.states.is_empty() || filter.states.contains(&job.state);
    let mut seen = at_start(&client, &filter).await?;
    let mut watch = client.watch_jobs(filter.clone());
    loop {
        let update = tokio::select! {
            update = watch.next() => update?,
            _ = tokio::signal::ctrl_c() => return Ok(0),
        };
        let line = match update {
            JobUpdate::Job(job) => {
                seen.note(&job);
                line(&job, arguments.json)
            }
            JobUpdate::Removed(job) => {
                seen.removed(&job);
                match arguments.json {
                    true => serde_json::json!({ "job": job, "removed": true }).to_string(),
                    false => format!("{job}  REMOVED"),
                }
            }
            JobUpdate::Anew => {
                say::status_line(
                    "the server no longer knows all changes; the jobs that have ended in the meantime follow, then \
                     those that have not ended",
                );
                for job in missed(&client, &filter, &mut seen).await?.iter().filter(|job| wanted(job)) {
                    say::data(format!("{}\n", line(job, arguments.json)).as_bytes())?;
                }
                continue;
            }
        };
        say::data(format!("{line}\n").as_bytes())?;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_watch_shows_the_wait_for_a_client() {
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
        let line = line(&job, false);
        let text = "  waits for a step command since 1970-01-01 00:00:04 UTC, until 1970-01-01 00:01:04 UTC: counterpoint \
                    step 01938f2c (needs the role operate)";
        assert!(line.starts_with("01938f2c  RUNNING") && line.ends_with(text), "{line}");
    }

    /// The job with this number, which the server accepted at this time; it ended then, or has not ended (0).
    fn job(number: i64, ended_ms: i64) -> v1::JobStatus {
        let job_id = format!("{:08x}-{:04x}-7000-8000-000000000000", number >> 16, number & 0xffff);
        v1::JobStatus { job_id, ended_ms, ..Default::default() }
    }

    fn numbers(jobs: &VecDeque<v1::JobStatus>) -> Vec<i64> {
        jobs.iter().map(|job| accepted_ms(&job.job_id)).collect()
    }

    #[test]
    fn ends_are_found_in_any_order_of_their_times_and_with_any_clock_of_the_client() {
        let mut seen = WatchedJobs { newest: job(1000, 0).job_id, ..WatchedJobs::default() };
        // 900 was open at the start; 1001 and 1002 came later, and the end of 1002 was delivered first.
        [job(900, 0), job(1001, 0), job(1002, 5000)].iter().for_each(|job| seen.note(job));
        assert_eq!(seen.since_ms(), 900);
        // 1003 was accepted while the watch was cut off and ended before 1002; 950 had ended before the watch began.
        let list = [job(900, 4000), job(950, 800), job(1001, 3000), job(1002, 5000), job(1003, 4500), job(1004, 0)];
        assert_eq!(numbers(&seen.missed(list.to_vec())), [900, 1001, 1003]);
        // The next time nothing is printed again.
        assert_eq!(seen.since_ms(), 1004);
        assert_eq!(numbers(&seen.missed([job(1004, 9000), job(1005, 8000)].to_vec())), [1004, 1005]);
        assert_eq!(numbers(&seen.missed([job(1005, 8000)].to_vec())), Vec::<i64>::new());
    }

    #[test]
    fn ends_of_a_long_watch_are_forgotten_and_not_printed_again() {
        let mut seen = WatchedJobs::default();
        let count = i64::try_from(REMEMBERED).unwrap() + 1;
        let end = |number: i64| number * 1000;
        seen.note(&job(1, 0));
        (2..=2 * count).for_each(|number| seen.note(&job(number, end(number))));
        assert!(seen.ended.len() <= REMEMBERED, "{}", seen.ended.len());
        // A late end of an open job is printed, and one that was delivered shortly before the last one is not repeated.
        let list = [job(1, 10), job(2, end(2)), job(2 * count, end(2 * count)), job(2 * count + 1, end(2 * count) - 1)];
        assert_eq!(numbers(&seen.missed(list.to_vec())), [1, 2 * count + 1]);
    }
}
