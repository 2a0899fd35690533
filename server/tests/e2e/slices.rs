//! Runs of several tenants take turns on one worker, with the real emulator.

use std::time::Duration;

use counterpoint_proto::v1;
use counterpoint_proto::v1::watch_job_response::Content;
use counterpoint_server::access::Role;
use counterpoint_server::options::ServerOptions;
use counterpoint_server::service;
use redb::ReadableDatabase as _;
use tonic::transport::Channel;

use crate::guarded::*;
use crate::life::copy;
use crate::share::server_until;

/// Moves in an endless loop; iterations without events take most of the time.
pub const BLOCKS: &str = "O1\nN1 #1=0\nWHILE[#1LT100]DO1\n#1=#1+1\nEND1\nG1 X.001 F100.\nX0.\nGOTO 1\n";
/// Tool changes, whose macro takes nearly all the time.
pub const MACRO: &str = "O1\nN1 T3 M06\nT4 M06\nGOTO 1\n";
const SPIN: &str = "DO/I=1,100000\nA=1\nENDOF/DO\n";
pub const TINY: &str = "O1\nG21 G90 G94 F100\nG1 X1.\nM30\n";
/// Timeout of a test.
const PATIENCE: Duration = Duration::from_secs(120);

/// A server with one worker that runs real jobs, and tenants.
pub struct Real {
    handle: service::Handle,
    task: tokio::task::JoinHandle<()>,
}

impl Real {
    pub async fn start<const N: usize>(options: ServerOptions, tenants: [&str; N]) -> (Self, [As; N]) {
        let tokens = tenants.map(|tenant| grant(&options, tenant, tenant, Role::Submit));
        let (server, connection) = Self::serve(options).await;
        (server, tokens.map(|token| As { connection: connection.clone(), bearer: Bearer(Some(token)) }))
    }

    /// Another server for the same tenants.
    async fn again<const N: usize>(options: ServerOptions, tenants: [As; N]) -> (Self, [As; N]) {
        let (server, connection) = Self::serve(options).await;
        (server, tenants.map(|tenant| As { connection: connection.clone(), ..tenant }))
    }

    async fn serve(options: ServerOptions) -> (Self, Channel) {
        let service = service::build(options).await.unwrap();
        let handle = service.handle();
        let task = tokio::spawn(async { service.run(std::future::pending()).await.unwrap() });
        let address = format!("http://{}", handle.address());
        let connection = Channel::from_shared(address).unwrap().connect().await.unwrap();
        (Self { handle, task }, connection)
    }

    pub async fn stop(self) {
        self.handle.stop();
        tokio::time::timeout(PATIENCE, self.task).await.expect("it stops").unwrap();
    }
}

pub fn limits() -> v1::JobLimits {
    v1::JobLimits {
        simulated_ns: i64::MAX,
        blocks: 10_000_000_000,
        macro_steps: 1_000_000_000_000_000,
        ..Default::default()
    }
}

/// Submits a job that only a time limit ends.
pub async fn endless(caller: &As, machine: &str, program: &str, limits: v1::JobLimits) -> String {
    caller.submit_limited("endless", machine, program, Some(limits)).await.unwrap().job_id
}

/// Stores the machine whose tool change takes long.
pub async fn put_spin(caller: &As) {
    let toml = "extends = \"fanuc-mill\"\n[ce]\nname = \"spin\"\n[macros]\ntool = \"t.mac\"\n";
    let mut files = Vec::new();
    for (path, content) in [("machine.toml", toml), ("t.mac", SPIN)] {
        let digest = caller.upload(content.as_bytes()).await.unwrap();
        files.push(v1::MachineFile { path: format!("spin/{path}"), digest });
    }
    caller.machines().put_machine(v1::PutMachineRequest { name: "spin".into(), files }).await.unwrap();
}

pub async fn ends(caller: &As, job: &str) -> v1::JobStatus {
    let ends = async {
        loop {
            let status = caller.wait(job).await;
            if status.ended_ms > 0 {
                return status;
            }
        }
    };
    tokio::time::timeout(PATIENCE, ends).await.unwrap_or_else(|_| panic!("{job} has not ended"))
}

/// Waits until the first channel of a job has executed more blocks than at the first look.
pub async fn moves(caller: &As, job: &str) {
    let request = v1::WatchJobRequest { job_id: job.into(), heartbeat_ms: 100, ..Default::default() };
    let mut watch = caller.jobs().watch_job(request).await.unwrap().into_inner();
    let moves = async {
        let mut first = None;
        loop {
            let Some(Content::Progress(progress)) = watch.message().await.unwrap().unwrap().content else { continue };
            let Some(now) = progress.channels.first().map(|channel| channel.blocks) else { continue };
            if *first.get_or_insert(now) < now {
                return;
            }
        }
    };
    tokio::time::timeout(PATIENCE, moves).await.unwrap_or_else(|_| panic!("{job} does not move"));
}

