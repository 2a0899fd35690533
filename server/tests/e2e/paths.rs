//! No text that reaches a client names a place on the server.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use counterpoint_proto::v1;
use counterpoint_server::local::disk::{Disk, DiskOperation, Faults};
use prost::Message;
use tonic::Status;

use crate::faults::submission;
use crate::support::*;

/// Whether a step fails.
type Fails = fn(DiskOperation) -> bool;

/// A disk on which steps of one kind fail, with errors that name the file.
#[derive(Default)]
struct Telling(Mutex<Option<Fails>>);

impl Faults for Telling {
    fn before(&self, step: DiskOperation, path: &Path) -> io::Result<usize> {
        match *self.0.lock().unwrap() {
            Some(fails) if fails(step) => {
                Err(io::Error::other(format!("input/output error at path \"{}\"", path.display())))
            }
            _ => Ok(usize::MAX),
        }
    }
}

/// Checks that no answer to a client names a path of the server.
struct PathCheck {
    folder: PathBuf,
    refused: usize,
}

impl PathCheck {
    fn look(&mut self, call: &str, text: &str) {
        assert!(!text.contains(self.folder.to_str().unwrap()), "{call}: {text}");
    }

    fn answer<T: Message>(&mut self, call: &str, answer: Result<tonic::Response<T>, Status>) {
        match answer {
            Ok(answer) => self.look(call, &String::from_utf8_lossy(&answer.into_inner().encode_to_vec())),
            Err(status) => self.refusal(call, &status),
        }
    }

    fn refusal(&mut self, call: &str, status: &Status) {
        self.refused += 1;
        self.look(call, status.message());
        self.look(call, &String::from_utf8_lossy(status.details()));
    }

    async fn stream<T: Message>(&mut self, call: &str, answer: Result<tonic::Response<tonic::Streaming<T>>, Status>) {
        let mut stream = match answer {
            Ok(answer) => answer.into_inner(),
            Err(status) => return self.refusal(call, &status),
        };
        while let Ok(next) = tokio::time::timeout(Duration::from_millis(300), stream.message()).await {
            match next {
                Ok(Some(message)) => self.look(call, &String::from_utf8_lossy(&message.encode_to_vec())),
                Ok(None) => return,
                Err(status) => return self.refusal(call, &status),
            }
        }
    }
}

