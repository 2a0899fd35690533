//! Calls outside the contract that clients may hold open: health watches and reflection.

use std::time::{Duration, Instant};

use counterpoint_proto::v1;
use counterpoint_server::access::Role;
use tokio_stream::wrappers::ReceiverStream;
use tonic::Code;
use tonic_health::pb::HealthCheckRequest;
use tonic_health::pb::health_client::HealthClient;

use crate::guarded::*;
use crate::support::*;

/// Open health watches of one address; docs/operations.md names the number.
const MOST: usize = 32;

/// Health watches need no identity: their number is bounded, and a watch that ends makes room.
#[tokio::test]
async fn an_address_has_a_bounded_number_of_health_watches() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(guarded(folder.path())).await;
    let mut health = HealthClient::new(server.connection.clone());
    let mut open = Vec::new();
    for _ in 0..MOST {
        let mut watch = health.watch(HealthCheckRequest::default()).await.unwrap().into_inner();
        assert!(watch.message().await.unwrap().is_some());
        open.push(watch);
    }
    let refused = health.watch(HealthCheckRequest::default()).await.unwrap_err();
    assert_eq!((refused.code(), reason(&refused).as_str()), (Code::ResourceExhausted, "TOO_MANY_HEALTH_WATCHES"));
    assert!(health.check(HealthCheckRequest::default()).await.is_ok(), "a check is answered");
    open.pop();
    let begin = Instant::now();
    while health.watch(HealthCheckRequest::default()).await.is_err() {
        assert!(begin.elapsed() < Duration::from_secs(20), "the place of a watch that has ended is free");
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    server.stop().await;
}

/// The deadline of gRPC is that of the whole call, so a stream that has begun ends at it, too.
#[tokio::test]
async fn a_stream_ends_at_the_deadline_of_its_call_and_a_deadline_that_is_none_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let job_id = server.submit("r", "EVENTS 3\nHANG").await;
    let watch = || tonic::Request::new(v1::WatchJobRequest { job_id: job_id.clone(), ..Default::default() });
    let (begin, deadline) = (Instant::now(), Duration::from_millis(700));
    let mut request = watch();
    request.set_timeout(deadline);
    let mut stream = server.jobs().watch_job(request).await.unwrap().into_inner();
    let end = loop {
        match tokio::time::timeout(Duration::from_secs(20), stream.message()).await.expect("the stream ends") {
            Ok(message) => assert!(message.is_some(), "it ends with a status"),
            Err(status) => break status,
        }
    };
    assert_eq!((end.code(), reason(&end).as_str()), (Code::DeadlineExceeded, "CALL_DEADLINE"));
    assert!(begin.elapsed() >= deadline, "{:?}", begin.elapsed());
    for wrong in ["soon", "5", "-1S", "123456789S"] {
        let mut request = watch();
        request.metadata_mut().insert("grpc-timeout", wrong.parse().unwrap());
        let refused = server.jobs().watch_job(request).await.unwrap_err();
        assert_eq!((refused.code(), reason(&refused).as_str()), (Code::InvalidArgument, "INVALID_REQUEST"), "{wrong}");
    }
    server.stop().await;
}

/// Opens a stream of reflection that stays open, and returns the status of its end.
macro_rules! reflects {
    ($version:ident, $connection:expr, $bearer:expr) => {{
        use tonic_reflection::pb::$version as pb;
        let mut client = pb::server_reflection_client::ServerReflectionClient::with_interceptor($connection, $bearer);
        let message_request = Some(pb::server_reflection_request::MessageRequest::ListServices(String::new()));
        let (send, receive) = tokio::sync::mpsc::channel(1);
        send.send(pb::ServerReflectionRequest { message_request, ..Default::default() }).await.unwrap();
        let mut answers = client.server_reflection_info(ReceiverStream::new(receive)).await.unwrap().into_inner();
        assert!(answers.message().await.unwrap().is_some());
        tokio::spawn(async move {
            let ended = answers.message().await;
            drop(send);
            ended.unwrap_err()
        })
    }};
}

#[tokio::test]
async fn reflection_ends_with_the_rights_of_its_identity() {
    let folder = tempfile::tempdir().unwrap();
    let options = guarded(folder.path());
    let access = options.guard.access.clone();
    let kept = std::fs::read_to_string(&access).unwrap_or_default();
    let token = grant(&options, "r", "t", Role::Read);
    let server = Server::start(options).await;
    let known = Bearer(Some(token));
    let streams =
        [reflects!(v1, server.connection.clone(), known.clone()), reflects!(v1alpha, server.connection.clone(), known)];
    let begin = Instant::now();
    std::fs::write(&access, kept).unwrap();
    server.handle.reload();
    for stream in streams {
        let status = tokio::time::timeout(Duration::from_secs(20), stream).await.expect("it ends").unwrap();
        assert_eq!((status.code(), reason(&status).as_str()), (Code::Unauthenticated, "UNAUTHENTICATED"));
    }
    assert!(begin.elapsed() < Duration::from_secs(1), "{:?}", begin.elapsed());
    server.stop().await;
}
