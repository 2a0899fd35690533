//! Submitting: identity, admission, blobs, paths, machines.

use counterpoint_proto::v1;
use tonic::Code;
use tonic_types::StatusExt;

use crate::support::*;

#[tokio::test]
async fn the_same_request_gives_the_same_job_and_other_content_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let request = server.request("r-1", "EVENTS 10").await;
    let first = server.jobs().submit_job(request.clone()).await.unwrap().into_inner();
    let again = server.jobs().submit_job(request.clone()).await.unwrap().into_inner();
    assert!(!first.duplicate && again.duplicate);
    let id = first.status.unwrap().job_id;
    assert_eq!(id, again.status.unwrap().job_id);
    let other = v1::SubmitJobRequest {
        options: Some(v1::JobOptions { opstop: true, ..Default::default() }),
        ..request.clone()
    };
    let refused = server.jobs().submit_job(other).await.unwrap_err();
    assert_eq!((refused.code(), reason(&refused).as_str()), (Code::AlreadyExists, "REQUEST_ID_REUSED"));
    assert_eq!(server.wait(&id).await.state(), v1::JobState::Succeeded);
    let after = server.jobs().submit_job(request).await.unwrap().into_inner();
    assert_eq!(after.status.unwrap().state(), v1::JobState::Succeeded);
    server.stop().await;
}

#[tokio::test]
async fn many_submits_at_once_under_one_id_make_one_job() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let request = server.request("r-1", "EVENTS 10").await;
    let mut calls = tokio::task::JoinSet::new();
    for _ in 0..32 {
        let (mut jobs, request) = (server.jobs(), request.clone());
        calls.spawn(async move { jobs.submit_job(request).await.unwrap().into_inner() });
    }
    let answers = calls.join_all().await;
    assert_eq!(answers.iter().filter(|a| !a.duplicate).count(), 1);
    let ids: std::collections::BTreeSet<_> = answers.into_iter().map(|a| a.status.unwrap().job_id).collect();
    assert_eq!(ids.len(), 1);
    server.stop().await;
}

#[tokio::test]
async fn wrong_fields_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let good = server.request("r-1", "EVENTS 1").await;
    let file = |path: &str| v1::FileRef { path: path.into(), digest: good.files[0].digest.clone() };
    let mut cases = vec![
        (v1::SubmitJobRequest { request_id: String::new(), ..good.clone() }, "request_id"),
        (v1::SubmitJobRequest { programs: vec![], ..good.clone() }, "programs"),
        (
            v1::SubmitJobRequest {
                options: Some(v1::JobOptions { opskip: vec![10], ..Default::default() }),
                ..good.clone()
            },
            "options.opskip",
        ),
        (v1::SubmitJobRequest { files: vec![file("other.nc")], ..good.clone() }, "programs[0].path"),
        (v1::SubmitJobRequest { files: vec![file("main.nc"), file("main.nc")], ..good.clone() }, "files[1].path"),
    ];
    for path in ["../main.nc", "/etc/passwd", "a\\b", "a/./b", "C:/x"] {
        cases
            .push((v1::SubmitJobRequest { files: vec![file("main.nc"), file(path)], ..good.clone() }, "files[1].path"));
    }
    for (request, field) in cases {
        let refused = server.jobs().submit_job(request).await.unwrap_err();
        assert_eq!((refused.code(), reason(&refused).as_str()), (Code::InvalidArgument, "INVALID_REQUEST"));
        assert_eq!(refused.get_error_details().bad_request().unwrap().field_violations[0].field, field);
    }
    let unknown = v1::SubmitJobRequest { machine: "no-such".into(), ..good.clone() };
    assert_eq!(reason(&server.jobs().submit_job(unknown).await.unwrap_err()), "UNKNOWN_MACHINE");
    let absent = v1::FileRef { path: "x".into(), digest: digest(b"absent") };
    let missing = v1::SubmitJobRequest { files: vec![file("main.nc"), absent], ..good };
    assert_eq!(reason(&server.jobs().submit_job(missing).await.unwrap_err()), "MISSING_BLOBS");
    server.stop().await;
}

