//! The examination of a data folder without a server.

use std::path::{Path, PathBuf};
use std::process::Command;

use counterpoint_proto::v1;
use counterpoint_server::doctor::{DoctorFinding, examine};
use counterpoint_server::service;
use redb::{ReadableTable as _, TableDefinition};

use crate::support::*;
use crate::upgrade::{folder_1, write_ledger};

const JOB: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("job");
const REQUEST: TableDefinition<'_, &str, &str> = TableDefinition::new("request_id");
const LOG: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("log");
const BLOB: TableDefinition<'_, &str, u64> = TableDefinition::new("blob");

fn blob(folder: &Path, content: &str) -> PathBuf {
    let name = digest(content.as_bytes());
    folder.join("blobs").join(&name[..2]).join(name)
}

/// Exit code and output of the command.
fn command(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_counterpointd"));
    let output = command.args(["doctor", "--data"]).arg(folder).args(arguments).output().unwrap();
    let text = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8(text).unwrap())
}

/// Contents of all files of a folder.
fn contents(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut all = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if entry.is_dir() {
                folders.push(entry);
            } else {
                all.push((entry.clone(), std::fs::read(entry).unwrap()));
            }
        }
    }
    all.sort();
    all
}

fn one<'a>(found: &'a [DoctorFinding], path: &Path, what: &str) -> &'a DoctorFinding {
    let all: Vec<_> = found.iter().filter(|damage| damage.path == path && damage.what.contains(what)).collect();
    assert_eq!(all.len(), 1, "{what} of {}: {found:#?}", path.display());
    all[0]
}

#[tokio::test]
async fn a_whole_folder_has_no_damage_and_one_in_use_is_not_examined() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    for (n, script) in ["EVENTS 20000", "EVENTS 3\nWRITE a.txt", "REFUSE", "EVENTS 2\nALARM"].into_iter().enumerate() {
        let job = server.submit(&format!("r-{n}"), script).await;
        server.wait(&job).await;
    }
    let (code, text) = command(folder.path(), &[]);
    assert!(code == Some(3) && text.contains("process"), "{code:?} {text}");
    server.stop().await;
    let before = contents(folder.path());
    assert_eq!(examine(folder.path(), false), Ok(Vec::new()));
    assert_eq!(command(folder.path(), &[]).0, Some(0));
    assert!(contents(folder.path()) == before, "an examination changes nothing");
    std::fs::remove_file(folder.path().join("lock")).unwrap();
    assert_eq!(command(folder.path(), &[]).0, Some(0));
    assert!(!folder.path().join("lock").exists(), "it makes no lock");
    assert_eq!(examine(folder.path(), true), Ok(Vec::new()));
    assert_eq!(command(&folder.path().join("none"), &[]).0, Some(3));
    // The state that a killed server leaves is not a damage either.
    let (running, killed) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let server = Server::start(options(running.path())).await;
    let job = server.submit("r", "EVENTS 20000\nHANG").await;
    server.until(&job, v1::JobState::Running).await;
    crate::life::copy(running.path(), killed.path());
    server.stop().await;
    assert_eq!(examine(killed.path(), false), Ok(Vec::new()));
    // A ledger of an earlier schema is none the worse for that, and stays as it is.
    let old = tempfile::tempdir().unwrap();
    folder_1(old.path()).await;
    let before = contents(old.path());
    assert_eq!(examine(old.path(), false), Ok(Vec::new()));
    assert!(contents(old.path()) == before);
}

/// A wrong path must not look like a folder without damage.
#[test]
fn a_folder_without_data_of_a_server_is_not_examined() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [&[][..], &["--repair"]] {
        let (code, text) = command(folder.path(), arguments);
        assert!(code == Some(3) && !text.contains("0 damaged"), "{code:?} {text}");
        assert!(text.contains("is not a data folder"), "{text}");
    }
    std::fs::write(folder.path().join("notes.txt"), "of somebody else").unwrap();
    assert_eq!(command(folder.path(), &[]).0, Some(3));
}

