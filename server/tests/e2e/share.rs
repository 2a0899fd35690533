//! Shares of tenants: turns, quotas, places in the queue; priorities and deadlines of jobs.

use std::collections::BTreeMap;
use std::sync::atomic::Ordering;
use std::time::{SystemTime, UNIX_EPOCH};

use counterpoint_proto::v1;
use counterpoint_proto::v1::watch_job_response::Content;
use counterpoint_server::access::Role;
use counterpoint_server::options::{OptionTables, Quotas, ServerOptions, Tenant};
use tonic::{Code, Status};
use tonic_types::StatusExt;

use crate::descriptors::Process;
use crate::floods::{Flood, flood};
use crate::guarded::*;
use crate::support::*;

const LATHE: &str = "fanuc-2path-lathe";

/// A server with two tenants.
async fn two(options: ServerOptions) -> (Server, As, As) {
    let tokens = [grant(&options, "n", "noisy", Role::Submit), grant(&options, "q", "quiet", Role::Submit)];
    let server = Server::start(options).await;
    let [noisy, quiet] = tokens.map(|token| As::new(&server, &token));
    (server, noisy, quiet)
}

/// Submits this many jobs at once; returns their identities in the order of acceptance.
async fn many(caller: &As, name: &str, script: &str, count: usize) -> Vec<String> {
    caller.upload(script.as_bytes()).await.unwrap();
    let mut calls = tokio::task::JoinSet::new();
    for number in 0..count {
        let (caller, request_id) = (caller.clone(), format!("{name}-{number}"));
        let request = v1::SubmitJobRequest {
            request_id,
            machine: LATHE.into(),
            programs: vec![v1::Program { path: "main.nc".into(), ..Default::default() }],
            files: vec![v1::FileRef { path: "main.nc".into(), digest: digest(script.as_bytes()) }],
            ..Default::default()
        };
        calls
            .spawn(async move { caller.jobs().submit_job(request).await.unwrap().into_inner().status.unwrap().job_id });
    }
    let mut ids = calls.join_all().await;
    ids.sort();
    ids
}

fn quota(status: &Status) -> String {
    assert_eq!((status.code(), reason(status).as_str()), (Code::ResourceExhausted, "QUOTA_EXCEEDED"));
    let details = status.get_error_details();
    let violation = &details.quota_failure().unwrap().violations[0];
    assert_eq!(violation.subject, "tenant:noisy");
    let metadata = &details.error_info().unwrap().metadata;
    let (name, limit) = (metadata["quota"].clone(), &metadata["limit"]);
    let (begin, remedy) = (format!("the quota {name} is {limit}: "), ["submit again", "upload again", "delete"]);
    let text = &violation.description;
    assert!(text.starts_with(&begin) && remedy.iter().any(|part| text.contains(part)), "{text}");
    name
}

#[tokio::test]
async fn a_queue_of_thousands_of_one_tenant_does_not_delay_the_job_of_another() {
    let folder = tempfile::tempdir().unwrap();
    let (server, noisy, quiet) = two(ServerOptions { workers: 1, queue: 5000, ..guarded(folder.path()) }).await;
    let endless = noisy.submit("endless", LATHE, "HANG").await.unwrap().job_id;
    server_until(&noisy, &endless, v1::JobState::Running).await;
    let queue = many(&noisy, "n", "EVENTS 1", 2000).await;
    // The one worker hangs in a job of the other tenant.
    let own = quiet.submit("q", LATHE, "EVENTS 3").await.unwrap().job_id;
    assert_eq!(quiet.wait(&own).await.state(), v1::JobState::Succeeded);
    let waiting = v1::ListJobsRequest { states: vec![v1::JobState::Queued.into()], ..Default::default() };
    let page = noisy.jobs().list_jobs(waiting).await.unwrap().into_inner();
    assert_eq!(page.jobs.len(), 50, "none of them had to run before");
    server.script.hang.store(false, Ordering::SeqCst);
    // Beside a queue that moves, a job waits for about a turn of each tenant.
    let own = quiet.submit("q-2", LATHE, "EVENTS 3").await.unwrap().job_id;
    let own = quiet.wait(&own).await;
    let last = noisy.wait(&queue[queue.len() - 1]).await;
    assert!(own.ended_ms <= last.ended_ms, "{} {}", own.ended_ms, last.ended_ms);
    server.stop().await;
}

