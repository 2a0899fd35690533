//! Jobs by the beginning of their ids, as `jobs` shows them.
//!
//! *Invariant:* a job is never chosen among several: the common beginning of more than one id is refused.

use std::fmt::Write as _;

use counterpoint_proto::v1;
use counterpoint_server::utc::instant;

use crate::client::ServerSession;
use crate::error::Error;
use crate::job_status::{labels, programs, state_name};

/// Minimum number of characters of the beginning of an id.
const FEWEST: usize = 4;
/// Digits of a whole id.
const DIGITS: usize = 32;
/// Maximum number of candidates that a refusal lists.
const LISTED: usize = 10;

/// Hexadecimal digits of an id or of its beginning; none if the text is neither.
fn digits(text: &str) -> Option<String> {
    let digits: String = text.chars().filter(|c| *c != '-').map(|c| c.to_ascii_lowercase()).collect();
    let hexadecimal = !digits.is_empty() && digits.len() <= DIGITS && digits.bytes().all(|b| b.is_ascii_hexdigit());
    hexadecimal.then_some(digits)
}

/// The whole id of the job that a text means. A text that cannot be the beginning of an id is left to the server, which
/// refuses it by name.
pub(crate) async fn whole(client: &ServerSession, text: &str) -> Result<String, Error> {
    let Some(digits) = digits(text).filter(|digits| digits.len() < DIGITS) else { return Ok(text.to_owned()) };
    if digits.len() < FEWEST {
        return Err(Error::Usage(format!(
            "'{text}' is too short for a job: give at least {FEWEST} characters of its id"
        )));
    }
    let found = beginning(client, &digits).await?;
    match found.as_slice() {
        [] => Err(Error::Usage(format!("no job begins with '{text}': `counterpoint jobs` lists the jobs"))),
        [job] => Ok(job.job_id.clone()),
        several => Err(Error::Usage(ambiguous(text, several))),
    }
}

/// The newest jobs whose ids have this beginning, at most one more than a refusal lists.
async fn beginning(client: &ServerSession, digits: &str) -> Result<Vec<v1::JobStatus>, Error> {
    let filter = v1::JobFilter { id_prefix: digits.to_owned(), ..Default::default() };
    let page_size = u32::try_from(LISTED + 1).unwrap_or(u32::MAX);
    let mut request = v1::ListJobsRequest { filter: Some(filter), newest_first: true, page_size, ..Default::default() };
    let mut found = Vec::new();
    loop {
        let page = client.jobs().list_jobs(request.clone()).await?.into_inner();
        // An earlier server does not know the filter and lists all jobs.
        found.extend(page.jobs.into_iter().filter(|job| job.job_id.replace('-', "").starts_with(digits)));
        if page.next_page_token.is_empty() || found.len() > LISTED {
            return Ok(found);
        }
        request.page_token = page.next_page_token;
    }
}

/// The reason why the beginning of an id selects no job, with the candidates.
fn ambiguous(text: &str, jobs: &[v1::JobStatus]) -> String {
    let mut out = format!("several jobs begin with '{text}': give more of the id");
    for job in jobs.iter().take(LISTED) {
        let line = format!(
            "  {}  {:<9}  {}  {}  {}  {}",
            job.job_id,
            state_name(job),
            instant(job.submitted_ms),
            job.machine,
            labels(job),
            programs(job)
        );
        let _ = write!(out, "\n{}", line.trim_end());
    }
    if jobs.len() > LISTED {
        out.push_str("\n  and more");
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_beginning_of_an_id_is_looked_for() {
        assert_eq!(digits("01938F2C-5d1e").as_deref(), Some("01938f2c5d1e"));
        for text in ["", "-", "nodir", "01938f2c/", "0".repeat(33).as_str()] {
            assert_eq!(digits(text), None, "{text}");
        }
    }

    #[test]
    fn a_refusal_lists_what_could_be_meant() {
        let job = |n: usize| v1::JobStatus {
            job_id: format!("01938f2c-{n}"),
            machine: "fanuc-mill".to_owned(),
            state: v1::JobState::Failed.into(),
            submitted_ms: 1000,
            ..Default::default()
        };
        let jobs: Vec<_> = (0..=LISTED).map(job).collect();
        let text = ambiguous("0193", &jobs[..2]);
        assert_eq!(
            text.lines().collect::<Vec<_>>(),
            [
                "several jobs begin with '0193': give more of the id",
                "  01938f2c-0  FAILED     1970-01-01 00:00:01  fanuc-mill",
                "  01938f2c-1  FAILED     1970-01-01 00:00:01  fanuc-mill",
            ]
        );
        assert_eq!(ambiguous("0193", &jobs).lines().last(), Some("  and more"));
    }
}