#[tokio::test]
async fn every_damage_is_found_with_its_place_and_a_repair_leaves_only_what_nobody_else_can_mend() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let mut jobs = Vec::new();
    for (name, script) in [
        ("cut", "EVENTS 20000"),
        ("gone", "EVENTS 20001"),
        ("small", "EVENTS 5"),
        ("wrote", "EVENTS 6\nWRITE a.txt"),
        ("row", "EVENTS 7"),
        ("whole", "EVENTS 8"),
    ] {
        let job = server.submit(name, script).await;
        assert_eq!(server.wait(&job).await.state(), v1::JobState::Succeeded);
        jobs.push(job);
    }
    server.stop().await;
    let data = folder.path();
    let log = |n: usize| log_file(data, &jobs[n]);
    std::fs::File::options().write(true).open(log(0)).unwrap().set_len(30_000).unwrap();
    std::fs::remove_file(log(1)).unwrap();
    let files = data.join("jobs").join(&jobs[3]).join("files.json");
    std::fs::write(&files, "{").unwrap();
    let orphan = data.join("jobs").join("00000000-0000-7000-8000-000000000000");
    std::fs::create_dir(&orphan).unwrap();
    std::fs::write(blob(data, "EVENTS 5"), "EVENTS 9").unwrap();
    std::fs::remove_file(blob(data, "EVENTS 20000")).unwrap();
    let ledger = data.join("ledger.redb");
    let database = redb::Database::open(&ledger).unwrap();
    let txn = database.begin_write().unwrap();
    {
        txn.open_table(JOB).unwrap().insert(jobs[4].as_str(), b"{".as_slice()).unwrap();
        txn.open_table(REQUEST).unwrap().insert("stray", "no-job").unwrap();
        let mut logs = txn.open_table(LOG).unwrap();
        let cut = logs.get(jobs[2].as_str()).unwrap().unwrap().value()[..200].to_vec();
        logs.insert(jobs[2].as_str(), cut.as_slice()).unwrap();
        logs.insert("no-job", b"x".as_slice()).unwrap();
        drop(logs);
        txn.open_table(BLOB).unwrap().insert(digest(b"EVENTS 8").as_str(), 7).unwrap();
    }
    txn.commit().unwrap();
    drop(database);

    let before = contents(data);
    let found = examine(data, false).unwrap();
    assert!(contents(data) == before, "an examination changes nothing");
    assert!(found.iter().all(|damage| !damage.repaired), "{found:#?}");
    let lasting = |found: &[DoctorFinding]| {
        let cut = one(found, &log(0), "damaged");
        assert!(cut.remedy == "delete the damaged job" && cut.what.matches("submit the job again").count() == 1);
        one(found, &log(1), "gone");
        one(found, &ledger, &jobs[2]);
        one(found, &files, "macros");
        one(found, &blob(data, "EVENTS 20000"), "gone");
    };
    lasting(&found);
    let mendable = |found: &[DoctorFinding], repaired: bool| {
        for (path, what) in [
            (&ledger, jobs[4].as_str()),
            (&ledger, "request id 'stray'"),
            (&ledger, "the log of job 'no-job'"),
            (&ledger, "counts"),
            (&orphan, "belongs to no job"),
            (&blob(data, "EVENTS 5"), "has changed"),
        ] {
            assert_eq!(one(found, path, what).repaired, repaired);
        }
    };
    mendable(&found, false);
    let (code, text) = command(data, &[]);
    assert!(code == Some(1) && text.lines().count() == found.len() + 1 && text.contains("11 damaged"), "{text}");

    let found = examine(data, true).unwrap();
    mendable(&found, true);
    assert!(!one(&found, &blob(data, "EVENTS 5"), "gone").repaired, "the exit code tells that a file is needed");
    assert!(!orphan.exists() && !blob(data, "EVENTS 5").exists());
    let found = examine(data, false).unwrap();
    lasting(&found);
    one(&found, &blob(data, "EVENTS 5"), "gone");
    assert_eq!(found.len(), 6, "{found:#?}");

    // The printed remedies repair the rest.
    let server = Server::start(options(data)).await;
    for job in [&jobs[0], &jobs[1], &jobs[2], &jobs[3]] {
        server.jobs().delete_job(v1::DeleteJobRequest { job_id: job.clone() }).await.unwrap();
    }
    for (name, script) in [("cut", "EVENTS 20000"), ("small", "EVENTS 5"), ("row", "EVENTS 7")] {
        let job = server.submit(name, script).await;
        assert_eq!(server.wait(&job).await.state(), v1::JobState::Succeeded);
    }
    server.stop().await;
    assert_eq!(examine(data, false), Ok(Vec::new()));
}

