//! The bounds of ids, names, labels, paths and tokens: every text of every request of the contract has one.

use std::collections::BTreeSet;

use counterpoint_proto::{DESCRIPTORS, v1};
use prost::Message;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FileDescriptorSet};
use tonic::codegen::http::uri::PathAndQuery;
use tonic::{Code, Request};
use tonic_types::StatusExt;

use crate::support::*;

/// Messages in the requests of the contract.
fn messages() -> Vec<DescriptorProto> {
    let set = FileDescriptorSet::decode(DESCRIPTORS).unwrap();
    let messages: Vec<&DescriptorProto> = set.file.iter().flat_map(|file| &file.message_type).collect();
    let services = set.file.iter().flat_map(|file| &file.service).flat_map(|service| &service.method);
    let short = |name: &str| name.rsplit('.').next().unwrap().to_owned();
    let mut open: Vec<String> = services.map(|method| short(method.input_type())).collect();
    let mut seen: Vec<DescriptorProto> = Vec::new();
    while let Some(name) = open.pop() {
        let Some(message) = messages.iter().find(|message| message.name() == name) else { continue };
        if seen.iter().any(|known| known.name() == name) {
            continue;
        }
        let fields = message.field.iter().chain(message.nested_type.iter().flat_map(|entry| &entry.field));
        open.extend(fields.filter(|field| field.r#type() == Type::Message).map(|field| short(field.type_name())));
        seen.push((*message).clone());
    }
    seen
}

/// Texts in the requests of the contract: `Message.field`, of a map `Message.field.key` and `Message.field.value`.
fn texts() -> BTreeSet<String> {
    let mut texts = BTreeSet::new();
    for message in messages() {
        for field in &message.field {
            let place = format!("{}.{}", message.name(), field.name());
            let of_map = message.nested_type.iter().find(|entry| field.type_name().ends_with(entry.name()));
            match (field.r#type(), of_map.filter(|_| field.r#type() == Type::Message)) {
                (Type::String, _) => drop(texts.insert(place)),
                (_, Some(entry)) => {
                    let parts = entry.field.iter().filter(|part| part.r#type() == Type::String);
                    texts.extend(parts.map(|part| format!("{place}.{}", part.name())));
                }
                _ => {}
            }
        }
    }
    texts
}

/// Lists and maps in the requests of the contract: `Message.field`.
fn lists() -> BTreeSet<String> {
    let mut lists = BTreeSet::new();
    for message in messages() {
        let repeated = message.field.iter().filter(|field| field.label() == Label::Repeated);
        lists.extend(repeated.map(|field| format!("{}.{}", message.name(), field.name())));
    }
    lists
}

/// Calls that have been refused, with the texts that were refused.
struct Door<'a> {
    server: &'a Server,
    seen: BTreeSet<String>,
}

impl Door<'_> {
    /// Makes a call that must be refused because of a field.
    async fn refuses<T: Message + 'static>(&mut self, call: &str, request: T, text: &str, field: &str) {
        let mut raw = tonic::client::Grpc::new(self.server.connection.clone());
        raw.ready().await.unwrap();
        let codec = tonic_prost::ProstCodec::<T, ()>::default();
        let path = PathAndQuery::try_from(format!("/counterpoint.v1.{call}")).unwrap();
        let refused = raw.unary(Request::new(request), path, codec).await.expect_err(text);
        assert_eq!((refused.code(), reason(&refused).as_str()), (Code::InvalidArgument, "INVALID_REQUEST"), "{text}");
        let details = refused.get_error_details();
        let violation = &details.bad_request().unwrap().field_violations[0];
        assert!(violation.field.starts_with(field), "{text}: {}", violation.field);
        assert!(violation.description.starts_with("must ") || violation.description.contains("must "), "{violation:?}");
        self.seen.insert(text.to_owned());
    }
}

macro_rules! single {
    ($door:ident, $bad:ident: $($call:literal $request:ident.$field:ident),*) => { $(
        let mut request = v1::$request::default();
        request.$field = $bad.clone();
        let text = concat!(stringify!($request), ".", stringify!($field));
        $door.refuses($call, request, text, stringify!($field)).await;
    )* };
}

