//! A server that is killed (`kill -9`) again and again under load, on a good disk and on a bad one.
//!
//! The server is this test program, started again as [`serve`]: it needs no option that a real server does not have.

use std::collections::BTreeMap;
use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use counterpoint_proto::v1;
use counterpoint_proto::v1::blobs_client::BlobsClient;
use counterpoint_proto::v1::jobs_client::JobsClient;
use counterpoint_server::local::disk::Disk;
use counterpoint_server::options::{Maxima, ServerOptions};
use counterpoint_server::service;
use tonic::transport::{Channel, Endpoint};

use crate::bad_disk::{BadDisk, Random};
use crate::cache::caching;
use crate::support::*;

/// The data folder of [`serve`], and of a thousand steps of its disk this many fail.
const FOLDER: &str = "COUNTERPOINT_TEST_FOLDER";
const FAULTS: &str = "COUNTERPOINT_TEST_FAULTS";

const SCRIPTS: [&str; 4] = ["EVENTS 20", "EVENTS 3000", "EVENTS 12\nWRITE a.txt", "EVENTS 15000"];
/// Requests in progress at the same time.
const CALLERS: usize = 4;

/// A job that is running alone at several kills is not given up.
fn patient() -> Maxima {
    Maxima { attempts: u32::MAX, ..Maxima::default() }
}

/// The server that is killed; without its folder in the environment this does nothing.
#[tokio::test(flavor = "multi_thread")]
#[ignore = "the server of the other tests here"]
async fn serve() {
    let (Ok(folder), Ok(faults)) = (std::env::var(FOLDER), std::env::var(FAULTS)) else { return };
    let disk = Arc::new(BadDisk::new(std::process::id().into(), false));
    let options = ServerOptions { queue: 100_000, maxima: patient(), ..caching(Path::new(&folder)) };
    let service = service::build_on(options, Script::default(), Disk::faulty(disk.clone())).await.unwrap();
    disk.fail(faults.parse().unwrap());
    println!("\nlistening on {}", service.handle().url());
    service.run(std::future::pending()).await.unwrap();
}

struct Process(Child);

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Starts a server; returns its address too.
fn start(folder: &Path, permille: u64) -> (Process, String) {
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["killed::serve", "--exact", "--ignored", "--nocapture"])
        .env(FOLDER, folder)
        .env(FAULTS, permille.to_string())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let address = lines.map(Result::unwrap).find_map(|line| line.strip_prefix("listening on ").map(str::to_owned));
    (Process(child), address.expect("the server starts"))
}

/// Kills beyond those of the test, as long as no server has accepted anything.
const MORE: u64 = 100;

/// Accepted jobs: identity by request id.
type Accepted = Arc<Mutex<BTreeMap<String, String>>>;

/// Submits until the server dies. A request that was not answered is asked again of the next server.
async fn load(channel: Channel, accepted: Accepted, asked: Arc<Mutex<Vec<u64>>>, seed: u64) {
    let (mut random, mut blobs, mut jobs) = (Random(seed), BlobsClient::new(channel.clone()), JobsClient::new(channel));
    loop {
        let number = match asked.lock().unwrap().pop() {
            Some(number) => number,
            None => random.next() >> 8,
        };
        let content = SCRIPTS[usize::try_from(number % 4).unwrap()].as_bytes();
        let upload = v1::UploadRequest { digest: digest(content), data: content.into(), size: None };
        let request = v1::SubmitJobRequest {
            request_id: number.to_string(),
            machine: "fanuc-2path-lathe".into(),
            programs: vec![v1::Program { path: "main.nc".into(), ..Default::default() }],
            files: vec![v1::FileRef { path: "main.nc".into(), digest: digest(content) }],
            // Half of the jobs run; the others get the results of an equal job.
            options: Some(v1::JobOptions { no_cache: number % 8 < 4, ..Default::default() }),
            ..Default::default()
        };
        let uploaded = blobs.upload(tokio_stream::iter([upload])).await;
        let answer = match uploaded {
            Ok(_) => jobs.submit_job(request).await,
            Err(status) => Err(status),
        };
        match answer {
            Ok(answer) => {
                let job = answer.into_inner().status.unwrap().job_id;
                let before = accepted.lock().unwrap().insert(number.to_string(), job.clone());
                assert!(before.is_none_or(|before| before == job), "a request id has one job");
            }
            Err(status) => {
                asked.lock().unwrap().push(number);
                if !status.message().contains("transport") && reason_of(&status).is_some() {
                    tokio::time::sleep(Duration::from_millis(5)).await;
                    continue;
                }
                return;
            }
        }
    }
}

/// The reason that the server gave; none if it is gone.
fn reason_of(status: &tonic::Status) -> Option<String> {
    use tonic_types::StatusExt as _;
    status.get_error_details().error_info().map(|info| info.reason.clone())
}

