//! One changed bit anywhere in the data folder: the answer is the original, or the damage is reported. It is never
//! served as something else.
//!
//! `FLIPS` in the environment is the number of bits, by default 200.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use counterpoint_proto::v1;
use counterpoint_server::doctor::examine;
use counterpoint_server::local::disk::Disk;
use prost::Message;
use tonic::{Code, Status};

use crate::bad_disk::Random;
use crate::support::*;

/// Answers to a client by their questions: the bytes of an answer, or the code of a refusal.
type Answers = BTreeMap<String, Result<Vec<u8>, Code>>;

/// Jobs of all kinds: a log in the ledger, in a plain and in a compressed file, files of macros, a refused job.
const SCRIPTS: [(&str, &str); 5] = [
    ("small", "EVENTS 9"),
    ("plain", "EVENTS 700"),
    ("packed", "EVENTS 3000"),
    ("wrote", "EVENTS 12\nWRITE a.txt\nWRITE out/b.txt"),
    ("refused", "REFUSE"),
];
const MACHINE: &str = "extends = \"fanuc-mill\"\n[ce]\nname = \"own\"\n";

fn encoded<T: Message>(answer: Result<tonic::Response<T>, Status>) -> Result<Vec<u8>, Code> {
    answer.map(|answer| answer.into_inner().encode_to_vec()).map_err(|status| status.code())
}

async fn whole<T: Message>(
    answer: Result<tonic::Response<tonic::Streaming<T>>, Status>,
    part: impl Fn(T) -> Vec<u8>,
) -> Result<Vec<u8>, Code> {
    let mut stream = answer.map_err(|status| status.code())?.into_inner();
    let mut all = Vec::new();
    while let Some(message) = stream.message().await.map_err(|status| status.code())? {
        all.extend(part(message));
    }
    Ok(all)
}

/// The status of a job whose log is damaged stays readable, without the description that the log has.
fn without_description(
    answer: Result<tonic::Response<v1::GetJobResponse>, Status>,
) -> Result<tonic::Response<v1::GetJobResponse>, Status> {
    answer.map(|answer| answer.map(|job| v1::GetJobResponse { description: None, ..job }))
}

/// All answers about a job.
async fn ask_of(server: &Server, name: &str, job: &str, answers: &mut Answers) {
    let job_id = job.to_owned();
    let get = v1::GetJobRequest { job_id: job_id.clone() };
    answers.insert(format!("{name} status"), encoded(without_description(server.jobs().get_job(get).await)));
    let watch =
        v1::WatchJobRequest { job_id: job_id.clone(), level: v1::WatchLevel::Everything.into(), ..Default::default() };
    let events = |message: v1::WatchJobResponse| match message.content {
        Some(v1::watch_job_response::Content::Batch(batch)) => batch.encode_to_vec(),
        _ => Vec::new(),
    };
    answers.insert(format!("{name} watch"), whole(server.jobs().watch_job(watch).await, events).await);
    let get = v1::GetSummaryRequest { job_id: job_id.clone() };
    let summary = whole(server.results().get_summary(get).await, |message| message.data.to_vec()).await;
    answers.insert(format!("{name} summary"), summary);
    let list = v1::ListFilesRequest { job_id: job_id.clone(), ..Default::default() };
    answers.insert(format!("{name} files"), encoded(server.results().list_files(list).await));
    let get = v1::GetFileRequest { job_id, path: "a.txt".into() };
    let file = whole(server.results().get_file(get).await, |message| message.data.to_vec()).await;
    answers.insert(format!("{name} file"), file);
}

/// All answers about a folder.
async fn ask(server: &Server, jobs: &BTreeMap<&str, String>) -> Answers {
    let mut answers = Answers::new();
    for (name, job) in jobs {
        ask_of(server, name, job, &mut answers).await;
    }
    let list = server.jobs().list_jobs(v1::ListJobsRequest::default()).await;
    answers.insert("list".into(), encoded(list));
    let get = v1::GetMachineRequest { name: "own".into(), ..Default::default() };
    answers.insert("machine".into(), encoded(server.machines().get_machine(get).await));
    for content in SCRIPTS.map(|(_, script)| script).into_iter().chain([MACHINE]) {
        answers.extend([blob(server, content).await]);
    }
    answers
}

async fn blob(server: &Server, content: &str) -> (String, Result<Vec<u8>, Code>) {
    let digest = digest(content.as_bytes());
    let download = server.blobs().download(v1::DownloadRequest { digest: digest.clone() }).await;
    (digest, whole(download, |message| message.data.to_vec()).await)
}

/// Compares answers with the true ones; those that differ must be refused as damage. Returns the number of the latter.
fn compare(place: &str, answers: &Answers, truth: &Answers) -> usize {
    let mut lost = 0;
    for (question, answer) in answers {
        if *answer == truth[question] {
            continue;
        }
        lost += 1;
        // A damaged blob is put aside, so the next question does not find it.
        let of_blob = question.len() == 64 && *answer == Err(Code::NotFound);
        assert!(*answer == Err(Code::DataLoss) || of_blob, "{place}: {question} is answered by {answer:?}");
    }
    lost
}

