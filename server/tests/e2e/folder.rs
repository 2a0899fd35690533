//! One server per data folder.

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
