//! `cancel` and `delete`, for one job or for the jobs of a filter.
//!
//! *Invariant:* jobs of a filter are cancelled or deleted only after a confirmation, on the terminal or by `--yes`.

use std::io::{BufRead as _, IsTerminal as _, Write as _, stdin};

use counterpoint_proto::v1;

use crate::arguments::{JobFilter, Many};
use crate::client::ServerSession;
use crate::error::Error;
use crate::{job_names, jobs, say};

/// Action on the selected jobs.
#[derive(Debug, Clone, Copy)]
pub(crate) enum JobAction {
    Cancel,
    Delete,
}

impl JobAction {
    fn verb(self) -> &'static str {
        match self {
            Self::Cancel => "cancel",
            Self::Delete => "delete",
        }
    }

    fn done(self) -> &'static str {
        match self {
            Self::Cancel => "cancelled",
            Self::Delete => "deleted",
        }
    }

    async fn one(self, client: &ServerSession, job_id: String) -> Result<(), Error> {
        match self {
            Self::Cancel => {
                jobs::say_ended(client, &job_id).await?;
                client.jobs().cancel_job(v1::CancelJobRequest { job_id }).await?;
            }
            Self::Delete => drop(client.jobs().delete_job(v1::DeleteJobRequest { job_id }).await?),
        }
        Ok(())
    }

    /// Acts on one page of jobs, or only lists it; returns the ids and the token of the next page.
    async fn page(
        self,
        client: &ServerSession,
        filter: &v1::JobFilter,
        all: bool,
        dry_run: bool,
        page_token: String,
    ) -> Result<(Vec<String>, String), Error> {
        let (filter, page_size) = (Some(filter.clone()), 0);
        Ok(match self {
            Self::Cancel => {
                let request = v1::CancelJobsRequest { filter, all, dry_run, page_size, page_token };
                let answer = client.jobs().cancel_jobs(request).await?.into_inner();
                (answer.job_ids, answer.next_page_token)
            }
            Self::Delete => {
                let request = v1::DeleteJobsRequest { filter, all, dry_run, page_size, page_token };
                let answer = client.jobs().delete_jobs(request).await?.into_inner();
                (answer.job_ids, answer.next_page_token)
            }
        })
    }

    /// Acts on all pages of jobs, or only lists them; returns the number of jobs.
    async fn pages(
        self,
        client: &ServerSession,
        filter: &JobFilter,
        all: bool,
        dry_run: bool,
        mut each: impl FnMut(&str) -> Result<(), Error>,
    ) -> Result<usize, Error> {
        let (filter, mut token, mut count) = (jobs::filter(filter), String::new(), 0);
        loop {
            let (ids, next) = self.page(client, &filter, all, dry_run, token).await?;
            count += ids.len();
            ids.iter().try_for_each(|id| each(id))?;
            if next.is_empty() {
                return Ok(count);
            }
            token = next;
        }
    }
}

/// A number of jobs in words.
fn jobs_of(count: usize) -> String {
    if count == 1 { "1 job".to_owned() } else { format!("{count} jobs") }
}

/// Whether the user confirms the action.
fn confirmed(act: JobAction, count: usize) -> Result<bool, Error> {
    let (verb, jobs) = (act.verb(), jobs_of(count));
    if !stdin().is_terminal() {
        return Err(Error::Usage(format!(
            "this would {verb} {jobs}: add --yes to do it, or --dry-run to list their ids"
        )));
    }
    let _ = write!(anstream::stderr(), "{verb} {jobs}? [y/N] ");
    let mut answer = String::new();
    stdin().lock().read_line(&mut answer).map_err(Error::file("standard input"))?;
    Ok(matches!(answer.trim().to_ascii_lowercase().as_str(), "y" | "yes"))
}

/// Executes `cancel` or `delete`.
pub(crate) async fn act(act: JobAction, arguments: Many) -> Result<u8, Error> {
    let client = ServerSession::connect(&arguments.remote.server).await?;
    let Many { job, filter, all, dry_run, yes, quiet, .. } = arguments;
    if let Some(job) = job {
        let job = job_names::whole(&client, &job).await?;
        act.one(&client, job).await?;
        return Ok(0);
    }
    let shown = |id: &str| say::data(format!("{id}\n").as_bytes());
    if dry_run {
        let count = act.pages(&client, &filter, all, true, shown).await?;
        say::status_line(format_args!("{} would be {}", jobs_of(count), act.done()));
        return Ok(0);
    }
    if !yes {
        let count = act.pages(&client, &filter, all, true, |_| Ok(())).await?;
        if count > 0 && !confirmed(act, count)? {
            say::status_line("nothing was changed");
            return Ok(0);
        }
    }
    let count = act.pages(&client, &filter, all, false, |id| if quiet { Ok(()) } else { shown(id) }).await?;
    say::status_line(format_args!("{} {}", jobs_of(count), act.done()));
    Ok(0)
}
