//! How many tiny jobs end in a second. Run by hand, in release, on a quiet machine:
//! `cargo test --release -p counterpoint-server --test e2e rate -- --ignored --nocapture`.

#![allow(clippy::print_stdout)]

use std::path::Path;
use std::time::Instant;

use counterpoint_proto::v1;
use counterpoint_server::options::Options;

use crate::support::*;

const JOBS: usize = 2000;
const CALLERS: usize = 64;

/// Ended jobs per second, from the first submit to the last end, with the folder in `parent`.
async fn rate(parent: &Path) -> f64 {
    let folder = tempfile::tempdir_in(parent).unwrap();
    let server = Server::start(Options { queue: JOBS, ..options(folder.path()) }).await;
    let request = server.request("", "EVENTS 20").await;
    let begin = Instant::now();
    let callers = (0..CALLERS).map(|caller| {
        let (mut jobs, request) = (server.jobs(), request.clone());
        tokio::spawn(async move {
            let mut last = String::new();
            for n in 0..JOBS / CALLERS {
                let request = v1::SubmitJobRequest { request_id: format!("{caller}-{n}"), ..request.clone() };
                last = jobs.submit_job(request).await.unwrap().into_inner().status.unwrap().job_id;
            }
            let status = jobs.wait_job(v1::WaitJobRequest { job_id: last, timeout_ms: 600_000 }).await.unwrap();
            assert_eq!(status.into_inner().status.unwrap().state(), v1::JobState::Succeeded);
        })
    });
    for caller in callers.collect::<Vec<_>>() {
        caller.await.unwrap();
    }
    let rate = (JOBS / CALLERS * CALLERS) as f64 / begin.elapsed().as_secs_f64();
    server.stop().await;
    rate
}

#[tokio::test(flavor = "multi_thread")]
#[ignore = "a measurement"]
async fn tiny_jobs_ended_per_second_on_disk_and_in_memory() {
    let disk = rate(&std::env::temp_dir()).await;
    println!("on disk: {disk:.0} tiny jobs ended per second");
    let memory = Path::new("/dev/shm");
    if memory.is_dir() {
        let memory = rate(memory).await;
        println!("in memory: {memory:.0}; on disk {:.2} of that", disk / memory);
    }
}
