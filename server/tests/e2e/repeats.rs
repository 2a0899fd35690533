//! Submits that repeat earlier ones.

use std::time::Duration;

use counterpoint_proto::v1;
use counterpoint_server::access::Role;
use counterpoint_server::options::ServerOptions;
use tonic::Code;

use crate::cut::Cut;
use crate::guarded::*;
use crate::support::*;

/// Time for which a submit must wait instead of being refused.
const WAITS: Duration = Duration::from_millis(300);

/// A repeat holds a place in the queue until the ledger has found the earlier submit.
#[tokio::test(flavor = "multi_thread")]
async fn a_repeat_takes_the_last_place_from_no_other_submit() {
    for queue in [true, false] {
        let folder = tempfile::tempdir().unwrap();
        let mut options = ServerOptions { workers: 1, ..guarded(folder.path()) };
        match queue {
            true => options.queue = 2,
            false => options.quotas.tenant_queued = 2,
        }
        let token = grant(&options, "one", "one", Role::Operate);
        let cut = Cut::start(options, &token).await;
        let running = cut.submit("running", "EVENTS 9\nHANG", v1::JobOptions::default()).await;
        cut.until(&running, |status| status.state() == v1::JobState::Running).await;
        let waiting = cut.submit("waiting", "EVENTS 3", v1::JobOptions::default()).await;
        let submit = |id: &'static str, script: &'static str| {
            let caller = As::new(&cut.server, &token);
            tokio::spawn(async move {
                caller.submit_with(id, "fanuc-2path-lathe", script, Some(v1::JobOptions::default())).await
            })
        };
        cut.caller.upload(b"EVENTS 4").await.unwrap();
        cut.close(true);
        let repeat = submit("waiting", "EVENTS 3");
        cut.held().await;
        let mut new = submit("new", "EVENTS 4");
        let early = tokio::time::timeout(WAITS, &mut new).await;
        assert!(early.is_err(), "it waits for the place: {early:?}");
        cut.close(false);
        assert_eq!(repeat.await.unwrap().unwrap().job_id, waiting);
        let status = new.await.unwrap().expect("one job waits, and there are two places");
        assert_ne!(status.job_id, waiting);
        let full = submit("more", "EVENTS 4").await.unwrap().unwrap_err();
        assert_eq!(full.code(), Code::ResourceExhausted, "{full:?}");
        assert_eq!(submit("new", "EVENTS 4").await.unwrap().unwrap().job_id, status.job_id, "a repeat needs no place");
        cut.caller.jobs().cancel_job(v1::CancelJobRequest { job_id: running }).await.unwrap();
        cut.server.stop().await;
    }
}

#[tokio::test]
async fn a_repeat_gets_its_job_when_the_request_could_not_be_accepted_any_more() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let digest = server.upload(b"extends = \"fanuc-2path-lathe\"\n[ce]\nname = \"own\"\n").await;
    let files = vec![v1::MachineFile { path: "own/machine.toml".into(), digest }];
    server.machines().put_machine(v1::PutMachineRequest { name: "own".into(), files }).await.unwrap();
    let request = v1::SubmitJobRequest { machine: "own".into(), ..server.request("a", "EVENTS 2").await };
    let submit = async |request: &v1::SubmitJobRequest| {
        server.jobs().submit_job(request.clone()).await.map(|answer| answer.into_inner())
    };
    let job = submit(&request).await.unwrap().status.unwrap().job_id;
    server.wait(&job).await;
    let again = v1::RerunJobRequest { job_id: job.clone(), request_id: "b".into(), ..Default::default() };
    let rerun = async || server.jobs().rerun_job(again.clone()).await.map(|answer| answer.into_inner());
    let second = rerun().await.unwrap().status.unwrap().job_id;
    server.wait(&second).await;

    server.machines().delete_machine(v1::DeleteMachineRequest { name: "own".into() }).await.unwrap();
    let known = submit(&request).await.unwrap();
    assert_eq!((known.status.unwrap().job_id, known.duplicate), (job.clone(), true));
    let other = v1::SubmitJobRequest { priority: v1::JobPriority::High.into(), ..request.clone() };
    assert_eq!(
        reason(&submit(&other).await.unwrap_err()),
        "UNKNOWN_MACHINE",
        "a request with other content is not a repeat"
    );

    server.jobs().delete_job(v1::DeleteJobRequest { job_id: job }).await.unwrap();
    let known = rerun().await.unwrap();
    assert_eq!((known.status.unwrap().job_id, known.duplicate), (second, true));
    assert_eq!(reason(&submit(&request).await.unwrap_err()), "UNKNOWN_MACHINE", "the job has been deleted");
    server.stop().await;
}
