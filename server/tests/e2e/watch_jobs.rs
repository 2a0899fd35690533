//! Following many jobs with one cursor.

use std::collections::BTreeMap;
use std::sync::atomic::Ordering;

use counterpoint_proto::v1;
use counterpoint_server::access::Role;
use tonic::{Code, Status, Streaming};
use tonic_types::StatusExt;

use crate::guarded::*;
use crate::support::*;

/// View of a watcher: the last state of each job, by request id.
struct Seen {
    stream: Streaming<v1::WatchJobsResponse>,
    jobs: BTreeMap<String, v1::JobState>,
    removed: Vec<String>,
    cursor: u64,
}

impl Seen {
    async fn watch(server: &Server, filter: v1::JobFilter, after: u64) -> Self {
        let request = v1::WatchJobsRequest { filter: Some(filter), after, heartbeat_ms: 100 };
        let stream = server.jobs().watch_jobs(request).await.unwrap().into_inner();
        Self { stream, jobs: BTreeMap::new(), removed: Vec::new(), cursor: 0 }
    }

    async fn next(&mut self) -> Result<(), Status> {
        let message = self.stream.message().await?.expect("the stream goes on");
        assert!(message.cursor >= self.cursor, "cursors ascend");
        self.cursor = message.cursor;
        for change in message.changes {
            let status = change.status.unwrap();
            match change.removed {
                true => self.removed.push(status.job_id),
                false => drop(self.jobs.insert(status.request_id.clone(), status.state())),
            }
        }
        Ok(())
    }

    async fn until(&mut self, done: impl Fn(&Self) -> bool) {
        while !done(self) {
            self.next().await.unwrap();
        }
    }

    fn is(&self, name: &str, state: v1::JobState) -> bool {
        self.jobs.get(name) == Some(&state)
    }
}

/// Of two deletes of a job the later one finds no job, and watchers receive one removal.
#[tokio::test]
async fn a_job_that_is_deleted_twice_at_once_is_removed_once() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let kept = server.submit("kept", "EVENTS 3").await;
    server.wait(&kept).await;
    let mut jobs = Vec::new();
    for number in 0..20 {
        let job = server.submit(&format!("job-{number}"), "EVENTS 3").await;
        server.wait(&job).await;
        jobs.push(job);
    }
    let mut seen = Seen::watch(&server, v1::JobFilter::default(), 0).await;
    seen.until(|seen| seen.cursor > 0).await;
    for job in &jobs {
        let delete = async || {
            let request = v1::DeleteJobRequest { job_id: job.clone() };
            server.jobs().delete_job(request).await.map(drop).map_err(|refused| reason(&refused))
        };
        let (one, other) = tokio::join!(delete(), delete());
        let [Ok(()), Err(refusal)] = (if one.is_ok() { [one, other] } else { [other, one] }) else {
            panic!("one of two deletes must be done");
        };
        assert_eq!(refusal, "UNKNOWN_JOB");
    }
    let last = server.submit("last", "EVENTS 3").await;
    server.wait(&last).await;
    seen.until(|seen| seen.is("last", v1::JobState::Succeeded)).await;
    assert_eq!(seen.removed, jobs);
    server.stop().await;
    assert_eq!(counterpoint_server::doctor::examine(folder.path(), false), Ok(Vec::new()), "the bytes agree");
}

