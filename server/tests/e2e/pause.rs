//! Jobs that are held back and resumed.

use std::sync::atomic::Ordering;
use std::time::{SystemTime, UNIX_EPOCH};

use counterpoint_proto::v1;
use counterpoint_proto::v1::watch_job_response::Content;
use counterpoint_server::options::ServerOptions;

use crate::support::*;

async fn pause(server: &Server, job: &str) -> v1::JobStatus {
    let request = v1::PauseJobRequest { job_id: job.into() };
    server.jobs().pause_job(request).await.unwrap().into_inner().status.unwrap()
}

async fn resume(server: &Server, job: &str) -> v1::JobStatus {
    let request = v1::ResumeJobRequest { job_id: job.into() };
    server.jobs().resume_job(request).await.unwrap().into_inner().status.unwrap()
}

/// A paused run gives its worker to the next job; the job gives the same events when it is resumed, and its watch sees
/// each of them once.
#[tokio::test]
async fn a_paused_run_frees_its_worker_and_its_watch_continues_after_the_resume() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(ServerOptions { workers: 1, ..options(folder.path()) }).await;
    let job = server.submit("paused", "EVENTS 500\nHANG\nEVENTS 500").await;
    let mut watch = server.watch(&job, 0, v1::WatchLevel::Everything).await;
    let mut seen = 0;
    while seen < 500 {
        if let Some(Content::Batch(batch)) = watch.message().await.unwrap().unwrap().content {
            seen += batch.events.len();
        }
    }
    assert!(pause(&server, &job).await.paused);
    server.until(&job, v1::JobState::Queued).await;
    let next = server.submit("next", "EVENTS 3").await;
    assert_eq!(server.wait(&next).await.state(), v1::JobState::Succeeded, "the one worker is free");
    let status = server.status(&job).await;
    assert_eq!((status.state(), status.paused, status.attempt), (v1::JobState::Queued, true, 0));
    server.script.hang.store(false, Ordering::SeqCst);
    assert!(!resume(&server, &job).await.paused);
    let ended = loop {
        match watch.message().await.unwrap().expect("the end comes first").content {
            Some(Content::Batch(batch)) => seen += batch.events.len(),
            Some(Content::Ended(status)) => break status,
            _ => {}
        }
    };
    assert_eq!((ended.state(), ended.paused, ended.attempt), (v1::JobState::Succeeded, false, 1));
    assert_eq!((seen, ended.events), (1000, 1000), "each event once");
    assert_eq!(server.events(&job, 0).await.len(), 1000);
    for status in [pause(&server, &job).await, resume(&server, &job).await] {
        assert_eq!((status.state(), status.paused), (v1::JobState::Succeeded, false), "an ended job stays as it is");
    }
    server.stop().await;
    let server = Server::start(options(folder.path())).await;
    assert!(!server.status(&job).await.paused);
    server.stop().await;
}

#[tokio::test]
async fn a_paused_job_survives_a_restart_and_waits_until_it_is_resumed() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(ServerOptions { workers: 1, ..options(folder.path()) }).await;
    let running = server.submit("running", "EVENTS 5\nHANG").await;
    server.until_events(&running, 5).await;
    let waiting = server.submit("waiting", "EVENTS 7").await;
    assert!(pause(&server, &waiting).await.paused);
    assert!(pause(&server, &waiting).await.paused, "twice is once");
    pause(&server, &running).await;
    server.stop().await;
    let server = Server::start(options(folder.path())).await;
    server.script.hang.store(false, Ordering::SeqCst);
    let other = server.submit("other", "EVENTS 1").await;
    assert_eq!(server.wait(&other).await.state(), v1::JobState::Succeeded, "jobs that are held back stop nobody");
    for job in [&running, &waiting] {
        let status = server.status(job).await;
        assert_eq!((status.state(), status.paused), (v1::JobState::Queued, true));
        resume(&server, job).await;
        let status = server.wait(job).await;
        assert_eq!((status.state(), status.attempt), (v1::JobState::Succeeded, 1));
    }
    server.stop().await;
}

#[tokio::test]
async fn a_paused_job_can_be_cancelled_and_ends_at_its_deadline() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(ServerOptions { workers: 1, ..options(folder.path()) }).await;
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_millis();
    let request = server.request("late", "EVENTS 5\nHANG").await;
    let request = v1::SubmitJobRequest { deadline_ms: i64::try_from(now).unwrap() + 1500, ..request };
    let late = server.jobs().submit_job(request).await.unwrap().into_inner().status.unwrap().job_id;
    server.until_events(&late, 5).await;
    pause(&server, &late).await;
    let job = server.submit("cancelled", "EVENTS 5\nHANG").await;
    server.until_events(&job, 5).await;
    pause(&server, &job).await;
    let cancel = v1::CancelJobRequest { job_id: job.clone() };
    server.jobs().cancel_job(cancel).await.unwrap();
    let status = server.wait(&job).await;
    assert_eq!((status.state(), status.paused), (v1::JobState::Cancelled, false));
    let status = server.wait(&late).await;
    assert_eq!((status.state(), status.cause(), status.paused), (v1::JobState::Failed, v1::JobCause::Limit, false));
    server.stop().await;
}