/// Jobs of a caller that wait, up to a page of them.
async fn waiting(caller: &As) -> usize {
    let states = vec![v1::JobState::Queued.into()];
    let request = v1::ListJobsRequest { states, page_size: 500, ..Default::default() };
    caller.jobs().list_jobs(request).await.unwrap().into_inner().jobs.len()
}

/// One identity has endless jobs on all workers, ten thousand in the queue, its quota full, and floods the server with
/// frames; the other one does its work beside that, sees nothing of it and stops nothing.
#[tokio::test]
async fn neither_of_two_identities_slows_sees_or_stops_the_other_under_load() {
    const QUEUE: usize = 10_000;
    let folder = tempfile::tempdir().unwrap();
    let quotas = Quotas { tenant_queued: QUEUE, ..Quotas::default() };
    let (server, noisy, quiet) = two(ServerOptions { queue: QUEUE + 100, quotas, ..guarded(folder.path()) }).await;
    let mut endless = Vec::new();
    for number in 0..2 {
        let job = noisy.submit(&format!("endless-{number}"), LATHE, "EVENTS 1\nHANG").await.unwrap().job_id;
        server_until(&noisy, &job, v1::JobState::Running).await;
        endless.push(job);
    }
    let queue = many(&noisy, "n", "EVENTS 1", QUEUE).await;
    assert_eq!(quota(&noisy.submit("more", LATHE, "EVENTS 1").await.unwrap_err()), "tenant_queued");
    let address = server.handle.address().to_string();
    let mut floods = tokio::task::JoinSet::new();
    for kind in Flood::ALL {
        let (address, job) = (address.clone(), endless[0].clone());
        floods.spawn(async move { flood(&address, &job, kind).await });
    }
    // No job of the queue takes a turn, and every worker is taken: those of the other tenant run all the same.
    for number in 0..10 {
        let own = quiet.submit(&format!("q-{number}"), LATHE, "EVENTS 3").await.unwrap().job_id;
        assert_eq!(quiet.wait(&own).await.state(), v1::JobState::Succeeded);
    }
    floods.join_all().await;
    let first = v1::GetJobRequest { job_id: queue[0].clone() };
    let first = noisy.jobs().get_job(first).await.unwrap().into_inner().status.unwrap();
    assert_eq!((first.state(), first.attempt), (v1::JobState::Queued, 0));
    assert_eq!((quiet.list().await.len(), waiting(&quiet).await), (10, 0), "it sees its own jobs only");
    for job in [&endless[0], &queue[0]] {
        let cancel = v1::CancelJobRequest { job_id: job.clone() };
        let pause = v1::PauseJobRequest { job_id: job.clone() };
        assert_eq!(quiet.jobs().cancel_job(cancel).await.unwrap_err().code(), Code::NotFound);
        assert_eq!(quiet.jobs().pause_job(pause).await.unwrap_err().code(), Code::NotFound);
    }
    // Now the queue moves. In the order of acceptance alone, the first of these would end after all of it.
    server.script.hang.store(false, Ordering::SeqCst);
    for number in 10..20 {
        let own = quiet.submit(&format!("q-{number}"), LATHE, "EVENTS 3").await.unwrap().job_id;
        assert_eq!(quiet.wait(&own).await.state(), v1::JobState::Succeeded);
    }
    assert!(waiting(&noisy).await > 0, "ten turns of the one take fewer than the queue of the other");
    // And in the opposite direction: the jobs of the first continue while the second waits for something.
    server.script.hang.store(true, Ordering::SeqCst);
    for number in 0..2 {
        let own = quiet.submit(&format!("hang-{number}"), LATHE, "HANG").await.unwrap().job_id;
        server_until(&quiet, &own, v1::JobState::Running).await;
    }
    assert_eq!(noisy.wait(&queue[QUEUE / 2]).await.state(), v1::JobState::Succeeded);
    server.script.hang.store(false, Ordering::SeqCst);
    server.stop().await;
}