#[tokio::test]
async fn every_text_of_every_request_has_a_limit_that_its_refusal_names() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let digest = digest(b"x");
    let mut door = Door { server: &server, seen: BTreeSet::new() };
    for bad in ["x".repeat(5000), "a\nb".to_owned()] {
        single!(door, bad:
            "Blobs/Upload" UploadRequest.digest, "Blobs/Download" DownloadRequest.digest,
            "Jobs/GetJob" GetJobRequest.job_id, "Jobs/WatchJob" WatchJobRequest.job_id,
            "Jobs/WaitJob" WaitJobRequest.job_id, "Jobs/CancelJob" CancelJobRequest.job_id,
            "Jobs/PauseJob" PauseJobRequest.job_id, "Jobs/ResumeJob" ResumeJobRequest.job_id,
            "Jobs/DeleteJob" DeleteJobRequest.job_id, "Jobs/ListJobs" ListJobsRequest.page_token,
            "Jobs/CancelJobs" CancelJobsRequest.page_token, "Jobs/DeleteJobs" DeleteJobsRequest.page_token,
            "Jobs/SubmitJob" SubmitJobRequest.request_id, "Jobs/RerunJob" RerunJobRequest.request_id,
            "Operator/WatchQuestions" WatchQuestionsRequest.job_id,
            "Operator/AnswerQuestion" AnswerQuestionRequest.job_id,
            "Machines/GetMachine" GetMachineRequest.name, "Machines/PutMachine" PutMachineRequest.name,
            "Machines/CheckMachine" CheckMachineRequest.name, "Machines/DeleteMachine" DeleteMachineRequest.name,
            "Machines/ListMachines" ListMachinesRequest.page_token,
            "Admin/ListConnections" ListConnectionsRequest.page_token,
            "Results/GetListing" GetListingRequest.job_id, "Results/GetTrace" GetTraceRequest.job_id,
            "Results/GetTimeline" GetTimelineRequest.job_id, "Results/GetToolpath" GetToolpathRequest.job_id,
            "Results/GetSummary" GetSummaryRequest.job_id, "Results/GetEvents" GetEventsRequest.job_id,
            "Results/ListFiles" ListFilesRequest.job_id, "Results/GetFile" GetFileRequest.job_id);
        let rerun = v1::RerunJobRequest { request_id: "r".into(), job_id: bad.clone(), ..Default::default() };
        door.refuses("Jobs/RerunJob", rerun, "RerunJobRequest.job_id", "job_id").await;
        let one = v1::ListFilesRequest { job_id: "j".into(), page_token: bad.clone(), ..Default::default() };
        door.refuses("Results/ListFiles", one, "ListFilesRequest.page_token", "page_token").await;
        let one = v1::GetFileRequest { job_id: "j".into(), path: bad.clone() };
        door.refuses("Results/GetFile", one, "GetFileRequest.path", "path").await;
        let find = v1::FindMissingRequest { digests: vec![digest.clone(), bad.clone()] };
        door.refuses("Blobs/FindMissing", find, "FindMissingRequest.digests", "digests[1]").await;
        let content = Some(v1::attend_request::Content::JobId(bad.clone()));
        door.refuses("Operator/Attend", v1::AttendRequest { content }, "AttendRequest.job_id", "job_id").await;
        let content = Some(v1::debug_request::Content::JobId(bad.clone()));
        door.refuses("Operator/Debug", v1::DebugRequest { content }, "DebugRequest.job_id", "job_id").await;
        for (path, digest, field) in [(&bad, &digest, "path"), (&"m".to_owned(), &bad, "digest")] {
            let files = vec![v1::MachineFile { path: path.clone(), digest: digest.clone() }];
            let (text, field) = (format!("MachineFile.{field}"), format!("files[0].{field}"));
            let put = v1::PutMachineRequest { name: "m".into(), files: files.clone() };
            door.refuses("Machines/PutMachine", put, &text, &field).await;
            let check = v1::CheckMachineRequest { name: "m".into(), files };
            door.refuses("Machines/CheckMachine", check, &text, &field).await;
        }
        filters(&mut door, &bad).await;
        submits(&mut door, &bad).await;
    }
    breakpoints(&mut door).await;
    values(&mut door).await;
    assert_eq!(door.seen, texts());
    server.stop().await;
}

