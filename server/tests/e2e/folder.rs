//! One server per data folder.

use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

use counterpoint_proto::v1;
use counterpoint_server::service;
use tokio_stream::wrappers::ReceiverStream;

#[cfg(target_os = "linux")]
use crate::descriptors::Process;
use crate::support::*;

#[tokio::test]
async fn a_second_start_is_refused_and_harms_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let content = b"EVENTS 10";
    let name = digest(content);
    let (chunks, stream) = tokio::sync::mpsc::channel(1);
    let mut blobs = server.blobs();
    let upload = tokio::spawn(async move { blobs.upload(ReceiverStream::new(stream)).await });
    let first = v1::UploadRequest { digest: name.clone(), data: content[..4].into(), size: None };
    chunks.send(first).await.unwrap();
    while std::fs::read_dir(folder.path().join("tmp")).unwrap().count() == 0 {
        tokio::time::sleep(std::time::Duration::from_millis(2)).await;
    }
    let refused = service::build_with(options(folder.path()), Script::default()).await.map(drop).unwrap_err();
    let text = refused.to_string();
    assert!(text.contains(&format!("process {}", std::process::id())), "{text}");
    assert_eq!(std::fs::read_dir(folder.path().join("tmp")).unwrap().count(), 1, "the upload's file is still there");
    chunks.send(v1::UploadRequest { data: content[4..].into(), ..Default::default() }).await.unwrap();
    drop(chunks);
    assert_eq!(upload.await.unwrap().unwrap().into_inner().digest, name);
    let job = server.submit("r", "EVENTS 10").await;
    assert_eq!(server.wait(&job).await.state(), v1::JobState::Succeeded);
    server.stop().await;
    Server::start(options(folder.path())).await.stop().await;
}

/// The server's command, in a folder.
fn command(inside: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_counterpointd"));
    command.current_dir(inside).args(arguments).env_remove("COUNTERPOINT_LOG").env_remove("COUNTERPOINT_DATA");
    command
}

/// Whatever the umask of its parent and the mode of an earlier folder: other users can read nothing.
#[cfg(target_os = "linux")]
#[tokio::test]
async fn nobody_else_can_read_the_data_folder() {
    use std::os::unix::fs::PermissionsExt as _;

    use counterpoint_proto::v1::blobs_client::BlobsClient;
    use counterpoint_proto::v1::jobs_client::JobsClient;

    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data");
    std::fs::create_dir(&data).unwrap();
    std::fs::set_permissions(&data, std::fs::Permissions::from_mode(0o755)).unwrap();
    let audit = folder.path().join("audit.jsonl");
    let process = Process::start_with(folder.path(), &["--audit", audit.to_str().unwrap()]);
    let channel = tonic::transport::Endpoint::from_shared(format!("http://{}", process.address)).unwrap();
    let channel = channel.connect().await.unwrap();
    let program = format!("O1\n{}M30\n", "G4 P9\n".repeat(20_000));
    let name = digest(program.as_bytes());
    let chunks = program.as_bytes().chunks(60_000);
    let chunks = chunks.map(|data| v1::UploadRequest { data: data.to_vec().into(), ..Default::default() });
    let first = v1::UploadRequest { digest: name.clone(), ..Default::default() };
    let upload: Vec<_> = std::iter::once(first).chain(chunks).collect();
    BlobsClient::new(channel.clone()).upload(tokio_stream::iter(upload)).await.unwrap();
    let request = v1::SubmitJobRequest {
        request_id: "r".into(),
        machine: "fanuc-mill".into(),
        programs: vec![v1::Program { path: "main.nc".into(), ..Default::default() }],
        files: vec![v1::FileRef { path: "main.nc".into(), digest: name }],
        ..Default::default()
    };
    let mut jobs = JobsClient::new(channel);
    let job_id = jobs.submit_job(request).await.unwrap().into_inner().status.unwrap().job_id;
    jobs.wait_job(v1::WaitJobRequest { job_id: job_id.clone(), timeout_ms: 60_000 }).await.unwrap();
    assert!(log_file(&data, &job_id).is_file());
    let mut left = vec![data, audit];
    while let Some(path) = left.pop() {
        let meta = std::fs::metadata(&path).unwrap();
        let expected = if meta.is_dir() { 0o700 } else { 0o600 };
        assert_eq!(meta.permissions().mode() & 0o777, expected, "{}", path.display());
        if meta.is_dir() {
            left.extend(std::fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path()));
        }
    }
}

#[test]
fn folders_may_be_named_relative_to_the_current_one() {
    let folder = tempfile::tempdir().unwrap();
    let mut server =
        command(folder.path(), &["--listen", "127.0.0.1:0", "--data", "data"]).stdout(Stdio::piped()).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(server.stdout.take().unwrap()).read_line(&mut line).unwrap();
    assert!(line.contains("listening on http://127.0.0.1:"), "{line}");
    for arguments in [["backup", "copy", "--data", "data"], ["restore", "copy", "--data", "again"]] {
        let output = command(folder.path(), &arguments).output().unwrap();
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    }
    server.kill().unwrap();
    server.wait().unwrap();
    assert!(folder.path().join("again/ledger.redb").is_file());
}