/// Times of the first channel of a job as its watch shows them, until they stop or move as wanted.
async fn until_it(caller: &As, job: &str, moves: bool) {
    let request = v1::WatchJobRequest { job_id: job.into(), heartbeat_ms: 100, ..Default::default() };
    let mut watch = caller.jobs().watch_job(request).await.unwrap().into_inner();
    let (mut last, mut same) = (None, 0);
    for _ in 0..600 {
        let message = tokio::time::timeout(std::time::Duration::from_secs(20), watch.message()).await.unwrap();
        let Some(Content::Progress(progress)) = message.unwrap().unwrap().content else { continue };
        let now = progress.channels.first().map(|channel| channel.t_ns);
        same = if now == last { same + 1 } else { 0 };
        if last.is_some() && now.is_some() && (moves && same == 0 || !moves && same == 5) {
            return;
        }
        last = now;
    }
    panic!("{job} never did: moves {moves}");
}

/// On the real server: two endless jobs of one tenant have all cores until another tenant has a job, too.
#[tokio::test]
async fn the_second_job_of_a_tenant_stands_while_another_tenant_needs_its_core() {
    // However fast the server is, it computes for minutes before its time, its blocks or its log reach a limit.
    const ENDLESS: &str = "O1\nN1 #1=0\nWHILE[#1LT100]DO1\n#1=#1+1\nEND1\nG1 X.001 F100.\nX0.\nGOTO 1\n";
    const HOUR_NS: i64 = 3_600_000_000_000;
    let limits = v1::JobLimits { simulated_ns: 1000 * HOUR_NS, blocks: 10_000_000_000, ..Default::default() };
    let limits = Some(limits);
    let folder = tempfile::tempdir().unwrap();
    let options = guarded(folder.path());
    let tokens = [grant(&options, "n", "noisy", Role::Submit), grant(&options, "q", "quiet", Role::Submit)];
    let access = options.guard.access.to_str().unwrap();
    let server = Process::start_with(folder.path(), &["--workers", "2", "--access", access]);
    let endpoint = tonic::transport::Endpoint::from_shared(format!("http://{}", server.address)).unwrap();
    let connection = endpoint.connect().await.unwrap();
    let [noisy, quiet] = tokens.map(|token| As { connection: connection.clone(), bearer: Bearer(Some(token)) });
    let (mut jobs, mut own) = (Vec::new(), Vec::new());
    for number in 0..2 {
        let id = format!("n-{number}");
        jobs.push(noisy.submit_limited(&id, "fanuc-mill", ENDLESS, limits).await.unwrap().job_id);
        until_it(&noisy, &jobs[number], true).await;
    }
    for number in 0..2 {
        let id = format!("q-{number}");
        own.push(quiet.submit_limited(&id, "fanuc-mill", ENDLESS, limits).await.unwrap().job_id);
        until_it(&quiet, &own[0], true).await;
        until_it(&noisy, &jobs[1], false).await;
        until_it(&noisy, &jobs[0], true).await;
        if number == 0 {
            quiet.jobs().cancel_job(v1::CancelJobRequest { job_id: own.remove(0) }).await.unwrap();
            until_it(&noisy, &jobs[1], true).await;
        }
    }
    // A stopped job ends like any other on request.
    noisy.jobs().cancel_job(v1::CancelJobRequest { job_id: jobs[1].clone() }).await.unwrap();
    assert_eq!(noisy.wait(&jobs[1]).await.state(), v1::JobState::Cancelled);
}

