//! Access control: tokens, roles, rates, the audit log, and addresses that strangers can reach.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

use counterpoint_proto::v1;
use counterpoint_server::access::{Role, token};
use counterpoint_server::local::disk::{Disk, DiskOperation, Faults};
use counterpoint_server::options::{Guard, ServerOptions, System};
use counterpoint_server::service;
use serde_json::Value;
use tonic::{Code, Status};
use tonic_health::pb::HealthCheckRequest;
use tonic_health::pb::health_client::HealthClient;
use tonic_types::StatusExt;

use crate::guarded::*;
use crate::support::*;

#[tokio::test]
async fn an_address_that_strangers_can_reach_needs_tls_and_identities() {
    let folder = tempfile::tempdir().unwrap();
    let open = |guard: Guard| ServerOptions { listen: "0.0.0.0:0".parse().unwrap(), guard, ..guarded(folder.path()) };
    let access = guarded(folder.path()).guard;
    for guard in [Guard::default(), access.clone()] {
        let error = service::build(open(guard)).await.unwrap_err().to_string();
        assert!(error.contains("--insecure") && error.contains("tls_cert"), "{error}");
    }
    assert!(!folder.path().join("data").exists(), "nothing is touched before that");
    let server = service::build(open(Guard { insecure: true, ..Guard::default() })).await.unwrap();
    assert!(server.handle().url().starts_with("http://0.0.0.0:"));
    let no_key = Guard { tls_key: "key.pem".into(), ..Guard::default() };
    assert!(service::build(open(no_key)).await.unwrap_err().to_string().contains("need tls_cert"));
}

#[tokio::test]
async fn without_a_file_of_identities_the_caller_on_loopback_is_the_administrator() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let anybody = As::new(&server, "whatever");
    let job = anybody.submit("r", "fanuc-2path-lathe", "EVENTS 3").await.unwrap().job_id;
    assert_eq!(As::nobody(&server).wait(&job).await.state(), v1::JobState::Succeeded);
    server.stop().await;
}

fn refused<T>(answer: Result<T, Status>) -> (Code, String) {
    answer.map(drop).map_err(|status| (status.code(), reason(&status))).unwrap_err()
}

#[tokio::test]
async fn each_role_may_do_what_it_is_for() {
    let folder = tempfile::tempdir().unwrap();
    let options = guarded(folder.path());
    let roles = [Role::Read, Role::Submit, Role::Operate, Role::Admin];
    let tokens = roles.map(|role| grant(&options, &role.to_string(), "t", role));
    let server = Server::start(options).await;
    let [read, submit, operate, admin] = tokens.map(|token| As::new(&server, &token));
    let denied = (Code::PermissionDenied, "PERMISSION_DENIED".to_owned());
    let job = submit.submit("r", "fanuc-2path-lathe", "EVENTS 3").await.unwrap().job_id;
    assert_eq!(read.wait(&job).await.state(), v1::JobState::Succeeded);
    assert_eq!(read.list().await, std::slice::from_ref(&job));
    assert_eq!(refused(read.submit("r2", "fanuc-2path-lathe", "EVENTS 3").await), denied);
    let cancel = v1::CancelJobRequest { job_id: job.clone() };
    assert_eq!(refused(read.jobs().cancel_job(cancel.clone()).await), denied);
    assert_eq!(refused(read.jobs().delete_job(v1::DeleteJobRequest { job_id: job.clone() }).await), denied);
    assert_eq!(refused(read.put_machine("own", "x").await), denied);
    submit.put_machine("own", "x").await.unwrap();
    let attend = || {
        let first = v1::attend_request::Content::JobId(job.clone());
        tokio_stream::iter([v1::AttendRequest { content: Some(first) }])
    };
    assert_eq!(refused(submit.operator().attend(attend()).await), denied);
    assert_eq!(refused(operate.operator().attend(attend()).await).1, "NOT_ATTENDED");
    assert_eq!(refused(admin.operator().attend(attend()).await).1, "NOT_ATTENDED");
    let debug = || {
        let first = v1::debug_request::Content::JobId(job.clone());
        tokio_stream::iter([v1::DebugRequest { content: Some(first) }])
    };
    assert_eq!(refused(submit.operator().debug(debug()).await), denied);
    assert_eq!(refused(operate.operator().debug(debug()).await).1, "NOT_STEPPED");
    admin.jobs().cancel_job(cancel).await.unwrap();

    let unknown = (Code::Unauthenticated, "UNAUTHENTICATED".to_owned());
    for stranger in [As::nobody(&server), As::new(&server, ""), As::new(&server, "cpt_00"), As::new(&server, "a.b.c")] {
        assert_eq!(refused(stranger.jobs().get_job(v1::GetJobRequest { job_id: job.clone() }).await), unknown);
        assert_eq!(refused(stranger.upload(b"x").await), unknown);
    }
    let health = HealthClient::new(server.connection.clone()).check(HealthCheckRequest::default()).await.unwrap();
    assert_eq!(health.into_inner().status, 1, "health needs no identity");
    server.stop().await;
}

