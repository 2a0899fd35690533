//! Commands for jobs on a server: several jobs at once, a full queue, deadlines, and the JSON of a status.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)]

mod served;

use std::io::{BufRead as _, BufReader, Read as _};
use std::process::{Command, Stdio};
use std::time::Duration;

use counterpoint_server::options::{Maxima, Quotas, ServerOptions};
use serde_json::Value;
use served::{Server, program};

const CLEAN: &str = "O1\nG21 G90 G0 X1.\nM30\n";
const ENDLESS: &str = "O1\nN1 G4 P9\nGOTO 1\nM30\n";

#[test]
fn several_jobs_are_awaited_and_each_end_names_its_job() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), ServerOptions::default());
    let clean = program(folder.path(), "clean.nc", CLEAN);
    let alarm = program(folder.path(), "alarm.nc", "O1\nG21 G90 G0 X[1/0]\nM30\n");
    let jobs = [server.submit(&clean), server.submit(&alarm)];
    let (code, out, talk) = server.call(&["wait", &jobs[0], &jobs[1]]);
    assert_eq!((code, out.as_str()), (1, ""), "the highest code: {talk}");
    for (job, state, name) in [(&jobs[0], "SUCCEEDED", "clean.nc"), (&jobs[1], "FAILED", "alarm.nc")] {
        let line = talk.lines().find(|line| line.starts_with(&format!("{job}  {state}"))).expect(&talk);
        assert!(line.contains(name), "{line}");
    }
    let (code, out, _) = server.call(&["wait", "--json", &jobs[1], &jobs[0]]);
    let lines: Vec<Value> = out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!((code, &lines[0]["job"], &lines[1]["job"]), (1, &jobs[1].as_str().into(), &jobs[0].as_str().into()));
    let (code, _, talk) = server.call(&["wait", "--quiet", &jobs[0]]);
    assert_eq!((code, talk.as_str()), (0, ""));
}

/// 60 mm at 600 mm/min take 6 s without accelerations; after half of this time X has covered half of its travel.
#[test]
fn an_instant_of_a_job_of_the_server_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), ServerOptions::default());
    let cut = program(folder.path(), "cut.nc", "O1\nG21 G90 G94 G0 X0.\nG1 X60. F600.\nM30\n");
    let (code, job, talk) = server.call(&["submit", "--machine", "fanuc-mill", "--time", "simple", "--law", &cut]);
    assert_eq!((code, server.call(&["wait", "--quiet", &job]).0), (0, 0), "{talk}");
    let (_, times, _) = server.call(&["where", &job, "cut.nc:3", "--json"]);
    let times: serde_json::Value = serde_json::from_str(&times).unwrap();
    let [start, takes] = ["t_ns", "dur_ns"].map(|name| times[0][name].as_i64().unwrap());
    assert_eq!(takes, 6_000_000_000, "{times}");
    let (code, state, talk) = server.call(&["at", &job, &format!("{}ms", (start + takes / 2) / 1_000_000), "--json"]);
    let state: serde_json::Value = serde_json::from_str(&state).expect(&talk);
    let x = state["channels"][0]["position"]["X"].as_f64().unwrap();
    // The start is not at a whole millisecond.
    assert!(code == 0 && (x - 30.0).abs() < 0.02, "{state}");
}

