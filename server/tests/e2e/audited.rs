//! The audit log of every call that changes something.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use counterpoint_proto::v1;
use counterpoint_server::access::Role;
use counterpoint_server::options::ServerOptions;
use serde_json::Value;

use crate::contract::*;
use crate::guarded::*;
use crate::support::*;

const LATHE: &str = "fanuc-2path-lathe";

/// Options of a server with an audit log, and its file.
pub fn audited(folder: &Path) -> (ServerOptions, PathBuf) {
    let mut options = guarded(folder);
    let audit = folder.join("audit.jsonl");
    options.guard.audit = audit.clone();
    (options, audit)
}

/// The lines about outcomes: identity, call, target and code.
pub fn lines(audit: &Path) -> Vec<(String, String, String, String)> {
    all_lines(audit).into_iter().filter(|(.., code)| code != "Asked").collect()
}

/// All lines of a log, with the same fields.
pub fn all_lines(audit: &Path) -> Vec<(String, String, String, String)> {
    let text = std::fs::read_to_string(audit).unwrap();
    let of = |line: &Value, key: &str| line[key].as_str().unwrap_or_default().to_owned();
    let line = |line: &str| {
        let line: Value = serde_json::from_str(line).unwrap();
        let call = of(&line, "call").trim_start_matches("/counterpoint.v1.").to_owned();
        (of(&line, "identity"), call, of(&line, "target"), of(&line, "code"))
    };
    text.lines().map(line).collect()
}

/// Changing calls of one identity; each is logged with its target.
struct Making {
    caller: As,
    /// Call and target.
    made: Vec<(&'static str, String)>,
}

impl Making {
    fn made(&mut self, call: &'static str, target: &str) {
        self.made.push((call, target.to_owned()));
    }

    async fn submit(&mut self, request_id: &str, script: &str, options: v1::JobOptions) -> String {
        let job = self.caller.submit_with(request_id, LATHE, script, Some(options)).await.unwrap().job_id;
        self.made("Blobs/Upload", &digest(script.as_bytes()));
        self.made("Jobs/SubmitJob", &job);
        job
    }

    async fn files_and_machines(&mut self) {
        let caller = self.caller.clone();
        let text = "extends = \"fanuc-mill\"\n[ce]\nname = \"own\"\n";
        let digest = digest(text.as_bytes());
        let find = v1::FindMissingRequest { digests: vec![digest.clone()] };
        caller.blobs().find_missing(find).await.unwrap();
        self.made("Blobs/FindMissing", "");
        caller.blobs().put_blob(v1::PutBlobRequest { data: text.into() }).await.unwrap();
        self.made("Blobs/PutBlob", &digest);
        let files = vec![v1::MachineFile { path: "own/machine.toml".into(), digest }];
        let check = v1::CheckMachineRequest { name: "own".into(), files: files.clone() };
        caller.machines().check_machine(check).await.unwrap();
        self.made("Machines/CheckMachine", "own");
        caller.machines().put_machine(v1::PutMachineRequest { name: "own".into(), files }).await.unwrap();
        self.made("Machines/PutMachine", "own");
        caller.machines().delete_machine(v1::DeleteMachineRequest { name: "own".into() }).await.unwrap();
        self.made("Machines/DeleteMachine", "own");
    }

    async fn operator(&mut self) {
        let caller = self.caller.clone();
        let attended = v1::JobOptions { attended: true, ..Default::default() };
        let job = self.submit("attended", "ASK who", attended).await;
        let watch = v1::WatchQuestionsRequest { job_id: job.clone() };
        let mut questions = caller.operator().watch_questions(watch).await.unwrap().into_inner();
        self.made("Operator/WatchQuestions", &job);
        assert!(questions.message().await.unwrap().is_some(), "the job asks");
        let answer = Some(v1::DialogAnswer { button: "OK".into(), ..Default::default() });
        let answer = v1::AnswerQuestionRequest { job_id: job.clone(), question_id: 1, answer };
        assert!(caller.operator().answer_question(answer).await.unwrap().into_inner().accepted);
        self.made("Operator/AnswerQuestion", &job);
        caller.wait(&job).await;
        let first = v1::AttendRequest { content: Some(v1::attend_request::Content::JobId(job.clone())) };
        caller.operator().attend(tokio_stream::iter([first])).await.unwrap();
        self.made("Operator/Attend", &job);
        let stepped = v1::JobOptions { stepped: true, ..Default::default() };
        let job = self.submit("stepped", "STEP here", stepped).await;
        let first = v1::DebugRequest { content: Some(v1::debug_request::Content::JobId(job.clone())) };
        caller.operator().debug(tokio_stream::iter([first])).await.unwrap();
        self.made("Operator/Debug", &job);
        caller.jobs().cancel_job(v1::CancelJobRequest { job_id: job.clone() }).await.unwrap();
        self.made("Jobs/CancelJob", &job);
    }