#[tokio::test]
async fn a_revoked_token_is_refused_after_a_reload_and_a_broken_file_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let options = guarded(folder.path());
    let (old, access) = (grant(&options, "old", "t", Role::Read), options.guard.access.clone());
    let server = Server::start(options.clone()).await;
    let old = As::new(&server, &old);
    old.list().await;
    std::fs::write(&access, "[[token]]\nname = 1").unwrap();
    server.handle.reload();
    old.list().await;
    std::fs::write(&access, "").unwrap();
    let new = grant(&options, "new", "t", Role::Read);
    server.handle.reload();
    assert_eq!(refused(old.jobs().list_jobs(v1::ListJobsRequest::default()).await).1, "UNAUTHENTICATED");
    As::new(&server, &new).list().await;
    server.stop().await;
    std::fs::write(&access, "[[token]]\nname = 1").unwrap();
    let error = service::build(options).await.unwrap_err().to_string();
    assert!(error.contains("access.toml"), "{error}");
}

#[tokio::test]
async fn a_flood_of_a_stranger_has_few_lines_in_the_audit_log() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = guarded(folder.path());
    options.guard.audit = folder.path().join("audit.jsonl");
    let (audit, token) = (options.guard.audit.clone(), grant(&options, "one", "t", Role::Read));
    let server = Server::start(options).await;
    let (one, stranger) = (As::new(&server, &token), As::nobody(&server));
    for _ in 0..200 {
        stranger.jobs().list_jobs(v1::ListJobsRequest::default()).await.unwrap_err();
        let upload = one.blobs().find_missing(v1::FindMissingRequest::default()).await.unwrap_err();
        assert_eq!(upload.code(), Code::PermissionDenied);
    }
    server.stop().await;
    let log = std::fs::read_to_string(audit).unwrap();
    let lines = |code: &str| log.lines().filter(|line| line.contains(code)).count();
    assert_eq!((lines("Unauthenticated"), lines("PermissionDenied")), (10, 200), "those of an identity are all there");
    let count = |line: &str| serde_json::from_str::<serde_json::Value>(line).unwrap()["left_out"].as_u64();
    let left_out: Vec<_> = log.lines().filter_map(|line| Some((line, count(line)?))).collect();
    assert!(left_out.len() == 1 && left_out[0].1 == 190, "the others are counted when the server ends: {left_out:?}");
    assert!(left_out[0].0.contains(r#""peer":"127.0.0.1""#), "{left_out:?}");
}

/// Watches and waiting calls end within a second after their identity was revoked or has expired; jobs and the calls of
/// other identities continue.
#[tokio::test]
async fn open_calls_end_with_the_rights_of_their_identity() {
    let folder = tempfile::tempdir().unwrap();
    let options = guarded(folder.path());
    let access = options.guard.access.clone();
    let stays = grant(&options, "stays", "default", Role::Submit);
    let kept = std::fs::read_to_string(&access).unwrap();
    let revoked = grant(&options, "revoked", "default", Role::Operate);
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap().as_secs();
    let (expires, row) = token::create("expires", "default", Role::Read, Some(now + 2)).unwrap();
    let rows = std::fs::read_to_string(&access).unwrap() + &row;
    std::fs::write(&access, rows).unwrap();
    let server = Server::start(options).await;
    let [stays, revoked, expires] = [stays, revoked, expires].map(|token| As::new(&server, &token));
    let job = stays.submit("r", "fanuc-2path-lathe", "HANG").await.unwrap().job_id;
    let watch = async |caller: &As| {
        let request = v1::WatchJobRequest { job_id: job.clone(), heartbeat_ms: 100, ..Default::default() };
        caller.jobs().watch_job(request).await.unwrap().into_inner()
    };
    let (mut open, mut short, mut other) = (watch(&stays).await, watch(&expires).await, watch(&revoked).await);
    let mut many = revoked.jobs().watch_jobs(v1::WatchJobsRequest::default()).await.unwrap().into_inner();
    let mut waiting = revoked.jobs();
    let wait = v1::WaitJobRequest { job_id: job.clone(), timeout_ms: 60_000 };
    let waiting = tokio::spawn(async move { waiting.wait_job(wait).await.map(drop).unwrap_err() });
    let expired = loop {
        if let Err(status) = short.message().await {
            break status;
        }
    };
    assert_eq!((expired.code(), reason(&expired).as_str()), (Code::Unauthenticated, "UNAUTHENTICATED"));
    assert!(other.message().await.unwrap().is_some(), "another identity continues");
    let begin = std::time::Instant::now();
    std::fs::write(&access, kept).unwrap();
    server.handle.reload();
    let first = loop {
        if let Err(status) = other.message().await {
            break status;
        }
    };
    let second = loop {
        if let Err(status) = many.message().await {
            break status;
        }
    };
    for status in [first, second, waiting.await.unwrap()] {
        assert_eq!((status.code(), reason(&status).as_str()), (Code::Unauthenticated, "UNAUTHENTICATED"));
    }
    assert!(begin.elapsed() < Duration::from_secs(1), "{:?}", begin.elapsed());
    server.script.hang.store(false, std::sync::atomic::Ordering::SeqCst);
    while let Some(message) = open.message().await.unwrap() {
        if let Some(v1::watch_job_response::Content::Ended(status)) = message.content {
            assert_eq!(status.state(), v1::JobState::Succeeded);
        }
    }
    server.stop().await;
}

/// A lowered role ends only the calls that need a higher role.
#[tokio::test]
async fn open_calls_that_a_lowered_role_allows_continue() {
    let folder = tempfile::tempdir().unwrap();
    let options = guarded(folder.path());
    let access = options.guard.access.clone();
    let lowered = grant(&options, "lowered", "default", Role::Operate);
    let server = Server::start(options).await;
    let caller = As::new(&server, &lowered);
    let stepped = v1::JobOptions { stepped: true, ..Default::default() };
    let job = caller.submit_with("r", "fanuc-2path-lathe", "STEP a", Some(stepped)).await.unwrap().job_id;
    let request = v1::WatchJobRequest { job_id: job.clone(), heartbeat_ms: 100, ..Default::default() };
    let mut watch = caller.jobs().watch_job(request).await.unwrap().into_inner();
    let (send, receive) = tokio::sync::mpsc::channel(1);
    send.send(v1::DebugRequest { content: Some(v1::debug_request::Content::JobId(job)) }).await.unwrap();
    let receive = tokio_stream::wrappers::ReceiverStream::new(receive);
    let mut steps = caller.operator().debug(receive).await.unwrap().into_inner();
    assert!(steps.message().await.unwrap().is_some(), "the run has stopped");
    let rows = std::fs::read_to_string(&access).unwrap();
    std::fs::write(&access, rows.replace("operate", "read")).unwrap();
    server.handle.reload();
    let refused = steps.message().await.unwrap_err();
    assert_eq!((refused.code(), reason(&refused).as_str()), (Code::PermissionDenied, "PERMISSION_DENIED"));
    for _ in 0..10 {
        assert!(watch.message().await.unwrap().is_some(), "read is enough for a watch");
    }
    server.stop().await;
}

#[tokio::test]
async fn calls_beyond_the_rate_of_an_identity_are_refused_and_others_pass() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = guarded(folder.path());
    options.guard.max_calls_per_s = 5;
    let (one, other) = (grant(&options, "one", "t", Role::Read), grant(&options, "other", "t", Role::Read));
    let server = Server::start(options).await;
    let (one, other) = (As::new(&server, &one), As::new(&server, &other));
    // Its connection has several identities: it is never left unread for one of them.
    other.list().await;
    let mut calls = tokio::task::JoinSet::new();
    for _ in 0..100 {
        let one = one.clone();
        calls.spawn(async move { one.jobs().list_jobs(v1::ListJobsRequest::default()).await.map(drop) });
    }
    let answers = calls.join_all().await;
    let first = answers.into_iter().find_map(Result::err).expect("a hundred calls take less than nineteen seconds");
    assert_eq!((first.code(), reason(&first).as_str()), (Code::ResourceExhausted, "RATE_LIMITED"));
    let wait = first.get_error_details().retry_info().unwrap().retry_delay.unwrap();
    assert!(wait > Duration::from_secs(1) && wait <= Duration::from_millis(1200), "{wait:?}");
    other.list().await;
    server.stop().await;
}