/// `submit` offers no answer to a job that waits for a client, so the commands that show the job name the next command.
#[test]
fn a_job_that_waits_for_a_client_or_is_paused_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), ServerOptions::default());
    let clean = program(folder.path(), "clean.nc", CLEAN);
    let (_, job, talk) = server.call(&["submit", "--machine", "fanuc-mill", "--step", &clean]);
    let expect = |command: &[&str], expected: &str| {
        let mut child = server.command(command).stderr(Stdio::piped()).spawn().unwrap();
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
        let found = lines.by_ref().map_while(Result::ok).find(|line| line.contains(expected));
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(found.is_some(), "{command:?}: {expected}; {talk}");
    };
    expect(&["wait", &job], &format!("{job}  waits for a step command since "));
    expect(&["watch", &job], &format!("UTC: counterpoint step {job}"));
    let (_, status, _) = server.call(&["status", &job, "--json"]);
    let status: Value = serde_json::from_str(&status).unwrap();
    assert_eq!((&status["state"], &status["operator_wait"]["action"]), (&"RUNNING".into(), &"COMMAND".into()));
    assert!(server.call(&["status", &job]).1.contains("\nwaits         for a step command since "));
    assert!(server.call(&["jobs"]).1.contains("RUNNING (waits for a step command)"));
    assert!(server.call(&["admin", "workers"]).1.contains("waits for a step command"));
    assert_eq!(server.call(&["pause", &job]).0, 0);
    expect(&["wait", &job], &format!("{job}  paused: counterpoint resume {job}"));
    expect(&["watch", &job], &format!("paused: counterpoint resume {job}"));
}

/// The keys are those of docs/cli.md.
#[test]
fn the_json_of_a_status_has_the_documented_keys() {
    const DOCS: &str = include_str!("../../docs/cli.md");
    let section = DOCS.split("### The JSON of a status").nth(1).expect("a section").split("\n## ").next().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), ServerOptions::default());
    let endless = program(folder.path(), "endless.nc", ENDLESS);
    let with = ["--machine", "fanuc-mill", "--max-time", "1", "--deadline", "1h"];
    let (_, job, _) = server.call(&[&["submit", &endless][..], &with].concat());
    let (_, text, _) = server.call(&["wait", "--json", &job]);
    let status: Value = serde_json::from_str(&text).unwrap();
    for key in status.as_object().unwrap().keys() {
        assert!(section.contains(&format!("| `{key}` |")), "{key} is not documented");
    }
    assert_eq!((&status["cause"], &status["limit"]), (&"LIMIT".into(), &"SIMULATED_NS".into()), "{status}");
    assert_eq!(status["attempt"], 1, "{status}");
    assert!(status["cpu_us"].as_u64().is_some(), "{status}");
    let (_, text, _) = server.call(&["status", &job]);
    assert!(text.contains("\nstopped after ") && !text.contains("cycle time"), "{text}");
}

/// Each further program is submitted when the queue has room for it.
#[test]
fn programs_wait_for_a_place_in_the_queue() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), ServerOptions { workers: 1, queue: 1, ..ServerOptions::default() });
    let endless = program(folder.path(), "endless.nc", ENDLESS);
    let mut endless_jobs = Vec::new();
    loop {
        let (code, job, talk) = server.call(&["submit", "--machine", "fanuc-mill", &endless]);
        if code != 0 {
            assert!(talk.contains("QUEUE_FULL"), "{talk}");
            break;
        }
        endless_jobs.push(job);
    }
    let names = ["one.nc", "two.nc"].map(|name| program(folder.path(), name, CLEAN));
    let mut command = server.command(&["submit", "--each", "--machine", "fanuc-mill", &names[0], &names[1]]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut talk = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    while !line.contains("QUEUE_FULL") {
        line.clear();
        assert!(talk.read_line(&mut line).unwrap() > 0, "the command must report that it waits");
    }
    assert!(line.contains(&names[0]) && line.contains("waits"), "{line}");
    endless_jobs.iter().for_each(|job| assert_eq!(server.call(&["cancel", job]).0, 0));
    let mut ids = String::new();
    child.stdout.take().unwrap().read_to_string(&mut ids).unwrap();
    assert!(child.wait().unwrap().success());
    assert_eq!(ids.lines().count(), 2, "{ids}");
}