#[tokio::test]
async fn a_tenant_with_a_table_of_its_own_has_its_quota_and_the_others_that_of_all() {
    let folder = tempfile::tempdir().unwrap();
    let quotas = Quotas { tenant_queued: 4, ..Quotas::default() };
    let own = Tenant { queued: Some(2), uploads: Some(1), ..Tenant::default() };
    let tenants = BTreeMap::from([("noisy".to_owned(), own)]);
    let tables = OptionTables { tenants, ..OptionTables::default() };
    let (server, noisy, quiet) = two(ServerOptions { workers: 1, quotas, tables, ..guarded(folder.path()) }).await;
    for (caller, name, most) in [(&noisy, "n", 2), (&quiet, "q", 4)] {
        let running = caller.submit(&format!("{name}-runs"), LATHE, "HANG").await.unwrap().job_id;
        server_until(caller, &running, v1::JobState::Running).await;
        many(caller, name, "EVENTS 1", most).await;
        let refused = caller.submit(&format!("{name}-more"), LATHE, "EVENTS 1").await.unwrap_err();
        assert_eq!(refused.get_error_details().error_info().unwrap().metadata["quota"], "tenant_queued");
        assert_eq!(waiting(caller).await, most);
    }
    server.script.hang.store(false, Ordering::SeqCst);
    server.stop().await;
}

/// On the real server: the file gives the quotas of a tenant, and a file with an error changes nothing.
#[tokio::test]
async fn tables_of_tenants_are_read_again_on_sighup() {
    const ENDLESS: &str = "O1\nN1 G4 P1\nGOTO 1\n";
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("counterpoint.toml");
    std::fs::write(&file, "[tenants.default]\nqueued = 1\nrunning = 1\n").unwrap();
    let server = Process::start_with(folder.path(), &["--workers", "2", "--config", file.to_str().unwrap()]);
    let hang_up = |text: &str| {
        std::fs::write(&file, text).unwrap();
        let process = rustix::process::Pid::from_raw(i32::try_from(server.child.id()).unwrap()).unwrap();
        rustix::process::kill_process(process, rustix::process::Signal::HUP).unwrap();
    };
    let endpoint = tonic::transport::Endpoint::from_shared(format!("http://{}", server.address)).unwrap();
    let caller = As { connection: endpoint.connect().await.unwrap(), bearer: Bearer(None) };
    let limit = |status: Status| status.get_error_details().error_info().unwrap().metadata["limit"].clone();
    let running = caller.submit("runs", "fanuc-mill", ENDLESS).await.unwrap().job_id;
    server_until(&caller, &running, v1::JobState::Running).await;
    let first = caller.submit("waits-1", "fanuc-mill", ENDLESS).await.unwrap().job_id;
    assert_eq!(limit(caller.submit("waits-2", "fanuc-mill", ENDLESS).await.unwrap_err()), "1");
    hang_up("[tenants.default]\nqueued = 2\nrunning = 1\n");
    server.until("tables of tenants read again").await;
    caller.submit("waits-2", "fanuc-mill", ENDLESS).await.unwrap();
    hang_up("[tenants.default]\nqueue = 9\n");
    server.until("tables of tenants cannot be read again").await;
    assert_eq!(limit(caller.submit("waits-3", "fanuc-mill", ENDLESS).await.unwrap_err()), "2");
    assert_eq!(waiting(&caller).await, 2, "the second worker is not for this tenant");
    hang_up("queue = 9\n[tenants.default]\nqueued = 2\nrunning = 1\n");
    let line = server.until("other options of the file have changed: they take effect at a restart").await;
    assert!(line.contains("WARN") && line.contains("options=\"queue\""), "{line}");
    hang_up("");
    // Without a table of its own it has the quotas for all: the second worker, too.
    server_until(&caller, &first, v1::JobState::Running).await;
}

