//! Backups of a running and of a stopped server, and their way back.

use std::path::Path;
use std::process::Command;

use counterpoint_proto::v1;
use counterpoint_server::doctor::examine;
use counterpoint_server::local::disk::Disk;
use tonic_types::StatusExt as _;

use crate::support::*;

/// Exit code and output of a command of the server, while servers of this test continue.
async fn command(arguments: &[&str], folder: &Path, data: &Path) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_counterpointd"));
    command.args(arguments).arg(folder).arg("--data").arg(data);
    let output = tokio::task::spawn_blocking(move || command.output().unwrap()).await.unwrap();
    (output.status.code(), String::from_utf8([output.stdout, output.stderr].concat()).unwrap())
}

#[tokio::test]
async fn a_backup_of_a_running_server_has_every_job_and_finishes_those_that_had_not_ended() {
    let folder = tempfile::tempdir().unwrap();
    let (data, copy, back) =
        (folder.path().join("data"), folder.path().join("backup"), folder.path().join("a/restored"));
    let server = Server::start(options(&data)).await;
    let mut ended = Vec::new();
    for (name, script) in [("large", "EVENTS 20000"), ("small", "EVENTS 9"), ("wrote", "EVENTS 1\nWRITE a.txt")] {
        let job = server.submit(name, script).await;
        server.wait(&job).await;
        ended.push((job.clone(), server.events(&job, 0).await));
    }
    let unused = server.upload(b"nobody needs this").await;
    let running = server.submit("running", "EVENTS 3000\nHANG\nEVENTS 5").await;
    server.until(&running, v1::JobState::Running).await;
    let (code, text) = command(&["backup"], &copy, &data).await;
    assert!(code == Some(0) && text.starts_with("4 jobs, 4 blobs, 0 jobs left out"), "{code:?} {text}");
    assert_eq!(std::fs::read_dir(data.join("tmp")).unwrap().count(), 0, "nothing is left of the request");
    let (code, text) = command(&["backup"], &copy, &data).await;
    assert!(code == Some(3) && text.contains("not empty"), "{text}");
    // The server continues, and later changes are not in the backup.
    server.jobs().delete_job(v1::DeleteJobRequest { job_id: ended[0].0.clone() }).await.unwrap();
    let later = server.submit("later", "EVENTS 2").await;
    server.wait(&later).await;
    server.stop().await;

    let (code, text) = command(&["restore"], &copy, &data).await;
    assert!(code == Some(3) && text.contains("not empty"), "{text}");
    let (code, text) = command(&["restore"], &copy, &back).await;
    assert_eq!(code, Some(0), "{text}");
    assert_eq!(examine(&back, false), Ok(Vec::new()));
    let server = Server::start(options(&back)).await;
    server.script.hang.store(false, std::sync::atomic::Ordering::SeqCst);
    let status = server.wait(&running).await;
    assert_eq!((status.state(), status.events, status.attempt), (v1::JobState::Succeeded, 3005, 1));
    for (job, expected) in &ended {
        assert!(server.events(job, 0).await == *expected);
    }
    let files = v1::ListFilesRequest { job_id: ended[2].0.clone(), ..Default::default() };
    assert_eq!(server.results().list_files(files).await.unwrap().into_inner().files.len(), 1);
    let again = server.request("small", "EVENTS 9").await;
    assert!(server.jobs().submit_job(again).await.unwrap().into_inner().duplicate);
    let ask = v1::FindMissingRequest { digests: vec![unused.clone()] };
    assert_eq!(server.blobs().find_missing(ask).await.unwrap().into_inner().digests, [unused]);
    let gone = server.jobs().get_job(v1::GetJobRequest { job_id: later }).await.unwrap_err();
    assert_eq!(reason(&gone), "UNKNOWN_JOB");
    server.stop().await;
}