/// The quota of waiting jobs passes like a full queue, unless the user does not wait.
#[test]
fn programs_wait_for_the_quota_of_waiting_jobs() {
    let folder = tempfile::tempdir().unwrap();
    let quotas = Quotas { tenant_queued: 1, ..Quotas::default() };
    let server = Server::start(folder.path(), ServerOptions { workers: 1, quotas, ..ServerOptions::default() });
    let endless = program(folder.path(), "endless.nc", ENDLESS);
    let mut endless_jobs = Vec::new();
    loop {
        let (code, job, talk) = server.call(&["submit", "--machine", "fanuc-mill", &endless]);
        if code != 0 {
            assert!(talk.contains("QUOTA_EXCEEDED"), "{talk}");
            break;
        }
        endless_jobs.push(job);
    }
    let names = ["one.nc", "two.nc"].map(|name| program(folder.path(), name, CLEAN));
    let each = ["submit", "--each", "--machine", "fanuc-mill", &names[0], &names[1]];
    let (code, _, talk) = server.call(&[&each[..], &["--no-wait"]].concat());
    assert!(code == 3 && talk.ends_with("0 of 2 submitted\n"), "{code} {talk}");
    let mut child = server.command(&each).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut talk = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    talk.read_line(&mut line).unwrap();
    assert!(line.contains(&names[0]) && line.contains("waits") && line.contains("QUOTA_EXCEEDED"), "{line}");
    endless_jobs.iter().for_each(|job| assert_eq!(server.call(&["cancel", job]).0, 0));
    assert!(child.wait().unwrap().success());
    line.clear();
    talk.read_to_string(&mut line).unwrap();
    assert!(!line.contains("of 2 submitted"), "{line}");
}

#[test]
fn a_program_that_is_not_submitted_has_an_object_in_the_json() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), ServerOptions::default());
    let clean = program(folder.path(), "clean.nc", CLEAN);
    let absent = folder.path().join("absent.nc").display().to_string();
    let (code, out, _) = server.call(&["submit", "--each", "--json", "--machine", "fanuc-mill", &absent, &clean]);
    assert_eq!(code, 2);
    let lines: Vec<Value> = out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!((lines.len(), &lines[0]["program"]), (2, &absent.as_str().into()), "{out}");
    assert!(lines[0]["error"].as_str().unwrap().contains("does not exist"), "{out}");
    assert!(lines[0].get("job").is_none() && lines[1]["job"].is_string(), "{out}");
}

#[test]
fn a_deadline_in_the_past_is_refused_unless_the_request_is_a_repetition() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), ServerOptions::default());
    let clean = program(folder.path(), "clean.nc", CLEAN);
    let job = server.submit(&clean);
    for command in [&["submit", "--machine", "fanuc-mill", &clean][..], &["rerun", &job]] {
        let past = [command, &["--deadline", "@1000"]].concat();
        let (code, _, talk) = server.call(&past);
        assert!(code == 2 && talk.contains("1970-01-01 00:16:40 UTC has passed"), "{talk}");
        assert_eq!(server.call(&[&past[..], &["--request-id", command[0]]].concat()).0, 0);
    }
}

/// docs/cli.md: with a request id the command can be repeated safely.
#[test]
fn a_request_with_a_relative_deadline_can_be_repeated() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), ServerOptions::default());
    let clean = program(folder.path(), "clean.nc", CLEAN);
    let earlier = server.submit(&clean);
    for command in [&["submit", "--machine", "fanuc-mill", &clean][..], &["rerun", &earlier]] {
        let command = [command, &["--deadline", "30m", "--request-id", command[0]]].concat();
        let (code, job, talk) = server.call(&command);
        assert_eq!(code, 0, "{talk}");
        let (code, again, talk) = server.call(&command);
        assert_eq!((code, again), (0, job), "{talk}");
    }
}

