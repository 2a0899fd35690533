//! Limits: the server's maxima, the clock, the bytes of a job and of a machine.

use std::sync::atomic::Ordering;

use counterpoint_proto::v1;
use counterpoint_server::options::{Maxima, ServerOptions};
use tonic::Code;
use tonic_types::StatusExt as _;

use crate::support::*;

async fn submit_limited(server: &Server, request_id: &str, script: &str, limits: v1::JobLimits) -> String {
    let mut request = server.request(request_id, script).await;
    request.options = Some(v1::JobOptions { limits: Some(limits), ..Default::default() });
    server.jobs().submit_job(request).await.unwrap().into_inner().status.unwrap().job_id
}

async fn summary(server: &Server, job: &str) -> serde_json::Value {
    let request = v1::GetSummaryRequest { job_id: job.into() };
    let mut stream = server.results().get_summary(request).await.unwrap().into_inner();
    let mut text = Vec::new();
    while let Some(chunk) = stream.message().await.unwrap() {
        text.extend_from_slice(&chunk.data);
    }
    serde_json::from_slice(&text).unwrap()
}

#[tokio::test]
async fn a_job_without_end_is_stopped_by_the_clock_whatever_it_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let settings = || ServerOptions {
        workers: 1,
        maxima: Maxima { max_wall_ms: 300, ..Maxima::default() },
        ..options(folder.path())
    };
    let server = Server::start(settings()).await;
    let forever = v1::JobLimits { wall_ms: 1 << 63, ..Default::default() };
    let asked = v1::JobLimits { wall_ms: 50, ..Default::default() };
    let jobs = [
        (submit_limited(&server, "forever", "EVENTS 5\nHANG", forever).await, "300 ms"),
        (submit_limited(&server, "asked", "EVENTS 5\nHANG", asked).await, "50 ms"),
        (submit_limited(&server, "default", "EVENTS 5\nHANG", v1::JobLimits::default()).await, "300 ms"),
    ];
    let other = server.submit("other", "EVENTS 3").await;
    assert_eq!(server.wait(&other).await.state(), v1::JobState::Succeeded, "others get their turn");
    for (job, reached) in &jobs {
        let status = server.wait(job).await;
        assert_eq!((status.state(), status.error.as_str()), (v1::JobState::Failed, ""));
        assert!(status.verdict.contains("wall_ms") && status.verdict.contains(reached), "{}", status.verdict);
        assert!(!status.cancel_requested);
        assert_eq!((status.cause(), status.limit()), (v1::JobCause::Limit, v1::JobLimit::WallMs));
    }
    let before = summary(&server, &jobs[0].0).await;
    assert_eq!((&before["state"], &before["verdict"]["kind"]), (&"FAILED".into(), &"LIMIT".into()));
    server.stop().await;
    let _ = std::fs::remove_file(folder.path().join("jobs").join(&jobs[0].0).join("summary.json"));
    let server = Server::start(settings()).await;
    assert_eq!(summary(&server, &jobs[0].0).await, before, "made again from the log");
    server.stop().await;
}

#[tokio::test]
async fn a_job_that_fills_the_disk_is_stopped_by_its_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(ServerOptions {
        maxima: Maxima { max_job_bytes: 1 << 20, ..Maxima::default() },
        ..options(folder.path())
    })
    .await;
    let endless = v1::JobLimits { max_job_bytes: u64::MAX, ..Default::default() };
    let job = submit_limited(&server, "endless", "EVENTS 100000000", endless).await;
    let status = server.wait(&job).await;
    assert_eq!(status.state(), v1::JobState::Failed);
    assert!(status.verdict.contains("max_job_bytes") && status.verdict.contains("1048576"), "{}", status.verdict);
    let length = std::fs::metadata(log_file(folder.path(), &job)).unwrap().len();
    assert!(length < 1 << 20 && status.events < 100_000, "{length} bytes, {} events", status.events);
    let path = "x".repeat(200);
    let few = v1::JobLimits { max_job_bytes: 150, ..Default::default() };
    let job = submit_limited(&server, "files", &format!("WRITE {path}"), few).await;
    let status = server.wait(&job).await;
    assert!(status.verdict.contains("max_job_bytes"), "{status:?}");
    server.stop().await;
}

