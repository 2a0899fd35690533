//! Many reads of one identity at once.

use counterpoint_proto::v1;
use counterpoint_server::local::disk::Disk;
use tonic::transport::Endpoint;

use crate::guarded::*;
use crate::limited::two_on;

const JOBS: usize = 150;
const LISTS: usize = 800;
/// Calls on one connection, fewer than its streams.
const OF_A_CONNECTION: usize = 40;
const SEARCHES: usize = 160;
/// Fewer than one in this many calls of a flood may be answered during one call of another identity.
const MEANWHILE: usize = 8;

/// Before the first call of another identity, a single identity has no limit on its calls.
#[tokio::test(flavor = "multi_thread")]
async fn a_call_of_another_identity_precedes_a_flood_of_lists() {
    let folder = tempfile::tempdir().unwrap();
    let (server, noisy, quiet) = two_on(folder.path(), 0, Disk::default()).await;
    let mut last = String::new();
    for number in 0..JOBS {
        last = noisy.submit(&format!("r{number}"), "fanuc-2path-lathe", "EVENTS 1").await.unwrap().job_id;
    }
    noisy.wait(&last).await;
    let endpoint = Endpoint::from_shared(server.handle.url()).unwrap();
    let mut flood = tokio::task::JoinSet::new();
    for _ in 0..LISTS / OF_A_CONNECTION {
        let caller = As { connection: endpoint.connect_lazy(), ..noisy.clone() };
        for _ in 0..OF_A_CONNECTION {
            let mut jobs = caller.jobs();
            let request = v1::ListJobsRequest { page_size: 500, short_ids: true, ..Default::default() };
            flood.spawn(async move { jobs.list_jobs(request).await.is_ok() });
        }
    }
    assert!(flood.join_next().await.unwrap().unwrap(), "a list succeeds");
    let list = async { drop(quiet.list().await) };
    assert_precedes(&mut flood, list, LISTS).await;
    server.stop().await;
}

/// The server looks for the machine of a program in its text.
#[tokio::test(flavor = "multi_thread")]
async fn a_call_of_another_identity_precedes_a_flood_of_submits_without_a_machine() {
    let folder = tempfile::tempdir().unwrap();
    let (server, noisy, quiet) = two_on(folder.path(), 0, Disk::default()).await;
    let program = "G1 X1. Y2.5 F100 (to the next point)\n".repeat(1500);
    for caller in [&noisy, &quiet] {
        caller.upload(program.as_bytes()).await.unwrap();
    }
    let endpoint = Endpoint::from_shared(server.handle.url()).unwrap();
    let mut flood = tokio::task::JoinSet::new();
    for number in 0..SEARCHES {
        let caller = As { connection: endpoint.connect_lazy(), ..noisy.clone() };
        let request = request_of(&format!("s{number}"), "", &program);
        flood.spawn(async move { caller.jobs().submit_job(request).await.is_ok() });
    }
    flood.join_next().await.unwrap().unwrap();
    let search = async { drop(quiet.jobs().submit_job(request_of("own", "", &program)).await) };
    assert_precedes(&mut flood, search, SEARCHES).await;
    server.stop().await;
}

/// Checks that a call of another identity is answered before most of the calls of a flood, and ends the flood.
async fn assert_precedes(flood: &mut tokio::task::JoinSet<bool>, call: impl Future<Output = ()>, calls: usize) {
    let answered = |flood: &mut tokio::task::JoinSet<bool>| std::iter::from_fn(|| flood.try_join_next()).count();
    answered(flood);
    call.await;
    let meanwhile = answered(flood);
    assert!(meanwhile < calls / MEANWHILE, "{meanwhile} calls came first");
    assert!(!flood.is_empty(), "the flood was over");
    flood.shutdown().await;
}
