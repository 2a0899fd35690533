//! Outputs of the server that cannot be written, and systems that refuse to start its threads.

use std::io::BufRead as _;
use std::os::unix::process::CommandExt as _;
use std::process::{Command, Stdio};

use counterpoint_proto::v1;
use counterpoint_proto::v1::blobs_client::BlobsClient;
use counterpoint_proto::v1::jobs_client::JobsClient;
use rustix::process::{Pid, Signal, getuid, kill_process};
use tonic::transport::Channel;

use crate::support::digest;

/// A log that cannot be written ends no thread: the server runs jobs, writes its ledger and ends in order.
#[tokio::test]
async fn a_log_on_a_full_disk_or_without_a_reader_harms_nothing() {
    let folder = tempfile::tempdir().unwrap();
    for (number, closed) in [false, true].into_iter().enumerate() {
        let data = folder.path().join(number.to_string());
        let mut command = Command::new(env!("CARGO_BIN_EXE_counterpointd"));
        command.args(["--listen", "127.0.0.1:0", "--data"]).arg(&data).env("COUNTERPOINT_LOG", "debug");
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        command.stdout(Stdio::piped()).stderr(if closed { Stdio::piped() } else { full.into() });
        let mut child = command.spawn().unwrap();
        drop(child.stderr.take());
        let mut line = String::new();
        std::io::BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let url = line.trim().strip_prefix("listening on ").unwrap().to_owned();
        let channel = Channel::from_shared(url).unwrap().connect().await.unwrap();
        let (mut jobs, mut blobs) = (JobsClient::new(channel.clone()), BlobsClient::new(channel));
        let text = b"O1\nG4 X1.\nM30\n";
        let chunk = v1::UploadRequest { digest: digest(text), data: text.to_vec().into(), ..Default::default() };
        let digest = blobs.upload(tokio_stream::iter([chunk])).await.unwrap().into_inner().digest;
        for n in 0..20 {
            let request = v1::SubmitJobRequest {
                request_id: format!("{closed}-{n}"),
                machine: "fanuc-mill".into(),
                programs: vec![v1::Program { path: "main.nc".into(), ..Default::default() }],
                files: vec![v1::FileRef { path: "main.nc".into(), digest: digest.clone() }],
                ..Default::default()
            };
            let job = jobs.submit_job(request).await.unwrap().into_inner().status.unwrap().job_id;
            let wait = v1::WaitJobRequest { job_id: job, timeout_ms: 20_000 };
            let status = jobs.wait_job(wait).await.unwrap().into_inner().status.unwrap();
            assert_eq!(status.state(), v1::JobState::Succeeded);
        }
        kill_process(Pid::from_child(&child), Signal::TERM).unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(0), "it ends in order");
    }
}

/// Under a limit of processes the start ends with the reason, not with a panic or a server that hangs.
#[test]
fn a_start_with_too_few_threads_says_how_many_it_needs() {
    if !getuid().is_root() {
        println!("skipped: only root can run a command as a user that has no other processes");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    for most in [1, 2, 3, 6] {
        let mut command = Command::new("prlimit");
        command.arg(format!("--nproc={most}")).arg(env!("CARGO_BIN_EXE_counterpointd"));
        command.args(["--listen", "127.0.0.1:0", "--data"]).arg(folder.path().join("data"));
        let output = command.uid(65_533).gid(65_533).output().unwrap();
        let text = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
        assert_eq!(output.status.code(), Some(3), "{most}: {text}");
        assert!(text.contains(&format!("the system allows {} more threads", most - 1)), "{most}: {text}");
        assert!(!text.contains("panicked"), "{most}: {text}");
    }
}
