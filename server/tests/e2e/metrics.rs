//! The data of monitoring.

use counterpoint_proto::v1;
use counterpoint_server::local::disk::{Disk, DiskOperation, Faults};
use counterpoint_server::options::ServerOptions;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;

use crate::support::*;

fn seen(folder: &Path) -> ServerOptions {
    let mut options = ServerOptions { workers: 1, ..options(folder) };
    options.connections.metrics = "127.0.0.1:0".into();
    options
}

/// Status code and content.
async fn get(server: &Server, method: &str, path: &str) -> (u16, String) {
    let mut stream = TcpStream::connect(server.handle.metrics().unwrap()).await.unwrap();
    let request = format!("{method} {path} HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).await.unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).await.unwrap();
    let (head, content) = answer.split_once("\r\n\r\n").unwrap();
    (head.split(' ').nth(1).unwrap().parse().unwrap(), content.to_owned())
}

pub async fn value(server: &Server, name: &str) -> Option<f64> {
    let (_, text) = get(server, "GET", "/metrics").await;
    let line = text.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' '));
    line.map(|value| value.parse().unwrap())
}

#[tokio::test]
async fn metrics_follow_jobs_calls_and_watches() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(seen(folder.path())).await;
    let ended = server.submit("r-1", "EVENTS 50").await;
    server.wait(&ended).await;
    let running = server.submit("r-2", "EVENTS 3\nHANG").await;
    server.until(&running, v1::JobState::Running).await;
    let waiting = server.submit("r-3", "EVENTS 1").await;
    let watch = server.watch(&running, 0, v1::WatchLevel::Everything).await;
    let toml = "extends = \"fanuc-mill\"\n[ce]\nname = \"own\"\n";
    let file = v1::MachineFile { path: "own/machine.toml".into(), digest: server.upload(toml.as_bytes()).await };
    server.machines().put_machine(v1::PutMachineRequest { name: "own".into(), files: vec![file] }).await.unwrap();
    let files = ["EVENTS 50", "EVENTS 3\nHANG", "EVENTS 1", toml].map(str::len).iter().sum::<usize>() as f64;
    assert_eq!(value(&server, "counterpoint_tenant_file_bytes{tenant=\"default\"}").await, Some(files));
    assert!(value(&server, "counterpoint_tenant_machine_bytes{tenant=\"default\"}").await.unwrap() > 100.0);
    for (name, expected) in [
        ("counterpoint_jobs_accepted_total", 3.0),
        ("counterpoint_jobs_ended_total{state=\"SUCCEEDED\"}", 1.0),
        ("counterpoint_jobs_queued{tenant=\"default\",priority=\"normal\"}", 1.0),
        ("counterpoint_jobs_running", 1.0),
        ("counterpoint_tenant_running{tenant=\"default\"}", 1.0),
        ("counterpoint_calls_total{call=\"SubmitJob\",code=\"Ok\"}", 3.0),
        ("counterpoint_call_seconds_count{call=\"SubmitJob\"}", 3.0),
        ("counterpoint_watchers", 1.0),
        ("counterpoint_ledger_writable", 1.0),
    ] {
        assert_eq!(value(&server, name).await, Some(expected), "{name}");
    }
    assert!(value(&server, "counterpoint_events_total").await.unwrap() >= 53.0);
    assert!(value(&server, "counterpoint_syncs_total").await.unwrap() > 0.0);
    assert!(value(&server, "counterpoint_commit_seconds_count").await.unwrap() >= 3.0);
    assert!(value(&server, "counterpoint_free_bytes").await.unwrap() > 0.0);
    drop(watch);
    server.script.hang.store(false, Ordering::SeqCst);
    server.wait(&waiting).await;
    assert_eq!(value(&server, "counterpoint_jobs_queued{tenant=\"default\",priority=\"normal\"}").await, None);
    server.jobs().get_job(counterpoint_proto::v1::GetJobRequest { job_id: "none".into() }).await.unwrap_err();
    assert_eq!(value(&server, "counterpoint_calls_total{call=\"GetJob\",code=\"NotFound\"}").await, Some(1.0));
    server.stop().await;
}

/// A disk that can become full.
struct Full(AtomicBool);

impl Faults for Full {
    fn before(&self, _: DiskOperation, _: &Path) -> std::io::Result<usize> {
        Ok(usize::MAX)
    }

    fn free(&self) -> Option<u64> {
        self.0.load(Ordering::SeqCst).then_some(0)
    }
}

#[tokio::test]
async fn the_process_its_build_and_its_connections_are_measured() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(seen(folder.path())).await;
    server.submit("r", "EVENTS 1").await;
    assert_eq!(value(&server, "counterpoint_connections").await, Some(1.0));
    let build = format!("counterpoint_build_info{{version=\"{}\"}}", env!("CARGO_PKG_VERSION"));
    assert_eq!(value(&server, &build).await, Some(1.0));
    if cfg!(target_os = "linux") {
        assert!(value(&server, "process_resident_memory_bytes").await.unwrap() > 1e6);
        assert!(value(&server, "process_open_fds").await.unwrap() > 5.0);
    }
    server.stop().await;
}

/// Connections that ask nothing do not keep the probe of an orchestrator out, which would restart the server.
#[tokio::test]
async fn silent_connections_keep_no_probe_out() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(seen(folder.path())).await;
    let mut silent = Vec::new();
    for _ in 0..100 {
        silent.push(TcpStream::connect(server.handle.metrics().unwrap()).await.unwrap());
    }
    let answer = tokio::time::timeout(Duration::from_secs(20), get(&server, "GET", "/livez")).await;
    assert_eq!(answer.expect("before the first of them has been dropped"), (200, "ok\n".into()));
    drop(silent);
    server.stop().await;
}

#[tokio::test]
async fn a_server_is_live_and_ready_while_it_takes_jobs() {
    let folder = tempfile::tempdir().unwrap();
    let full = Arc::new(Full(AtomicBool::new(false)));
    let server = Server::start_on(seen(folder.path()), Disk::faulty(full.clone())).await;
    assert_eq!(get(&server, "GET", "/livez").await, (200, "ok\n".into()));
    assert_eq!(get(&server, "GET", "/readyz").await, (200, "ok\n".into()));
    for path in ["/livez", "/readyz", "/metrics"] {
        assert_eq!(get(&server, "HEAD", path).await, (200, String::new()), "{path}");
    }
    full.0.store(true, Ordering::SeqCst);
    assert_eq!(get(&server, "GET", "/livez").await.0, 200);
    let (status, reason) = get(&server, "GET", "/readyz").await;
    assert!(status == 503 && reason.contains("min_free_bytes"), "{status} {reason}");
    assert_eq!(get(&server, "GET", "/other").await.0, 404);
    assert_eq!(get(&server, "POST", "/metrics").await.0, 405);
    server.stop().await;
}
