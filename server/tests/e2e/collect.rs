//! Data that are removed: blobs that nothing needs, folders of jobs without a row, ended jobs beyond those to be kept.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::{Duration, SystemTime};

use counterpoint_proto::v1;
use counterpoint_server::access::Role;
use counterpoint_server::options::{Retention, ServerOptions, Tenant};

use crate::guarded::*;
use crate::share::server_until;
use crate::support::*;
use crate::upgrade::folder_1;

fn place(folder: &Path, name: &str) -> PathBuf {
    folder.join("blobs").join(&name[..2]).join(name)
}

/// Makes all blobs of a stopped server two days old.
fn age(folder: &Path) {
    for digits in std::fs::read_dir(folder.join("blobs")).unwrap() {
        for blob in std::fs::read_dir(digits.unwrap().path()).unwrap() {
            let file = std::fs::File::options().append(true).open(blob.unwrap().path()).unwrap();
            file.set_modified(SystemTime::now() - Duration::from_secs(2 * 86_400)).unwrap();
        }
    }
}

/// A content that a collection comes to after all others.
fn last() -> Vec<u8> {
    let mut contents = (0..).map(|n| format!("nobody needs this {n}").into_bytes());
    contents.find(|content| digest(content).starts_with("ff")).unwrap()
}

/// Starts a server and waits until its first collection is over.
async fn collected(folder: &Path) -> Server {
    let server = Server::start(options(folder)).await;
    let last = place(folder, &digest(&last()));
    for _ in 0..2000 {
        if !last.exists() {
            return server;
        }
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    panic!("what nothing needs was not collected");
}

#[tokio::test]
async fn blobs_go_when_no_job_and_no_machine_needs_them_for_a_while() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let (shared, own) = ("EVENTS 3", "EVENTS 4");
    let first = server.submit("first", shared).await;
    let second = server.submit("second", shared).await;
    let third = server.submit("third", own).await;
    let machine = server.upload(b"extends = \"fanuc-mill\"\n[ce]\nname = \"mine\"\n").await;
    let files = vec![v1::MachineFile { path: "mine/machine.toml".into(), digest: machine.clone() }];
    server.machines().put_machine(v1::PutMachineRequest { name: "mine".into(), files: files.clone() }).await.unwrap();
    // The same revision again needs nothing more.
    server.machines().put_machine(v1::PutMachineRequest { name: "mine".into(), files }).await.unwrap();
    for job in [&first, &second, &third] {
        server.wait(job).await;
    }
    server.jobs().delete_job(v1::DeleteJobRequest { job_id: first }).await.unwrap();
    server.jobs().delete_job(v1::DeleteJobRequest { job_id: third }).await.unwrap();
    let young = server.upload(b"young").await;
    server.upload(&last()).await;
    server.stop().await;
    age(folder.path());
    let file = std::fs::File::options().append(true).open(place(folder.path(), &young)).unwrap();
    file.set_modified(SystemTime::now()).unwrap();

    let server = collected(folder.path()).await;
    let left = |name: &str| place(folder.path(), name).exists();
    assert!(left(&digest(shared.as_bytes())), "the second job needs it");
    assert!(!left(&digest(own.as_bytes())), "its job has been deleted");
    assert!(left(&machine) && left(&young));
    let request = v1::GetJobRequest { job_id: second.clone() };
    assert!(server.jobs().get_job(request).await.unwrap().into_inner().description.is_some());
    let ask = v1::FindMissingRequest { digests: vec![digest(own.as_bytes()), young.clone()] };
    let missing = server.blobs().find_missing(ask).await.unwrap().into_inner().digests;
    assert_eq!(missing, [digest(own.as_bytes())]);
    let again = server.submit("third", own).await;
    assert_eq!(server.wait(&again).await.state(), v1::JobState::Succeeded);
    server.jobs().delete_job(v1::DeleteJobRequest { job_id: second }).await.unwrap();
    server.upload(&last()).await;
    server.stop().await;
    age(folder.path());

    let server = collected(folder.path()).await;
    assert!(!left(&digest(shared.as_bytes())) && !left(&young));
    assert!(left(&machine) && left(&digest(own.as_bytes())));
    server.stop().await;
}

#[tokio::test]
async fn blobs_of_the_jobs_of_a_migrated_ledger_stay() {
    let folder = tempfile::tempdir().unwrap();
    let jobs = folder_1(folder.path()).await;
    let name = digest(&last());
    std::fs::create_dir_all(place(folder.path(), &name).parent().unwrap()).unwrap();
    std::fs::write(place(folder.path(), &name), last()).unwrap();
    age(folder.path());
    let server = collected(folder.path()).await;
    for script in ["EVENTS 700", "EVENTS 7"] {
        assert!(place(folder.path(), &digest(script.as_bytes())).exists(), "{script}");
    }
    assert_eq!(server.wait(&jobs["queued"]).await.state(), v1::JobState::Succeeded);
    server.stop().await;
}