/// Makes every call that reads or writes.
async fn ask_all(server: &Server, check: &mut PathCheck, jobs: &[String], round: usize) {
    let content = format!("EVENTS {}", round + 1);
    let chunk =
        v1::UploadRequest { digest: digest(content.as_bytes()), data: content.clone().into(), ..Default::default() };
    check.answer("upload", server.blobs().upload(tokio_stream::iter([chunk])).await);
    let known = digest(b"EVENTS 20000\nWRITE a.txt");
    let find = v1::FindMissingRequest { digests: vec![known.clone()] };
    check.answer("find", server.blobs().find_missing(find).await);
    check.stream("download", server.blobs().download(v1::DownloadRequest { digest: known.clone() }).await).await;
    let submit = v1::SubmitJobRequest {
        request_id: format!("more-{round}"),
        machine: "fanuc-2path-lathe".into(),
        programs: vec![v1::Program { path: "main.nc".into(), ..Default::default() }],
        files: vec![v1::FileRef { path: "main.nc".into(), digest: known.clone() }],
        ..Default::default()
    };
    let guess = v1::SubmitJobRequest { machine: String::new(), request_id: format!("guess-{round}"), ..submit.clone() };
    check.answer("submit", server.jobs().submit_job(submit).await);
    check.answer("guess", server.jobs().submit_job(guess).await);
    let files = vec![v1::MachineFile { path: "own/machine.toml".into(), digest: known }];
    let put = v1::PutMachineRequest { name: "own".into(), files };
    check.answer("put machine", server.machines().put_machine(put).await);
    let list = v1::ListMachinesRequest { page_size: 3, ..Default::default() };
    check.answer("list machines", server.machines().list_machines(list).await);
    check.answer("list", server.jobs().list_jobs(v1::ListJobsRequest::default()).await);
    for (at, job) in jobs.iter().enumerate() {
        let job_id = job.clone();
        check.answer("get", server.jobs().get_job(v1::GetJobRequest { job_id: job_id.clone() }).await);
        let watch = v1::WatchJobRequest { job_id: job_id.clone(), ..Default::default() };
        check.stream("watch", server.jobs().watch_job(watch).await).await;
        let ask = v1::GetEventsRequest { job_id: job_id.clone() };
        check.stream("events", server.results().get_events(ask).await).await;
        let ask = v1::GetSummaryRequest { job_id: job_id.clone() };
        check.stream("summary", server.results().get_summary(ask).await).await;
        let ask = v1::GetTimelineRequest { job_id: job_id.clone(), ..Default::default() };
        check.stream("timeline", server.results().get_timeline(ask).await).await;
        let ask = v1::GetListingRequest { job_id: job_id.clone(), channel: 1, ..Default::default() };
        check.stream("listing", server.results().get_listing(ask).await).await;
        let ask = v1::ListFilesRequest { job_id: job_id.clone(), ..Default::default() };
        check.answer("files", server.results().list_files(ask).await);
        let ask = v1::GetFileRequest { job_id: job_id.clone(), path: "a.txt".into() };
        check.stream("file", server.results().get_file(ask).await).await;
        let rerun = v1::RerunJobRequest { request_id: format!("re-{round}-{at}"), job_id, ..Default::default() };
        check.answer("rerun", server.jobs().rerun_job(rerun).await);
    }
}

/// Whether a job is accepted.
async fn accepts(server: &Server, request_id: &str) -> bool {
    let Some(request) = submission(server, request_id, "EVENTS 1").await else { return false };
    server.jobs().submit_job(request).await.is_ok()
}

#[tokio::test]
async fn no_error_names_a_place_on_the_server() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data");
    let faults = Arc::new(Telling::default());
    let server = Server::start_on(options(&data), Disk::faulty(faults.clone())).await;
    let mut jobs = Vec::new();
    for (name, script) in [("large", "EVENTS 20000\nWRITE a.txt"), ("refused", "REFUSE"), ("panic", "PANIC")] {
        jobs.push(server.submit(name, script).await);
        server.wait(&jobs[jobs.len() - 1]).await;
    }
    let mut check = PathCheck { folder: data.clone(), refused: 0 };
    let kinds: [Fails; 5] = [
        |step| step == DiskOperation::Read,
        |step| matches!(step, DiskOperation::Create),
        |step| matches!(step, DiskOperation::Write(_)),
        |step| matches!(step, DiskOperation::Sync),
        |step| matches!(step, DiskOperation::Place),
    ];
    for (round, fails) in kinds.into_iter().enumerate() {
        *faults.0.lock().unwrap() = Some(fails);
        let before = check.refused;
        ask_all(&server, &mut check, &jobs, round).await;
        assert!(check.refused > before, "kind {round} is met");
        *faults.0.lock().unwrap() = None;
        let accepted = async {
            while !accepts(&server, &format!("next-{round}")).await {
                tokio::time::sleep(Duration::from_millis(20)).await;
            }
        };
        tokio::time::timeout(Duration::from_secs(20), accepted).await.expect("the ledger opens again");
    }
    // Files that are folders, cut short, or gone.
    let large = data.join("jobs").join(&jobs[0]);
    for name in ["log.segments", "files.json", "summary.json", "timeline.json", "timeline.svg"] {
        let path = large.join(name);
        if path.is_file() {
            std::fs::remove_file(&path).unwrap();
            std::fs::create_dir(&path).unwrap();
        }
    }
    ask_all(&server, &mut check, &jobs, 7).await;
    server.stop().await;
}
