//! Damage of the data folder: it is reported, with the way out, and never read as something else.

use std::path::Path;

use counterpoint_proto::v1;
use counterpoint_proto::v1::watch_job_response::Content;
use counterpoint_server::service;
use redb::ReadableDatabase;
use tonic::{Code, Status};

use crate::support::*;

/// The status that ends a watch; none when the watch ends as that of a whole log does.
async fn end_of_watch(server: &Server, job: &str, level: v1::WatchLevel) -> Option<Status> {
    let mut stream = server.watch(job, 0, level).await;
    loop {
        match stream.message().await {
            Ok(Some(v1::WatchJobResponse { content: Some(Content::Ended(_)), .. })) | Ok(None) => return None,
            Ok(Some(_)) => {}
            Err(status) => return Some(status),
        }
    }
}

async fn why_not_started(folder: &Path) -> String {
    match service::build_with(options(folder), Script::default()).await {
        Ok(_) => panic!("the server must not start"),
        Err(error) => error.to_string(),
    }
}

#[tokio::test]
async fn a_log_cut_short_emptied_or_gone_is_data_loss() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let mut jobs = Vec::new();
    for (name, events) in [("cut", 20_000), ("empty", 20_000), ("gone", 20_000), ("flipped", 20_000), ("plain", 700)] {
        let job = server.submit(name, &format!("EVENTS {events}")).await;
        server.wait(&job).await;
        jobs.push(job);
    }
    server.stop().await;
    let log = |job: &str| log_file(folder.path(), job);
    let length = std::fs::metadata(log(&jobs[0])).unwrap().len();
    std::fs::File::options().write(true).open(log(&jobs[0])).unwrap().set_len(length / 2).unwrap();
    std::fs::File::create(log(&jobs[1])).unwrap();
    std::fs::remove_file(log(&jobs[2])).unwrap();
    let mut bytes = std::fs::read(log(&jobs[3])).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 0x55;
    std::fs::write(log(&jobs[3]), bytes).unwrap();
    let length = std::fs::metadata(folder.path().join("jobs").join(&jobs[4]).join("log")).unwrap().len();
    std::fs::File::options().write(true).open(log(&jobs[4])).unwrap().set_len(length / 2).unwrap();
    let server = Server::start(options(folder.path())).await;
    for job in &jobs {
        let status = end_of_watch(&server, job, v1::WatchLevel::Everything).await.expect("damage is reported");
        assert_eq!((status.code(), reason(&status).as_str()), (Code::DataLoss, "DATA_LOSS"), "{status:?}");
        assert!(status.message().contains("submit the job again"), "{}", status.message());
        let request = v1::GetEventsRequest { job_id: job.clone() };
        let status = match server.results().get_events(request).await {
            Err(status) => status,
            Ok(stream) => {
                let mut stream = stream.into_inner();
                loop {
                    match stream.message().await {
                        Ok(message) => assert!(message.is_some(), "the events must not end as if whole"),
                        Err(status) => break status,
                    }
                }
            }
        };
        assert_eq!(reason(&status), "DATA_LOSS");
        assert_eq!(end_of_watch(&server, job, v1::WatchLevel::Progress).await.map(|s| s.code()), None);
    }
    server.stop().await;
}

#[tokio::test]
async fn a_blob_whose_content_changed_is_not_run_and_can_be_uploaded_again() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let script = "EVENTS 10";
    let name = digest(script.as_bytes());
    let request = server.request("first", script).await;
    std::fs::write(folder.path().join("blobs").join(&name[..2]).join(&name), "EVENTS 99").unwrap();
    let job = server.jobs().submit_job(request).await.unwrap().into_inner().status.unwrap().job_id;
    let status = server.wait(&job).await;
    assert_eq!(status.state(), v1::JobState::Failed);
    assert!(status.error.contains(&name) && status.error.contains("upload"), "{}", status.error);
    let stream = match server.blobs().download(v1::DownloadRequest { digest: name.clone() }).await {
        Ok(_) => panic!("a damaged blob must not be handed out"),
        Err(status) => status,
    };
    assert_eq!(reason(&stream), "UNKNOWN_BLOB");
    let ask = v1::FindMissingRequest { digests: vec![name.clone()] };
    assert_eq!(server.blobs().find_missing(ask).await.unwrap().into_inner().digests, [name]);
    let again = server.submit("second", script).await;
    let status = server.wait(&again).await;
    assert_eq!((status.state(), status.events), (v1::JobState::Succeeded, 10));
    server.stop().await;
}

