//! Finding jobs: by state, machine, label and time, oldest or newest first; machines and files page by page.

use std::sync::atomic::Ordering;

use counterpoint_proto::v1;
use counterpoint_server::access::Role;
use tonic::Code;
use tonic_types::StatusExt;

use crate::guarded::*;
use crate::support::*;

fn labels(all: &[(&str, &str)]) -> std::collections::BTreeMap<String, String> {
    all.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect()
}

async fn submit(server: &Server, name: &str, machine: &str, own: &[(&str, &str)], script: &str) -> v1::JobStatus {
    let request = server.request(name, script).await;
    let request = v1::SubmitJobRequest { machine: machine.into(), labels: labels(own), ..request };
    server.jobs().submit_job(request).await.unwrap().into_inner().status.unwrap()
}

/// Request ids of the jobs of all pages.
async fn names(server: &Server, mut request: v1::ListJobsRequest) -> String {
    let mut names = Vec::new();
    loop {
        let page = server.jobs().list_jobs(request.clone()).await.unwrap().into_inner();
        names.extend(page.jobs.into_iter().map(|job| job.request_id));
        if page.next_page_token.is_empty() {
            return names.join(" ");
        }
        request.page_token = page.next_page_token;
    }
}

fn by(filter: v1::JobFilter) -> v1::ListJobsRequest {
    v1::ListJobsRequest { filter: Some(filter), page_size: 1, ..Default::default() }
}

#[tokio::test]
async fn jobs_are_found_by_what_they_are_also_after_a_restart() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let lathe = "fanuc-2path-lathe";
    let first = submit(&server, "a", lathe, &[("part", "17"), ("shift", "early")], "EVENTS 3").await;
    assert_eq!((first.tenant.as_str(), first.priority()), ("default", v1::JobPriority::Normal));
    assert_eq!(first.labels, labels(&[("part", "17"), ("shift", "early")]));
    server.wait(&first.job_id).await;
    let second = submit(&server, "b", "fanuc-mill", &[("part", "17")], "ALARM").await;
    server.wait(&second.job_id).await;
    let running = submit(&server, "c", lathe, &[("part", "18")], "HANG").await;
    server.until(&running.job_id, v1::JobState::Running).await;
    let filter = |states: &[v1::JobState], machine: &str, own: &[(&str, &str)]| v1::JobFilter {
        states: states.iter().map(|state| (*state).into()).collect(),
        machine: machine.into(),
        labels: labels(own),
        ..Default::default()
    };
    use v1::JobState::{Failed, Queued, Running, Succeeded};
    let cases = [
        (filter(&[], "", &[]), "a b c"),
        (filter(&[Succeeded, Running], "", &[]), "a c"),
        (filter(&[Queued], "", &[]), ""),
        (filter(&[Failed], "", &[("part", "17")]), "b"),
        (filter(&[], lathe, &[]), "a c"),
        (filter(&[], lathe, &[("part", "17")]), "a"),
        (filter(&[], "", &[("part", "17"), ("shift", "early")]), "a"),
        (filter(&[], "", &[("part", "1")]), ""),
        (v1::JobFilter { from_ms: running.submitted_ms, ..Default::default() }, "c"),
        (v1::JobFilter { until_ms: running.submitted_ms, ..filter(&[], lathe, &[]) }, "a"),
        (v1::JobFilter { id_prefix: second.job_id.clone(), ..Default::default() }, "b"),
        (v1::JobFilter { id_prefix: second.job_id.to_uppercase().replace('-', ""), ..filter(&[], lathe, &[]) }, ""),
        (v1::JobFilter { id_prefix: first.job_id[..3].to_owned(), ..filter(&[], lathe, &[]) }, "a c"),
        (v1::JobFilter { id_prefix: "ffff".into(), ..Default::default() }, ""),
    ];
    for (filter, expected) in &cases {
        assert_eq!(names(&server, by(filter.clone())).await, *expected, "{filter:?}");
    }
    let short = v1::ListJobsRequest { short_ids: true, ..Default::default() };
    for job in server.jobs().list_jobs(short).await.unwrap().into_inner().jobs {
        assert!(job.short_id.len() >= 8 && job.job_id.starts_with(&job.short_id), "{job:?}");
        let found = by(v1::JobFilter { id_prefix: job.short_id, ..Default::default() });
        assert_eq!(names(&server, found).await, job.request_id);
    }
    let newest = v1::ListJobsRequest { newest_first: true, page_size: 2, ..Default::default() };
    assert_eq!(names(&server, newest.clone()).await, "c b a");
    let both = v1::ListJobsRequest { states: vec![Succeeded.into(), Failed.into()], ..by(filter(&[Failed], "", &[])) };
    assert_eq!(names(&server, both).await, "b", "both lists of states count");
    server.jobs().delete_job(v1::DeleteJobRequest { job_id: first.job_id }).await.unwrap();
    server.script.hang.store(false, Ordering::SeqCst);
    server.wait(&running.job_id).await;
    server.stop().await;
    let server = Server::start(options(folder.path())).await;
    assert_eq!(names(&server, newest).await, "c b");
    assert_eq!(names(&server, by(filter(&[Succeeded], lathe, &[]))).await, "c");
    assert_eq!(names(&server, by(filter(&[], "", &[("part", "17")]))).await, "b");
    server.stop().await;
}