#[tokio::test]
async fn numbers_tokens_and_sizes_that_are_none_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let job_id = server.submit("r", "EVENTS 3").await;
    server.wait(&job_id).await;
    let field = |status: tonic::Status| {
        assert_eq!(reason(&status), "INVALID_REQUEST");
        status.get_error_details().bad_request().unwrap().field_violations[0].field.clone()
    };
    let watch = v1::WatchJobRequest { job_id: job_id.clone(), level: 99, ..Default::default() };
    assert_eq!(field(server.jobs().watch_job(watch).await.unwrap_err()), "level");
    let list = v1::ListJobsRequest { states: vec![1, 99], ..Default::default() };
    assert_eq!(field(server.jobs().list_jobs(list).await.unwrap_err()), "states[1]");
    let list = v1::ListJobsRequest { page_token: "zzz".into(), ..Default::default() };
    assert_eq!(field(server.jobs().list_jobs(list).await.unwrap_err()), "page_token");
    let timeline = v1::GetTimelineRequest { job_id: job_id.clone(), format: 99 };
    assert_eq!(field(server.results().get_timeline(timeline).await.unwrap_err()), "format");
    let toolpath = v1::GetToolpathRequest { job_id, format: 99 };
    assert_eq!(field(server.results().get_toolpath(toolpath).await.unwrap_err()), "format");
    let machine = v1::GetMachineRequest { name: "fanuc-mill".into(), section: 99, ..Default::default() };
    assert_eq!(field(server.machines().get_machine(machine).await.unwrap_err()), "section");
    for size in [0, 2, 4] {
        let chunk = v1::UploadRequest { digest: digest(b"abc"), size: Some(size), data: "abc".into() };
        let refused = server.blobs().upload(tokio_stream::iter([chunk])).await.unwrap_err();
        assert_eq!(field(refused), "size", "{size}");
    }
    let chunk = v1::UploadRequest { digest: digest(b"abc"), size: Some(3), data: "abc".into() };
    server.blobs().upload(tokio_stream::iter([chunk])).await.unwrap();
    server.stop().await;
}

#[tokio::test]
async fn a_full_queue_refuses_and_says_when_to_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let server =
        Server::start(counterpoint_server::options::ServerOptions { queue: 1, workers: 1, ..options(folder.path()) })
            .await;
    let running = server.submit("r-1", "HANG").await;
    server.until(&running, v1::JobState::Running).await;
    let queued = server.submit("r-2", "EVENTS 1").await;
    let third = server.request("r-3", "EVENTS 1").await;
    let refused = server.jobs().submit_job(third).await.unwrap_err();
    assert_eq!((refused.code(), reason(&refused).as_str()), (Code::ResourceExhausted, "QUEUE_FULL"));
    assert!(refused.get_error_details().retry_info().is_some());
    // A known job is answered even then.
    let again = server.request("r-2", "EVENTS 1").await;
    assert!(server.jobs().submit_job(again).await.unwrap().into_inner().duplicate);
    server.script.hang.store(false, std::sync::atomic::Ordering::SeqCst);
    assert_eq!(server.wait(&queued).await.state(), v1::JobState::Succeeded);
    server.stop().await;
}

#[tokio::test]
async fn blobs_come_back_whole_and_lies_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let content: Vec<u8> = (0..300_000u32).map(|i| (i % 251) as u8).collect();
    let (name, absent) = (digest(&content), digest(b"absent"));
    let ask = |digests: Vec<String>| v1::FindMissingRequest { digests };
    let asked = server.blobs().find_missing(ask(vec![name.clone(), absent.clone()])).await.unwrap().into_inner();
    assert_eq!(asked.digests, [name.clone(), absent.clone()]);
    server.upload(&content).await;
    server.upload(&content).await;
    let asked = server.blobs().find_missing(ask(vec![name.clone(), absent.clone()])).await.unwrap().into_inner();
    assert_eq!(asked.digests, std::slice::from_ref(&absent));
    let mut stream = server.blobs().download(v1::DownloadRequest { digest: name }).await.unwrap().into_inner();
    let mut back = Vec::new();
    while let Some(chunk) = stream.message().await.unwrap() {
        back.extend_from_slice(&chunk.data);
    }
    assert!(back == content);
    let lie = v1::UploadRequest { digest: absent.clone(), data: "something else".into(), size: None };
    let refused = server.blobs().upload(tokio_stream::iter([lie])).await.unwrap_err();
    assert_eq!(reason(&refused), "DIGEST_MISMATCH");
    let refused = server.blobs().download(v1::DownloadRequest { digest: absent }).await.unwrap_err();
    assert_eq!(reason(&refused), "UNKNOWN_BLOB");
    server.stop().await;
}