#[tokio::test]
async fn the_audit_log_says_who_changed_what_and_who_was_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = guarded(folder.path());
    let audit = folder.path().join("audit.jsonl");
    options.guard.audit = audit.clone();
    let (ci, viewer) = (grant(&options, "ci", "t", Role::Submit), grant(&options, "viewer", "t", Role::Read));
    let server = Server::start(options).await;
    let caller = As::new(&server, &ci);
    let job = caller.submit("r", "fanuc-2path-lathe", "EVENTS 3").await.unwrap().job_id;
    caller.wait(&job).await;
    let rerun = v1::RerunJobRequest { job_id: job.clone(), request_id: "r-2".into(), ..Default::default() };
    let again = caller.jobs().rerun_job(rerun).await.unwrap().into_inner().status.unwrap().job_id;
    caller.wait(&again).await;
    let delete = v1::DeleteJobRequest { job_id: job.clone() };
    As::new(&server, &viewer).jobs().delete_job(delete.clone()).await.unwrap_err();
    As::nobody(&server).jobs().delete_job(delete.clone()).await.unwrap_err();
    std::fs::rename(&audit, folder.path().join("audit.1")).unwrap();
    server.handle.reload();
    caller.jobs().delete_job(delete.clone()).await.unwrap();
    caller.jobs().delete_job(delete).await.unwrap_err();
    server.stop().await;
    let read = |name: &str| -> Vec<Value> {
        let text = std::fs::read_to_string(folder.path().join(name)).unwrap();
        assert!(!text.contains(&ci), "no token is in it");
        let lines = text.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
        lines.filter(|line| line["code"] != "Asked").collect()
    };
    let row = |line: &Value| {
        let call = line["call"].as_str().unwrap().rsplit('/').next().unwrap().to_owned();
        format!("{} {} {} {}", line["identity"], call, line["target"], line["code"].as_str().unwrap())
    };
    let before: Vec<String> = read("audit.1").iter().map(row).collect();
    let expected = [
        format!("\"ci\" Upload \"{}\" Ok", digest(b"EVENTS 3")),
        format!("\"ci\" SubmitJob \"{job}\" Ok"),
        format!("\"ci\" RerunJob \"{again}\" Ok"),
        "\"viewer\" DeleteJob null PermissionDenied".to_owned(),
        "null DeleteJob null Unauthenticated".to_owned(),
    ];
    assert_eq!(before, expected);
    let after: Vec<String> = read("audit.jsonl").iter().map(row).collect();
    assert_eq!(after, [format!("\"ci\" DeleteJob \"{job}\" Ok"), format!("\"ci\" DeleteJob \"{job}\" NotFound")]);
    let line = &read("audit.jsonl")[0];
    assert_eq!((&line["tenant"], &line["role"]), (&"t".into(), &"submit".into()));
    assert!(line["time_ms"].is_u64() && line["peer"].as_str().unwrap().starts_with("127.0.0.1:"));
}

