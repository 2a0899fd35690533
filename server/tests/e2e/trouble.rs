//! Trouble of the host: a disk that is full or fails, descriptors that run out, a server that is killed.

use std::io;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering};

use counterpoint_proto::v1;
use counterpoint_proto::v1::watch_job_response::Content;
use counterpoint_server::local::disk::{Disk, DiskOperation, Faults};
use counterpoint_server::options::{Maxima, ServerOptions};
use tonic::Code;
use tonic_health::pb::health_client::HealthClient;
use tonic_types::StatusExt;

use crate::life::copy;
use crate::support::*;

/// A disk that fails on request.
#[derive(Default)]
struct Trouble {
    /// Writes to the ledger fail.
    ledger: AtomicBool,
    /// Writes to logs fail when this many more have been done; negative = never.
    logs: AtomicI64,
    /// Writes come to no more than 7 bytes each.
    short: AtomicBool,
    /// Files that macros have written cannot be put in their place.
    results: AtomicBool,
    /// Blobs cannot be opened: the process has too many open files.
    descriptors: AtomicBool,
    /// Free bytes to be reported; 0 = those of the disk.
    free: AtomicU64,
}

impl Trouble {
    fn none() -> Arc<Self> {
        Arc::new(Self { logs: AtomicI64::new(-1), ..Self::default() })
    }
}

impl Faults for Trouble {
    fn before(&self, step: DiskOperation, path: &Path) -> io::Result<usize> {
        let on = |flag: &AtomicBool| flag.load(Ordering::SeqCst);
        let full = || Err(io::ErrorKind::StorageFull.into());
        let writes = matches!(step, DiskOperation::Write(_) | DiskOperation::Resize(_) | DiskOperation::Sync);
        if path.ends_with("ledger.redb") {
            return if writes && on(&self.ledger) { full() } else { Ok(usize::MAX) };
        }
        if path.ends_with("log") && matches!(step, DiskOperation::Write(_)) {
            let left = self.logs.load(Ordering::SeqCst);
            if left == 0 {
                return full();
            }
            self.logs.store(if left > 0 { left - 1 } else { left }, Ordering::SeqCst);
        }
        if path.ends_with("files.json") && step == DiskOperation::Place && on(&self.results) {
            return full();
        }
        if step == DiskOperation::Read && on(&self.descriptors) {
            return Err(io::Error::from_raw_os_error(24));
        }
        Ok(if on(&self.short) { 7 } else { usize::MAX })
    }

    fn free(&self) -> Option<u64> {
        Some(self.free.load(Ordering::SeqCst)).filter(|free| *free > 0)
    }
}

async fn start(folder: &Path, trouble: &Arc<Trouble>) -> Server {
    Server::start_on(options(folder), Disk::faulty(trouble.clone())).await
}

/// Waits until the host has failed a run of a job.
async fn failed_by_the_host(server: &Server, job: &str) -> v1::JobStatus {
    for _ in 0..2000 {
        let status = server.status(job).await;
        if status.host_failures > 0 {
            return status;
        }
        tokio::time::sleep(std::time::Duration::from_millis(5)).await;
    }
    panic!("the host failed no run of {job}");
}

