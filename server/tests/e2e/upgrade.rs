//! Ledgers of other versions of the server.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::Ordering;

use counterpoint_proto::v1;
use counterpoint_proto::v1::watch_job_response::Content;
use counterpoint_server::options::{Quotas, ServerOptions};
use counterpoint_server::service;
use redb::{ReadableDatabase, ReadableTable, TableDefinition};
use serde_json::{Value, json};

use crate::support::*;

const JOB: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("job");
const REQUEST: TableDefinition<'_, &str, &str> = TableDefinition::new("request_id");
const MACHINE: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("machine");
const MACHINE_BYTES: TableDefinition<'_, &str, u64> = TableDefinition::new("machine_bytes");
const META: TableDefinition<'_, &str, u64> = TableDefinition::new("meta");

/// The schema of this version.
const NOW: u64 = 10;

/// A row as schema 1 began: without answers, limits of the server and counters of the host.
pub fn row_1(id: &str, request: &str, state: &str, script: &str) -> Value {
    let ended = !matches!(state, "QUEUED" | "RUNNING");
    json!({
        "id": id, "request_id": request, "content": "c",
        "machine_name": "fanuc-2path-lathe", "machine": {"name": "fanuc-2path-lathe", "files": {}},
        "programs": [{"file": "main.nc", "number": null, "channel": null}],
        "files": [["main.nc", digest(script.as_bytes())]],
        "options": {
            "opskip": [], "opstop": false, "ignore_waits": [], "threads": 0,
            "limits": {
                "simulated_ns": 86_400_000_000_000_i64, "blocks": 10_000_000, "zero_time_blocks": 1_000_000,
                "events": 40_000_000, "block_length": 8192, "nesting": 32, "diagnostics": 1000
            }
        },
        "state": state, "attempt": u32::from(state != "QUEUED"), "cancel": false,
        "submitted_ms": 1_700_000_000_000_i64, "started_ms": if state == "QUEUED" { 0 } else { 1_700_000_000_001_i64 },
        "ended_ms": if ended { 1_700_000_000_002_i64 } else { 0 },
        "events": 0, "makespan_ns": 0, "highest_severity": 0, "verdict": "", "error": "", "findings": [],
        "log_digest": ""
    })
}

/// Writes a ledger of a schema with these rows.
pub fn write_ledger(folder: &Path, schema: u64, rows: &[Value]) {
    let path = folder.join("ledger.redb");
    let _ = std::fs::remove_file(&path);
    let database = redb::Database::create(path).unwrap();
    let txn = database.begin_write().unwrap();
    txn.open_table(MACHINE).unwrap();
    txn.open_table(META).unwrap().insert("schema", schema).unwrap();
    for row in rows {
        let (id, request) = (row["id"].as_str().unwrap(), row["request_id"].as_str().unwrap());
        txn.open_table(JOB).unwrap().insert(id, row.to_string().as_bytes()).unwrap();
        txn.open_table(REQUEST).unwrap().insert(request, id).unwrap();
    }
    txn.commit().unwrap();
}

fn schema(folder: &Path) -> u64 {
    let database = redb::Database::open(folder.join("ledger.redb")).unwrap();
    let meta = database.begin_read().unwrap().open_table(META).unwrap();
    meta.get("schema").unwrap().unwrap().value()
}

/// A folder as a server of schema 1 left it: a job that has ended, one that was running, one that waited.
pub async fn folder_1(folder: &Path) -> BTreeMap<&'static str, String> {
    let server = Server::start(options(folder)).await;
    let ended = server.submit("ended", "EVENTS 700").await;
    let status = server.wait(&ended).await;
    server.upload(b"EVENTS 7").await;
    server.stop().await;
    assert!(folder.join("jobs").join(&ended).join("log").is_file(), "schema 1 has logs in files");
    let mut done = row_1(&ended, "ended", "SUCCEEDED", "EVENTS 700");
    done["events"] = status.events.into();
    done["makespan_ns"] = status.makespan_ns.into();
    done["log_digest"] = status.log_digest.into();
    let id = |n: u8| format!("ffffffff-ffff-7fff-bfff-0000000000{n:02}");
    write_ledger(
        folder,
        1,
        &[done, row_1(&id(1), "running", "RUNNING", "EVENTS 700"), row_1(&id(2), "queued", "QUEUED", "EVENTS 7")],
    );
    BTreeMap::from([("ended", ended), ("running", id(1)), ("queued", id(2))])
}