#[tokio::test]
async fn labels_priorities_deadlines_and_times_that_are_none_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let good = server.request("r", "EVENTS 1").await;
    let with = |own: &[(&str, &str)]| v1::SubmitJobRequest { labels: labels(own), ..good.clone() };
    let many: Vec<String> = (0..33).map(|n| n.to_string()).collect();
    let many: Vec<(&str, &str)> = many.iter().map(|key| (key.as_str(), "")).collect();
    let long = "x".repeat(256);
    let cases = [
        (with(&[("", "v")]), "labels[\"\"]"),
        (with(&[("Part", "v")]), "labels[\"Part\"]"),
        (with(&[("-a", "v")]), "labels[\"-a\"]"),
        (with(&[("a", "two\nlines")]), "labels[\"a\"]"),
        (with(&[("a", &long)]), "labels[\"a\"]"),
        (with(&many), "labels"),
        (v1::SubmitJobRequest { priority: 9, ..good.clone() }, "priority"),
        (v1::SubmitJobRequest { deadline_ms: -1, ..good.clone() }, "deadline_ms"),
    ];
    let field = |status: tonic::Status| {
        assert_eq!((status.code(), reason(&status).as_str()), (Code::InvalidArgument, "INVALID_REQUEST"));
        status.get_error_details().bad_request().unwrap().field_violations[0].field.clone()
    };
    for (request, expected) in cases {
        assert_eq!(field(server.jobs().submit_job(request).await.unwrap_err()), expected);
    }
    let list = by(v1::JobFilter { from_ms: -1, ..Default::default() });
    assert_eq!(field(server.jobs().list_jobs(list).await.unwrap_err()), "filter.from_ms");
    let list = by(v1::JobFilter { id_prefix: "part".into(), ..Default::default() });
    assert_eq!(field(server.jobs().list_jobs(list).await.unwrap_err()), "filter.id_prefix");
    let list = by(v1::JobFilter { states: vec![1, 77], ..Default::default() });
    assert_eq!(field(server.jobs().list_jobs(list).await.unwrap_err()), "filter.states[1]");
    server.stop().await;
}

#[tokio::test]
async fn a_failed_job_says_whether_program_machine_limit_or_host_made_it_fail() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let cause = async |script: &str, limits: v1::JobLimits| {
        let request = server.request(script, script).await;
        let options = v1::JobOptions { limits: Some(limits), ..Default::default() };
        let request = v1::SubmitJobRequest { request_id: digest(script.as_bytes()), options: Some(options), ..request };
        let job = server.jobs().submit_job(request).await.unwrap().into_inner().status.unwrap().job_id;
        server.wait(&job).await.cause()
    };
    let none = v1::JobLimits::default();
    assert_eq!(cause("EVENTS 3", none).await, v1::JobCause::Unspecified);
    assert_eq!(cause("ALARM", none).await, v1::JobCause::Program);
    assert_eq!(cause("REFUSE", none).await, v1::JobCause::Program);
    assert_eq!(cause("HANG", v1::JobLimits { wall_ms: 50, ..none }).await, v1::JobCause::Limit);
    assert_eq!(cause("SLOW", v1::JobLimits { wall_ms: 50, ..none }).await, v1::JobCause::Limit);
    assert_eq!(cause("PANIC", none).await, v1::JobCause::Host);
    server.stop().await;
}

