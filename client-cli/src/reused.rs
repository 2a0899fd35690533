//! Jobs that have the results of an equal job instead of a run.

use counterpoint_proto::v1;
use counterpoint_server::utc::instant;

use crate::client::ServerSession;
use crate::error::Error;

/// Characters of an id in a printed line; commands accept this prefix.
const SHORT: usize = 18;

/// Says that the job has not been run and names the job whose results it has; `None` after a run.
pub(crate) fn note(status: &v1::JobStatus) -> Option<String> {
    let from = &status.reused_from;
    let short = from.get(..SHORT).unwrap_or(from);
    let of = (status.reused_ended_ms > 0).then(|| format!(" of {} UTC", instant(status.reused_ended_ms)));
    let of = of.unwrap_or_default();
    (!from.is_empty()).then(|| format!("not run: results of equal job {short}{of} (submit --no-cache runs it)"))
}

/// The equal job whose results a job has, with the end of its run, and whether it was deleted.
pub(crate) async fn source(client: &ServerSession, status: &v1::JobStatus) -> Result<String, Error> {
    let job_id = status.reused_from.clone();
    if job_id.is_empty() {
        return Ok(job_id);
    }
    let found = client.jobs().get_job(v1::GetJobRequest { job_id: job_id.clone() }).await;
    let deleted = match found {
        Ok(_) => "",
        Err(refusal) if refusal.code() == tonic::Code::NotFound => " (deleted)",
        Err(refusal) => return Err(refusal.into()),
    };
    let ended =
        if status.reused_ended_ms > 0 { format!("  {} UTC", instant(status.reused_ended_ms)) } else { String::new() };
    Ok(format!("{job_id}{ended}{deleted}"))
}

#[cfg(test)]
mod tests {
    use super::note;
    use counterpoint_proto::v1::JobStatus;

    #[test]
    fn the_note_names_the_earlier_job_and_the_end_of_its_run() {
        let reused_from = "01a22750-0402-7000-8000-000000000001".to_owned();
        let status = JobStatus { reused_from, reused_ended_ms: 951_827_696_000, ..JobStatus::default() };
        let text =
            "not run: results of equal job 01a22750-0402-7000 of 2000-02-29 12:34:56 UTC (submit --no-cache runs it)";
        assert_eq!(note(&status).as_deref(), Some(text));
        let early = JobStatus { reused_ended_ms: 0, ..status };
        let text = "not run: results of equal job 01a22750-0402-7000 (submit --no-cache runs it)";
        assert_eq!(note(&early).as_deref(), Some(text), "of an earlier server");
        assert_eq!(note(&JobStatus::default()), None);
    }
}