async fn kill(kills: u64, permille: u64) {
    let folder = tempfile::tempdir().unwrap();
    let (accepted, asked) = (Accepted::default(), Arc::default());
    let mut random = Random(kills + permille);
    let begin = Instant::now();
    // On a loaded machine the first servers may be killed before they have accepted anything.
    let more = |number: u64| number < kills || number < kills + MORE && accepted.lock().unwrap().is_empty();
    for number in (0..).take_while(|number| more(*number)) {
        let (mut process, address) = start(folder.path(), permille);
        let channel = Endpoint::from_shared(address).unwrap().connect().await.unwrap();
        let mut callers = tokio::task::JoinSet::new();
        for caller in 0..CALLERS {
            let seed = number * 1000 + caller as u64;
            callers.spawn(load(channel.clone(), accepted.clone(), Arc::clone(&asked), seed));
        }
        tokio::time::sleep(Duration::from_millis(20 + random.below(180))).await;
        process.0.kill().unwrap();
        while let Some(ended) = callers.join_next().await {
            ended.unwrap();
        }
    }
    let (killed, accepted) = (begin.elapsed(), accepted.lock().unwrap().clone());
    let server = Server::start(ServerOptions { queue: 100_000, maxima: patient(), ..options(folder.path()) }).await;
    let mut expected = Vec::new();
    for (number, script) in SCRIPTS.iter().enumerate() {
        let job = server.submit(&format!("again-{number}"), script).await;
        expected.push(ended(&server, &job).await);
    }
    for (request, job) in &accepted {
        let number: u64 = request.parse().unwrap();
        let expected = &expected[usize::try_from(number % 4).unwrap()];
        assert!(&ended(&server, job).await == expected, "the job of request {request} has other events");
    }
    let mut listed = Vec::new();
    let mut request = v1::ListJobsRequest { page_size: 500, ..Default::default() };
    loop {
        let page = server.jobs().list_jobs(request.clone()).await.unwrap().into_inner();
        listed.extend(page.jobs.into_iter().map(|job| job.request_id));
        request.page_token = page.next_page_token;
        if request.page_token.is_empty() {
            break;
        }
    }
    let all = listed.len();
    listed.sort();
    listed.dedup();
    assert_eq!(all, listed.len(), "no request has two jobs");
    server.stop().await;
    println!(
        "{kills} kills in {killed:?}, {permille} of 1000 steps failed: {} jobs accepted, all ended once",
        accepted.len()
    );
    assert!(!accepted.is_empty());
}

/// State and events of a job that ends.
async fn ended(server: &Server, job: &str) -> (v1::JobState, Vec<v1::Event>) {
    let mut status = server.wait(job).await;
    while status.ended_ms == 0 {
        status = server.wait(job).await;
    }
    (status.state(), server.events(job, 0).await)
}

#[tokio::test(flavor = "multi_thread")]
async fn a_server_killed_again_and_again_ends_every_accepted_job_once() {
    kill(4, 0).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn so_does_one_whose_disk_fails_too() {
    kill(4, 15).await;
}

/// `KILLS=500 cargo test --release -p counterpoint-server --test e2e -- --ignored kill_500 --nocapture`
#[tokio::test(flavor = "multi_thread")]
#[ignore = "takes minutes"]
async fn kill_500() {
    let kills = std::env::var("KILLS").ok().and_then(|kills| kills.parse().ok()).unwrap_or(500);
    kill(kills, 0).await;
    kill(kills, 15).await;
}

/// Bytes of memory that a process has in use.
pub fn resident(process: u32) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
    line.trim().trim_end_matches(" kB").parse::<u64>().unwrap() * 1024
}

/// `JOBS=100000 cargo test --release -p counterpoint-server --test e2e -- --ignored long_queue --nocapture`
#[tokio::test(flavor = "multi_thread")]
#[ignore = "prints figures"]
async fn long_queue() {
    let jobs: u64 = std::env::var("JOBS").ok().and_then(|jobs| jobs.parse().ok()).unwrap_or(100_000);
    let folder = tempfile::tempdir().unwrap();
    let (mut process, address) = start(folder.path(), 0);
    let channel = Endpoint::from_shared(address).unwrap().connect().await.unwrap();
    println!("idle: {} MiB", resident(process.0.id()) >> 20);
    let mut blobs = BlobsClient::new(channel.clone());
    let upload = v1::UploadRequest { digest: digest(b"HANG"), data: "HANG".into(), size: None };
    blobs.upload(tokio_stream::iter([upload])).await.unwrap();
    let submit = |number: u64| {
        let mut client = JobsClient::new(channel.clone());
        let request = v1::SubmitJobRequest {
            request_id: number.to_string(),
            machine: "fanuc-2path-lathe".into(),
            programs: vec![v1::Program { path: "main.nc".into(), ..Default::default() }],
            files: vec![v1::FileRef { path: "main.nc".into(), digest: digest(b"HANG") }],
            ..Default::default()
        };
        async move { client.submit_job(request).await.unwrap() }
    };
    for number in 0..100 {
        submit(number).await;
    }
    let (before, begin) = (resident(process.0.id()), Instant::now());
    let (mut callers, mut times) = (tokio::task::JoinSet::new(), Vec::new());
    for number in 100..jobs {
        if callers.len() >= 64 {
            times.extend(callers.join_next().await.unwrap());
        }
        let submitted = submit(number);
        callers.spawn(async move {
            let begin = Instant::now();
            submitted.await;
            begin.elapsed()
        });
    }
    times.extend(callers.join_all().await);
    times.sort();
    println!("submit: p50 {:?}, p99 {:?}", times[times.len() / 2], times[times.len() * 99 / 100]);
    let each = (resident(process.0.id()) - before) / (jobs - 100).max(1);
    println!("{jobs} jobs queued in {:?}, {each} bytes of memory each", begin.elapsed());
    for states in [vec![], vec![v1::JobState::Queued.into()], vec![v1::JobState::Running.into()]] {
        let (mut client, begin) = (JobsClient::new(channel.clone()), Instant::now());
        let request = v1::ListJobsRequest { states: states.clone(), page_size: 50, ..Default::default() };
        let page = client.list_jobs(request).await.unwrap().into_inner();
        println!("a page of {} jobs, states {states:?}: {:?}", page.jobs.len(), begin.elapsed());
    }
    process.0.kill().unwrap();
    drop(process);
    let begin = Instant::now();
    let (process, _) = start(folder.path(), 0);
    println!("recovered in {:?}, {} bytes of memory each", begin.elapsed(), resident(process.0.id()) / jobs);
}
