//! Compaction of the ledger while the server runs: nothing is lost, whatever happens meanwhile.

use std::fs::Metadata;
use std::io;
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use counterpoint_proto::v1;
use counterpoint_proto::v1::admin_client::AdminClient;
use counterpoint_server::doctor;
use counterpoint_server::local::disk::{Disk, DiskOperation, Faults};
use counterpoint_server::options::{Retention, ServerOptions};
use tonic::Status;

use crate::support::*;

async fn compact(server: &Server) -> Result<v1::CompactLedgerResponse, Status> {
    let mut admin = AdminClient::new(server.connection.clone());
    admin.compact_ledger(v1::CompactLedgerRequest {}).await.map(tonic::Response::into_inner)
}

/// Runs jobs with logs in the ledger, and deletes all but five. Returns the ids of these five, and the metadata of the
/// ledger file before the deletion.
async fn used(server: &Server, folder: &Path, jobs: usize) -> (Vec<String>, Metadata) {
    let mut all = Vec::new();
    for number in 0..jobs {
        all.push(server.submit(&format!("r-{number}"), "EVENTS 200").await);
    }
    for job in &all {
        server.wait(job).await;
    }
    let full = folder.join("ledger.redb").metadata().unwrap();
    let kept = all.split_off(jobs - 5);
    for job_id in all {
        server.jobs().delete_job(v1::DeleteJobRequest { job_id }).await.unwrap();
    }
    (kept, full)
}

/// Checks that every job exists with its events, and that the folder has no damage.
async fn has_all(folder: &Path, jobs: &[String]) {
    let damages = doctor::examine(folder, false).unwrap();
    assert!(damages.is_empty(), "{damages:?}");
    let server = Server::start(options(folder)).await;
    for job in jobs {
        assert_eq!(server.wait(job).await.state(), v1::JobState::Succeeded, "{job}");
        assert_eq!(server.events(job, 0).await.len(), 200, "{job}");
    }
    let list = server
        .jobs()
        .list_jobs(v1::ListJobsRequest { page_size: 500, ..Default::default() })
        .await
        .unwrap()
        .into_inner();
    assert_eq!(list.jobs.len(), jobs.len());
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_compacted_ledger_is_smaller_and_has_every_job() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let (mut kept, _) = used(&server, folder.path(), 400).await;
    // A run, a watch and submits continue during the compaction.
    let running = server.submit("running", "EVENTS 200\nHANG").await;
    let mut watch = server.watch(&running, 0, v1::WatchLevel::Everything).await;
    let request = server.request("r", "EVENTS 200").await;
    let submits = tokio::spawn({
        let mut jobs = server.jobs();
        async move {
            let mut accepted = Vec::new();
            for number in 0..50 {
                let request = v1::SubmitJobRequest { request_id: format!("meanwhile-{number}"), ..request.clone() };
                accepted.push(jobs.submit_job(request).await.unwrap().into_inner().status.unwrap().job_id);
            }
            accepted
        }
    });
    let done = compact(&server).await.unwrap();
    assert!(done.after_bytes < done.before_bytes / 2, "{done:?}");
    assert!(folder.path().join("ledger.redb").metadata().unwrap().len() < done.before_bytes);
    kept.extend(submits.await.unwrap());
    server.script.hang.store(false, std::sync::atomic::Ordering::SeqCst);
    let mut events = 0;
    while let Some(message) = watch.message().await.unwrap() {
        if let Some(v1::watch_job_response::Content::Batch(batch)) = message.content {
            events += batch.events.len();
        }
    }
    assert_eq!(events, 200);
    kept.push(running);
    let again = compact(&server).await.unwrap();
    assert!(again.after_bytes <= again.before_bytes + (1 << 20), "{again:?}");
    server.stop().await;
    has_all(folder.path(), &kept).await;
}

#[tokio::test]
async fn a_ledger_with_much_free_space_is_compacted_by_itself() {
    let folder = tempfile::tempdir().unwrap();
    let retention = Retention { compact_bytes: 1 << 20, blob_grace_s: 0, ..Retention::default() };
    let server = Server::start(ServerOptions { retention, ..options(folder.path()) }).await;
    let (kept, full) = used(&server, folder.path(), 400).await;
    for _ in 0..2000 {
        let now = folder.path().join("ledger.redb").metadata().unwrap();
        // A different inode means that the file has been rewritten.
        if now.ino() != full.ino() && now.len() < full.len() / 2 {
            server.stop().await;
            return has_all(folder.path(), &kept).await;
        }
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    panic!("the ledger still has its file of {} bytes", full.len());
}

/// What happens at a step of the compaction.
#[derive(Debug)]
enum Trouble {
    None,
    /// The folder is copied before each step, as a server killed at this step would leave it.
    Killed {
        from: PathBuf,
        to: PathBuf,
        copies: usize,
    },
    /// The disk has too little space for a copy.
    Full,
    /// This step fails.
    Fails {
        left: usize,
        met: bool,
    },
}

struct Troubles(Mutex<Trouble>);

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap().map(Result::unwrap) {
        let to = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy(&entry.path(), &to)
        } else {
            drop(std::fs::copy(entry.path(), to))
        }
    }
}