/// A disk that is blocked and counts the writes that wait for it.
#[derive(Default)]
struct Waited {
    blocked: AtomicBool,
    waiting: AtomicUsize,
}

impl Faults for Waited {
    fn before(&self, step: DiskOperation, _: &Path) -> std::io::Result<usize> {
        if step == DiskOperation::Sync && self.blocked.load(Ordering::SeqCst) {
            self.waiting.fetch_add(1, Ordering::SeqCst);
            while self.blocked.load(Ordering::SeqCst) {
                std::thread::sleep(Duration::from_millis(1));
            }
        }
        Ok(usize::MAX)
    }
}

/// Waits until something holds.
async fn until(what: &str, holds: impl Fn() -> bool) {
    for _ in 0..12_000 {
        if holds() {
            return;
        }
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    panic!("never: {what}");
}

/// A client that ends its submit before the answer cannot keep the job out of the audit log.
#[tokio::test(flavor = "multi_thread")]
async fn a_change_whose_client_goes_before_the_answer_is_in_the_audit_log() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = guarded(folder.path());
    let audit = folder.path().join("audit.jsonl");
    options.guard.audit = audit.clone();
    let token = grant(&options, "ci", "t", Role::Submit);
    let disk = Arc::new(Waited::default());
    let server = Server::start_on(options, Disk::faulty(disk.clone())).await;
    let caller = As::new(&server, &token);
    let digest = caller.upload(b"EVENTS 3").await.unwrap();
    let request = v1::SubmitJobRequest {
        request_id: "r".into(),
        machine: "fanuc-2path-lathe".into(),
        programs: vec![v1::Program { path: "main.nc".into(), ..Default::default() }],
        files: vec![v1::FileRef { path: "main.nc".into(), digest }],
        ..Default::default()
    };
    disk.blocked.store(true, Ordering::SeqCst);
    let submit = tokio::spawn({
        let caller = caller.clone();
        async move { caller.jobs().submit_job(request).await }
    });
    until("the submit waits for the disk", || disk.waiting.load(Ordering::SeqCst) > 0).await;
    submit.abort();
    // The server reads the end of the previous call first, because this call uses the same connection.
    caller.list().await;
    disk.blocked.store(false, Ordering::SeqCst);
    let line = || {
        let text = std::fs::read_to_string(&audit).unwrap();
        let lines = text.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
        lines.into_iter().find(|line| line["call"].as_str().unwrap().ends_with("/SubmitJob") && line["code"] != "Asked")
    };
    until("the call has a line", || line().is_some()).await;
    let line = line().unwrap();
    assert_eq!((&line["identity"], &line["code"]), (&"ci".into(), &"Cancelled".into()));
    let request = v1::ListJobsRequest::default();
    let mut jobs = Vec::new();
    while jobs.is_empty() {
        jobs = caller.jobs().list_jobs(request.clone()).await.unwrap().into_inner().jobs;
    }
    assert_eq!(line["target"], jobs[0].job_id.as_str());
    assert_eq!(caller.wait(&jobs[0].job_id).await.state(), v1::JobState::Succeeded, "the change was made");
    server.stop().await;
}

