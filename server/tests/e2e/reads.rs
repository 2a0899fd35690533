//! Many reads of one identity at once.

use std::time::{Duration, Instant};

use counterpoint_proto::v1;
use counterpoint_server::local::disk::Disk;
use tonic::transport::Endpoint;

use crate::guarded::*;
use crate::limited::two_on;

const JOBS: usize = 150;
const LISTS: usize = 800;
/// Calls on one connection, fewer than its streams.
const OF_A_CONNECTION: usize = 40;
/// The lists of the flood take longer together, also on a fast machine.
const PROMPT: Duration = Duration::from_millis(1500);

async fn list_time(caller: &As) -> Duration {
    let begin = Instant::now();
    caller.jobs().list_jobs(v1::ListJobsRequest { page_size: 1, ..Default::default() }).await.unwrap();
    begin.elapsed()
}

/// Before the first call of another identity, a lone one has no limit on its calls.
#[tokio::test(flavor = "multi_thread")]
async fn a_flood_of_lists_delays_no_other_identity_and_ends_with_its_clients() {
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
    assert_eq!(flood.join_next().await.unwrap().ok(), Some(true));
    let beside = list_time(&quiet).await;
    assert!(beside < PROMPT, "{beside:?}");
    let answered = std::iter::from_fn(|| flood.try_join_next()).count();
    assert!(answered < LISTS / 2, "the flood was over: {answered}");
    flood.shutdown().await;
    tokio::time::sleep(Duration::from_millis(200)).await;
    let afterwards = list_time(&noisy).await;
    assert!(afterwards < PROMPT, "{afterwards:?}");
    server.stop().await;
}