#[tokio::test]
async fn a_machine_can_be_put_listed_and_pinned() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let shipped =
        server.machines().list_machines(v1::ListMachinesRequest::default()).await.unwrap().into_inner().machines;
    let lathe = shipped.iter().find(|m| m.name == "fanuc-2path-lathe").unwrap();
    assert!(lathe.shipped && lathe.revision.is_empty() && lathe.channels == 2);
    let request = v1::CheckMachineRequest { name: "fanuc-2path-lathe".into(), files: vec![] };
    assert!(server.machines().check_machine(request).await.unwrap().into_inner().usable);
    let bad = server.upload(b"!nonsense").await;
    let file = v1::MachineFile { path: "mine/machine.toml".into(), digest: bad };
    let check = v1::CheckMachineRequest { name: "mine".into(), files: vec![file.clone()] };
    let found = server.machines().check_machine(check).await.unwrap().into_inner();
    assert!(!found.usable && found.findings[0].error && found.findings[0].file.ends_with("machine.toml"));
    let put = v1::PutMachineRequest { name: "mine".into(), files: vec![file] };
    assert_eq!(reason(&server.machines().put_machine(put).await.unwrap_err()), "MACHINE_INVALID");
    server.stop().await;
}

#[tokio::test]
async fn a_shipped_machine_cannot_be_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let extends = server.upload(b"extends = \"fanuc-mill\"\nname = \"poisoned\"\n").await;
    let put = |name: &str| v1::PutMachineRequest {
        name: name.into(),
        files: vec![v1::MachineFile { path: format!("{name}/machine.toml"), digest: extends.clone() }],
    };
    let refused = server.machines().put_machine(put("fanuc-2path-lathe")).await.unwrap_err();
    assert_eq!((refused.code(), reason(&refused).as_str()), (Code::AlreadyExists, "MACHINE_SHIPPED"));
    server.stop().await;
}

/// A job without a machine: the server guesses the machine by the signs of the shipped machines and of the tenant's
/// own, reports the choice and its reason, and refuses programs without signs of a machine.
#[tokio::test]
async fn a_job_without_a_machine_is_guessed() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let submit = async |id: &str, text: &str| {
        let request = v1::SubmitJobRequest { machine: String::new(), ..server.request(id, text).await };
        server.jobs().submit_job(request).await.map(|answer| answer.into_inner().status.unwrap())
    };
    let lathe = "O1\n(T1 M6)\nG50 S2500\nT0101\nG96 S200 M3\nG0 X52. Z2.\nM30\n";
    let status = submit("lathe", lathe).await.unwrap();
    assert_eq!(status.machine, "fanuc-lathe");
    assert!(status.machine_guess.starts_with("G50 S2500 (line 3), G96 S200 (line 5)"), "{}", status.machine_guess);
    assert_eq!(server.status(&status.job_id).await.machine_guess, status.machine_guess);
    let refused = submit("bare", "O1\nG0 X1.\nM30\n").await.unwrap_err();
    assert_eq!(refused.code(), Code::InvalidArgument);
    assert!(refused.message().contains("shows which machine it is for"), "{}", refused.message());
    // A machine of the tenant's own is a candidate if it has signs.
    let own = "extends = \"fanuc-lathe\"\n[ce]\nname = \"ours\"\n[signs.traits.ours]\n\"G510\" = 5\n";
    let digest = server.upload(own.as_bytes()).await;
    let file = v1::MachineFile { path: "ours/machine.toml".into(), digest };
    let put = v1::PutMachineRequest { name: "ours".into(), files: vec![file] };
    server.machines().put_machine(put).await.unwrap();
    assert_eq!(submit("own", &lathe.replace("T0101", "G510\nT0101")).await.unwrap().machine, "ours");
    assert_eq!(submit("still", lathe).await.unwrap().machine, "fanuc-lathe");
    server.stop().await;
}

#[tokio::test]
async fn a_content_in_one_message_is_stored_like_an_upload() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let content = vec![7; 1 << 20];
    for _ in 0..2 {
        let put = v1::PutBlobRequest { data: content.clone().into() };
        let stored = server.blobs().put_blob(put).await.unwrap().into_inner();
        assert_eq!((stored.digest, stored.size), (digest(&content), 1 << 20));
    }
    let empty = server.blobs().put_blob(v1::PutBlobRequest::default()).await.unwrap().into_inner();
    assert_eq!((empty.digest, empty.size), (digest(b""), 0));
    let find = v1::FindMissingRequest { digests: vec![digest(&content), digest(b""), digest(b"x")] };
    assert_eq!(server.blobs().find_missing(find).await.unwrap().into_inner().digests, [digest(b"x")]);
    let long = v1::PutBlobRequest { data: vec![7; (1 << 20) + 1].into() };
    assert_eq!(reason(&server.blobs().put_blob(long).await.unwrap_err()), "INVALID_REQUEST");
    server.stop().await;
}
