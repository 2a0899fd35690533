//! `counterpoint load` against a server.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)]

use std::path::Path;
use std::process::{Command, Output, Stdio};

use counterpoint_server::options::ServerOptions;
use counterpoint_server::service;
use serde_json::Value;

const STANDARD: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/load/standard.toml");

fn load(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_counterpoint"));
    command.arg("load").args(arguments).env_remove("COUNTERPOINT_SERVER").stdin(Stdio::null()).output().unwrap()
}

/// A server with its runtime, and its address.
fn server(folder: &Path, queue: usize) -> (tokio::runtime::Runtime, String) {
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build().unwrap();
    let listen = "127.0.0.1:0".parse().unwrap();
    let options = ServerOptions { listen, data: folder.join("data"), queue, workers: 1, ..ServerOptions::default() };
    let service = runtime.block_on(service::build(options)).unwrap();
    let url = service.handle().url();
    runtime.spawn(service.run(std::future::pending()));
    (runtime, url)
}

fn report(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

#[test]
fn the_standard_mix_runs_without_errors_and_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let (_runtime, url) = server(folder.path(), 1000);
    let (json, html) = (folder.path().join("load.json"), folder.path().join("load.html"));
    let files = ["--json", json.to_str().unwrap(), "--html", html.to_str().unwrap()];
    // One round of the mix: every kind comes up.
    let count = ["--callers", "2", "--jobs", "21", "--for", "5m", "--warm-up", "0s", "--max-errors", "0", "--delete"];
    let output = load(&[&["--mix", STANDARD, "--server", &url][..], &count, &files].concat());
    let (out, talk) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert_eq!(output.status.code(), Some(0), "{out}{talk}");
    assert!(out.contains("no errors") && talk.contains("kept errors"), "{out}{talk}");
    let report = report(&json);
    assert_eq!(report["jobs"], serde_json::json!({"tiny": 12, "part": 6, "twin": 2, "long": 1}), "{report}");
    assert_eq!(report["errors"], serde_json::json!({}));
    let times = &report["times_ms"];
    for (stretch, count) in [("submit", 21), ("queue", 21), ("end", 21), ("first_event", 20)] {
        assert_eq!(times[stretch]["count"], count, "{stretch}: the long job is followed by progress only");
        let [p50, p99, max] = ["p50", "p99", "max"].map(|share| times[stretch][share].as_f64().unwrap());
        assert!(p50 <= p99 && p99 <= max, "{stretch} {p50} {p99} {max}");
    }
    assert!(times["submit"]["max"].as_f64() <= times["end"]["max"].as_f64());
    assert!(report["events_per_s"].as_f64().unwrap() > 0.0);
    let page = std::fs::read_to_string(&html).unwrap();
    assert!(page.matches("<svg").count() >= 5 && page.contains("first event"), "{page}");
    for foreign in ["<script", "src=", "href=", "@import", "url("] {
        assert!(!page.contains(foreign), "{foreign}");
    }
}

#[test]
fn a_rate_beyond_the_queue_is_counted_by_reason_and_a_missed_threshold_is_the_exit_code() {
    let folder = tempfile::tempdir().unwrap();
    let (_runtime, url) = server(folder.path(), 1);
    let mix = folder.path().join("mix.toml");
    let made = "{ name = \"a.nc\", head = \"O1\\n\", lines = \"G4 P1\\n\", times = 20000, foot = \"M30\\n\" }";
    let text = format!("[[job]]\nname = \"slow\"\nmachine = \"fanuc-mill\"\nmade = [{made}]\n");
    std::fs::write(&mix, text).unwrap();
    let json = folder.path().join("load.json");
    let pace = ["--rate", "500", "--for", "5m", "--jobs", "100", "--warm-up", "0s", "--max-errors", "1"];
    let to = ["--mix", mix.to_str().unwrap(), "--server", &url, "--json", json.to_str().unwrap()];
    let output = load(&[&to[..], &pace].concat());
    assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stderr));
    let report = report(&json);
    let refused = report["errors"]["QUEUE_FULL"].as_u64().unwrap();
    assert_eq!(refused + report["jobs"]["slow"].as_u64().unwrap(), 100, "every job that was due is accounted for");
    assert_eq!(report["thresholds"][0]["kept"], false);
}

#[test]
fn only_this_machine_gets_load_unless_another_is_asked_for() {
    let output = load(&["--mix", STANDARD, "--callers", "1", "--server", "http://192.0.2.1:7878"]);
    let talk = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{talk}");
    assert!(talk.contains("--allow-remote"), "{talk}");
    let output = load(&["--mix", STANDARD, "--server", "http://127.0.0.1:1"]);
    assert_eq!(output.status.code(), Some(2), "a pace is needed");
}

#[test]
fn a_refusal_that_cannot_heal_ends_the_load() {
    let folder = tempfile::tempdir().unwrap();
    let (_runtime, url) = server(folder.path(), 100);
    let mix = folder.path().join("mix.toml");
    let made = "{ name = \"a.nc\", head = \"O1\\n\", lines = \"G4 P1\\n\", times = 2, foot = \"M30\\n\" }";
    std::fs::write(&mix, format!("[[job]]\nname = \"one\"\nmachine = \"no-such-machine\"\nmade = [{made}]\n")).unwrap();
    let begin = std::time::Instant::now();
    for pace in [["--callers", "2"], ["--rate", "5"]] {
        let to = ["--mix", mix.to_str().unwrap(), "--server", &url, "--for", "5m", "--quiet"];
        let output = load(&[&to[..], &pace].concat());
        let talk = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{talk}");
        assert!(talk.contains("no-such-machine") && talk.contains("UNKNOWN_MACHINE"), "{talk}");
    }
    assert!(begin.elapsed().as_secs() < 60);
}
