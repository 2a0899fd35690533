//! The content of `deploy/`, checked by the tools that will read it. A test without its tool is skipped with a message.

#![allow(missing_docs, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stderr)]

use std::path::{Path, PathBuf};
use std::process::Command;

fn deploy(path: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../deploy").join(path)
}

/// Output of a tool that must succeed; none if it is absent.
fn output(tool: &str, arguments: &[&str], file: &Path) -> Option<String> {
    let output = match Command::new(tool).args(arguments).arg(file).output() {
        Ok(output) => output,
        Err(error) => {
            eprintln!("skipped: {tool} cannot be run: {error}");
            return None;
        }
    };
    let text = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
    assert!(output.status.success(), "{tool} {arguments:?}: {text}");
    Some(text)
}

/// `COUNTERPOINT_PROMTOOL` names the tool where it is not installed.
#[test]
fn the_rules_pass_the_checks_of_prometheus_and_each_alert_fires_in_time() {
    let tool = std::env::var("COUNTERPOINT_PROMTOOL").unwrap_or_else(|_| "promtool".to_owned());
    let checked = output(&tool, &["check", "rules"], &deploy("prometheus/rules.yaml"));
    assert!(checked.is_none_or(|text| text.contains("SUCCESS")));
    let tested = output(&tool, &["test", "rules"], &deploy("prometheus/tests.yaml"));
    assert!(tested.is_none_or(|text| text.contains("SUCCESS") && !text.contains("FAILED")));
}

/// `COUNTERPOINT_HELM` names the tool where it is not installed.
#[test]
fn helm_accepts_the_chart_and_renders_it_with_and_without_the_monitor() {
    let tool = std::env::var("COUNTERPOINT_HELM").unwrap_or_else(|_| "helm".to_owned());
    let chart = deploy("helm/counterpoint");
    let image = ["--set", "image.repository=registry.example/counterpoint"];
    let linted = output(&tool, &[&["lint", "--strict"][..], &image].concat(), &chart);
    assert!(linted.is_none_or(|text| text.contains("0 chart(s) failed")));
    let monitor = ["--set", "metrics.serviceMonitor=true", "--api-versions", "monitoring.coreos.com/v1"];
    for (more, kinds) in [
        (&[][..], &["ConfigMap", "Service", "Service", "StatefulSet"][..]),
        (&monitor[..], &["ConfigMap", "Service", "Service", "ServiceMonitor", "StatefulSet"][..]),
    ] {
        let Some(text) = output(&tool, &[&["template", "counterpoint"][..], &image, more].concat(), &chart) else {
            return;
        };
        let mut rendered: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("kind: ")).collect();
        rendered.sort_unstable();
        assert_eq!(rendered, kinds, "{text}");
    }
}

/// systemd accepts each line of the unit, and rates its exposure (0 to 10) at 2.5 or less.
#[cfg(target_os = "linux")]
#[test]
fn the_unit_passes_the_checks_of_systemd_and_exposes_little() {
    let folder = tempfile::tempdir().unwrap();
    let unit = folder.path().join("counterpointd.service");
    let text = std::fs::read_to_string(deploy("counterpointd.service")).unwrap();
    // The program must be there to be verified.
    std::fs::write(&unit, text.replace("/usr/local/bin/counterpointd", env!("CARGO_BIN_EXE_counterpointd"))).unwrap();
    if let Some(remarks) = output("systemd-analyze", &["verify"], &unit) {
        assert!(!remarks.contains("counterpointd.service"), "{remarks}");
        output("systemd-analyze", &["security", "--offline=true", "--threshold=25"], &unit);
    }
}