async fn said(caller: &As, job: &str) -> String {
    let request =
        v1::WatchJobRequest { job_id: job.into(), level: v1::WatchLevel::Everything.into(), ..Default::default() };
    let mut stream = caller.jobs().watch_job(request).await.unwrap().into_inner();
    let mut text = String::new();
    while let Some(message) = stream.message().await.unwrap() {
        if let Some(v1::watch_job_response::Content::Batch(batch)) = message.content {
            for event in batch.events {
                if let Some(v1::event::Kind::Diagnostic(diagnostic)) = event.kind {
                    text += &diagnostic.text;
                }
            }
        }
    }
    text
}

#[tokio::test]
async fn only_machines_that_an_administrator_has_put_there_may_start_commands() {
    let folder = tempfile::tempdir().unwrap();
    for allow_system in [false, true] {
        let data = folder.path().join(allow_system.to_string());
        std::fs::create_dir(&data).unwrap();
        let options = ServerOptions { system: System { allow_system, ..System::default() }, ..guarded(&data) };
        let (submit, admin) = (grant(&options, "s", "t", Role::Submit), grant(&options, "a", "t", Role::Admin));
        let server = Server::start(options).await;
        let (submit, admin) = (As::new(&server, &submit), As::new(&server, &admin));
        let own = submit.put_machine("own", "by a submitter").await.unwrap();
        admin.put_machine("trusted", "by an administrator").await.unwrap();
        let shipped = "fanuc-2path-lathe";
        for (machine, allowed) in [("own", false), ("trusted", allow_system), (shipped, allow_system)] {
            let job = submit.submit(machine, machine, "SYSTEM").await.unwrap().job_id;
            let expected = if allowed { "allowed" } else { "refused" };
            assert_eq!(said(&submit, &job).await, expected, "{machine}");
        }
        assert_eq!(refused(submit.put_machine("trusted", "replaced").await).1, "PERMISSION_DENIED");
        // The same files become trusted when an administrator puts them.
        assert_eq!(admin.put_machine("own", "by a submitter").await.unwrap().revision, own.revision);
        let job = submit.submit("again", "own", "SYSTEM").await.unwrap().job_id;
        assert_eq!(said(&submit, &job).await, if allow_system { "allowed" } else { "refused" });
        server.stop().await;
    }
}