/// Lists larger than the largest message are returned in pages, even if the client asks for all items.
#[tokio::test]
async fn lists_of_files_and_machines_fit_into_messages() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let paths: Vec<String> = (1000..6000).map(|number| format!("{number}{}", "x".repeat(1000))).collect();
    let job = server.submit("files", &paths.iter().map(|path| format!("WRITE {path}\n")).collect::<String>()).await;
    assert_eq!(server.wait(&job).await.state(), v1::JobState::Succeeded);
    let (mut listed, mut pages) = (Vec::new(), 0);
    let mut request = v1::ListFilesRequest { job_id: job, ..Default::default() };
    loop {
        let page = server.results().list_files(request.clone()).await.unwrap().into_inner();
        listed.extend(page.files.into_iter().map(|file| file.path));
        pages += 1;
        if page.next_page_token.is_empty() {
            break;
        }
        request.page_token = page.next_page_token;
    }
    assert!(listed == paths && pages == 2, "{} files on {pages} pages", listed.len());

    let anybody = As::nobody(&server);
    let names: Vec<String> = (1..6).map(|number| format!("own-{number}")).collect();
    for name in &names {
        anybody.put_machine(name, &"long ".repeat(180_000)).await.unwrap();
    }
    let (mut listed, mut pages) = (Vec::new(), 0);
    let mut request = v1::ListMachinesRequest::default();
    loop {
        let page = server.machines().list_machines(request.clone()).await.unwrap().into_inner();
        listed.extend(page.machines.into_iter().filter(|machine| !machine.shipped).map(|machine| machine.name));
        pages += 1;
        if page.next_page_token.is_empty() {
            break;
        }
        request.page_token = page.next_page_token;
    }
    assert!(listed == names && pages == 2, "{listed:?} on {pages} pages");
    server.stop().await;
}

#[tokio::test]
async fn machines_and_files_come_page_by_page_and_a_machine_can_be_deleted() {
    let folder = tempfile::tempdir().unwrap();
    let options = guarded(folder.path());
    let (submit, admin) = (grant(&options, "s", "t", Role::Submit), grant(&options, "a", "t", Role::Admin));
    let server = Server::start(options).await;
    let (submit, admin) = (As::new(&server, &submit), As::new(&server, &admin));
    submit.put_machine("mine", "first").await.unwrap();
    let newest = submit.put_machine("mine", "second").await.unwrap();
    admin.put_machine("theirs", "of an administrator").await.unwrap();

    let all = submit.machines().list_machines(v1::ListMachinesRequest::default()).await.unwrap().into_inner();
    let all: Vec<_> = all.machines.into_iter().map(|machine| machine.name).collect();
    let (mut request, mut paged) = (v1::ListMachinesRequest { page_size: 2, ..Default::default() }, Vec::new());
    loop {
        let page = submit.machines().list_machines(request.clone()).await.unwrap().into_inner();
        assert!(page.machines.len() <= 2);
        paged.extend(page.machines.into_iter().map(|machine| machine.name));
        if page.next_page_token.is_empty() {
            break;
        }
        request.page_token = page.next_page_token;
    }
    assert!(paged == all && all.len() > 4, "{paged:?}");

    let job = submit.submit("files", "mine", "WRITE c\nWRITE a\nWRITE b\nHANG").await.unwrap().job_id;
    let delete = |name: &str| v1::DeleteMachineRequest { name: name.into() };
    let refused = submit.machines().delete_machine(delete("theirs")).await.unwrap_err();
    assert_eq!(reason(&refused), "PERMISSION_DENIED");
    let refused = submit.machines().delete_machine(delete("fanuc-mill")).await.unwrap_err();
    assert_eq!(reason(&refused), "MACHINE_SHIPPED");
    let refused = submit.machines().delete_machine(delete(&format!("mine@{}", newest.revision))).await.unwrap_err();
    assert_eq!(reason(&refused), "INVALID_REQUEST");
    submit.machines().delete_machine(delete("mine")).await.unwrap();
    admin.machines().delete_machine(delete("theirs")).await.unwrap();
    for name in ["mine".to_owned(), format!("mine@{}", newest.revision)] {
        let get = v1::GetMachineRequest { name, ..Default::default() };
        assert_eq!(reason(&submit.machines().get_machine(get).await.unwrap_err()), "UNKNOWN_MACHINE");
    }
    assert_eq!(reason(&submit.machines().delete_machine(delete("mine")).await.unwrap_err()), "UNKNOWN_MACHINE");
    server.script.hang.store(false, Ordering::SeqCst);
    assert_eq!(submit.wait(&job).await.state(), v1::JobState::Succeeded, "a job keeps its revision");
    let again = v1::RerunJobRequest { job_id: job.clone(), request_id: "again".into(), ..Default::default() };
    let again = submit.jobs().rerun_job(again).await.unwrap().into_inner().status.unwrap().job_id;
    assert_eq!(submit.wait(&again).await.state(), v1::JobState::Succeeded, "also when it is run again");

    let mut request = v1::ListFilesRequest { job_id: job, page_size: 2, ..Default::default() };
    let mut paths = Vec::new();
    for size in [2, 1] {
        let page = submit.results().list_files(request.clone()).await.unwrap().into_inner();
        assert_eq!(page.files.len(), size);
        paths.extend(page.files.into_iter().map(|file| file.path));
        request.page_token = page.next_page_token;
    }
    assert_eq!((paths.join(" ").as_str(), request.page_token.as_str()), ("a b c", ""));
    server.stop().await;
}
