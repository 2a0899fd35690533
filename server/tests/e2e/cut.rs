//! Calls whose clients leave while the server makes their change durable: the change is completed and logged.

use std::path::Path;
use std::sync::{Arc, Condvar, Mutex};
use std::time::Duration;

use counterpoint_proto::v1;
use counterpoint_server::access::Role;
use counterpoint_server::local::disk::{Disk, DiskOperation, Faults};
use counterpoint_server::options::ServerOptions;
use tokio::sync::Notify;

use crate::audited::{all_lines, audited, lines};
use crate::guarded::*;
use crate::support::*;
use crate::web::ask_at;

/// A disk that delays every sync while it is closed.
#[derive(Default)]
struct Gate {
    closed: Mutex<bool>,
    opened: Condvar,
    held: Notify,
}

impl Faults for Gate {
    fn before(&self, step: DiskOperation, _path: &Path) -> std::io::Result<usize> {
        let mut closed = self.closed.lock().unwrap();
        while step == DiskOperation::Sync && *closed {
            self.held.notify_one();
            closed = self.opened.wait(closed).unwrap();
        }
        Ok(usize::MAX)
    }
}

impl Gate {
    fn set(&self, closed: bool) {
        *self.closed.lock().unwrap() = closed;
        self.opened.notify_all();
    }
}

/// A server on such a disk, and a caller.
pub(crate) struct Cut {
    gate: Arc<Gate>,
    pub(crate) server: Server,
    pub(crate) caller: As,
}

impl Cut {
    pub(crate) async fn start(options: ServerOptions, token: &str) -> Self {
        let gate = Arc::new(Gate::default());
        let server = Server::start_on(options, Disk::faulty(gate.clone())).await;
        let caller = As::new(&server, token);
        Self { gate, server, caller }
    }

