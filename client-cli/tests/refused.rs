//! Commands for jobs on a server that are refused, or whose result is not the expected one.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)]

mod served;

use std::process::Command;

use counterpoint_server::options::ServerOptions;
use served::{Server, program};

const CLEAN: &str = "O1\nG21 G90 G0 X1.\nM30\n";

/// An empty value usually comes from an unset variable. Without its condition a filter would select the jobs of others.
#[test]
fn an_empty_value_of_an_option_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), ServerOptions::default());
    let clean = program(folder.path(), "clean.nc", CLEAN);
    let (_, job, _) = server.call(&["submit", "--machine", "fanuc-mill", "--label", "order=1", &clean]);
    assert_eq!(server.call(&["wait", "--quiet", &job]).0, 0);
    for (option, command) in [
        ("--machine", &["delete", "--label", "order=1", "--yes", "--machine", ""][..]),
        ("--machine", &["cancel", "--machine", "", "--yes"]),
        ("--machine", &["jobs", "--machine", ""]),
        ("--machine", &["wait", "--machine", ""]),
        ("--machine", &["watch", "--all", "--machine="]),
        ("--label", &["jobs", "--label", ""]),
        ("--request-id", &["submit", "--request-id", "", &clean]),
        ("--request-id", &["rerun", &job, "--request-id", ""]),
        ("--filter", &["machine", "show", "fanuc-mill", "codes", "--filter", ""]),
    ] {
        let (code, out, talk) = server.call(command);
        let named = talk.contains(&format!("'{option} <")) && talk.contains("is a variable unset?");
        assert!(code == 2 && out.is_empty() && named, "{command:?}: {code} {talk}");
    }
    for command in [&["jobs", "--state", ""][..], &["jobs", "--since", ""], &["delete", "", "--yes"]] {
        assert_eq!(server.call(command).0, 2, "{command:?}");
    }
    assert_eq!(server.call(&["jobs"]).1.lines().count(), 2, "the job is still there");
}

#[test]
fn a_job_with_more_programs_than_channels_is_refused_at_submit_and_reported_once() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), ServerOptions::default());
    let names = ["a.nc", "b.nc", "c.nc"].map(|name| program(folder.path(), name, CLEAN));
    let three = [&names[0], &names[1], &names[2]];
    let (code, out, talk) = server.call(&["submit", "--machine", "fanuc-2path-lathe", three[0], three[1], three[2]]);
    assert_eq!((code, out.as_str()), (2, ""), "{talk}");
    assert!(talk.contains("fanuc-2path-lathe has 2 channels, but the job has 3 programs"), "{talk}");
    assert_eq!(server.call(&["jobs", "--json"]).1, "", "nothing was submitted");
    // A client that does not know the machine.
    let job = server.runtime.block_on(async {
        let settings = counterpoint_client::ClientSettings::new(&server.url);
        let client = counterpoint_client::Client::connect(&settings).await.unwrap();
        let blob = counterpoint_client::Blob::new(CLEAN.as_bytes().to_vec());
        client.upload(std::slice::from_ref(&blob)).await.unwrap();
        let paths = ["a.nc", "b.nc", "c.nc"].map(str::to_owned);
        let file =
            |path: &String| counterpoint_client::v1::FileRef { path: path.clone(), digest: blob.digest().into() };
        let program = |path: &String| counterpoint_client::v1::Program { path: path.clone(), ..Default::default() };
        let request = counterpoint_client::v1::SubmitJobRequest {
            request_id: "three".into(),
            machine: "fanuc-2path-lathe".into(),
            programs: paths.iter().map(program).collect(),
            files: paths.iter().map(file).collect(),
            ..Default::default()
        };
        client.submit(request).await.unwrap().job_id
    });
    let (code, out, ended) = server.call(&["wait", &job]);
    assert!(code != 0 && out.is_empty(), "{ended}");
    assert_eq!(ended.matches("but the job has more programs").count(), 1, "the reason is printed once: {ended}");
}

#[test]
fn the_trace_of_a_job_without_one_is_said_to_be_the_listing() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), ServerOptions::default());
    let clean = program(folder.path(), "clean.nc", CLEAN);
    for (trace, noted) in [(&[][..], true), (&["--trace"], false)] {
        let (_, job, _) = server.call(&[&["submit", "--machine", "fanuc-mill", &clean][..], trace].concat());
        assert_eq!(server.call(&["wait", "--quiet", &job]).0, 0);
        let (code, out, talk) = server.call(&["result", &job, "trace"]);
        assert!(code == 0 && out.contains("M30"), "{out}");
        assert_eq!(talk.contains("submitted without --trace: this is the listing"), noted, "{talk}");
    }
}

#[test]
fn a_command_of_other_programs_suggests_the_one_that_does_the_work_here() {
    for (word, command) in [("check", "lint"), ("diff", "machine diff"), ("optimise", "analyse")] {
        let output = Command::new(env!("CARGO_BIN_EXE_counterpoint")).args([word, "part.nc"]).output().unwrap();
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.contains(&format!("'{command}'")), "{word}: {text}");
    }
}
