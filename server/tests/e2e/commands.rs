//! Commands of the operating system, started by the macros of real machines.

use std::path::Path;

use counterpoint_proto::v1;
use counterpoint_server::access::Role;
use counterpoint_server::options::{ServerOptions, System};
use counterpoint_server::runner::KernelRunner;
use counterpoint_server::service;
use tonic::Status;
use tonic::transport::Endpoint;

use crate::guarded::*;
use crate::support::*;

/// "operating system command not allowed"
const INHIBITED: u32 = 1_118_001;

/// Puts a machine whose macro makes a file when a program starts.
async fn put(caller: &As, name: &str, made: &Path) -> Result<(), Status> {
    let machine =
        format!("extends = \"fanuc-mill\"\n[ce]\nname = \"{name}\"\n[macros]\nprogram_startup = \"start.mac\"\n");
    let files = [("machine.toml", machine), ("start.mac", format!("SYSTEM/'touch \"{}\"'\n", made.display()))];
    let mut listed = Vec::new();
    for (file, text) in files {
        let digest = caller.upload(text.as_bytes()).await?;
        listed.push(v1::MachineFile { path: format!("{name}/{file}"), digest });
    }
    let request = v1::PutMachineRequest { name: name.into(), files: listed };
    caller.machines().put_machine(request).await.map(drop)
}

/// Runs a job; returns its state, and whether a diagnostic says that commands are not allowed.
async fn run(caller: &As, request_id: &str, machine: &str) -> (v1::JobState, bool) {
    let job = caller.submit(request_id, machine, "M30\n").await.unwrap().job_id;
    let state = caller.wait(&job).await.state();
    let mut summary = caller.results().get_summary(v1::GetSummaryRequest { job_id: job }).await.unwrap().into_inner();
    let mut text = Vec::new();
    while let Some(part) = summary.message().await.unwrap() {
        text.extend(part.data);
    }
    let summary: serde_json::Value = serde_json::from_slice(&text).unwrap();
    let diagnostics = summary["diagnostics"].as_array().unwrap();
    (state, diagnostics.iter().any(|diagnostic| diagnostic["number"] == INHIBITED))
}

/// The command of a submitter's machine never runs; that of an administrator's machine runs, also for the job of a
/// submitter, if the server allows commands.
#[tokio::test]
async fn a_command_runs_only_if_an_administrator_has_put_its_machine_and_the_server_allows_it() {
    for allow_system in [false, true] {
        let folder = tempfile::tempdir().unwrap();
        let options = ServerOptions { system: System { allow_system, ..System::default() }, ..guarded(folder.path()) };
        let (submit, admin) = (grant(&options, "s", "t", Role::Submit), grant(&options, "a", "t", Role::Admin));
        let service = service::build_with(options, KernelRunner::default()).await.unwrap();
        let handle = service.handle();
        let task = tokio::spawn(async { service.run(std::future::pending()).await.unwrap() });
        let connection = Endpoint::from_shared(handle.url()).unwrap().connect().await.unwrap();
        let [submit, admin] =
            [submit, admin].map(|token| As { connection: connection.clone(), bearer: Bearer(Some(token)) });
        let made = |name: &str| folder.path().join(format!("made-by-{name}"));
        put(&submit, "theirs", &made("theirs")).await.unwrap();
        put(&admin, "trusted", &made("trusted")).await.unwrap();
        let refused = put(&submit, "trusted", &made("replaced")).await.unwrap_err();
        assert_eq!(reason(&refused), "PERMISSION_DENIED");
        for (who, caller, machine, allowed) in [
            ("submitter", &submit, "theirs", false),
            ("administrator", &admin, "theirs", false),
            ("submitter", &submit, "trusted", allow_system),
        ] {
            let expected = if allowed { v1::JobState::Succeeded } else { v1::JobState::Failed };
            let request_id = format!("{who}-{machine}");
            assert_eq!(run(caller, &request_id, machine).await, (expected, !allowed), "{request_id} {allow_system}");
            assert_eq!(made(machine).exists(), allowed, "{request_id} {allow_system}");
        }
        assert!(!made("replaced").exists());
        handle.stop();
        task.await.unwrap();
    }
}
