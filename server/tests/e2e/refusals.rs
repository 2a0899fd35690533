//! Refusals of the transport: they carry the details that all refusals have.

use counterpoint_proto::v1;
use counterpoint_server::options::{Maxima, ServerOptions};
use tonic::codegen::http::uri::PathAndQuery;
use tonic::{Code, Request};
use tonic_health::pb::HealthCheckRequest;
use tonic_health::pb::health_client::HealthClient;

use crate::guarded::*;
use crate::support::*;

#[tokio::test]
async fn every_status_says_its_reason_also_those_of_the_transport() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let digests = vec!["x".repeat(64); 80_000];
    let refused = server.blobs().find_missing(v1::FindMissingRequest { digests }).await.unwrap_err();
    assert_eq!((refused.code(), reason(&refused).as_str()), (Code::ResourceExhausted, "MESSAGE_TOO_LARGE"));
    assert!(refused.message().contains("4194304"), "{refused}");
    let chunk = v1::UploadRequest { data: vec![0; 5 << 20].into(), ..Default::default() };
    let refused = server.blobs().upload(tokio_stream::iter([chunk])).await.unwrap_err();
    assert_eq!((refused.code(), reason(&refused).as_str()), (Code::ResourceExhausted, "MESSAGE_TOO_LARGE"));

    let attended = v1::SubmitJobRequest {
        options: Some(v1::JobOptions { attended: true, ..Default::default() }),
        ..server.request("attended", "HANG").await
    };
    let job = server.jobs().submit_job(attended).await.unwrap().into_inner().status.unwrap().job_id;
    let said = |content| v1::AttendRequest { content: Some(content) };
    let large = v1::DialogAnswer { dialog: "x".repeat(5 << 20), ..Default::default() };
    let large = v1::QuestionAnswer { question_id: 1, answer: Some(large) };
    let messages = [said(v1::attend_request::Content::JobId(job)), said(v1::attend_request::Content::Answer(large))];
    let mut stream = server.operator().attend(tokio_stream::iter(messages)).await.unwrap().into_inner();
    let refused = loop {
        match stream.message().await {
            Ok(message) => assert!(message.is_some(), "the stream must not end as if all were well"),
            Err(status) => break status,
        }
    };
    assert_eq!((refused.code(), reason(&refused).as_str()), (Code::ResourceExhausted, "MESSAGE_TOO_LARGE"));

    let mut raw = tonic::client::Grpc::new(server.connection.clone());
    let mut call = async |path: &'static str| {
        raw.ready().await.unwrap();
        let codec = tonic_prost::ProstCodec::<v1::UploadRequest, v1::GetJobResponse>::default();
        // Read as a GetJobRequest, its bytes are not text.
        let request = v1::UploadRequest { digest: String::new(), data: vec![0xff].into(), size: None };
        raw.unary(Request::new(request), PathAndQuery::from_static(path), codec).await.unwrap_err()
    };
    for path in ["/counterpoint.v1.Jobs/NoSuchCall", "/no.such.Service/Call"] {
        let refused = call(path).await;
        assert_eq!((refused.code(), reason(&refused).as_str()), (Code::Unimplemented, "UNKNOWN_CALL"), "{path}");
    }
    let refused = call("/counterpoint.v1.Results/GetFile").await;
    assert_eq!((refused.code(), reason(&refused).as_str()), (Code::InvalidArgument, "MALFORMED_MESSAGE"));

    let check = HealthCheckRequest { service: "no.such.Service".into() };
    let refused = HealthClient::new(server.connection.clone()).check(check).await.unwrap_err();
    assert_eq!((refused.code(), reason(&refused).as_str()), (Code::NotFound, "UNKNOWN_SERVICE"));
    server.stop().await;
}

/// Callers without an identity may check the health of the server, so these messages do not count in the memory budget.
#[tokio::test]
async fn a_health_check_is_small_and_takes_nothing_of_the_memory_budget() {
    let folder = tempfile::tempdir().unwrap();
    let options =
        ServerOptions { maxima: Maxima { memory_bytes: 100_000, ..Maxima::default() }, ..guarded(folder.path()) };
    let server = Server::start(options).await;
    let check = async |length: usize| {
        let check = HealthCheckRequest { service: "x".repeat(length) };
        reason(&HealthClient::new(server.connection.clone()).check(check).await.unwrap_err())
    };
    assert_eq!(check(4000).await, "UNKNOWN_SERVICE");
    for length in [5000, 1 << 20, 5 << 20] {
        assert_eq!(check(length).await, "MESSAGE_TOO_LARGE", "{length}");
    }
    server.stop().await;
}

/// A name of a megabyte is refused like any other; the connection and other calls on it continue.
#[tokio::test]
async fn a_very_long_name_is_refused_and_harms_no_other_call() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let long = "x".repeat(1 << 20);
    let job = v1::GetJobRequest { job_id: long.clone() };
    assert_eq!(reason(&server.jobs().get_job(job).await.unwrap_err()), "INVALID_REQUEST");
    let request = v1::SubmitJobRequest { machine: long.clone(), ..server.request("r", "EVENTS 1").await };
    assert_eq!(reason(&server.jobs().submit_job(request).await.unwrap_err()), "INVALID_REQUEST");
    let request =
        v1::SubmitJobRequest { labels: [(long, String::new())].into(), ..server.request("r", "EVENTS 1").await };
    assert_eq!(reason(&server.jobs().submit_job(request).await.unwrap_err()), "INVALID_REQUEST");
    let job = server.submit("r", "EVENTS 1").await;
    assert_eq!(server.wait(&job).await.events, 1);
    server.stop().await;
}