/// Asks reflection of a version for the names of all services; returns the code of a refusal.
macro_rules! services {
    ($version:ident, $connection:expr, $bearer:expr) => {{
        use tonic_reflection::pb::$version as pb;
        let mut client =
            pb::server_reflection_client::ServerReflectionClient::with_interceptor($connection.clone(), $bearer);
        let message_request = Some(pb::server_reflection_request::MessageRequest::ListServices(String::new()));
        let request = pb::ServerReflectionRequest { message_request, ..Default::default() };
        let answer = match client.server_reflection_info(tokio_stream::iter([request])).await {
            Ok(mut answers) => answers.get_mut().message().await,
            Err(status) => Err(status),
        };
        answer.map_err(|status| status.code()).map(|answer| match answer.unwrap().message_response.unwrap() {
            pb::server_reflection_response::MessageResponse::ListServicesResponse(list) => {
                list.service.into_iter().map(|service| service.name).collect::<Vec<_>>()
            }
            other => panic!("{other:?}"),
        })
    }};
}

#[tokio::test]
async fn reflection_can_be_switched_off_and_needs_an_identity() {
    let folder = tempfile::tempdir().unwrap();
    for reflection in [true, false] {
        let mut options = guarded(folder.path());
        options.guard.reflection = reflection;
        let token = grant(&options, "r", "t", Role::Read);
        let server = Server::start(options).await;
        let known = Bearer(Some(token));
        let named = [services!(v1, server.connection, known.clone()), services!(v1alpha, server.connection, known)];
        for services in named {
            match services {
                Ok(names) => {
                    assert!(reflection && names.iter().any(|name| name == "counterpoint.v1.Jobs"), "{names:?}")
                }
                Err(code) => assert!(!reflection && code == Code::Unimplemented, "{code:?}"),
            }
        }
        for unknown in
            [services!(v1, server.connection, Bearer(None)), services!(v1alpha, server.connection, Bearer(None))]
        {
            assert_eq!(unknown, Err(Code::Unauthenticated));
        }
        server.stop().await;
    }
}

