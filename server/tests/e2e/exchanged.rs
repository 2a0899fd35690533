//! Files exchanged between two jobs, and missing files: each answer is correct for its own job, or reports damage with
//! the id of that job.

use std::path::Path;

use counterpoint_proto::v1;
use counterpoint_server::doctor::examine;
use tonic::{Code, Status};

use crate::support::*;

/// All of a stream, or the status that ends it.
async fn whole<T>(answer: Result<tonic::Response<tonic::Streaming<T>>, Status>) -> Result<Vec<T>, Status> {
    let (mut stream, mut all) = (answer?.into_inner(), Vec::new());
    while let Some(message) = stream.message().await? {
        all.push(message);
    }
    Ok(all)
}

/// Makes every call that reads the log of a job; returns the error of each.
async fn reads_of_log(server: &Server, job: &str) -> Vec<(&'static str, Option<Status>)> {
    let (job_id, mut results) = (job.to_owned(), server.results());
    let id = || job_id.clone();
    let watch = v1::WatchJobRequest { job_id: id(), level: v1::WatchLevel::Everything.into(), ..Default::default() };
    let (timeline, toolpath) = (
        v1::GetTimelineRequest { job_id: id(), ..Default::default() },
        v1::GetToolpathRequest { job_id: id(), ..Default::default() },
    );
    let listing = v1::GetListingRequest { job_id: id(), ..Default::default() };
    let trace = v1::GetTraceRequest { job_id: id(), channel: 1 };
    vec![
        ("watch", whole(server.jobs().watch_job(watch).await).await.err()),
        ("events", whole(results.get_events(v1::GetEventsRequest { job_id: id() }).await).await.err()),
        ("summary", whole(results.get_summary(v1::GetSummaryRequest { job_id: id() }).await).await.err()),
        ("timeline", whole(results.get_timeline(timeline).await).await.err()),
        ("toolpath", whole(results.get_toolpath(toolpath).await).await.err()),
        ("listing", whole(results.get_listing(listing).await).await.err()),
        ("trace", whole(results.get_trace(trace).await).await.err()),
    ]
}

/// Asserts that each call that reads the log reports one damage, with the id of the job.
async fn assert_lost(server: &Server, job: &str, what: &str) {
    let mut texts = Vec::new();
    for (call, status) in reads_of_log(server, job).await {
        let status = status.unwrap_or_else(|| panic!("{call} must report: {what}"));
        assert_eq!((status.code(), reason(&status).as_str()), (Code::DataLoss, "DATA_LOSS"), "{call} {status:?}");
        assert!(status.message().contains(job), "{call} names the job: {}", status.message());
        texts.push(status.message().to_owned());
    }
    texts.dedup();
    assert!(texts.len() == 1 && texts[0].contains(what), "one text for one damage: {texts:?}");
}

fn exchange(data: &Path, jobs: [&str; 2], file: &str) {
    let [first, second] = jobs.map(|job| data.join("jobs").join(job).join(file));
    let aside = data.join("aside");
    std::fs::rename(&first, &aside).unwrap();
    std::fs::rename(&second, &first).unwrap();
    std::fs::rename(&aside, &second).unwrap();
}

async fn files_of(server: &Server, job: &str) -> Result<Vec<String>, Status> {
    let list = v1::ListFilesRequest { job_id: job.into(), ..Default::default() };
    let files = server.results().list_files(list).await?.into_inner().files;
    Ok(files.into_iter().map(|file| file.path).collect())
}

#[tokio::test]
async fn files_that_two_jobs_have_exchanged_are_damage_of_both() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let mut pairs = Vec::new();
    for (file, events) in [("log", 700), ("log.segments", 3000), ("files.json", 9)] {
        let mut jobs = Vec::new();
        for name in ["a.txt", "b.txt"] {
            let job = server.submit(&format!("{file}.{name}"), &format!("EVENTS {events}\nWRITE {name}")).await;
            server.wait(&job).await;
            jobs.push(job);
        }
        pairs.push((file, jobs));
    }
    server.stop().await;
    for (file, jobs) in &pairs {
        exchange(folder.path(), [&jobs[0], &jobs[1]], file);
    }
    let found = examine(folder.path(), false).unwrap();
    for (file, jobs) in &pairs {
        for job in jobs {
            let path = folder.path().join("jobs").join(job).join(file);
            assert!(found.iter().any(|damage| damage.path == path), "{}: {found:#?}", path.display());
        }
    }
    let server = Server::start(options(folder.path())).await;
    for (file, jobs) in &pairs {
        for (job, name) in jobs.iter().zip(["a.txt", "b.txt"]) {
            let files = files_of(&server, job).await;
            if *file == "files.json" {
                let status = files.unwrap_err();
                assert!(reason(&status) == "DATA_LOSS" && status.message().contains(job.as_str()), "{status:?}");
            } else {
                assert_eq!(files.unwrap(), [name]);
                assert_lost(&server, job, "checksum").await;
            }
            let get = v1::GetJobRequest { job_id: job.clone() };
            let answer = server.jobs().get_job(get).await.unwrap().into_inner();
            assert_eq!(answer.description.is_some(), *file == "files.json", "no description of another job");
        }
    }
    server.stop().await;
}

#[tokio::test]
async fn a_log_that_is_gone_has_one_text_and_its_files_are_still_read() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let mut jobs = Vec::new();
    for (name, script) in [("log", "EVENTS 3000"), ("files", "EVENTS 3000\nWRITE a.txt")] {
        let job = server.submit(name, script).await;
        server.wait(&job).await;
        jobs.push(job);
    }
    server.stop().await;
    for job in &jobs {
        std::fs::remove_file(log_file(folder.path(), job)).unwrap();
    }
    let server = Server::start(options(folder.path())).await;
    for (job, files) in jobs.iter().zip([&[][..], &["a.txt"]]) {
        assert_lost(&server, job, "it is missing").await;
        assert_eq!(files_of(&server, job).await.unwrap(), files);
        let get = v1::GetFileRequest { job_id: job.clone(), path: "a.txt".into() };
        let got = whole(server.results().get_file(get).await).await;
        match got {
            Ok(parts) => assert!(!files.is_empty() && parts[0].data == "a.txt", "{parts:?}"),
            Err(status) => assert_eq!((reason(&status).as_str(), files.len()), ("UNKNOWN_FILE", 0)),
        }
    }
    server.stop().await;
}

#[tokio::test]
async fn results_of_a_job_whose_program_has_changed_on_the_disk_are_data_loss() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let job = server.submit("r", "EVENTS 9").await;
    server.wait(&job).await;
    server.stop().await;
    let name = digest(b"EVENTS 9");
    std::fs::write(folder.path().join("blobs").join(&name[..2]).join(&name), "EVENTS 8").unwrap();
    let server = Server::start(options(folder.path())).await;
    let get = v1::GetSummaryRequest { job_id: job.clone() };
    let status = whole(server.results().get_summary(get).await).await.unwrap_err();
    assert!(reason(&status) == "DATA_LOSS" && status.message().contains(&job), "{status:?}");
    server.stop().await;
}
