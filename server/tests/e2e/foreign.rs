//! Jobs of another tenant: every call with the id of a job, and every filter, treats them as not found.

use counterpoint_proto::{DESCRIPTORS, v1};
use counterpoint_server::access::Role;
use counterpoint_server::options::ServerOptions;
use prost::Message as _;
use tonic::Code;

use crate::contract::*;
use crate::guarded::*;
use crate::support::*;

const LATHE: &str = "fanuc-2path-lathe";

/// The jobs of a tenant: one each that has ended, runs, asks its operator, is stepped, or is held back.
struct Jobs {
    all: Vec<String>,
    asking: String,
    question: u64,
    stepped: String,
}

impl Jobs {
    async fn submit(owner: &As) -> Self {
        let ended = owner.submit("ended", LATHE, "EVENTS 3\nWRITE a.txt").await.unwrap().job_id;
        owner.wait(&ended).await;
        let running = owner.submit("running", LATHE, "EVENTS 2\nHANG").await.unwrap().job_id;
        until_logged(owner, &running, 2).await;
        let attended = v1::JobOptions { attended: true, ..Default::default() };
        let asking = owner.submit_with("asking", LATHE, "ASK who", Some(attended)).await.unwrap().job_id;
        let stepped = v1::JobOptions { stepped: true, ..Default::default() };
        let stepped = owner.submit_with("stepped", LATHE, "STEP here", Some(stepped)).await.unwrap().job_id;
        let held = owner.submit("held", LATHE, "HANG").await.unwrap().job_id;
        let (question, _) = (question(owner, &asking).await, at_stop(owner, &stepped).await);
        owner.jobs().pause_job(v1::PauseJobRequest { job_id: held.clone() }).await.unwrap();
        let all = vec![ended, running, asking.clone(), stepped.clone(), held];
        Self { all, asking, question, stepped }
    }

    /// All answers about these jobs that their owner receives.
    async fn seen(&self, owner: &As) -> Vec<v1::GetJobResponse> {
        let mut seen = Vec::new();
        for id in &self.all {
            let get = v1::GetJobRequest { job_id: id.clone() };
            seen.push(owner.jobs().get_job(get).await.unwrap().into_inner());
        }
        seen
    }
}

/// Waits until a job has logged this many events.
async fn until_logged(owner: &As, job: &str, events: u64) {
    let level = v1::WatchLevel::Everything.into();
    let request = v1::WatchJobRequest { job_id: job.into(), level, ..Default::default() };
    let mut watch = owner.jobs().watch_job(request).await.unwrap().into_inner();
    let mut seen = 0;
    while seen < events {
        if let Some(v1::watch_job_response::Content::Batch(batch)) = watch.message().await.unwrap().unwrap().content {
            seen = batch.last_seq;
        }
    }
}

/// The open question of a job.
async fn question(owner: &As, job: &str) -> u64 {
    let request = v1::WatchQuestionsRequest { job_id: job.into() };
    let mut questions = owner.operator().watch_questions(request).await.unwrap().into_inner();
    match questions.message().await.unwrap().unwrap().content.unwrap() {
        v1::watch_questions_response::Content::Question(question) => question.id,
        other => panic!("{other:?}"),
    }
}

/// Waits until a stepped job has stopped; returns the place.
async fn at_stop(owner: &As, job: &str) -> String {
    let first = v1::DebugRequest { content: Some(v1::debug_request::Content::JobId(job.into())) };
    let (send, receive) = tokio::sync::mpsc::channel(1);
    send.send(first).await.unwrap();
    let receive = tokio_stream::wrappers::ReceiverStream::new(receive);
    let mut stops = owner.operator().debug(receive).await.unwrap().into_inner();
    match stops.message().await.unwrap().unwrap().content.unwrap() {
        v1::debug_response::Content::Stopped(state) => state.reason,
        other => panic!("{other:?}"),
    }
}

