//! A job that equals an ended job gets a copy of its results instead of a run.

use std::path::Path;
use std::sync::atomic::Ordering;

use counterpoint_proto::v1;
use counterpoint_server::access::Role;
use counterpoint_server::doctor;
use counterpoint_server::options::{Maxima, Retention, ServerOptions, System};

use crate::faults::said;
use crate::guarded::*;
use crate::support::*;

/// Options of a server that reuses results for equal jobs.
pub fn caching(folder: &Path) -> ServerOptions {
    ServerOptions { retention: Retention { result_cache: true, ..Retention::default() }, ..options(folder) }
}

/// Submits a job and waits for its end.
async fn ended(server: &Server, request: v1::SubmitJobRequest) -> v1::JobStatus {
    let status = server.jobs().submit_job(request).await.unwrap().into_inner().status.unwrap();
    server.wait(&status.job_id).await
}

fn prepared(server: &Server) -> u64 {
    server.script.prepared.load(Ordering::SeqCst)
}

/// Listings and drawings of a job.
async fn results(server: &Server, job: &str) -> Vec<Vec<u8>> {
    let id = || job.to_owned();
    let mut client = server.results();
    let mut all = Vec::new();
    macro_rules! add {
        ($call:expr) => {
            let (mut stream, mut whole) = ($call.await.unwrap().into_inner(), Vec::new());
            while let Some(chunk) = stream.message().await.unwrap() {
                whole.extend_from_slice(&chunk.data);
            }
            all.push(whole);
        };
    }
    for channel in 0..=2 {
        add!(client.get_listing(v1::GetListingRequest { job_id: id(), channel, ..Default::default() }));
    }
    for format in [v1::DrawingFormat::Json, v1::DrawingFormat::Svg] {
        let format = i32::from(format);
        add!(client.get_timeline(v1::GetTimelineRequest { job_id: id(), format }));
        add!(client.get_toolpath(v1::GetToolpathRequest { job_id: id(), format }));
    }
    all
}

