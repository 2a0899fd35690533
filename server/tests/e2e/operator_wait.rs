//! Running jobs that wait for a client say so wherever their state is shown.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use counterpoint_proto::v1;
use counterpoint_proto::v1::watch_job_response::Content;
use counterpoint_server::options::{Quotas, ServerOptions, System};
use tokio_stream::wrappers::ReceiverStream;

use crate::support::*;

fn now_ms() -> i64 {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_millis().try_into().unwrap()
}

async fn submit(server: &Server, script: &str, options: v1::JobOptions) -> String {
    let request = v1::SubmitJobRequest { options: Some(options), ..server.request("waits", script).await };
    server.jobs().submit_job(request).await.unwrap().into_inner().status.unwrap().job_id
}

/// The wait of the job, about which all calls that show the job must agree.
async fn shown(server: &Server, job: &str) -> Option<v1::OperatorWait> {
    let got = server.status(job).await.operator_wait;
    let list = server.jobs().list_jobs(v1::ListJobsRequest::default()).await.unwrap().into_inner();
    let listed = list.jobs.into_iter().find(|listed| listed.job_id == job).unwrap().operator_wait;
    let wait = v1::WaitJobRequest { job_id: job.to_owned(), timeout_ms: 1 };
    let waited = server.jobs().wait_job(wait).await.unwrap().into_inner().status.unwrap().operator_wait;
    let mut watch = server.watch(job, 0, v1::WatchLevel::Progress).await;
    let Some(Content::Progress(progress)) = watch.message().await.unwrap().unwrap().content else { panic!("progress") };
    assert_eq!((&listed, &waited, &progress.operator_wait), (&got, &got, &got));
    got
}

