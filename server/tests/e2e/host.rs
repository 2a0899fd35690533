//! Troubles of the host that are not the disk's: clocks, folders that cannot be written, threads that do not start.

use std::os::unix::fs::PermissionsExt as _;
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use counterpoint_proto::v1;
use counterpoint_proto::v1::admin_client::AdminClient;
use counterpoint_server::doctor::examine_on;
use counterpoint_server::local::disk::{Disk, DiskOperation, Faults};
use counterpoint_server::options::{Retention, ServerOptions};
use redb::{ReadableDatabase as _, ReadableTable as _, TableDefinition};
use rustix::process::{Pid, Resource, Rlimit, getuid, prlimit};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;

use crate::descriptors::Process;
use crate::support::*;

const META: TableDefinition<'_, &str, u64> = TableDefinition::new("meta");
const HOUR_MS: u64 = 3_600_000;

fn now_ms() -> u64 {
    u64::try_from(SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_millis()).unwrap()
}

/// The clock was 40 years ahead when an earlier server ran, and has been set back.
#[tokio::test]
async fn after_a_clock_that_was_set_back_jobs_end_at_the_right_time_and_grow_old() {
    let folder = tempfile::tempdir().unwrap();
    let retention = Retention { keep_s: 2, ..Retention::default() };
    let options = ServerOptions { retention, ..options(folder.path()) };
    let server = Server::start(options.clone()).await;
    server.stop().await;
    let ahead = now_ms() + 40 * 365 * 24 * HOUR_MS;
    let clock = |set: Option<u64>| {
        let database = redb::Database::open(folder.path().join("ledger.redb")).unwrap();
        if let Some(ms) = set {
            let txn = database.begin_write().unwrap();
            txn.open_table(META).unwrap().insert("clock_ms", ms).unwrap();
            txn.commit().unwrap();
        }
        database.begin_read().unwrap().open_table(META).unwrap().get("clock_ms").unwrap().map(|row| row.value())
    };
    clock(Some(ahead));
    let server = Server::start(options.clone()).await;
    for name in ["one", "two"] {
        let job = server.submit(name, "EVENTS 1").await;
        let v1::JobStatus { submitted_ms, started_ms, ended_ms, .. } = server.wait(&job).await;
        assert!(submitted_ms <= started_ms && started_ms <= ended_ms, "{submitted_ms} {started_ms} {ended_ms}");
        assert!(u64::try_from(ended_ms).unwrap() < ahead, "the status shows the clock");
        is_gone(&server, &job).await;
    }
    server.stop().await;
    let after = clock(None).unwrap();
    assert!(after > ahead + 4000, "the time of two jobs is kept: {after}");
    let server = Server::start(options).await;
    let job = server.submit("three", "EVENTS 1").await;
    server.wait(&job).await;
    is_gone(&server, &job).await;
    server.stop().await;
}

/// The clock shows a month more than when an earlier server ran: that is wrong, or the server was off for a month.
#[tokio::test]
async fn no_job_is_removed_because_of_a_clock_that_has_just_jumped_ahead() {
    let folder = tempfile::tempdir().unwrap();
    let retention = Retention { keep_s: 24 * 3600, ..Retention::default() };
    let options = ServerOptions { retention, ..options(folder.path()) };
    let server = Server::start(options.clone()).await;
    let job = server.submit("old", "EVENTS 1").await;
    server.wait(&job).await;
    server.stop().await;
    let month = i64::try_from(30 * 24 * HOUR_MS).unwrap();
    make_older(folder.path(), month);
    let server = Server::start(options).await;
    let mut admin = AdminClient::new(server.connection.clone());
    let removed = admin.collect(v1::CollectRequest {}).await.unwrap().into_inner();
    assert_eq!(removed.jobs, 0, "the jump of the clock is not confirmed");
    let young = server.submit("young", "EVENTS 1").await;
    let status = server.wait(&young).await;
    assert!(status.ended_ms > i64::try_from(now_ms()).unwrap() - month / 2, "the status shows the clock");
    server.stop().await;
}