/// The start time is that of the last run that was not discarded: neither a pause nor the end of a server leaves the
/// time of an earlier run.
#[tokio::test]
async fn a_job_that_waits_again_has_no_start() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(ServerOptions { workers: 1, ..options(folder.path()) }).await;
    let [first, second] = [server.submit("first", "EVENTS 5\nHANG").await, server.submit("second", "HANG").await];
    server.until_events(&first, 5).await;
    assert!(server.status(&first).await.started_ms > 0);
    pause(&server, &first).await;
    server.until(&first, v1::JobState::Queued).await;
    server.until(&second, v1::JobState::Running).await;
    // The job waits for the only worker until it is cancelled.
    assert_eq!(resume(&server, &first).await.state(), v1::JobState::Queued);
    server.jobs().cancel_job(v1::CancelJobRequest { job_id: first.clone() }).await.unwrap();
    let status = server.wait(&first).await;
    assert_eq!((status.state(), status.started_ms), (v1::JobState::Cancelled, 0));

    assert!(server.status(&second).await.started_ms > 0);
    server.stop().await;
    let server = Server::start(ServerOptions { min_free_bytes: u64::MAX, ..options(folder.path()) }).await;
    let status = server.status(&second).await;
    assert_eq!((status.state(), status.started_ms), (v1::JobState::Queued, 0), "no run starts on a full disk");
    server.stop().await;
}

/// A watch that has seen more events than the last run logs is given the end, whether it continues, or begins at its
/// cursor now or after a restart of the server.
#[tokio::test]
async fn a_watch_of_an_earlier_run_is_given_the_end_of_a_shorter_one() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(ServerOptions { workers: 1, ..options(folder.path()) }).await;
    let mut ended = Vec::new();
    for resumed in [false, true] {
        let job = server.submit(&format!("resumed-{resumed}"), "PACED 4000").await;
        let mut watch = server.watch(&job, 0, v1::WatchLevel::Everything).await;
        let mut cursor = 0;
        while cursor < 100 {
            if let Some(Content::Batch(batch)) = watch.message().await.unwrap().unwrap().content {
                assert_eq!(batch.first_seq, cursor + 1);
                cursor = batch.last_seq;
            }
        }
        pause(&server, &job).await;
        server.until(&job, v1::JobState::Queued).await;
        if resumed {
            resume(&server, &job).await;
            server.until(&job, v1::JobState::Running).await;
        }
        server.jobs().cancel_job(v1::CancelJobRequest { job_id: job.clone() }).await.unwrap();
        let events = server.wait(&job).await.events;
        assert!(events < cursor, "{events}");
        ended.push((job, cursor, watch));
    }
    for (job, cursor, open) in &mut ended {
        let again = server.watch(job, *cursor, v1::WatchLevel::Everything).await;
        for mut watch in [std::mem::replace(open, again), server.watch(job, 0, v1::WatchLevel::Progress).await] {
            assert_eq!(end(&mut watch).await, v1::JobState::Cancelled);
        }
        assert_eq!(end(open).await, v1::JobState::Cancelled);
    }
    server.stop().await;
    let server = Server::start(options(folder.path())).await;
    for (job, cursor, _) in &ended {
        let mut watch = server.watch(job, *cursor, v1::WatchLevel::Diagnostics).await;
        assert_eq!(end(&mut watch).await, v1::JobState::Cancelled);
    }
    server.stop().await;
}

/// The state at the end of a watch that has no more events.
async fn end(watch: &mut tonic::Streaming<v1::WatchJobResponse>) -> v1::JobState {
    loop {
        match watch.message().await.unwrap().expect("the end comes first").content.unwrap() {
            Content::Ended(status) => return status.state(),
            // Of the first run.
            Content::Batch(_) | Content::Progress(_) | Content::Description(_) => {}
        }
    }
}

/// However pauses, resumes and a cancel meet a run that begins and ends, the job ends once and nothing stays behind.
#[tokio::test]
async fn pauses_and_resumes_at_any_moment_lose_no_job() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let mut tasks = Vec::new();
    for number in 0..24 {
        let job = server.submit(&format!("job-{number}"), "EVENTS 2000").await;
        let connection = server.connection.clone();
        tasks.push(tokio::spawn(async move {
            let mut jobs = v1::jobs_client::JobsClient::new(connection);
            for turn in 0..6 {
                let job_id = job.clone();
                if number % 6 == 5 && turn == 3 {
                    jobs.cancel_job(v1::CancelJobRequest { job_id }).await.unwrap();
                } else if turn % 2 == 0 {
                    jobs.pause_job(v1::PauseJobRequest { job_id }).await.unwrap();
                } else {
                    jobs.resume_job(v1::ResumeJobRequest { job_id }).await.unwrap();
                }
            }
            jobs.resume_job(v1::ResumeJobRequest { job_id: job.clone() }).await.unwrap();
            job
        }));
    }
    for task in tasks {
        let job = task.await.unwrap();
        let status = server.wait(&job).await;
        assert!(matches!(status.state(), v1::JobState::Succeeded | v1::JobState::Cancelled), "{status:?}");
        assert!(!status.paused);
        if status.state() == v1::JobState::Succeeded {
            assert_eq!(server.events(&job, 0).await.len(), 2000);
        }
    }
    server.stop().await;
}
