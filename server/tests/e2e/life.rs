//! The life of jobs: ends, cancel, delete, restart, drain, results.

use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::Duration;

use counterpoint_proto::v1;
use counterpoint_proto::v1::watch_job_response::Content;
use counterpoint_server::options::{Maxima, ServerOptions};
use tonic::Code;

use crate::support::*;

#[tokio::test]
async fn every_end_has_its_state_and_the_server_lives_on() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let good = server.submit("good", "EVENTS 5").await;
    let alarm = server.submit("alarm", "EVENTS 5\nALARM").await;
    let panic = server.submit("panic", "EVENTS 5\nPANIC").await;
    let refused = server.submit("refused", "REFUSE").await;
    assert_eq!(server.wait(&good).await.state(), v1::JobState::Succeeded);
    let status = server.wait(&alarm).await;
    assert_eq!((status.state(), status.highest_severity, status.events), (v1::JobState::Failed, 9, 6));
    let status = server.wait(&panic).await;
    assert_eq!((status.state(), status.error.as_str()), (v1::JobState::Failed, "internal error: scripted"));
    let status = server.wait(&refused).await;
    assert_eq!((status.state(), status.findings[0].text.as_str()), (v1::JobState::Failed, "refused"));
    let listing = server.results().get_summary(v1::GetSummaryRequest { job_id: refused }).await;
    assert_eq!(reason(&listing.unwrap_err()), "NO_RESULTS");
    let mut request = v1::ListJobsRequest { page_size: 3, ..Default::default() };
    let page = server.jobs().list_jobs(request.clone()).await.unwrap().into_inner();
    assert_eq!(page.jobs.len(), 3);
    request.page_token = page.next_page_token;
    let page = server.jobs().list_jobs(request).await.unwrap().into_inner();
    assert_eq!((page.jobs.len(), page.next_page_token.as_str()), (1, ""));
    let failed = v1::ListJobsRequest { states: vec![v1::JobState::Failed.into()], ..Default::default() };
    assert_eq!(server.jobs().list_jobs(failed).await.unwrap().into_inner().jobs.len(), 3);
    server.stop().await;
}

#[tokio::test]
async fn running_and_queued_jobs_can_be_cancelled_and_deleted() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(ServerOptions { workers: 1, ..options(folder.path()) }).await;
    let running = server.submit("r-1", "EVENTS 5\nHANG").await;
    let queued = server.submit("r-2", "EVENTS 5").await;
    server.until_events(&running, 5).await;
    let delete = |id: &str| v1::DeleteJobRequest { job_id: id.into() };
    assert_eq!(reason(&server.jobs().delete_job(delete(&running)).await.unwrap_err()), "JOB_NOT_ENDED");
    for id in [&queued, &running] {
        let cancel = v1::CancelJobRequest { job_id: id.clone() };
        assert!(server.jobs().cancel_job(cancel).await.unwrap().into_inner().status.unwrap().cancel_requested);
        let status = server.wait(id).await;
        assert_eq!(status.state(), v1::JobState::Cancelled);
    }
    assert_eq!(server.status(&running).await.events, 5);
    server.jobs().delete_job(delete(&running)).await.unwrap();
    let gone = server.jobs().get_job(v1::GetJobRequest { job_id: running.clone() }).await.unwrap_err();
    assert_eq!((gone.code(), reason(&gone).as_str()), (Code::NotFound, "UNKNOWN_JOB"));
    assert!(!folder.path().join("jobs").join(&running).exists());
    server.stop().await;
}

/// Long programs take long to prepare: cancel ends that, and a drain gives the job to the next server.
#[tokio::test]
async fn a_job_that_is_being_prepared_can_be_cancelled_and_drained() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(ServerOptions { workers: 1, ..options(folder.path()) }).await;
    let job = server.submit("r-1", "SLOW").await;
    server.until(&job, v1::JobState::Running).await;
    server.jobs().cancel_job(v1::CancelJobRequest { job_id: job.clone() }).await.unwrap();
    let status = server.wait(&job).await;
    assert_eq!((status.state(), status.findings.len(), status.error.as_str()), (v1::JobState::Cancelled, 0, ""));
    let drained = server.submit("r-2", "SLOW").await;
    server.until(&drained, v1::JobState::Running).await;
    server.stop().await;
    let server = Server::start(options(folder.path())).await;
    server.until(&drained, v1::JobState::Running).await;
    assert_eq!(server.status(&drained).await.attempt, 1, "a drain is no failed attempt");
    server.stop().await;
}

pub fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
        let target = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy(&entry.path(), &target);
        } else {
            std::fs::copy(entry.path(), target).unwrap();
        }
    }
}