#[tokio::test(flavor = "multi_thread")]
async fn an_equal_job_has_the_results_of_the_first_and_does_not_run() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(caching(folder.path())).await;
    // A log in the ledger, one in a file, one that is compressed, one whose results are stored.
    let scripts = ["EVENTS 20", "EVENTS 20\nALARM", "EVENTS 1500", "EVENTS 2000\nWRITE a.txt\nWRITE b.txt"];
    for (number, script) in scripts.into_iter().chain(["EVENTS 60000", "WRITE c.txt"]).enumerate() {
        let before = prepared(&server);
        let first = ended(&server, server.request(&format!("first-{number}"), script).await).await;
        assert_eq!(first.reused_from, "");
        let second = v1::SubmitJobRequest {
            labels: [("part".to_owned(), "17".to_owned())].into(),
            priority: v1::JobPriority::High.into(),
            deadline_ms: i64::MAX,
            options: Some(v1::JobOptions { threads: 1, ..Default::default() }),
            ..server.request(&format!("second-{number}"), script).await
        };
        let second = ended(&server, second).await;
        assert_eq!(prepared(&server), before + 1, "{script}");
        assert_eq!((&second.reused_from, second.reused_ended_ms), (&first.job_id, first.ended_ms), "{script}");
        assert!(second.job_id > first.job_id && second.attempt == 1 && second.ended_ms >= second.started_ms);
        let facts = |status: &v1::JobStatus| {
            let v1::JobStatus { state, cause, events, makespan_ns, highest_severity, .. } = *status;
            (state, cause, events, makespan_ns, highest_severity, status.log_digest.clone(), status.verdict.clone())
        };
        assert_eq!(facts(&second), facts(&first), "{script}");
        let (one, other) = (said(&server, &first.job_id).await, said(&server, &second.job_id).await);
        assert!(one == other, "{script}");
        assert_eq!(results(&server, &first.job_id).await, results(&server, &second.job_id).await, "{script}");
        // The first job is deleted: the copy remains, and a third equal job names the job that ran.
        server.jobs().delete_job(v1::DeleteJobRequest { job_id: first.job_id.clone() }).await.unwrap();
        let before = prepared(&server);
        let third = ended(&server, server.request(&format!("third-{number}"), script).await).await;
        assert_eq!((third.reused_from, prepared(&server)), (first.job_id, before), "{script}");
        assert_eq!(third.reused_ended_ms, first.ended_ms, "{script}");
        assert!(said(&server, &third.job_id).await == one, "{script}");
    }
    server.stop().await;
    assert_eq!(doctor::examine(folder.path(), false), Ok(Vec::new()));

    // The next server also reuses them.
    let server = Server::start(caching(folder.path())).await;
    let again = ended(&server, server.request("again", "EVENTS 60000").await).await;
    assert!(!again.reused_from.is_empty() && prepared(&server) == 0);
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_that_differs_or_asks_for_a_run_runs() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(caching(folder.path())).await;
    let request = server.request("first", "EVENTS 5").await;
    let other = server.upload(b"EVENTS 6").await;
    let first = ended(&server, request.clone()).await;
    let with = |options: v1::JobOptions| v1::SubmitJobRequest { options: Some(options), ..request.clone() };
    let limited = |limits: v1::JobLimits| with(v1::JobOptions { limits: Some(limits), ..Default::default() });
    let answer = v1::DialogAnswer { dialog: "Clamp".into(), ..Default::default() };
    let file = |path: &str| v1::FileRef { path: path.into(), digest: other.clone() };
    let program = |n| vec![v1::Program { path: "main.nc".into(), number: Some(n), ..Default::default() }];
    let different = [
        v1::SubmitJobRequest { machine: "fanuc-mill".into(), ..request.clone() },
        v1::SubmitJobRequest { files: vec![file("main.nc")], ..request.clone() },
        v1::SubmitJobRequest { files: vec![request.files[0].clone(), file("sub.nc")], ..request.clone() },
        v1::SubmitJobRequest { programs: program(7), ..request.clone() },
        with(v1::JobOptions { opskip: vec![1], ..Default::default() }),
        with(v1::JobOptions { opstop: true, ..Default::default() }),
        with(v1::JobOptions { ignore_waits: vec![2], ..Default::default() }),
        with(v1::JobOptions { trace: "W".into(), ..Default::default() }),
        with(v1::JobOptions { parameters: "-A".into(), ..Default::default() }),
        with(v1::JobOptions { answers: vec![answer], ..Default::default() }),
        with(v1::JobOptions { lint: true, ..Default::default() }),
        with(v1::JobOptions { races: v1::RaceCheck::Warn.into(), ..Default::default() }),
        with(v1::JobOptions { time: v1::TimeModel::Simple.into(), ..Default::default() }),
        with(v1::JobOptions { warnings_off: vec![2_900_680], ..Default::default() }),
        with(v1::JobOptions { warnings_on: vec![2_900_680], ..Default::default() }),
        with(v1::JobOptions { attended: true, ..Default::default() }),
        with(v1::JobOptions { stepped: true, ..Default::default() }),
        with(v1::JobOptions { no_cache: true, ..Default::default() }),
        limited(v1::JobLimits { blocks: 9, ..Default::default() }),
        limited(v1::JobLimits { wall_ms: 90_000, ..Default::default() }),
        limited(v1::JobLimits { max_job_bytes: 1 << 20, ..Default::default() }),
    ];
    for (number, request) in different.into_iter().enumerate() {
        let request = v1::SubmitJobRequest { request_id: format!("{number}"), ..request };
        let (options, before) = (request.options.clone(), prepared(&server));
        let status = ended(&server, request).await;
        assert_eq!((status.reused_from.as_str(), prepared(&server)), ("", before + 1), "{number} {options:?}");
    }
    let before = prepared(&server);
    let rerun = v1::RerunJobRequest { job_id: first.job_id, request_id: "rerun".into(), ..Default::default() };
    let rerun = server.jobs().rerun_job(rerun).await.unwrap().into_inner().status.unwrap();
    assert_eq!((server.wait(&rerun.job_id).await.reused_from.as_str(), prepared(&server)), ("", before + 1));
    // The most recently ended equal job counts.
    let last = ended(&server, v1::SubmitJobRequest { request_id: "last".into(), ..request.clone() }).await;
    assert_eq!(last.reused_from, rerun.job_id);
    server.stop().await;

    // Jobs with other maxima or other rights are not equal; a server can switch the cache off.
    let maxima = Maxima { max_blocks: 8, ..Maxima::default() };
    let system = System { allow_system: true, ..System::default() };
    for (number, options) in [
        ServerOptions { maxima, ..caching(folder.path()) },
        ServerOptions { system, ..caching(folder.path()) },
        options(folder.path()),
    ]
    .into_iter()
    .enumerate()
    {
        let server = Server::start(options).await;
        let request = v1::SubmitJobRequest { request_id: format!("other-{number}"), ..request.clone() };
        assert_eq!((ended(&server, request).await.reused_from.as_str(), prepared(&server)), ("", 1), "{number}");
        server.stop().await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn results_that_another_run_might_not_have_are_not_given_to_others() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(caching(folder.path())).await;
    server.script.hang.store(false, Ordering::SeqCst);
    let small = v1::JobLimits { max_job_bytes: 2000, ..Default::default() };
    let limited = v1::JobOptions { limits: Some(small), ..Default::default() };
    let attended = v1::JobOptions { attended: true, ..Default::default() };
    let cases = [
        ("ASK Clamp", None),
        ("EVENTS 3\nSYSTEM", None),
        ("PANIC", None),
        ("REFUSE", None),
        ("EVENTS 700", Some(limited)),
        ("EVENTS 7", Some(attended)),
    ];
    for (case, (script, options)) in cases.into_iter().enumerate() {
        for number in 0..3 {
            let before = prepared(&server);
            let request = server.request(&format!("{case}-{number}"), script).await;
            let status = ended(&server, v1::SubmitJobRequest { options: options.clone(), ..request }).await;
            assert_eq!((status.reused_from.as_str(), prepared(&server)), ("", before + 1), "{script}");
        }
    }
    server.script.hang.store(true, Ordering::SeqCst);
    for number in 0..2 {
        let job = server.submit(&format!("hang-{number}"), "EVENTS 9\nHANG").await;
        server.until_events(&job, 9).await;
        server.jobs().cancel_job(v1::CancelJobRequest { job_id: job.clone() }).await.unwrap();
        let status = server.wait(&job).await;
        assert_eq!((status.state(), status.reused_from.as_str()), (v1::JobState::Cancelled, ""));
    }
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_damaged_log_is_given_to_no_equal_job() {
    let folder = tempfile::tempdir().unwrap();
    for (number, script) in ["EVENTS 1500", "EVENTS 60000", "EVENTS 20\nWRITE a.txt"].into_iter().enumerate() {
        let data = folder.path().join(number.to_string());
        let server = Server::start(caching(&data)).await;
        let first = ended(&server, server.request("first", script).await).await;
        let expected = said(&server, &first.job_id).await;
        server.stop().await;
        let files = data.join("jobs").join(&first.job_id).join("files.json");
        let damaged = if files.is_file() { files } else { log_file(&data, &first.job_id) };
        let mut content = std::fs::read(&damaged).unwrap();
        let middle = content.len() / 2;
        content[middle] ^= 1;
        std::fs::write(&damaged, content).unwrap();
        let server = Server::start(caching(&data)).await;
        let second = ended(&server, server.request("second", script).await).await;
        assert_eq!((second.reused_from.as_str(), prepared(&server)), ("", 1), "{script}");
        assert!(said(&server, &second.job_id).await == expected, "{script}");
        let third = ended(&server, server.request("third", script).await).await;
        assert_eq!(third.reused_from, second.job_id, "{script}");
        assert!(said(&server, &third.job_id).await == expected, "{script}");
        server.stop().await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn results_of_a_tenant_are_not_given_to_another() {
    let folder = tempfile::tempdir().unwrap();
    let options = ServerOptions { retention: Retention::default(), ..guarded(folder.path()) };
    let tokens = ["one", "other"].map(|tenant| grant(&options, "someone", tenant, Role::Submit));
    let server = Server::start(options).await;
    let [one, other] = tokens.map(|token| As::new(&server, &token));
    for (tenant, of) in [("one", &one), ("other", &other)] {
        let before = prepared(&server);
        let first = of.submit("first", "fanuc-2path-lathe", "EVENTS 5").await.unwrap().job_id;
        assert_eq!(of.wait(&first).await.reused_from, "", "{tenant}");
        let second = of.submit("second", "fanuc-2path-lathe", "EVENTS 5").await.unwrap().job_id;
        assert_eq!((of.wait(&second).await.reused_from, prepared(&server)), (first, before + 1), "{tenant}");
    }
    server.stop().await;
}