#[tokio::test]
async fn a_ledger_that_cannot_be_used_is_reported_with_the_way_out() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    server.upload(b"x").await;
    server.stop().await;
    let ledger = folder.path().join("ledger.redb");
    write_ledger(folder.path(), 999, &[]);
    let later = examine(folder.path(), true).unwrap();
    assert!(later.len() == 1 && later[0].remedy.contains("schema 999"), "{later:?}");
    for content in [b"".as_slice(), b"not a ledger"] {
        std::fs::write(&ledger, content).unwrap();
        let found = examine(folder.path(), true).unwrap();
        assert!(found.len() == 1 && found[0].path == ledger && !found[0].repaired, "{found:?}");
        assert!(found[0].remedy.contains("mv "), "{found:?}");
        assert_eq!(std::fs::read(&ledger).unwrap(), content);
    }
    assert_eq!(command(folder.path(), &["--repair"]).0, Some(1));
}

/// The starting server and `doctor` recommend a repair only if it saves rows.
#[tokio::test]
async fn a_repair_is_recommended_only_if_it_saves_rows() {
    let folder = tempfile::tempdir().unwrap();
    folder_of_jobs(folder.path()).await;
    let ledger = folder.path().join("ledger.redb");
    let clean = std::fs::read(&ledger).unwrap();
    let grown = [&clean[..], &b"more"[..]].concat();
    let later = {
        write_ledger(folder.path(), 999, &[]);
        std::fs::read(&ledger).unwrap()
    };
    let forms: [(&str, Option<&[u8]>, bool); 5] = [
        ("grown", Some(&grown), true),
        ("missing", None, false),
        ("empty", Some(b""), false),
        ("random", Some(&[0x5a; 20_000]), false),
        ("of a later version", Some(&later), false),
    ];
    for (form, content, repaired) in forms {
        match content {
            Some(content) => std::fs::write(&ledger, content).unwrap(),
            None => std::fs::remove_file(&ledger).unwrap(),
        }
        let started = service::build_with(options(folder.path()), Script::default()).await.map(drop);
        let (code, examined) = command(folder.path(), &[]);
        assert_eq!(code, Some(1), "{form}: {examined}");
        for text in [started.unwrap_err().to_string(), examined] {
            assert_eq!(text.contains("--repair"), repaired, "{form}: {text}");
            assert!(repaired || text.contains("backup"), "{form}: {text}");
        }
        let (code, text) = command(folder.path(), &["--repair"]);
        assert_eq!(code, Some(i32::from(!repaired)), "{form}: {text}");
        assert!(!text.contains("--repair"), "{form}: {text}");
    }
}

/// A folder with jobs that have logs in files, and their identities.
async fn folder_of_jobs(folder: &Path) -> Vec<String> {
    let server = Server::start(options(folder)).await;
    let mut jobs = Vec::new();
    for number in 0..6 {
        let job = server.submit(&format!("r-{number}"), &format!("EVENTS {}", 2000 + number)).await;
        server.wait(&job).await;
        jobs.push(job);
    }
    server.stop().await;
    jobs
}

#[tokio::test]
async fn a_ledger_that_has_grown_is_repaired_without_loss_and_each_damaged_one_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let jobs = folder_of_jobs(folder.path()).await;
    let ledger = folder.path().join("ledger.redb");
    for (more, kept) in [(1, "redb.damaged"), (10_000, "redb.damaged.2"), (5, "redb.damaged.3")] {
        let grown = [std::fs::read(&ledger).unwrap(), vec![b'x'; more]].concat();
        std::fs::write(&ledger, &grown).unwrap();
        assert_eq!(command(folder.path(), &[]).0, Some(1));
        let (code, text) = command(folder.path(), &["--repair"]);
        assert!(code == Some(0) && text.contains("6 jobs"), "{more}: {code:?} {text}");
        assert!(std::fs::read(ledger.with_extension(kept)).unwrap() == grown);
        assert_eq!(examine(folder.path(), false), Ok(Vec::new()));
    }
    let server = Server::start(options(folder.path())).await;
    for (number, job) in jobs.iter().enumerate() {
        assert_eq!(server.status(job).await.events, 2000 + number as u64);
    }
    server.stop().await;
}

