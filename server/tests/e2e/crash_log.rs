//! The log and the status after a crash of the server.

use counterpoint_proto::v1;
use counterpoint_proto::v1::admin_client::AdminClient;
use counterpoint_proto::v1::blobs_client::BlobsClient;
use counterpoint_proto::v1::jobs_client::JobsClient;
use tonic::transport::{Channel, Endpoint};

use crate::descriptors::Process;
use crate::support::*;

const ENDLESS: &[u8] = b"O1\nG21 G94 F100\nN1 G1 X1.\nX0.\nGOTO 1\nM30\n";

async fn connected(server: &Process) -> Channel {
    Endpoint::from_shared(format!("http://{}", server.address)).unwrap().connect().await.unwrap()
}

/// Submits a job and waits until it runs.
async fn running(server: &Process) -> String {
    let job = submit(server, "endless").await;
    while status(server, &job).await.state() != v1::JobState::Running {
        tokio::task::yield_now().await;
    }
    job
}

async fn submit(server: &Process, request_id: &str) -> String {
    let channel = connected(server).await;
    let upload = v1::UploadRequest { digest: digest(ENDLESS), data: ENDLESS.into(), size: None };
    BlobsClient::new(channel.clone()).upload(tokio_stream::iter([upload])).await.unwrap();
    let limits = v1::JobLimits { blocks: 1_000_000_000, simulated_ns: i64::MAX, ..Default::default() };
    let request = v1::SubmitJobRequest {
        request_id: request_id.into(),
        machine: "fanuc-mill".into(),
        programs: vec![v1::Program { path: "main.nc".into(), ..Default::default() }],
        files: vec![v1::FileRef { path: "main.nc".into(), digest: digest(ENDLESS) }],
        options: Some(v1::JobOptions { limits: Some(limits), ..Default::default() }),
        ..Default::default()
    };
    let mut jobs = JobsClient::new(channel);
    jobs.submit_job(request).await.unwrap().into_inner().status.unwrap().job_id
}

async fn status(server: &Process, job: &str) -> v1::JobStatus {
    let request = v1::GetJobRequest { job_id: job.to_owned() };
    JobsClient::new(connected(server).await).get_job(request).await.unwrap().into_inner().status.unwrap()
}

#[tokio::test]
async fn the_log_and_the_status_name_a_job_that_runs_alone_and_the_end_of_that() {
    let folder = tempfile::tempdir().unwrap();
    let server = Process::start(folder.path());
    let job = running(&server).await;
    assert!(!status(&server, &job).await.suspect);
    drop(server);
    let server = Process::start(folder.path());
    let warning = |line: &str| assert!(line.contains("WARN"), "{line}");
    let cause = "the previous server died while these jobs were working: look for the cause at the end of its log";
    warning(&server.until(cause).await);
    let remedy = "cancel it if it must not run again";
    warning(&server.until(&format!("suspect: the job waits to run alone; {remedy} job=\"{job}\"")).await);
    let remedy = "cancel it if they must not wait";
    warning(
        &server.until(&format!("the job runs alone after a crash, and other jobs wait; {remedy} job=\"{job}\"")).await,
    );
    assert!(status(&server, &job).await.suspect);
    let workers = AdminClient::new(connected(&server).await).list_workers(v1::ListWorkersRequest {}).await;
    assert!(workers.unwrap().into_inner().workers.iter().all(|worker| worker.suspect));
    let waiting = submit(&server, "waiting").await;
    let waits = status(&server, &waiting).await;
    let listed = JobsClient::new(connected(&server).await).list_jobs(v1::ListJobsRequest::default()).await;
    let listed = listed.unwrap().into_inner().jobs.pop().unwrap();
    for waits in [waits, listed] {
        assert_eq!((waits.waits_for_suspect, &waits.waits_for_job), (true, &job), "{waits:?}");
    }
    assert!(!status(&server, &job).await.waits_for_suspect);
    warning(
        &server
            .until(&format!("no longer a suspect: other jobs run beside it; no action is needed job=\"{job}\""))
            .await,
    );
    assert!(!status(&server, &job).await.suspect);
    assert!(!status(&server, &waiting).await.waits_for_suspect);
}

#[tokio::test]
async fn the_log_says_that_a_job_is_given_up() {
    let folder = tempfile::tempdir().unwrap();
    let server = Process::start(folder.path());
    let job = running(&server).await;
    drop(server);
    let server = Process::start_with(folder.path(), &["--attempts", "1"]);
    let line = server.until("given up: poison: the server died 1 times while this job ran alone").await;
    assert!(line.contains("WARN") && line.contains(&job), "{line}");
    let remedy = "look for the cause at the end of the log of the crashed server before you run the job again";
    assert!(line.contains(remedy), "{line}");
    let status = status(&server, &job).await;
    assert!(status.state() == v1::JobState::Failed && !status.suspect, "{status:?}");
}