async fn until_it_waits(server: &Server, job: &str) -> v1::OperatorWait {
    let wait = async {
        loop {
            if let Some(wait) = server.status(job).await.operator_wait {
                return wait;
            }
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
    };
    tokio::time::timeout(Duration::from_secs(20), wait).await.expect("the job waits for a client")
}

/// The next state of the job in a watch of many jobs that passes the test.
async fn until_reported(watch: &mut tonic::Streaming<v1::WatchJobsResponse>, passes: impl Fn(&v1::JobStatus) -> bool) {
    let reported = async {
        loop {
            let message = watch.message().await.unwrap().unwrap();
            if message.changes.into_iter().filter_map(|change| change.status).any(|status| passes(&status)) {
                return;
            }
        }
    };
    tokio::time::timeout(Duration::from_secs(20), reported).await.expect("the change is reported");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_whose_dialog_is_open_waits_for_an_answer() {
    let data = tempfile::tempdir().unwrap();
    let server = Server::start(options(data.path())).await;
    let request = v1::WatchJobsRequest { heartbeat_ms: 1000, ..Default::default() };
    let mut watch = server.jobs().watch_jobs(request).await.unwrap().into_inner();
    let begin = now_ms();
    let attended = v1::JobOptions { attended: true, ..Default::default() };
    let job = submit(&server, "ASK Clamp\nHANG", attended.clone()).await;
    let wait = until_it_waits(&server, &job).await;
    assert_eq!(wait.action(), v1::OperatorAction::Answer);
    assert!((begin..=now_ms()).contains(&wait.since_ms), "{wait:?}");
    let wait_s = i64::try_from(System::default().operator_wait_s).unwrap();
    assert_eq!(wait.until_ms, wait.since_ms + 1000 * wait_s, "operator_wait_s of the server");
    let deadline = wait.since_ms + 60_000;
    let request = server.request("late", "ASK Clamp").await;
    let request = v1::SubmitJobRequest { options: Some(attended), deadline_ms: deadline, ..request };
    let late = server.jobs().submit_job(request).await.unwrap().into_inner().status.unwrap().job_id;
    assert_eq!(until_it_waits(&server, &late).await.until_ms, deadline, "its deadline comes first");
    assert_eq!(shown(&server, &job).await, Some(wait));
    until_reported(&mut watch, |status| status.operator_wait == Some(wait)).await;
    let answer = v1::DialogAnswer { button: "OK".into(), ..Default::default() };
    let answer = v1::AnswerQuestionRequest { job_id: job.clone(), question_id: 1, answer: Some(answer) };
    assert!(server.operator().answer_question(answer).await.unwrap().into_inner().accepted);
    until_reported(&mut watch, |status| status.job_id == job && status.operator_wait.is_none()).await;
    assert_eq!(shown(&server, &job).await, None, "it runs");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_that_stands_waits_for_a_command() {
    let data = tempfile::tempdir().unwrap();
    let system = System { operator_wait_s: 600, ..System::default() };
    let server = Server::start(ServerOptions { system, ..options(data.path()) }).await;
    let job = submit(&server, "STEP a\nHANG", v1::JobOptions { stepped: true, ..Default::default() }).await;
    let wait = until_it_waits(&server, &job).await;
    assert_eq!(wait.action(), v1::OperatorAction::Command);
    assert_eq!(wait.until_ms, wait.since_ms + 600_000);
    assert_eq!(shown(&server, &job).await, Some(wait));
    let (say, requests) = tokio::sync::mpsc::channel(4);
    let content = |content| v1::DebugRequest { content: Some(content) };
    say.send(content(v1::debug_request::Content::JobId(job.clone()))).await.unwrap();
    let _heard = server.operator().debug(ReceiverStream::new(requests)).await.unwrap();
    let step = v1::DebugCommand { what: Some(v1::debug_command::What::Step(v1::DebugStep::default())) };
    say.send(content(v1::debug_request::Content::Command(step))).await.unwrap();
    while server.status(&job).await.operator_wait.is_some() {
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    assert_eq!(shown(&server, &job).await, None, "it runs");
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_progress_of_a_job_that_is_held_back_says_so() {
    let data = tempfile::tempdir().unwrap();
    let server = Server::start(options(data.path())).await;
    let job = server.submit("held", "HANG").await;
    let mut watch = server.watch(&job, 0, v1::WatchLevel::Progress).await;
    server.jobs().pause_job(v1::PauseJobRequest { job_id: job.clone() }).await.unwrap();
    let reported = async {
        loop {
            let content = watch.message().await.unwrap().unwrap().content;
            if matches!(&content, Some(Content::Progress(progress)) if progress.paused) {
                return;
            }
        }
    };
    tokio::time::timeout(Duration::from_secs(20), reported).await.expect("the progress says that the job is paused");
    server.stop().await;
}

/// A client may see a wait at once, for example when it starts to follow the jobs.
#[tokio::test(flavor = "multi_thread")]
async fn the_end_of_a_short_wait_is_reported_to_those_who_saw_it() {
    let data = tempfile::tempdir().unwrap();
    let server = Server::start(options(data.path())).await;
    let attended = v1::JobOptions { attended: true, ..Default::default() };
    let job = submit(&server, "ASK Clamp\nHANG", attended.clone()).await;
    until_it_waits(&server, &job).await;
    let mut watch = server.jobs().watch_jobs(v1::WatchJobsRequest::default()).await.unwrap().into_inner();
    until_reported(&mut watch, |status| status.job_id == job && status.operator_wait.is_some()).await;
    let answer = v1::DialogAnswer { button: "OK".into(), ..Default::default() };
    let answer = v1::AnswerQuestionRequest { job_id: job.clone(), question_id: 1, answer: Some(answer) };
    assert!(server.operator().answer_question(answer).await.unwrap().into_inner().accepted);
    until_reported(&mut watch, |status| status.job_id == job && status.operator_wait.is_none()).await;
    server.stop().await;
}

/// Waits until the status and the lists show why a queued job waits; returns the reason.
async fn until_it_waits_for_a_worker(server: &Server, job: &str) -> v1::WorkerWait {
    let wait = async {
        loop {
            if let Some(wait) = server.status(job).await.worker_wait {
                return wait;
            }
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
    };
    let wait = tokio::time::timeout(Duration::from_secs(20), wait).await.expect("the job has a reason to wait");
    let list = server.jobs().list_jobs(v1::ListJobsRequest::default()).await.unwrap().into_inner();
    for listed in list.jobs {
        assert_eq!(listed.worker_wait, (listed.job_id == job).then_some(wait), "only the queued job waits: {listed:?}");
    }
    wait
}

/// The jobs of a tenant that wait for a client hold its workers.
#[tokio::test(flavor = "multi_thread")]
async fn a_queued_job_says_that_jobs_which_wait_for_a_client_hold_all_workers() {
    let data = tempfile::tempdir().unwrap();
    let server = Server::start(ServerOptions { workers: 1, ..options(data.path()) }).await;
    let attended = v1::JobOptions { attended: true, ..Default::default() };
    let asks = submit(&server, "ASK Clamp", attended).await;
    until_it_waits(&server, &asks).await;
    let job = server.submit("queued", "EVENTS 3").await;
    let wait = until_it_waits_for_a_worker(&server, &job).await;
    assert_eq!(wait, v1::WorkerWait { workers: 1, waiting_for_client: 1, tenant_running: false });
    let short = v1::WaitJobRequest { job_id: job.clone(), timeout_ms: 1 };
    let waited = server.jobs().wait_job(short).await.unwrap().into_inner().status.unwrap();
    assert_eq!(waited.worker_wait, Some(wait), "a call that waits for the end has the reason, too");
    let answer = v1::DialogAnswer { button: "OK".into(), ..Default::default() };
    let answer = v1::AnswerQuestionRequest { job_id: asks, question_id: 1, answer: Some(answer) };
    assert!(server.operator().answer_question(answer).await.unwrap().into_inner().accepted);
    assert_eq!(server.wait(&job).await.worker_wait, None);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_queued_job_says_that_its_tenant_has_all_workers_of_its_quota() {
    let data = tempfile::tempdir().unwrap();
    let quotas = Quotas { tenant_running: 1, ..Quotas::default() };
    let server = Server::start(ServerOptions { workers: 4, quotas, ..options(data.path()) }).await;
    let hangs = server.submit("hangs", "HANG").await;
    server.until(&hangs, v1::JobState::Running).await;
    let job = server.submit("queued", "EVENTS 3").await;
    let wait = until_it_waits_for_a_worker(&server, &job).await;
    assert_eq!(wait, v1::WorkerWait { workers: 1, waiting_for_client: 0, tenant_running: true });
    server.stop().await;
}