pub async fn server_until(caller: &As, job: &str, state: v1::JobState) {
    for _ in 0..6000 {
        let get = v1::GetJobRequest { job_id: job.into() };
        if caller.jobs().get_job(get).await.unwrap().into_inner().status.unwrap().state() == state {
            return;
        }
        tokio::time::sleep(std::time::Duration::from_millis(5)).await;
    }
    panic!("{job} never became {state:?}");
}

#[tokio::test]
async fn a_tenant_that_fills_the_queue_leaves_places_for_others() {
    let folder = tempfile::tempdir().unwrap();
    let (server, noisy, quiet) = two(ServerOptions { workers: 1, queue: 20, ..guarded(folder.path()) }).await;
    let running = noisy.submit("endless", LATHE, "HANG").await.unwrap().job_id;
    server_until(&noisy, &running, v1::JobState::Running).await;
    many(&noisy, "n", "EVENTS 1", 20).await;
    let refused = noisy.submit("more", LATHE, "EVENTS 1").await.unwrap_err();
    assert_eq!(reason(&refused), "QUEUE_FULL");
    let own = quiet.submit("q", LATHE, "HANG").await.unwrap().job_id;
    server_until(&quiet, &own, v1::JobState::Running).await;
    // A tenth of the places, though the queue is full.
    many(&quiet, "more", "EVENTS 1", 2).await;
    let refused = quiet.submit("too-many", LATHE, "EVENTS 1").await.unwrap_err();
    assert_eq!(reason(&refused), "QUEUE_FULL");
    server.script.hang.store(false, Ordering::SeqCst);
    server.stop().await;
}

#[tokio::test]
async fn quotas_of_a_tenant_are_refused_by_name_and_others_go_on() {
    let folder = tempfile::tempdir().unwrap();
    let quotas = Quotas { tenant_queued: 2, tenant_running: 1, ..Quotas::default() };
    let (server, noisy, quiet) = two(ServerOptions { workers: 2, quotas, ..guarded(folder.path()) }).await;
    let first = noisy.submit("1", LATHE, "HANG").await.unwrap().job_id;
    server_until(&noisy, &first, v1::JobState::Running).await;
    let second = noisy.submit("2", LATHE, "EVENTS 1").await.unwrap().job_id;
    noisy.submit("3", LATHE, "EVENTS 1").await.unwrap();
    assert_eq!(quota(&noisy.submit("4", LATHE, "EVENTS 1").await.unwrap_err()), "tenant_queued");
    assert!(noisy.submit("3", LATHE, "EVENTS 1").await.is_ok(), "a known job is answered even then");
    let own = quiet.submit("q", LATHE, "EVENTS 3").await.unwrap().job_id;
    assert_eq!(quiet.wait(&own).await.state(), v1::JobState::Succeeded, "the second worker is free for it");
    let get = v1::GetJobRequest { job_id: second.clone() };
    let status = noisy.jobs().get_job(get).await.unwrap().into_inner().status.unwrap();
    assert_eq!(status.state(), v1::JobState::Queued, "one worker is all that its tenant may have");
    server.script.hang.store(false, Ordering::SeqCst);
    assert_eq!(noisy.wait(&second).await.state(), v1::JobState::Succeeded);
    server.stop().await;
}