/// The server of a folder takes the lock and empties `tmp` at its start.
#[tokio::test]
async fn a_backup_whose_server_restarts_or_dies_ends_with_an_error_at_once() {
    for restarts in [true, false] {
        let folder = tempfile::tempdir().unwrap();
        let (data, copy) = (folder.path().join("data"), folder.path().join("backup"));
        let server = Server::start(options(&data)).await;
        server.wait(&server.submit("one", "EVENTS 9").await).await;
        server.stop().await;
        // A server that exits before it handles the request.
        let lock = std::fs::File::options().write(true).open(data.join("lock")).unwrap();
        lock.lock().unwrap();
        let (from, to) = (data.clone(), copy.clone());
        let begin = std::time::Instant::now();
        let backup = tokio::spawn(async move { command(&["backup"], &to, &from).await });
        let requested = || std::fs::read_dir(data.join("tmp")).unwrap().count() > 0;
        while !requested() {
            tokio::time::sleep(std::time::Duration::from_millis(5)).await;
        }
        if restarts {
            std::fs::remove_dir_all(data.join("tmp")).unwrap();
            std::fs::create_dir(data.join("tmp")).unwrap();
        } else {
            lock.unlock().unwrap();
        }
        let (code, text) = backup.await.unwrap();
        let expected = match restarts {
            true => "the server was restarted during the backup: run the backup again",
            false => "the server exited during the backup: run the backup again",
        };
        assert!(code == Some(3) && text.contains(expected), "{code:?} {text}");
        assert!(begin.elapsed().as_secs() < 20, "{:?}", begin.elapsed());
        assert!(!requested(), "nothing is left of the request");
    }
}

#[tokio::test]
async fn a_stopped_server_can_be_backed_up_and_a_damaged_backup_is_restored_only_on_demand() {
    let folder = tempfile::tempdir().unwrap();
    let (data, copy, back) = (folder.path().join("data"), folder.path().join("backup"), folder.path().join("back"));
    let server = Server::start(options(&data)).await;
    let (lost, kept) = (server.submit("lost", "EVENTS 20000").await, server.submit("kept", "EVENTS 20001").await);
    server.wait(&lost).await;
    server.wait(&kept).await;
    server.stop().await;
    std::fs::remove_dir_all(data.join("jobs").join(&lost)).unwrap();
    let (code, text) = command(&["backup"], &copy, &data).await;
    assert!(code == Some(0) && text.starts_with("1 jobs, 1 blobs, 1 jobs left out"), "{code:?} {text}");
    let log = log_file(&copy, &kept);
    std::fs::File::options().write(true).open(&log).unwrap().set_len(30_000).unwrap();
    let (code, text) = command(&["restore"], &copy, &back).await;
    assert!(code == Some(3) && text.contains("--damaged") && text.contains(&kept) && !back.exists(), "{text}");
    let (code, text) = command(&["restore", "--damaged"], &copy, &back).await;
    assert_eq!(code, Some(0), "{text}");
    let server = Server::start(options(&back)).await;
    assert_eq!(server.status(&kept).await.events, 20_001);
    server.stop().await;
    let (code, text) = command(&["restore"], &folder.path().join("none"), &back).await;
    assert!(code == Some(3) && text.contains("not a backup"), "{text}");
    std::fs::create_dir(folder.path().join("other")).unwrap();
    let target = folder.path().join("new");
    for (source, what) in [("none", "there is no such folder"), ("other", "is not a data folder")] {
        let source = folder.path().join(source);
        let (code, text) = command(&["backup"], &target, &source).await;
        assert!(code == Some(3) && text.contains(what) && text.contains(source.to_str().unwrap()), "{text}");
        assert!(!text.contains("remove") && !target.exists(), "nothing was begun: {text}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn of_several_backups_to_one_folder_one_is_made_whole_and_the_others_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data");
    let server = Server::start(options(&data)).await;
    for name in ["a", "b", "c", "d", "e", "f"] {
        server.wait(&server.submit(name, &format!("EVENTS 20000\nWRITE {name}")).await).await;
    }
    for round in 0..4 {
        let copy = folder.path().join(format!("copy-{round}"));
        let begun = [(); 4].map(|()| {
            let (data, copy) = (data.clone(), copy.clone());
            tokio::spawn(async move { command(&["backup"], &copy, &data).await })
        });
        let mut whole = 0;
        for one in begun {
            match one.await.unwrap() {
                (Some(0), _) => whole += 1,
                (code, text) => {
                    let told = text.contains("choose a new folder") && !text.contains("remove");
                    assert!(code == Some(3) && told, "{code:?} {text}");
                }
            }
        }
        assert_eq!(whole, 1, "{}", copy.display());
        assert_eq!(examine(&copy, false), Ok(Vec::new()));
    }
    server.stop().await;
}

#[cfg(unix)]
#[tokio::test]
async fn a_restored_folder_is_for_its_owner_only_even_if_it_was_there() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = tempfile::tempdir().unwrap();
    let (data, copy, back) = (folder.path().join("data"), folder.path().join("copy"), folder.path().join("back"));
    let server = Server::start(options(&data)).await;
    server.wait(&server.submit("one", "EVENTS 9").await).await;
    server.stop().await;
    for (verb, target, of_server) in [("backup", &copy, &data), ("restore", &back, &back)] {
        std::fs::create_dir(target).unwrap();
        std::fs::set_permissions(target, std::fs::Permissions::from_mode(0o755)).unwrap();
        let (code, text) = command(&[verb], &copy, of_server).await;
        assert_eq!(code, Some(0), "{text}");
        let mode = target.metadata().unwrap().permissions().mode() & 0o777;
        assert_eq!(mode, 0o700, "{verb}");
    }
}