/// The data folder as a killed server leaves it: unfinished jobs run again, watchers continue at their cursor.
#[tokio::test]
async fn what_a_killed_server_left_unfinished_is_run_again() {
    let (folder, after) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let server = Server::start(ServerOptions { workers: 1, ..options(folder.path()) }).await;
    let done = server.submit("done", "EVENTS 50").await;
    server.wait(&done).await;
    let running = server.submit("running", "EVENTS 300\nHANG\nEVENTS 300").await;
    server.until(&running, v1::JobState::Running).await;
    let queued = server.submit("queued", "EVENTS 7").await;
    let data = after.path().join("data");
    copy(folder.path(), &data);
    server.stop().await;

    let server = Server::start(options(&data)).await;
    server.script.hang.store(false, Ordering::SeqCst);
    let status = server.wait(&running).await;
    assert_eq!((status.state(), status.attempt, status.events), (v1::JobState::Succeeded, 2, 600));
    assert_eq!(server.wait(&queued).await.state(), v1::JobState::Succeeded);
    assert_eq!(server.status(&done).await.events, 50);
    let mut stream = server.watch(&running, 123, v1::WatchLevel::Everything).await;
    let mut next = 124;
    while let Some(message) = stream.message().await.unwrap() {
        if let Some(Content::Batch(batch)) = message.content {
            batch.events.iter().for_each(|event| {
                assert_eq!(event.seq, next);
                next += 1;
            });
        }
    }
    assert_eq!(next, 601);
    let again = server.request("done", "EVENTS 50").await;
    assert!(server.jobs().submit_job(again).await.unwrap().into_inner().duplicate, "identity outlives the server");
    server.stop().await;
}

#[tokio::test]
async fn a_job_that_takes_the_server_down_is_given_up() {
    let (folder, after) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let server = Server::start(options(folder.path())).await;
    let job = server.submit("r", "HANG").await;
    server.until(&job, v1::JobState::Running).await;
    let data = after.path().join("data");
    copy(folder.path(), &data);
    server.stop().await;
    let server =
        Server::start(ServerOptions { maxima: Maxima { attempts: 1, ..Maxima::default() }, ..options(&data) }).await;
    let status = server.wait(&job).await;
    assert_eq!(status.state(), v1::JobState::Failed);
    assert!(status.error.starts_with("poison"), "{}", status.error);
    server.stop().await;
}

#[tokio::test]
async fn a_drain_ends_in_time_with_cursor_and_the_job_runs_again() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let job = server.submit("r", "EVENTS 1000\nHANG").await;
    let mut stream = server.watch(&job, 0, v1::WatchLevel::Everything).await;
    let mut last = 0;
    while last < 1000 {
        if let Some(Content::Batch(batch)) = stream.message().await.unwrap().unwrap().content {
            last = batch.last_seq;
        }
        if last == 0 {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
        if last >= 900 {
            break;
        }
    }
    // A client that opens a connection and never speaks must not hold the server.
    let silent = tokio::net::TcpStream::connect(server.handle.address()).await.unwrap();
    let jobs = server.jobs();
    server.stop().await;
    drop(silent);
    let ended = loop {
        match stream.message().await {
            Ok(Some(_)) => {}
            Ok(None) => panic!("the stream must not end as if the job had"),
            Err(status) => break status,
        }
    };
    assert_eq!(ended.code(), Code::Unavailable);
    drop(jobs);

    let server = Server::start(options(folder.path())).await;
    server.script.hang.store(false, Ordering::SeqCst);
    let status = server.wait(&job).await;
    assert_eq!((status.state(), status.attempt), (v1::JobState::Succeeded, 1), "a drain is no failed attempt");
    server.stop().await;
}

#[tokio::test]
async fn a_draining_server_refuses_jobs_and_says_so_in_its_health() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(ServerOptions { grace_s: 5, ..options(folder.path()) }).await;
    let job = server.submit("r", "HANG").await;
    server.until(&job, v1::JobState::Running).await;
    let request = server.request("r-2", "EVENTS 1").await;
    let mut health = tonic_health::pb::health_client::HealthClient::new(server.connection.clone());
    let mut watched = health.watch(tonic_health::pb::HealthCheckRequest::default()).await.unwrap().into_inner();
    assert_eq!(watched.message().await.unwrap().unwrap().status, 1);
    server.handle.stop();
    assert_eq!(watched.message().await.unwrap().unwrap().status, 2);
    let refused = loop {
        match server.jobs().submit_job(request.clone()).await {
            Err(status) => break status,
            Ok(_) => tokio::time::sleep(Duration::from_millis(5)).await,
        }
    };
    assert_eq!((refused.code(), reason(&refused).as_str()), (Code::Unavailable, "DRAINING"));
    server.script.hang.store(false, Ordering::SeqCst);
    tokio::time::timeout(Duration::from_secs(8), server.task).await.unwrap().unwrap();
}

