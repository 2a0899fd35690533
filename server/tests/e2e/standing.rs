//! Jobs and calls that use no processor time take no turn from others.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use counterpoint_proto::v1;
use http::uri::PathAndQuery;
use tonic::{Code, Request};

use crate::guarded::*;
use crate::limited::{Blocked, two_on};
use crate::metrics::value;
use crate::share::server_until;
use crate::support::*;

/// Calls in one flood; an identity has four in hand in any case.
const FLOOD: usize = 24;

pub const MACHINE: &str = "fanuc-2path-lathe";

/// Submits at once, none of which becomes durable before all have come; returns how many waited for others of their
/// identity.
async fn flood(server: &Server, noisy: &As, disk: &Blocked, round: usize) -> usize {
    let deferred = async || value(server, "counterpoint_calls_deferred_total").await.unwrap();
    let before = deferred().await;
    disk.0.store(true, Ordering::SeqCst);
    let mut calls = tokio::task::JoinSet::new();
    for number in 0..FLOOD {
        let noisy = noisy.clone();
        let request = request_of(&format!("{round}-{number}"), MACHINE, "EVENTS 1");
        calls.spawn(async move { noisy.jobs().submit_job(request).await.map(drop) });
    }
    // Each look is a call over the same loopback, so a slow computer gives the calls more time.
    for _ in 0..100 {
        if deferred().await > before {
            break;
        }
        tokio::time::sleep(Duration::from_millis(1)).await;
    }
    disk.0.store(false, Ordering::SeqCst);
    assert!(calls.join_all().await.iter().all(Result::is_ok));
    (deferred().await - before) as usize
}

/// Floods until one has all its calls in hand: the last calls of the other identity count for a while.
async fn passes(server: &Server, noisy: &As, disk: &Blocked, what: &str) {
    let passes = async {
        let mut round = 0;
        while flood(server, noisy, disk, round).await > 0 {
            round += 1;
        }
    };
    tokio::time::timeout(Duration::from_secs(20), passes).await.unwrap_or_else(|_| panic!("{what} takes turns"));
}

/// A way to do nothing on a server.
#[derive(Debug, Clone, Copy)]
pub enum Idle {
    SteppedJob,
    WatchedPausedJob,
    RequestWithoutBody,
}

/// Makes an identity idle in this way; returns its job, and the task that holds its call.
pub async fn be_idle(quiet: &As, idle: Idle, name: &str) -> (Option<String>, Option<tokio::task::JoinHandle<()>>) {
    match idle {
        Idle::SteppedJob => {
            let options = v1::JobOptions { stepped: true, ..Default::default() };
            let job = quiet.submit_with(name, MACHINE, "EVENTS 3\nSTEP a", Some(options)).await.unwrap().job_id;
            server_until(quiet, &job, v1::JobState::Running).await;
            (Some(job), None)
        }
        Idle::WatchedPausedJob => {
            let job = quiet.submit(name, MACHINE, "EVENTS 3\nHANG").await.unwrap().job_id;
            quiet.jobs().pause_job(v1::PauseJobRequest { job_id: job.clone() }).await.unwrap();
            server_until(quiet, &job, v1::JobState::Queued).await;
            let watch = v1::WatchJobRequest { job_id: job.clone(), heartbeat_ms: 100, ..Default::default() };
            let mut watch = quiet.jobs().watch_job(watch).await.unwrap().into_inner();
            let reads = async move { while watch.message().await.is_ok_and(|message| message.is_some()) {} };
            (Some(job), Some(tokio::spawn(reads)))
        }
        Idle::RequestWithoutBody => {
            let mut raw = tonic::client::Grpc::new(quiet.connection.clone());
            raw.ready().await.unwrap();
            let mut request = Request::new(tokio_stream::pending::<v1::GetJobRequest>());
            let bearer = format!("Bearer {}", quiet.bearer.0.clone().unwrap());
            request.metadata_mut().insert("authorization", bearer.parse().unwrap());
            let call = async move {
                let codec = tonic_prost::ProstCodec::<v1::GetJobRequest, v1::GetJobResponse>::default();
                let path = PathAndQuery::from_static("/counterpoint.v1.Jobs/GetJob");
                let _ = raw.client_streaming(request, path, codec).await;
            };
            (None, Some(tokio::spawn(call)))
        }
    }
}