#[tokio::test]
async fn a_ledger_of_schema_1_is_opened_and_its_jobs_are_listed_watched_and_finished() {
    let folder = tempfile::tempdir().unwrap();
    let jobs = folder_1(folder.path()).await;
    let server = Server::start(options(folder.path())).await;
    let listed = server.jobs().list_jobs(v1::ListJobsRequest::default()).await.unwrap().into_inner().jobs;
    let listed: Vec<_> = listed.into_iter().map(|job| job.job_id).collect();
    assert_eq!(listed, [&jobs["ended"], &jobs["running"], &jobs["queued"]].map(Clone::clone));
    for (name, events, attempt) in [("ended", 700, 1), ("running", 700, 2), ("queued", 7, 1)] {
        let status = server.wait(&jobs[name]).await;
        assert_eq!((status.state(), status.events), (v1::JobState::Succeeded, events), "{name}: {status:?}");
        assert_eq!(status.attempt, attempt, "{name}");
        let mut watch = server.watch(&jobs[name], 0, v1::WatchLevel::Everything).await;
        let mut seen = 0;
        while let Some(message) = watch.message().await.unwrap() {
            if let Some(Content::Batch(batch)) = message.content {
                seen += batch.events.len() as u64;
            }
        }
        assert_eq!(seen, events, "{name}");
    }
    server.jobs().delete_job(v1::DeleteJobRequest { job_id: jobs["ended"].clone() }).await.unwrap();
    server.script.hang.store(false, Ordering::SeqCst);
    let next = server.submit("next", "EVENTS 3").await;
    assert!(next > jobs["queued"], "order goes on behind the rows that were there");
    server.wait(&next).await;
    server.stop().await;
    assert!(schema(folder.path()) > 1, "a server of schema 1 must not open rows that it does not know");
    let server = Server::start(options(folder.path())).await;
    assert_eq!(server.status(&next).await.events, 3);
    server.stop().await;
}

const LOG: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("log");
const WORK: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("work");
const BLOB: TableDefinition<'_, &str, u64> = TableDefinition::new("blob");
const ENDED: TableDefinition<'_, (i64, &str), u64> = TableDefinition::new("ended");
const ENDED_7: TableDefinition<'_, (i64, &str), (u64, &str)> = TableDefinition::new("ended_jobs");
const USAGE: TableDefinition<'_, &str, (u64, u64, u64)> = TableDefinition::new("usage");

/// A folder as a server of a schema left it: two jobs that have ended, one of them with a small log, one running job
/// and one waiting job. Returns their identities by request id.
const SCRIPTS: [(&str, &str, u64); 4] = [
    ("ended", "EVENTS 2000", 2000),
    ("small", "EVENTS 9", 9),
    ("running", "EVENTS 1990\nHANG", 1990),
    ("queued", "EVENTS 7", 7),
];