#[tokio::test]
async fn stored_bytes_of_a_tenant_are_counted_over_restarts() {
    let folder = tempfile::tempdir().unwrap();
    let quotas = Quotas { tenant_bytes: 100, ..Quotas::default() };
    let options = ServerOptions { quotas, ..guarded(folder.path()) };
    let (server, noisy, quiet) = two(options.clone()).await;
    let job = noisy.submit("1", LATHE, "EVENTS 2000").await.unwrap().job_id;
    noisy.wait(&job).await;
    assert_eq!(quota(&noisy.submit("2", LATHE, "EVENTS 2000").await.unwrap_err()), "tenant_bytes");
    assert!(quiet.submit("q", LATHE, "EVENTS 1").await.is_ok());
    let tokens = [noisy.bearer, quiet.bearer];
    server.stop().await;
    let server = Server::start(options.clone()).await;
    let [noisy, _] = tokens.map(|bearer| As { connection: server.connection.clone(), bearer });
    assert_eq!(quota(&noisy.upload(b"more").await.unwrap_err()), "tenant_bytes");
    noisy.jobs().delete_job(v1::DeleteJobRequest { job_id: job }).await.unwrap();
    noisy.upload(b"more").await.unwrap();
    server.stop().await;
}

/// Uploads, also unfinished ones, and machines count as the results of jobs do.
#[tokio::test]
async fn files_and_machines_of_a_tenant_count_and_a_full_share_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let quotas = Quotas { tenant_bytes: 10_000, ..Quotas::default() };
    let (server, noisy, quiet) = two(ServerOptions { quotas, ..guarded(folder.path()) }).await;
    noisy.upload(&[b'a'; 4000]).await.unwrap();
    noisy.upload(&[b'a'; 4000]).await.expect("the same content is stored once");
    // Announced or not, a content that does not fit is refused and leaves nothing.
    for size in [Some(7000), None] {
        let content = [b'b'; 7000];
        let first = v1::UploadRequest { digest: digest(&content), size, ..Default::default() };
        let rest = content.chunks(1000);
        let rest = rest.map(|data| v1::UploadRequest { data: data.to_vec().into(), ..Default::default() });
        let chunks: Vec<_> = std::iter::once(first).chain(rest).collect();
        assert_eq!(quota(&noisy.blobs().upload(tokio_stream::iter(chunks)).await.unwrap_err()), "tenant_bytes");
    }
    assert!(quiet.upload(&[b'b'; 7000]).await.is_ok(), "another tenant has a share of its own");
    let toml = format!("extends = \"fanuc-mill\"\n[ce]\nname = \"own\"\n{}", "#\n".repeat(1000));
    let digest = noisy.upload(toml.as_bytes()).await.unwrap();
    let put = |name: &str| {
        let file = v1::MachineFile { path: format!("{name}/machine.toml"), digest: digest.clone() };
        v1::PutMachineRequest { name: name.into(), files: vec![file] }
    };
    let mut puts = 0;
    let refused = loop {
        match noisy.machines().put_machine(put(&format!("own-{puts}"))).await {
            Ok(_) => puts += 1,
            Err(refused) => break refused,
        }
    };
    assert!(quota(&refused) == "tenant_bytes" && (5..20).contains(&puts), "{puts} machines of some 300 bytes");
    assert_eq!(quota(&noisy.submit("1", LATHE, "x").await.unwrap_err()), "tenant_bytes");
    noisy.machines().delete_machine(v1::DeleteMachineRequest { name: "own-0".into() }).await.unwrap();
    noisy.submit("1", LATHE, "x").await.expect("there is room again");
    server.stop().await;
}

