//! Many jobs in one call: found by their hold, cancelled and deleted by filter.

use counterpoint_proto::v1;
use counterpoint_proto::v1::JobState::{Cancelled, Failed, Paused, Queued, Running, Succeeded};
use counterpoint_server::access::Role;
use counterpoint_server::options::ServerOptions;
use tonic::Code;
use tonic_types::StatusExt as _;

use crate::guarded::*;
use crate::support::*;

fn in_states(states: &[v1::JobState]) -> v1::JobFilter {
    v1::JobFilter { states: states.iter().map(|state| (*state).into()).collect(), ..Default::default() }
}

fn cancel(filter: v1::JobFilter) -> v1::CancelJobsRequest {
    v1::CancelJobsRequest { filter: Some(filter), ..Default::default() }
}

/// Cancels pages until there are no more.
async fn cancel_all(server: &Server, mut request: v1::CancelJobsRequest) -> Vec<String> {
    let mut ids = Vec::new();
    loop {
        let page = server.jobs().cancel_jobs(request.clone()).await.unwrap().into_inner();
        assert!(request.page_size == 0 || page.job_ids.len() <= request.page_size as usize);
        ids.extend(page.job_ids);
        if page.next_page_token.is_empty() {
            return ids;
        }
        request.page_token = page.next_page_token;
    }
}

async fn listed(server: &Server, request: v1::ListJobsRequest) -> Vec<String> {
    let jobs = server.jobs().list_jobs(request).await.unwrap().into_inner().jobs;
    jobs.into_iter().map(|job| job.job_id).collect()
}

async fn pause(server: &Server, job: &str) {
    server.jobs().pause_job(v1::PauseJobRequest { job_id: job.into() }).await.unwrap();
}

#[tokio::test]
async fn jobs_that_are_held_back_are_found_and_cancelled_by_that() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(ServerOptions { workers: 1, ..options(folder.path()) }).await;
    let running = server.submit("running", "EVENTS 5\nHANG").await;
    server.until_events(&running, 5).await;
    let [held, waiting, other] = [
        server.submit("held", "EVENTS 1").await,
        server.submit("waiting", "EVENTS 1").await,
        server.submit("o", "").await,
    ];
    pause(&server, &held).await;
    pause(&server, &other).await;
    let by = |filter| v1::ListJobsRequest { filter: Some(filter), ..Default::default() };
    assert_eq!(listed(&server, by(in_states(&[Paused]))).await, [&*held, &other]);
    assert_eq!(listed(&server, by(in_states(&[Paused, Running]))).await, [&*running, &held, &other]);
    let top = v1::ListJobsRequest { states: vec![Paused.into()], ..Default::default() };
    assert_eq!(listed(&server, top.clone()).await, [&*held, &other]);
    assert_eq!(listed(&server, by(in_states(&[Queued]))).await, [&*held, &waiting, &other], "the state is QUEUED");
    let both = v1::ListJobsRequest { filter: Some(in_states(&[Queued])), ..top };
    let refused = server.jobs().list_jobs(both).await.unwrap_err();
    assert_eq!((refused.code(), reason(&refused).as_str()), (Code::InvalidArgument, "INVALID_REQUEST"));

    let look = v1::CancelJobsRequest { dry_run: true, ..cancel(in_states(&[Paused])) };
    assert_eq!(cancel_all(&server, look).await, [&*other, &held]);
    assert_eq!(server.status(&held).await.state(), Queued, "a dry run changes nothing");
    assert_eq!(cancel_all(&server, cancel(in_states(&[Paused]))).await, [&*other, &held]);
    for (job, state) in [(&held, Cancelled), (&other, Cancelled), (&waiting, Queued), (&running, Running)] {
        assert_eq!(server.status(job).await.state(), state);
    }
    let one_by_one = v1::CancelJobsRequest { all: true, page_size: 1, ..Default::default() };
    assert_eq!(cancel_all(&server, one_by_one.clone()).await, [&*waiting, &running]);
    assert_eq!(server.wait(&running).await.state(), Cancelled);
    assert_eq!(cancel_all(&server, one_by_one).await, [""; 0], "ended jobs are passed over");
    server.stop().await;
}

#[tokio::test]
async fn ended_jobs_are_deleted_by_filter_and_others_stay() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(ServerOptions { workers: 1, ..options(folder.path()) }).await;
    let good = server.submit("good", "EVENTS 1").await;
    let bad = server.submit("bad", "ALARM").await;
    server.wait(&good).await;
    server.wait(&bad).await;
    let running = server.submit("running", "EVENTS 5\nHANG").await;
    server.until_events(&running, 5).await;
    let failed = v1::DeleteJobsRequest { filter: Some(in_states(&[Failed, Running])), ..Default::default() };
    let look = v1::DeleteJobsRequest { dry_run: true, ..failed.clone() };
    for request in [look, failed] {
        assert_eq!(server.jobs().delete_jobs(request).await.unwrap().into_inner().job_ids, [&*bad]);
    }
    let gone = server.jobs().get_job(v1::GetJobRequest { job_id: bad }).await.unwrap_err();
    assert_eq!(reason(&gone), "UNKNOWN_JOB");
    let all = v1::DeleteJobsRequest { all: true, ..Default::default() };
    assert_eq!(server.jobs().delete_jobs(all).await.unwrap().into_inner().job_ids, [&*good]);
    assert_eq!(listed(&server, v1::ListJobsRequest::default()).await, [&*running], "a job that runs stays");
    server.stop().await;
}