async fn folder_of(folder: &Path, schema: u64) -> BTreeMap<&'static str, String> {
    let server = Server::start(ServerOptions { workers: 1, ..options(folder) }).await;
    let mut jobs = BTreeMap::new();
    let mut rows = Vec::new();
    for (name, script, _) in SCRIPTS[..2].iter().copied() {
        let job = server.submit(name, script).await;
        let status = server.wait(&job).await;
        let mut row = row_1(&job, name, "SUCCEEDED", script);
        row["events"] = status.events.into();
        row["makespan_ns"] = status.makespan_ns.into();
        row["log_digest"] = status.log_digest.into();
        rows.push(row);
        jobs.insert(name, job);
    }
    if schema >= 6 {
        for (name, script, _) in &SCRIPTS[2..] {
            jobs.insert(*name, server.submit(name, script).await);
        }
        server.until_events(&jobs["running"], 1990).await;
        server.stop().await;
        back_to_9(folder);
        if schema <= 8 {
            back_to_8(folder);
        }
        if schema <= 7 {
            back_to_7(folder);
        }
        if schema == 6 {
            back_to_6(folder);
        }
        return jobs;
    }
    for (_, script, _) in &SCRIPTS[2..] {
        server.upload(script.as_bytes()).await;
    }
    server.stop().await;
    let small = jobs["small"].clone();
    let small = small.as_str();
    let log = {
        let database = redb::Database::open(folder.join("ledger.redb")).unwrap();
        let logs = database.begin_read().unwrap().open_table(LOG).unwrap();
        logs.get(small).unwrap().unwrap().value()[5..].to_vec()
    };
    for ((name, script, _), state) in SCRIPTS[2..].iter().copied().zip(["RUNNING", "QUEUED"]) {
        let id = format!("ffffffff-ffff-7fff-bfff-0000000000{:02}", rows.len());
        rows.push(row_1(&id, name, state, script));
        jobs.insert(name, id);
    }
    if schema >= 4 {
        for row in &mut rows {
            row["host_failures"] = 0.into();
            row["host_failure"] = "".into();
            row["wall_ms"] = 0.into();
            row["stored_bytes"] = 10.into();
        }
    }
    if schema >= 5 {
        rows.iter_mut().for_each(|row| row["machine"]["trusted"] = true.into());
    }
    if schema == 1 {
        let path = folder.join("jobs").join(small);
        std::fs::create_dir_all(&path).unwrap();
        std::fs::write(path.join("log"), &log).unwrap();
    }
    write_ledger(folder, schema, &rows);
    let database = redb::Database::open(folder.join("ledger.redb")).unwrap();
    let txn = database.begin_write().unwrap();
    if schema >= 2 {
        txn.open_table(LOG).unwrap().insert(small, log.as_slice()).unwrap();
    }
    if schema >= 3 {
        let mut counts = txn.open_table(BLOB).unwrap();
        for (_, script, _) in SCRIPTS {
            counts.insert(digest(script.as_bytes()).as_str(), 1).unwrap();
        }
    }
    if schema >= 4 {
        for name in ["ended", "small"] {
            txn.open_table(ENDED).unwrap().insert((1_700_000_000_002, jobs[name].as_str()), 10).unwrap();
        }
    }
    txn.commit().unwrap();
    jobs
}

/// Gives a ledger of schema 10 the form of schema 9: rows have no checksums, nor have the files of macros.
fn back_to_9(folder: &Path) {
    let database = redb::Database::open(folder.join("ledger.redb")).unwrap();
    let txn = database.begin_write().unwrap();
    for table in [JOB, WORK, MACHINE, LOG] {
        let mut rows = txn.open_table(table).unwrap();
        let all: Vec<(String, Vec<u8>)> = rows
            .iter()
            .unwrap()
            .map(|row| row.map(|(key, row)| (key.value().to_owned(), row.value()[5..].to_vec())).unwrap())
            .collect();
        for (key, row) in all {
            rows.insert(key.as_str(), row.as_slice()).unwrap();
        }
    }
    let mut meta = txn.open_table(META).unwrap();
    meta.insert("schema", 9).unwrap();
    meta.remove("files").unwrap();
    drop(meta);
    txn.commit().unwrap();
}

/// Gives a ledger of schema 9 the form of schema 8: the bytes of requests and machines do not count.
fn back_to_8(folder: &Path) {
    let database = redb::Database::open(folder.join("ledger.redb")).unwrap();
    let txn = database.begin_write().unwrap();
    txn.delete_table(MACHINE_BYTES).unwrap();
    txn.open_table(META).unwrap().insert("schema", 8).unwrap();
    txn.commit().unwrap();
}

/// Gives a ledger of schema 8 the form of schema 7: the work of each job is in the row of the job.
fn back_to_7(folder: &Path) {
    let database = redb::Database::open(folder.join("ledger.redb")).unwrap();
    let txn = database.begin_write().unwrap();
    {
        let (works, mut jobs) = (txn.open_table(WORK).unwrap(), txn.open_table(JOB).unwrap());
        for work in works.iter().unwrap() {
            let (id, work) = work.unwrap();
            let mut row: Value = serde_json::from_slice(jobs.get(id.value()).unwrap().unwrap().value()).unwrap();
            let work: Value = serde_json::from_slice(work.value()).unwrap();
            let row = row.as_object_mut().unwrap();
            row.retain(|key, _| key != "attended" && key != "stepped");
            row.extend(work.as_object().unwrap().clone());
            jobs.insert(id.value(), Value::from(row.clone()).to_string().as_bytes()).unwrap();
        }
    }
    txn.delete_table(WORK).unwrap();
    txn.open_table(META).unwrap().insert("schema", 7).unwrap();
    txn.commit().unwrap();
}