    /// Makes a call and drops it while its change is on the way to the disk.
    async fn call<T: Send + 'static>(&self, call: impl Future<Output = T> + Send + 'static) {
        self.gate.set(true);
        let call = tokio::spawn(call);
        self.gate.held.notified().await;
        call.abort();
        assert!(call.await.is_err(), "the call has no answer yet");
        // The server reads the end of the previous call first, because this call uses the same connection.
        self.caller.list().await;
        self.gate.set(false);
    }

    /// Makes a call whose deadline passes while its change is being written, and returns its answer. The client does
    /// not end the call.
    async fn late(&self, token: &str, call: &str, request: &impl prost::Message) -> String {
        let mut body = vec![0];
        body.extend(u32::try_from(request.encoded_len()).unwrap().to_be_bytes());
        body.extend(request.encode_to_vec());
        let headers = format!(
            "content-type: application/grpc-web+proto\r\ngrpc-timeout: 300m\r\nauthorization: Bearer {token}\r\n"
        );
        self.gate.set(true);
        let answer = ask_at(&self.server, ("POST", &format!("/counterpoint.v1.{call}")), &headers, &body).await;
        self.gate.set(false);
        String::from_utf8_lossy(&answer).into_owned()
    }

    /// Closes or opens the disk.
    pub(crate) fn close(&self, closed: bool) {
        self.gate.set(closed);
    }

    /// Waits until a change is on the way to the closed disk.
    pub(crate) async fn held(&self) {
        self.gate.held.notified().await;
    }

    pub(crate) async fn submit(&self, id: &str, script: &str, options: v1::JobOptions) -> String {
        let submitted = self.caller.submit_with(id, "fanuc-2path-lathe", script, Some(options)).await;
        submitted.unwrap().job_id
    }

    async fn status(&self, job: &str) -> v1::JobStatus {
        let request = v1::GetJobRequest { job_id: job.into() };
        self.caller.jobs().get_job(request).await.unwrap().into_inner().status.unwrap()
    }

    /// Waits for the state of a job.
    pub(crate) async fn until(&self, job: &str, good: impl Fn(&v1::JobStatus) -> bool) {
        for _ in 0..4000 {
            if good(&self.status(job).await) {
                return;
            }
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
        panic!("{:?}", self.status(job).await);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_change_whose_client_leaves_is_made_whole_and_noted_with_its_job() {
    let folder = tempfile::tempdir().unwrap();
    let (options, audit) = audited(folder.path());
    let options = ServerOptions { workers: 1, ..options };
    let token = grant(&options, "one", "one", Role::Operate);
    let cut = Cut::start(options.clone(), &token).await;
    let plain = v1::JobOptions::default;
    let running = cut.submit("running", "EVENTS 9\nHANG", plain()).await;
    cut.until(&running, |status| status.state() == v1::JobState::Running).await;
    let waiting = cut.submit("waiting", "EVENTS 3", plain()).await;
    let held = cut.submit("held", "EVENTS 4", plain()).await;
    let mut expected = Vec::new();

    let (mut jobs, job_id) = (cut.caller.jobs(), held.clone());
    cut.call(async move { jobs.pause_job(v1::PauseJobRequest { job_id }).await }).await;
    cut.until(&held, |status| status.paused).await;
    expected.push(("Jobs/PauseJob", held.clone()));
    let (mut jobs, job_id) = (cut.caller.jobs(), waiting.clone());
    cut.call(async move { jobs.cancel_job(v1::CancelJobRequest { job_id }).await }).await;
    assert_eq!(cut.caller.wait(&waiting).await.state(), v1::JobState::Cancelled);
    expected.push(("Jobs/CancelJob", waiting.clone()));

    let mut changes = cut.caller.jobs().watch_jobs(v1::WatchJobsRequest::default()).await.unwrap().into_inner();
    let (mut jobs, job_id) = (cut.caller.jobs(), waiting.clone());
    cut.call(async move { jobs.delete_job(v1::DeleteJobRequest { job_id }).await }).await;
    let removed = async {
        let gone = |change: &v1::JobChange| {
            change.removed && change.status.as_ref().is_some_and(|status| status.job_id == waiting)
        };
        while !changes.message().await.unwrap().expect("more comes").changes.iter().any(gone) {}
    };
    tokio::time::timeout(Duration::from_secs(20), removed).await.expect("the watch hears of it");
    expected.push(("Jobs/DeleteJob", waiting.clone()));

    let (mut jobs, job_id) = (cut.caller.jobs(), running.clone());
    cut.call(async move { jobs.cancel_job(v1::CancelJobRequest { job_id }).await }).await;
    assert_eq!(cut.caller.wait(&running).await.state(), v1::JobState::Cancelled);
    expected.push(("Jobs/CancelJob", running.clone()));
    let (mut jobs, job_id) = (cut.caller.jobs(), held.clone());
    cut.call(async move { jobs.resume_job(v1::ResumeJobRequest { job_id }).await }).await;
    assert_eq!(cut.caller.wait(&held).await.state(), v1::JobState::Succeeded);
    expected.push(("Jobs/ResumeJob", held.clone()));

    let asking = cut.submit("asking", "ASK Clamp", v1::JobOptions { attended: true, ..plain() }).await;
    let watch = v1::WatchQuestionsRequest { job_id: asking.clone() };
    let mut questions = cut.caller.operator().watch_questions(watch).await.unwrap().into_inner();
    assert!(questions.message().await.unwrap().is_some());
    let (mut operator, job_id) = (cut.caller.operator(), asking.clone());
    let answer = Some(v1::DialogAnswer { button: "OK".into(), ..Default::default() });
    let answer = v1::AnswerQuestionRequest { job_id, question_id: 1, answer };
    cut.call(async move { operator.answer_question(answer).await }).await;
    assert_eq!(cut.caller.wait(&asking).await.state(), v1::JobState::Succeeded);
    expected.push(("Operator/AnswerQuestion", asking.clone()));

    let (mut jobs, job_id) = (cut.caller.jobs(), held.clone());
    let rerun = v1::RerunJobRequest { job_id, request_id: "again".into(), ..Default::default() };
    cut.call(async move { jobs.rerun_job(rerun).await }).await;
    let all = v1::ListJobsRequest { newest_first: true, ..Default::default() };
    let newest = async || cut.caller.jobs().list_jobs(all.clone()).await.unwrap().into_inner().jobs.remove(0);
    while newest().await.rerun_of != held {
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    expected.push(("Jobs/RerunJob", newest().await.job_id));
    cut.server.stop().await;
    let noted: Vec<_> = lines(&audit).into_iter().filter(|(.., code)| code == "Cancelled").collect();
    let noted: Vec<_> = noted.iter().map(|(_, call, target, _)| (call.as_str(), target.clone())).collect();
    assert_eq!(noted, expected);

    // The ledger has the states that the server has shown.
    let cut = Cut::start(options, &token).await;
    assert!(!cut.status(&held).await.paused);
    assert_eq!(cut.status(&running).await.state(), v1::JobState::Cancelled);
    cut.server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_audit_log_names_each_change_before_it_is_made() {
    let folder = tempfile::tempdir().unwrap();
    let (options, audit) = audited(folder.path());
    let token = grant(&options, "one", "one", Role::Operate);
    let cut = Cut::start(ServerOptions { workers: 1, ..options }, &token).await;
    let plain = v1::JobOptions::default;
    let running = cut.submit("running", "EVENTS 9\nHANG", plain()).await;
    cut.until(&running, |status| status.state() == v1::JobState::Running).await;
    let (a, b) = (cut.submit("a", "EVENTS 3", plain()).await, cut.submit("b", "EVENTS 4", plain()).await);
    let asked = |call: &str| -> Vec<String> {
        let asked = all_lines(&audit).into_iter().filter(|(_, name, _, code)| name == call && code == "Asked");
        asked.map(|(_, _, target, _)| target).collect()
    };
    let requests = ["request running", "request a", "request b"];
    assert_eq!(asked("Jobs/SubmitJob"), requests, "a job has no id before it is accepted");

    // A server that is killed while its disk holds the changes has written these lines.
    let queued = || Some(v1::JobFilter { states: vec![v1::JobState::Queued.into()], ..Default::default() });
    let mut jobs = cut.caller.jobs();
    let cancel = v1::CancelJobsRequest { filter: queued(), ..Default::default() };
    cut.gate.set(true);
    let call = tokio::spawn(async move { jobs.cancel_jobs(cancel).await });
    cut.gate.held.notified().await;
    assert_eq!(asked("Jobs/CancelJobs"), [b.as_str(), &a]);
    let outcomes = || lines(&audit).into_iter().filter(|(_, call, ..)| call == "Jobs/CancelJobs").count();
    assert_eq!(outcomes(), 0, "no change has been made");
    cut.gate.set(false);
    assert_eq!(call.await.unwrap().unwrap().into_inner().job_ids, [b.as_str(), &a]);
    assert_eq!(outcomes(), 2);

    let mut jobs = cut.caller.jobs();
    let all = v1::DeleteJobsRequest { all: true, ..Default::default() };
    let dry = v1::DeleteJobsRequest { dry_run: true, ..all.clone() };
    jobs.delete_jobs(dry).await.unwrap();
    assert!(asked("Jobs/DeleteJobs").is_empty(), "a dry run changes nothing");
    cut.gate.set(true);
    let call = tokio::spawn(async move { jobs.delete_jobs(all).await });
    cut.gate.held.notified().await;
    assert_eq!(asked("Jobs/DeleteJobs"), [b.as_str(), &a]);
    cut.gate.set(false);
    call.await.unwrap().unwrap();

    let (mut jobs, job_id) = (cut.caller.jobs(), running.clone());
    cut.call(async move { jobs.cancel_job(v1::CancelJobRequest { job_id }).await }).await;
    assert_eq!(asked("Jobs/CancelJob"), [running]);
    cut.server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_change_whose_deadline_passes_is_made_whole_and_noted_with_its_job() {
    let folder = tempfile::tempdir().unwrap();
    let (mut options, audit) = audited(folder.path());
    options.guard.grpc_web = true;
    let token = grant(&options, "one", "one", Role::Operate);
    let cut = Cut::start(ServerOptions { workers: 1, ..options }, &token).await;
    let plain = v1::JobOptions::default;
    let running = cut.submit("running", "EVENTS 9\nHANG", plain()).await;
    cut.until(&running, |status| status.state() == v1::JobState::Running).await;
    let held = cut.submit("held", "EVENTS 4", plain()).await;

    let answer = cut.late(&token, "Jobs/PauseJob", &v1::PauseJobRequest { job_id: held.clone() }).await;
    assert!(answer.contains("grpc-status: 4"), "{answer}");
    cut.until(&held, |status| status.paused).await;
    let rerun = v1::RerunJobRequest { job_id: held.clone(), request_id: "again".into(), ..Default::default() };
    cut.late(&token, "Jobs/RerunJob", &rerun).await;
    let all = v1::ListJobsRequest { newest_first: true, ..Default::default() };
    let newest = async || cut.caller.jobs().list_jobs(all.clone()).await.unwrap().into_inner().jobs.remove(0);
    while newest().await.rerun_of != held {
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    let again = newest().await.job_id;
    let cancel = v1::CancelJobsRequest { all: true, ..Default::default() };
    cut.late(&token, "Jobs/CancelJobs", &cancel).await;
    for job in [&running, &held, &again] {
        assert_eq!(cut.caller.wait(job).await.state(), v1::JobState::Cancelled);
    }
    let absent = v1::CancelJobRequest { job_id: "absent".into() };
    assert_eq!(cut.caller.jobs().cancel_job(absent).await.unwrap_err().code(), tonic::Code::NotFound);
    let line = |call: &str, target: &str| {
        let parts = ["one", call, target, "DeadlineExceeded"].map(str::to_owned);
        <(String, String, String, String)>::from(parts)
    };
    let expected = [
        line("Jobs/PauseJob", &held),
        line("Jobs/RerunJob", &again),
        line("Jobs/CancelJobs", &again),
        line("Jobs/CancelJobs", &held),
        line("Jobs/CancelJobs", &running),
    ];
    cut.server.stop().await;
    let late: Vec<_> = lines(&audit).into_iter().filter(|(.., code)| code == "DeadlineExceeded").collect();
    assert_eq!(late, expected);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_watch_shows_a_cancel_whose_run_has_not_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let options = guarded(folder.path());
    let token = grant(&options, "one", "one", Role::Operate);
    let cut = Cut::start(ServerOptions { workers: 1, ..options }, &token).await;
    let running = cut.submit("running", "EVENTS 9\nHANG", v1::JobOptions::default()).await;
    cut.until(&running, |status| status.state() == v1::JobState::Running).await;
    let request = v1::WatchJobRequest { job_id: running.clone(), heartbeat_ms: 100, ..Default::default() };
    let mut watch = cut.caller.jobs().watch_job(request).await.unwrap().into_inner();
    // The run is asked to stop once the cancel is durable.
    cut.gate.set(true);
    let (mut jobs, job_id) = (cut.caller.jobs(), running.clone());
    let cancel = tokio::spawn(async move { jobs.cancel_job(v1::CancelJobRequest { job_id }).await });
    cut.gate.held.notified().await;
    let shown = async {
        loop {
            let message = watch.message().await.unwrap().expect("the job runs");
            match message.content {
                Some(v1::watch_job_response::Content::Progress(now)) if now.cancel_requested => return now.state(),
                _ => {}
            }
        }
    };
    let state = tokio::time::timeout(Duration::from_secs(20), shown).await.expect("the watch shows the cancel");
    assert_eq!(state, v1::JobState::Running);
    assert!(cut.status(&running).await.cancel_requested);
    cut.gate.set(false);
    cancel.await.unwrap().unwrap();
    assert_eq!(cut.caller.wait(&running).await.state(), v1::JobState::Cancelled);
    cut.server.stop().await;
}