#[tokio::test]
async fn changes_of_many_jobs_come_with_one_cursor_and_resume_at_it() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let before = server.submit("before", "EVENTS 1").await;
    server.wait(&before).await;
    let open = server.submit("open", "HANG").await;
    server.until(&open, v1::JobState::Running).await;
    let mut seen = Seen::watch(&server, v1::JobFilter::default(), 0).await;
    seen.until(|seen| seen.cursor > 0).await;
    assert!(seen.is("open", v1::JobState::Running) && seen.jobs.len() == 1, "{:?}", seen.jobs);
    let next = server.submit("next", "EVENTS 1").await;
    seen.until(|seen| seen.is("next", v1::JobState::Succeeded)).await;
    let cursor = seen.cursor;
    drop(seen);
    server.script.hang.store(false, Ordering::SeqCst);
    server.wait(&open).await;
    server.jobs().delete_job(v1::DeleteJobRequest { job_id: next.clone() }).await.unwrap();
    let mut seen = Seen::watch(&server, v1::JobFilter::default(), cursor).await;
    seen.until(|seen| !seen.removed.is_empty()).await;
    assert!(seen.is("open", v1::JobState::Succeeded) && !seen.jobs.contains_key("before"));
    assert_eq!(seen.removed, [next]);
    // A stream without changes has signs of life.
    let cursor = seen.cursor;
    seen.next().await.unwrap();
    assert_eq!(seen.cursor, cursor);
    server.handle.stop();
    let status = loop {
        if let Err(status) = seen.next().await {
            break status;
        }
    };
    assert_eq!((status.code(), reason(&status).as_str()), (Code::Unavailable, "DRAINING"));
    let resume = status.get_error_details().error_info().unwrap().metadata["cursor"].clone();
    assert_eq!(resume, cursor.to_string());
    server.stop().await;

    let server = Server::start(options(folder.path())).await;
    let request = v1::WatchJobsRequest { after: cursor, ..Default::default() };
    let refused = server.jobs().watch_jobs(request).await.unwrap_err();
    assert_eq!((refused.code(), reason(&refused).as_str()), (Code::OutOfRange, "CURSOR_TOO_OLD"));
    let order = "watch without a cursor, wait for the first message, and then list the jobs";
    assert!(refused.message().contains(order), "docs/api.md: {}", refused.message());
    let oldest = refused.get_error_details().error_info().unwrap().metadata["oldest"].parse::<u64>().unwrap();
    assert!(oldest > cursor, "cursors ascend over restarts");
    let request = v1::WatchJobsRequest { after: oldest, ..Default::default() };
    server.jobs().watch_jobs(request).await.unwrap();
    let request = v1::WatchJobsRequest { after: oldest + 1000, ..Default::default() };
    assert_eq!(reason(&server.jobs().watch_jobs(request).await.unwrap_err()), "CURSOR_BEYOND_LOG");
    server.stop().await;
}

#[tokio::test]
async fn a_filter_chooses_the_jobs_that_are_followed() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let labels: BTreeMap<_, _> = [("part".to_owned(), "17".to_owned())].into();
    let failed = v1::JobFilter { states: vec![v1::JobState::Failed.into()], ..Default::default() };
    let labelled = v1::JobFilter { labels: labels.clone(), ..Default::default() };
    let mut failed = Seen::watch(&server, failed, 0).await;
    let mut labelled = Seen::watch(&server, labelled, 0).await;
    failed.next().await.unwrap();
    labelled.next().await.unwrap();
    let good = server.submit("good", "EVENTS 1").await;
    server.wait(&good).await;
    let own = v1::SubmitJobRequest { labels, ..server.request("own", "EVENTS 1").await };
    server.jobs().submit_job(own).await.unwrap();
    let bad = server.submit("bad", "ALARM").await;
    server.wait(&bad).await;
    failed.until(|seen| !seen.jobs.is_empty()).await;
    labelled.until(|seen| seen.is("own", v1::JobState::Succeeded)).await;
    assert_eq!(failed.jobs.keys().collect::<Vec<_>>(), ["bad"]);
    assert_eq!(labelled.jobs.keys().collect::<Vec<_>>(), ["own"]);
    for job_id in [good, bad] {
        server.jobs().delete_job(v1::DeleteJobRequest { job_id }).await.unwrap();
    }
    server.stop().await;
}

#[tokio::test]
async fn jobs_of_another_tenant_are_not_followed() {
    let folder = tempfile::tempdir().unwrap();
    let options = guarded(folder.path());
    let tokens = [grant(&options, "a", "one", Role::Submit), grant(&options, "b", "other", Role::Submit)];
    let server = Server::start(options).await;
    let [one, other] = tokens.map(|token| As::new(&server, &token));
    let request = v1::WatchJobsRequest { heartbeat_ms: 100, ..Default::default() };
    let mut stream = one.jobs().watch_jobs(request).await.unwrap().into_inner();
    stream.message().await.unwrap();
    let theirs = other.submit("theirs", "fanuc-2path-lathe", "EVENTS 1").await.unwrap().job_id;
    other.wait(&theirs).await;
    other.jobs().delete_job(v1::DeleteJobRequest { job_id: theirs }).await.unwrap();
    let own = one.submit("own", "fanuc-2path-lathe", "EVENTS 1").await.unwrap().job_id;
    loop {
        let message = stream.message().await.unwrap().unwrap();
        let seen: Vec<_> = message.changes.into_iter().map(|change| change.status.unwrap()).collect();
        assert!(seen.iter().all(|status| status.job_id == own), "{seen:?}");
        if seen.iter().any(|status| status.state() == v1::JobState::Succeeded) {
            break;
        }
    }
    server.stop().await;
}
