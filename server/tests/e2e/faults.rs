//! A disk that fails at any write, and a loss of power at any write: every accepted job ends exactly once, and its
//! reported state is true.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use counterpoint_proto::v1;
use counterpoint_server::doctor;
use counterpoint_server::local::disk::Disk;

use crate::bad_disk::{BadDisk, Random, numbered};
use crate::cache::caching;
use crate::support::*;

/// Kinds of jobs: a small log, a log in a file, one with stored results, files of macros, and a job that fails.
const SCRIPTS: [&str; 6] = [
    "EVENTS 20",
    "EVENTS 3000",
    "EVENTS 20000",
    "EVENTS 12\nWRITE a.txt\nWRITE out/b.txt",
    "EVENTS 7\nALARM",
    "REFUSE",
];

/// Jobs of one seed.
const JOBS: usize = 9;

/// Data of an accepted job: its identity, and its end if that was seen.
#[derive(Debug, Clone, Default)]
struct Known {
    job: String,
    ended: Option<v1::JobStatus>,
}

/// Answers that a client has received, by request id.
type Heard = BTreeMap<String, Known>;

fn script(request: &str) -> &'static str {
    let number: usize = request.rsplit_once('-').unwrap().1.parse().unwrap();
    SCRIPTS[number % SCRIPTS.len()]
}

/// Submits jobs until the disk has no power, repeating refused requests; returns the answers.
async fn load(server: &Server, disk: &BadDisk, caller: usize) -> Heard {
    let mut heard = Heard::new();
    for number in 0..JOBS {
        let id = format!("{caller}-{number}");
        while disk.has_power() {
            // Uploads fail like all else.
            let Some(request) = request(server, &id).await else { continue };
            if let Ok(accepted) = server.jobs().submit_job(request).await {
                let job = accepted.into_inner().status.unwrap().job_id;
                heard.insert(id.clone(), Known { job, ended: None });
                break;
            }
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
        for known in heard.values_mut().filter(|known| known.ended.is_none()) {
            let request = v1::GetJobRequest { job_id: known.job.clone() };
            let status = server.jobs().get_job(request).await.ok().map(|answer| answer.into_inner().status.unwrap());
            known.ended = status.filter(|status| status.ended_ms > 0);
        }
    }
    heard
}

async fn request(server: &Server, id: &str) -> Option<v1::SubmitJobRequest> {
    submission(server, id, script(id)).await
}

/// A submit whose file has been uploaded, if it could be.
pub async fn submission(server: &Server, id: &str, script: &str) -> Option<v1::SubmitJobRequest> {
    let content = script.as_bytes();
    let upload = v1::UploadRequest { digest: digest(content), data: content.to_vec().into(), size: None };
    let uploaded = server.blobs().upload(tokio_stream::iter([upload])).await;
    let digest = uploaded.ok()?.into_inner().digest;
    Some(v1::SubmitJobRequest {
        request_id: id.into(),
        machine: "fanuc-2path-lathe".into(),
        programs: vec![v1::Program { path: "main.nc".into(), ..Default::default() }],
        files: vec![v1::FileRef { path: "main.nc".into(), digest }],
        ..Default::default()
    })
}

/// All reports about a job, without the parts that differ between runs.
#[derive(Debug, PartialEq)]
pub struct Said {
    state: v1::JobState,
    events: Vec<v1::Event>,
    summary: String,
    log: String,
    files: Vec<(String, String)>,
}

/// All chunks of an answer as text, or the reason why there is none.
macro_rules! text {
    ($call:expr) => {
        match $call.await {
            Err(status) => reason(&status),
            Ok(stream) => {
                let (mut stream, mut text) = (stream.into_inner(), Vec::new());
                while let Some(chunk) = stream.message().await.unwrap() {
                    text.extend_from_slice(&chunk.data);
                }
                String::from_utf8(text).unwrap()
            }
        }
    };
}

pub async fn said(server: &Server, job: &str) -> Said {
    let (id, mut results) = (job.to_owned(), server.results());
    let status = server.wait(job).await;
    assert!(status.ended_ms > 0, "{status:?}");
    let state = status.state();
    let events = server.events(job, 0).await;
    let summary = text!(results.get_summary(v1::GetSummaryRequest { job_id: id.clone() }));
    let log = text!(results.get_events(v1::GetEventsRequest { job_id: id.clone() }));
    let listed = results.list_files(v1::ListFilesRequest { job_id: id.clone(), ..Default::default() }).await;
    let mut files = Vec::new();
    for file in listed.map_or(Vec::new(), |listed| listed.into_inner().files) {
        let request = v1::GetFileRequest { job_id: id.clone(), path: file.path.clone() };
        files.push((file.path, text!(results.get_file(request))));
    }
    Said { state, events, summary, log, files }
}

/// Drives a server with a bad disk; then a server on the remains of its folder, which must keep every promise.
async fn drive(folder: &Path, seed: u64, power: bool, expected: &BTreeMap<&str, Said>) -> (u64, usize) {
    let mut random = Random(seed);
    let disk = Arc::new(BadDisk::new(seed, power));
    let data = numbered(folder, seed);
    // With every other seed, equal jobs reuse results.
    let options = |data: &Path| if seed % 2 == 1 { caching(data) } else { options(data) };
    let server = Server::start_on(options(&data), Disk::faulty(disk.clone())).await;
    if power {
        disk.lose_power_after(10 + random.below(600));
    }
    // With power loss alone at every other seed.
    if !power || random.below(2) == 0 {
        disk.fail(1 + random.below(60));
    }
    let space_back = async {
        tokio::time::sleep(Duration::from_millis(300 + random.below(700))).await;
        disk.fail(0);
    };
    let (mut heard, second, ()) = tokio::join!(load(&server, &disk, 0), load(&server, &disk, 1), space_back);
    heard.extend(second);
    assert!(power || heard.len() == 2 * JOBS, "with space everything is accepted");
    let (server, data) = if power {
        while disk.has_power() {
            disk.lose_power_after(0);
        }
        let left = numbered(folder, seed + 1_000_000);
        let torn = random.below(2) == 0;
        disk.survived(&data, &left, torn);
        println!("seed {seed}: torn {torn}, {} steps failed, {} jobs accepted", disk.failed(), heard.len());
        server.handle.stop();
        server.handle.stop();
        server.task.await.unwrap();
        (Server::start(options(&left)).await, left)
    } else {
        (server, data)
    };
    for (id, known) in &heard {
        let status = server.status(&known.job).await;
        if let Some(before) = &known.ended {
            let what = |status: &v1::JobStatus| (status.state(), status.attempt, status.ended_ms, status.events);
            assert_eq!(what(&status), what(before), "seed {seed}: an end that was seen is the end of {id}");
        }
        assert_eq!(&said(&server, &known.job).await, &expected[script(id)], "seed {seed}: {id}");
        let request = request(&server, id).await.unwrap();
        let again = server.jobs().submit_job(request).await.unwrap().into_inner();
        assert!(again.duplicate && again.status.unwrap().job_id == known.job, "seed {seed}: {id} once");
    }
    server.stop().await;
    let damages = doctor::examine(&data, false).unwrap();
    assert!(damages.is_empty(), "seed {seed}: {damages:?}");
    std::fs::remove_dir_all(&data).unwrap();
    (disk.failed(), heard.len())
}

/// The answers of a server on a good disk about each kind of job.
async fn expected(folder: &Path) -> BTreeMap<&'static str, Said> {
    let server = Server::start(options(&folder.join("good"))).await;
    let mut expected = BTreeMap::new();
    for (number, script) in SCRIPTS.iter().enumerate() {
        let job = server.submit(&number.to_string(), script).await;
        expected.insert(*script, said(&server, &job).await);
    }
    server.stop().await;
    expected
}

