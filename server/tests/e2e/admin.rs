//! Service `Admin`.

use std::sync::atomic::Ordering;
use std::time::Duration;

use counterpoint_proto::v1;
use counterpoint_server::access::Role;
use counterpoint_server::options::{Retention, ServerOptions};
use tonic::{Code, Status};

use crate::guarded::*;
use crate::support::*;

fn denied<T>(answer: Result<T, Status>) -> bool {
    answer.is_err_and(|status| status.code() == Code::PermissionDenied && reason(&status) == "PERMISSION_DENIED")
}

#[tokio::test]
async fn only_administrators_see_connections_streams_and_workers() {
    let folder = tempfile::tempdir().unwrap();
    let options = ServerOptions { workers: 1, ..guarded(folder.path()) };
    let (operator, admin) = (grant(&options, "op", "t", Role::Operate), grant(&options, "root", "it", Role::Admin));
    let server = Server::start(options).await;
    let (operator, admin) = (As::new(&server, &operator), As::new(&server, &admin));
    assert!(denied(operator.admin().list_connections(v1::ListConnectionsRequest::default()).await));
    assert!(denied(operator.admin().list_streams(v1::ListStreamsRequest {}).await));
    assert!(denied(operator.admin().list_workers(v1::ListWorkersRequest {}).await));
    assert!(denied(operator.admin().collect(v1::CollectRequest {}).await));
    assert!(denied(operator.admin().drain(v1::DrainRequest {}).await));

    let running = operator.submit("r-1", "fanuc-2path-lathe", "EVENTS 30\nHANG").await.unwrap().job_id;
    let waiting = operator.submit("r-2", "fanuc-2path-lathe", "EVENTS 1").await.unwrap().job_id;
    let level = v1::WatchLevel::Everything.into();
    let request = v1::WatchJobRequest { job_id: running.clone(), level, ..Default::default() };
    let mut watch = operator.jobs().watch_job(request).await.unwrap().into_inner();
    let mut seen = 0;
    while seen < 30 {
        if let Some(v1::watch_job_response::Content::Batch(batch)) = watch.message().await.unwrap().unwrap().content {
            seen = batch.last_seq;
        }
    }
    let workers = admin.admin().list_workers(v1::ListWorkersRequest {}).await.unwrap().into_inner();
    assert_eq!((workers.slots, workers.queued, workers.workers.len()), (1, 1, 1));
    let worker = &workers.workers[0];
    assert_eq!((worker.job_id.as_str(), worker.tenant.as_str(), worker.events), (running.as_str(), "t", 30));
    assert_eq!((worker.machine.as_str(), worker.attempt), ("fanuc-2path-lathe", 1));
    let streams = admin.admin().list_streams(v1::ListStreamsRequest {}).await.unwrap().into_inner().streams;
    assert_eq!(streams.len(), 1, "{streams:?}");
    assert_eq!((streams[0].job_id.as_str(), streams[0].position, streams[0].behind), (running.as_str(), 30, 0));
    let listed = admin.admin().list_connections(v1::ListConnectionsRequest::default()).await.unwrap().into_inner();
    let [connection] = &listed.connections[..] else { panic!("{listed:?}") };
    assert_eq!((connection.identity.as_str(), connection.tenant.as_str()), ("root", "it"), "who called last");
    assert!(connection.peer.starts_with("127.0.0.1:") && connection.since_ms > 0 && connection.calls >= 8);
    assert_eq!(connection.open_calls, 2, "the watch and this call");
    drop(watch);
    server.script.hang.store(false, Ordering::SeqCst);
    operator.wait(&waiting).await;
    server.stop().await;
}

#[tokio::test]
async fn an_administrator_collects_and_drains() {
    let folder = tempfile::tempdir().unwrap();
    let retention = Retention { blob_grace_s: 0, ..Retention::default() };
    let options = ServerOptions { retention, workers: 1, ..options(folder.path()) };
    let mut server = Server::start(options).await;
    let admin = As::nobody(&server);
    let ended = server.submit("r-1", "EVENTS 2").await;
    server.wait(&ended).await;
    admin.jobs().delete_job(v1::DeleteJobRequest { job_id: ended }).await.unwrap();
    // The server may have been faster.
    let collected = admin.admin().collect(v1::CollectRequest {}).await.unwrap().into_inner();
    assert!(collected.blobs <= 1 && collected.jobs == 0, "{collected:?}");
    let digests = vec![digest(b"EVENTS 2")];
    let missing = server.blobs().find_missing(v1::FindMissingRequest { digests: digests.clone() }).await.unwrap();
    assert_eq!(missing.into_inner().digests, digests, "nothing needs it any more");
    let running = server.submit("r-2", "HANG").await;
    server.until(&running, v1::JobState::Running).await;
    let drained = admin.admin().drain(v1::DrainRequest {}).await.unwrap().into_inner();
    assert_eq!((drained.running, drained.grace_s), (1, 0));
    tokio::time::timeout(Duration::from_secs(10), &mut server.task).await.expect("the server stops").unwrap();
}
