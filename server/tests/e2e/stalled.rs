//! Memory of stalled watchers, in a server in a separate process.

use std::fmt::Write as _;
use std::time::Duration;

use counterpoint_proto::v1;
use counterpoint_proto::v1::blobs_client::BlobsClient;
use counterpoint_proto::v1::jobs_client::JobsClient;
use counterpoint_proto::v1::watch_job_response::Content;
use tonic::Streaming;
use tonic::transport::{Channel, Endpoint};

use crate::descriptors::Process;
use crate::killed::resident;
use crate::support::digest;

const WATCHERS: u64 = 128;
/// Bytes that one of them may hold.
const MOST: u64 = 128 * 1024;
const BLOCKS: usize = 20_000;

/// A connection whose client takes little before it reads.
async fn connect(server: &Process) -> Channel {
    let endpoint = Endpoint::from_shared(format!("http://{}", server.address)).unwrap();
    let endpoint = endpoint.initial_stream_window_size(65_535).initial_connection_window_size(16 << 20);
    endpoint.connect().await.unwrap()
}

async fn watch(channel: &Channel, job: &str) -> Streaming<v1::WatchJobResponse> {
    let level = v1::WatchLevel::Everything.into();
    let request = v1::WatchJobRequest { job_id: job.into(), level, ..Default::default() };
    JobsClient::new(channel.clone()).watch_job(request).await.unwrap().into_inner()
}

/// A job with a log of some megabytes that has ended.
async fn job(channel: &Channel) -> String {
    let mut program = String::from("%\nO1\nG21 G17 G90 G94 G54\nT1 M6\nS1000 M3\nG0 X0 Y0 Z5\n");
    for n in 0..BLOCKS {
        writeln!(program, "G1 X{} Y{}.{:03} F500", n % 97, n % 89, n % 1000).unwrap();
    }
    program.push_str("M30\n%\n");
    let name = digest(program.as_bytes());
    let first = v1::UploadRequest { digest: name.clone(), ..Default::default() };
    let chunks: Vec<_> = program
        .as_bytes()
        .chunks(60_000)
        .map(|data| v1::UploadRequest { data: data.to_vec().into(), ..Default::default() })
        .collect();
    let upload = std::iter::once(first).chain(chunks);
    BlobsClient::new(channel.clone()).upload(tokio_stream::iter(upload.collect::<Vec<_>>())).await.unwrap();
    let request = v1::SubmitJobRequest {
        request_id: "stalled".into(),
        machine: "fanuc-mill".into(),
        programs: vec![v1::Program { path: "main.nc".into(), ..Default::default() }],
        files: vec![v1::FileRef { path: "main.nc".into(), digest: name }],
        ..Default::default()
    };
    let mut jobs = JobsClient::new(channel.clone());
    let job = jobs.submit_job(request).await.unwrap().into_inner().status.unwrap().job_id;
    let wait = v1::WaitJobRequest { job_id: job.clone(), timeout_ms: 60_000 };
    let status = jobs.wait_job(wait).await.unwrap().into_inner().status.unwrap();
    assert!(status.ended_ms > 0 && status.events > BLOCKS as u64, "{status:?}");
    job
}

/// Reads a watch to its end; returns the number of the last event.
async fn last(mut stream: Streaming<v1::WatchJobResponse>) -> u64 {
    let mut last = 0;
    while let Some(message) = stream.message().await.unwrap() {
        if let Some(Content::Batch(batch)) = message.content {
            last = batch.last_seq;
        }
    }
    last
}

#[tokio::test(flavor = "multi_thread")]
async fn a_watcher_that_stands_still_holds_little_on_a_shared_connection() {
    stand_still(false).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_watcher_that_stands_still_holds_little_on_a_connection_of_its_own() {
    stand_still(true).await;
}

async fn stand_still(own: bool) {
    let folder = tempfile::tempdir().unwrap();
    let server = Process::start(folder.path());
    let channel = connect(&server).await;
    let job = job(&channel).await;
    let whole = last(watch(&channel, &job).await).await;
    let before = resident(server.child.id());
    let mut still = Vec::new();
    for _ in 0..WATCHERS {
        let channel = if own { connect(&server).await } else { channel.clone() };
        let mut stream = watch(&channel, &job).await;
        // It has begun.
        stream.message().await.unwrap().unwrap();
        still.push((channel, stream));
    }
    // Batches read ahead for them are dropped when they are found to have stopped reading; a second of samples shows
    // that this stays so.
    let (mut each, mut calm) = (u64::MAX, 0);
    for _ in 0..400 {
        each = resident(server.child.id()).saturating_sub(before) / WATCHERS;
        calm = if each <= MOST { calm + 1 } else { 0 };
        if calm == 20 {
            break;
        }
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    println!("own connections {own}: {} kB for each watcher that stands still", each / 1024);
    assert!(calm == 20, "{each} bytes for each watcher that stands still, own connections: {own}");
    assert_eq!(last(watch(&channel, &job).await).await, whole, "another one gets everything");
    let (_, stream) = still.pop().unwrap();
    assert_eq!(last(stream).await, whole, "so does one that continues");
}