async fn cancel(caller: &As, job: &str) {
    caller.jobs().cancel_job(v1::CancelJobRequest { job_id: job.into() }).await.unwrap();
    let status = ends(caller, job).await;
    assert_eq!(status.state(), v1::JobState::Cancelled, "{status:?}");
}

/// Three tenants keep one worker busy with endless blocks, an endless macro, and the preparation of long programs. The
/// job of a fourth tenant ends, and every run continues.
#[tokio::test(flavor = "multi_thread")]
async fn the_job_of_a_tenant_ends_beside_endless_runs_of_others_on_one_worker() {
    let folder = tempfile::tempdir().unwrap();
    let options = ServerOptions { workers: 1, ..guarded(folder.path()) };
    let (server, [blocks, macros, long, late]) = Real::start(options, ["blocks", "macros", "long", "late"]).await;
    put_spin(&macros).await;
    let first = endless(&blocks, "fanuc-mill", BLOCKS, limits()).await;
    moves(&blocks, &first).await;
    let second = endless(&macros, "spin", MACRO, limits()).await;
    server_until(&macros, &second, v1::JobState::Running).await;
    let third = endless(
        &long,
        "fanuc-mill",
        &format!("O1\nG21 G90 G94 F100\n{}M30\n", "G1 X1.\nX2.\n".repeat(80_000)),
        limits(),
    )
    .await;
    for number in 0..3 {
        let job = late.submit(&format!("tiny-{number}"), "fanuc-mill", TINY).await.unwrap().job_id;
        assert_eq!(ends(&late, &job).await.state(), v1::JobState::Succeeded);
    }
    moves(&blocks, &first).await;
    let status = ends(&long, &third).await;
    assert_eq!(status.state(), v1::JobState::Succeeded, "{status:?}");
    // One of the two runs is suspended at any time.
    cancel(&macros, &second).await;
    moves(&blocks, &first).await;
    cancel(&blocks, &first).await;
    server.stop().await;
}

/// A run can be paused, resumed and stopped with the server, whether suspended or not.
#[tokio::test(flavor = "multi_thread")]
async fn suspended_runs_are_paused_resumed_and_drained_like_others() {
    let folder = tempfile::tempdir().unwrap();
    let options = ServerOptions { workers: 1, ..guarded(folder.path()) };
    let (server, tenants) = Real::start(options.clone(), ["a", "b", "c"]).await;
    let mut jobs = Vec::new();
    for tenant in &tenants {
        jobs.push(endless(tenant, "fanuc-mill", BLOCKS, limits()).await);
    }
    for (tenant, job) in tenants.iter().zip(&jobs) {
        moves(tenant, job).await;
    }
    for (tenant, job) in tenants.iter().zip(&jobs) {
        tenant.jobs().pause_job(v1::PauseJobRequest { job_id: job.clone() }).await.unwrap();
        server_until(tenant, job, v1::JobState::Queued).await;
    }
    for (tenant, job) in tenants.iter().zip(&jobs) {
        tenant.jobs().resume_job(v1::ResumeJobRequest { job_id: job.clone() }).await.unwrap();
    }
    for (tenant, job) in tenants.iter().zip(&jobs) {
        moves(tenant, job).await;
    }
    server.stop().await;
    // The runs were interrupted, so no job has failed and all jobs run again.
    let (server, tenants) = Real::again(options, tenants).await;
    for (tenant, job) in tenants.iter().zip(&jobs) {
        moves(tenant, job).await;
    }
    server.stop().await;
}

/// After a crash, jobs that were running run alone for a while only, also if they have no end or their clients do
/// nothing.
#[tokio::test(flavor = "multi_thread")]
async fn jobs_that_a_crash_has_interrupted_do_not_hold_other_tenants() {
    let (first, second) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let options = ServerOptions { workers: 2, ..guarded(first.path()) };
    let (server, [endless_one, stepping, late]) = Real::start(options.clone(), ["endless", "stepping", "late"]).await;
    let without_end = endless(&endless_one, "fanuc-mill", BLOCKS, limits()).await;
    moves(&endless_one, &without_end).await;
    let options_of_job = v1::JobOptions { stepped: true, ..Default::default() };
    let stepped = stepping.submit_with("stepped", "fanuc-mill", TINY, Some(options_of_job)).await.unwrap().job_id;
    server_until(&stepping, &stepped, v1::JobState::Running).await;
    let data = second.path().join("data");
    copy(&options.data, &data);
    server.stop().await;
    let (server, [endless_one, stepping, late]) =
        Real::again(ServerOptions { data, ..options }, [endless_one, stepping, late]).await;
    let job = late.submit("late", "fanuc-mill", TINY).await.unwrap().job_id;
    assert_eq!(ends(&late, &job).await.state(), v1::JobState::Succeeded);
    moves(&endless_one, &without_end).await;
    server_until(&stepping, &stepped, v1::JobState::Running).await;
    cancel(&endless_one, &without_end).await;
    cancel(&stepping, &stepped).await;
    server.stop().await;
}

