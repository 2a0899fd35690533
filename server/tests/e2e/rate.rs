//! How many tiny jobs end and how many stored events are watched in a second, and how old live events are. Run by hand,
//! in release, on a quiet machine: `cargo test --release -p counterpoint-server --test e2e rate -- --ignored
//! --nocapture`.

#![allow(clippy::print_stdout)]

use std::path::Path;
use std::time::Instant;

use bytes::Buf as _;
use counterpoint_proto::v1;
use counterpoint_server::options::ServerOptions;
use tonic::Status;
use tonic::client::Grpc;
use tonic::codec::{Codec, DecodeBuf, Decoder, EncodeBuf, Encoder};
use tonic::transport::Endpoint;

use crate::support::*;

const JOBS: usize = 2000;
const CALLERS: usize = 64;

/// Ended jobs per second, from the first submit to the last end, with the folder in `parent`.
async fn rate(parent: &Path) -> f64 {
    let folder = tempfile::tempdir_in(parent).unwrap();
    let server = Server::start(ServerOptions { queue: JOBS, ..options(folder.path()) }).await;
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

/// Messages as they come: only their bytes are counted.
#[derive(Default)]
struct Raw;

impl Codec for Raw {
    type Encode = v1::WatchJobRequest;
    type Decode = usize;
    type Encoder = Self;
    type Decoder = Self;

    fn encoder(&mut self) -> Self {
        Self
    }

    fn decoder(&mut self) -> Self {
        Self
    }
}

impl Encoder for Raw {
    type Item = v1::WatchJobRequest;
    type Error = Status;

    fn encode(&mut self, item: Self::Item, out: &mut EncodeBuf<'_>) -> Result<(), Status> {
        prost::Message::encode(&item, out).map_err(|error| Status::internal(error.to_string()))
    }
}

impl Decoder for Raw {
    type Item = usize;
    type Error = Status;

    fn decode(&mut self, from: &mut DecodeBuf<'_>) -> Result<Option<usize>, Status> {
        let bytes = from.remaining();
        from.advance(bytes);
        Ok(Some(bytes))
    }
}

/// Watches an ended job on a connection of its own; returns the bytes that came.
async fn watched(url: String, job: String) -> usize {
    let mut client = Grpc::new(Endpoint::from_shared(url).unwrap().connect().await.unwrap());
    client.ready().await.unwrap();
    let request = v1::WatchJobRequest { job_id: job, level: v1::WatchLevel::Everything.into(), ..Default::default() };
    let path = "/counterpoint.v1.Jobs/WatchJob".parse().unwrap();
    let mut stream = client.server_streaming(tonic::Request::new(request), path, Raw).await.unwrap().into_inner();
    let mut bytes = 0;
    while let Some(more) = stream.message().await.unwrap() {
        bytes += more;
    }
    bytes
}

#[tokio::test(flavor = "multi_thread")]
#[ignore = "a measurement"]
async fn stored_events_watched_per_second() {
    const EVENTS: usize = 500_000;
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let mut jobs = Vec::new();
    for number in 0..16 {
        jobs.push(server.submit(&format!("r-{number}"), &format!("EVENTS {EVENTS}")).await);
    }
    for job in &jobs {
        assert_eq!(server.wait(job).await.state(), v1::JobState::Succeeded);
    }
    let url = server.handle.url();
    let each: Vec<String> = jobs.clone();
    let one = vec![jobs[0].clone(); 64];
    for (what, watched_jobs) in [("16 jobs, a watcher each", each), ("64 watchers of one job", one)] {
        let begin = Instant::now();
        let watchers: Vec<_> = watched_jobs.iter().map(|job| tokio::spawn(watched(url.clone(), job.clone()))).collect();
        let mut bytes = 0;
        for watcher in watchers {
            bytes += watcher.await.unwrap();
        }
        let seconds = begin.elapsed().as_secs_f64();
        let events = (watched_jobs.len() * EVENTS) as f64;
        println!("{what}: {:.1} M events/s, {:.0} MB/s", events / seconds / 1e6, bytes as f64 / seconds / 1e6);
    }
    server.stop().await;
}

/// How long an event of a running job takes to its watcher when one comes every 5 ms.
#[tokio::test(flavor = "multi_thread")]
#[ignore = "a measurement"]
async fn live_events_reach_their_watcher() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let job = server.submit("r", "PACED 2000").await;
    let mut stream = server.watch(&job, 0, v1::WatchLevel::Everything).await;
    let mut times = Vec::new();
    while let Some(message) = stream.message().await.unwrap() {
        if let Some(v1::watch_job_response::Content::Batch(batch)) = message.content {
            let now = clock();
            times.extend(batch.events.iter().map(|event| now - event.t_ns));
        }
    }
    assert_eq!(times.len(), 2000);
    times.sort_unstable();
    let at = |share: usize| times[times.len() * share / 1000] as f64 / 1e6;
    println!("live events: p50 {:.2} ms, p99 {:.2} ms, p99.9 {:.2} ms", at(500), at(990), at(999));
    server.stop().await;
}
