//! Messages compressed by gzip, in both directions.

use std::time::Duration;

use counterpoint_proto::v1;
use tonic::Code;
use tonic::codec::CompressionEncoding::Gzip;

use crate::support::*;

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