/// A file and one of its bits.
struct Flip<'a> {
    path: &'a Path,
    whole: Vec<u8>,
}

impl<'a> Flip<'a> {
    fn make(path: &'a Path, random: &mut Random) -> (Self, String) {
        let whole = std::fs::read(path).unwrap();
        let mut changed = whole.clone();
        let bit = below(random, whole.len() * 8);
        changed[bit / 8] ^= 1 << (bit % 8);
        std::fs::write(path, changed).unwrap();
        (Self { path, whole }, format!("bit {bit} of {}", path.display()))
    }
}

impl Drop for Flip<'_> {
    fn drop(&mut self) {
        std::fs::write(self.path, &self.whole).unwrap();
        let _ = std::fs::remove_file(self.path.with_extension("damaged"));
    }
}

fn below(random: &mut Random, end: usize) -> usize {
    usize::try_from(random.below(end as u64)).unwrap()
}

/// A folder with jobs of all kinds, and its jobs by name.
async fn folder_of_all(folder: &Path) -> BTreeMap<&'static str, String> {
    let server = Server::start(options(folder)).await;
    let mut jobs = BTreeMap::new();
    for (name, script) in SCRIPTS {
        let job = server.submit(name, script).await;
        server.wait(&job).await;
        jobs.insert(name, job);
    }
    let digest = server.upload(MACHINE.as_bytes()).await;
    let files = vec![v1::MachineFile { path: "own/machine.toml".into(), digest }];
    server.machines().put_machine(v1::PutMachineRequest { name: "own".into(), files }).await.unwrap();
    server.stop().await;
    jobs
}

fn flips() -> usize {
    std::env::var("FLIPS").ok().map_or(200, |text| text.parse().unwrap())
}

#[tokio::test]
async fn a_changed_bit_in_a_file_is_reported_or_harmless() {
    let folder = tempfile::tempdir().unwrap();
    let jobs = folder_of_all(folder.path()).await;
    let server = Server::start(options(folder.path())).await;
    let truth = ask(&server, &jobs).await;
    assert!(truth.values().filter(|answer| answer.is_ok()).count() > 20, "{truth:?}");
    let job = |name: &str, file: &str| folder.path().join("jobs").join(&jobs[name]).join(file);
    let blobs = folder.path().join("blobs");
    let of_blob = |content: &str| {
        let name = digest(content.as_bytes());
        blobs.join(&name[..2]).join(name)
    };
    let mut files: Vec<(PathBuf, &str)> = vec![
        (job("plain", "log"), "plain"),
        (job("packed", "log.segments"), "packed"),
        (job("wrote", "files.json"), "wrote"),
    ];
    files.extend([of_blob("EVENTS 9"), of_blob(MACHINE)].map(|path| (path, "")));
    let (mut random, mut lost) = (Random(7), BTreeMap::<&PathBuf, usize>::new());
    for number in 0..flips() * 17 / 20 {
        let (path, name) = &files[number % files.len()];
        let (flip, place) = Flip::make(path, &mut random);
        let mut answers = Answers::new();
        if name.is_empty() {
            answers
                .extend([blob(&server, if path.ends_with(digest(b"EVENTS 9")) { "EVENTS 9" } else { MACHINE }).await]);
        } else {
            ask_of(&server, name, &jobs[name], &mut answers).await;
        }
        *lost.entry(path).or_default() += compare(&place, &answers, &truth).min(1);
        drop(flip);
    }
    for (path, _) in &files {
        assert!(lost[path] > flips() / 20, "damage of {} is reported: {lost:?}", path.display());
    }
    assert_eq!(ask(&server, &jobs).await, truth);
    server.stop().await;
}

/// A result of a job, by the name of the file in which it is stored.
async fn stored(server: &Server, job: &str, name: &str) -> Result<Vec<u8>, Code> {
    let (mut results, job_id) = (server.results(), job.to_owned());
    let format = match name.rsplit('.').next() {
        Some("json") => v1::DrawingFormat::Json.into(),
        _ => v1::DrawingFormat::Svg.into(),
    };
    match name.split('.').next().unwrap() {
        "summary" => {
            let answer = results.get_summary(v1::GetSummaryRequest { job_id }).await;
            whole(answer, |message| message.data.to_vec()).await
        }
        "timeline" => {
            let answer = results.get_timeline(v1::GetTimelineRequest { job_id, format }).await;
            whole(answer, |message| message.data.to_vec()).await
        }
        _ => {
            let answer = results.get_toolpath(v1::GetToolpathRequest { job_id, format }).await;
            whole(answer, |message| message.data.to_vec()).await
        }
    }
}

