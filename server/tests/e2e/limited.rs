//! Callers that call too often: only their own calls wait for their turn.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use counterpoint_proto::v1;
use counterpoint_server::access::Role;
use counterpoint_server::local::disk::{Disk, DiskOperation, Faults};
use counterpoint_server::options::ServerOptions;
use tonic::transport::Endpoint;
use tonic::{Code, Status};
use tonic_types::StatusExt as _;

use crate::guarded::*;
use crate::metrics::value;
use crate::share::server_until;
use crate::support::*;

/// A disk on which nothing becomes durable while it is blocked.
#[derive(Default)]
pub struct Blocked(pub AtomicBool);

impl Faults for Blocked {
    fn before(&self, step: DiskOperation, _: &Path) -> std::io::Result<usize> {
        while step == DiskOperation::Sync && self.0.load(Ordering::SeqCst) {
            std::thread::sleep(Duration::from_millis(1));
        }
        Ok(usize::MAX)
    }
}

/// A server with a rate, and two identities with connections of their own.
async fn two(folder: &Path, per_s: u32) -> (Server, As, As) {
    two_on(folder, per_s, Disk::default()).await
}

pub async fn two_on(folder: &Path, per_s: u32, disk: Disk) -> (Server, As, As) {
    // A flood of submits fits into the queue.
    let mut options = ServerOptions { workers: 1, queue: 10_000, ..guarded(folder) };
    options.guard.max_calls_per_s = per_s;
    options.connections.metrics = "127.0.0.1:0".into();
    let tokens = [grant(&options, "noisy", "noisy", Role::Submit), grant(&options, "quiet", "quiet", Role::Submit)];
    let server = Server::start_on(options, disk).await;
    let endpoint = Endpoint::from_shared(server.handle.url()).unwrap();
    let [noisy, quiet] = tokens.map(|token| As { connection: endpoint.connect_lazy(), bearer: Bearer(Some(token)) });
    (server, noisy, quiet)
}

async fn call(caller: &As) -> Result<(), Status> {
    caller.jobs().list_jobs(v1::ListJobsRequest::default()).await.map(drop)
}

/// Callers that call again as soon as they have an answer, until they are told to stop or the server goes.
struct Callers {
    stop: Arc<AtomicBool>,
    passed: Arc<AtomicUsize>,
    refused: Arc<AtomicUsize>,
    tasks: tokio::task::JoinSet<Option<Status>>,
}

impl Callers {
    fn start(caller: &As, count: usize) -> Self {
        let (stop, passed, refused) = (Arc::<AtomicBool>::default(), Arc::default(), Arc::default());
        let mut tasks = tokio::task::JoinSet::new();
        for _ in 0..count {
            let (caller, stop) = (caller.clone(), stop.clone());
            let (passed, refused): (Arc<AtomicUsize>, Arc<AtomicUsize>) = (Arc::clone(&passed), Arc::clone(&refused));
            tasks.spawn(async move {
                while !stop.load(Ordering::SeqCst) {
                    match call(&caller).await {
                        Ok(()) => passed.fetch_add(1, Ordering::SeqCst),
                        Err(status) if status.code() == Code::ResourceExhausted => {
                            assert_eq!(reason(&status), "RATE_LIMITED");
                            assert!(
                                status.get_error_details().retry_info().unwrap().retry_delay > Some(Duration::ZERO)
                            );
                            refused.fetch_add(1, Ordering::SeqCst)
                        }
                        Err(status) => return Some(status),
                    };
                }
                None
            });
        }
        Self { stop, passed, refused, tasks }
    }

    /// Waits until as many calls have been answered.
    async fn until(&self, answers: usize) {
        while self.passed.load(Ordering::SeqCst) + self.refused.load(Ordering::SeqCst) < answers {
            tokio::time::sleep(Duration::from_millis(2)).await;
        }
    }

    /// Stops them; returns how many calls have passed and been refused.
    async fn stop(self) -> (usize, usize) {
        self.stop.store(true, Ordering::SeqCst);
        assert!(self.tasks.join_all().await.iter().all(Option::is_none));
        (self.passed.load(Ordering::SeqCst), self.refused.load(Ordering::SeqCst))
    }
}

/// The server's own counts give the number of answers; its tokens give the permitted number of calls.
#[tokio::test]
async fn callers_that_never_pause_are_slowed_to_the_rate_of_their_identity() {
    const RATE: u32 = 100;
    let folder = tempfile::tempdir().unwrap();
    let begin = Instant::now();
    let (server, noisy, _) = two(folder.path(), RATE).await;
    let callers = Callers::start(&noisy, 20);
    callers.until(300).await;
    let (passed, refused) = callers.stop().await;
    let answered = value(&server, "counterpoint_calls_total{call=\"ListJobs\",code=\"Ok\"}").await.unwrap();
    let tokens = f64::from(RATE) * (1.0 + begin.elapsed().as_secs_f64());
    assert!(answered <= tokens, "{answered} calls with {tokens} tokens");
    assert_eq!((passed, refused), (answered as usize, 0), "they wait, as they are few");
    let held = value(&server, "counterpoint_calls_held_total").await.unwrap();
    assert!(held >= 1.0 && held <= answered, "{held}");
    assert_eq!(value(&server, "counterpoint_calls_waiting").await, Some(0.0));
    server.stop().await;
}