/// A client whose answer was lost repeats its upload.
#[tokio::test]
async fn a_content_that_is_stored_is_uploaded_again_whatever_the_quota() {
    let folder = tempfile::tempdir().unwrap();
    let quotas = Quotas { tenant_bytes: 10_000, ..Quotas::default() };
    let (server, noisy, _) = two(ServerOptions { quotas, ..guarded(folder.path()) }).await;
    let stored = [b'a'; 9000];
    noisy.upload(&stored).await.unwrap();
    for size in [Some(9000), None] {
        let first = v1::UploadRequest { digest: digest(&stored), size, ..Default::default() };
        let rest = stored.chunks(1000);
        let rest = rest.map(|data| v1::UploadRequest { data: data.to_vec().into(), ..Default::default() });
        let chunks: Vec<_> = std::iter::once(first).chain(rest).collect();
        let answer = noisy.blobs().upload(tokio_stream::iter(chunks)).await.expect("it is there already");
        assert_eq!(answer.into_inner().size, 9000);
    }
    // More than that is not stored under the digest of a small content.
    noisy.upload(b"small").await.unwrap();
    let first = v1::UploadRequest { digest: digest(b"small"), size: Some(9000), data: stored.to_vec().into() };
    assert_eq!(quota(&noisy.blobs().upload(tokio_stream::iter([first])).await.unwrap_err()), "tenant_bytes");
    let first = v1::UploadRequest { digest: digest(b"small"), size: None, data: stored.to_vec().into() };
    assert_eq!(reason(&noisy.blobs().upload(tokio_stream::iter([first])).await.unwrap_err()), "INVALID_REQUEST");
    server.stop().await;
}

/// Processor time counts, not the time of the clock, and every run counts.
#[tokio::test]
async fn processor_time_of_a_tenant_is_counted_and_a_job_that_waits_takes_none() {
    let folder = tempfile::tempdir().unwrap();
    let quotas = Quotas { tenant_cpu_s: 1, ..Quotas::default() };
    let options = ServerOptions { quotas, ..guarded(folder.path()) };
    let (server, noisy, quiet) = two(options.clone()).await;
    let job = noisy.submit("waits", LATHE, "EVENTS 1\nHANG").await.unwrap().job_id;
    server_until(&noisy, &job, v1::JobState::Running).await;
    tokio::time::sleep(std::time::Duration::from_millis(1100)).await;
    server.script.hang.store(false, Ordering::SeqCst);
    let status = noisy.wait(&job).await;
    assert!(status.ended_ms - status.started_ms >= 1000, "it was there for more than a second");
    assert!((1..700_000).contains(&status.cpu_us), "{} µs", status.cpu_us);
    // Twice 600 ms in one run each, the first of them stopped by a pause.
    server.script.hang.store(true, Ordering::SeqCst);
    let job = noisy.submit("burns", LATHE, "BURN 600\nEVENTS 1\nHANG").await.unwrap().job_id;
    let mut watch = noisy.jobs().watch_job(watch_all(&job)).await.unwrap().into_inner();
    while !matches!(watch.message().await.unwrap().unwrap().content, Some(Content::Batch(_))) {}
    noisy.jobs().pause_job(v1::PauseJobRequest { job_id: job.clone() }).await.unwrap();
    server_until(&noisy, &job, v1::JobState::Queued).await;
    server.script.hang.store(false, Ordering::SeqCst);
    noisy.jobs().resume_job(v1::ResumeJobRequest { job_id: job.clone() }).await.unwrap();
    assert!(noisy.wait(&job).await.cpu_us >= 1_200_000);
    assert_eq!(quota(&noisy.submit("3", LATHE, "EVENTS 1").await.unwrap_err()), "tenant_cpu_s");
    let tokens = [noisy.bearer, quiet.bearer];
    server.stop().await;
    let server = Server::start(options).await;
    let [noisy, quiet] = tokens.map(|bearer| As { connection: server.connection.clone(), bearer });
    assert_eq!(quota(&noisy.submit("3", LATHE, "EVENTS 1").await.unwrap_err()), "tenant_cpu_s");
    assert!(quiet.submit("q-2", LATHE, "EVENTS 1").await.is_ok());
    server.stop().await;
}

fn watch_all(job: &str) -> v1::WatchJobRequest {
    v1::WatchJobRequest { job_id: job.into(), level: v1::WatchLevel::Everything.into(), ..Default::default() }
}

