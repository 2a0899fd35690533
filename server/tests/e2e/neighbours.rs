//! How much the jobs of other tenants cost a tenant. Run by hand, in release, on a quiet machine: `cargo test --release
//! -p counterpoint-server --test e2e neighbours -- --ignored --nocapture --test-threads 1`. `ROUNDS` is the number of
//! pairs or of late jobs.

#![allow(clippy::print_stdout)]

use std::time::{Duration, Instant};

use counterpoint_proto::v1;
use counterpoint_server::local::disk::Disk;
use counterpoint_server::options::ServerOptions;

use crate::guarded::*;
use crate::limited::two_on;
use crate::slices::{BLOCKS, MACRO, Real, TINY, endless, ends, limits, moves, put_spin};
use crate::standing::{Idle, MACHINE, be_idle};

const CALLERS: usize = 64;
const SUBMITS: usize = 4096;

fn rounds() -> usize {
    std::env::var("ROUNDS").ok().and_then(|rounds| rounds.parse().ok()).unwrap_or(5)
}

/// Accepted submits per second of a tenant with 64 callers. All jobs have ended when it returns.
async fn rate(tenant: &As, round: &str) -> f64 {
    let begin = Instant::now();
    let mut callers = tokio::task::JoinSet::new();
    for caller in 0..CALLERS {
        let (tenant, round) = (tenant.clone(), round.to_owned());
        callers.spawn(async move {
            let mut last = String::new();
            for number in 0..SUBMITS / CALLERS {
                let request = request_of(&format!("{round}-{caller}-{number}"), MACHINE, "EVENTS 1");
                last = tenant.jobs().submit_job(request).await.unwrap().into_inner().status.unwrap().job_id;
            }
            last
        });
    }
    let last = callers.join_all().await;
    let rate = SUBMITS as f64 / begin.elapsed().as_secs_f64();
    for job in last {
        tenant.wait(&job).await;
    }
    rate
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[tokio::test(flavor = "multi_thread")]
#[ignore = "a measurement"]
async fn submits_of_a_tenant_beside_an_idle_neighbour() {
    let folder = tempfile::tempdir().unwrap();
    let (server, noisy, quiet) = two_on(folder.path(), 0, Disk::default()).await;
    noisy.upload(b"EVENTS 1").await.unwrap();
    rate(&noisy, "first").await;
    for idle in [Idle::SteppedJob, Idle::WatchedPausedJob, Idle::RequestWithoutBody] {
        let (mut alone, mut ratios) = (Vec::new(), Vec::new());
        for round in 0..rounds() {
            let mut both = [0.0, 0.0];
            for beside in [round % 2 == 1, round % 2 == 0] {
                let neighbour =
                    if beside { Some(be_idle(&quiet, idle, &format!("{idle:?}-{round}")).await) } else { None };
                // The last calls of an identity count for a while.
                tokio::time::sleep(Duration::from_secs(1)).await;
                both[usize::from(beside)] = rate(&noisy, &format!("{idle:?}-{round}-{beside}")).await;
                let Some((job, task)) = neighbour else { continue };
                if let Some(job_id) = job {
                    quiet.jobs().cancel_job(v1::CancelJobRequest { job_id }).await.unwrap();
                }
                if let Some(task) = task {
                    task.abort();
                }
            }
            alone.push(both[0]);
            ratios.push(both[1] / both[0]);
        }
        println!("{idle:?}: alone {:.0} submits per second, beside it {:.2} of that", median(alone), median(ratios));
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
#[ignore = "a measurement"]
async fn a_tiny_job_of_a_late_tenant_beside_eight_busy_tenants() {
    let folder = tempfile::tempdir().unwrap();
    let options = ServerOptions { workers: 1, ..guarded(folder.path()) };
    let names = ["macros", "long", "c", "d", "e", "f", "g", "h", "late"];
    let (server, [macros, long, others @ .., late]) = Real::start(options, names).await;
    put_spin(&macros).await;
    endless(&macros, "spin", MACRO, limits()).await;
    for tenant in &others {
        let job = endless(tenant, "fanuc-mill", BLOCKS, limits()).await;
        moves(tenant, &job).await;
    }
    let program = format!("O1\nG21 G90 G94 F100\n{}M30\n", "G1 X1.\nX2.\n".repeat(250_000));
    let mut times = Vec::new();
    for number in 0..rounds() {
        let job = long.submit_limited(&format!("long-{number}"), "fanuc-mill", &program, Some(limits())).await;
        let job = job.unwrap().job_id;
        let begin = Instant::now();
        let tiny = late.submit(&format!("tiny-{number}"), "fanuc-mill", TINY).await.unwrap().job_id;
        assert_eq!(ends(&late, &tiny).await.state(), v1::JobState::Succeeded);
        times.push(begin.elapsed().as_secs_f64());
        long.jobs().cancel_job(v1::CancelJobRequest { job_id: job.clone() }).await.unwrap();
        ends(&long, &job).await;
    }
    let longest = times.iter().copied().fold(0.0, f64::max);
    println!("submit to end: median {:.2} s, longest {longest:.2} s", median(times));
    server.stop().await;
}