async fn filters(door: &mut Door<'_>, bad: &str) {
    let labels = |key: &str, value: &str| [(key.to_owned(), value.to_owned())].into();
    let filters = [
        ("machine", v1::JobFilter { machine: bad.into(), ..Default::default() }),
        ("id_prefix", v1::JobFilter { id_prefix: bad.into(), ..Default::default() }),
        ("labels.key", v1::JobFilter { labels: labels(bad, "v"), ..Default::default() }),
        ("labels.value", v1::JobFilter { labels: labels("k", bad), ..Default::default() }),
    ];
    for (text, filter) in filters {
        let field = format!("filter.{}", text.split('.').next().unwrap());
        let text = format!("JobFilter.{text}");
        let filter = Some(filter);
        let list = v1::ListJobsRequest { filter: filter.clone(), ..Default::default() };
        door.refuses("Jobs/ListJobs", list, &text, &field).await;
        let watch = v1::WatchJobsRequest { filter: filter.clone(), ..Default::default() };
        door.refuses("Jobs/WatchJobs", watch, &text, &field).await;
        let cancel = v1::CancelJobsRequest { filter: filter.clone(), ..Default::default() };
        door.refuses("Jobs/CancelJobs", cancel, &text, &field).await;
        let delete = v1::DeleteJobsRequest { filter, ..Default::default() };
        door.refuses("Jobs/DeleteJobs", delete, &text, &field).await;
    }
}

/// Changes a request.
type Change<'a> = Box<dyn Fn(&mut v1::SubmitJobRequest) + 'a>;

async fn submits(door: &mut Door<'_>, bad: &str) {
    let whole = door.server.request("r", "EVENTS 1").await;
    let answer = |change: &dyn Fn(&mut v1::DialogAnswer)| {
        let mut answer = v1::DialogAnswer { dialog: "D".into(), ..Default::default() };
        change(&mut answer);
        Some(v1::JobOptions { answers: vec![answer], ..Default::default() })
    };
    let label = |key: &str, value: &str| (key.to_owned(), value.to_owned());
    let changes: Vec<(&str, &str, Change<'_>)> = vec![
        ("SubmitJobRequest.machine", "machine", Box::new(|r| r.machine = bad.into())),
        ("SubmitJobRequest.labels.key", "labels", Box::new(|r| r.labels.extend([label(bad, "")]))),
        ("SubmitJobRequest.labels.value", "labels", Box::new(|r| r.labels.extend([label("k", bad)]))),
        ("FileRef.path", "files[0].path", Box::new(|r| r.files[0].path = bad.into())),
        ("FileRef.digest", "files[0].digest", Box::new(|r| r.files[0].digest = bad.into())),
        ("Program.path", "programs[0].path", Box::new(|r| r.programs[0].path = bad.into())),
        ("Program.section", "programs[0].section", Box::new(|r| r.programs[0].section = Some(bad.into()))),
        (
            "JobOptions.trace",
            "options.trace",
            Box::new(|r| r.options = Some(v1::JobOptions { trace: bad.into(), ..Default::default() })),
        ),
        (
            "JobOptions.parameters",
            "options.parameters",
            Box::new(|r| r.options = Some(v1::JobOptions { parameters: bad.into(), ..Default::default() })),
        ),
        (
            "DialogAnswer.dialog",
            "options.answers[0].dialog",
            Box::new(|r| r.options = answer(&|answer| answer.dialog = bad.into())),
        ),
        (
            "DialogAnswer.button",
            "options.answers[0].button",
            Box::new(|r| r.options = answer(&|answer| answer.button = bad.into())),
        ),
        (
            "DialogAnswer.values.key",
            "options.answers[0].values",
            Box::new(|r| r.options = answer(&|answer| drop(answer.values.insert(bad.into(), Default::default())))),
        ),
    ];
    for (text, field, change) in changes {
        let mut request = whole.clone();
        change(&mut request);
        door.refuses("Jobs/SubmitJob", request, text, field).await;
    }
    let labels = [label("", "v")].into();
    let rerun = v1::RerunJobRequest { request_id: "r".into(), job_id: "j".into(), labels, ..Default::default() };
    door.refuses("Jobs/RerunJob", rerun, "RerunJobRequest.labels.key", "labels").await;
    let labels = [label("k", bad)].into();
    let rerun = v1::RerunJobRequest { request_id: "r".into(), job_id: "j".into(), labels, ..Default::default() };
    door.refuses("Jobs/RerunJob", rerun, "RerunJobRequest.labels.value", "labels").await;
}