#[tokio::test]
async fn the_owner_of_the_server_sets_the_maxima() {
    let folder = tempfile::tempdir().unwrap();
    let maxima = Maxima {
        max_simulated_ns: 11,
        max_blocks: 12,
        max_zero_time_blocks: 13,
        max_events: 14,
        max_block_length: 15,
        max_nesting: 16,
        max_diagnostics: 17,
        max_memory: 18,
        max_macro_steps: 19,
        ..Maxima::default()
    };
    let settings = ServerOptions { maxima, ..options(folder.path()) };
    let server = Server::start(settings.clone()).await;
    let all = v1::JobLimits {
        simulated_ns: i64::MAX,
        blocks: 1 << 63,
        zero_time_blocks: u64::MAX,
        events: u64::MAX,
        block_length: u32::MAX,
        nesting: 1000,
        diagnostics: u32::MAX,
        memory: u64::MAX,
        macro_steps: u64::MAX,
        wall_ms: u64::MAX,
        max_job_bytes: u64::MAX,
    };
    let job = submit_limited(&server, "r", "EVENTS 1", all).await;
    server.wait(&job).await;
    let limits = server.script.limits.lock().unwrap().clone().unwrap();
    assert_eq!((limits.simulated_ns, limits.blocks, limits.zero_time_blocks, limits.events), (11, 12, 13, 14));
    assert_eq!((limits.block_length, limits.nesting, limits.diagnostics), (15, 16, 17));
    assert_eq!((limits.memory, limits.macro_steps), (18, 19));
    server.stop().await;
    // Other maxima do not make another job of the same request.
    let server = Server::start(ServerOptions { maxima: Maxima { max_blocks: 5, ..settings.maxima }, ..settings }).await;
    let again = submit_limited(&server, "r", "EVENTS 1", all).await;
    assert_eq!(again, job);
    server.script.hang.store(false, Ordering::SeqCst);
    server.stop().await;
}

#[tokio::test]
async fn one_large_blob_under_many_names_is_no_machine() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(ServerOptions {
        maxima: Maxima { max_machine_bytes: 10_000, ..Maxima::default() },
        ..options(folder.path())
    })
    .await;
    let blob = server.upload(&[b' '; 400]).await;
    let files = |count: usize| {
        let file = |n| v1::MachineFile { path: format!("mine/{n}.tps"), digest: blob.clone() };
        (0..count).map(file).collect::<Vec<_>>()
    };
    let check = |count| v1::CheckMachineRequest { name: "mine".into(), files: files(count) };
    assert!(!server.machines().check_machine(check(25)).await.unwrap().into_inner().usable);
    let refused = server.machines().check_machine(check(26)).await.unwrap_err();
    assert_eq!((refused.code(), reason(&refused).as_str()), (Code::InvalidArgument, "MACHINE_TOO_LARGE"));
    let put = v1::PutMachineRequest { name: "mine".into(), files: files(26) };
    assert_eq!(reason(&server.machines().put_machine(put).await.unwrap_err()), "MACHINE_TOO_LARGE");
    server.stop().await;
}

/// On the real emulator: a macro that keeps ever more texts ends its job, while another job runs as if it were alone.
#[tokio::test]
async fn a_job_that_takes_more_memory_than_its_budget_fails_alone() {
    const HOARD: &str = "DECLAR/OBJECT,SEQUENCE,HOARD\nT='0123456789'\nDO/I=1,10\nT=T//T\nENDOF/DO\n\
        WHILE/1.EQ.1\nHOARD+=T//'x'\nENDOF/WHILE\n";
    let folder = tempfile::tempdir().unwrap();
    let service = counterpoint_server::service::build(options(folder.path())).await.unwrap();
    let handle = service.handle();
    let task = tokio::spawn(async { service.run(std::future::pending()).await.unwrap() });
    let connection = tonic::transport::Channel::from_shared(handle.url()).unwrap().connect().await.unwrap();
    let server = Server { handle, task, script: Script::default(), connection };
    let mut files = Vec::new();
    for (path, text) in [
        ("own/machine.toml", "extends = \"fanuc-mill\"\n[ce]\nname = \"own\"\n[macros]\ntool = \"t.mac\"\n"),
        ("own/t.mac", HOARD),
    ] {
        files.push(v1::MachineFile { path: path.into(), digest: server.upload(text.as_bytes()).await });
    }
    let put = v1::PutMachineRequest { name: "own".into(), files };
    server.machines().put_machine(put).await.unwrap();
    let submit = async |name: &str, machine: &str| {
        let mut request = server.request(name, "O1\nG90 G94 F100\nT3 M06\nG1 X1.\nM30\n").await;
        let limits = v1::JobLimits { memory: 8 << 20, ..Default::default() };
        request.options = Some(v1::JobOptions { limits: Some(limits), ..Default::default() });
        request.machine = machine.into();
        server.jobs().submit_job(request).await.unwrap().into_inner().status.unwrap().job_id
    };
    let (greedy, modest) = (submit("greedy", "own").await, submit("modest", "fanuc-mill").await);
    let greedy = server.wait(&greedy).await;
    let modest = server.wait(&modest).await;
    let expected = (v1::JobState::Failed, v1::JobCause::Limit, v1::JobLimit::Memory);
    assert_eq!((greedy.state(), greedy.cause(), greedy.limit()), expected, "{greedy:?}");
    assert!(greedy.verdict.contains("HOARD"), "{}", greedy.verdict);
    assert_eq!((modest.state(), modest.limit()), (v1::JobState::Succeeded, v1::JobLimit::Unspecified), "{modest:?}");
    server.stop().await;
}