    async fn jobs(&mut self) {
        let mut jobs = self.caller.jobs();
        let job = self.submit("running", "HANG", v1::JobOptions::default()).await;
        jobs.pause_job(v1::PauseJobRequest { job_id: job.clone() }).await.unwrap();
        self.made("Jobs/PauseJob", &job);
        jobs.resume_job(v1::ResumeJobRequest { job_id: job.clone() }).await.unwrap();
        self.made("Jobs/ResumeJob", &job);
        let labels = [("again".to_owned(), "yes".to_owned())];
        let mut again = Vec::new();
        for request_id in ["first", "second"] {
            let (job_id, labels) = (job.clone(), labels.clone().into());
            let rerun = v1::RerunJobRequest { job_id, request_id: request_id.into(), labels, ..Default::default() };
            again.push(jobs.rerun_job(rerun).await.unwrap().into_inner().status.unwrap().job_id);
            self.made("Jobs/RerunJob", again.last().unwrap());
        }
        let filter = Some(v1::JobFilter { labels: labels.into(), ..Default::default() });
        jobs.cancel_jobs(v1::CancelJobsRequest { filter: filter.clone(), ..Default::default() }).await.unwrap();
        // The newest job comes first.
        again.iter().rev().for_each(|job| self.made("Jobs/CancelJobs", job));
        for job in &again {
            self.caller.wait(job).await;
        }
        jobs.delete_jobs(v1::DeleteJobsRequest { filter, ..Default::default() }).await.unwrap();
        again.iter().rev().for_each(|job| self.made("Jobs/DeleteJobs", job));
        jobs.cancel_job(v1::CancelJobRequest { job_id: job.clone() }).await.unwrap();
        self.made("Jobs/CancelJob", &job);
        self.caller.wait(&job).await;
        jobs.delete_job(v1::DeleteJobRequest { job_id: job.clone() }).await.unwrap();
        self.made("Jobs/DeleteJob", &job);
    }
}

/// Calls that need more than the role `read`.
fn changing() -> BTreeSet<&'static str> {
    ROLES.iter().filter(|(role, _)| *role > Role::Read).flat_map(|(_, calls)| calls.iter().copied()).collect()
}

/// Every changing call has a line with caller, call, target and outcome, whether it succeeds or is refused.
#[tokio::test]
async fn every_call_that_changes_something_is_in_the_audit_log_with_its_target() {
    let folder = tempfile::tempdir().unwrap();
    let (options, audit) = audited(folder.path());
    let (root, viewer) = (grant(&options, "root", "t", Role::Admin), grant(&options, "viewer", "t", Role::Read));
    let mut server = Server::start(options).await;
    let viewer = As::new(&server, &viewer);
    for call in changing() {
        ask(&viewer, &path(call), Vec::new()).await.expect_err(call);
    }
    let mut making = Making { caller: As::new(&server, &root), made: Vec::new() };
    making.files_and_machines().await;
    making.operator().await;
    making.jobs().await;
    for (role, calls) in ROLES {
        for call in calls.iter().filter(|_| role == Role::Admin) {
            ask(&making.caller, &path(call), Vec::new()).await.unwrap();
            making.made(call, "");
        }
    }
    (&mut server.task).await.unwrap();
    assert_eq!(making.made.iter().map(|(call, _)| *call).collect::<BTreeSet<_>>(), changing(), "each is made");
    let line =
        |identity: &str, call: &str, target: &str, code: &str| [identity, call, target, code].map(str::to_owned).into();
    let refused = changing().into_iter().map(|call| line("viewer", call, "", "PermissionDenied"));
    let made = making.made.iter().map(|(call, target)| line("root", call, target, "Ok"));
    assert_eq!(lines(&audit), refused.chain(made).collect::<Vec<_>>());
}

/// An administrator sees why a token was refused; no content of a file is in the log.
#[tokio::test]
async fn a_refused_call_has_its_reason_in_the_audit_log() {
    let folder = tempfile::tempdir().unwrap();
    let (options, audit) = audited(folder.path());
    let (submit, read) = (grant(&options, "ci", "t", Role::Submit), grant(&options, "viewer", "t", Role::Read));
    let server = Server::start(options).await;
    for token in ["cpt_unknown", &read, &submit] {
        let caller = As::new(&server, token);
        let files = vec![v1::MachineFile { path: "own/machine.toml".into(), digest: digest(b"absent") }];
        let put = v1::PutMachineRequest { name: "own".into(), files };
        caller.machines().put_machine(put).await.unwrap_err();
    }
    server.stop().await;
    let text = std::fs::read_to_string(&audit).unwrap();
    let reasons: Vec<String> = text
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).unwrap()["reason"].as_str().unwrap().to_owned())
        .collect();
    assert_eq!(reasons.len(), 3, "{text}");
    assert!(reasons[0].contains("the token is not known"), "{text}");
    assert!(reasons[1].contains("submit"), "the role that the call needs: {text}");
    assert_eq!(reasons[2], "MISSING_BLOBS", "{text}");
}

/// Ids and names of the client may be long; the log stays small.
#[tokio::test]
async fn a_long_target_and_a_long_path_are_cut_in_the_audit_log() {
    let folder = tempfile::tempdir().unwrap();
    let (options, audit) = audited(folder.path());
    let token = grant(&options, "ci", "t", Role::Submit);
    let server = Server::start(options).await;
    let caller = As::new(&server, &token);
    for letter in ["x", "ü"] {
        let first = v1::UploadRequest { digest: letter.repeat(5000), ..Default::default() };
        let refused = caller.blobs().upload(tokio_stream::iter([first])).await.unwrap_err();
        assert_eq!(reason(&refused), "INVALID_REQUEST");
    }
    let long = format!("/counterpoint.v1.Jobs/{}", "y".repeat(5000));
    assert_eq!(reason(&ask(&caller, &long, Vec::new()).await.unwrap_err()), "UNKNOWN_CALL");
    server.stop().await;
    let upload = |letter: &str| ("Blobs/Upload".to_owned(), letter.repeat(128));
    let path = long[..128].trim_start_matches("/counterpoint.v1.").to_owned();
    let noted: Vec<_> = lines(&audit).into_iter().map(|(_, call, target, _)| (call, target)).collect();
    assert_eq!(noted, [upload("x"), upload("ü"), (path, String::new())]);
}
