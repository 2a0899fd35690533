//! A server whose descriptors have run out, as a process of its own.

use std::io::{BufRead as _, BufReader};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use counterpoint_proto::v1;
use counterpoint_proto::v1::jobs_client::JobsClient;
use rustix::process::{Pid, Resource, Rlimit, prlimit};
use tokio::net::TcpStream;
use tonic::transport::Endpoint;

pub struct Process {
    pub child: Child,
    pub address: String,
    log: std::path::PathBuf,
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Process {
    pub fn start(folder: &std::path::Path) -> Self {
        Self::start_with(folder, &["--preface-s", "600"])
    }

    /// Starts one with options.
    pub fn start_with(folder: &std::path::Path, options: &[&str]) -> Self {
        let log = folder.join("stderr");
        let mut child = Command::new(env!("CARGO_BIN_EXE_counterpointd"))
            .args(["--listen", "127.0.0.1:0", "--data"])
            .arg(folder.join("data"))
            .args(options)
            .env_remove("COUNTERPOINT_LOG")
            .stdout(Stdio::piped())
            .stderr(std::fs::File::create(&log).unwrap())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let address = line.trim().rsplit_once("://").expect("the address is printed").1.to_owned();
        Self { child, address, log }
    }

    /// Lines of the log with a text.
    fn lines(&self, with: &str) -> Vec<String> {
        let log = std::fs::read_to_string(&self.log).unwrap();
        log.lines().filter(|line| line.contains(with)).map(str::to_owned).collect()
    }

    pub async fn until(&self, with: &str) -> String {
        for _ in 0..2000 {
            if let Some(line) = self.lines(with).pop() {
                return line;
            }
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
        panic!("the server never said '{with}'");
    }

    /// Lets the process have this many descriptors beyond those that it has; returns the limit before.
    fn limit(&self, spare: u64) -> Rlimit {
        let open = std::fs::read_dir(format!("/proc/{}/fd", self.child.id())).unwrap().count() as u64;
        let pid = Pid::from_raw(i32::try_from(self.child.id()).unwrap());
        let limit =
            Rlimit { current: Some(open + spare), maximum: rustix::process::getrlimit(Resource::Nofile).maximum };
        prlimit(pid, Resource::Nofile, limit).unwrap()
    }

    fn raise(&self, limit: Rlimit) {
        prlimit(Pid::from_raw(i32::try_from(self.child.id()).unwrap()), Resource::Nofile, limit).unwrap();
    }
}

#[tokio::test]
async fn without_descriptors_the_accept_loop_waits_and_accepts_again_when_there_are_some() {
    let folder = tempfile::tempdir().unwrap();
    let server = Process::start(folder.path());
    let endpoint = Endpoint::from_shared(format!("http://{}", server.address)).unwrap();
    let mut client = JobsClient::new(endpoint.connect().await.unwrap());
    client.list_jobs(v1::ListJobsRequest::default()).await.unwrap();
    let before = server.limit(2);
    let begin = Instant::now();
    let mut silent = Vec::new();
    for _ in 0..8 {
        silent.push(TcpStream::connect(&server.address).await.unwrap());
    }
    server.until("no connection can be accepted").await;
    for _ in 0..10 {
        client.list_jobs(v1::ListJobsRequest::default()).await.expect("clients that are connected are served");
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    drop(silent);
    server.raise(before);
    let mut late = JobsClient::new(endpoint.connect().await.expect("a new client is accepted again"));
    late.list_jobs(v1::ListJobsRequest::default()).await.unwrap();
    let line = server.until("connections are accepted again").await;
    let most = begin.elapsed().as_millis() / 100 + 2;
    let failed = line.rsplit_once("failed=").expect("the number of accepts that failed").1;
    let failed: u128 = failed.trim().parse().unwrap();
    assert!((1..=most).contains(&failed), "{failed} accepts failed where {most} could be tried with pauses");
    assert_eq!(server.lines("no connection can be accepted").len(), 1, "it is reported once");
}