async fn summary(server: &Server, job: &str) -> Vec<u8> {
    let request = v1::GetSummaryRequest { job_id: job.into() };
    let mut stream = server.results().get_summary(request).await.unwrap().into_inner();
    let mut text = Vec::new();
    while let Some(chunk) = stream.message().await.unwrap() {
        text.extend_from_slice(&chunk.data);
    }
    text
}

async fn events(server: &Server, job: &str) -> Vec<u8> {
    let request = v1::GetEventsRequest { job_id: job.into() };
    let mut stream = server.results().get_events(request).await.unwrap().into_inner();
    let mut text = Vec::new();
    while let Some(chunk) = stream.message().await.unwrap() {
        text.extend_from_slice(&chunk.data);
    }
    text
}

#[tokio::test]
async fn files_of_macros_are_listed_read_and_survive() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let job = server.submit("r", "EVENTS 1\nWRITE a.txt\nWRITE out/b.txt").await;
    let refused = server.submit("no", "REFUSE").await;
    server.wait(&job).await;
    server.wait(&refused).await;
    let list = |job: &String| v1::ListFilesRequest { job_id: job.clone(), ..Default::default() };
    assert_eq!(reason(&server.results().list_files(list(&refused)).await.unwrap_err()), "NO_RESULTS");
    server.stop().await;
    let server = Server::start(options(folder.path())).await;
    let files = server.results().list_files(list(&job)).await.unwrap().into_inner().files;
    let files: Vec<_> = files.iter().map(|file| (file.path.as_str(), file.size)).collect();
    assert_eq!(files, [("a.txt", 5), ("out/b.txt", 9)]);
    let get = |path: &str| v1::GetFileRequest { job_id: job.clone(), path: path.into() };
    let mut stream = server.results().get_file(get("out/b.txt")).await.unwrap().into_inner();
    assert_eq!(stream.message().await.unwrap().unwrap().data.as_ref(), b"out/b.txt");
    let unknown = server.results().get_file(get("../ledger")).await.unwrap_err();
    assert_eq!((unknown.code(), reason(&unknown).as_str()), (Code::NotFound, "UNKNOWN_FILE"));
    server.stop().await;
}

#[tokio::test]
async fn results_are_the_same_stored_kept_and_made_again() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let job = server.submit("r", "EVENTS 50000\nALARM").await;
    server.wait(&job).await;
    let (first, log) = (summary(&server, &job).await, events(&server, &job).await);
    assert_eq!(log.iter().filter(|&&b| b == b'\n').count(), 50_001);
    let parsed: serde_json::Value = serde_json::from_slice(&first).unwrap();
    assert_eq!((&parsed["state"], &parsed["highest_severity"]), (&"FAILED".into(), &9.into()));
    let request = |channel| v1::GetListingRequest { job_id: job.clone(), channel, ..Default::default() };
    assert!(server.results().get_listing(request(1)).await.is_ok());
    assert_eq!(reason(&server.results().get_listing(request(7)).await.unwrap_err()), "UNKNOWN_CHANNEL");
    server.stop().await;
    let server = Server::start(options(folder.path())).await;
    assert!(summary(&server, &job).await == first, "from the stored file");
    std::fs::remove_file(folder.path().join("jobs").join(&job).join("summary.json")).unwrap();
    assert!(summary(&server, &job).await == first, "from the log");
    assert!(events(&server, &job).await == log);
    server.stop().await;
}

/// Only a running job has progress; its status says as much as a watch.
#[tokio::test]
async fn the_status_of_a_running_job_has_its_progress() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let job = server.submit("runs", "EVENTS 30\nHANG").await;
    let get = async || {
        let request = v1::GetJobRequest { job_id: job.clone() };
        server.jobs().get_job(request).await.unwrap().into_inner().progress
    };
    server.until_events(&job, 30).await;
    let progress = get().await.expect("it runs");
    assert_eq!((progress.position, progress.channels.len()), (30, 2), "{progress:?}");
    let mut watch = server.watch(&job, 30, v1::WatchLevel::Progress).await;
    let content = watch.message().await.unwrap().unwrap().content;
    assert_eq!(content, Some(v1::watch_job_response::Content::Progress(progress)));
    server.script.hang.store(false, Ordering::SeqCst);
    server.wait(&job).await;
    assert_eq!(get().await, None);
    server.stop().await;
}