/// Gives a ledger of schema 7 the form of schema 6: ended jobs without tenants, times of tenants in ms.
fn back_to_6(folder: &Path) {
    let database = redb::Database::open(folder.join("ledger.redb")).unwrap();
    let txn = database.begin_write().unwrap();
    {
        let (now, mut before) = (txn.open_table(ENDED_7).unwrap(), txn.open_table(ENDED).unwrap());
        for row in now.iter().unwrap() {
            let (key, row) = row.unwrap();
            before.insert(key.value(), row.value().0).unwrap();
        }
        let mut usage = txn.open_table(USAGE).unwrap();
        let (bytes, day, _) = usage.get("default").unwrap().unwrap().value();
        usage.insert("default", (bytes, day, 5_000)).unwrap();
    }
    txn.delete_table(ENDED_7).unwrap();
    txn.open_table(META).unwrap().insert("schema", 6).unwrap();
    txn.commit().unwrap();
}

/// Five seconds of a tenant that a ledger of schema 6 has in ms count as five.
#[tokio::test]
async fn the_time_that_tenants_have_used_keeps_its_unit() {
    let folder = tempfile::tempdir().unwrap();
    folder_of(folder.path(), 6).await;
    let quota =
        |tenant_cpu_s| ServerOptions { quotas: Quotas { tenant_cpu_s, ..Quotas::default() }, ..options(folder.path()) };
    let server = Server::start(quota(6)).await;
    let request = server.request("above", "EVENTS 1").await;
    server.submit("below", "EVENTS 1").await;
    server.stop().await;
    let server = Server::start(quota(5)).await;
    assert_eq!(reason(&server.jobs().submit_job(request).await.unwrap_err()), "QUOTA_EXCEEDED");
    server.stop().await;
}

#[tokio::test]
async fn ledgers_of_all_earlier_schemas_are_opened_and_their_jobs_found_finished_and_run_again() {
    for schema in 1..NOW {
        let folder = tempfile::tempdir().unwrap();
        let jobs = folder_of(folder.path(), schema).await;
        let server = Server::start(options(folder.path())).await;
        server.script.hang.store(false, Ordering::SeqCst);
        for (name, _, count) in SCRIPTS {
            let status = server.wait(&jobs[name]).await;
            let expected = (v1::JobState::Succeeded, count, "default");
            assert_eq!((status.state(), status.events, status.tenant.as_str()), expected, "{schema}: {name}");
            assert_eq!(server.events(&jobs[name], 0).await.len() as u64, count, "{schema}: {name}");
        }
        let list = async |filter: v1::JobFilter| {
            let request = v1::ListJobsRequest { filter: Some(filter), newest_first: true, ..Default::default() };
            let jobs = server.jobs().list_jobs(request).await.unwrap().into_inner().jobs;
            jobs.into_iter().map(|job| job.request_id).collect::<Vec<_>>().join(" ")
        };
        let machine = v1::JobFilter { machine: "fanuc-2path-lathe".into(), ..Default::default() };
        assert_eq!(list(machine).await, "queued running small ended", "{schema}");
        let succeeded = v1::JobFilter { states: vec![v1::JobState::Succeeded.into()], ..Default::default() };
        assert_eq!(list(succeeded).await, "queued running small ended", "{schema}");
        // The request ids of the jobs are known, and mean the same.
        for (name, script, _) in SCRIPTS {
            let request = server.request(name, script).await;
            let again = server.jobs().submit_job(request.clone()).await.unwrap().into_inner();
            assert!(again.duplicate && again.status.unwrap().job_id == jobs[name], "{schema}: {name}");
            let other = v1::SubmitJobRequest { machine: "fanuc-mill".into(), ..request };
            let refused = server.jobs().submit_job(other).await.unwrap_err();
            assert_eq!(reason(&refused), "REQUEST_ID_REUSED", "{schema}: {name}");
        }
        let rerun =
            v1::RerunJobRequest { job_id: jobs["small"].clone(), request_id: "again".into(), ..Default::default() };
        let again = server.jobs().rerun_job(rerun).await.unwrap().into_inner().status.unwrap().job_id;
        assert_eq!(server.wait(&again).await.events, 9, "{schema}");
        server.jobs().delete_job(v1::DeleteJobRequest { job_id: jobs["ended"].clone() }).await.unwrap();
        server.stop().await;
        assert_eq!(counterpoint_server::doctor::examine(folder.path(), false).unwrap(), [], "{schema}");
        assert_eq!(self::schema(folder.path()), NOW, "a later schema needs a folder of this one here");
    }
}