#[test]
fn a_folder_that_hides_a_machine_of_the_server_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), ServerOptions::default());
    let clean = program(folder.path(), "clean.nc", CLEAN);
    let own = folder.path().join("cell").display().to_string();
    let made = Command::new(env!("CARGO_BIN_EXE_counterpoint"))
        .args(["machine", "new", &own, "--from", "fanuc-mill"])
        .output()
        .unwrap();
    assert!(made.status.success());
    let submit = |machine: &str| {
        let mut command = server.command(&["submit", "--machine", machine, &clean]);
        let output = command.current_dir(folder.path()).output().unwrap();
        let talk = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{talk}");
        talk
    };
    let talk = submit("cell");
    assert!(talk.contains("machine from the folder 'cell' here"), "{talk}");
    assert!(!submit("./cell").contains("from the folder"), "the argument names the folder");
}

/// `wait` selects jobs as `jobs`, `cancel` and `delete` do.
#[test]
fn the_jobs_of_a_filter_are_awaited() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), ServerOptions::default());
    let clean = program(folder.path(), "clean.nc", CLEAN);
    let alarm = program(folder.path(), "alarm.nc", "O1\nG21 G90 G0 X[1/0]\nM30\n");
    let submit = |program: &str, label: &str| {
        let (code, job, talk) = server.call(&["submit", "--machine", "fanuc-mill", "--label", label, program]);
        assert_eq!(code, 0, "{talk}");
        job
    };
    let jobs = [submit(&clean, "batch=1"), submit(&clean, "batch=2"), submit(&alarm, "batch=2")];
    let (code, out, talk) = server.call(&["wait", "--json", "--label", "batch=1"]);
    assert_eq!((code, out.lines().count()), (0, 1), "{talk}");
    assert!(out.contains(&jobs[0]));
    let (code, out, talk) = server.call(&["wait", "--json", "--label", "batch=2", "--machine", "fanuc-mill"]);
    let ids: Vec<Value> = out.lines().map(|l| serde_json::from_str::<Value>(l).unwrap()["job"].clone()).collect();
    assert_eq!((code, ids), (1, jobs[1..].iter().map(|job| Value::from(job.as_str())).collect()), "{talk}");
    let (code, _, talk) = server.call(&["wait", "--label", "batch=3"]);
    assert!(code == 2 && talk.contains("no job matches the filter"), "{code} {talk}");
    let (code, out, talk) = server.call(&["wait", "--all"]);
    assert_eq!((code, out.as_str()), (0, ""), "all jobs have ended: {talk}");
    let (code, _, talk) = server.call(&["wait"]);
    assert!(code == 2 && talk.contains("--all"), "{code} {talk}");
    let (code, _, talk) = server.call(&["wait", &jobs[0], "--label", "batch=1"]);
    assert!(code == 2 && talk.contains("cannot be used with"), "{code} {talk}");
}

/// The first error of a job, with its place, is in the status; a job that failed has no cycle time.
#[test]
fn the_status_of_a_failed_job_has_its_first_error() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), ServerOptions::default());
    let alarm = program(folder.path(), "alarm.nc", "O1\nG21 G90 G0 X1.\nG0 X[1/0]\nG0 X[2/0]\nM30\n");
    let job = server.submit(&alarm);
    server.call(&["wait", "--quiet", &job]);
    let (_, text, _) = server.call(&["status", "--json", &job]);
    let error = serde_json::from_str::<Value>(&text).unwrap()["first_error"].clone();
    assert_eq!((&error["file"], &error["line"], &error["channel"]), (&"alarm.nc".into(), &3.into(), &1.into()));
    assert_eq!(error["number"], 2_900_061);
    assert!(error["text"].as_str().unwrap().contains("division by zero"), "{error}");
    let (_, text, _) = server.call(&["status", &job]);
    let line = text.lines().find(|line| line.starts_with("first error")).expect(&text);
    assert!(line.contains("alarm.nc:3") && line.contains("2900061") && line.contains("division by zero"), "{line}");
    let (_, text, _) = server.call(&["wait", &job]);
    let (_, list, _) = server.call(&["jobs"]);
    let row: Vec<&str> = list.lines().nth(1).expect(&list).split_whitespace().collect();
    assert_eq!(row[6..], ["-", "fanuc-mill", "alarm.nc"], "no cycle time: {list}");
    assert!(!text.contains("cycle time"), "{text}");
    let missing = program(folder.path(), "missing.nc", "O1\nM98 P77\nM30\n");
    let job = server.submit(&missing);
    let (_, _, talk) = server.call(&["wait", &job]);
    assert!(talk.contains("missing.nc:2"), "the end names the first error: {talk}");
}