/// The copy and the original number their later openings independently.
#[tokio::test]
async fn a_cursor_from_before_a_restore_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (data, copy, back) = (folder.path().join("data"), folder.path().join("backup"), folder.path().join("restored"));
    Server::start(options(&data)).await.stop().await;
    let (code, text) = command(&["backup"], &copy, &data).await;
    assert_eq!(code, Some(0), "{text}");
    let newest = async |server: &Server| {
        let refused = v1::WatchJobsRequest { after: u64::MAX, ..Default::default() };
        let refused = server.jobs().watch_jobs(refused).await.unwrap_err();
        refused.get_error_details().error_info().unwrap().metadata["last_seq"].parse::<u64>().unwrap()
    };
    let server = Server::start(options(&data)).await;
    server.wait(&server.submit("lost", "EVENTS 1").await).await;
    let cursor = newest(&server).await;
    server.stop().await;
    let (code, text) = command(&["restore"], &copy, &back).await;
    assert_eq!(code, Some(0), "{text}");
    let server = Server::start(options(&back)).await;
    for job in ["a", "b", "c"] {
        server.wait(&server.submit(job, "EVENTS 1").await).await;
    }
    let request = v1::WatchJobsRequest { after: cursor, ..Default::default() };
    assert_eq!(reason(&server.jobs().watch_jobs(request).await.unwrap_err()), "CURSOR_TOO_OLD");
    server.stop().await;
}

/// A process that holds a request for a copy of the ledger, as `backup` does, and is killed before it takes the copy.
#[tokio::test]
async fn the_copy_of_the_ledger_for_a_backup_that_was_killed_is_removed() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data");
    let server = Server::start(options(&data)).await;
    server.wait(&server.submit("one", "EVENTS 9").await).await;
    let tmp = data.join("tmp");
    let copies = || {
        std::fs::read_dir(&tmp)
            .unwrap()
            .filter(|entry| entry.as_ref().unwrap().file_name().to_string_lossy().starts_with("backup-"))
            .count()
    };
    // Each loop is a backup that is killed at another moment.
    for pause in [20, 200, 900, 1100, 1300] {
        let mut backup = Command::new(env!("CARGO_BIN_EXE_counterpointd"))
            .arg("backup")
            .arg(folder.path().join(format!("copy-{pause}")))
            .arg("--data")
            .arg(&data)
            .stdout(std::process::Stdio::null())
            .stderr(std::process::Stdio::null())
            .spawn()
            .unwrap();
        while copies() == 0 && backup.try_wait().unwrap().is_none() {
            tokio::time::sleep(std::time::Duration::from_millis(1)).await;
        }
        tokio::time::sleep(std::time::Duration::from_millis(pause)).await;
        // It may have ended.
        let _ = backup.kill();
        backup.wait().unwrap();
    }
    // A request whose copy was never taken.
    let request = tmp.join("backup-0");
    std::fs::write(&request, "held\n").unwrap();
    std::fs::write(request.with_extension("ready"), "").unwrap();
    let begin = std::time::Instant::now();
    while copies() > 0 {
        assert!(begin.elapsed().as_secs() < 20, "copies are left: {}", copies());
        tokio::time::sleep(std::time::Duration::from_millis(20)).await;
    }
    server.stop().await;
}