#[tokio::test]
async fn page_tokens_have_the_limits_of_the_documentation() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let documentation = include_str!("../../../docs/api.md");
    let row = "| `page_token` of `ListJobs`, `CancelJobs` and `DeleteJobs` | 64 characters |";
    assert!(documentation.contains(row), "{row}");
    for (length, rule) in [(64, "is not a next_page_token of this call"), (65, "must have at most 64 characters")] {
        let page_token = "x".repeat(length);
        let list = v1::ListJobsRequest { page_token: page_token.clone(), ..Default::default() };
        let cancel = v1::CancelJobsRequest { page_token: page_token.clone(), all: true, ..Default::default() };
        let delete = v1::DeleteJobsRequest { page_token, all: true, ..Default::default() };
        let mut jobs = server.jobs();
        for refused in [
            jobs.list_jobs(list).await.unwrap_err(),
            jobs.cancel_jobs(cancel).await.unwrap_err(),
            jobs.delete_jobs(delete).await.unwrap_err(),
        ] {
            let details = refused.get_error_details();
            let violation = &details.bad_request().unwrap().field_violations[0];
            assert!(violation.field == "page_token" && violation.description.starts_with(rule), "{violation:?}");
        }
    }
    server.stop().await;
}

/// Texts of dialogs may be long.
async fn values(door: &mut Door<'_>) {
    let whole = door.server.request("values", "EVENTS 1").await;
    for texts in [vec![64 * 1024 + 1], vec![60 * 1024; 5]] {
        let text = |length| Some(v1::dialog_value::Value::Text("x".repeat(length)));
        let named = |(at, length)| (format!("V{at}"), v1::DialogValue { value: text(length) });
        let values = texts.into_iter().enumerate().map(named).collect();
        let answer = v1::DialogAnswer { dialog: "D".into(), values, ..Default::default() };
        let options = Some(v1::JobOptions { answers: vec![answer.clone()], ..Default::default() });
        let submit = v1::SubmitJobRequest { options, ..whole.clone() };
        door.refuses("Jobs/SubmitJob", submit, "DialogValue.text", "options.answers[0].values").await;
        let request = v1::AnswerQuestionRequest { job_id: "j".into(), question_id: 1, answer: Some(answer) };
        door.refuses("Operator/AnswerQuestion", request, "DialogValue.text", "answer.values").await;
    }
}

/// Breakpoints come on the stream of a stepped job.
async fn breakpoints(door: &mut Door<'_>) {
    use v1::breakpoint::At;
    use v1::debug_command::What;
    use v1::debug_request::Content;
    let long = "x".repeat(5000);
    let line = v1::BreakLine { file: long.clone(), line: 1 };
    for (number, (text, at, field)) in [
        ("Breakpoint.wait", At::Wait(long.clone()), "wait"),
        ("Breakpoint.wait", At::Wait("M\x00100".to_owned()), "wait"),
        ("Breakpoint.write", At::Write(long.clone()), "write"),
        ("BreakLine.file", At::Line(line), "line.file"),
    ]
    .into_iter()
    .enumerate()
    {
        let mut request = door.server.request(&format!("breakpoint-{number}"), "STEP a").await;
        request.options = Some(v1::JobOptions { stepped: true, ..Default::default() });
        let job = door.server.jobs().submit_job(request).await.unwrap().into_inner().status.unwrap().job_id;
        let add = What::Add(v1::Breakpoint { at: Some(at), ..Default::default() });
        let messages = [Content::JobId(job.clone()), Content::Command(v1::DebugCommand { what: Some(add) })];
        let messages = messages.map(|content| v1::DebugRequest { content: Some(content) });
        let mut stream = door.server.operator().debug(tokio_stream::iter(messages)).await.unwrap().into_inner();
        let refused = loop {
            match stream.message().await {
                Ok(message) => assert!(message.is_some(), "{text}"),
                Err(refused) => break refused,
            }
        };
        let details = refused.get_error_details();
        assert_eq!(details.bad_request().unwrap().field_violations[0].field, format!("command.add.{field}"));
        door.seen.insert(text.to_owned());
        door.server.jobs().cancel_job(v1::CancelJobRequest { job_id: job }).await.unwrap();
    }
}