#[test]
fn an_unknown_machine_has_suggestions() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), ServerOptions::default());
    let clean = program(folder.path(), "clean.nc", CLEAN);
    let refused = |name: &str| {
        let (code, _, talk) = server.call(&["submit", "--machine", name, &clean]);
        assert_eq!(code, 2, "{talk}");
        talk
    };
    let talk = refused("fanuc-mil");
    assert!(
        talk.contains("no machine 'fanuc-mil'; similar names: 'fanuc-mill'; `counterpoint machine list`"),
        "{talk}"
    );
    let talk = refused("siemens");
    assert!(talk.contains("similar names: 'siemens-mill', 'siemens-lathe', '"), "{talk}");
    let talk = refused("nosuch");
    assert!(talk.contains("no machine 'nosuch'; `counterpoint machine list` lists the machines"), "{talk}");
}

#[test]
fn man_without_a_folder_prints_the_first_page() {
    let output = Command::new(env!("CARGO_BIN_EXE_counterpoint")).arg("man").output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success() && text.starts_with(".TH \"counterpoint\" \"1\""), "{text}");
}

/// The log is damaged, so results made from it cannot be read.
#[test]
fn a_result_that_cannot_be_read_leaves_no_file_and_the_others_are_tried() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), ServerOptions::default());
    let text = "O1\nG21 G90\n#1=0\nWHILE[#1LT3000]DO1\nG0 X#1\n#1=#1+1\nEND1\nM30\n";
    let job = server.submit(&program(folder.path(), "long.nc", text));
    server.call(&["wait", &job]);
    let of_job = std::fs::read_dir(folder.path().join("data/jobs").join(&job)).unwrap();
    for entry in of_job.map(Result::unwrap).filter(|entry| entry.file_name().to_string_lossy().starts_with("log")) {
        std::fs::File::create(entry.path()).unwrap();
    }
    let out = folder.path().join("out");
    std::fs::create_dir(&out).unwrap();
    let listing = out.join("long.lce").display().to_string();
    std::fs::write(&listing, "earlier").unwrap();
    let (code, _, talk) = server.call(&["result", &job, "listing", "-o", &listing]);
    assert!(code == 3 && talk.contains("DATA_LOSS"), "{code} {talk}");
    assert_eq!(std::fs::read_to_string(&listing).unwrap(), "earlier");
    std::fs::remove_file(&listing).unwrap();
    let (code, _, talk) = server.call(&["result", &job, "all", "-o", &out.display().to_string()]);
    assert!(code == 3 && talk.contains(&format!("'{listing}' was not written: ")), "{code} {talk}");
    assert!(talk.contains("events.jsonl' was not written: "), "the other results are tried: {talk}");
    let names: Vec<_> =
        std::fs::read_dir(&out).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    assert!(names.iter().any(|name| name == "summary.json"), "{names:?}");
    for absent in ["long.lce", "events.jsonl", "incomplete"] {
        assert!(!names.iter().any(|name| name.contains(absent)), "{names:?}");
    }
    let absent = folder.path().join("nodir/x").display().to_string();
    let (code, _, talk) = server.call(&["result", &job, "summary", "-o", &absent]);
    assert!(code == 2 && talk.contains("nodir' does not exist"), "{code} {talk}");
}

