//! Messages compressed by gzip, in both directions.

use std::time::Duration;

use counterpoint_proto::v1;
use tonic::Code;
use tonic::codec::CompressionEncoding::Gzip;

use crate::support::*;
use crate::web::ask;

/// A member of gzip data whose content is stored as it is.
fn member(content: &[u8]) -> Vec<u8> {
    let length = u16::try_from(content.len()).unwrap();
    let mut member = vec![0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 255, 1];
    member.extend([length.to_le_bytes(), (!length).to_le_bytes()].concat());
    member.extend(content);
    member.extend([crc32fast::hash(content).to_le_bytes(), u32::from(length).to_le_bytes()].concat());
    member
}

/// The status of a call with this gzip data as its message.
async fn call(server: &Server, data: &[u8]) -> String {
    let headers = "content-type: application/grpc-web+proto\r\ngrpc-encoding: gzip\r\n";
    let mut body = vec![1];
    body.extend(u32::try_from(data.len()).unwrap().to_be_bytes());
    body.extend(data);
    let answer = String::from_utf8_lossy(&ask(server, "POST", headers, &body).await).into_owned();
    let status = answer.rsplit_once("grpc-status:").unwrap_or_else(|| panic!("{answer}")).1;
    status.trim_start().chars().take_while(char::is_ascii_digit).collect()
}

#[tokio::test]
async fn a_message_is_the_first_member_of_its_gzip_data() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = options(folder.path());
    options.guard.grpc_web = true;
    let server = Server::start(options).await;
    let (message, wrong) = (member(&[]), member(&[0xff; 3]));
    assert_eq!(call(&server, &message).await, "0");
    assert_ne!(call(&server, &wrong).await, "0", "the content is not a message");
    assert_eq!(call(&server, &[&message[..], &wrong].concat()).await, "0", "a second member is ignored");
    assert_eq!(call(&server, &[&message[..], b"behind"].concat()).await, "0", "other bytes are ignored");
    assert_ne!(call(&server, &[&wrong[..], &message].concat()).await, "0");
    assert_ne!(call(&server, &message[..message.len() - 1]).await, "0", "the data have no end");
    server.stop().await;
}

#[tokio::test]
async fn a_client_that_compresses_gets_compressed_answers_and_the_same_contents() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let content = "N10 G1 X10. Z-20. F0.2\n".repeat(2000);
    let digest = digest(content.as_bytes());
    let chunk = v1::UploadRequest { digest: digest.clone(), data: content.clone().into(), ..Default::default() };
    let mut blobs = server.blobs().send_compressed(Gzip).accept_compressed(Gzip);
    assert_eq!(blobs.upload(tokio_stream::iter([chunk])).await.unwrap().into_inner().size, content.len() as u64);
    let job = server.submit("r", "EVENTS 3000").await;
    server.wait(&job).await;
    let ask = v1::GetEventsRequest { job_id: job.clone() };
    let mut texts = Vec::new();
    for results in [server.results(), server.results().accept_compressed(Gzip)] {
        let response = results.clone().get_events(ask.clone()).await.unwrap();
        let compressed = response.metadata().get("grpc-encoding").is_some_and(|encoding| encoding == "gzip");
        let (mut stream, mut text) = (response.into_inner(), Vec::new());
        while let Some(message) = stream.message().await.unwrap() {
            text.extend(message.data);
        }
        texts.push((compressed, text));
    }
    assert!(!texts[0].0 && texts[1].0 && texts[0].1 == texts[1].1 && texts[0].1.len() > 100_000);
    let watch = v1::WatchJobRequest { job_id: job, ..Default::default() };
    let mut stream = server.jobs().accept_compressed(Gzip).watch_job(watch).await.unwrap().into_inner();
    while tokio::time::timeout(Duration::from_secs(10), stream.message()).await.unwrap().unwrap().is_some() {}
    server.stop().await;
}

/// Some kilobytes that are gigabytes when they are decompressed.
#[tokio::test]
async fn a_message_is_bounded_by_its_size_without_compression() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let bomb = v1::FindMissingRequest { digests: vec!["x".repeat(64 << 20)] };
    let refused = server.blobs().send_compressed(Gzip).find_missing(bomb).await.unwrap_err();
    assert_eq!((refused.code(), reason(&refused).as_str()), (Code::ResourceExhausted, "MESSAGE_TOO_LARGE"));
    assert!(refused.message().contains("4194304"), "{refused}");
    let chunk = v1::UploadRequest { data: vec![0; 64 << 20].into(), ..Default::default() };
    let refused = server.blobs().send_compressed(Gzip).upload(tokio_stream::iter([chunk])).await.unwrap_err();
    assert_eq!((refused.code(), reason(&refused).as_str()), (Code::ResourceExhausted, "MESSAGE_TOO_LARGE"));
    server.submit("next", "EVENTS 1").await;
    server.stop().await;
}