/// The server may not use files of root, so files of a repair or a restore by root belong to the owner of the folder.
#[cfg(unix)]
#[tokio::test]
async fn files_of_a_repair_and_a_restore_belong_to_the_owner_of_the_folder_alone() {
    use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _, chown};
    const USER: u32 = 65_534;

    if !rustix::process::getuid().is_root() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (data, back) = (folder.path().join("data"), folder.path().join("back"));
    let jobs = folder_of_jobs(&data).await;
    let ledger = data.join("ledger.redb");
    let mut headless = std::fs::read(&ledger).unwrap();
    headless[..4096].fill(0xaa);
    std::fs::write(&ledger, &headless).unwrap();
    std::fs::remove_file(data.join("lock")).unwrap();
    std::fs::create_dir(data.join("jobs/stray")).unwrap();
    let given = |folder: &Path| {
        let mut left = vec![folder.to_owned()];
        while let Some(path) = left.pop() {
            chown(&path, Some(USER), Some(USER)).unwrap();
            if path.is_dir() {
                left.extend(std::fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path()));
            }
        }
    };
    let of_user = |folder: &Path| {
        let mut left = vec![folder.to_owned()];
        while let Some(path) = left.pop() {
            let meta = std::fs::metadata(&path).unwrap();
            assert_eq!((meta.uid(), meta.gid()), (USER, USER), "{}", path.display());
            if meta.is_dir() {
                left.extend(std::fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path()));
            }
        }
    };
    given(&data);
    let (_, text) = command(&data, &["--repair"]);
    assert!(text.contains("6 jobs") && data.join("lost/stray").is_dir(), "{text}");
    of_user(&data);
    for file in [&ledger, &data.join("lock")] {
        assert_eq!(file.metadata().unwrap().permissions().mode() & 0o777, 0o600, "{}", file.display());
    }
    std::fs::create_dir(&back).unwrap();
    chown(&back, Some(USER), Some(USER)).unwrap();
    counterpoint_server::backup::restore(&data, &back, true).unwrap();
    of_user(&back);
    // When the server starts, it closes files that an earlier repair has left open.
    std::fs::set_permissions(&ledger, std::fs::Permissions::from_mode(0o644)).unwrap();
    let server = Server::start(options(&data)).await;
    assert_eq!(ledger.metadata().unwrap().permissions().mode() & 0o777, 0o600);
    assert_eq!(server.status(&jobs[0]).await.events, 2000);
    server.stop().await;
}

/// Pages of a file that contain a text.
fn pages_with(content: &[u8], text: &str) -> Vec<usize> {
    let within = |page: &[u8]| page.windows(text.len()).any(|part| part == text.as_bytes());
    (0..content.len() / 4096).filter(|number| within(&content[number * 4096..(number + 1) * 4096])).collect()
}

#[tokio::test]
async fn rows_that_damage_has_cut_off_are_saved_and_the_folder_of_a_lost_job_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let jobs = folder_of_jobs(folder.path()).await;
    let ledger = folder.path().join("ledger.redb");
    let clean = std::fs::read(&ledger).unwrap();
    // Without its head no tree can be read.
    let mut headless = clean.clone();
    headless[..4096].fill(0xaa);
    std::fs::write(&ledger, &headless).unwrap();
    let (code, text) = command(folder.path(), &["--repair"]);
    assert!(code == Some(1) && text.contains("6 jobs") && text.contains("may be lost"), "{code:?} {text}");
    assert_eq!(examine(folder.path(), false), Ok(Vec::new()));
    let server = Server::start(options(folder.path())).await;
    for (number, job) in jobs.iter().enumerate() {
        assert_eq!(server.status(job).await.events, 2000 + number as u64);
        assert_eq!(server.events(job, 0).await.len(), 2000 + number);
    }
    server.stop().await;
    // Nothing of the job is left but its folder.
    let mut content = std::fs::read(&ledger).unwrap();
    for page in pages_with(&content, &jobs[2]) {
        content[page * 4096..(page + 1) * 4096].fill(0);
    }
    std::fs::write(&ledger, &content).unwrap();
    let log = std::fs::read(log_file(folder.path(), &jobs[2])).unwrap();
    let (code, text) = command(folder.path(), &["--repair"]);
    let lost = folder.path().join("lost").join(&jobs[2]);
    assert!(code == Some(1) && !text.contains("doctor --repair"), "{code:?} {text}");
    if code == Some(1) && lost.exists() {
        assert!(text.contains(lost.to_str().unwrap()), "{text}");
        let file = log_file(folder.path(), &jobs[2]).file_name().unwrap().to_owned();
        let kept = std::fs::read_dir(&lost).unwrap().map(|entry| entry.unwrap().path()).find(|path| {
            path.file_name() == Some(&file)
                || path.file_name().is_some_and(|name| name.to_str().unwrap().starts_with("log"))
        });
        assert!(std::fs::read(kept.unwrap()).unwrap() == log);
        assert_eq!(command(folder.path(), &[]).0, Some(0));
    } else {
        assert!(text.contains("mv "), "nothing can be saved: {text}");
        assert!(log_file(folder.path(), &jobs[2]).exists());
    }
}