/// Further fields that a call needs before it looks for its job.
fn more(method: &Method, jobs: &Jobs) -> Vec<u8> {
    match method.name() {
        "Jobs/RerunJob" => v1::RerunJobRequest { request_id: "stolen".into(), ..Default::default() }.encode_to_vec(),
        "Results/GetFile" => v1::GetFileRequest { path: "a.txt".into(), ..Default::default() }.encode_to_vec(),
        "Operator/AnswerQuestion" => {
            let answer = Some(v1::DialogAnswer { button: "OK".into(), ..Default::default() });
            v1::AnswerQuestionRequest { question_id: jobs.question, answer, ..Default::default() }.encode_to_vec()
        }
        _ => Vec::new(),
    }
}

/// Calls for many jobs find none of them.
async fn finds_nothing(other: &As, jobs: &Jobs) {
    let prefix = |id: &str| Some(v1::JobFilter { id_prefix: id.into(), ..Default::default() });
    let filters = jobs.all.iter().map(|id| prefix(id)).chain([prefix(""), None]);
    for filter in filters {
        let all = filter.as_ref().is_none_or(|filter| filter.id_prefix.is_empty());
        let cancel = v1::CancelJobsRequest { filter: filter.clone(), all, ..Default::default() };
        assert_eq!(other.jobs().cancel_jobs(cancel).await.unwrap().into_inner(), v1::CancelJobsResponse::default());
        let delete = v1::DeleteJobsRequest { filter: filter.clone(), all, ..Default::default() };
        assert_eq!(other.jobs().delete_jobs(delete).await.unwrap().into_inner(), v1::DeleteJobsResponse::default());
        let list = v1::ListJobsRequest { filter: filter.clone(), ..Default::default() };
        assert_eq!(other.jobs().list_jobs(list).await.unwrap().into_inner(), v1::ListJobsResponse::default());
        let watch = v1::WatchJobsRequest { filter, heartbeat_ms: 100, ..Default::default() };
        let mut watch = other.jobs().watch_jobs(watch).await.unwrap().into_inner();
        assert_eq!(watch.message().await.unwrap().unwrap().changes, []);
    }
    for id in &jobs.all {
        let list = v1::ListJobsRequest { page_token: id.clone(), ..Default::default() };
        assert_eq!(other.jobs().list_jobs(list).await.unwrap().into_inner().jobs, []);
    }
}

/// The refusal is the same as for a nonexistent job, and the owner's jobs are unaffected.
#[tokio::test]
async fn a_job_of_another_tenant_is_not_there_for_any_call() {
    let folder = tempfile::tempdir().unwrap();
    // The job that is held back finds no worker, so its state no longer changes.
    let options = ServerOptions { workers: 3, ..guarded(folder.path()) };
    let tokens = ["one", "other"].map(|tenant| grant(&options, "admin", tenant, Role::Admin));
    let server = Server::start(options).await;
    let [owner, other] = tokens.map(|token| As::new(&server, &token));
    let jobs = Jobs::submit(&owner).await;
    let before = jobs.seen(&owner).await;
    let absent = "00000000-0000-7000-8000-000000000000";
    let mut calls = 0;
    for method in methods(DESCRIPTORS) {
        let Some(field) = method.field("job_id") else { continue };
        calls += 1;
        let refusal = async |id: &str| {
            let message = [more(&method, &jobs), text(field, id)].concat();
            let status = ask(&other, &method.path, message).await.expect_err(method.name());
            assert_eq!((status.code(), reason(&status).as_str()), (Code::NotFound, "UNKNOWN_JOB"), "{}", method.name());
            status.message().replace(id, "ID")
        };
        let expected = refusal(absent).await;
        for id in &jobs.all {
            assert_eq!(refusal(id).await, expected, "{}", method.name());
        }
    }
    assert!(calls >= 20, "{calls} calls name a job");
    finds_nothing(&other, &jobs).await;

    assert_eq!(jobs.seen(&owner).await, before);
    assert_eq!(owner.list().await, jobs.all);
    assert_eq!(question(&owner, &jobs.asking).await, jobs.question, "it is still open");
    assert_eq!(at_stop(&owner, &jobs.stepped).await, "here");
    for id in &jobs.all[1..] {
        owner.jobs().cancel_job(v1::CancelJobRequest { job_id: id.clone() }).await.unwrap();
        assert_eq!(owner.wait(id).await.state(), v1::JobState::Cancelled);
    }
    server.stop().await;
}