async fn start(folder: &std::path::Path) -> (Server, As, As, Arc<Blocked>) {
    let disk = Arc::new(Blocked::default());
    let (server, noisy, quiet) = two_on(folder, 0, counterpoint_server::local::disk::Disk::faulty(disk.clone())).await;
    noisy.upload(b"EVENTS 1").await.unwrap();
    (server, noisy, quiet, disk)
}

#[tokio::test(flavor = "multi_thread")]
async fn a_stepped_job_that_stands_takes_no_turn() {
    let folder = tempfile::tempdir().unwrap();
    let (server, noisy, quiet, disk) = start(folder.path()).await;
    let (job, _) = be_idle(&quiet, Idle::SteppedJob, "steps").await;
    passes(&server, &noisy, &disk, "a job that stands").await;
    quiet.jobs().cancel_job(v1::CancelJobRequest { job_id: job.unwrap() }).await.unwrap();
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_that_works_takes_turns() {
    let folder = tempfile::tempdir().unwrap();
    let (server, noisy, quiet, disk) = start(folder.path()).await;
    let job = quiet.submit("works", MACHINE, "HANG").await.unwrap().job_id;
    server_until(&quiet, &job, v1::JobState::Running).await;
    for round in 0..3 {
        assert!(flood(&server, &noisy, &disk, round).await > 0, "round {round}");
    }
    server.script.hang.store(false, Ordering::SeqCst);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_watch_and_a_wait_of_a_paused_job_take_no_turn() {
    let folder = tempfile::tempdir().unwrap();
    let (server, noisy, quiet, disk) = start(folder.path()).await;
    let (job, reads) = be_idle(&quiet, Idle::WatchedPausedJob, "paused").await;
    let (job, reads) = (job.unwrap(), reads.unwrap());
    let wait = v1::WaitJobRequest { job_id: job.clone(), timeout_ms: 60_000 };
    let waiting = quiet.clone();
    let waits = tokio::spawn(async move { waiting.jobs().wait_job(wait).await.map(drop) });
    passes(&server, &noisy, &disk, "a watch").await;
    assert!(!reads.is_finished() && !waits.is_finished());
    quiet.jobs().cancel_job(v1::CancelJobRequest { job_id: job }).await.unwrap();
    waits.await.unwrap().unwrap();
    reads.await.unwrap();
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_call_whose_request_does_not_come_takes_no_turn() {
    let folder = tempfile::tempdir().unwrap();
    let (server, noisy, quiet, disk) = start(folder.path()).await;
    quiet.list().await;
    let (_, call) = be_idle(&quiet, Idle::RequestWithoutBody, "").await;
    let call = call.unwrap();
    passes(&server, &noisy, &disk, "a request that does not come").await;
    assert!(!call.is_finished());
    call.abort();
    server.stop().await;
}

#[tokio::test]
async fn a_call_whose_request_stalls_is_ended() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = options(folder.path());
    options.connections.upload_stall_s = 1;
    let server = Server::start(options).await;
    let mut raw = tonic::client::Grpc::new(server.connection.clone());
    for path in ["/counterpoint.v1.Jobs/SubmitJob", "/counterpoint.v1.Jobs/WatchJob", "/counterpoint.v1.Jobs/WaitJob"] {
        raw.ready().await.unwrap();
        let codec = tonic_prost::ProstCodec::<v1::GetJobRequest, v1::GetJobResponse>::default();
        let request = Request::new(tokio_stream::pending::<v1::GetJobRequest>());
        let refused = raw.client_streaming(request, PathAndQuery::from_static(path), codec).await.unwrap_err();
        assert_eq!((refused.code(), reason(&refused).as_str()), (Code::DeadlineExceeded, "CALL_STALLED"), "{path}");
    }
    server.stop().await;
}
