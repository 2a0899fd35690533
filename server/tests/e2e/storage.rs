//! The cost of the end of a job, and small logs that are rows of the ledger.

use std::io;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex};

use counterpoint_proto::v1;
use counterpoint_server::local::disk::{Disk, DiskOperation, Faults};
use counterpoint_server::options::ServerOptions;

use crate::support::*;

/// Counts durable writes, and lets logs wait for them.
#[derive(Default)]
struct Counting {
    ledger: AtomicUsize,
    others: AtomicUsize,
    held: Mutex<bool>,
    released: Condvar,
}

impl Counting {
    fn hold(&self, held: bool) {
        *self.held.lock().unwrap() = held;
        self.released.notify_all();
    }
}

impl Faults for Counting {
    fn before(&self, step: DiskOperation, path: &Path) -> io::Result<usize> {
        if step == DiskOperation::Sync {
            let count = if path.ends_with("ledger.redb") { &self.ledger } else { &self.others };
            count.fetch_add(1, Ordering::SeqCst);
            if path.ends_with("log.segments") {
                let held = self.held.lock().unwrap();
                drop(self.released.wait_while(held, |held| *held).unwrap());
            }
        }
        Ok(usize::MAX)
    }
}

#[tokio::test]
async fn the_end_of_a_tiny_job_costs_one_commit_that_it_shares() {
    let (folder, disk) = (tempfile::tempdir().unwrap(), Arc::new(Counting::default()));
    let server = Server::start_on(options(folder.path()), Disk::faulty(disk.clone())).await;
    let first = server.submit("first", "EVENTS 20").await;
    server.wait(&first).await;
    disk.ledger.store(0, Ordering::SeqCst);
    disk.others.store(0, Ordering::SeqCst);
    let count = 20;
    for n in 0..count {
        let mut request = server.request("", "EVENTS 20").await;
        request.request_id = format!("r-{n}");
        let job = server.jobs().submit_job(request).await.unwrap().into_inner().status.unwrap().job_id;
        assert_eq!(server.wait(&job).await.state(), v1::JobState::Succeeded);
    }
    assert_eq!(disk.others.load(Ordering::SeqCst), 0, "no file of a tiny job is made durable");
    let commits = disk.ledger.load(Ordering::SeqCst);
    assert!(commits <= 2 * count, "{commits} commits for {count} jobs, one after the other");
    assert_eq!(std::fs::read_dir(folder.path().join("jobs")).unwrap().count(), 0);
    // The end of a job is visible before its worker is free and removes the mark.
    let begin = std::time::Instant::now();
    loop {
        let marks = std::fs::read(folder.path().join("marks")).unwrap();
        assert!(!marks.is_empty());
        if marks.iter().all(|byte| *byte == 0) {
            break;
        }
        assert!(begin.elapsed().as_secs() < 20, "a mark stays");
        tokio::time::sleep(std::time::Duration::from_millis(2)).await;
    }
    server.stop().await;
}

/// Its log, its folder and the folder of all jobs, which those that end at the same time share; results can be made
/// again.
#[tokio::test]
async fn the_end_of_a_large_job_costs_two_syncs_of_its_own() {
    let (folder, disk) = (tempfile::tempdir().unwrap(), Arc::new(Counting::default()));
    let settings = ServerOptions { workers: 1, ..options(folder.path()) };
    let server = Server::start_on(settings, Disk::faulty(disk.clone())).await;
    let count = 6;
    let mut requests = Vec::new();
    for n in 0..count {
        requests.push(server.request(&format!("r-{n}"), "EVENTS 40000").await);
    }
    disk.ledger.store(0, Ordering::SeqCst);
    disk.others.store(0, Ordering::SeqCst);
    let mut jobs = Vec::new();
    disk.hold(true);
    for request in requests {
        jobs.push(server.jobs().submit_job(request).await.unwrap().into_inner().status.unwrap().job_id);
    }
    // All of them stand before the sync of their logs.
    while disk.others.load(Ordering::SeqCst) < count {
        tokio::time::sleep(std::time::Duration::from_millis(2)).await;
    }
    disk.hold(false);
    for job in &jobs {
        assert_eq!(server.wait(job).await.state(), v1::JobState::Succeeded);
        let results = ["summary.json", "timeline.json", "timeline.svg", "toolpath.json", "toolpath.svg"];
        assert!(results.iter().all(|name| folder.path().join("jobs").join(job).join(name).is_file()));
    }
    let (others, commits) = (disk.others.load(Ordering::SeqCst), disk.ledger.load(Ordering::SeqCst));
    println!("{count} large jobs: {others} syncs of files and folders, {commits} of the ledger");
    assert!(others <= 3 * count, "{others} syncs for {count} jobs");
    assert!(commits <= 2 * count, "{commits} commits for {count} jobs");
    server.stop().await;
}

#[tokio::test]
async fn a_small_log_survives_is_watched_and_goes_with_its_job() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let job = server.submit("small", "EVENTS 20\nALARM").await;
    let whole = server.events(&job, 0).await;
    assert_eq!(whole.len(), 21);
    server.stop().await;
    let server = Server::start(options(folder.path())).await;
    assert_eq!(server.events(&job, 0).await, whole);
    assert_eq!(server.events(&job, 15).await, whole[15..]);
    let summary = server.results().get_summary(v1::GetSummaryRequest { job_id: job.clone() }).await;
    assert!(summary.unwrap().into_inner().message().await.unwrap().is_some());
    let files =
        server.results().list_files(v1::ListFilesRequest { job_id: job.clone(), ..Default::default() }).await.unwrap();
    assert!(files.into_inner().files.is_empty());
    assert!(
        server
            .jobs()
            .get_job(v1::GetJobRequest { job_id: job.clone() })
            .await
            .unwrap()
            .into_inner()
            .description
            .is_some()
    );
    server.jobs().delete_job(v1::DeleteJobRequest { job_id: job.clone() }).await.unwrap();
    server.stop().await;
    let database = redb::Database::open(folder.path().join("ledger.redb")).unwrap();
    let table = redb::TableDefinition::<&str, &[u8]>::new("log");
    let read = redb::ReadableDatabase::begin_read(&database).unwrap();
    assert!(read.open_table(table).unwrap().get(job.as_str()).unwrap().is_none());
}

#[tokio::test]
async fn a_job_being_stored_leaves_its_worker_to_the_next() {
    let (folder, disk) = (tempfile::tempdir().unwrap(), Arc::new(Counting::default()));
    let settings = ServerOptions { workers: 1, ..options(folder.path()) };
    let server = Server::start_on(settings, Disk::faulty(disk.clone())).await;
    disk.hold(true);
    let large = server.submit("large", "EVENTS 20000").await;
    let tiny = server.submit("tiny", "EVENTS 5").await;
    assert_eq!(server.wait(&tiny).await.state(), v1::JobState::Succeeded);
    assert_eq!(server.status(&large).await.state(), v1::JobState::Running, "its end is not durable yet");
    disk.hold(false);
    assert_eq!(server.wait(&large).await.state(), v1::JobState::Succeeded);
    server.stop().await;
}