/// A job that has run alone after a crash is not a suspect for later servers, even if it is held back.
#[tokio::test(flavor = "multi_thread")]
async fn a_suspect_that_has_run_alone_stays_cleared_in_the_ledger() {
    let (first, second) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let options = ServerOptions { workers: 1, ..guarded(first.path()) };
    let (server, [endless_one, late]) = Real::start(options.clone(), ["endless", "late"]).await;
    let job = endless(&endless_one, "fanuc-mill", BLOCKS, limits()).await;
    moves(&endless_one, &job).await;
    let data = second.path().join("data");
    copy(&options.data, &data);
    server.stop().await;
    let suspect = |data: &std::path::Path| {
        let table = redb::TableDefinition::<&str, &[u8]>::new("job");
        let database = redb::Database::open(data.join("ledger.redb")).unwrap();
        let row = database.begin_read().unwrap().open_table(table).unwrap().get(job.as_str()).unwrap().unwrap();
        String::from_utf8_lossy(row.value()).contains("\"suspect\":true")
    };
    let options = ServerOptions { data, ..options };
    let (server, [endless_one, late]) = Real::again(options.clone(), [endless_one, late]).await;
    moves(&endless_one, &job).await;
    let during = second.path().join("during");
    copy(&options.data, &during);
    // Another tenant gets its turn after the suspect has run alone for its time.
    let tiny = late.submit("tiny", "fanuc-mill", TINY).await.unwrap().job_id;
    assert_eq!(ends(&late, &tiny).await.state(), v1::JobState::Succeeded);
    endless_one.jobs().pause_job(v1::PauseJobRequest { job_id: job.clone() }).await.unwrap();
    server_until(&endless_one, &job, v1::JobState::Queued).await;
    server.stop().await;
    assert_eq!([suspect(&during), suspect(&options.data)], [true, false]);
}

/// After a crash, suspended runs have also counted as attempts.
#[tokio::test(flavor = "multi_thread")]
async fn a_run_that_was_suspended_at_a_crash_counts_as_an_attempt() {
    let (first, second) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let options = ServerOptions { workers: 1, ..guarded(first.path()) };
    let (server, tenants) = Real::start(options.clone(), ["a", "b", "c"]).await;
    let mut jobs = Vec::new();
    for tenant in &tenants {
        jobs.push(endless(tenant, "fanuc-mill", BLOCKS, limits()).await);
    }
    for (tenant, job) in tenants.iter().zip(&jobs) {
        moves(tenant, job).await;
    }
    let data = second.path().join("data");
    copy(&options.data, &data);
    server.stop().await;
    let (server, tenants) = Real::again(ServerOptions { data, ..options }, tenants).await;
    for (tenant, job) in tenants.iter().zip(&jobs) {
        moves(tenant, job).await;
        let request = v1::GetJobRequest { job_id: job.clone() };
        let status = tenant.jobs().get_job(request).await.unwrap().into_inner().status.unwrap();
        assert_eq!(status.attempt, 2, "{status:?}");
        cancel(tenant, job).await;
    }
    server.stop().await;
}

/// A run gets its full running time, however long it was suspended. Suspended time counts for its deadline.
#[tokio::test(flavor = "multi_thread")]
async fn a_limit_of_time_counts_running_time_and_a_deadline_does_not() {
    const WALL_MS: u64 = 2000;
    let folder = tempfile::tempdir().unwrap();
    let options = ServerOptions { workers: 1, ..guarded(folder.path()) };
    let (server, [busy, limited, late]) = Real::start(options, ["busy", "limited", "late"]).await;
    let endless_job = endless(&busy, "fanuc-mill", BLOCKS, limits()).await;
    moves(&busy, &endless_job).await;
    let second = endless(&late, "fanuc-mill", BLOCKS, limits()).await;
    moves(&late, &second).await;
    let job = endless(&limited, "fanuc-mill", BLOCKS, v1::JobLimits { wall_ms: WALL_MS, ..limits() }).await;
    let status = ends(&limited, &job).await;
    assert_eq!((status.state(), status.limit()), (v1::JobState::Failed, v1::JobLimit::WallMs), "{status:?}");
    // Each of three tenants has a third of the worker.
    let elapsed = status.ended_ms - status.started_ms;
    assert!(elapsed >= 3 * WALL_MS as i64 / 2, "{elapsed} ms: suspended time has counted");
    let digest = limited.upload(BLOCKS.as_bytes()).await.unwrap();
    let request = v1::SubmitJobRequest {
        request_id: "deadline".into(),
        machine: "fanuc-mill".into(),
        programs: vec![v1::Program { path: "main.nc".into(), ..Default::default() }],
        files: vec![v1::FileRef { path: "main.nc".into(), digest }],
        options: Some(v1::JobOptions { limits: Some(limits()), ..Default::default() }),
        deadline_ms: status.ended_ms + 3000,
        ..Default::default()
    };
    let job = limited.jobs().submit_job(request).await.unwrap().into_inner().status.unwrap().job_id;
    assert_eq!(ends(&limited, &job).await.limit(), v1::JobLimit::Deadline);
    server.stop().await;
}
