//! The unit in which the coordinates of a program are read.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)]

use std::process::Command;

use serde_json::Value;

/// Report and status lines of a run of a program.
fn run(text: &str, options: &[&str]) -> (String, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("part.nc");
    std::fs::write(&path, text).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_counterpoint"))
        .args(["run", "--no-timeline", path.to_str().unwrap()])
        .args(options)
        .output()
        .unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (text(&output.stdout), text(&output.stderr))
}

/// The line of the report below the cycle time.
fn line(text: &str, options: &[&str]) -> String {
    let (out, err) = run(text, options);
    out.lines().nth(1).unwrap_or_else(|| panic!("{out}{err}")).to_owned()
}

const MOVES: &str = "G0 X1. Y1. Z2.\nG1 Z1. F10.\nM30\n";

#[test]
fn the_report_names_the_unit_of_the_coordinates() {
    let mill = &["--machine", "fanuc-mill"];
    let unnamed = "no G20/G21: coordinates read in mm, the unit in which machine fanuc-mill begins";
    assert_eq!(line(&format!("O1\n{MOVES}"), mill), unnamed);
    assert_eq!(line(&format!("O1\nG21\n{MOVES}"), mill), "coordinates read in mm");
    assert_eq!(line(&format!("O1\nG21 {MOVES}"), mill), "coordinates read in mm");
    assert_eq!(line(&format!("O1\nG20\n{MOVES}"), mill), "coordinates read in inch");
    let changed = format!("O1\nG21\nG1 X1. F9.\nG20\n{MOVES}");
    assert_eq!(line(&changed, mill), "coordinates read in mm, from line 4 in inch");
    let late = format!("O1\nG1 X1. F9.\nG20\n{MOVES}");
    let late = line(&late, mill);
    assert_eq!(late, "coordinates read in mm, the unit in which machine fanuc-mill begins, from line 3 in inch");
    // Moves of a tool change have no coordinates of the program.
    assert_eq!(line(&format!("O1\nT1 M6\nG20\n{MOVES}"), mill), "coordinates read in inch");
    // A system variable selects a unit as a code does.
    let variable = line("O1\nG20\nG1 X1. F9.\n#3005=0\nG1 X30.\nM30\n", mill);
    assert_eq!(variable, "coordinates read in inch, from line 4 in mm");
    let siemens = line(MOVES, &["--machine", "siemens-mill"]);
    let begins = "no G70/G71/G700/G710: coordinates read in mm, the unit in which machine siemens-mill begins";
    assert_eq!(siemens, begins);
    assert_eq!(line(&format!("G700\n{MOVES}"), &["--machine", "siemens-mill"]), "coordinates read in inch");
    let conversational = "0 BEGIN PGM A INCH\n1 L X+1 Y+1 R0 F100\n2 END PGM A INCH\n";
    assert_eq!(line(conversational, &["--machine", "heidenhain-mill"]), "coordinates read in inch");
    let metric = conversational.replace("INCH", "MM");
    assert_eq!(line(&metric, &["--machine", "heidenhain-mill"]), "coordinates read in mm");
    let okuma = "coordinates read in mm, the unit in which machine okuma-mill begins";
    assert_eq!(line("G0 X1. Y1.\nM02\n", &["--machine", "okuma-mill"]), okuma);
}

#[test]
fn the_summary_has_the_units_of_each_channel() {
    let options = ["--json", "--machine", "fanuc-mill"];
    let (out, _) = run(&format!("O1\nG21\nG1 X1. F9.\nG20\n{MOVES}"), &options);
    let summary: Value = serde_json::from_str(&out).unwrap();
    let channels = serde_json::json!([{ "channel": 1, "selected": true, "units": [
        { "unit": "mm", "file": "", "line": 0 }, { "unit": "inch", "file": "part.nc", "line": 4 }
    ] }]);
    assert_eq!(summary["coordinates"]["channels"], channels);
}

#[test]
fn a_run_can_begin_in_the_other_unit() {
    let program = format!("O1\n{MOVES}");
    let inch = line(&program, &["--machine", "fanuc-mill", "--set", "units=inch"]);
    let begins = "no G20/G21: coordinates read in inch, the unit in which machine fanuc-mill-set-inch begins";
    assert_eq!(inch, begins);
    let (out, _) = run("O1\nG0 X1. Y1.\nG1 X2. F10.\nM30\n", &["--json", "--machine", "fanuc-mill"]);
    let mm: Value = serde_json::from_str(&out).unwrap();
    let options = ["--json", "--machine", "fanuc-mill", "--set", "units=inch"];
    let (out, _) = run("O1\nG0 X1. Y1.\nG1 X2. F10.\nM30\n", &options);
    let inch: Value = serde_json::from_str(&out).unwrap();
    // 1 mm at 10 mm/min and 1 inch at 10 inch/min take 6 s.
    for summary in [&mm, &inch] {
        assert_eq!(summary["channels"][0]["feed_ns"].as_i64().unwrap() / 1_000_000, 6_000);
    }
    let okuma = run("G0 X1.\nM02\n", &["--machine", "okuma-mill", "--set", "units=inch"]);
    assert!(okuma.1.contains("machine 'okuma-mill' has no codes for both units"), "{}", okuma.1);
}

#[test]
fn the_guess_of_a_machine_names_the_unit_if_the_program_does_not() {
    let named = run(&format!("%\nO1\nG21\nT1 M6\nS900 M3\nG90 G54\n{MOVES}"), &[]).1;
    assert!(named.contains("machine fanuc-mill, guessed from") && !named.contains("begins in"), "{named}");
    let program = format!("%\nO1\nT1 M6\nS900 M3\nG90 G54\n{MOVES}");
    let unnamed = run(&program, &[]).1;
    assert!(unnamed.contains("use --machine to choose another; no G20/G21: begins in mm"), "{unnamed}");
    let set = run(&program, &["--set", "units=inch"]).1;
    assert!(set.contains("no G20/G21: begins in inch"), "{set}");
}