/// Every list of every request is refused if it has one entry more than `docs/api.md` allows.
#[tokio::test]
async fn every_list_of_every_request_has_a_limit_that_its_refusal_names() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let mut door = Door { server: &server, seen: BTreeSet::new() };
    let find = v1::FindMissingRequest { digests: vec![digest(b"x"); 10_001] };
    door.refuses("Blobs/FindMissing", find, "FindMissingRequest.digests", "digests").await;
    let file = |at: usize| (format!("file-{at}"), digest(b"x"));
    let files: Vec<_> = (0..1001).map(file).map(|(path, digest)| v1::MachineFile { path, digest }).collect();
    let put = v1::PutMachineRequest { name: "own".into(), files: files.clone() };
    door.refuses("Machines/PutMachine", put, "PutMachineRequest.files", "files").await;
    let check = v1::CheckMachineRequest { name: "own".into(), files };
    door.refuses("Machines/CheckMachine", check, "CheckMachineRequest.files", "files").await;
    let labels = || (0..33).map(|at| (format!("k{at}"), String::new())).collect();
    let rerun = v1::RerunJobRequest { request_id: "r".into(), labels: labels(), ..Default::default() };
    door.refuses("Jobs/RerunJob", rerun, "RerunJobRequest.labels", "labels").await;
    let states = vec![v1::JobState::Queued as i32; 17];
    let list = v1::ListJobsRequest { states: states.clone(), ..Default::default() };
    door.refuses("Jobs/ListJobs", list, "ListJobsRequest.states", "states").await;
    for (text, filter) in [
        ("states", v1::JobFilter { states, ..Default::default() }),
        ("labels", v1::JobFilter { labels: labels(), ..Default::default() }),
    ] {
        let (field, text, filter) = (format!("filter.{text}"), format!("JobFilter.{text}"), Some(filter));
        let list = v1::ListJobsRequest { filter: filter.clone(), ..Default::default() };
        door.refuses("Jobs/ListJobs", list, &text, &field).await;
        let watch = v1::WatchJobsRequest { filter: filter.clone(), ..Default::default() };
        door.refuses("Jobs/WatchJobs", watch, &text, &field).await;
        let cancel = v1::CancelJobsRequest { filter: filter.clone(), ..Default::default() };
        door.refuses("Jobs/CancelJobs", cancel, &text, &field).await;
        let delete = v1::DeleteJobsRequest { filter, ..Default::default() };
        door.refuses("Jobs/DeleteJobs", delete, &text, &field).await;
    }
    let whole = server.request("r", "EVENTS 1").await;
    let program = |_| v1::Program { path: "main.nc".into(), ..Default::default() };
    let submits = [
        ("programs", v1::SubmitJobRequest { programs: (0..65).map(program).collect(), ..whole.clone() }),
        ("labels", v1::SubmitJobRequest { labels: labels(), ..whole.clone() }),
        ("files", {
            let more = (0..1000).map(file).map(|(path, digest)| v1::FileRef { path, digest });
            v1::SubmitJobRequest { files: whole.files.iter().cloned().chain(more).collect(), ..whole.clone() }
        }),
    ];
    for (field, request) in submits {
        door.refuses("Jobs/SubmitJob", request, &format!("SubmitJobRequest.{field}"), field).await;
    }
    let answer = v1::DialogAnswer { dialog: "D".into(), ..Default::default() };
    let values = (0..1001).map(|at| (format!("v{at}"), v1::DialogValue::default())).collect();
    let many = v1::DialogAnswer { values, ..answer.clone() };
    for (text, options) in [
        ("JobOptions.opskip", v1::JobOptions { opskip: vec![1; 17], ..Default::default() }),
        ("JobOptions.ignore_waits", v1::JobOptions { ignore_waits: vec![1; 1001], ..Default::default() }),
        ("JobOptions.answers", v1::JobOptions { answers: vec![answer; 10_001], ..Default::default() }),
        ("JobOptions.warnings_off", v1::JobOptions { warnings_off: vec![77; 1001], ..Default::default() }),
        ("JobOptions.warnings_on", v1::JobOptions { warnings_on: vec![77; 1001], ..Default::default() }),
        ("DialogAnswer.values", v1::JobOptions { answers: vec![many], ..Default::default() }),
    ] {
        let request = v1::SubmitJobRequest { options: Some(options), ..whole.clone() };
        let field = if text.ends_with("values") { "options.answers[0].values" } else { &text["JobOptions.".len()..] };
        let field = format!("options.{}", field.trim_start_matches("options."));
        door.refuses("Jobs/SubmitJob", request, text, &field).await;
    }
    assert_eq!(door.seen, lists());
    server.stop().await;
}