async fn many(seeds: std::ops::Range<u64>, power: bool) {
    let folder = tempfile::tempdir().unwrap();
    let expected = expected(folder.path()).await;
    let (mut failed, mut accepted) = (0, 0);
    for seed in seeds.clone() {
        let (own, jobs) = drive(folder.path(), seed, power, &expected).await;
        (failed, accepted) = (failed + own, accepted + jobs);
    }
    println!("seeds {seeds:?}, power loss {power}: {failed} steps failed, {accepted} jobs accepted");
    assert!(failed > 0 && accepted > 0);
}

#[tokio::test]
async fn with_a_bad_disk_every_accepted_job_ends_once_and_nothing_lies() {
    many(0..4, false).await;
}

#[tokio::test]
async fn after_a_loss_of_power_every_accepted_job_ends_once_and_nothing_lies() {
    many(100..112, true).await;
}

/// `SEEDS=500 cargo test --release -p counterpoint-server --test e2e -- --ignored many_seeds --nocapture`
#[tokio::test]
#[ignore = "takes minutes"]
async fn many_seeds() {
    let seeds = std::env::var("SEEDS").ok().and_then(|seeds| seeds.parse().ok()).unwrap_or(100);
    many(1000..1000 + seeds, true).await;
    many(5000..5000 + seeds / 4, false).await;
}
