//! Stalled connections and uploads.

use std::time::Duration;

use counterpoint_proto::{DESCRIPTORS, v1};
use counterpoint_server::options::{Connections, ServerOptions};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;
use tokio_stream::wrappers::ReceiverStream;
use tonic::Code;
use tonic_types::StatusExt;

use crate::contract::*;
use crate::guarded::As;
use crate::support::*;

async fn connect(server: &Server) -> TcpStream {
    TcpStream::connect(server.handle.address()).await.unwrap()
}

/// Reads until the server closes the connection; returns the bytes.
async fn closed(stream: &mut TcpStream) -> Vec<u8> {
    let mut said = Vec::new();
    let end = tokio::time::timeout(Duration::from_secs(20), stream.read_to_end(&mut said)).await;
    let _ = end.expect("the server lets the connection go");
    said
}

#[tokio::test]
async fn a_peer_that_never_speaks_or_only_begins_to_is_let_go() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(ServerOptions {
        connections: Connections { preface_s: 1, ..Connections::default() },
        ..options(folder.path())
    })
    .await;
    let (mut silent, mut slow) = (connect(&server).await, connect(&server).await);
    slow.write_all(b"PRI * HT").await.unwrap();
    closed(&mut silent).await;
    closed(&mut slow).await;
    let job = server.submit("r", "EVENTS 1").await;
    assert_eq!(server.wait(&job).await.state(), v1::JobState::Succeeded);
    server.stop().await;
}

#[tokio::test]
async fn a_connection_without_calls_is_let_go_and_one_with_a_watch_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(ServerOptions {
        connections: Connections { idle_s: 1, ..Connections::default() },
        ..options(folder.path())
    })
    .await;
    let job = server.submit("r", "HANG\nEVENTS 3").await;
    let mut watch = server.watch(&job, 0, v1::WatchLevel::Blocks).await;
    let mut idle = connect(&server).await;
    idle.write_all(b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\x04\0\0\0\0\0").await.unwrap();
    let said = closed(&mut idle).await;
    assert!(said.windows(2).any(|w| w == [7, 0]), "GOAWAY: {said:?}");
    server.script.hang.store(false, std::sync::atomic::Ordering::SeqCst);
    while let Some(message) = watch.message().await.unwrap() {
        if let Some(v1::watch_job_response::Content::Ended(status)) = message.content {
            assert_eq!(status.state(), v1::JobState::Succeeded);
        }
    }
    server.stop().await;
}

#[tokio::test]
async fn connections_are_limited_per_address_and_a_place_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    // One for the client of the test.
    let server = Server::start(ServerOptions {
        connections: Connections { max_connections_per_address: 3, ..Connections::default() },
        ..options(folder.path())
    })
    .await;
    let (first, _second) = (connect(&server).await, connect(&server).await);
    let mut beyond = connect(&server).await;
    assert_eq!(closed(&mut beyond).await, b"");
    drop(first);
    let mut place = Vec::new();
    for _ in 0..1000 {
        let mut stream = connect(&server).await;
        let mut byte = [0];
        if tokio::time::timeout(Duration::from_millis(50), stream.read(&mut byte)).await.is_err() {
            place.push(stream);
            break;
        }
    }
    assert_eq!(place.len(), 1, "the place of the one that left is free again");
    server.stop().await;
}

/// No call waits longer for its request, regardless of its kind.
#[tokio::test]
async fn a_call_whose_request_stands_still_is_ended() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(ServerOptions {
        connections: Connections { upload_stall_s: 1, ..Connections::default() },
        ..options(folder.path())
    })
    .await;
    let caller = As::nobody(&server);
    let mut calls = tokio::task::JoinSet::new();
    let sets = [DESCRIPTORS, tonic_health::pb::FILE_DESCRIPTOR_SET];
    for method in sets.into_iter().flat_map(methods) {
        let caller = caller.clone();
        calls.spawn(async move {
            let answer = call(&caller, &method.path, tokio_stream::pending()).await;
            (method.path, answer.map(drop).unwrap_err())
        });
    }
    let ended = tokio::time::timeout(Duration::from_secs(20), calls.join_all()).await.expect("every call ends");
    for (path, refused) in ended {
        let expected = if path.ends_with("/Upload") { "UPLOAD_STALLED" } else { "CALL_STALLED" };
        assert_eq!((refused.code(), reason(&refused).as_str()), (Code::DeadlineExceeded, expected), "{path}");
    }
    let job = server.submit("r", "EVENTS 1").await;
    assert_eq!(server.wait(&job).await.state(), v1::JobState::Succeeded, "others are served");
    server.stop().await;
}

#[tokio::test]
async fn an_upload_that_stands_still_is_ended() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(ServerOptions {
        connections: Connections { upload_stall_s: 1, ..Connections::default() },
        ..options(folder.path())
    })
    .await;
    let (chunks, stream) = tokio::sync::mpsc::channel(1);
    let first = v1::UploadRequest { digest: digest(b"whole"), data: "who".into(), size: None };
    chunks.send(first).await.unwrap();
    let refused = server.blobs().upload(ReceiverStream::new(stream)).await.unwrap_err();
    assert_eq!((refused.code(), reason(&refused).as_str()), (Code::DeadlineExceeded, "UPLOAD_STALLED"));
    assert_eq!(std::fs::read_dir(folder.path().join("tmp")).unwrap().count(), 0);
    drop(chunks);
    server.stop().await;
}

#[tokio::test]
async fn uploads_of_a_connection_are_limited() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(ServerOptions {
        connections: Connections { max_uploads_per_connection: 2, ..Connections::default() },
        ..options(folder.path())
    })
    .await;
    let mut open = Vec::new();
    for n in 0..2 {
        let (chunks, stream) = tokio::sync::mpsc::channel(1);
        let first = v1::UploadRequest { digest: digest(b"whole"), data: "who".into(), size: None };
        chunks.send(first).await.unwrap();
        let mut blobs = server.blobs();
        open.push((chunks, tokio::spawn(async move { blobs.upload(ReceiverStream::new(stream)).await })));
        while std::fs::read_dir(folder.path().join("tmp")).unwrap().count() <= n {
            tokio::time::sleep(Duration::from_millis(2)).await;
        }
    }
    let upload = || v1::UploadRequest { digest: digest(b"x"), data: "x".into(), size: None };
    let refused = server.blobs().upload(tokio_stream::iter([upload()])).await.unwrap_err();
    assert_eq!((refused.code(), reason(&refused).as_str()), (Code::ResourceExhausted, "TOO_MANY_UPLOADS"));
    assert!(refused.get_error_details().retry_info().is_some());
    for (chunks, upload) in open {
        chunks.send(v1::UploadRequest { data: "le".into(), ..Default::default() }).await.unwrap();
        drop(chunks);
        upload.await.unwrap().unwrap();
    }
    server.blobs().upload(tokio_stream::iter([upload()])).await.unwrap();
    server.stop().await;
}