/// The memory budget of the server refuses what does not fit, counts jobs until they end, and is free again afterwards.
#[tokio::test]
async fn requests_beyond_the_memory_budget_are_refused_and_fit_again_when_jobs_have_ended() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(ServerOptions {
        maxima: Maxima { memory_bytes: 100_000, ..Maxima::default() },
        workers: 1,
        ..options(folder.path())
    })
    .await;
    let mut request = server.request("large", "EVENTS 1").await;
    let text = v1::DialogValue { value: Some(v1::dialog_value::Value::Text("x".repeat(20_000))) };
    let answer = v1::DialogAnswer { dialog: "D".into(), values: [("V".to_owned(), text)].into(), ..Default::default() };
    request.options = Some(v1::JobOptions { answers: vec![answer], ..Default::default() });
    let refused = server.jobs().submit_job(request).await.unwrap_err();
    assert_eq!((refused.code(), reason(&refused).as_str()), (Code::FailedPrecondition, "BEYOND_MEMORY"));
    let ended = server.submit("ended", "EVENTS 1").await;
    server.wait(&ended).await;
    let mut waiting = Vec::new();
    let full = loop {
        let request = server.request(&format!("waits-{}", waiting.len()), "HANG").await;
        match server.jobs().submit_job(request).await {
            Ok(answer) => waiting.push(answer.into_inner().status.unwrap().job_id),
            Err(refused) => break refused,
        }
    };
    assert_eq!((full.code(), reason(&full).as_str()), (Code::ResourceExhausted, "MEMORY_FULL"));
    assert!(full.get_error_details().retry_info().is_some());
    assert!((20..50).contains(&waiting.len()), "some kilobytes for each job that waits: {}", waiting.len());
    let rerun = v1::RerunJobRequest { request_id: "again".into(), job_id: ended.clone(), ..Default::default() };
    assert_eq!(reason(&server.jobs().rerun_job(rerun).await.unwrap_err()), "MEMORY_FULL");
    // Jobs can be looked at, and a submit whose answer was lost is repeated.
    let again = server.request("waits-0", "HANG").await;
    let again = server.jobs().submit_job(again).await.unwrap().into_inner();
    assert!(again.duplicate && again.status.unwrap().job_id == waiting[0]);
    assert_eq!(server.status(&waiting[0]).await.request_id, "waits-0");
    let (mut listed, mut page_token) = (0, String::new());
    loop {
        let request = v1::ListJobsRequest { page_token, page_size: 500, ..Default::default() };
        let page = server.jobs().list_jobs(request).await.unwrap().into_inner();
        listed += page.jobs.len();
        page_token = page.next_page_token;
        if page_token.is_empty() {
            break;
        }
    }
    assert_eq!(listed, waiting.len() + 1);
    server.script.hang.store(false, Ordering::SeqCst);
    for job in &waiting {
        let cancel = v1::CancelJobRequest { job_id: job.clone() };
        server.jobs().cancel_job(cancel).await.unwrap();
        server.wait(job).await;
    }
    let job = server.submit("fits", "EVENTS 2").await;
    assert_eq!(server.wait(&job).await.events, 2);
    server.stop().await;
}