/// Waits until a job has been removed.
async fn is_gone(server: &Server, job: &str) {
    let gone = async {
        while server.jobs().get_job(v1::GetJobRequest { job_id: job.to_owned() }).await.is_ok() {
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    };
    tokio::time::timeout(Duration::from_secs(30), gone).await.expect("the job grows old");
}

/// Makes the ledger and the ends in it older.
fn make_older(folder: &Path, by_ms: i64) {
    const ENDED: TableDefinition<'_, (i64, &str), (u64, &str)> = TableDefinition::new("ended_jobs");
    let database = redb::Database::open(folder.join("ledger.redb")).unwrap();
    let txn = database.begin_write().unwrap();
    {
        let mut meta = txn.open_table(META).unwrap();
        let clock = meta.get("clock_ms").unwrap().unwrap().value();
        meta.insert("clock_ms", clock - u64::try_from(by_ms).unwrap()).unwrap();
        let mut ended = txn.open_table(ENDED).unwrap();
        let ((ms, id), value) = {
            let (key, value) = ended.first().unwrap().unwrap();
            ((key.value().0, key.value().1.to_owned()), (value.value().0, value.value().1.to_owned()))
        };
        ended.remove((ms, id.as_str())).unwrap();
        ended.insert((ms - by_ms, id.as_str()), (value.0, value.1.as_str())).unwrap();
    }
    txn.commit().unwrap();
}

/// The command as a user that cannot write the folder.
fn as_reader(arguments: &[&str], folder: &Path) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_counterpointd"));
    if getuid().is_root() {
        command.uid(65_534).gid(65_534);
    }
    let output = command.args(arguments).arg("--data").arg(folder).output().unwrap();
    (output.status.code(), String::from_utf8([output.stdout, output.stderr].concat()).unwrap())
}

/// Sets the modes of a folder and all that is in it.
fn modes(folder: &Path, of_folders: u32, of_files: u32) {
    std::fs::set_permissions(folder, std::fs::Permissions::from_mode(0o700)).unwrap();
    for entry in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        match entry.is_dir() {
            true => modes(&entry, of_folders, of_files),
            false => std::fs::set_permissions(&entry, std::fs::Permissions::from_mode(of_files)).unwrap(),
        }
    }
    std::fs::set_permissions(folder, std::fs::Permissions::from_mode(of_folders)).unwrap();
}

#[tokio::test]
async fn a_folder_that_cannot_be_written_is_examined_and_restore_and_start_say_so() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::set_permissions(folder.path(), std::fs::Permissions::from_mode(0o755)).unwrap();
    let (data, empty) = (folder.path().join("data"), folder.path().join("empty"));
    let server = Server::start(options(&data)).await;
    for (name, script) in [("small", "EVENTS 3"), ("large", "EVENTS 3000\nWRITE a.txt")] {
        let job = server.submit(name, script).await;
        server.wait(&job).await;
    }
    server.stop().await;
    std::fs::create_dir(&empty).unwrap();
    for with_lock in [true, false] {
        modes(&data, 0o555, 0o444);
        modes(&empty, 0o555, 0o444);
        let examined = as_reader(&["doctor"], &data);
        let repaired = as_reader(&["doctor", "--repair"], &data);
        let restored = as_reader(&["restore", data.to_str().unwrap()], &empty);
        let started = as_reader(&["--listen", "127.0.0.1:0"], &data);
        modes(&data, 0o755, 0o644);
        modes(&empty, 0o755, 0o644);
        assert!(examined.0 == Some(0) && examined.1.contains("0 damaged"), "{with_lock}: {examined:?}");
        assert!(restored.0 == Some(3) && restored.1.contains("cannot be written"), "{with_lock}: {restored:?}");
        assert!(started.0 == Some(3) && started.1.contains("data folder"), "{with_lock}: {started:?}");
        for refused in [repaired, started] {
            assert_eq!(refused.0, Some(3), "{with_lock}: {refused:?}");
            for part in [data.to_str().unwrap(), "Permission denied", "as the user that owns"] {
                assert!(refused.1.contains(part), "{with_lock} {part}: {refused:?}");
            }
            assert!(!refused.1.contains(" mv "), "it has no damage: {refused:?}");
        }
        let _ = std::fs::remove_file(data.join("lock"));
    }
}