#[tokio::test]
async fn a_ledger_that_cannot_be_written_is_opened_again_and_reads_go_on() {
    let (folder, trouble) = (tempfile::tempdir().unwrap(), Trouble::none());
    let server = start(folder.path(), &trouble).await;
    let done = server.submit("done", "EVENTS 5").await;
    server.wait(&done).await;
    let others: Vec<String> = {
        let mut others = Vec::new();
        for n in 0..10 {
            let job = server.submit(&format!("other-{n}"), "EVENTS 1").await;
            server.wait(&job).await;
            others.push(job);
        }
        others
    };
    let (known, new) = (server.request("done", "EVENTS 5").await, server.request("new", "EVENTS 7").await);
    let mut health = HealthClient::new(server.connection.clone());
    let ask = tonic_health::pb::HealthCheckRequest { service: "counterpoint.v1.Jobs".into() };
    let mut health = health.watch(ask).await.unwrap().into_inner();
    assert_eq!(health.message().await.unwrap().unwrap().status, 1);
    trouble.ledger.store(true, Ordering::SeqCst);
    for _ in 0..3 {
        let refused = server.jobs().submit_job(new.clone()).await.unwrap_err();
        assert_eq!((refused.code(), reason(&refused).as_str()), (Code::Unavailable, "STORAGE"));
        assert!(refused.get_error_details().retry_info().is_some());
    }
    assert_eq!(health.message().await.unwrap().unwrap().status, 2);
    // `done` has left the memory: ten jobs ended after it.
    assert_eq!(server.status(&done).await.state(), v1::JobState::Succeeded);
    let jobs = server.jobs().list_jobs(v1::ListJobsRequest::default()).await.unwrap().into_inner().jobs;
    assert_eq!(jobs.len(), 1 + others.len());
    assert!(server.jobs().submit_job(known).await.unwrap().into_inner().duplicate);
    trouble.ledger.store(false, Ordering::SeqCst);
    assert_eq!(health.message().await.unwrap().unwrap().status, 1);
    let job = server.jobs().submit_job(new).await.unwrap().into_inner().status.unwrap().job_id;
    assert_eq!(server.wait(&job).await.state(), v1::JobState::Succeeded);
    server.jobs().delete_job(v1::DeleteJobRequest { job_id: done.clone() }).await.unwrap();
    server.stop().await;
    let server = Server::start(options(folder.path())).await;
    assert_eq!(server.status(&job).await.events, 7);
    server.stop().await;
}

#[tokio::test]
async fn a_job_that_ends_while_the_ledger_is_closed_ends_when_it_is_open_again() {
    let (folder, trouble) = (tempfile::tempdir().unwrap(), Trouble::none());
    let server = start(folder.path(), &trouble).await;
    let job = server.submit("r", "EVENTS 5\nHANG").await;
    server.until(&job, v1::JobState::Running).await;
    trouble.ledger.store(true, Ordering::SeqCst);
    let new = server.request("new", "EVENTS 7").await;
    assert_eq!(reason(&server.jobs().submit_job(new).await.unwrap_err()), "STORAGE");
    server.script.hang.store(false, Ordering::SeqCst);
    assert_eq!(server.status(&job).await.state(), v1::JobState::Running);
    trouble.ledger.store(false, Ordering::SeqCst);
    let status = server.wait(&job).await;
    assert_eq!((status.state(), status.attempt, status.error.as_str()), (v1::JobState::Succeeded, 1, ""));
    server.stop().await;
}

/// The run is dropped in the middle of its log; a watcher that has seen half of it sees the other half, once.
#[tokio::test]
async fn a_full_disk_sends_the_job_back_to_the_queue_and_watchers_go_on() {
    let (folder, trouble) = (tempfile::tempdir().unwrap(), Trouble::none());
    let server = start(folder.path(), &trouble).await;
    trouble.logs.store(4, Ordering::SeqCst);
    let job = server.submit("r", "EVENTS 50000").await;
    let mut stream = server.watch(&job, 0, v1::WatchLevel::Everything).await;
    let status = failed_by_the_host(&server, &job).await;
    assert!(matches!(status.state(), v1::JobState::Queued | v1::JobState::Running), "{status:?}");
    assert!(status.host_failure.contains("log") && status.error.is_empty(), "{status:?}");
    trouble.logs.store(-1, Ordering::SeqCst);
    let mut next = 1;
    let ended = loop {
        match stream.message().await.unwrap().unwrap().content.unwrap() {
            Content::Batch(batch) => batch.events.iter().for_each(|event| {
                assert_eq!(event.seq, next);
                next += 1;
            }),
            Content::Ended(status) => break status,
            _ => {}
        }
    };
    assert_eq!((ended.state(), ended.attempt, next), (v1::JobState::Succeeded, 1, 50_001));
    server.stop().await;
}

