//! Spans of jobs at a collector of traces.

#[cfg(feature = "otlp")]
use collector::*;
use counterpoint_server::options::ServerOptions;

use crate::support::*;

fn traced(folder: &std::path::Path, endpoint: &str) -> ServerOptions {
    let mut options = options(folder);
    options.connections.otlp = endpoint.into();
    options
}

#[cfg(not(feature = "otlp"))]
#[tokio::test]
async fn a_server_that_cannot_send_spans_does_not_start_when_it_is_to() {
    let folder = tempfile::tempdir().unwrap();
    let options = traced(folder.path(), "http://127.0.0.1:4317");
    match counterpoint_server::service::build_with(options, Script::default()).await {
        Ok(_) => panic!("the server must not start"),
        Err(error) => assert!(error.to_string().contains("--features otlp"), "{error}"),
    }
}

#[cfg(feature = "otlp")]
mod collector {
    pub use std::sync::{Arc, Mutex};
    pub use std::time::Duration;

    pub use counterpoint_proto::v1;
    use opentelemetry_proto::tonic::collector::trace::v1::trace_service_server::{TraceService, TraceServiceServer};
    use opentelemetry_proto::tonic::collector::trace::v1::{ExportTraceServiceRequest, ExportTraceServiceResponse};
    pub use opentelemetry_proto::tonic::common::v1::any_value::Value;
    pub use opentelemetry_proto::tonic::trace::v1::Span;
    pub use opentelemetry_proto::tonic::trace::v1::status::StatusCode;
    use tokio_stream::wrappers::TcpListenerStream;
    use tonic::{Request, Response, Status};

    /// A collector, and all that it was sent.
    #[derive(Clone, Default)]
    pub struct Collector(pub Arc<Mutex<Vec<ExportTraceServiceRequest>>>);

    #[tonic::async_trait]
    impl TraceService for Collector {
        async fn export(
            &self,
            request: Request<ExportTraceServiceRequest>,
        ) -> Result<Response<ExportTraceServiceResponse>, Status> {
            self.0.lock().unwrap().push(request.into_inner());
            Ok(Response::new(ExportTraceServiceResponse::default()))
        }
    }

    impl Collector {
        /// Serves; returns the address.
        pub async fn serve(&self) -> String {
            let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
            let address = listener.local_addr().unwrap();
            let service = TraceServiceServer::new(self.clone());
            let server = tonic::transport::Server::builder().add_service(service);
            tokio::spawn(server.serve_with_incoming(TcpListenerStream::new(listener)));
            format!("http://{address}")
        }

        /// All spans, with the name of the service that sent them.
        pub fn spans(&self) -> Vec<(String, Span)> {
            let mut all = Vec::new();
            for resource in self.0.lock().unwrap().iter().flat_map(|request| &request.resource_spans) {
                let attributes = &resource.resource.as_ref().unwrap().attributes;
                let service = attributes.iter().find(|one| one.key == "service.name").unwrap();
                let Some(Value::StringValue(service)) = service.value.clone().unwrap().value else { panic!("a text") };
                let spans = resource.scope_spans.iter().flat_map(|scope| scope.spans.clone());
                all.extend(spans.map(|span| (service.clone(), span)));
            }
            all
        }
    }

    /// The text of an attribute.
    pub fn text(span: &Span, key: &str) -> String {
        let value = span.attributes.iter().find(|one| one.key == key).and_then(|one| one.value.clone()?.value);
        match value {
            Some(Value::StringValue(text)) => text,
            Some(Value::IntValue(number)) => number.to_string(),
            other => panic!("{key}: {other:?}"),
        }
    }

    pub fn hex(bytes: &[u8]) -> String {
        bytes.iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

#[cfg(feature = "otlp")]
#[tokio::test]
async fn a_job_has_a_span_in_the_trace_of_its_client() {
    const TRACE: &str = "4bf92f3577b34da6a3ce929d0e0e4736";
    const SPAN: &str = "00f067aa0ba902b7";
    let (folder, collector) = (tempfile::tempdir().unwrap(), Collector::default());
    let server = Server::start(traced(folder.path(), &collector.serve().await)).await;
    let submit = async |name: &str, script: &str, traceparent: String| {
        let mut request = tonic::Request::new(server.request(name, script).await);
        request.metadata_mut().insert("traceparent", traceparent.parse().unwrap());
        let job = server.jobs().submit_job(request).await.unwrap().into_inner().status.unwrap().job_id;
        server.wait(&job).await;
        job
    };
    let first = submit("first", "EVENTS 7", format!("00-{TRACE}-{SPAN}-01")).await;
    submit("unrecorded", "EVENTS 7", format!("00-{TRACE}-{SPAN}-00")).await;
    let second = submit("second", "REFUSE", "none".into()).await;
    let cancelled = server.submit("cancelled", "HANG").await;
    server.until(&cancelled, v1::JobState::Running).await;
    server.jobs().cancel_job(v1::CancelJobRequest { job_id: cancelled.clone() }).await.unwrap();
    server.wait(&cancelled).await;
    server.stop().await;
    // Spans that had not been sent were sent at the end.
    let spans = collector.spans();
    assert!(spans.iter().all(|(service, _)| service == "counterpointd"));
    let spans: Vec<Span> = spans.into_iter().map(|(_, span)| span).collect();
    let job = |id: &str| {
        let found: Vec<_> =
            spans.iter().filter(|span| span.name == "job" && text(span, "counterpoint.job") == id).collect();
        assert_eq!(found.len(), 1, "{id}");
        found[0].clone()
    };
    assert_eq!(
        spans.iter().filter(|span| span.name == "job").count(),
        3,
        "what its client does not record is not sent"
    );
    let span = job(&first);
    assert_eq!((hex(&span.trace_id).as_str(), hex(&span.parent_span_id).as_str()), (TRACE, SPAN));
    assert_eq!(
        (text(&span, "counterpoint.state").as_str(), text(&span, "counterpoint.events").as_str()),
        ("SUCCEEDED", "7")
    );
    assert_eq!(span.status.clone().unwrap().code(), StatusCode::Ok);
    assert!(span.start_time_unix_nano > 0 && span.end_time_unix_nano >= span.start_time_unix_nano);
    let run = spans.iter().find(|run| run.parent_span_id == span.span_id).unwrap();
    assert_eq!((run.name.as_str(), &run.trace_id), ("run", &span.trace_id));
    assert!(run.start_time_unix_nano >= span.start_time_unix_nano);
    let failed = job(&second);
    assert!(failed.parent_span_id.is_empty() && hex(&failed.trace_id) != TRACE, "it begins a trace of its own");
    let status = failed.status.clone().unwrap();
    assert_eq!(status.code(), StatusCode::Error);
    assert!(status.message.contains("refused"), "{}", status.message);
    assert_eq!(text(&job(&cancelled), "counterpoint.state"), "CANCELLED");
}

#[cfg(feature = "otlp")]
#[tokio::test]
async fn a_collector_that_is_gone_or_takes_nothing_holds_no_job_and_no_stop() {
    // One collector does not listen, the other never answers.
    let silent = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
    let gone = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap().local_addr().unwrap();
    for address in [gone, silent.local_addr().unwrap()] {
        let folder = tempfile::tempdir().unwrap();
        let server = Server::start(traced(folder.path(), &format!("http://{address}"))).await;
        for number in 0..20 {
            let job = server.submit(&format!("r-{number}"), "EVENTS 3").await;
            assert_eq!(server.wait(&job).await.state(), v1::JobState::Succeeded);
        }
        tokio::time::timeout(Duration::from_secs(10), server.stop()).await.unwrap();
    }
}