/// A job that has waited for its operator in a ledger of schema 7 is attended in this version, with the answers that it
/// has received, and its list entry says nothing about its options.
#[tokio::test]
async fn an_attended_job_of_an_earlier_schema_keeps_its_options_and_answers() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let request = server.request("attended", "ASK One\nASK Two").await;
    let options_7 = v1::JobOptions { attended: true, stepped: true, opskip: vec![3], ..Default::default() };
    let request = v1::SubmitJobRequest { options: Some(options_7.clone()), ..request };
    let job = server.jobs().submit_job(request.clone()).await.unwrap().into_inner().status.unwrap().job_id;
    server.jobs().pause_job(v1::PauseJobRequest { job_id: job.clone() }).await.unwrap();
    server.stop().await;
    back_to_9(folder.path());
    back_to_8(folder.path());
    back_to_7(folder.path());
    let database = redb::Database::open(folder.path().join("ledger.redb")).unwrap();
    let txn = database.begin_write().unwrap();
    {
        let mut jobs = txn.open_table(JOB).unwrap();
        let mut row: Value = serde_json::from_slice(jobs.get(job.as_str()).unwrap().unwrap().value()).unwrap();
        let answer = |name: &str| json!([1, {"dialog": name, "button": format!("{name}-ok"), "values": {}}]);
        row["answers"] = json!([answer("One"), answer("Two")]);
        jobs.insert(job.as_str(), row.to_string().as_bytes()).unwrap();
    }
    txn.commit().unwrap();
    drop(database);
    let server = Server::start(options(folder.path())).await;
    let got = server.jobs().get_job(v1::GetJobRequest { job_id: job.clone() }).await.unwrap().into_inner();
    assert_eq!(got.options.map(|options| v1::JobOptions { limits: None, ..options }), Some(options_7));
    assert!(server.jobs().submit_job(request).await.unwrap().into_inner().duplicate);
    server.jobs().resume_job(v1::ResumeJobRequest { job_id: job.clone() }).await.unwrap();
    assert_eq!(server.wait(&job).await.state(), v1::JobState::Succeeded);
    let texts = server.events(&job, 0).await.into_iter().filter_map(|event| match event.kind {
        Some(v1::event::Kind::Diagnostic(diagnostic)) => Some(diagnostic.text),
        _ => None,
    });
    assert_eq!(texts.collect::<Vec<_>>(), ["One: One-ok", "Two: Two-ok"]);
    server.stop().await;
}

#[tokio::test]
async fn a_ledger_of_a_later_schema_is_refused_and_not_touched() {
    let folder = tempfile::tempdir().unwrap();
    write_ledger(folder.path(), 999, &[]);
    let refused = match service::build_with(options(folder.path()), Script::default()).await {
        Ok(_) => panic!("the server must not start"),
        Err(error) => error.to_string(),
    };
    for part in ["ledger.redb", "schema 999", "later version", "backup"] {
        assert!(refused.contains(part), "{refused}");
    }
    assert_eq!(schema(folder.path()), 999);
}

/// Files of macros were stored without a checksum before schema 10.
#[tokio::test]
async fn files_of_macros_of_an_earlier_schema_get_a_checksum() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let job = server.submit("r", "EVENTS 2\nWRITE a.txt").await;
    server.wait(&job).await;
    server.stop().await;
    back_to_9(folder.path());
    let path = folder.path().join("jobs").join(&job).join("files.json");
    let sealed = std::fs::read(&path).unwrap();
    std::fs::write(&path, &sealed[20..]).unwrap();
    assert!(serde_json::from_slice::<Value>(&sealed[20..]).is_ok());
    assert_eq!(counterpoint_server::doctor::examine(folder.path(), false).unwrap(), [], "of the earlier schema");
    let server = Server::start(options(folder.path())).await;
    assert_eq!(std::fs::read(&path).unwrap(), sealed);
    let list = v1::ListFilesRequest { job_id: job.clone(), ..Default::default() };
    let files = server.results().list_files(list.clone()).await.unwrap().into_inner().files;
    assert_eq!(files.iter().map(|file| file.path.as_str()).collect::<Vec<_>>(), ["a.txt"]);
    // From now on one without a checksum is damaged.
    std::fs::write(&path, &sealed[20..]).unwrap();
    let refused = server.results().list_files(list).await.unwrap_err();
    assert!(reason(&refused) == "DATA_LOSS" && refused.message().contains(&job), "{refused}");
    server.stop().await;
}
