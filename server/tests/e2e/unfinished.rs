//! Data of a run that did not reach its end are not results of a job.

use std::fs;

use counterpoint_proto::v1;
use counterpoint_server::options::ServerOptions;

use crate::support::*;

/// The server stops after the run of a job has stored everything except its end. The next server cancels the job before
/// the job runs again.
#[tokio::test(flavor = "multi_thread")]
async fn results_of_a_run_that_did_not_end_are_not_served() {
    let folder = tempfile::tempdir().unwrap();
    let (ledger, early) = (folder.path().join("ledger.redb"), folder.path().join("early"));
    let waits = || ServerOptions { min_free_bytes: u64::MAX, ..options(folder.path()) };
    let server = Server::start(ServerOptions { workers: 1, ..options(folder.path()) }).await;
    let busy = server.submit("busy", "HANG").await;
    server.until(&busy, v1::JobState::Running).await;
    let job = server.submit("job", "EVENTS 5000\nWRITE out.txt").await;
    server.jobs().pause_job(v1::PauseJobRequest { job_id: job.clone() }).await.unwrap();
    server.jobs().cancel_job(v1::CancelJobRequest { job_id: busy.clone() }).await.unwrap();
    server.stop().await;
    fs::copy(&ledger, &early).unwrap();
    let server = Server::start(options(folder.path())).await;
    server.jobs().resume_job(v1::ResumeJobRequest { job_id: job.clone() }).await.unwrap();
    assert_eq!(server.wait(&job).await.state(), v1::JobState::Succeeded);
    server.stop().await;
    fs::copy(&early, &ledger).unwrap();
    assert!(folder.path().join("jobs").join(&job).join("files.json").exists());

    let server = Server::start(waits()).await;
    server.jobs().cancel_job(v1::CancelJobRequest { job_id: job.clone() }).await.unwrap();
    let status = server.wait(&job).await;
    assert_eq!((status.state(), status.events), (v1::JobState::Cancelled, 0));
    let mut results = server.results();
    let summary = results.get_summary(v1::GetSummaryRequest { job_id: job.clone() }).await;
    let events = results.get_events(v1::GetEventsRequest { job_id: job.clone() }).await;
    let files = results.list_files(v1::ListFilesRequest { job_id: job.clone(), ..Default::default() }).await;
    let refused = [summary.map(drop).unwrap_err(), events.map(drop).unwrap_err(), files.map(drop).unwrap_err()];
    assert_eq!(refused.map(|refusal| reason(&refusal)), ["NO_RESULTS"; 3]);
    server.stop().await;
}