#[tokio::test]
async fn a_download_of_changed_content_ends_with_data_loss() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let name = server.upload(b"whole").await;
    std::fs::write(folder.path().join("blobs").join(&name[..2]).join(&name), "other").unwrap();
    let stream = server.blobs().download(v1::DownloadRequest { digest: name }).await.unwrap();
    let mut stream = stream.into_inner();
    let status = loop {
        match stream.message().await {
            Ok(message) => assert!(message.is_some(), "the content must not end as if whole"),
            Err(status) => break status,
        }
    };
    assert_eq!((status.code(), reason(&status).as_str()), (Code::DataLoss, "DATA_LOSS"));
    server.stop().await;
}

#[tokio::test]
async fn a_lost_or_empty_ledger_beside_jobs_refuses_the_start() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    // A log of some size, so that the job has a folder.
    let job = server.submit("r", "EVENTS 20000").await;
    server.wait(&job).await;
    server.stop().await;
    let ledger = folder.path().join("ledger.redb");
    let kept = std::fs::read(&ledger).unwrap();
    let lost = |path: &Path| std::fs::remove_file(path).unwrap();
    let empty = |path: &Path| drop(std::fs::File::create(path).unwrap());
    for damage in [&lost as &dyn Fn(&Path), &empty] {
        damage(&ledger);
        let why = why_not_started(folder.path()).await;
        assert!(why.contains("ledger.redb") && why.contains("mv "), "{why}");
    }
    std::fs::write(&ledger, "not a ledger").unwrap();
    let why = why_not_started(folder.path()).await;
    assert!(why.contains("ledger.redb") && why.contains("mv "), "{why}");
    std::fs::write(&ledger, kept).unwrap();
    let server = Server::start(options(folder.path())).await;
    assert_eq!(server.status(&job).await.events, 20_000);
    server.stop().await;
}

#[tokio::test]
async fn an_unreadable_row_is_reported_and_stops_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let good = server.submit("good", "EVENTS 5").await;
    let bad = server.submit("bad", "EVENTS 5").await;
    server.wait(&good).await;
    server.wait(&bad).await;
    server.stop().await;
    let table = redb::TableDefinition::<&str, &[u8]>::new("job");
    let database = redb::Database::open(folder.path().join("ledger.redb")).unwrap();
    let txn = database.begin_write().unwrap();
    txn.open_table(table).unwrap().insert(bad.as_str(), b"{\"id\":".as_slice()).unwrap();
    txn.commit().unwrap();
    assert!(database.begin_read().unwrap().open_table(table).unwrap().get(bad.as_str()).unwrap().is_some());
    drop(database);
    let server = Server::start(options(folder.path())).await;
    assert_eq!(server.status(&good).await.state(), v1::JobState::Succeeded);
    let jobs = server.jobs().list_jobs(v1::ListJobsRequest::default()).await.unwrap().into_inner().jobs;
    assert_eq!(jobs.iter().map(|job| &job.job_id).collect::<Vec<_>>(), [&good]);
    let status = server.jobs().get_job(v1::GetJobRequest { job_id: bad }).await.unwrap_err();
    assert_eq!((status.code(), reason(&status).as_str()), (Code::DataLoss, "DATA_LOSS"));
    server.stop().await;
}