#[tokio::test]
async fn folders_of_jobs_without_a_row_go_at_the_start() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let job = server.submit("r", "EVENTS 20000").await;
    server.wait(&job).await;
    server.stop().await;
    let orphan = folder.path().join("jobs").join("00000000-0000-7000-8000-000000000000");
    std::fs::create_dir(&orphan).unwrap();
    std::fs::write(orphan.join("log"), "x").unwrap();
    let server = Server::start(options(folder.path())).await;
    assert!(!orphan.exists() && log_file(folder.path(), &job).is_file());
    server.stop().await;
}

#[tokio::test]
async fn ended_jobs_of_a_migrated_ledger_count() {
    let folder = tempfile::tempdir().unwrap();
    let jobs = folder_1(folder.path()).await;
    let retention = Retention { keep_s: 3600, ..Retention::default() };
    let server = Server::start(ServerOptions { retention, ..options(folder.path()) }).await;
    until_listed(&server, &[&jobs["running"], &jobs["queued"]]).await;
    server.stop().await;
}

async fn listed(server: &Server) -> Vec<String> {
    let jobs = server.jobs().list_jobs(v1::ListJobsRequest::default()).await.unwrap().into_inner().jobs;
    jobs.into_iter().map(|job| job.job_id).collect()
}

async fn until_listed(server: &Server, expected: &[&String]) {
    for _ in 0..2000 {
        if listed(server).await.iter().eq(expected.iter().copied()) {
            return;
        }
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    panic!("{:?} is not {expected:?}", listed(server).await);
}

#[tokio::test]
async fn ended_jobs_beyond_those_to_be_kept_go_the_oldest_first_and_others_never() {
    let folder = tempfile::tempdir().unwrap();
    let own = |keep_jobs, keep_bytes, keep_s| ServerOptions {
        workers: 1,
        retention: Retention { keep_jobs, keep_bytes, keep_s, ..Retention::default() },
        ..options(folder.path())
    };
    let server = Server::start(own(0, 0, 0)).await;
    let mut ended = Vec::new();
    for n in 0..5 {
        let job = server.submit(&format!("r-{n}"), &format!("EVENTS {}", 5000 + n)).await;
        server.wait(&job).await;
        ended.push(job);
    }
    server.stop().await;
    let job = |job: &str| folder.path().join("jobs").join(job);
    let bytes: u64 = ended.iter().map(|id| std::fs::metadata(log_file(folder.path(), id)).unwrap().len()).sum();

    // By number, while one job runs and one waits.
    let server = Server::start(own(3, 0, 0)).await;
    let running = server.submit("running", "HANG").await;
    server.until(&running, v1::JobState::Running).await;
    let queued = server.submit("queued", "EVENTS 1").await;
    until_listed(&server, &[&ended[2], &ended[3], &ended[4], &running, &queued]).await;
    assert!(!job(&ended[0]).exists() && !job(&ended[1]).exists() && job(&ended[2]).exists());
    let gone = server.jobs().get_job(v1::GetJobRequest { job_id: ended[0].clone() }).await.unwrap_err();
    assert_eq!(reason(&gone), "UNKNOWN_JOB");
    // The request id has gone with the job, and the blob is still there.
    let again = server.request("r-0", "EVENTS 5000").await;
    assert!(!server.jobs().submit_job(again).await.unwrap().into_inner().duplicate);
    server.script.hang.store(false, std::sync::atomic::Ordering::SeqCst);
    server.wait(&queued).await;
    server.stop().await;

    // By bytes: the logs of five jobs are too many for two and a half.
    let left = {
        let server = Server::start(own(0, 0, 0)).await;
        let left = listed(&server).await;
        for id in &left {
            server.wait(id).await;
        }
        server.stop().await;
        left
    };
    let server = Server::start(own(0, bytes / 2, 0)).await;
    let kept = |left: &[String]| -> u64 {
        left.iter().filter_map(|id| std::fs::metadata(log_file(folder.path(), id)).ok()).map(|meta| meta.len()).sum()
    };
    assert!(kept(&left) > 0);
    for _ in 0..2000 {
        if kept(&listed(&server).await) <= bytes / 2 {
            break;
        }
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    let now = listed(&server).await;
    assert!(kept(&now) <= bytes / 2 && !now.is_empty() && left.ends_with(&now), "{now:?} of {left:?}");
    server.stop().await;

    // By age.
    let server = Server::start(own(0, 0, 1)).await;
    until_listed(&server, &[]).await;
    // The folder of a job goes after its row.
    let folders = || std::fs::read_dir(folder.path().join("jobs")).unwrap().count();
    for _ in 0..2000 {
        if folders() == 0 {
            break;
        }
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    assert_eq!(folders(), 0);
    server.stop().await;
}

/// A tenant beyond its retention limit loses its own oldest jobs; older jobs of another tenant stay.
#[tokio::test]
async fn a_tenant_with_many_ended_jobs_loses_its_own_oldest() {
    let folder = tempfile::tempdir().unwrap();
    let retention = Retention { tenant_keep_jobs: 2, ..Retention::default() };
    let options = ServerOptions { retention, workers: 1, ..guarded(folder.path()) };
    let tokens = ["few", "many"].map(|tenant| grant(&options, tenant, tenant, Role::Submit));
    let server = Server::start(options).await;
    let [few, many] = tokens.map(|token| As::new(&server, &token));
    let mut jobs = Vec::new();
    for (caller, name) in [(&few, "f-1"), (&many, "m-1"), (&few, "f-2"), (&many, "m-2"), (&many, "m-3"), (&many, "m-4")]
    {
        let job = caller.submit(name, "fanuc-2path-lathe", "EVENTS 5").await.unwrap().job_id;
        caller.wait(&job).await;
        jobs.push(job);
    }
    let kept = [jobs[4].clone(), jobs[5].clone()];
    for _ in 0..2000 {
        if many.list().await == kept {
            break;
        }
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    assert_eq!(many.list().await, kept);
    assert_eq!(few.list().await, [jobs[0].clone(), jobs[2].clone()]);
    server.stop().await;
}

/// Bytes of the folder of a job.
fn bytes(folder: &Path, job: &str) -> u64 {
    let files = std::fs::read_dir(folder.join("jobs").join(job)).unwrap();
    files.map(|file| file.unwrap().metadata().unwrap().len()).sum()
}

async fn until_own(caller: &As, expected: &[&String]) {
    for _ in 0..2000 {
        if caller.list().await.iter().eq(expected.iter().copied()) {
            return;
        }
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    panic!("{:?} is not {expected:?}", caller.list().await);
}

/// A tenant beyond its bytes loses its own jobs that ended first, regardless of the order of acceptance; a job that
/// runs or waits stays, those of others stay, and a restart changes nothing of that.
#[tokio::test]
async fn a_tenant_beyond_its_bytes_loses_its_own_jobs_that_ended_first_also_after_a_restart() {
    const MACHINE: &str = "fanuc-2path-lathe";
    let folder = tempfile::tempdir().unwrap();
    let mut options = ServerOptions { workers: 2, ..guarded(folder.path()) };
    let tokens = ["few", "many"].map(|tenant| grant(&options, tenant, tenant, Role::Submit));
    let server = Server::start(options.clone()).await;
    let [few, many] = [0, 1].map(|at: usize| As::new(&server, &tokens[at]));
    let mut others = Vec::new();
    for name in ["f-1", "f-2"] {
        let job = few.submit(name, MACHINE, "EVENTS 20000").await.unwrap().job_id;
        few.wait(&job).await;
        others.push(job);
    }
    let first = many.submit("m-1", MACHINE, "EVENTS 20000\nHANG").await.unwrap().job_id;
    server_until(&many, &first, v1::JobState::Running).await;
    let second = many.submit("m-2", MACHINE, "EVENTS 20000").await.unwrap().job_id;
    let ended = many.wait(&second).await.ended_ms;
    while SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap().as_millis() <= ended as u128 {
        std::thread::yield_now();
    }
    server.script.hang.store(false, Ordering::SeqCst);
    assert!(many.wait(&first).await.ended_ms > ended);
    server.script.hang.store(true, Ordering::SeqCst);
    let running = many.submit("m-3", MACHINE, "HANG").await.unwrap().job_id;
    let data = folder.path().join("data");
    let most = bytes(&data, &first) * 3 / 2;
    let own = Tenant { running: Some(1), keep_bytes: Some(most), ..Tenant::default() };
    let waits = many.submit("m-4", MACHINE, "EVENTS 20000").await.unwrap().job_id;
    many.wait(&waits).await;
    options.tables.tenants = BTreeMap::from([("many".to_owned(), own)]);
    // The two that ended first; the last one is all that its bytes allow.
    server.handle.set_tenants(options.tables.tenants.clone());
    until_own(&many, &[&running, &waits]).await;
    assert_eq!(few.list().await, others);
    server.stop().await;

    let server = Server::start(options).await;
    let [few, many] = [0, 1].map(|at: usize| As::new(&server, &tokens[at]));
    let next = many.submit("m-5", MACHINE, "EVENTS 20000").await.unwrap().job_id;
    server.script.hang.store(false, Ordering::SeqCst);
    many.wait(&next).await;
    many.wait(&running).await;
    until_own(&many, &[&running, &next]).await;
    assert_eq!(few.list().await, others);
    server.stop().await;
}
