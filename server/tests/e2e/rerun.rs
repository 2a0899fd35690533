//! A job returns its inputs, and runs again from them.

use counterpoint_proto::v1;
use counterpoint_server::options::{Maxima, ServerOptions};
use tonic::Code;

use crate::support::*;

fn rerun(job_id: &str, request_id: &str) -> v1::RerunJobRequest {
    v1::RerunJobRequest { job_id: job_id.into(), request_id: request_id.into(), ..Default::default() }
}

fn everything() -> v1::JobOptions {
    let value = |value| v1::DialogValue { value: Some(value) };
    v1::JobOptions {
        opskip: vec![0, 3],
        opstop: true,
        ignore_waits: vec![2],
        threads: 3,
        limits: Some(v1::JobLimits { blocks: 77, wall_ms: 5_000, memory: 1 << 40, ..Default::default() }),
        trace: "IE".into(),
        answers: vec![v1::DialogAnswer {
            dialog: "Clamp".into(),
            button: "OK".into(),
            values: [
                ("A".to_owned(), value(v1::dialog_value::Value::Flag(true))),
                ("B".to_owned(), value(v1::dialog_value::Value::Number(1.5))),
                ("C".to_owned(), value(v1::dialog_value::Value::Text("t".into()))),
            ]
            .into(),
        }],
        attended: false,
        stepped: false,
        lint: false,
        law: true,
        parameters: "-SHIFT=2".into(),
        time: v1::TimeModel::Simple as i32,
        races: v1::RaceCheck::Warn as i32,
        warnings_off: vec![2_900_680],
        warnings_on: vec![2_900_681],
        no_cache: true,
    }
}

#[tokio::test]
async fn a_job_gives_back_what_was_submitted_and_runs_again_with_it() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let machine = server.upload(b"extends = \"fanuc-2path-lathe\"\n[ce]\nname = \"mine\"\n").await;
    let file = v1::MachineFile { path: "mine/machine.toml".into(), digest: machine };
    let put = v1::PutMachineRequest { name: "mine".into(), files: vec![file] };
    let revision = server.machines().put_machine(put).await.unwrap().into_inner().machine.unwrap().revision;
    let request = v1::SubmitJobRequest {
        machine: "mine".into(),
        options: Some(everything()),
        labels: [("part".to_owned(), "17".to_owned())].into(),
        priority: v1::JobPriority::High.into(),
        deadline_ms: i64::MAX,
        ..server.request("first", "EVENTS 5").await
    };
    let first = server.jobs().submit_job(request.clone()).await.unwrap().into_inner().status.unwrap();
    assert_eq!((first.priority(), first.deadline_ms), (v1::JobPriority::High, i64::MAX));
    let done = server.wait(&first.job_id).await;
    let get = |job: &str| v1::GetJobRequest { job_id: job.into() };
    let got = server.jobs().get_job(get(&first.job_id)).await.unwrap().into_inner();
    assert_eq!((got.files, got.options), (request.files.clone(), request.options.clone()));
    assert_eq!(got.pinned_machine, format!("mine@{revision}"));

    let again = server.jobs().rerun_job(rerun(&first.job_id, "again")).await.unwrap().into_inner();
    let status = again.status.unwrap();
    assert!(!again.duplicate && status.job_id > first.job_id);
    assert_eq!((status.rerun_of.as_str(), status.machine.as_str()), (first.job_id.as_str(), "mine"));
    assert_eq!((status.priority(), status.labels), (v1::JobPriority::High, first.labels.clone()));
    assert_eq!(status.deadline_ms, 0, "the deadline is not taken over");
    assert_eq!(server.wait(&status.job_id).await.log_digest, done.log_digest);
    let got = server.jobs().get_job(get(&status.job_id)).await.unwrap().into_inner();
    assert_eq!((got.files, got.options), (request.files, request.options));
    assert_eq!(got.pinned_machine, format!("mine@{revision}"));

    let same = server.jobs().rerun_job(rerun(&first.job_id, "again")).await.unwrap().into_inner();
    assert!(same.duplicate && same.status.unwrap().job_id == status.job_id);
    let other = v1::RerunJobRequest { priority: v1::JobPriority::Low.into(), ..rerun(&first.job_id, "again") };
    let refused = server.jobs().rerun_job(other).await.unwrap_err();
    assert_eq!((refused.code(), reason(&refused).as_str()), (Code::AlreadyExists, "REQUEST_ID_REUSED"));
    let refused = server.jobs().rerun_job(rerun("0190-none", "r")).await.unwrap_err();
    assert_eq!(reason(&refused), "UNKNOWN_JOB");

    // It needs nothing of the earlier job that goes with it.
    server.jobs().delete_job(v1::DeleteJobRequest { job_id: first.job_id }).await.unwrap();
    let third = server.jobs().rerun_job(rerun(&status.job_id, "third")).await.unwrap().into_inner().status.unwrap();
    assert_eq!(server.wait(&third.job_id).await.log_digest, done.log_digest);
    server.stop().await;
}

/// Values that the server fills in are not part of the request, so they may change from one version to the next.
#[tokio::test]
async fn other_maxima_of_the_server_do_not_make_a_request_another_one() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let mut request = server.request("r", "EVENTS 5").await;
    request.options = Some(everything());
    let first = server.jobs().submit_job(request.clone()).await.unwrap().into_inner().status.unwrap().job_id;
    let plain = server.request("plain", "EVENTS 5").await;
    let second = server.jobs().submit_job(plain.clone()).await.unwrap().into_inner().status.unwrap().job_id;
    server.wait(&first).await;
    server.wait(&second).await;
    server.stop().await;
    let maxima = Maxima { max_blocks: 9, max_nesting: 3, max_memory: 1 << 20, ..Maxima::default() };
    let server = Server::start(ServerOptions { maxima, ..options(folder.path()) }).await;
    for (request, job) in [(request, &first), (plain, &second)] {
        let again = server.jobs().submit_job(request).await.unwrap().into_inner();
        assert!(again.duplicate && again.status.unwrap().job_id == *job);
    }
    // A new run has the limits of now.
    let third = server.jobs().rerun_job(rerun(&first, "third")).await.unwrap().into_inner().status.unwrap();
    server.wait(&third.job_id).await;
    let limits = server.script.limits.lock().unwrap().clone().unwrap();
    assert_eq!((limits.blocks, limits.nesting, limits.memory), (9, 3, 1 << 20));
    server.stop().await;
}

/// The client knows the names of its files, and has them.
#[tokio::test]
async fn a_rerun_whose_files_are_lost_names_them() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let job = server.submit("first", "EVENTS 5").await;
    server.wait(&job).await;
    let name = digest(b"EVENTS 5");
    std::fs::remove_file(folder.path().join("blobs").join(&name[..2]).join(&name)).unwrap();
    let refused = server.jobs().rerun_job(rerun(&job, "second")).await.unwrap_err();
    assert_eq!((reason(&refused).as_str(), refused.code()), ("MISSING_BLOBS", Code::FailedPrecondition));
    assert_eq!(refused.message(), "the server no longer has 'main.nc': submit the programs again");
    server.stop().await;
}