#[test]
fn a_command_that_lost_its_server_reports_that_it_tries_again() {
    for (command, quiet) in [("watch", false), ("wait", false), ("wait", true)] {
        let folder = tempfile::tempdir().unwrap();
        let server = Server::start(folder.path(), ServerOptions::default());
        let job = server.submit(&program(folder.path(), "endless.nc", ENDLESS));
        let mut command = server.command(&[command, &job]);
        command.args(quiet.then_some("--quiet"));
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(500));
        let Server { runtime, .. } = server;
        runtime.shutdown_background();
        std::thread::sleep(Duration::from_secs(3));
        child.kill().unwrap();
        let mut talk = String::new();
        child.stderr.take().unwrap().read_to_string(&mut talk).unwrap();
        child.wait().unwrap();
        let lines = talk.lines().filter(|line| line.ends_with("; trying again for up to 60 s")).count();
        assert_eq!(lines, usize::from(!quiet), "{talk}");
    }
}

#[test]
fn the_report_of_a_job_without_a_run_gives_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), ServerOptions::default());
    let clean = program(folder.path(), "clean.nc", CLEAN);
    let late = ["--deadline", "@1000", "--request-id", "late", "--no-cache"];
    let (code, job, talk) = server.call(&[&["submit", "--machine", "fanuc-mill", &clean][..], &late].concat());
    assert_eq!(code, 0, "{talk}");
    server.call(&["wait", &job]);
    let (code, _, talk) = server.call(&["result", &job, "report"]);
    assert!(code == 2 && talk.contains("NO_RESULTS"), "{code} {talk}");
    assert!(talk.contains("its deadline, 1970-01-01 00:16:40 UTC: submit it again with a later deadline"), "{talk}");
}

#[test]
fn an_empty_machine_is_refused_and_a_guess_of_the_server_is_printed() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), ServerOptions::default());
    let haas = program(folder.path(), "haas.nc", "%\nO00012\nT1 M06\nG187 P1\nM30\n%\n");
    for command in [&["submit", "--machine", ""][..], &["submit", "--each", "--machine", ""]] {
        let (code, out, talk) = server.call(&[command, &[&haas]].concat());
        let refused = talk.contains("'--machine <NAME|DIR>'") && talk.contains("is a variable unset?");
        assert!(code == 2 && out.is_empty() && refused, "{code} {talk}");
    }
    let job = server.runtime.block_on(async {
        let settings = counterpoint_client::ClientSettings::new(&server.url);
        let client = counterpoint_client::Client::connect(&settings).await.unwrap();
        let blob = counterpoint_client::Blob::new(std::fs::read(&haas).unwrap());
        client.upload(std::slice::from_ref(&blob)).await.unwrap();
        let request = counterpoint_client::v1::SubmitJobRequest {
            request_id: "guessed".into(),
            programs: vec![counterpoint_client::v1::Program { path: "haas.nc".into(), ..Default::default() }],
            files: vec![counterpoint_client::v1::FileRef { path: "haas.nc".into(), digest: blob.digest().into() }],
            ..Default::default()
        };
        client.submit(request).await.unwrap().job_id
    });
    let (code, _, talk) = server.call(&["rerun", &job]);
    assert!(code == 0 && talk.contains("machine haas-mill, guessed by the server from "), "{talk}");
}

#[test]
fn a_file_that_is_too_large_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let maxima = Maxima { max_blob_bytes: 1000, ..Maxima::default() };
    let server = Server::start(folder.path(), ServerOptions { maxima, ..ServerOptions::default() });
    let large = program(folder.path(), "large.nc", &CLEAN.repeat(100));
    let (code, _, talk) = server.call(&["submit", "--machine", "fanuc-mill", &large]);
    assert_eq!(code, 2, "{talk}");
    assert!(talk.contains("'large.nc' has 2200 bytes: the blob is larger than the limit of 1000 bytes"), "{talk}");
}
