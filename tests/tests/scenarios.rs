//! Runs every file of `scenarios/` and compares it with the result that the control must give.

use std::path::Path;

use counterpoint_kernel::options::JobOptions;
use counterpoint_tests::{Done, Work, machine, processors};
use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Scenario {
    title: String,
    machine: String,
    #[serde(default)]
    overlay: String,
    programs: Vec<String>,
    /// Further files that programs may call or start, by name.
    #[serde(default)]
    files: std::collections::BTreeMap<String, String>,
    #[serde(default)]
    options: JobOptions,
    expect: Expect,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Expect {
    state: String,
    makespan: Option<f64>,
    /// Value and tolerance, seconds.
    makespan_about: Option<(f64, f64)>,
    ends: Option<Vec<f64>>,
    states: Option<Vec<String>>,
    waits: Option<Vec<f64>>,
    meetings: Option<Vec<(String, f64)>>,
    verdict: Option<Verdict>,
    #[serde(default)]
    diagnostics: Vec<u32>,
    /// Numbers of warnings that must occur, and no others; `None` does not ask.
    warnings: Option<Vec<u32>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Verdict {
    kind: String,
    at: Option<f64>,
    waiting: Vec<(u16, u32, Vec<u16>)>,
    #[serde(default)]
    says: Vec<String>,
}

fn ns(seconds: f64) -> i64 {
    (seconds * 1e9).round() as i64
}

fn word<T: serde::Serialize>(value: &T) -> String {
    serde_json::to_value(value).unwrap().as_str().unwrap_or_default().to_owned()
}

fn check(name: &str, scenario: &Scenario, done: &Done) {
    let summary = &done.summary;
    let expect = &scenario.expect;
    let title = &scenario.title;
    let story = || format!("{name}: {title}\n{}", serde_json::to_string_pretty(summary).unwrap());
    assert_eq!(word(&summary.state), expect.state, "{}", story());
    if let Some(makespan) = expect.makespan {
        assert_eq!(summary.makespan_ns, ns(makespan), "makespan of {}", story());
    }
    if let Some((makespan, tolerance)) = expect.makespan_about {
        assert!((summary.makespan_ns - ns(makespan)).abs() <= ns(tolerance), "makespan of {}", story());
    }
    if let Some(ends) = &expect.ends {
        let found: Vec<i64> = summary.channels.iter().map(|c| c.end_ns).collect();
        assert_eq!(found, ends.iter().map(|e| ns(*e)).collect::<Vec<_>>(), "ends of {}", story());
    }
    if let Some(states) = &expect.states {
        let found: Vec<String> = summary.channels.iter().map(|c| word(&c.state)).collect();
        assert_eq!(&found, states, "states of {}", story());
    }
    if let Some(waits) = &expect.waits {
        let found: Vec<i64> = summary.channels.iter().map(|c| c.wait_ns).collect();
        assert_eq!(found, waits.iter().map(|e| ns(*e)).collect::<Vec<_>>(), "waits of {}", story());
    }
    if let Some(meetings) = &expect.meetings {
        let found: Vec<(String, i64)> =
            summary.waits.iter().filter_map(|w| Some((w.key.to_string(), w.release_ns?))).collect();
        assert_eq!(
            found,
            meetings.iter().map(|(k, t)| (k.clone(), ns(*t))).collect::<Vec<_>>(),
            "meetings of {}",
            story()
        );
    }
    let numbers: Vec<u32> = summary.diagnostics.iter().filter(|d| d.severity >= 8).map(|d| d.number).collect();
    assert_eq!(numbers, expect.diagnostics, "diagnostics of {}", story());
    if let Some(expected) = &expect.warnings {
        let warnings = summary.diagnostics.iter().filter(|d| (1..8).contains(&d.severity));
        assert_eq!(&warnings.map(|d| d.number).collect::<Vec<_>>(), expected, "warnings of {}", story());
    }
    match (&expect.verdict, &summary.verdict) {
        (None, None) => {}
        (Some(expected), Some(found)) => {
            assert_eq!(word(&found.kind), expected.kind, "verdict of {}", story());
            if let Some(at) = expected.at {
                assert_eq!(found.at_ns, ns(at), "time of the verdict of {}", story());
            }
            let members: Vec<(u16, u32, Vec<u16>)> =
                found.members.iter().map(|m| (m.channel, m.line, m.waiting_for.clone())).collect();
            assert_eq!(members, expected.waiting, "members of the verdict of {}", story());
            for part in &expected.says {
                assert!(found.text.contains(part), "'{part}' is not in the verdict of {}", story());
            }
        }
        (expected, _) => panic!("verdict expected: {}, {}", expected.is_some(), story()),
    }
}

#[test]
fn every_scenario_ends_as_the_control_would() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let mut names: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    names.sort();
    let (mut count, mut failed) = (0, Vec::new());
    for path in names.iter().filter(|p| p.extension().is_some_and(|e| e == "toml")) {
        let name = path.file_stem().unwrap().to_string_lossy();
        if std::panic::catch_unwind(|| run(&name, path)).is_err() {
            failed.push(name.into_owned());
        }
        count += 1;
    }
    assert!(failed.is_empty(), "{} of {count} scenarios end otherwise: {failed:#?}", failed.len());
    assert!(count >= 20, "only {count} scenarios were found");
}

/// Runs one scenario in all paths.
fn run(name: &str, path: &Path) {
    let scenario: Scenario =
        toml::from_str(&std::fs::read_to_string(path).unwrap()).unwrap_or_else(|e| panic!("{name}: {e}"));
    let mut work =
        Work::texts(machine(&scenario.machine, &scenario.overlay), &scenario.programs, scenario.options.clone());
    scenario.files.iter().for_each(|(name, text)| work.files.insert(name.clone(), text));
    let parallel = work.run(None).unwrap();
    check(name, &scenario, &parallel);
    work.options.threads = 1;
    let sequential = work.run(None).unwrap();
    let (results, ..) = work.results(None).unwrap();
    assert_eq!(results.summary, sequential.summary, "{name}: results without a log");
    assert_eq!(
        parallel.summary.log_digest, sequential.summary.log_digest,
        "{name}: parallel and sequential logs differ"
    );
}

/// The judgement without a run holds in the run: programs without a mistake reach their end or an alarm that has
/// nothing to do with waits, and programs with a mistake do not.
#[test]
fn the_judgement_without_a_run_is_true() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let mut names: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    names.sort();
    let (mut clean, mut wrong, mut open) = (0, 0, 0);
    let mut failed = Vec::new();
    for path in names.iter().filter(|p| p.extension().is_some_and(|e| e == "toml")) {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let scenario: Scenario = toml::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        let mut work =
            Work::texts(machine(&scenario.machine, &scenario.overlay), &scenario.programs, scenario.options.clone());
        scenario.files.iter().for_each(|(name, text)| work.files.insert(name.clone(), text));
        work.options.lint = true;
        let judged = work.run(None).unwrap().summary;
        let says = |number| judged.diagnostics.iter().any(|diagnostic| diagnostic.number == number);
        let state = word(&judged.state);
        // Waits of the control that never end: the rest are variables, races and limits.
        let verdict = scenario.expect.verdict.as_ref().map(|verdict| verdict.kind.as_str());
        let hangs = verdict.is_some_and(|kind| !matches!(kind, "PARTNER_SPINNING" | "LIMIT" | "PARTNER_ALARMED"));
        if says(2_900_441) || says(2_900_444) {
            open += 1;
        } else if state == "SUCCEEDED" {
            clean += 1;
            if hangs {
                failed.push(format!("{name}: nothing found, but {verdict:?}"));
            }
        } else {
            wrong += 1;
            if scenario.expect.state == "SUCCEEDED" {
                failed.push(format!("{name}: {:?} {:?}", judged.verdict, judged.diagnostics));
            }
        }
    }
    println!("{clean} without a mistake, {wrong} with one, {open} open");
    assert!(failed.is_empty(), "{failed:#?}");
    assert!(clean >= 20 && wrong >= 10 && open >= 5, "{clean} {wrong} {open}");
}

/// One processor, two, free and beside busy threads, with few threads and many.
#[test]
fn everywhere() {
    processors::everywhere(&processors::FEW_SETTINGS, "everywhere", &[]);
}