/// More callers than may wait: the server refuses some, and reads their next calls after a pause.
#[tokio::test]
async fn callers_beyond_those_that_may_wait_are_refused_and_not_listened_to_for_a_while() {
    const CALLERS: usize = 40;
    let folder = tempfile::tempdir().unwrap();
    let begin = Instant::now();
    let (server, noisy, quiet) = two(folder.path(), 5).await;
    let callers = Callers::start(&noisy, CALLERS);
    callers.until(3 * CALLERS).await;
    call(&quiet).await.expect("nobody else is refused");
    let (passed, refused) = callers.stop().await;
    let elapsed = begin.elapsed().as_secs_f64();
    assert!(passed as f64 <= 5.0 * (1.0 + elapsed), "{passed} calls in {elapsed} s");
    let pauses = value(&server, "counterpoint_pauses_total").await.unwrap();
    assert!(pauses >= 1.0);
    // Each pause ends a round of calls; those of the round in which the callers stop may be without one.
    assert!(refused as f64 <= (pauses + 1.0) * CALLERS as f64, "{refused} refusals, {pauses} pauses");
    assert!(pauses <= elapsed / 0.9 + 1.0, "{pauses} pauses in {elapsed} s: each takes a second");
    assert_eq!(value(&server, "counterpoint_calls_limited_total").await, Some(refused as f64));
    server.stop().await;
}

#[tokio::test]
async fn calls_of_others_pass_while_those_of_one_identity_wait() {
    const OWN: usize = 60;
    let folder = tempfile::tempdir().unwrap();
    let (server, noisy, quiet) = two(folder.path(), 100).await;
    let callers = Callers::start(&noisy, 90);
    while value(&server, "counterpoint_calls_waiting").await < Some(20.0) {
        tokio::time::sleep(Duration::from_millis(2)).await;
    }
    let before = value(&server, "counterpoint_calls_held_total").await.unwrap();
    for _ in 0..OWN {
        call(&quiet).await.unwrap();
    }
    let health = tonic_health::pb::health_client::HealthClient::new(quiet.connection.clone());
    health.clone().check(tonic_health::pb::HealthCheckRequest::default()).await.unwrap();
    assert!(before >= 20.0);
    let (_, refused) = callers.stop().await;
    assert_eq!(refused, 0);
    // None of the other identity's calls has waited: all held calls are those of the first.
    let held = value(&server, "counterpoint_calls_held_total").await.unwrap();
    let noisy = value(&server, "counterpoint_calls_total{call=\"ListJobs\",code=\"Ok\"}").await.unwrap() - OWN as f64;
    assert!(held <= noisy - 100.0, "{held} of {noisy} calls were held, the first hundred found a token");
    server.stop().await;
}

#[tokio::test]
async fn calls_that_wait_end_with_the_drain() {
    let folder = tempfile::tempdir().unwrap();
    let (server, noisy, _) = two(folder.path(), 1).await;
    let mut callers = Callers::start(&noisy, 3);
    while value(&server, "counterpoint_calls_waiting").await < Some(1.0) {
        tokio::time::sleep(Duration::from_millis(2)).await;
    }
    server.stop().await;
    while let Some(status) = callers.tasks.join_next().await {
        let status = status.unwrap().expect("the server goes");
        // Without details it is the end of the connection.
        let answer = status.get_error_details().error_info().map(|info| info.reason.clone());
        assert!(answer.as_deref().is_none_or(|reason| reason == "DRAINING"), "{status:?}");
    }
}

/// The ledger takes all operations that wait into its next commit: how many commits it needs says how many calls were
/// in hand at once.
#[tokio::test]
async fn a_flood_of_submits_has_few_calls_in_hand_while_another_identity_calls() {
    const FLOOD: usize = 24;
    /// Calls that an identity has in hand in any case.
    const FEW: usize = 4;
    let folder = tempfile::tempdir().unwrap();
    let disk = Arc::new(Blocked::default());
    let (server, noisy, quiet) = two_on(folder.path(), 0, Disk::faulty(disk.clone())).await;
    // Both have a job that hangs, so no job ends meanwhile.
    let first = noisy.submit("first", "fanuc-2path-lathe", "HANG").await.unwrap().job_id;
    server_until(&noisy, &first, v1::JobState::Running).await;
    let own = quiet.submit("own", "fanuc-2path-lathe", "HANG").await.unwrap().job_id;
    server_until(&quiet, &own, v1::JobState::Running).await;
    let commits = async || value(&server, "counterpoint_commit_seconds_count").await.unwrap();
    let before = commits().await;
    disk.0.store(true, Ordering::SeqCst);
    let mut calls = tokio::task::JoinSet::new();
    for number in 0..FLOOD {
        let noisy = noisy.clone();
        calls.spawn(async move {
            let request = v1::SubmitJobRequest {
                request_id: format!("n-{number}"),
                machine: "fanuc-2path-lathe".into(),
                programs: vec![v1::Program { path: "main.nc".into(), ..Default::default() }],
                files: vec![v1::FileRef { path: "main.nc".into(), digest: digest(b"HANG") }],
                ..Default::default()
            };
            noisy.jobs().submit_job(request).await.map(drop)
        });
    }
    while value(&server, "counterpoint_calls_deferred_total").await < Some((FLOOD - FEW) as f64) {
        tokio::time::sleep(Duration::from_millis(2)).await;
    }
    // Those of the other identity continue beside the flood.
    for _ in 0..20 {
        call(&quiet).await.unwrap();
    }
    disk.0.store(false, Ordering::SeqCst);
    assert!(calls.join_all().await.iter().all(Result::is_ok));
    let commits = commits().await - before;
    assert!(commits >= (FLOOD / FEW) as f64, "{FLOOD} submits in {commits} commits: more than {FEW} at once");
    assert_eq!(value(&server, "counterpoint_calls_deferred_total").await, Some((FLOOD - FEW) as f64));
    server.script.hang.store(false, Ordering::SeqCst);
    server.stop().await;
}
