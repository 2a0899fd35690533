//! Two tenants: neither sees, stops, reads or reuses data of the other.

use counterpoint_proto::v1;
use counterpoint_server::access::Role;
use counterpoint_server::options::{Options, Retention};
use counterpoint_server::{backup, doctor};
use tonic::{Code, Status};

use crate::guarded::*;
use crate::support::*;

const LATHE: &str = "fanuc-2path-lathe";

struct Two {
    server: Server,
    options: Options,
    one: As,
    other: As,
}

async fn two(folder: &std::path::Path) -> Two {
    let options = guarded(folder);
    let tokens = ["one", "other"].map(|tenant| grant(&options, "admin", tenant, Role::Admin));
    let server = Server::start(options.clone()).await;
    let [one, other] = tokens.map(|token| As::new(&server, &token));
    Two { server, options, one, other }
}

fn unknown<T>(answer: Result<T, Status>) {
    let status = answer.map(drop).unwrap_err();
    assert_eq!((status.code(), reason(&status).as_str()), (Code::NotFound, "UNKNOWN_JOB"));
}

#[tokio::test]
async fn a_job_of_another_tenant_is_not_there_for_any_call() {
    let folder = tempfile::tempdir().unwrap();
    let Two { server, one, other, .. } = two(folder.path()).await;
    let ended = one.submit("r-1", LATHE, "EVENTS 3\nWRITE a.txt").await.unwrap().job_id;
    one.wait(&ended).await;
    let running = one.submit("r-2", LATHE, "HANG").await.unwrap().job_id;
    server_runs(&one, &running).await;
    for id in [&ended, &running] {
        let job_id = id.clone();
        unknown(other.jobs().get_job(v1::GetJobRequest { job_id: job_id.clone() }).await);
        let watch = v1::WatchJobRequest { job_id: job_id.clone(), ..Default::default() };
        unknown(other.jobs().watch_job(watch).await);
        unknown(other.jobs().wait_job(v1::WaitJobRequest { job_id: job_id.clone(), timeout_ms: 1 }).await);
        unknown(other.jobs().cancel_job(v1::CancelJobRequest { job_id: job_id.clone() }).await);
        unknown(other.jobs().pause_job(v1::PauseJobRequest { job_id: job_id.clone() }).await);
        unknown(other.jobs().resume_job(v1::ResumeJobRequest { job_id: job_id.clone() }).await);
        unknown(other.jobs().delete_job(v1::DeleteJobRequest { job_id: job_id.clone() }).await);
        let results = || other.results();
        let listing = v1::GetListingRequest { job_id: job_id.clone(), ..Default::default() };
        unknown(results().get_listing(listing).await);
        unknown(results().get_trace(v1::GetTraceRequest { job_id: job_id.clone(), channel: 1 }).await);
        let timeline = v1::GetTimelineRequest { job_id: job_id.clone(), ..Default::default() };
        unknown(results().get_timeline(timeline).await);
        let toolpath = v1::GetToolpathRequest { job_id: job_id.clone(), ..Default::default() };
        unknown(results().get_toolpath(toolpath).await);
        unknown(results().get_summary(v1::GetSummaryRequest { job_id: job_id.clone() }).await);
        unknown(results().get_events(v1::GetEventsRequest { job_id: job_id.clone() }).await);
        unknown(results().list_files(v1::ListFilesRequest { job_id: job_id.clone(), ..Default::default() }).await);
        let file = v1::GetFileRequest { job_id: job_id.clone(), path: "a.txt".into() };
        unknown(results().get_file(file).await);
        let first = v1::AttendRequest { content: Some(v1::attend_request::Content::JobId(job_id.clone())) };
        unknown(other.operator().attend(tokio_stream::iter([first])).await);
        let first = v1::DebugRequest { content: Some(v1::debug_request::Content::JobId(job_id)) };
        unknown(other.operator().debug(tokio_stream::iter([first])).await);
    }
    assert!(other.list().await.is_empty());
    assert_eq!(one.list().await, [ended, running.clone()]);
    one.jobs().cancel_job(v1::CancelJobRequest { job_id: running.clone() }).await.unwrap();
    assert_eq!(one.wait(&running).await.state(), v1::JobState::Cancelled);
    server.stop().await;
}

async fn server_runs(caller: &As, job: &str) {
    for _ in 0..1000 {
        let request = v1::GetJobRequest { job_id: job.into() };
        let status = caller.jobs().get_job(request).await.unwrap().into_inner().status.unwrap();
        if status.state() == v1::JobState::Running {
            return;
        }
        tokio::time::sleep(std::time::Duration::from_millis(5)).await;
    }
    panic!("{job} never ran");
}