/// Names of the tests in a source that are not ignored.
fn tests_of(source: &str) -> BTreeSet<String> {
    let (mut names, mut is_test, mut ignored) = (BTreeSet::new(), false, false);
    for line in source.lines().map(str::trim_start) {
        if line.starts_with("#[") {
            is_test |= line.starts_with("#[test]") || line.starts_with("#[tokio::test");
            ignored |= line.starts_with("#[ignore");
            continue;
        }
        let head = line.strip_prefix("async ").unwrap_or(line).strip_prefix("fn ");
        let name = head.and_then(|head| head.split('(').next()).filter(|_| is_test && !ignored);
        names.extend(name.map(str::to_owned));
        (is_test, ignored) = (false, false);
    }
    names
}

/// Every row of the threat model names tests that are there and run.
#[test]
fn the_threat_model_names_its_tests() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut tests = BTreeSet::new();
    let mut folders = ["server/src", "server/tests", "client-cli/tests", "kernel"].map(|name| root.join(name)).to_vec();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|kind| kind == "rs") {
                tests.extend(tests_of(&std::fs::read_to_string(path).unwrap()));
            }
        }
    }
    let text = std::fs::read_to_string(root.join("docs/security.md")).unwrap();
    let rows = text.split_once("| who | what |").unwrap().1.lines().skip(2).take_while(|line| line.starts_with('|'));
    let mut count = 0;
    for row in rows {
        let named = row.trim_end_matches(['|', ' ']).rsplit('|').next().unwrap();
        let names: Vec<&str> = named.split('`').skip(1).step_by(2).collect();
        assert!(!names.is_empty(), "no test: {row}");
        for name in names {
            assert!(tests.contains(name), "`cargo test` runs no test {name}");
        }
        count += 1;
    }
    assert!(count >= 40, "{count} rows");
}

/// Calls without a known identity are answered at the rate of their address; those of a known one always are.
#[tokio::test]
async fn refused_calls_of_an_address_are_limited_and_known_callers_of_it_pass() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = guarded(folder.path());
    options.guard.max_refused_per_s = 5;
    let token = grant(&options, "known", "t", Role::Read);
    let server = Server::start(options).await;
    let strange = tonic::transport::Endpoint::from_shared(server.handle.url()).unwrap().connect().await.unwrap();
    let list = || v1::ListJobsRequest::default();
    let mut reasons = Vec::new();
    let begin = std::time::Instant::now();
    for bearer in std::iter::repeat_n([None, Some("guessed".to_owned())], 6).flatten() {
        let stranger = As { connection: strange.clone(), bearer: Bearer(bearer) };
        let refused = stranger.jobs().list_jobs(list()).await.unwrap_err();
        let wait = refused.get_error_details().retry_info().and_then(|info| info.retry_delay);
        assert_eq!(reason(&refused) == "RATE_LIMITED", wait.is_some());
        reasons.push(reason(&refused));
        // The same address, another connection.
        As::new(&server, &token).jobs().list_jobs(list()).await.unwrap();
    }
    assert!(reasons[..5].iter().all(|reason| reason == "UNAUTHENTICATED"), "{reasons:?}");
    let limited = reasons.iter().filter(|reason| *reason == "RATE_LIMITED").count();
    assert!(limited >= 1 && begin.elapsed() >= std::time::Duration::from_millis(150), "{reasons:?}");
    server.stop().await;
}