/// A number that JSON does not have would make the row of its job unreadable.
#[tokio::test]
async fn numbers_of_answers_are_finite() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let mut door = Door { server: &server, seen: BTreeSet::new() };
    for number in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let value = v1::DialogValue { value: Some(v1::dialog_value::Value::Number(number)) };
        let answer =
            v1::DialogAnswer { dialog: "D".into(), values: [("V".to_owned(), value)].into(), ..Default::default() };
        let options = v1::JobOptions { answers: vec![answer.clone()], ..Default::default() };
        let submit = v1::SubmitJobRequest { options: Some(options), ..server.request("r", "").await };
        door.refuses("Jobs/SubmitJob", submit, "", "options.answers[0].values").await;
        let given = v1::AnswerQuestionRequest { answer: Some(answer), ..Default::default() };
        door.refuses("Operator/AnswerQuestion", given, "", "answer.values").await;
    }
    server.stop().await;
}

/// Lists at their limits pass, and texts with invalid content are refused.
#[tokio::test]
async fn lists_have_limits_and_letters_tokens_and_names_are_of_their_kind() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let mut door = Door { server: &server, seen: BTreeSet::new() };
    let states = vec![v1::JobState::Queued as i32; 1_000_000];
    let list = v1::ListJobsRequest { states, ..Default::default() };
    door.refuses("Jobs/ListJobs", list, "", "states").await;
    let list = v1::ListJobsRequest { states: vec![v1::JobState::Queued as i32; 16], ..Default::default() };
    server.jobs().list_jobs(list).await.unwrap();
    let find = v1::FindMissingRequest { digests: vec![digest(b"x"); 10_000] };
    server.blobs().find_missing(find).await.unwrap();
    let whole = server.request("r", "EVENTS 1").await;
    let of = |options: v1::JobOptions| v1::SubmitJobRequest { options: Some(options), ..whole.clone() };
    for options in [
        v1::JobOptions { trace: "Q!?".into(), ..Default::default() },
        v1::JobOptions { trace: "b\u{2028}a".into(), ..Default::default() },
    ] {
        door.refuses("Jobs/SubmitJob", of(options), "", "options.trace").await;
    }
    let longest = format!("{}@{}", "m".repeat(64), "0".repeat(16));
    let get = |name: String| v1::GetMachineRequest { name, ..Default::default() };
    assert_eq!(reason(&server.machines().get_machine(get(longest.clone())).await.unwrap_err()), "UNKNOWN_MACHINE");
    for name in [longest + "0", "m".repeat(65)] {
        door.refuses("Machines/GetMachine", get(name), "", "name").await;
    }
    let list = v1::ListMachinesRequest { page_token: "\u{2028}".into(), ..Default::default() };
    door.refuses("Machines/ListMachines", list, "", "page_token").await;
    // A limit above the maximum means the maximum; a token is that of a page.
    let limits = v1::JobLimits { nesting: u32::MAX, ..Default::default() };
    let options = v1::JobOptions {
        limits: Some(limits),
        opskip: vec![1; 16],
        ignore_waits: vec![9999; 1000],
        warnings_off: vec![77; 1000],
        warnings_on: vec![78; 1000],
        trace: "iEw".into(),
        ..Default::default()
    };
    let job = server.jobs().submit_job(of(options)).await.unwrap().into_inner().status.unwrap().job_id;
    server.wait(&job).await;
    assert_eq!(server.script.limits.lock().unwrap().as_ref().unwrap().nesting, 1000);
    let list = v1::ListFilesRequest { job_id: job, page_token: "none".into(), ..Default::default() };
    assert_eq!(reason(&server.results().list_files(list).await.unwrap_err()), "INVALID_REQUEST");
    server.stop().await;
}

#[tokio::test]
async fn a_chunk_of_an_upload_has_a_limit() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let content = vec![7; (1 << 20) + 1];
    let upload = |parts: &[&[u8]]| {
        let part = |data: &&[u8]| v1::UploadRequest { data: data.to_vec().into(), ..Default::default() };
        let mut chunks: Vec<_> = parts.iter().map(part).collect();
        chunks[0].digest = digest(&content);
        let mut blobs = server.blobs();
        async move { blobs.upload(tokio_stream::iter(chunks)).await }
    };
    for parts in [&[&content[..]][..], &[&[], &content]] {
        let refused = upload(parts).await.unwrap_err();
        assert_eq!(refused.get_error_details().bad_request().unwrap().field_violations[0].field, "data");
    }
    upload(&[&content[..1 << 20], &content[1 << 20..]]).await.unwrap();
    server.stop().await;
}