/// A job is saved only if its work is whole, too.
#[tokio::test]
async fn the_forecast_counts_the_jobs_that_the_repair_keeps() {
    let folder = tempfile::tempdir().unwrap();
    folder_of_jobs(folder.path()).await;
    let ledger = folder.path().join("ledger.redb");
    let clean = std::fs::read(&ledger).unwrap();
    let of_work = b"\"options\":";
    let places = (0..clean.len() - of_work.len()).filter(|at| clean[*at..].starts_with(of_work));
    let mut fewer = 0;
    for at in places.step_by(3) {
        let mut content = clean.clone();
        content[at + 1] ^= 1;
        std::fs::write(&ledger, &content).unwrap();
        let (_, text) = command(folder.path(), &[]);
        // Some places belong to nothing.
        let Some((before, _)) = text.split_once(" jobs and ") else { continue };
        let forecast: usize = before.rsplit(' ').next().unwrap().parse().unwrap();
        let copy = tempfile::tempdir().unwrap();
        crate::life::copy(folder.path(), copy.path());
        command(copy.path(), &["--repair"]);
        let server = Server::start(options(copy.path())).await;
        let there = server.jobs().list_jobs(v1::ListJobsRequest::default()).await.unwrap().into_inner().jobs.len();
        assert_eq!(forecast, there, "byte {at}: {text}");
        assert_eq!(text.contains(" without "), forecast < 6, "{text}");
        fewer += usize::from(forecast < 6);
        server.stop().await;
    }
    assert!(fewer > 0, "no work was damaged");
}

/// The rows of jobs that wait are in no file: their work and requests show that they are lost.
#[tokio::test]
async fn a_repair_names_the_jobs_that_are_lost_or_may_have_been_deleted() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let file = server.upload(b"extends = \"fanuc-mill\"\n[ce]\nname = \"mine\"\n").await;
    let files = vec![v1::MachineFile { path: "mine/machine.toml".into(), digest: file }];
    server.machines().put_machine(v1::PutMachineRequest { name: "mine".into(), files }).await.unwrap();
    let deleted = server.submit("deleted", "EVENTS 1").await;
    server.wait(&deleted).await;
    server.jobs().delete_job(v1::DeleteJobRequest { job_id: deleted.clone() }).await.unwrap();
    let hang = server.submit("hang", "HANG").await;
    server.until(&hang, v1::JobState::Running).await;
    let mut jobs = vec![("hang", hang)];
    for name in ["wait-1", "wait-2", "wait-3"] {
        let request =
            v1::SubmitJobRequest { priority: v1::JobPriority::Low.into(), ..server.request(name, "HANG").await };
        jobs.push((name, server.jobs().submit_job(request).await.unwrap().into_inner().status.unwrap().job_id));
    }
    server.stop().await;
    let ledger = folder.path().join("ledger.redb");
    let clean = std::fs::read(&ledger).unwrap();
    let mut content = clean.clone();
    // A row of a job has its state.
    for page in pages_with(&content, "\"state\":") {
        content[page * 4096..(page + 1) * 4096].fill(0);
    }
    std::fs::write(&ledger, &content).unwrap();
    let (code, text) = command(folder.path(), &["--repair"]);
    assert_eq!(code, Some(1), "{text}");
    for (request, job) in &jobs {
        let line = text.lines().find(|line| line.contains(&format!("job '{job}'")) && line.contains("is lost"));
        assert!(line.is_some_and(|line| line.contains("submit it again")), "{request}: {text}");
    }
    assert_eq!(command(folder.path(), &[]).0, Some(0));
    // Without its head, a ledger does not show which of its rows were removed.
    let mut headless = clean;
    headless[..4096].fill(0xaa);
    std::fs::write(&ledger, &headless).unwrap();
    let (_, text) = command(folder.path(), &["--repair"]);
    let server = Server::start(options(folder.path())).await;
    let there = server.jobs().list_jobs(v1::ListJobsRequest::default()).await.unwrap().into_inner();
    let notes: Vec<&str> = text.lines().filter(|line| line.contains("without their table")).collect();
    let [note] = notes[..] else { panic!("one line: {text}") };
    assert!(note.starts_with("note: ") && note.contains("4 saved jobs") && note.contains("delete again"), "{text}");
    assert!(there.jobs.iter().all(|status| note.contains(&status.job_id)), "{text}");
    let damaged = text.lines().filter(|line| line.starts_with("damaged: ")).count();
    let repaired = text.lines().filter(|line| line.starts_with("repaired: ")).count();
    let total = format!("{} damaged, {repaired} repaired", damaged + repaired);
    assert!(text.lines().last().unwrap().starts_with(&total), "{text}");
    server.stop().await;
}