#[tokio::test]
async fn too_many_open_files_and_results_that_cannot_be_kept_fail_no_job() {
    let (folder, trouble) = (tempfile::tempdir().unwrap(), Trouble::none());
    let server = start(folder.path(), &trouble).await;
    for (name, flag) in [("descriptors", &trouble.descriptors), ("results", &trouble.results)] {
        flag.store(true, Ordering::SeqCst);
        let job = server.submit(name, "EVENTS 5\nWRITE a.txt").await;
        let status = failed_by_the_host(&server, &job).await;
        assert!(!matches!(status.state(), v1::JobState::Failed), "{status:?}");
        flag.store(false, Ordering::SeqCst);
        let status = server.wait(&job).await;
        assert_eq!((status.state(), status.attempt, status.events), (v1::JobState::Succeeded, 1, 5), "{name}");
    }
    server.stop().await;
}

#[tokio::test]
async fn a_job_waiting_for_the_host_can_be_cancelled() {
    let (folder, trouble) = (tempfile::tempdir().unwrap(), Trouble::none());
    let server = start(folder.path(), &trouble).await;
    trouble.logs.store(0, Ordering::SeqCst);
    let job = server.submit("r", "EVENTS 20000").await;
    failed_by_the_host(&server, &job).await;
    server.jobs().cancel_job(v1::CancelJobRequest { job_id: job.clone() }).await.unwrap();
    trouble.logs.store(-1, Ordering::SeqCst);
    assert_eq!(server.wait(&job).await.state(), v1::JobState::Cancelled);
    server.stop().await;
}

#[tokio::test]
async fn short_writes_lose_nothing() {
    let (folder, trouble) = (tempfile::tempdir().unwrap(), Trouble::none());
    let server = start(folder.path(), &trouble).await;
    trouble.short.store(true, Ordering::SeqCst);
    let job = server.submit("r", "EVENTS 3000\nWRITE a.txt").await;
    assert_eq!(server.wait(&job).await.state(), v1::JobState::Succeeded);
    server.stop().await;
    let server = Server::start(options(folder.path())).await;
    let mut stream = server.watch(&job, 0, v1::WatchLevel::Everything).await;
    let mut last = 0;
    while let Some(message) = stream.message().await.unwrap() {
        if let Some(Content::Batch(batch)) = message.content {
            last = batch.last_seq;
        }
    }
    assert_eq!(last, 3000);
    server.stop().await;
}

#[tokio::test]
async fn below_the_reserve_no_run_starts_and_new_work_is_refused() {
    let (folder, trouble) = (tempfile::tempdir().unwrap(), Trouble::none());
    let disk = Disk::faulty(trouble.clone());
    let server = Server::start_on(ServerOptions { workers: 1, ..options(folder.path()) }, disk).await;
    let running = server.submit("running", "HANG").await;
    server.until(&running, v1::JobState::Running).await;
    let queued = server.submit("queued", "EVENTS 3").await;
    let third = server.request("third", "EVENTS 4").await;
    trouble.free.store(1, Ordering::SeqCst);
    let refused = server.jobs().submit_job(third).await.unwrap_err();
    assert_eq!((refused.code(), reason(&refused).as_str()), (Code::ResourceExhausted, "DISK_FULL"));
    assert!(refused.get_error_details().retry_info().is_some());
    let upload = v1::UploadRequest { digest: digest(b"x"), data: "x".into(), size: None };
    let refused = server.blobs().upload(tokio_stream::iter([upload])).await.unwrap_err();
    assert_eq!(reason(&refused), "DISK_FULL");
    server.script.hang.store(false, Ordering::SeqCst);
    assert_eq!(server.wait(&running).await.state(), v1::JobState::Succeeded, "what runs may end");
    assert_eq!(server.status(&queued).await.state(), v1::JobState::Queued);
    trouble.free.store(0, Ordering::SeqCst);
    assert_eq!(server.wait(&queued).await.state(), v1::JobState::Succeeded);
    server.stop().await;
}