#[tokio::test]
async fn request_ids_and_machines_belong_to_their_tenant_also_after_a_restart() {
    let folder = tempfile::tempdir().unwrap();
    let Two { server, options, one, other } = two(folder.path()).await;
    let first = one.submit("r", LATHE, "EVENTS 3").await.unwrap().job_id;
    let second = other.submit("r", LATHE, "EVENTS 4").await.unwrap().job_id;
    assert_ne!(first, second);
    let own = one.put_machine("own", "of one").await.unwrap();
    let get = |name: &str| v1::GetMachineRequest { name: name.into(), ..Default::default() };
    let pinned = format!("own@{}", own.revision);
    for (name, expected) in [("own", "UNKNOWN_MACHINE"), (&pinned, "UNKNOWN_MACHINE"), ("one/own", "INVALID_REQUEST")] {
        let status = other.machines().get_machine(get(name)).await.unwrap_err();
        assert_eq!(reason(&status), expected, "{name}");
    }
    assert_eq!(reason(&other.submit("m", "own", "EVENTS 1").await.unwrap_err()), "UNKNOWN_MACHINE");
    other.put_machine("own", "of other").await.unwrap();
    server.stop().await;
    let server = Server::start(options).await;
    for (caller, events, description) in [(one, 3, "of one"), (other, 4, "of other")] {
        let caller = As { connection: server.connection.clone(), ..caller };
        let again = caller.submit("r", LATHE, &format!("EVENTS {events}")).await.unwrap();
        assert!(again.job_id == first || again.job_id == second);
        assert_eq!(caller.wait(&again.job_id).await.events, events);
        let machine = caller.machines().get_machine(get("own")).await.unwrap().into_inner().machine.unwrap();
        assert_eq!(machine.description, description);
        let all =
            caller.machines().list_machines(v1::ListMachinesRequest::default()).await.unwrap().into_inner().machines;
        assert_eq!(all.iter().filter(|machine| !machine.shipped).count(), 1);
        let job = caller.submit("own", "own", "EVENTS 1").await.unwrap().job_id;
        assert_eq!(caller.wait(&job).await.state(), v1::JobState::Succeeded);
    }
    server.stop().await;
}

#[tokio::test]
async fn a_file_is_there_only_for_the_tenant_that_has_uploaded_it() {
    let folder = tempfile::tempdir().unwrap();
    let Two { server, one, other, .. } = two(folder.path()).await;
    let secret = one.upload(b"EVENTS 5").await.unwrap();
    let ask = || v1::FindMissingRequest { digests: vec![secret.clone()] };
    assert!(one.blobs().find_missing(ask()).await.unwrap().into_inner().digests.is_empty());
    let missing = other.blobs().find_missing(ask()).await.unwrap().into_inner().digests;
    assert_eq!(missing, std::slice::from_ref(&secret));
    let download = v1::DownloadRequest { digest: secret.clone() };
    assert_eq!(reason(&other.blobs().download(download).await.unwrap_err()), "UNKNOWN_BLOB");
    let request = v1::SubmitJobRequest {
        request_id: "steal".into(),
        machine: LATHE.into(),
        programs: vec![v1::Program { path: "main.nc".into(), ..Default::default() }],
        files: vec![v1::FileRef { path: "main.nc".into(), digest: secret.clone() }],
        ..Default::default()
    };
    assert_eq!(reason(&other.jobs().submit_job(request).await.unwrap_err()), "MISSING_BLOBS");
    let file = v1::MachineFile { path: "m/machine.toml".into(), digest: secret };
    let check = v1::CheckMachineRequest { name: "m".into(), files: vec![file] };
    assert_eq!(reason(&other.machines().check_machine(check).await.unwrap_err()), "MISSING_BLOBS");
    server.stop().await;
}

#[tokio::test]
async fn files_of_tenants_are_collected_examined_and_backed_up_like_others() {
    let folder = tempfile::tempdir().unwrap();
    let Two { server, options, one, other } = two(folder.path()).await;
    for caller in [&one, &other] {
        let job = caller.submit("r", LATHE, "EVENTS 3").await.unwrap().job_id;
        caller.wait(&job).await;
    }
    one.put_machine("own", "of one").await.unwrap();
    let stray = other.upload(b"nobody needs it").await.unwrap();
    server.stop().await;
    let data = &options.data;
    assert_eq!(doctor::examine(data, false).unwrap(), []);
    let copy = folder.path().join("copy");
    let contents = backup::backup(data, &copy).unwrap();
    assert_eq!((contents.jobs, contents.blobs, contents.left_out), (2, 3, 0));
    assert_eq!(doctor::examine(&copy, false).unwrap(), []);

    let place = |digest: &str| data.join("blobs/@other").join(&digest[..2]).join(digest);
    let kept = place(&digest(b"EVENTS 3"));
    let server =
        Server::start(Options { retention: Retention { blob_grace_s: 0, ..Retention::default() }, ..options.clone() })
            .await;
    for _ in 0..2000 {
        if !place(&stray).exists() {
            break;
        }
        tokio::time::sleep(std::time::Duration::from_millis(5)).await;
    }
    assert!(!place(&stray).exists() && kept.exists(), "what no job of its tenant needs is collected");
    server.stop().await;
    std::fs::write(&kept, "changed").unwrap();
    let found = doctor::examine(data, true).unwrap();
    assert!(found.iter().any(|damage| damage.path == kept && damage.repaired), "{found:?}");
    assert!(data.join("blobs/@one").join(&digest(b"EVENTS 3")[..2]).join(digest(b"EVENTS 3")).exists());
}