#[tokio::test]
async fn a_filter_must_say_which_jobs_and_only_those_that_can_be() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let all = |filter| v1::CancelJobsRequest { all: true, ..cancel(filter) };
    let requests = [
        (v1::CancelJobsRequest::default(), "filter"),
        (cancel(v1::JobFilter::default()), "filter"),
        (all(in_states(&[Queued])), "all"),
        (cancel(in_states(&[Succeeded])), "filter.states"),
        (v1::CancelJobsRequest { page_token: "x".into(), ..all(v1::JobFilter::default()) }, "page_token"),
    ];
    for (request, field) in requests {
        let status = server.jobs().cancel_jobs(request).await.unwrap_err();
        assert_eq!((status.code(), reason(&status).as_str()), (Code::InvalidArgument, "INVALID_REQUEST"));
        let violations = status.get_error_details().bad_request().unwrap().field_violations.clone();
        assert_eq!(violations[0].field, field, "{status}");
    }
    for filter in [None, Some(in_states(&[Paused])), Some(in_states(&[Queued, Running]))] {
        let request = v1::DeleteJobsRequest { filter, ..Default::default() };
        let status = server.jobs().delete_jobs(request).await.unwrap_err();
        assert_eq!(reason(&status), "INVALID_REQUEST");
    }
    server.stop().await;
}

#[tokio::test]
async fn a_call_for_many_jobs_reaches_those_of_its_tenant_and_the_audit_log_names_each() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = guarded(folder.path());
    options.guard.audit = folder.path().join("audit.jsonl");
    let audit = options.guard.audit.clone();
    let tokens = [("ci", "t", Role::Submit), ("viewer", "t", Role::Read), ("them", "u", Role::Submit)];
    let [ci, viewer, them] = tokens.map(|(name, tenant, role)| grant(&options, name, tenant, role));
    let server = Server::start(options).await;
    let [ci, viewer, them] = [ci, viewer, them].map(|token| As::new(&server, &token));
    let mut jobs = Vec::new();
    for (caller, name) in [(&ci, "a"), (&ci, "b"), (&them, "c")] {
        let job = caller.submit(name, "fanuc-2path-lathe", "EVENTS 1").await.unwrap().job_id;
        caller.wait(&job).await;
        jobs.push(job);
    }
    let all = v1::DeleteJobsRequest { all: true, ..Default::default() };
    let refused = viewer.jobs().delete_jobs(all.clone()).await.unwrap_err();
    assert_eq!(reason(&refused), "PERMISSION_DENIED");
    let deleted = ci.jobs().delete_jobs(all).await.unwrap().into_inner().job_ids;
    assert_eq!(deleted, [&*jobs[1], &jobs[0]]);
    assert_eq!(them.wait(&jobs[2]).await.state(), Succeeded, "the job of the other tenant stays");
    server.stop().await;
    let text = std::fs::read_to_string(audit).unwrap();
    let lines = text.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
    let of_call = lines.filter(|line| line["call"].as_str().unwrap().ends_with("/DeleteJobs"));
    let of_call = of_call.filter(|line| line["code"] != "Asked");
    let rows: Vec<_> =
        of_call.map(|line| format!("{} {} {}", line["identity"], line["target"], line["code"])).collect();
    let expected = [
        "\"viewer\" null \"PermissionDenied\"".to_owned(),
        format!("\"ci\" \"{}\" \"Ok\"", jobs[1]),
        format!("\"ci\" \"{}\" \"Ok\"", jobs[0]),
    ];
    assert_eq!(rows, expected);
}

#[tokio::test(flavor = "multi_thread")]
async fn two_calls_at_the_same_time_cancel_each_job_once() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(ServerOptions { workers: 1, ..options(folder.path()) }).await;
    let running = server.submit("running", "EVENTS 5\nHANG").await;
    server.until_events(&running, 5).await;
    let mut jobs = Vec::new();
    for number in 0..60 {
        jobs.push(server.submit(&format!("waiting-{number}"), "EVENTS 1").await);
    }
    let (one, other) = tokio::join!(
        cancel_all(&server, cancel(in_states(&[Queued]))),
        cancel_all(&server, cancel(in_states(&[Queued])))
    );
    let mut cancelled = [one, other].concat();
    cancelled.sort_unstable();
    assert_eq!(cancelled, jobs);
    server.jobs().cancel_job(v1::CancelJobRequest { job_id: running }).await.unwrap();
    server.stop().await;
}