/// A single file that the user of the server may not use, as after a restore by root.
#[tokio::test]
async fn a_file_that_cannot_be_used_is_named_and_is_no_damage() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::set_permissions(folder.path(), std::fs::Permissions::from_mode(0o755)).unwrap();
    let data = folder.path().join("data");
    let server = Server::start(options(&data)).await;
    let job = server.submit("large", "EVENTS 3000").await;
    server.wait(&job).await;
    server.stop().await;
    modes(&data, 0o777, 0o666);
    let log = log_file(&data, &job);
    let set = |path: &Path, mode| std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode)).unwrap();
    const EXAMINE: &[&str] = &["doctor"];
    const REPAIR: &[&str] = &["doctor", "--repair"];
    for (file, mode, commands) in [
        (data.join("ledger.redb"), 0o400, vec![EXAMINE, REPAIR]),
        (data.join("ledger.redb"), 0o444, vec![REPAIR]),
        (log, 0o400, vec![EXAMINE, REPAIR]),
        (data.join("jobs"), 0o555, vec![REPAIR]),
    ] {
        let before = file.metadata().unwrap().permissions().mode();
        set(&file, mode);
        for command in commands {
            let (code, text) = as_reader(command, &data);
            assert_eq!(code, Some(3), "{}: {text}", file.display());
            assert!(text.contains(file.to_str().unwrap()) && text.contains("as the user that owns"), "{text}");
            assert!(!text.contains("damaged") && !text.contains(" mv "), "{text}");
        }
        set(&file, before);
    }
    assert_eq!(as_reader(&["doctor", "--repair"], &data).0, Some(0));
}

/// A disk without room for anything, or on which nothing can be written.
struct Refusing(std::io::ErrorKind);

impl Faults for Refusing {
    fn before(&self, step: DiskOperation, _path: &Path) -> std::io::Result<usize> {
        match step {
            DiskOperation::Write(_) | DiskOperation::Resize(_) => Err(self.0.into()),
            _ => Ok(usize::MAX),
        }
    }
}

#[tokio::test]
async fn a_repair_and_a_start_on_a_full_or_read_only_disk_name_the_file_and_the_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    for n in 0..200 {
        server.submit(&format!("{n}"), "EVENTS 3").await;
    }
    server.stop().await;
    let ledger = folder.path().join("ledger.redb");
    for (kind, remedy) in [
        (std::io::ErrorKind::StorageFull, "make room"),
        (std::io::ErrorKind::ReadOnlyFilesystem, "mount its file system"),
    ] {
        let disk = || Disk::faulty(Arc::new(Refusing(kind)));
        for damaged in [false, true] {
            let whole = std::fs::read(&ledger).unwrap();
            if damaged {
                std::fs::write(&ledger, [&whole[..], b"x"].concat()).unwrap();
            }
            let repaired = examine_on(folder.path(), true, disk()).unwrap_err();
            assert!(repaired.contains(ledger.to_str().unwrap()) && repaired.contains(remedy), "{repaired}");
            assert!(!repaired.contains(" mv ") && !ledger.with_extension("redb.new").exists(), "{repaired}");
            std::fs::write(&ledger, whole).unwrap();
        }
        let started = Server::try_start(options(folder.path()), disk()).await.err().unwrap().to_string();
        assert!(started.contains(ledger.to_str().unwrap()) && started.contains(remedy), "{started}");
        assert!(!started.contains(" mv "), "{started}");
    }
    assert_eq!(examine_on(folder.path(), true, Disk::default()), Ok(Vec::new()));
}

/// Asks for `/readyz`.
async fn ready(address: &str) -> String {
    let mut stream = TcpStream::connect(address).await.unwrap();
    stream.write_all(b"GET /readyz HTTP/1.1\r\nhost: x\r\nconnection: close\r\n\r\n").await.unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).await.unwrap();
    answer
}

#[tokio::test]
async fn a_server_whose_kernels_cannot_start_is_not_ready_and_says_why() {
    let folder = tempfile::tempdir().unwrap();
    let port = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    let process = Process::start_with(folder.path(), &["--metrics", &port]);
    assert!(ready(&port).await.contains("200 OK"));
    let id = process.child.id();
    let pid = Pid::from_raw(i32::try_from(id).unwrap());
    let status = std::fs::read_to_string(format!("/proc/{id}/status")).unwrap();
    let size = status.lines().find_map(|line| line.strip_prefix("VmSize:")).unwrap();
    let used: u64 = size.trim().trim_end_matches(" kB").parse().unwrap();
    let limit = |current| Rlimit { current, maximum: None };
    prlimit(pid, Resource::As, limit(Some(used * 1024 + (1 << 20)))).unwrap();
    let answer = ready(&port).await;
    assert!(answer.contains("503") && answer.contains("no thread for a kernel can be started"), "{answer}");
    prlimit(pid, Resource::As, limit(None)).unwrap();
    assert!(ready(&port).await.contains("200 OK"));
}