impl Faults for Troubles {
    fn before(&self, step: DiskOperation, path: &Path) -> io::Result<usize> {
        let of_ledger = path.to_string_lossy().contains("ledger") || step == DiskOperation::Sync;
        match &mut *self.0.lock().unwrap() {
            Trouble::Killed { from, to, copies } if of_ledger => {
                copy(from, &to.join(copies.to_string()));
                *copies += 1;
            }
            Trouble::Fails { left: 0, met } if of_ledger && step != DiskOperation::Read && !*met => {
                *met = true;
                return Err(io::Error::from_raw_os_error(5));
            }
            Trouble::Fails { left, met: false } if of_ledger && step != DiskOperation::Read => *left -= 1,
            _ => {}
        }
        Ok(usize::MAX)
    }

    fn free(&self) -> Option<u64> {
        let full = matches!(*self.0.lock().unwrap(), Trouble::Full);
        Some(if full { ServerOptions::default().min_free_bytes + 1 } else { 1 << 40 })
    }
}

#[tokio::test]
async fn a_server_that_is_killed_at_any_step_of_a_compaction_loses_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let (data, copies) = (folder.path().join("data"), folder.path().join("copies"));
    let troubles = Arc::new(Troubles(Mutex::new(Trouble::None)));
    let server = Server::start_on(options(&data), Disk::faulty(troubles.clone())).await;
    let (kept, _) = used(&server, &data, 20).await;
    *troubles.0.lock().unwrap() = Trouble::Killed { from: data, to: copies.clone(), copies: 0 };
    compact(&server).await.unwrap();
    let trouble = std::mem::replace(&mut *troubles.0.lock().unwrap(), Trouble::None);
    let Trouble::Killed { copies: steps, .. } = trouble else { panic!("{trouble:?}") };
    assert!(steps > 10, "{steps}");
    server.stop().await;
    for step in 0..steps {
        has_all(&copies.join(step.to_string()), &kept).await;
    }
}

#[tokio::test]
async fn an_error_at_any_step_of_a_compaction_loses_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let troubles = Arc::new(Troubles(Mutex::new(Trouble::None)));
    let server = Server::start_on(options(folder.path()), Disk::faulty(troubles.clone())).await;
    let (kept, _) = used(&server, folder.path(), 6).await;
    let request = server.request("r", "EVENTS 200").await;
    for step in 0..300 {
        *troubles.0.lock().unwrap() = Trouble::Fails { left: step, met: false };
        let done = compact(&server).await;
        let trouble = std::mem::replace(&mut *troubles.0.lock().unwrap(), Trouble::None);
        let Trouble::Fails { met, .. } = trouble else { panic!("{trouble:?}") };
        // The server accepts submits again, perhaps after a pause.
        let id = format!("after-{step}");
        let job = loop {
            let request = v1::SubmitJobRequest { request_id: id.clone(), ..request.clone() };
            match server.jobs().submit_job(request).await {
                Ok(accepted) => break accepted.into_inner().status.unwrap().job_id,
                Err(_) => tokio::time::sleep(Duration::from_millis(5)).await,
            }
        };
        server.wait(&job).await;
        server.jobs().delete_job(v1::DeleteJobRequest { job_id: job }).await.unwrap();
        if !met {
            done.unwrap();
            server.stop().await;
            assert!(step > 10, "{step}");
            return has_all(folder.path(), &kept).await;
        }
    }
    panic!("a compaction never runs out of steps");
}

#[tokio::test]
async fn a_disk_without_room_for_a_copy_is_not_filled() {
    let folder = tempfile::tempdir().unwrap();
    let troubles = Arc::new(Troubles(Mutex::new(Trouble::None)));
    let server = Server::start_on(options(folder.path()), Disk::faulty(troubles.clone())).await;
    let (mut kept, _) = used(&server, folder.path(), 6).await;
    *troubles.0.lock().unwrap() = Trouble::Full;
    assert_eq!(reason(&compact(&server).await.unwrap_err()), "DISK_FULL");
    // The disk still has room for jobs.
    kept.push(server.submit("more", "EVENTS 200").await);
    server.wait(&kept[5]).await;
    *troubles.0.lock().unwrap() = Trouble::None;
    compact(&server).await.unwrap();
    server.stop().await;
    has_all(folder.path(), &kept).await;
}

#[tokio::test]
async fn a_small_ledger_stays_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let job = server.submit("r", "EVENTS 200").await;
    server.wait(&job).await;
    let before = folder.path().join("ledger.redb").metadata().unwrap();
    let answer = compact(&server).await.unwrap();
    let after = folder.path().join("ledger.redb").metadata().unwrap();
    assert_eq!((answer.before_bytes, answer.after_bytes), (before.len(), before.len()));
    assert_eq!((after.len(), after.ino()), (before.len(), before.ino()));
    server.stop().await;
    has_all(folder.path(), &[job]).await;
}
