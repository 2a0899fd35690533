//! Messages of refusals: each says what to do, and names the option that sets a limit.

use counterpoint_proto::v1;
use counterpoint_server::options::{Maxima, Quotas, ServerOptions};
use counterpoint_server::service;
use tonic::Status;

use crate::support::*;

/// Submits a job with a number of programs.
async fn submit_programs(server: &Server, count: usize) -> Status {
    let request = server.request("programs", "EVENTS 1").await;
    let digest = request.files[0].digest.clone();
    let path = |n: usize| format!("p{n}.nc");
    let request = v1::SubmitJobRequest {
        programs: (0..count).map(|n| v1::Program { path: path(n), ..Default::default() }).collect(),
        files: (0..count).map(|n| v1::FileRef { path: path(n), digest: digest.clone() }).collect(),
        ..request
    };
    server.jobs().submit_job(request).await.unwrap_err()
}

#[tokio::test]
async fn a_limit_on_a_list_names_its_option() {
    let folder = tempfile::tempdir().unwrap();
    let maxima = Maxima { max_files: 3, max_programs: 2, ..Maxima::default() };
    let server = Server::start(ServerOptions { maxima, ..options(folder.path()) }).await;
    for (count, field, option) in [(4, "files", "max_files"), (3, "programs", "max_programs")] {
        let refused = submit_programs(&server, count).await;
        let text = refused.message();
        assert!(text.starts_with(&format!("{field}: ")) && text.contains(option), "{text}");
        assert!(text.contains(&format!("has {count}")), "{text}");
    }
    let digest = server.upload(b"x").await;
    let file = |n| v1::MachineFile { path: format!("own/{n}.toml"), digest: digest.clone() };
    let put = v1::PutMachineRequest { name: "own".into(), files: (0..4).map(file).collect() };
    let refused = server.machines().put_machine(put).await.unwrap_err();
    assert!(refused.message().contains("max_files"), "{refused}");
    server.stop().await;
}

#[tokio::test]
async fn a_full_queue_names_its_option_and_asks_to_submit_later() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(ServerOptions { workers: 1, queue: 1, ..options(folder.path()) }).await;
    let running = server.submit("running", "HANG").await;
    server.until(&running, v1::JobState::Running).await;
    let mut waiting = 0;
    let refused = loop {
        let request = server.request(&format!("waiting-{waiting}"), "HANG").await;
        match server.jobs().submit_job(request).await {
            Ok(_) => waiting += 1,
            Err(refused) => break refused,
        }
        assert!(waiting < 10, "the queue has an end");
    };
    assert_eq!(reason(&refused), "QUEUE_FULL");
    let text = refused.message();
    assert!(text.contains("option queue") && text.contains("submit again later"), "{text}");
    server.stop().await;
}

/// Deleting jobs cannot make room for a content that is larger than the quota.
#[tokio::test]
async fn a_content_beyond_the_whole_quota_is_told_from_one_that_fits_later() {
    let folder = tempfile::tempdir().unwrap();
    let quotas = Quotas { tenant_bytes: 2000, ..Quotas::default() };
    let server = Server::start(ServerOptions { quotas, ..options(folder.path()) }).await;
    server.upload(&[b'x'; 1500]).await;
    let put = async |length: usize| {
        let refused =
            server.blobs().put_blob(v1::PutBlobRequest { data: vec![b'y'; length].into() }).await.unwrap_err();
        assert_eq!(reason(&refused), "QUOTA_EXCEEDED");
        refused.message().to_owned()
    };
    let later = put(1000).await;
    assert!(later.contains("delete ended jobs"), "{later}");
    let never = put(3000).await;
    assert!(never.contains("more than the whole quota") && !never.contains("delete"), "{never}");
    let streamed = v1::UploadRequest { digest: digest(&[b'z'; 3000]), data: vec![b'z'; 3000].into(), size: None };
    let refused = server.blobs().upload(tokio_stream::iter([streamed])).await.unwrap_err();
    assert!(refused.message().contains("more than the whole quota"), "{refused}");
    server.stop().await;
}

#[tokio::test]
async fn a_chunk_that_is_too_large_is_refused_with_the_remedy_for_its_call() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let data: tonic::codegen::Bytes = vec![0; 2 << 20].into();
    let chunk = v1::UploadRequest { digest: digest(&data), data: data.clone(), size: None };
    let upload = server.blobs().upload(tokio_stream::iter([chunk])).await.unwrap_err();
    let put = server.blobs().put_blob(v1::PutBlobRequest { data }).await.unwrap_err();
    for (refused, remedy) in [(upload, "in smaller chunks"), (put, "with Upload, in chunks")] {
        let text = refused.message();
        assert!(text.contains("1048576") && text.contains("has 2097152") && text.contains(remedy), "{text}");
    }
    server.stop().await;
}

/// The refusal does not claim that a job was never run if the job ran before it waited again.
#[tokio::test]
async fn a_job_that_was_cancelled_while_it_waited_has_no_results_whether_it_had_run_or_not() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(ServerOptions { workers: 1, ..options(folder.path()) }).await;
    let job_id = server.submit("paused", "EVENTS 5\nHANG").await;
    server.until_events(&job_id, 5).await;
    server.jobs().pause_job(v1::PauseJobRequest { job_id: job_id.clone() }).await.unwrap();
    server.until(&job_id, v1::JobState::Queued).await;
    server.jobs().cancel_job(v1::CancelJobRequest { job_id: job_id.clone() }).await.unwrap();
    server.wait(&job_id).await;
    let refused = server.results().get_summary(v1::GetSummaryRequest { job_id }).await.unwrap_err();
    assert_eq!(reason(&refused), "NO_RESULTS");
    assert!(refused.message().contains("ended without a finished run"), "{refused}");
    server.stop().await;
}

#[tokio::test]
async fn an_address_that_cannot_be_used_is_reported_with_its_option() {
    let folder = tempfile::tempdir().unwrap();
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap();
    let refused = async |options: ServerOptions| service::build(options).await.map(drop).unwrap_err().to_string();
    let mut metrics = options(&folder.path().join("metrics"));
    metrics.connections.metrics = address.to_string();
    let listen = ServerOptions { listen: address, ..options(&folder.path().join("listen")) };
    for (options, name) in [(metrics, "metrics"), (listen, "listen")] {
        let text = refused(options).await;
        assert!(text.contains(&format!("cannot listen on {address} (option {name})")), "{text}");
    }
}