#[tokio::test]
async fn uploads_of_a_tenant_are_limited_and_others_upload() {
    let folder = tempfile::tempdir().unwrap();
    let quotas = Quotas { tenant_uploads: 1, ..Quotas::default() };
    let (server, noisy, quiet) = two(ServerOptions { quotas, ..guarded(folder.path()) }).await;
    let (send, receive) = tokio::sync::mpsc::channel(1);
    let content = b"slow";
    let first = v1::UploadRequest { digest: digest(content), data: "sl".into(), ..Default::default() };
    let mut blobs = noisy.blobs();
    let slow = tokio::spawn(async move { blobs.upload(tokio_stream::wrappers::ReceiverStream::new(receive)).await });
    send.send(first).await.unwrap();
    // Its partial result is there.
    let begun = async {
        while std::fs::read_dir(folder.path().join("data/tmp")).unwrap().next().is_none() {
            tokio::time::sleep(std::time::Duration::from_millis(2)).await;
        }
    };
    tokio::time::timeout(std::time::Duration::from_secs(20), begun).await.expect("the upload has begun");
    assert_eq!(quota(&noisy.upload(b"other").await.unwrap_err()), "tenant_uploads");
    quiet.upload(b"other").await.unwrap();
    send.send(v1::UploadRequest { data: "ow".into(), ..Default::default() }).await.unwrap();
    drop(send);
    slow.await.unwrap().unwrap();
    noisy.upload(b"other").await.unwrap();
    server.stop().await;
}

#[tokio::test]
async fn urgent_jobs_go_first_and_a_deadline_ends_a_job_that_waits_or_runs() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(ServerOptions { workers: 1, ..options(folder.path()) }).await;
    let now = || i64::try_from(SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_millis()).unwrap();
    let submit = async |name: &str, script: &str, priority: v1::JobPriority, deadline_ms: i64| {
        let request = server.request(name, script).await;
        let request = v1::SubmitJobRequest { priority: priority.into(), deadline_ms, ..request };
        server.jobs().submit_job(request).await.unwrap().into_inner().status.unwrap().job_id
    };
    use v1::JobPriority::{High, Low, Normal};
    let running = submit("running", "HANG", Normal, 0).await;
    server.until(&running, v1::JobState::Running).await;
    let low = submit("low", "EVENTS 1", Low, 0).await;
    let normal = submit("normal", "EVENTS 1", Normal, 0).await;
    let high = submit("high", "EVENTS 1", High, 0).await;
    let late = submit("late", "EVENTS 1", High, now() + 100).await;
    let status = server.wait(&late).await;
    assert_eq!((status.state(), status.cause(), status.attempt), (v1::JobState::Failed, v1::JobCause::Limit, 0));
    assert!(status.verdict.contains("deadline") && status.error.is_empty(), "{status:?}");
    server.script.hang.store(false, Ordering::SeqCst);
    let mut started = Vec::new();
    for job in [&high, &normal, &low] {
        started.push(server.wait(job).await.started_ms);
    }
    assert!(started.is_sorted(), "{started:?}");
    server.script.hang.store(true, Ordering::SeqCst);
    let stopped = submit("stopped", "EVENTS 5\nHANG", Normal, now() + 300).await;
    let status = server.wait(&stopped).await;
    assert_eq!((status.state(), status.cause()), (v1::JobState::Failed, v1::JobCause::Limit));
    assert!(status.verdict.contains("its deadline, 20") && status.error.is_empty(), "{status:?}");
    let past = submit("past", "EVENTS 5", Normal, 1).await;
    let status = server.wait(&past).await;
    assert_eq!(status.cause(), v1::JobCause::Limit);
    let says = "the job had not ended at its deadline, 1970-01-01 00:00:00 UTC: submit it again with a later deadline";
    assert!(status.verdict.starts_with(says) && status.error.is_empty(), "{status:?}");
    // The ends are in the ledger.
    server.stop().await;
    let server = Server::start(options(folder.path())).await;
    assert_eq!(server.status(&late).await.cause(), v1::JobCause::Limit);
    server.stop().await;
}