/// docs/operations.md: if a backup or restore is killed, its file remains, and the folder has to be removed.
#[tokio::test]
async fn a_folder_whose_backup_or_restore_was_killed_is_refused_and_named() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, empty) = (folder.path().join("whole"), folder.path().join("empty"));
    Server::start(options(&whole)).await.stop().await;
    std::fs::create_dir(&empty).unwrap();
    for data in [&whole, &empty] {
        let claim = data.join("copy-in-progress");
        std::fs::write(&claim, "").unwrap();
        let before = std::fs::read_dir(data).unwrap().count();
        let mut server = Command::new(env!("CARGO_BIN_EXE_counterpointd"));
        let refused = server.args(["--listen", "127.0.0.1:0", "--data"]).arg(data).output().unwrap();
        let text = String::from_utf8(refused.stderr).unwrap();
        assert_eq!(refused.status.code(), Some(3), "{text}");
        assert!(text.contains(claim.to_str().unwrap()) && text.contains("remove the folder"), "{text}");
        assert_eq!(std::fs::read_dir(data).unwrap().count(), before, "the server changes nothing");
        for repair in [&[][..], &["--repair"]] {
            let mut doctor = Command::new(env!("CARGO_BIN_EXE_counterpointd"));
            let examined = doctor.args(["doctor", "--data"]).arg(data).args(repair).output().unwrap();
            let found = String::from_utf8(examined.stdout).unwrap();
            assert_eq!(examined.status.code(), Some(1), "{found}");
            let first = found.lines().next().unwrap_or_default();
            let named = first.starts_with("damaged: ") && first.contains(claim.to_str().unwrap());
            assert!(named && first.contains("remove the folder"), "{found}");
            assert!(claim.exists(), "a repair does not make the content whole");
        }
    }
    let copy = folder.path().join("copy");
    let (code, text) = command(&["backup"], &copy, &whole).await;
    assert!(code == Some(3) && text.contains("copy-in-progress") && !copy.exists(), "{code:?} {text}");
}

/// docs/operations.md: `backup` of a folder without some of its blobs completes, counts them, and exits with 1.
#[tokio::test]
async fn a_backup_counts_the_blobs_that_it_has_copied_and_reports_the_others() {
    let folder = tempfile::tempdir().unwrap();
    let (data, copy) = (folder.path().join("data"), folder.path().join("backup"));
    let server = Server::start(options(&data)).await;
    for (id, program) in [("one", "EVENTS 1"), ("two", "EVENTS 2")] {
        let job = server.submit(id, program).await;
        server.wait(&job).await;
    }
    server.stop().await;
    let content = digest(b"EVENTS 2");
    std::fs::remove_file(data.join("blobs").join(&content[..2]).join(&content)).unwrap();
    let (code, text) = command(&["backup"], &copy, &data).await;
    assert!(code == Some(1) && text.starts_with("2 jobs, 1 blobs, 0 jobs left out"), "{code:?} {text}");
    assert!(text.contains("1 blobs are missing in") && text.contains("doctor"), "{text}");
    assert_eq!(examine(&copy, false).unwrap().iter().filter(|found| !found.note).count(), 1);
}

/// A backup of a stopped server has the folder for as long as it copies the ledger.
#[tokio::test]
async fn a_server_that_starts_during_a_backup_waits_for_it() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data");
    Server::start(options(&data)).await.stop().await;
    let lock = std::fs::File::options().write(true).open(data.join("lock")).unwrap();
    std::fs::write(data.join("lock"), format!("{} backup\n", std::process::id())).unwrap();
    lock.lock().unwrap();
    let waits = async {
        tokio::time::sleep(std::time::Duration::from_secs(1)).await;
        lock.unlock().unwrap();
    };
    let (server, ()) = tokio::join!(Server::try_start(options(&data), Disk::default()), waits);
    server.unwrap_or_else(|error| panic!("{error}")).stop().await;
}
