//! Spans of jobs continue the trace of the client.

use std::io::Write;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use counterpoint_server::options::ServerOptions;
use tonic::Request;
use tracing_subscriber::fmt::format::FmtSpan;

use crate::support::*;

const PARENT: &str = "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01";

/// Everything that is logged.
#[derive(Clone, Default)]
struct Lines(Arc<Mutex<Vec<u8>>>);

impl Write for Lines {
    fn write(&mut self, data: &[u8]) -> std::io::Result<usize> {
        self.0.lock().unwrap().extend_from_slice(data);
        Ok(data.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl Lines {
    /// The span of a job after this many runs of it.
    async fn span(&self, job: &str, runs: usize) -> String {
        let start = format!("job{{id=\"{job}\" tenant=\"default\" attempt=1 ");
        for _ in 0..2000 {
            let text = String::from_utf8_lossy(&self.0.lock().unwrap()).into_owned();
            let closed = text.lines().filter(|line| line.contains(" close "));
            let found: Vec<&str> = closed.filter_map(|line| line.split_once(&start)?.1.split('}').next()).collect();
            if found.len() == runs {
                return found[runs - 1].to_owned();
            }
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
        panic!("{job} has not as many spans as runs");
    }
}

#[tokio::test]
async fn a_job_continues_the_trace_of_its_client_in_every_run() {
    let lines = Lines::default();
    let writer = lines.clone();
    let subscriber = tracing_subscriber::fmt().with_ansi(false).with_span_events(FmtSpan::CLOSE);
    subscriber.with_writer(move || writer.clone()).init();
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(ServerOptions { workers: 1, ..options(folder.path()) }).await;
    let mut request = Request::new(server.request("r-1", "EVENTS 3\nHANG").await);
    request.metadata_mut().insert("traceparent", PARENT.parse().unwrap());
    let job = server.jobs().submit_job(request).await.unwrap().into_inner().status.unwrap().job_id;
    server.until(&job, counterpoint_proto::v1::JobState::Running).await;
    server.stop().await;
    let first = lines.span(&job, 1).await;
    assert!(first.contains("trace=\"4bf92f3577b34da6a3ce929d0e0e4736\""), "{first}");
    assert!(first.contains("parent=\"00f067aa0ba902b7\""), "{first}");
    let server = Server::start(ServerOptions { workers: 1, ..options(folder.path()) }).await;
    server.script.hang.store(false, std::sync::atomic::Ordering::SeqCst);
    server.wait(&job).await;
    assert_eq!(lines.span(&job, 2).await, first, "a later run of another server is in the same span");
    let mut request = Request::new(server.request("r-2", "EVENTS 3").await);
    request.metadata_mut().insert("traceparent", "nonsense".parse().unwrap());
    let own = server.jobs().submit_job(request).await.unwrap().into_inner().status.unwrap().job_id;
    server.wait(&own).await;
    let span = lines.span(&own, 1).await;
    assert!(span.contains("parent=\"\"") && !span.contains("4bf92f"), "{span}");
    server.stop().await;
}