/// A result that is stored in a file is made again from the log after any damage; without the log the damage is
/// reported.
#[tokio::test]
async fn a_changed_bit_in_a_stored_result_is_never_served() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let job = server.submit("large", "EVENTS 30000").await;
    server.wait(&job).await;
    server.stop().await;
    // A server that has just started makes no result from memory.
    let server = Server::start(options(folder.path())).await;
    let of_job = folder.path().join("jobs").join(&job);
    let mut random = Random(13);
    for name in ["summary.json", "timeline.json", "timeline.svg", "toolpath.json", "toolpath.svg"] {
        let path = of_job.join(name);
        let truth = stored(&server, &job, name).await.unwrap();
        assert!(std::fs::read(&path).unwrap().ends_with(&truth) && !truth.is_empty(), "{name} is stored");
        for _ in 0..flips() / 25 {
            let (flip, place) = Flip::make(&path, &mut random);
            assert!(stored(&server, &job, name).await.as_ref() == Ok(&truth), "{place}: not the original");
            drop(flip);
        }
        let (of_result, place) = Flip::make(&path, &mut random);
        let log = log_file(folder.path(), &job);
        let (whole_log, half) = (std::fs::read(&log).unwrap(), std::fs::metadata(&log).unwrap().len() / 2);
        std::fs::OpenOptions::new().write(true).open(&log).unwrap().set_len(half).unwrap();
        assert_eq!(stored(&server, &job, name).await, Err(Code::DataLoss), "{place}, and the log is damaged");
        drop(of_result);
        assert!(stored(&server, &job, name).await.as_ref() == Ok(&truth), "{name} needs no log");
        std::fs::write(&log, whole_log).unwrap();
    }
    server.stop().await;
}

#[tokio::test]
async fn a_changed_bit_in_the_ledger_is_reported_by_doctor_and_start_and_what_is_whole_is_saved() {
    let folder = tempfile::tempdir().unwrap();
    let jobs = folder_of_all(folder.path()).await;
    let server = Server::start(options(folder.path())).await;
    let truth = ask(&server, &jobs).await;
    server.stop().await;
    let ledger = folder.path().join("ledger.redb");
    redb::Database::open(&ledger).unwrap().compact().unwrap();
    let (clean, mut random) = (std::fs::read(&ledger).unwrap(), Random(11));
    // Most of the other bytes belong to nothing.
    let used: Vec<usize> = (0..clean.len()).filter(|at| clean[*at] != 0).collect();
    let (mut refused, mut repaired, mut unusable) = (0, 0, 0);
    for number in 0..flips() * 3 / 20 {
        let mut bytes = clean.clone();
        let at = if number % 8 == 0 { below(&mut random, 512) } else { used[below(&mut random, used.len())] };
        bytes[at] ^= 1 << below(&mut random, 8);
        std::fs::write(&ledger, &bytes).unwrap();
        let place = format!("byte {at} of the ledger");
        let found = examine(folder.path(), false).unwrap_or_else(|error| panic!("{place}: {error}"));
        assert_eq!(std::fs::read(&ledger).unwrap(), bytes, "{place}: an examination changes nothing");
        match Server::try_start(options(folder.path()), Disk::default()).await {
            Err(error) => {
                let error = error.to_string();
                assert!(error.contains("ledger.redb") && error.contains("doctor --repair"), "{place}: {error}");
                assert!(!found.is_empty(), "{place}: doctor says nothing, start says {error}");
                refused += 1;
            }
            Ok(server) => {
                compare(&place, &ask(&server, &jobs).await, &truth);
                server.stop().await;
                continue;
            }
        }
        if number % 5 == 0 {
            let (status, text) = doctor(folder.path());
            assert!(status == Some(1) && !text.contains("panicked"), "{place}: {text}");
        }
        // A repair removes folders of jobs whose rows are lost.
        let copy = tempfile::tempdir().unwrap();
        crate::life::copy(folder.path(), copy.path());
        let mended = examine(copy.path(), true).unwrap();
        let ledger = copy.path().join("ledger.redb");
        if mended.iter().any(|damage| damage.path == ledger && !damage.repaired) {
            unusable += 1;
            continue;
        }
        repaired += 1;
        let server = Server::start(options(copy.path())).await;
        let mut missing = 0;
        for (name, job) in &jobs {
            let get = v1::GetJobRequest { job_id: job.clone() };
            match encoded(without_description(server.jobs().get_job(get).await)) {
                answer if answer == truth[&format!("{name} status")] => {}
                Err(Code::NotFound | Code::DataLoss) => missing += 1,
                other => panic!("{place}: {name} {other:?}"),
            }
        }
        assert!(missing <= 1, "{place}: {missing} jobs are lost by one bit");
        server.stop().await;
    }
    let counts = format!("{refused} refused, {repaired} repaired, {unusable} unusable");
    assert!(refused >= flips() / 100 && unusable == 0, "{counts}");
}

/// Exit code and output of the command.
fn doctor(folder: &Path) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_counterpointd"));
    let output = command.args(["doctor", "--data"]).arg(folder).output().unwrap();
    let text = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8(text).unwrap())
}
