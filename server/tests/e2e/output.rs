//! The log of the server, outputs that cannot be written, and systems that refuse to start its threads.

use std::fs::File;
use std::io::{BufRead as _, BufReader};
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use counterpoint_proto::v1;
use counterpoint_proto::v1::blobs_client::BlobsClient;
use counterpoint_proto::v1::jobs_client::JobsClient;
use rustix::process::{Pid, Signal, getuid, kill_process};
use serde_json::Value;
use tonic::transport::Channel;

use crate::support::digest;

/// A server with all lines in its log.
fn server(data: &Path, format: &str, log: Stdio) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_counterpointd"));
    command.args(["--listen", "127.0.0.1:0", "--log-format", format, "--data"]).arg(data);
    command.env("COUNTERPOINT_LOG", "debug").stdout(Stdio::piped()).stderr(log).spawn().unwrap()
}

/// Runs jobs on a server that has just been started; their ids.
async fn run_jobs(child: &mut Child, jobs: usize) -> Vec<String> {
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    let url = line.trim().strip_prefix("listening on ").unwrap().to_owned();
    let channel = Channel::from_shared(url).unwrap().connect().await.unwrap();
    let (mut client, mut blobs) = (JobsClient::new(channel.clone()), BlobsClient::new(channel));
    let text = b"O1\nG4 X1.\nM30\n";
    let chunk = v1::UploadRequest { digest: digest(text), data: text.to_vec().into(), ..Default::default() };
    let digest = blobs.upload(tokio_stream::iter([chunk])).await.unwrap().into_inner().digest;
    let mut ids = Vec::new();
    for n in 0..jobs {
        let request = v1::SubmitJobRequest {
            request_id: format!("job-{n}"),
            machine: "fanuc-mill".into(),
            programs: vec![v1::Program { path: "main.nc".into(), ..Default::default() }],
            files: vec![v1::FileRef { path: "main.nc".into(), digest: digest.clone() }],
            ..Default::default()
        };
        let job = client.submit_job(request).await.unwrap().into_inner().status.unwrap().job_id;
        let wait = v1::WaitJobRequest { job_id: job.clone(), timeout_ms: 20_000 };
        let status = client.wait_job(wait).await.unwrap().into_inner().status.unwrap();
        assert_eq!(status.state(), v1::JobState::Succeeded);
        ids.push(job);
    }
    ids
}

/// Ends a server by a signal.
fn stop(child: &mut Child) {
    kill_process(Pid::from_child(child), Signal::TERM).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(0), "it ends in order");
}

/// A log that cannot be written ends no thread: the server runs jobs, writes its ledger and ends in order.
#[tokio::test]
async fn a_log_on_a_full_disk_or_without_a_reader_harms_nothing() {
    let folder = tempfile::tempdir().unwrap();
    for (format, closed) in [("text", false), ("text", true), ("json", false), ("json", true)] {
        let full = File::options().write(true).open("/dev/full").unwrap();
        let log = if closed { Stdio::piped() } else { full.into() };
        let mut child = server(&folder.path().join(format!("{format}-{closed}")), format, log);
        drop(child.stderr.take());
        run_jobs(&mut child, 20).await;
        stop(&mut child);
    }
}

/// The lines of a log in JSON.
fn objects(log: &Path) -> Vec<Value> {
    let text = std::fs::read_to_string(log).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {line}"))).collect()
}

#[tokio::test]
async fn a_log_in_json_has_one_object_a_line_with_the_fields_and_spans_of_the_text() {
    let folder = tempfile::tempdir().unwrap();
    let (data, log) = (folder.path().join("data"), folder.path().join("log"));
    let mut child = server(&data, "json", File::create(&log).unwrap().into());
    let ids = run_jobs(&mut child, 2).await;

    let second = folder.path().join("second");
    let mut refused = server(&data, "json", File::create(&second).unwrap().into());
    assert_eq!(refused.wait().unwrap().code(), Some(3));
    let reason = objects(&second).pop().unwrap();
    assert_eq!((&reason["level"], &reason["fields"]["message"]), (&"ERROR".into(), &"the server ends".into()));
    assert!(reason["fields"]["reason"].as_str().unwrap().contains(&child.id().to_string()), "{reason}");

    stop(&mut child);
    let lines = objects(&log);
    assert!(lines.iter().any(|line| line["spans"].is_array()), "the log has spans");
    for line in &lines {
        assert!(line["timestamp"].is_string() && line["level"].is_string() && line["target"].is_string(), "{line}");
        assert!(line["fields"]["message"].is_string(), "{line}");
        let spans = line["spans"].as_array().map(Vec::as_slice).unwrap_or_default();
        assert!(spans.iter().all(|span| span["name"].is_string()), "{line}");
    }
    for id in &ids {
        let accepted =
            lines.iter().find(|line| line["fields"]["message"] == "accepted" && line["fields"]["job"] == **id);
        let fields = &accepted.expect("each job has a line")["fields"];
        assert_eq!((&fields["machine"], &fields["tenant"]), (&"fanuc-mill".into(), &"default".into()), "{fields}");
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

/// Starts a server that refuses to start; returns its exit code and its reason.
fn refused(variable: (&str, &str), option: [&str; 2]) -> (i32, String) {
    let folder = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_counterpointd"));
    command.args(["--listen", "127.0.0.1:0", "--data"]).arg(folder.path()).args(option).env(variable.0, variable.1);
    let output = command.output().unwrap();
    (output.status.code().unwrap(), String::from_utf8(output.stderr).unwrap())
}

/// A misspelt level would name a target without any lines, so the log would be empty.
#[test]
fn a_word_alone_in_the_filter_of_the_log_is_a_level() {
    for filter in ["inof", "info,debgu", "counterpoint_server", "info, h2"] {
        let (code, text) = refused(("COUNTERPOINT_LOG", filter), ["--audit", "/no-such-folder/audit.json"]);
        assert!(code == 2 && text.contains(&format!("COUNTERPOINT_LOG is '{filter}'")), "{code} {text}");
        let word = filter.rsplit([',', ' ']).next().unwrap();
        assert!(text.contains(&format!("'{word}' is not a level")) && text.contains("target=level"), "{text}");
    }
    // These are accepted: the server refuses its next option.
    for filter in ["WARN", "0", "off", "info, counterpoint_server=debug", "[job]=debug", "warn,[job{tenant}]", "", ","]
    {
        let (code, text) = refused(("COUNTERPOINT_LOG", filter), ["--audit", "/no-such-folder/audit.json"]);
        assert!(code == 2 && text.contains("(option audit)"), "{filter}: {code} {text}");
    }
}

#[test]
fn a_wrong_filter_of_the_log_and_an_audit_log_without_a_folder_are_named() {
    let (code, text) = refused(("COUNTERPOINT_LOG", "counterpoint_server=loud"), ["--workers", "1"]);
    assert!(code == 2 && text.contains("COUNTERPOINT_LOG is 'counterpoint_server=loud'"), "{code} {text}");
    let (code, text) = refused(("COUNTERPOINT_LOG", "info"), ["--audit", "/no-such-folder/audit.json"]);
    assert!(code == 2 && text.contains("(option audit)") && text.contains("/no-such-folder"), "{code} {text}");
}

#[test]
fn man_without_a_folder_prints_the_page_of_the_server() {
    let output = Command::new(env!("CARGO_BIN_EXE_counterpointd")).arg("man").output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success() && text.contains(".TH counterpointd 8"), "{text}");
    assert!(text.contains(".SH OPTIONS") && text.contains(".SH SIGNALS"), "{text}");
}
