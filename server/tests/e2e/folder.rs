//! One server per data folder.

use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

use counterpoint_proto::v1;
use counterpoint_server::service;
use tokio_stream::wrappers::ReceiverStream;

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