async fn in_state(server: &Server, state: v1::JobState) -> Vec<String> {
    let request = v1::ListJobsRequest { states: vec![state.into()], ..Default::default() };
    let jobs = server.jobs().list_jobs(request).await.unwrap().into_inner().jobs;
    jobs.into_iter().map(|job| job.job_id).collect()
}

#[tokio::test]
async fn after_an_unclean_stop_suspects_run_one_at_a_time_and_innocents_are_not_given_up() {
    let (first, second) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let server = Server::start(ServerOptions { workers: 3, ..options(first.path()) }).await;
    let mut jobs = Vec::new();
    for name in ["a", "b", "c"] {
        let job = server.submit(name, "EVENTS 2000\nHANG").await;
        server.until_events(&job, 2000).await;
        jobs.push(job);
    }
    let other = server.submit("other", "EVENTS 3").await;
    // Killed with three jobs running: the cause is unknown.
    let data = second.path().join("one");
    copy(first.path(), &data);
    server.stop().await;
    let strict = |data: &Path| ServerOptions {
        workers: 3,
        maxima: Maxima { attempts: 1, ..Maxima::default() },
        ..options(data)
    };
    let server = Server::start(strict(&data)).await;
    server.until_events(&jobs[0], 2000).await;
    assert_eq!(in_state(&server, v1::JobState::Running).await, jobs[..1]);
    assert_eq!(in_state(&server, v1::JobState::Failed).await, [""; 0]);
    // Killed with one of them alone: it did it.
    let data = second.path().join("two");
    copy(&second.path().join("one"), &data);
    server.stop().await;
    let server = Server::start(strict(&data)).await;
    let given_up = server.wait(&jobs[0]).await;
    assert!(given_up.state() == v1::JobState::Failed && given_up.error.starts_with("poison"), "{given_up:?}");
    assert!(server.events(&jobs[0], 0).await.is_empty(), "what its run had logged is no log");
    server.script.hang.store(false, Ordering::SeqCst);
    for job in jobs[1..].iter().chain([&other]) {
        assert_eq!(server.wait(job).await.state(), v1::JobState::Succeeded);
    }
    server.stop().await;
}

#[tokio::test]
async fn the_order_is_that_of_acceptance_also_when_the_clock_is_set_back() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let job = server.submit("first", "EVENTS 1").await;
    server.wait(&job).await;
    server.stop().await;
    // As if accepted when the clock was far ahead.
    let ahead = "f0000000-0000-7000-8000-000000000000";
    let table = redb::TableDefinition::<&str, &[u8]>::new("job");
    let database = redb::Database::open(folder.path().join("ledger.redb")).unwrap();
    let txn = database.begin_write().unwrap();
    {
        let mut rows = txn.open_table(table).unwrap();
        let row = rows.remove(job.as_str()).unwrap().unwrap().value().to_vec();
        // Without its checksum, as earlier schemas have it.
        let row = String::from_utf8(row[5..].to_vec()).unwrap().replace(&job, ahead);
        rows.insert(ahead, row.as_bytes()).unwrap();
        // Jobs are listed anew when an earlier schema is opened.
        let meta = redb::TableDefinition::<&str, u64>::new("meta");
        txn.open_table(meta).unwrap().insert("schema", 5).unwrap();
    }
    txn.commit().unwrap();
    drop(database);
    let server = Server::start(ServerOptions { workers: 1, ..options(folder.path()) }).await;
    let mut expected = vec![ahead.to_owned()];
    for name in ["second", "third", "fourth"] {
        expected.push(server.submit(name, "EVENTS 1\nHANG").await);
    }
    let jobs = server.jobs().list_jobs(v1::ListJobsRequest::default()).await.unwrap().into_inner().jobs;
    assert_eq!(jobs.into_iter().map(|job| job.job_id).collect::<Vec<_>>(), expected);
    server.stop().await;
    // Recovered in the same order.
    let server = Server::start(ServerOptions { workers: 1, ..options(folder.path()) }).await;
    server.until(&expected[1], v1::JobState::Running).await;
    assert_eq!(in_state(&server, v1::JobState::Queued).await, expected[2..]);
    server.stop().await;
}
