//! Many reads of one identity at once.

use std::time::Duration;

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
/// Time after which a client disconnects during the search for its machine.
const BEFORE_DISCONNECTING: Duration = Duration::from_millis(700);
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

/// An identity has as many turns as there are cores, but at least two.
#[tokio::test(flavor = "multi_thread")]
async fn a_search_for_a_client_that_has_disconnected_frees_its_turn() {
    let folder = tempfile::tempdir().unwrap();
    let (server, caller, _) = two_on(folder.path(), 0, Disk::default()).await;
    let mut requests = Vec::new();
    for (id, bytes, files) in [("long", 4 << 20, 4), ("middle", 1 << 20, 4), ("short", 1 << 16, 1)] {
        let mut request = v1::SubmitJobRequest { request_id: id.into(), ..Default::default() };
        for number in 0..files {
            let line = format!("G1 X{number}. Y2.5 F100 (to the next point)\n");
            let text = line.repeat(bytes / line.len());
            let path = format!("{number}.nc");
            let digest = caller.upload(text.as_bytes()).await.unwrap();
            request.programs.push(v1::Program { path: path.clone(), ..Default::default() });
            request.files.push(v1::FileRef { path, digest });
        }
        requests.push(request);
    }
    let search = |request: &v1::SubmitJobRequest| {
        let (mut jobs, request) = (caller.jobs(), request.clone());
        async move { drop(jobs.submit_job(request).await) }
    };
    // All turns are taken: by a search whose client stays, and by searches whose clients disconnect.
    let other = tokio::spawn(search(&requests[1]));
    let mut left = tokio::task::JoinSet::new();
    for _ in 1..std::thread::available_parallelism().map_or(2, usize::from).max(2) {
        left.spawn(tokio::time::timeout(BEFORE_DISCONNECTING, search(&requests[0])));
    }
    while let Some(searched) = left.join_next().await {
        assert!(searched.unwrap().is_err(), "the search takes longer");
    }
    search(&requests[2]).await;
    assert!(!other.is_finished(), "the last search waited for the turn of the client that stays");
    other.abort();
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
