//! The command line as a user sees it: exit codes, standard output, files.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)]

use std::path::Path;
use std::process::{Command, Output, Stdio};

use counterpoint_server::access::Role;
use counterpoint_server::options::{Guard, ServerOptions};
use counterpoint_server::service;

fn counterpoint(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_counterpoint"));
    command.args(arguments).env_remove("COUNTERPOINT_SERVER").stdin(Stdio::null()).output().unwrap()
}

fn code(output: &Output) -> i32 {
    output.status.code().unwrap()
}

fn program(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path.display().to_string()
}

#[test]
fn a_clean_program_gives_a_report_on_standard_output() {
    let folder = tempfile::tempdir().unwrap();
    let path = program(folder.path(), "part.nc", "%\nO1000\nG90 G0 X10. Y5.\nG1 X20. F100.\nM30\n%\n");
    let output = counterpoint(&["run", &path]);
    let (out, status) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert_eq!(code(&output), 0, "{out}{status}");
    assert!(out.starts_with("SUCCEEDED") && out.contains("part.nc"), "{out}");
    assert!(status.contains("fanuc-mill"), "the default machine is named: {status}");
    let output = counterpoint(&["run", "--quiet", &path]);
    assert!(output.stdout.is_empty() && output.stderr.is_empty());
}

#[test]
fn a_quiet_command_prints_the_errors_only() {
    let folder = tempfile::tempdir().unwrap();
    let failing = program(folder.path(), "part.nc", "G21 G90 G0 X10.\nG1 X20. F100.\nG1 X#9 Y[1/0]\nM30\n");
    let warned = program(folder.path(), "warned.nc", "G21 G90 G0 X10.\nG1 X20. F100.\nM30\n");
    let run = |arguments: &[&str]| {
        let output = counterpoint(&[arguments, &["--machine", "fanuc-mill", "--quiet"]].concat());
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.stdout.is_empty(), "data");
        (code(&output), text)
    };
    let (code, text) = run(&["run", &failing]);
    assert_eq!(code, 1, "{text}");
    assert!(text.contains("part.nc:3: ") && text.contains("remedy: ") && !text.contains("warning"), "{text}");
    assert_eq!(run(&["run", &warned]), (0, String::new()));
    let (code, text) = run(&["run", &warned, "--strict"]);
    assert!(code == 1 && text.contains("warning 2900681 warned.nc:2: "), "{code} {text}");
    let waiting = program(folder.path(), "waiting.nc", "M101 P12\nM30\n");
    let other = program(folder.path(), "other.nc", "M30\n");
    let output = counterpoint(&["lint", &waiting, &other, "--machine", "fanuc-2path-lathe", "--quiet"]);
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(1) && text.contains("waiting.nc line 1"), "{text}");
}

#[test]
fn all_results_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let upper = program(folder.path(), "upper.nc", "O1\nG0 X10. Z5.\nM101 P12\nG1 Z1. F.1\nM30\n");
    let lower = program(folder.path(), "lower.nc", "O2\nG0 X10. Z5.\nM101 P12\nM30\n");
    let out = folder.path().join("out");
    let output = counterpoint(&["run", &upper, &lower, "--json", "--out", &out.display().to_string()]);
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(summary["channels"].as_array().unwrap().len(), 2, "{summary}");
    let mut names: Vec<_> =
        std::fs::read_dir(&out).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    let expected = "events.jsonl summary.json timeline.json timeline.svg toolpath.json toolpath.svg";
    let expected: Vec<_> = expected.split(' ').chain(["upper.1.lce", "upper.2.lce", "upper.lce"]).collect();
    assert_eq!(names, expected);
    let merged = std::fs::read_to_string(out.join("upper.lce")).unwrap();
    assert!(merged.contains("\nK2 t=000:00.000 1! O2\n") && merged.contains("\nKERNEL 2 LOWER\n"), "{merged}");
}

#[test]
fn a_section_of_a_file_is_named_and_its_errors_name_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = program(folder.path(), "part.nc", "$1\nG4 P100\nM30\n$2\nG4 P200\nG4 P10 Q5\nM30\n");
    let output = counterpoint(&["run", "--machine", "citizen-3system", &format!("{path}#$2")]);
    let (out, status) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert_eq!(code(&output), 1, "{out}{status}");
    assert!(out.contains("part.nc#$2:6") && !out.contains("part.nc#$1"), "{out}");
    let output = counterpoint(&["run", "--machine", "citizen-3system", &format!("{path}#$5")]);
    let status = String::from_utf8_lossy(&output.stderr);
    assert!(code(&output) != 0 && status.contains("program or section $5 not found"), "{status}");
}

#[test]
fn waits_are_judged_without_a_run() {
    let folder = tempfile::tempdir().unwrap();
    let upper = program(folder.path(), "upper.nc", "O1\nM101\nM98 P20 L2\nM103\nM30\nO20\nM102\nM99\n");
    let lower = program(folder.path(), "lower.nc", "O2\nM101\nM102\nM103\nM30\n");
    let right = program(folder.path(), "right.nc", "O2\nM101\nM102\nM102\nM103\nM30\n");
    let part = program(folder.path(), "part.nc", "O2\nM101\nIF [#500 EQ 1] GOTO 10\nM102\nN10 M102\nM103\nM30\n");
    let lint = |more: &[&str]| {
        let output = counterpoint(&[&["lint", "--machine", "fanuc-2path-lathe", &upper], more].concat());
        (code(&output), String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let (status, text) = lint(&[&lower]);
    assert_eq!(status, 1, "{text}");
    assert!(text.contains("cannot run like this") && text.contains("'M102': different codes without P; "), "{text}");
    assert!(text.contains("channel 1 has 'M103' in line 4; channel 2 has 'M102' earlier, in line 3"), "{text}");
    let (status, text) = lint(&[&right, "--strict"]);
    assert_eq!(status, 0, "{text}");
    assert!(text.starts_with("no mistake found\n") && text.contains("M102        1: 2, 2: 2"), "{text}");
    let (status, text) = lint(&[&part]);
    assert_eq!(status, 0, "{text}");
    assert!(text.contains("as far as the programs could be judged") && text.contains("to line 3"), "{text}");
    assert_eq!(lint(&[&part, "--strict"]).0, 1);
    let (status, json) = lint(&[&lower, "--json"]);
    let summary: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!((status, summary["state"].as_str()), (1, Some("FAILED")));
    assert_eq!(lint(&["missing.nc"]).0, 2);
}

/// The upper turret dwells 2 s, waits for the lower one (5 s), and dwells 4 s more.
#[test]
fn what_decides_the_cycle_time_is_analysed() {
    let folder = tempfile::tempdir().unwrap();
    let upper = program(folder.path(), "upper.nc", "O1\nG4 P2000\nM101 P12\nG4 P4000\nM30\n");
    let lower = program(folder.path(), "lower.nc", "O2\nG4 P5000\nM101 P12\nM30\n");
    let out = folder.path().join("out").display().to_string();
    assert_eq!(code(&counterpoint(&["run", "-q", "--machine", "fanuc-2path-lathe", &upper, &lower, "--out", &out])), 0);
    let output = counterpoint(&["analyse", &out, "--what-if", "2:-1s", "--what-if", "1:-1s", "--json"]);
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let cost = &found["analysis"]["wait_cost"][0];
    assert_eq!(
        (cost[0].as_str(), cost[1].as_i64().map(|ns| ns / 100_000_000)),
        (Some("M101 P12"), Some(30)),
        "{found}"
    );
    let path: Vec<_> = found["analysis"]["critical"].as_array().unwrap().iter().map(|part| part[0].as_i64()).collect();
    assert_eq!(path, [Some(2), Some(1)], "{found}");
    let saves = |at: usize| found["what_if"][at]["saves_ns"].as_i64().unwrap() as f64 / 1e9;
    assert!((saves(0) - 1.0).abs() < 0.05 && (saves(1) - 2.0 / 3.0).abs() < 0.05, "{found}");
    let text = counterpoint(&["analyse", &format!("{out}/summary.json")]);
    let text = String::from_utf8_lossy(&text.stdout);
    assert!(text.contains("critical path") && text.contains("2 LOWER") && text.contains("M101 P12"), "{text}");
    let wrong = counterpoint(&["analyse", &upper]);
    let text = String::from_utf8_lossy(&wrong.stderr);
    assert!(code(&wrong) == 2 && text.contains("upper.nc' is not the summary of a job"), "{text}");
    let wrong = counterpoint(&["analyse", &out, "--what-if", "2:-1h"]);
    assert!(code(&wrong) == 2 && String::from_utf8_lossy(&wrong.stderr).contains("write 2:-2.5s"));
    let wrong = counterpoint(&["analyse", &out, "--what-if", "3:1s"]);
    assert!(code(&wrong) == 2 && String::from_utf8_lossy(&wrong.stderr).contains("(channels: 1, 2)"));
}

/// 100 mm at 100 mm/s and 1000 mm/s²: the rapid takes 1.1 s and has covered half of its length after 0.55 s. Then the
/// upper turret waits for the lower turret, which dwells for 5 s.
#[test]
fn an_instant_and_the_times_of_a_block_are_shown() {
    let folder = tempfile::tempdir().unwrap();
    let upper = program(folder.path(), "upper.nc", "O1\nG28 W0\nG0 Z400.\nM101 P12\nM30\n");
    let lower = program(folder.path(), "lower.nc", "O2\nG4 P5000\nM101 P12\nM30\n");
    let machine = "extends = \"fanuc-2path-lathe\"\n[ce]\nname = \"mine\"\n[[axes]]\nname = \"Z1\"\nrapid = 6000\n\
                   home = 500\nacceleration = 1000\n";
    let mine = folder.path().join("mine");
    std::fs::create_dir(&mine).unwrap();
    program(&mine, "machine.toml", machine);
    let out = folder.path().join("out").display().to_string();
    let mine = mine.display().to_string();
    let run = |more: &[&str]| {
        let output =
            counterpoint(&[&["run", "-q", "--machine", &mine, &upper, &lower, "--out", &out][..], more].concat());
        assert_eq!(code(&output), 0, "{}", String::from_utf8_lossy(&output.stderr));
    };
    let ask = |arguments: &[&str]| {
        let output = counterpoint(arguments);
        let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
        (code(&output), text)
    };
    run(&["--law"]);
    let (_, json) = ask(&["where", &out, "upper.nc:3", "--json"]);
    let found: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(found[0]["dur_ns"].as_i64(), Some(1_100_000_000), "{found}");
    let start = found[0]["t_ns"].as_i64().unwrap();
    let middle = format!("{}ms", (start + 550_000_000) / 1_000_000);
    let (_, json) = ask(&["at", &out, &middle, "--json"]);
    let found: serde_json::Value = serde_json::from_str(&json).unwrap();
    let z = found["channels"][0]["position"]["Z"].as_f64().unwrap();
    let [from, to] = [0, 1].map(|end| found["channels"][0]["action"]["ends"][end]["Z"].as_f64().unwrap());
    assert!((z - f64::midpoint(from, to)).abs() < 1e-9 && (to - from).abs() > 99.0, "{found}");
    let (status, text) = ask(&["at", &out, "2", "--channel", "1"]);
    assert!(status == 0 && text.contains("M101 P12") && text.contains("channel 2"), "{text}");
    assert!(!text.contains("LOWER"), "{text}");
    assert_eq!(ask(&["where", &out, "upper.nc:99"]).0, 1);
    let (status, text) = ask(&["where", &out, "./upper.nc:4"]);
    assert!(status == 0 && text.contains("executed 1 time"), "{text}");
    let (status, text) = ask(&["run", "-q", "--machine", &mine, &upper, &lower, "--law"]);
    assert!(status == 2 && text.contains("--out DIR"), "{text}");
    for (wrong, hint) in [
        (&["at", &out, "1h"][..], "12.5"),
        (&["at", &out, "99"], "the job ends at"),
        (&["at", &out, "1", "--channel", "9"], "no channel 9"),
        (&["at", "./missing", "1"], "no folder './missing'"),
        (&["where", &out, "upper.nc"], "part.nc:120"),
        (&["where", &out, "other.nc:3"], "no block"),
        (&["at", "", "1"], "no folder"),
    ] {
        let (status, text) = ask(wrong);
        assert!(status == 2 && text.contains(hint), "{wrong:?} {text}");
    }
    run(&[]);
    let (_, text) = ask(&["at", &out, &middle]);
    assert!(text.contains("--law"), "{text}");
}

/// Both turrets reach #100, and nothing orders them.
#[test]
fn an_analysis_of_a_failed_job_ends_with_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let upper = program(folder.path(), "upper.nc", "O1\nG0 X10.\nM101\nM30\n");
    let lower = program(folder.path(), "lower.nc", "O2\nG0 X10.\nM102\nM30\n");
    let out = folder.path().join("out").display().to_string();
    assert_eq!(code(&counterpoint(&["run", "--machine", "fanuc-2path-lathe", &upper, &lower, "--out", &out])), 1);
    // The timeline shows each channel with the code at which it stopped.
    let timeline = std::fs::read_to_string(folder.path().join("out/timeline.svg")).unwrap();
    assert!(timeline.contains(">alarm at M101<") && timeline.contains(">alarm at M102<"), "{timeline}");
    let output = counterpoint(&["analyse", &out]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(code(&output) == 1 && text.starts_with("FAILED"), "{text}");
    let output = counterpoint(&["analyse", &out, "--json"]);
    let value: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((code(&output), value["state"].as_str()), (1, Some("FAILED")));
}

#[test]
fn impossible_measurements_are_doubted() {
    let folder = tempfile::tempdir().unwrap();
    let part = program(folder.path(), "part.nc", "G0 X100. Y0. Z0.\nG1 X200. F1000\nG0 Z10.\nM30\n");
    let measured = program(folder.path(), "times.csv", "line,seconds\n2,1000\n3,2000\n");
    let run = |measured: &str| {
        let output = counterpoint(&["calibrate", "--machine", "fanuc-mill", "--measured", measured, &part]);
        (code(&output), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (ended, status) = run(&measured);
    assert!(
        ended == 0 && status.contains("warning: line 2: 1000.000 s were measured, but the machine takes 6."),
        "{status}"
    );
    let plausible = program(folder.path(), "good.csv", "line,seconds\n2,6.01\n3,0.09\n");
    assert!(!run(&plausible).1.contains("warning"), "{}", run(&plausible).1);
}

#[test]
fn lint_continues_after_a_missing_program_and_a_guess_names_a_waiting_code() {
    let folder = tempfile::tempdir().unwrap();
    let part = program(folder.path(), "part.nc", "O1\nM98 P77\nG65 P88\nM98 P99\nM30\n");
    let output = counterpoint(&["lint", "--machine", "fanuc-mill", &part]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    for number in [77, 88, 99] {
        assert!(code(&output) == 1 && text.contains(&format!("{number} not found")), "{number}: {text}");
    }
    let upper = program(folder.path(), "upper.nc", "O1\nM900\nM30\n");
    let lower = program(folder.path(), "lower.nc", "O2\nM900\nM30\n");
    let output = counterpoint(&["run", &upper, &lower]);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(code(&output) == 2 && text.contains("--set waits=900-999 if M900 is a waiting code"), "{text}");
}

#[test]
fn races_are_analysed() {
    let folder = tempfile::tempdir().unwrap();
    let upper = program(folder.path(), "upper.nc", "O1\nG4 P1000\n#100=1\nM30\n");
    let lower = program(folder.path(), "lower.nc", "O2\n#101=#100\nM30\n");
    let out = folder.path().join("out").display().to_string();
    let shared = ["--set", "shared=100-199"];
    let run = ["run", "-q", "--machine", "fanuc-2path-lathe", shared[0], shared[1], &upper, &lower, "--out", &out];
    assert_eq!(code(&counterpoint(&run)), 0);
    let output = counterpoint(&["analyse", &out, "--json"]);
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found["analysis"]["races"], serde_json::json!([["#100", {"1": 3, "2": 2}]]), "{found}");
    let text = counterpoint(&["analyse", &out]);
    let text = String::from_utf8_lossy(&text.stdout);
    assert!(text.contains("only timing decides") && text.contains("1:3  2:2"), "{text}");
}

#[test]
fn a_failed_job_fails_whoever_reads_it_and_its_files_have_no_colours() {
    let folder = tempfile::tempdir().unwrap();
    let upper = program(folder.path(), "upper.nc", "O1\nM101\nM30\n");
    let lower = program(folder.path(), "lower.nc", "O2\nM102\nM30\n");
    let out = folder.path().join("out").display().to_string();
    let run = ["run", "--machine", "fanuc-2path-lathe", &upper, &lower, "--out", &out, "--write", "summary,report"];
    for command in [&run[..], &["lint", "--machine", "fanuc-2path-lathe", &upper, &lower]] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_counterpoint"))
            .args(command)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        // The reader leaves before anything is written.
        drop(child.stdout.take());
        assert_eq!(child.wait().unwrap().code(), Some(1), "{command:?}");
    }
    let report = std::fs::read_to_string(Path::new(&out).join("report.txt")).unwrap();
    assert!(report.contains("FAILED") && !report.contains('\x1b'), "{report}");
    let analysed = counterpoint(&["analyse", &out]);
    assert!(String::from_utf8_lossy(&analysed.stdout).starts_with("FAILED: "), "{analysed:?}");
    let analysed = counterpoint(&["analyse", &out, "--json"]);
    let found: serde_json::Value = serde_json::from_slice(&analysed.stdout).unwrap();
    assert_eq!(found["state"], "FAILED");
}

#[test]
fn a_trace_and_a_log_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = program(folder.path(), "part.nc", "G90 G0 X2.\nQ7\nM30\n");
    let out = folder.path().join("out").display().to_string();
    let output = counterpoint(&["run", "-q", &path, "--trace", "ca", "--out", &out, "--write", "trace,log"]);
    assert_eq!(code(&output), 1, "{}", String::from_utf8_lossy(&output.stderr));
    let read = |name: &str| std::fs::read_to_string(Path::new(&out).join(name)).unwrap();
    let trace = read("1.trace");
    assert!(trace.starts_with("1! G90 G0 X2.\n"), "{trace}");
    assert!(trace.contains("  code_rapid\n    reg_axis_x 2\n"), "{trace}");
    let log = read("part.log");
    assert!(log.starts_with("Counterpoint\n") && log.contains("Q7 is not used") && !log.contains("1! "), "{log}");
    assert_eq!(code(&counterpoint(&["run", "-q", &path, "--trace", "K"])), 2);
}

#[test]
fn parameters_a_console_and_other_line_ends() {
    let folder = tempfile::tempdir().unwrap();
    let path = program(folder.path(), "part.nc", "G0 X1. NOISE\nM30\n");
    let machine = folder.path().join("told");
    std::fs::create_dir(&machine).unwrap();
    let text = "extends = \"fanuc-mill\"\n[ce]\nname = \"told\"\n[control]\nunknown_code = \"warn\"\n[macros]\nprogram_startup = \"start.mac\"\n";
    program(&machine, "machine.toml", text);
    program(&machine, "start.mac", "PPRINT/'got !(*)',$UPARAM\nERROR/4,'mind it'\n");
    let (machine, out) = (machine.display().to_string(), folder.path().join("out").display().to_string());
    let with = ["--machine", &machine, "--param", "-SHIFT=2 a", "--crlf", "--write", "console,listing"];
    let output = counterpoint(&[&["run", "-q", &path, "--out", &out][..], &with].concat());
    assert_eq!(code(&output), 0, "{}", String::from_utf8_lossy(&output.stderr));
    let read = |name: &str| std::fs::read_to_string(Path::new(&out).join(name)).unwrap();
    let console = "Display : got -SHIFT=2 a\r\nWarning: mind it (told/start.mac:2)\r\n\
                   Warning: 'NOISE' not recognized in 'G0 X1. NOISE' at line 1\r\n";
    assert_eq!(read("console.txt"), console);
    let listing = read("part.lce");
    assert!(
        listing.contains(
            "Database:     told/machine.toml\r\n\r\nUPARAM:       -SHIFT=2 a\r\n\r\ngot -SHIFT=2 a\r\nWarning: "
        ),
        "{listing}"
    );
    assert_eq!(listing.matches('\n').count(), listing.matches("\r\n").count());
}

#[test]
fn what_macros_write_is_reported_and_kept() {
    let folder = tempfile::tempdir().unwrap();
    let path = program(folder.path(), "part.nc", "T3 M6\nM30\n");
    let machine = folder.path().join("writer");
    std::fs::create_dir(&machine).unwrap();
    let text = "extends = \"fanuc-mill\"\n[ce]\nname = \"writer\"\n[macros]\ntool = \"tool.mac\"\n";
    program(&machine, "machine.toml", text);
    program(&machine, "tool.mac", "OUTPUT\nOPEN/20,'lists/tools.txt'\nWRITE/20,'T!(*)',$P3\n");
    let machine = machine.display().to_string();
    let output = counterpoint(&["run", "--machine", &machine, &path]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains("files written (use --out DIR to keep them)\n  lists/tools.txt, 3 bytes"), "{text}");
    let out = folder.path().join("out").display().to_string();
    let output = counterpoint(&["run", "-q", "--machine", &machine, &path, "--out", &out, "--write", "files"]);
    assert_eq!(code(&output), 0, "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(std::fs::read_to_string(Path::new(&out).join("files/lists/tools.txt")).unwrap(), "T3\n");
}

#[test]
fn what_programs_print_is_reported_and_kept() {
    let folder = tempfile::tempdir().unwrap();
    let text = "%\nO1\n#100=12.5\n#101=-3.14159\nDPRNT[X#100[43]*Y#101[53]]\nDPRNT[END]\nM30\n%\n";
    let path = program(folder.path(), "part.nc", text);
    let kept = |machine: &str, name: &str| {
        let out = folder.path().join("out").display().to_string();
        let output = counterpoint(&["run", "--machine", machine, &path, "--out", &out]);
        let report = String::from_utf8_lossy(&output.stdout).into_owned();
        assert_eq!(code(&output), 0, "{report}");
        let written = std::fs::read(Path::new(&out).join("files").join(name)).unwrap();
        assert!(report.contains(&format!("files written\n  {name}, {} bytes", written.len())), "{report}");
        String::from_utf8(written).unwrap()
    };
    assert_eq!(kept("haas-mill-turn", "dprnt.txt"), "X  12.500 Y-    3.142\rEND\r");
    // Every key of [output] in a machine of one's own.
    let machine = folder.path().join("printer");
    std::fs::create_dir(&machine).unwrap();
    let short = "extends = \"haas-mill-turn\"\n[ce]\nname = \"printer\"\n[output]\nfile = \"probe.log\"\n\
                 leading_zeros = \"none\"\nline_end = \"cr-lf\"\n";
    program(&machine, "machine.toml", short);
    let name = machine.display().to_string();
    assert_eq!(kept(&name, "probe.log"), "X12.500 Y-3.142\r\nEND\r\n");
    let column = short.replace("leading_zeros = \"none\"", "sign = \"column\"").replace("cr-lf", "lf");
    program(&machine, "machine.toml", &column);
    assert_eq!(kept(&name, "probe.log"), "X   12.500 Y-    3.142\nEND\n");
    // A control that wants POPEN says that it is missing, and keeps the lines.
    program(&machine, "machine.toml", &format!("{column}open = \"needed\"\n"));
    let output = counterpoint(&["run", "--machine", &name, &path]);
    let report = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        report.contains("2900358") && report.contains("files written (use --out DIR to keep them)\n  probe.log"),
        "{report}"
    );
}

#[cfg(unix)]
#[test]
fn commands_of_the_system_are_refused_unless_they_are_allowed() {
    let folder = tempfile::tempdir().unwrap();
    let path = program(folder.path(), "part.nc", "M30\n");
    let machine = folder.path().join("starter");
    std::fs::create_dir(&machine).unwrap();
    let text = "extends = \"fanuc-mill\"\n[ce]\nname = \"starter\"\n[macros]\nprogram_startup = \"start.mac\"\n";
    program(&machine, "machine.toml", text);
    let command = "SYSTEM/'ls; wc -l part.nc > lines.txt; exit 4'\nPPRINT/'status !(*)',$ERRNO\n";
    program(&machine, "start.mac", command);
    let machine = machine.display().to_string();
    let output = counterpoint(&["run", "--json", "--machine", &machine, &path]);
    assert_eq!(code(&output), 1);
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(summary["diagnostics"][0]["number"], 1_118_001, "{summary}");
    let out = folder.path().join("out").display().to_string();
    let arguments = ["run", "-q", "--allow-system", "--machine", &machine, &path, "--out", &out];
    assert_eq!(code(&counterpoint(&arguments)), 0);
    let read = |name: &str| std::fs::read_to_string(Path::new(&out).join(name)).unwrap();
    assert_eq!(read("files/lines.txt").trim(), "1 part.nc");
    let events = read("events.jsonl");
    let texts: Vec<_> = events.lines().filter(|line| line.contains("\"kind\":\"message\"")).collect();
    assert!(texts.len() == 2 && texts[0].contains("part.nc") && texts[1].contains("status 4"), "{texts:?}");
}

#[test]
fn exit_codes_tell_what_went_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let path = program(folder.path(), "part.nc", "O1\nG0 X1.\nM30\n");
    assert_eq!(code(&counterpoint(&["run", "no-such-file.nc"])), 2);
    assert_eq!(code(&counterpoint(&["run", "--machine", "no-such-machine", &path])), 2);
    assert_eq!(code(&counterpoint(&["run", &path, &path, &path, &path])), 2, "no machine to guess for four");
    assert_eq!(code(&counterpoint(&["nonsense"])), 2);
    assert_eq!(code(&counterpoint(&["jobs", "--server", "http://127.0.0.1:1"])), 3);
    // A channel that waits for one without a program can never continue.
    let waits = program(folder.path(), "waits.nc", "O1\nM101 P12\nM30\n");
    assert_eq!(code(&counterpoint(&["run", "--machine", "fanuc-2path-lathe", &waits])), 1);
}

#[test]
fn a_machine_is_guessed_with_a_reason_or_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let lathe = "O1\nG50 S2500\nT0101\nG96 S200 M3\nG0 X52. Z2.\nG1 Z-30. F0.2\nM30\n";
    let lathe = program(folder.path(), "lathe.nc", lathe);
    let output = counterpoint(&["run", &lathe]);
    let status = String::from_utf8_lossy(&output.stderr);
    assert_eq!(code(&output), 0, "{status}");
    assert!(status.contains("machine fanuc-lathe, guessed from G50 S2500 (line 2), G96 S200 (line 4)"), "{status}");
    for (name, text, reason) in [
        ("bare.nc", "O1\nG0 X1.\nM30\n", "shows which machine it is for"),
        ("part.i", "N10 G00 X+10*\n", "nothing but the name shows it"),
        ("part.mpf", "G54 G0 X10\nM30\n", "a Siemens control"),
    ] {
        let path = program(folder.path(), name, text);
        let output = counterpoint(&["run", &path]);
        let status = String::from_utf8_lossy(&output.stderr);
        assert_eq!(code(&output), 2, "{status}");
        assert!(status.contains("no machine given") && status.contains(reason), "{status}");
        assert!(output.stdout.is_empty(), "nothing was run");
        assert_eq!(code(&counterpoint(&["run", "--exit-code", "severity", &path])), 201);
    }
}

/// From Z500 to Z10 at 30 m/min and 5 m/s² takes 0.98 s and 0.1 s more for both changes of speed, with a tool of 80 in
/// the spindle 0.92 s.
#[test]
fn a_table_of_tools_counts_for_one_run() {
    let folder = tempfile::tempdir().unwrap();
    let part = program(folder.path(), "part.nc", "O1\nG43 H1 G0 Z10.\nM30\n");
    let table = program(folder.path(), "tools.csv", "number;name;diameter;length\nT1;FACE 63;63;80,0\n");
    let rows = program(folder.path(), "tools.toml", "[[tool.offsets]]\nnumber = 1\nvalues = { Z = 80 }\n");
    let wrong = program(folder.path(), "wrong.csv", "number,length,tip\n2,1,\n1,80,30\n");
    let unknown = program(folder.path(), "unknown.csv", "number,length,Q\n2,1,\n");
    let own = folder.path().join("our-mill");
    std::fs::create_dir(&own).unwrap();
    std::fs::write(own.join("machine.toml"), "extends = \"fanuc-mill\"\n[ce]\nname = \"our-mill\"\n").unwrap();
    let own = own.display().to_string();
    let run = |machine: &str, more: &[&str]| {
        let output = counterpoint(&[&["run", "--json", "--machine", machine, &part], more].concat());
        let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap_or_default();
        (code(&output), summary["makespan_ns"].as_i64(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    assert_eq!(run("fanuc-mill", &[]).1, Some(1_080_000_000));
    for (machine, tools) in [("fanuc-mill", &table), ("fanuc-mill", &rows), (own.as_str(), &table)] {
        let (status, time, text) = run(machine, &["--tools", tools]);
        assert_eq!((status, time), (0, Some(920_000_000)), "{text}");
    }
    let (status, _, text) = run("fanuc-mill", &["--tools", &wrong]);
    assert!(status == 2 && text.contains("wrong.csv:3: ") && text.contains("tip"), "{status} {text}");
    let (status, _, text) = run("fanuc-mill", &["--tools", &unknown]);
    assert!(status == 2 && text.contains("unknown.csv:1: unknown column 'Q'"), "{status} {text}");
}

#[test]
fn a_stopped_spindle_is_named_with_the_channel_that_stopped_it() {
    let folder = tempfile::tempdir().unwrap();
    let upper = program(folder.path(), "upper.nc", "G21 G0 X50 Z5\nG97 S500 M3\nM101 P12\nM5\nG4 X1\nM102 P12\nM30\n");
    let lower = program(folder.path(), "lower.nc", "G21 G0 X50 Z5\nM101 P12\nG4 X0.5\nG1 Z-20 F0.2\nM102 P12\nM30\n");
    let output = counterpoint(&["run", &upper, &lower, "--machine", "fanuc-2path-lathe"]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains("lower.nc:4: spindle 1 (MAIN) is stopped by channel 1 at 1."), "{text}");
    let alone = program(folder.path(), "alone.nc", "G21 G0 X50 Z5\nG99 G1 Z-20 F0.2\nM30\n");
    let output = counterpoint(&["run", &alone, "--machine", "fanuc-lathe"]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains("alone.nc:2: spindle 1 (MAIN) is stopped in 'G99"), "{text}");
}

#[test]
fn a_length_that_the_table_of_tools_does_not_have_is_reported_once() {
    let folder = tempfile::tempdir().unwrap();
    let mill = "G21 G90 G54\nT1 M6\nS500 M3\nG43 H1 Z50.\nG43 H7 Z40.\nG43 H7 Z30.\nG49\nM30\n";
    let siemens = "T=\"A\"\nM6\nG0 X0 D1\nT5\nM6\nD1\nG0 X10\nD1\nM30\n";
    let tnc = "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S500\n2 L Z+50 R0 FMAX M3\n3 TOOL CALL 5 Z S500\n4 L X+10 R0 FMAX\n\
               5 M30\n6 END PGM A MM\n";
    let numbers = program(folder.path(), "numbers.csv", "T,length mm\n1,80\n");
    let names = program(folder.path(), "names.csv", "name,length mm\nA,80\n");
    for (machine, text, table, place, subject) in [
        ("fanuc-mill", mill, &numbers, "part.nc:5: ", "tool offset 7 has no values"),
        ("haas-mill", mill, &numbers, "part.nc:5: ", "tool offset 7 has no values"),
        ("siemens-mill", siemens, &names, "part.nc:5: ", "edge 1 of tool 5 has no values"),
        ("heidenhain-mill", tnc, &numbers, "part.nc:4: ", "tool 5 has no values"),
    ] {
        let path = program(folder.path(), "part.nc", text);
        let run = |more: &[&str]| {
            let output = counterpoint(&[&["run", "--no-timeline", "--machine", machine, &path], more].concat());
            String::from_utf8_lossy(&output.stdout)
                .lines()
                .filter(|line| line.contains(" 2900024 "))
                .collect::<String>()
        };
        let told = run(&["--tools", table]);
        assert!(told.contains(&format!("{place}{subject}")) && !told.contains("times)"), "{machine}: {told}");
        assert_eq!(told.matches("2900024").count(), 1, "{machine}: {told}");
        assert_eq!(run(&[]), "", "{machine}: without a table all lengths are zero");
    }
}

/// One table for all controls: the active tool shifts the frame by 80 along Z, by 50 along X.
#[test]
fn a_table_of_tools_counts_on_every_control() {
    let folder = tempfile::tempdir().unwrap();
    let tables = [
        ("number", "number;name;length;radius\n5;EM10;80;5\n"),
        ("name", "tool;length;radius\nEM10;80;5\n"),
        ("edge", "T;D;name;length\n5;1;EM10;80\n5;2;EM10;70\n"),
        ("x", "T;name;X;Z\n5;EM10;50;80\n"),
    ];
    let table = |name: &str| folder.path().join(format!("{name}.csv")).display().to_string();
    for (name, text) in tables {
        program(folder.path(), &format!("{name}.csv"), text);
    }
    let tnc = |call: &str| format!("0 BEGIN PGM A MM\n1 TOOL CALL {call} Z S1000\n2 L Z+10 R0 FMAX\n3 END PGM A MM\n");
    let (name_of_tnc, number_of_tnc) = (tnc("\"EM10\""), tnc("5"));
    for (machine, ending, text, tools, axis, value) in [
        ("siemens-mill", "mpf", "T5 M6\nG0 Z10\nM30\n", "number", "Z", 80.0),
        ("siemens-mill", "mpf", "T=\"EM10\" M6\nG0 Z10\nM30\n", "number", "Z", 80.0),
        ("siemens-mill", "mpf", "T=\"em10\"\nM6\nG0 Z10\nM30\n", "name", "Z", 80.0),
        ("siemens-mill", "mpf", "T=5 D2 M6\nD2 G0 Z10\nM30\n", "edge", "Z", 70.0),
        ("siemens-lathe", "mpf", "T5 D1\nG0 Z10\nM30\n", "number", "Z", 80.0),
        ("siemens-lathe", "mpf", "T5 D1\nG0 X100\nM30\n", "x", "X", 50.0),
        ("heidenhain-mill", "h", name_of_tnc.as_str(), "number", "Z", 80.0),
        ("heidenhain-mill", "h", name_of_tnc.as_str(), "name", "Z", 80.0),
        ("heidenhain-mill", "h", number_of_tnc.as_str(), "number", "Z", 80.0),
        ("fanuc-mill", "nc", "O1\nT5 M6\nG43 H5 G0 Z10.\nM30\n", "number", "Z", 80.0),
        ("haas-mill", "nc", "O1\nT5 M6\nG43 H5 G0 Z10.\nM30\n", "number", "Z", 80.0),
        ("mazak-eia-mill", "eia", "O1\nT5 T0 M6\nG43 H5 G0 Z10.\nM30\n", "number", "Z", 80.0),
        ("mazak-eia-lathe", "eia", "O1\nT0505\nG0 Z10.\nM30\n", "number", "Z", 80.0),
        ("okuma-mill", "min", "G15 H1\nT5\nM6\nG56 H5 G0 Z10\nM2\n", "number", "Z", 80.0),
        ("okuma-lathe", "min", "T0505\nG0 Z10\nM2\n", "number", "Z", 80.0),
        ("fanuc-2path-lathe", "nc", "O1\nT0505\nG0 X100.\nM30\n", "x", "X", 50.0),
        ("isg-3channel", "nc", "T5 M6\nD5\nG0 Z10\nM30\n", "number", "Z", 80.0),
    ] {
        let part = program(folder.path(), &format!("part.{ending}"), text);
        let out = folder.path().join("out");
        let out_text = out.display().to_string();
        let with =
            ["run", "--machine", machine, "--tools", &table(tools), "--out", &out_text, "--write", "events", &part];
        let output = counterpoint(&with);
        assert_eq!(code(&output), 0, "{machine} {text}: {}", String::from_utf8_lossy(&output.stderr));
        let events = std::fs::read_to_string(out.join("events.jsonl")).unwrap();
        let events: Vec<serde_json::Value> = events.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        let shift_of = |event: &serde_json::Value| event["shift"][axis].as_f64();
        // The part zero is at work before the first line.
        let part_zero = events.iter().filter(|event| event["line"] == 0).find_map(shift_of);
        let shift = events.iter().filter_map(shift_of).next_back();
        assert_eq!(shift, Some(value + part_zero.unwrap_or(0.0)), "{machine} {text}");
    }
}

#[test]
fn waiting_codes_are_set_for_one_run() {
    let folder = tempfile::tempdir().unwrap();
    let upper = program(folder.path(), "upper.nc", "O1\nG4 X1.\nM901\nG4 X2.\nM30\n");
    let lower = program(folder.path(), "lower.nc", "O2\nG4 X4.\nM901\nM30\n");
    let run = |more: &[&str]| {
        let output = counterpoint(&[&["run", "--json", &upper, &lower], more].concat());
        let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap_or_default();
        (code(&output), summary["makespan_ns"].as_i64(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    // The upper turret waits from 1 s to 4 s and ends at 6 s.
    // So it does on a machine of one's own that has the row from a shipped one.
    let own = folder.path().join("our-lathe");
    std::fs::create_dir(&own).unwrap();
    let definition = "extends = \"fanuc-2path-lathe\"\n[ce]\nname = \"our-lathe\"\nnumber = 99\nrevision = 1\n";
    std::fs::write(own.join("machine.toml"), definition).unwrap();
    let own = own.display().to_string();
    for machine in [&[][..], &["--machine", "fanuc-2path-lathe"], &["--machine", &own]] {
        let (status, time, text) = run(&[machine, &["--set", "waits=900-999"]].concat());
        assert_eq!((status, time), (0, Some(6_000_000_000)), "{text}");
    }
    assert_eq!(run(&["--machine", "fanuc-2path-lathe"]).0, 1, "M901 is not a code of the machine");
    let refused = |more: &[&str], with: &str| {
        let (status, _, text) = run(more);
        assert!(status == 2 && text.contains(with), "{text}");
    };
    refused(&["--set", "waits=9"], "is not a range");
    refused(&["--set", "rapid=9"], "no such key 'rapid': the keys are waits=FIRST-LAST");
    refused(&["--machine", "siemens-2channel", "--set", "waits=900-999"], "has no range of M codes that wait");
}

#[test]
fn a_warning_is_switched_off_for_one_run() {
    let folder = tempfile::tempdir().unwrap();
    let part = program(folder.path(), "part.nc", "O1\nM3 S1000\nG1 X10. F80000\nM30\n");
    let run = |more: &[&str]| {
        let output = counterpoint(&[&["run", "--machine", "fanuc-mill", "--strict", &part], more].concat());
        (code(&output), String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned())
    };
    let (ended, text) = run(&[]);
    assert!(ended == 1 && text.contains("2900680"), "{text}");
    for key in ["warn.2900680=off", "warn.feed-above-rates=off"] {
        let (ended, text) = run(&["--set", key]);
        assert!(ended == 0 && !text.contains("2900680"), "{key}: {text}");
    }
    let (ended, text) = run(&["--set", "warn.2900680=off", "--set", "warn.2900680=on"]);
    assert!(ended == 1 && text.contains("2900680"), "{text}");
    let (ended, text) = run(&["--set", "warn.2900320=off"]);
    assert!(ended == 2 && text.contains("is an error: only warnings"), "{text}");
}

#[test]
fn warnings_are_counted_and_strict_makes_them_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let clean = program(folder.path(), "clean.nc", "O1\nG0 X1.\nM30\n");
    let warns = program(folder.path(), "warns.nc", "O1\nG0 X2.\nG0 X1. (no end\n");
    let run = |program: &str, more: &[&str]| {
        let output = counterpoint(&[&["run", "--machine", "fanuc-mill", program], more].concat());
        let first = String::from_utf8_lossy(&output.stdout).lines().next().unwrap_or_default().to_owned();
        (code(&output), first)
    };
    let (status, first) = run(&warns, &[]);
    assert!(status == 0 && first.starts_with("SUCCEEDED, 2 warnings  cycle time "), "{first}");
    assert_eq!(run(&warns, &["--strict"]).0, 1);
    assert_eq!(run(&clean, &["--strict"]), (0, "SUCCEEDED  cycle time 00:00.028".to_owned()));
}

#[test]
fn a_server_that_cannot_be_reached_is_an_error_at_once() {
    for command in ["watch", "wait", "attend", "cancel"] {
        let output = counterpoint(&[command, "job", "--server", "http://127.0.0.1:1"]);
        let status = String::from_utf8_lossy(&output.stderr);
        assert_eq!(code(&output), 3, "{status}");
        assert!(
            status.contains("no server answers at http://127.0.0.1:1") && status.contains("counterpointd"),
            "{status}"
        );
        // Without a scheme it is the address of a server without TLS.
        let output = counterpoint(&[command, "job", "--server", "127.0.0.1:1"]);
        let status = String::from_utf8_lossy(&output.stderr);
        assert!(code(&output) == 3 && status.contains("no server answers at http://127.0.0.1:1"), "{status}");
        assert_eq!(code(&counterpoint(&[command, "job", "--server", "ftp://localhost:1"])), 2);
    }
}

#[test]
fn the_token_and_the_authorities_come_from_the_environment() {
    let folder = tempfile::tempdir().unwrap();
    let access = folder.path().join("access.toml");
    let (token, row) = counterpoint_server::access::token::create("t", "t", Role::Read, None).unwrap();
    std::fs::write(&access, row).unwrap();
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build().unwrap();
    let guard = Guard { access, ..Guard::default() };
    let options = ServerOptions {
        guard,
        listen: "127.0.0.1:0".parse().unwrap(),
        data: folder.path().join("data"),
        ..ServerOptions::default()
    };
    let service = runtime.block_on(service::build(options)).unwrap();
    let url = service.handle().url();
    runtime.spawn(service.run(std::future::pending()));
    let list = |url: &str, name: &str, value: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_counterpoint"));
        let output = command.args(["jobs", "--server", url]).env(name, value).stdin(Stdio::null()).output().unwrap();
        (code(&output), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    assert_eq!(list(&url, "COUNTERPOINT_TOKEN", &token), (0, String::new()));
    let (status, talk) = list(&url, "COUNTERPOINT_TOKEN", "cpt_00");
    assert!(status == 3 && talk.contains("token is not known"), "{status} {talk}");
    assert!(talk.contains("the token came from COUNTERPOINT_TOKEN"), "{talk}");
    // An empty variable counts as absent.
    for name in ["COUNTERPOINT_CA", "COUNTERPOINT_TOKEN"] {
        let (status, talk) = list(&url, name, "");
        assert!(status == 3 && talk.contains("set COUNTERPOINT_TOKEN to a token for this server"), "{status} {talk}");
    }
    for (name, missing) in [("CERT", "KEY"), ("KEY", "CERT")] {
        let (status, talk) = list(
            &url,
            &format!("COUNTERPOINT_CLIENT_{name}"),
            &folder.path().join("access.toml").display().to_string(),
        );
        assert!(status == 2 && talk.contains(&format!("COUNTERPOINT_CLIENT_{missing} is not")), "{status} {talk}");
    }
    let (status, talk) = list("https://127.0.0.1:1", "COUNTERPOINT_CA", "no-such.pem");
    assert!(status != 0 && talk.contains("'no-such.pem' does not exist"), "{talk}");
}

/// Characters that change the direction of a text, end its line or have no width could forge a list of jobs.
#[test]
fn characters_that_deceive_readers_are_printed_as_escapes() {
    let folder = tempfile::tempdir().unwrap();
    let (_runtime, url) = server(folder.path());
    let done = |arguments: &[&str]| {
        let output = counterpoint(&[arguments, &["--server", &url]].concat());
        assert_eq!(code(&output), 0, "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let part = program(folder.path(), "pa\u{200b}rt.nc", "O1\nG0 X1.\nM30\n");
    let label = "odd=a\u{202e}b\u{2028}c\u{2029}d";
    let job = done(&["submit", &part, "--machine", "fanuc-mill", "--label", label]);
    let job = job.trim();
    for arguments in [&["wait", job][..], &["wait", job, "--json"], &["jobs"], &["jobs", "--json"], &["status", job]] {
        let text = done(arguments);
        let deceive = |c: char| matches!(c, '\u{200b}' | '\u{2028}'..='\u{202e}');
        assert!(!text.contains(deceive), "{arguments:?}: {text:?}");
        if arguments.contains(&"--json") {
            let read: serde_json::Value = serde_json::from_str(&text).unwrap();
            assert_eq!(read["labels"]["odd"], "a\u{202e}b\u{2028}c\u{2029}d");
        }
    }
    let list = done(&["jobs"]);
    assert!(list.contains(r"odd=a\u202eb\u2028c\u2029d") && list.contains(r"pa\u200brt.nc"), "{list}");
}

#[test]
fn jobs_on_a_server_are_labelled_found_followed_and_run_again() {
    let folder = tempfile::tempdir().unwrap();
    let (_runtime, url) = server(folder.path());
    let call = |arguments: &[&str]| {
        let output = counterpoint(&[arguments, &["--server", &url]].concat());
        let text = String::from_utf8_lossy(&output.stdout).trim_end().to_owned();
        (code(&output), text, String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let done = |arguments: &[&str]| {
        let (status, out, talk) = call(arguments);
        assert_eq!(status, 0, "{arguments:?}: {out} {talk}");
        out
    };
    let part = program(folder.path(), "part.nc", "O1\nG0 X1.\nM30\n");
    let with = ["--machine", "fanuc-mill", "--label", "part=17", "--label", "shift=early", "--priority", "high"];
    let first = done(&[&["submit", &part, "--deadline", "1h"][..], &with].concat());
    done(&["wait", &first]);
    let report = done(&["result", &first, "report"]);
    assert!(report.contains("cycle time") && report.contains("channel  program"), "{report}");
    assert!(report.starts_with(&format!("job {first}  part=17 shift=early  submitted 2")), "{report}");
    let fetched = folder.path().join("fetched");
    done(&["result", &first, "all", "-o", &fetched.display().to_string()]);
    for name in ["summary.json", "report.txt", "part.lce", "part.log", "console.txt", "events.jsonl", "timeline.svg"] {
        assert!(fetched.join(name).is_file(), "{name} is missing");
    }
    let json = |text: &str| serde_json::from_str::<serde_json::Value>(text).unwrap();
    let second =
        json(&done(&["submit", &part, "--machine", "fanuc-mill", "--json"]))["job"].as_str().unwrap().to_owned();
    let ended = json(&done(&["wait", &second, "--json"]));
    assert_eq!((&ended["job"], &ended["state"]), (&second.as_str().into(), &"SUCCEEDED".into()));
    let (status, _, talk) = call(&["watch", &second, "--json"]);
    assert!(status == 2 && talk.contains("cannot be used with '--json'"), "{talk}");
    let again = done(&["rerun", &first, "--request-id", "again", "--label", "part=18"]);
    assert_eq!(done(&["rerun", &first, "--request-id", "again", "--label", "part=18"]), again);
    done(&["wait", &again]);
    let listed = |arguments: &[&str]| {
        let lines = done(&[&["jobs", "--json"][..], arguments].concat());
        let jobs = lines.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
        jobs.collect::<Vec<_>>()
    };
    let names =
        |jobs: &[serde_json::Value]| jobs.iter().map(|job| job["job"].as_str().unwrap().to_owned()).collect::<Vec<_>>();
    let labelled = listed(&["--label", "part=17", "--state", "succeeded", "--since", "1h"]);
    assert_eq!(names(&labelled), std::slice::from_ref(&first));
    assert_eq!(labelled[0]["labels"]["shift"], "early");
    assert_eq!((&labelled[0]["priority"], labelled[0]["deadline_ms"].is_i64()), (&"HIGH".into(), true));
    assert_eq!(names(&listed(&["--newest", "--limit", "2", "--machine", "fanuc-mill"])), [again.clone(), second]);
    assert_eq!(listed(&["--label", "part=18"])[0]["rerun_of"], first.as_str());
    let (status, _, talk) = call(&["jobs", "--label", ""]);
    assert!(status == 2 && talk.contains("the value is empty"), "{talk}");

    let machine = folder.path().join("mine");
    std::fs::create_dir(&machine).unwrap();
    program(&machine, "machine.toml", "extends = \"fanuc-mill\"\n[ce]\nname = \"mine\"\n");
    done(&["machine", "show", &machine.display().to_string(), "axes"]);
    let machines = done(&["machine", "list", "--json"]);
    let shipped =
        |name: &str| machines.lines().map(json).find(|row| row["machine"] == name).unwrap()["shipped"].clone();
    assert_eq!((shipped("mine"), shipped("fanuc-mill")), (false.into(), true.into()));
    program(&machine, "machine.toml", "extends = \"fanuc-mill\"\n[ce]\nname = \"mine\"\nnumbre = 1\n");
    let (status, out, _) = call(&["machine", "check", &machine.display().to_string(), "--json"]);
    let found = json(&out);
    assert_eq!((status == 0, &found["findings"][0]["line"]), (found["usable"].as_bool().unwrap(), &4.into()), "{out}");
    done(&["machine", "delete", "mine"]);
    let (status, _, talk) = call(&["machine", "delete", "mine"]);
    assert!(status == 2 && talk.contains("UNKNOWN_MACHINE"), "{talk}");

    let mut watch = Command::new(env!("CARGO_BIN_EXE_counterpoint"))
        .args(["watch", "--all", "--label", "watched=yes", "--state", "succeeded", "--json", "--server", &url])
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let output = std::io::BufReader::new(watch.stdout.take().unwrap());
    let first_line = std::thread::spawn(move || std::io::BufRead::lines(output).next().unwrap().unwrap());
    // Jobs that end before the watch has begun are not reported.
    let mut watched = Vec::new();
    while !first_line.is_finished() {
        done(&["submit", &part, "--machine", "fanuc-mill"]);
        watched.push(done(&["submit", &part, "--machine", "fanuc-mill", "--label", "watched=yes"]));
    }
    let line = first_line.join().unwrap();
    assert!(watched.iter().any(|job| line.contains(job)) && line.contains("SUCCEEDED"), "{line}");
    watch.kill().unwrap();
    watch.wait().unwrap();
}

/// A server that has restarted does not know the changes before.
#[test]
fn a_watch_of_many_jobs_prints_those_that_have_ended_while_it_was_cut_off() {
    let folder = tempfile::tempdir().unwrap();
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build().unwrap();
    let start = |listen: &str| {
        let (listen, data) = (listen.parse().unwrap(), folder.path().join("data"));
        let service =
            runtime.block_on(service::build(ServerOptions { listen, data, grace_s: 0, ..ServerOptions::default() }));
        let service = service.unwrap();
        (service.handle(), runtime.spawn(service.run(std::future::pending())))
    };
    let done = |arguments: &[&str], url: &str| {
        let output = counterpoint(&[arguments, &["--server", url]].concat());
        assert_eq!(code(&output), 0, "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap().trim().to_owned()
    };
    let part = program(folder.path(), "part.nc", "O1\nG0 X1.\nM30\n");
    let submit = |url: &str| {
        let job = done(&["submit", &part, "--machine", "fanuc-mill"], url);
        done(&["wait", &job], url);
        job
    };
    let (first, task) = start("127.0.0.1:0");
    let (url, address) = (first.url(), first.address().to_string());
    let mut watch = Command::new(env!("CARGO_BIN_EXE_counterpoint"))
        .args(["watch", "--all", "--state", "succeeded", "--json", "--server", &url])
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let (send, lines) = std::sync::mpsc::channel();
    let output = std::io::BufReader::new(watch.stdout.take().unwrap());
    std::thread::spawn(move || {
        std::io::BufRead::lines(output).map_while(Result::ok).try_for_each(|line| send.send(line))
    });
    // A job that ends before the watch has begun is not printed.
    while lines.try_recv().is_err() {
        submit(&url);
    }
    first.stop();
    runtime.block_on(task).unwrap().unwrap();
    let (second, task) = start("127.0.0.1:0");
    let missed = submit(&second.url());
    second.stop();
    runtime.block_on(task).unwrap().unwrap();
    let (third, _task) = start(&address);
    let patience = std::time::Duration::from_secs(30);
    while !lines.recv_timeout(patience).expect("the job is printed").contains(&missed) {}
    third.stop();
    watch.kill().unwrap();
    watch.wait().unwrap();
}

/// The watch of a job that was paused, resumed and cancelled ends with the job, whether it was there all the time or
/// begins afterwards.
#[test]
fn a_watch_of_a_job_that_is_paused_resumed_and_cancelled_ends_with_the_job() {
    let folder = tempfile::tempdir().unwrap();
    let (_runtime, url) = server(folder.path());
    let call = |arguments: &[&str]| {
        let output = counterpoint(&[arguments, &["--server", &url]].concat());
        let out = String::from_utf8_lossy(&output.stdout).trim_end().to_owned();
        (code(&output), out, String::from_utf8_lossy(&output.stderr).into_owned())
    };
    // The first block is reported, since the spindle is off; the rest of the program has no end.
    let part = program(folder.path(), "part.nc", "O1\nG1 X1. F100\nN1 G4 P9\nGOTO 1\nM30\n");
    let (status, job, talk) = call(&["submit", &part, "--machine", "fanuc-mill"]);
    assert_eq!(status, 0, "{talk}");
    let mut watch = Command::new(env!("CARGO_BIN_EXE_counterpoint"))
        .args(["watch", &job, "--server", &url])
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut output = std::io::BufReader::new(watch.stdout.take().unwrap());
    let mut lines = std::io::BufRead::lines(&mut output).map(Result::unwrap);
    assert!(lines.any(|line| line.contains("2900681")));
    assert_eq!(call(&["pause", &job]).0, 0);
    while !call(&["status", &job]).1.contains("PAUSED") {}
    assert_eq!(call(&["resume", &job]).0, 0);
    assert_eq!(call(&["cancel", &job]).0, 0);
    assert_eq!(watch.wait().unwrap().code(), Some(1));
    let (status, _, talk) = call(&["watch", &job]);
    assert_eq!(status, 1, "{talk}");
}

/// Jobs of a filter are cancelled and deleted only after a confirmation, which scripts give with `--yes`.
#[test]
fn jobs_of_a_filter_are_cancelled_and_deleted_once_that_is_confirmed() {
    let folder = tempfile::tempdir().unwrap();
    let (_runtime, url) = server(folder.path());
    let call = |arguments: &[&str]| {
        let output = counterpoint(&[arguments, &["--server", &url]].concat());
        let lines = String::from_utf8_lossy(&output.stdout).lines().map(str::to_owned).collect::<Vec<_>>();
        (code(&output), lines, String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let part = program(folder.path(), "part.nc", "O1\nN1 G4 P9\nGOTO 1\nM30\n");
    let submit = |label: &str| call(&["submit", &part, "--machine", "fanuc-mill", "--label", label]).1.remove(0);
    let [first, second, third] = ["shift=early", "shift=early", "shift=late"].map(submit);
    assert_eq!(call(&["pause", &third]).0, 0);
    let (_, paused, _) = call(&["jobs", "--state", "paused", "--json"]);
    assert!(paused.len() == 1 && paused[0].contains(&third), "{paused:?}");

    let early = ["--label", "shift=early"];
    let both = [second, first];
    let (status, lines, talk) = call(&[&["cancel", "--dry-run"], &early[..]].concat());
    assert_eq!((status, &lines[..], talk.trim()), (0, &both[..], "2 jobs would be cancelled"));
    let (status, lines, talk) = call(&[&["cancel"], &early[..]].concat());
    assert_eq!((status, lines.len()), (2, 0), "{talk}");
    assert!(talk.contains("this would cancel 2 jobs: add --yes"), "{talk}");
    let (status, lines, talk) = call(&[&["cancel", "--yes"], &early[..]].concat());
    assert_eq!((status, &lines[..], talk.trim()), (0, &both[..], "2 jobs cancelled"));
    both.iter().for_each(|job| assert_eq!(call(&["wait", job]).0, 1));

    for arguments in [&["delete"][..], &["cancel", "--yes"], &["delete", "--all", "--state", "failed"]] {
        let (status, _, talk) = call(arguments);
        assert_eq!(status, 2, "{arguments:?}: {talk}");
    }
    let (status, lines, talk) = call(&["delete", "--state", "paused", "--yes"]);
    assert_eq!((status, lines.len()), (2, 0), "{talk}");
    assert!(talk.contains("only ended jobs can be deleted"), "{talk}");
    let (status, lines, talk) = call(&["delete", "--all", "--yes"]);
    assert_eq!((status, &lines[..], talk.trim()), (0, &both[..], "2 jobs deleted"));
    let (_, left, _) = call(&["jobs", "--json"]);
    assert!(left.len() == 1 && left[0].contains(&third), "{left:?}");
    assert_eq!(call(&["cancel", "--all", "--quiet", "--yes"]), (0, Vec::new(), "1 job cancelled\n".to_owned()));
}

/// A server in this process until the test ends, and its address.
fn server(folder: &Path) -> (tokio::runtime::Runtime, String) {
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build().unwrap();
    let options =
        ServerOptions { listen: "127.0.0.1:0".parse().unwrap(), data: folder.join("data"), ..ServerOptions::default() };
    let service = runtime.block_on(service::build(options)).unwrap();
    let url = service.handle().url();
    runtime.spawn(service.run(std::future::pending()));
    (runtime, url)
}

/// Programs of real controls: an equal job gets the results of the first, unless the run asked an operator or the system.
#[cfg(unix)]
#[test]
fn an_equal_job_on_a_server_has_the_results_of_the_first() {
    let folder = tempfile::tempdir().unwrap();
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build().unwrap();
    let (listen, data) = ("127.0.0.1:0".parse().unwrap(), folder.path().join("data"));
    let mut options = ServerOptions { listen, data, ..ServerOptions::default() };
    options.system.allow_system = true;
    let service = runtime.block_on(service::build(options)).unwrap();
    let url = service.handle().url();
    runtime.spawn(service.run(std::future::pending()));
    let call = |arguments: &[&str]| {
        let output = counterpoint(&[arguments, &["--server", &url]].concat());
        let text = String::from_utf8_lossy(&output.stdout).trim_end().to_owned();
        assert_eq!(code(&output), 0, "{arguments:?}: {text} {}", String::from_utf8_lossy(&output.stderr));
        text
    };
    // The job, and the job that made its results.
    let job = |arguments: &[&str]| {
        let id = call(&[&["submit"], arguments].concat());
        let status: serde_json::Value = serde_json::from_str(&call(&["wait", &id, "--json"])).unwrap();
        assert_eq!(status["state"], "SUCCEEDED", "{status}");
        (id, status["reused_from"].as_str().unwrap_or_default().to_owned())
    };
    let part = program(folder.path(), "part.nc", "O1\nG90\nG0 X10. Y10.\nG1 X20. F500.\nM30\n");
    let mill = ["--machine", "fanuc-mill", &part];
    let (first, of) = job(&mill);
    let (second, of_first) = job(&mill);
    assert_eq!((of.as_str(), of_first.as_str()), ("", first.as_str()));
    assert!(call(&["status", &second]).contains(&format!("results of    {first}  20")));
    let note = format!("not run: results of equal job {} of 20", &first[..18]);
    for arguments in [&["wait", &second][..], &["watch", &second], &["result", &second, "report"]] {
        let output = counterpoint(&[arguments, &["--server", &url]].concat());
        let text = [output.stdout, output.stderr].concat();
        let text = String::from_utf8_lossy(&text);
        assert!(text.contains(&note) && text.contains(" UTC (submit --no-cache runs it)\n"), "{arguments:?}: {text}");
    }
    let rows = call(&["jobs", "--oldest", "--long"]);
    let reused = |job: &str| rows.lines().find(|row| row.contains(job)).unwrap().contains("  reused  ");
    assert_eq!((reused(&first), reused(&second)), (false, true), "{rows}");
    for kind in ["summary", "listing", "events", "toolpath"] {
        assert_eq!(call(&["result", &first, kind]), call(&["result", &second, kind]), "{kind}");
    }
    assert_eq!(job(&[&["--no-cache"], &mill[..]].concat()).1, "");
    call(&["delete", &first]);
    assert!(call(&["status", &second]).contains(" UTC (deleted)\n"));

    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/bar-part");
    let [pin, answers] = ["pin.nc", "answers.toml"].map(|name| example.join(name).display().to_string());
    let machine = folder.path().join("starter");
    std::fs::create_dir(&machine).unwrap();
    let text = "extends = \"fanuc-mill\"\n[ce]\nname = \"starter\"\n[macros]\nprogram_startup = \"start.mac\"\n";
    program(&machine, "machine.toml", text);
    program(&machine, "start.mac", "SYSTEM/'true'\n");
    let starter = machine.display().to_string();
    for outside in [&["--machine", "tern-bar-lathe", "--answers", &answers, &pin][..], &["--machine", &starter, &part]]
    {
        assert_eq!((job(outside).1, job(outside).1), (String::new(), String::new()), "{outside:?}");
    }
}

/// A script that repeats a submit learns that the job is not new. The status of a failed job names the command for its
/// errors.
#[test]
fn a_repeated_submit_says_so_and_a_failed_job_names_the_command_that_shows_its_errors() {
    let folder = tempfile::tempdir().unwrap();
    let (_runtime, url) = server(folder.path());
    let call = |arguments: &[&str]| {
        let output = counterpoint(&[arguments, &["--server", &url]].concat());
        let text = String::from_utf8_lossy(&output.stdout).trim_end().to_owned();
        (code(&output), text, String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let failing = program(folder.path(), "part.nc", "G21 G90 G0 X10.\nG1 X20. F100.\nG1 X#9 Y[1/0]\nM30\n");
    let submit = ["submit", &failing, "--machine", "fanuc-mill", "--request-id", "once"];
    let (status, job, talk) = call(&submit);
    assert!(status == 0 && !talk.contains("before"), "{talk}");
    let (status, same, talk) = call(&submit);
    assert!(status == 0 && same == job && talk.contains("accepted this request id before"), "{same} {talk}");
    let (_, json, _) = call(&[&submit[..], &["--json"]].concat());
    assert_eq!(json, serde_json::json!({ "job": job, "duplicate": true }).to_string());
    let (status, _, talk) = call(&["wait", &job]);
    let shown = format!("counterpoint result {job} report");
    assert!(status == 1 && talk.contains("FAILED") && talk.contains(&format!("errors: {shown}\n")), "{talk}");
    assert!(call(&["status", &job]).1.contains(&format!("errors        {shown}")));
    assert!(call(&["result", &job, "report"]).1.contains("part.nc:3"));
}

/// Each command that takes a job takes the beginning of its id, and none acts on an ambiguous one.
#[test]
fn jobs_are_named_by_the_beginning_of_their_ids() {
    let folder = tempfile::tempdir().unwrap();
    let (_runtime, url) = server(folder.path());
    let call = |arguments: &[&str]| {
        let output = counterpoint(&[arguments, &["--server", &url]].concat());
        let text = String::from_utf8_lossy(&output.stdout).trim_end().to_owned();
        (code(&output), text, String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let done = |arguments: &[&str]| {
        let (status, out, talk) = call(arguments);
        assert_eq!(status, 0, "{arguments:?}: {out} {talk}");
        out
    };
    let part = program(folder.path(), "part.nc", "O1\nG0 X1.\nM30\n");
    let submit = |label: &str| done(&["submit", &part, "--machine", "fanuc-mill", "--label", label]);
    let jobs: Vec<String> = ["bracket 17", "flange", "order=4711"].iter().map(|label| submit(label)).collect();
    jobs.iter().for_each(|job| drop(done(&["wait", job])));
    // The newest first, with labels; the short id of each names it and nothing else.
    let list = done(&["jobs"]);
    let rows: Vec<&str> = list.lines().collect();
    assert!(rows[0].contains("job") && rows[0].contains("submitted UTC") && rows[0].contains("labels"), "{list}");
    assert!(rows[1].contains("order=4711") && rows[3].contains("bracket 17"), "{list}");
    assert!(done(&["jobs", "--oldest", "--long"]).lines().nth(1).unwrap().contains(&jobs[0]));
    assert!(done(&["jobs", "--label", "flange"]).lines().count() == 2);
    let short = |row: &str| row.split_whitespace().next().unwrap().to_owned();
    for (row, job) in rows[1..].iter().zip(jobs.iter().rev()) {
        let short = short(row);
        assert!(short.len() >= 8 && short.len() < job.len() && job.starts_with(&short), "{short} {job}");
        assert!(done(&["status", &short]).contains(job), "{short}");
        assert!(done(&["status", &short.to_uppercase().replace('-', "")]).contains("SUCCEEDED"));
        for command in [&["wait", &short][..], &["watch", &short], &["result", &short, "summary"], &["analyse", &short]]
        {
            done(command);
        }
        for command in ["cancel", "pause", "resume"] {
            let (status, _, talk) = call(&[command, &short]);
            assert!(status == 0 && talk.contains(&format!("{job} has already ended: SUCCEEDED")), "{command}: {talk}");
        }
    }
    assert_eq!(done(&["status", &jobs[0], "--json"]).matches("bracket 17").count(), 1);
    // Four hexadecimal digits are those of a year.
    let (status, _, talk) = call(&["delete", &jobs[0][..4]]);
    assert!(status == 2 && talk.contains("several jobs begin with"), "{talk}");
    assert!(jobs.iter().all(|job| talk.contains(job.as_str())) && talk.contains("bracket 17"), "{talk}");
    for (name, words) in
        [(&jobs[0][..3], "too short"), ("ffffffff", "no job begins with 'ffffffff'"), ("", "UNKNOWN_JOB")]
    {
        let (status, _, talk) = call(&["status", name]);
        assert!(status == 2 && talk.contains(words), "{name}: {talk}");
    }
    let again = done(&["rerun", &short(rows[1])]);
    done(&["wait", &again]);
    // A job submitted later may have the same beginning.
    let list = done(&["jobs"]);
    let row = list.lines().skip(1).find(|row| jobs[2].starts_with(&short(row))).unwrap();
    done(&["delete", &short(row)]);
    let (status, _, talk) = call(&["status", &jobs[2]]);
    assert!(status == 2 && talk.contains("UNKNOWN_JOB"), "{talk}");
    assert!(
        done(&["jobs", "--label", "order=4711"])
            .contains(&short(done(&["jobs", "--limit", "1"]).lines().nth(1).unwrap()))
    );
}

/// Components in folders inside that of a composite machine, and beside it, here and on a server.
#[test]
fn a_composite_machine_has_components_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("own");
    let at = own.display().to_string();
    assert_eq!(code(&counterpoint(&["machine", "new", &at, "--from", "composite-millturn"])), 0);
    let check = || {
        let output = counterpoint(&["machine", "check", &at]);
        (code(&output), String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned())
    };
    assert_eq!(check().0, 0, "{}", check().1);
    let turning = own.join("fanuc-turning/machine.toml");
    let text = std::fs::read_to_string(&turning).unwrap();
    assert!(text.contains("Component TURN"), "{text}");
    // A word that only the turning component has.
    std::fs::write(&turning, format!("{text}\n[[codes]]\nid = \"CODE_DELAY\"\nword = \"G704\"\n")).unwrap();
    assert_eq!(check().0, 0, "{}", check().1);
    let upper = program(folder.path(), "upper.nc", "O1\nG704 U2.5\nM30\n");
    let ends = |output: Output| {
        let text = String::from_utf8_lossy(&[output.stdout.as_slice(), &output.stderr].concat()).into_owned();
        (code(&output), text.contains("2900320"), text)
    };
    let (shipped, unknown, text) = ends(counterpoint(&["run", "--machine", "composite-millturn", &upper]));
    assert!(shipped == 1 && unknown, "{text}");
    let (mine, unknown, text) = ends(counterpoint(&["run", "--machine", &at, &upper]));
    assert!(mine == 0 && !unknown && text.contains("00:02.500"), "{text}");
    let (_runtime, url) = server(folder.path());
    let job = counterpoint(&["submit", "--machine", &at, &upper, "--server", &url]);
    let job = String::from_utf8_lossy(&job.stdout).trim().to_owned();
    assert_eq!(code(&counterpoint(&["wait", &job, "--server", &url])), 0);
    // Settings of a run reach the component.
    let counted = program(folder.path(), "counted.nc", "O1\nG704 U2.5\nG0 X100 Z1000\nM30\n");
    let (ended, _, text) =
        ends(counterpoint(&["run", "--json", "--set", "numbers=increments", "--machine", &at, &counted]));
    let summary: serde_json::Value = serde_json::from_str(text.lines().next().unwrap()).unwrap();
    let time = summary["makespan_ns"].as_i64().unwrap();
    // Z from 600 mm to 1 mm, not to 1000 mm: 599 mm at 500 mm/s and 5000 mm/s² take 1.298 s.
    assert_eq!((ended, time), (0, 3_798_000_000), "{text}");
    // Mistakes are reported with file and line.
    std::fs::write(&turning, "extends = \"fanuc-turning\"\n[control]\nnumbers = \"bananas\"\n").unwrap();
    let (status, told) = check();
    assert!(status == 2 && told.contains("own/fanuc-turning/machine.toml:3:"), "{told}");
    std::fs::write(&turning, "extends = \"fanuc-turnip\"\n").unwrap();
    let (status, told) = check();
    assert!(
        status == 2 && told.contains("own/fanuc-turning/machine.toml:1:") && told.contains("fanuc-turnip"),
        "{told}"
    );
    std::fs::remove_file(&turning).unwrap();
    // A component beside the machine, and invalid names.
    let definition = std::fs::read_to_string(own.join("machine.toml")).unwrap();
    let with = |machine: &str| {
        let row = format!("\n[[components]]\ndesignator = \"TURN\"\nmachine = \"{machine}\"\nchannels = [1, 2]\n");
        std::fs::write(own.join("machine.toml"), format!("{definition}{row}")).unwrap();
        check()
    };
    let beside = folder.path().join("our-turning");
    std::fs::create_dir(&beside).unwrap();
    std::fs::write(beside.join("machine.toml"), "extends = \"fanuc-turning\"\n").unwrap();
    let (status, told) = with("our-turning");
    assert_eq!(status, 0, "{told}");
    let line = std::fs::read_to_string(own.join("machine.toml")).unwrap().lines().count() - 1;
    let (status, told) = with("../our-turning");
    assert!(status == 2 && told.contains(&format!("own/machine.toml:{line}:")), "{line}: {told}");
    assert!(told.contains("is not the name of a folder"), "{told}");
    let (status, told) = with("our-turnings");
    assert!(status == 2 && told.contains(&format!("own/machine.toml:{line}:")), "{told}");
    assert!(told.contains("no machine of the name \"our-turnings\""), "{told}");
}

#[test]
fn exit_codes_of_the_emulated_system() {
    let folder = tempfile::tempdir().unwrap();
    let run = |program: &str, more: &[&str]| {
        let machine = if more.contains(&"--machine") { &[][..] } else { &["--machine", "fanuc-mill"] };
        let arguments = [&["run", "--exit-code", "severity", "-q", program], machine, more].concat();
        code(&counterpoint(&arguments))
    };
    let clean = program(folder.path(), "clean.nc", "O1\nG0 X1.\nM30\n");
    let warns = program(folder.path(), "warns.nc", "O1\nG0 X1.\n");
    let fails = program(folder.path(), "fails.nc", "O1\nG1 X1.\nM30\n");
    let loops = program(folder.path(), "loops.nc", "O1\nN1 GOTO 1\n");
    let empty = program(folder.path(), "empty.nc", "\n");
    assert_eq!(run(&clean, &[]), 0);
    assert_eq!(run(&warns, &[]), 4);
    assert_eq!(run(&fails, &[]), 8);
    assert_eq!(run(&loops, &["--max-blocks", "50"]), 16);
    // A verdict alone is fatal.
    let waits = program(folder.path(), "waits.nc", "O1\nM101 P12\nM30\n");
    assert_eq!(run(&waits, &["--machine", "fanuc-2path-lathe"]), 16);
    assert_eq!(run(&clean, &["--no-such-flag"]), 100);
    assert_eq!(run(&clean, &["--trace", "Q"]), 100, "no letter of a trace");
    let missing = folder.path().join("missing.toml").display().to_string();
    assert_eq!(run(&clean, &["--answers", &missing]), 105);
    assert_eq!(run(&clean, &["--out", &clean]), 106, "a file where a folder should be");
    assert_eq!(run("no-such-file.nc", &[]), 200);
    assert_eq!(run(&empty, &[]), 200);
    assert_eq!(run(&clean, &["--machine", "no-such-machine"]), 201);
}

#[test]
fn qualifiers_of_a_run() {
    let folder = tempfile::tempdir().unwrap();
    let machine = folder.path().join("asks");
    std::fs::create_dir_all(&machine).unwrap();
    let text = "extends = \"fanuc-mill\"\n[ce]\nname = \"asks\"\n[format]\nopskip = { mark = \"/\", default = 2 }\n\
        [macros]\nprogram_startup = \"say.mac\"\n";
    program(&machine, "machine.toml", text);
    program(&machine, "say.mac", "PPRINT/'user !(*)',$UPARAM\n");
    let machine = machine.display().to_string();
    let path = program(folder.path(), "part.nc", "O1\n/G4 P100\n/1 G4 P200\nM30\n");
    let run = |more: &[&str]| {
        let out = tempfile::tempdir().unwrap();
        let at = out.path().display().to_string();
        let mut arguments = vec!["run", "-q", &path, "--machine", &machine, "--out", &at];
        arguments.extend(more);
        assert_eq!(code(&counterpoint(&arguments)), 0, "{more:?}");
        let read = |name: &str| std::fs::read_to_string(out.path().join(name)).unwrap_or_default();
        let summary: serde_json::Value = serde_json::from_str(&read("summary.json")).unwrap();
        (summary["makespan_ns"].clone(), read("part.lce"), read("part.log"), read("1.trace"))
    };
    let (time, listing, log, trace) = run(&["--param", "SHIFT=2", "--trace", "S"]);
    assert_eq!(time, 300_000_000);
    assert!(listing.contains("\n\nUPARAM:       SHIFT=2\n\n") && trace.contains("user SHIFT=2"), "{listing}{trace}");
    assert_eq!(log, "");
    let (time, listing, log, _) = run(&["--nolist", "--opskip", "on"]);
    assert_eq!(time, 200_000_000, "level 2 is on");
    assert!(listing.is_empty() && log.contains("CE:"), "{log}");
    let (time, listing, log, trace) = run(&["--ef", "--opskip", "1,2", "--trace"]);
    assert_eq!(time, 0);
    assert!(!listing.is_empty() && log.contains("CE:"), "{log}");
    assert!(trace.contains("DelOn"), "{trace}");
    let refused = counterpoint(&["run", &path, "--opskip", "10"]);
    assert_eq!(code(&refused), 2);
}

#[test]
fn machines_can_be_listed_shown_checked_and_come_from_a_folder() {
    let output = counterpoint(&["machine", "list"]);
    assert!(String::from_utf8_lossy(&output.stdout).contains("fanuc-mill"));
    let output = counterpoint(&["machine", "show", "fanuc-mill", "axes", "--json"]);
    let shown: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(shown["axes"].is_array() && shown.get("codes").is_none());
    let output = counterpoint(&["machine", "show", "fanuc-mill", "groups"]);
    assert!(String::from_utf8_lossy(&output.stdout).contains("active at start"));
    assert_eq!(code(&counterpoint(&["machine", "check", "fanuc-2path-lathe"])), 0);
    let folder = tempfile::tempdir().unwrap();
    let mine = folder.path().join("mine");
    std::fs::create_dir(&mine).unwrap();
    std::fs::write(mine.join("machine.toml"), "nonsense = [").unwrap();
    let output = counterpoint(&["machine", "check", &mine.display().to_string()]);
    assert_eq!(code(&output), 2);
    assert!(String::from_utf8_lossy(&output.stderr).contains("mine/machine.toml:1:"));
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../machines/fanuc-mill");
    let path = program(folder.path(), "part.nc", "O1\nG0 X1.\nM30\n");
    let output = counterpoint(&["run", "-q", "--machine", &shipped.display().to_string(), &path]);
    assert_eq!(code(&output), 0, "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn a_machine_of_ones_own_begins_as_a_shipped_one() {
    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("our-lathe").display().to_string();
    let new = |from: &str, to: &str| counterpoint(&["machine", "new", to, "--from", from]);
    assert_eq!(code(&new("fanuc-lathe", &own)), 0);
    assert_eq!(code(&counterpoint(&["machine", "check", &own])), 0);
    let path = program(folder.path(), "part.nc", "O1\nG0 X50. Z2.\nG1 Z-10. F.2 S500 M3\nM30\n");
    let end = |machine: &str| {
        let output = counterpoint(&["run", "--json", "--machine", machine, &path]);
        let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        (code(&output), summary["makespan_ns"].clone())
    };
    assert_eq!(end(&own), end("fanuc-lathe"));
    let refused = |output: std::process::Output, words: &str| {
        let status = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(code(&output) == 2 && status.contains(words), "{status}");
    };
    refused(new("fanuc-lathe", &own), "exists already");
    refused(new("fanuc-late", &format!("{own}-2")), "did you mean fanuc-lathe?");
    refused(new("fanuc-lathe", &folder.path().join("fanuc-mill").display().to_string()), "is a shipped machine");
    refused(new("fanuc-lathe", &folder.path().join("a b").display().to_string()), "letters, digits");
}

#[test]
fn a_closed_pipe_is_no_panic() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_counterpoint"));
    let mut child = command
        .args(["machine", "show", "fanuc-2path-lathe"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((code(&output), output.stderr.as_slice()), (0, &b""[..]));
}

/// Runs with lines on standard input.
fn answering(arguments: &[&str], lines: &str) -> Output {
    use std::io::Write as _;
    let mut command = Command::new(env!("CARGO_BIN_EXE_counterpoint"));
    let command = command.args(arguments).env_remove("COUNTERPOINT_SERVER");
    let mut child =
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
    child.stdin.take().unwrap().write_all(lines.as_bytes()).unwrap();
    child.wait_with_output().unwrap()
}

/// `-` is standard input for every command that takes a program, under a name of its own or of `--name`.
#[test]
fn a_program_comes_from_standard_input() {
    let folder = tempfile::tempdir().unwrap();
    let (one, two) = ("O1\nG0 X10. Z5.\nM101 P12\nQ7\nM30\n", "O2\nG0 X10. Z5.\nM101 P12\nM30\n");
    let upper = program(folder.path(), "upper.nc", one);
    let told = |arguments: &[&str], input: &str| {
        let output = answering(arguments, input);
        (code(&output), String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned())
    };
    let out = folder.path().join("out").display().to_string();
    let (ended, text) = told(&["run", "-", &program(folder.path(), "lower.nc", two), "--out", &out], one);
    assert!(ended == 1 && text.contains("channel 1 <standard input>:4: Q7"), "{text}");
    assert!(Path::new(&out).join("stdin.1.lce").is_file());
    let (ended, text) = told(&["run", &upper, "-", "--name", "lower.nc", "--quiet"], two);
    assert!(ended == 1 && text.contains("upper.nc:4: Q7") && !text.contains("blocks"), "{text}");
    let (ended, text) = told(&["run", "--no-timeline", "--", "-#1", "-#2"], &format!("{one}{two}"));
    assert!(ended == 1 && text.contains("<standard input>#2  ENDED"), "{text}");
    let (ended, text) = told(&["lint", "-", "--machine", "fanuc-mill", "--name", "part.nc"], "O1\nG0 X1.\nM30\n");
    assert!(ended == 0 && text.contains("1 MAIN   part.nc"), "{text}");
    // Guess, encoding and checks are those of files.
    let (ended, text) = told(&["run", "-", "--name", "a.mpf"], "G1 X10 F100\nM30\n");
    assert!(ended == 2 && text.contains("the file ending .mpf (a.mpf)"), "{text}");
    let (ended, text) =
        told(&["run", "-", "--encoding", "shift_jis", "--machine", "fanuc-mill"], "O1\n(\u{fffd})\nM30\n");
    assert!(ended == 2 && text.contains("'<standard input>' has bytes that are not characters"), "{text}");
    let measured = program(folder.path(), "lines.csv", "line,seconds\n2,1.5\n");
    let calibrate = ["calibrate", "--machine", "fanuc-mill", "--measured", &measured, "-"];
    let (ended, text) = told(&calibrate, "O1\nG0 X100.\nM30\n");
    assert!(ended == 2 && text.contains("rapid of X") && text.contains("determine no datum"), "{text}");
    let summary = answering(&["run", "--json", "--machine", "fanuc-mill", "-"], "O1\nG0 X100.\nM30\n");
    let (ended, text) = told(&["analyse", "-"], &String::from_utf8_lossy(&summary.stdout));
    assert!(ended == 0 && text.starts_with("cycle time 00:0"), "{text}");
    for (arguments, words) in [
        (&["run", "-", "-"][..], "standard input (-) can be read only once"),
        (&["run", "-"], "'<standard input>' is empty"),
        (&["run", "-", "--step"], "--step and --attend read standard input"),
        (&["run", &upper, "-", "--name", "upper.nc"], "--name upper.nc: another program has this name"),
        (&["run", &upper, "--name", "x.nc"], "no program is -"),
        (&["run", "-", "--name", "a/x.nc"], "without folders"),
        (&["run", &upper, "--tools", "-"], "--tools needs a file"),
        (&["run", &upper, "--with", "-"], "--with needs a file"),
        (&["run", &upper, "--answers", "-"], "--answers needs a file"),
        (&["calibrate", "--machine", "fanuc-mill", "--measured", "-", &upper], "--measured needs a file"),
        (&["analyse", "-"], "'<standard input>' is not the summary of a job"),
        (&["macro", "check", "-", "-"], "can be read only once"),
        (&["macro", "fmt", "-", "-"], "can be read only once"),
    ] {
        let (ended, text) = told(arguments, "");
        assert!(ended == 2 && text.contains(words), "{arguments:?}: {ended} {text}");
    }
    let (ended, text) = told(&["macro", "check", "-"], "X=\n");
    assert!(ended == 1 && text.contains("--> <standard input>:1:"), "{text}");
    let (ended, text) = told(&["macro", "run", "-"], "PPRINT/'piped'\n");
    assert!(ended == 0 && text == "piped\n", "{text}");
}

#[test]
fn dialogs_are_answered_line_by_line() {
    let folder = tempfile::tempdir().unwrap();
    let machine = folder.path().join("asks");
    std::fs::create_dir(&machine).unwrap();
    let definition = r#"extends = "fanuc-mill"
[ce]
name = "asks"
[macros]
program_startup = "start.mac"
[[dialogs]]
name = "Clamp"
fields = [
  { label = "Force, kN", variable = "%G01", kind = "number", min = 1, max = 40, whole = true, default = 20 },
  { label = "Wet", variable = "%G02", kind = "check", default = false },
]
"#;
    std::fs::write(machine.join("machine.toml"), definition).unwrap();
    std::fs::write(machine.join("start.mac"), "%L01=$FDIALOG('Clamp')\nERROR/4,'!(*) !(*) !(*)',%L01,%G01,%G02\n")
        .unwrap();
    let path = program(folder.path(), "part.nc", "O1\nM30\n");
    let machine = machine.display().to_string();
    let run = ["run", "--json", "--machine", &machine, &path];
    let attended = ["run", "--json", "--attend", "--machine", &machine, &path];
    let texts = |output: &Output| {
        let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let texts = summary["diagnostics"].as_array().unwrap().iter();
        texts.map(|d| d["text"].as_str().unwrap().to_owned()).collect::<Vec<_>>().join("|")
    };
    assert!(texts(&counterpoint(&run)).contains("no answer for the dialog 'Clamp'"), "nobody attends");
    // Two lines that are refused at their field, then the values, then the button.
    let output = answering(&attended, "much\n99\n12\nyes\nok\n");
    let status = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(texts(&output).contains("OK 12"), "{} {status}", texts(&output));
    assert!(status.contains("'much' is not a valid number") && status.contains("must be 1 to 40, not 99"), "{status}");
    assert!(status.contains("Force, kN, 1 to 40, whole [20]:"), "{status}");
    let output = answering(&attended, "12\n");
    assert!(texts(&output).contains("the operator declined the dialog 'Clamp'"), "the end of the input declines");
}

#[test]
fn fields_that_take_no_value_are_not_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let machine = folder.path().join("decides");
    std::fs::create_dir(&machine).unwrap();
    let definition = r#"extends = "fanuc-mill"
[ce]
name = "decides"
[macros]
program_startup = "start.mac"
[[dialogs]]
name = "Wet"
fields = [
  { label = "Wet", variable = "%G02", kind = "check", default = false },
  { label = "Pressure", variable = "%G03", kind = "number", min = 1, max = 40, default = 20, when = "%G02" },
  { label = "Reason", variable = "%G04", kind = "text", default = "-", unless = "%G09" },
]
"#;
    std::fs::write(machine.join("machine.toml"), definition).unwrap();
    let start = "%G09=1\n%L01=$FDIALOG('Wet')\nERROR/4,'!(*) !(*)',%L01,%G03\n";
    std::fs::write(machine.join("start.mac"), start).unwrap();
    let path = program(folder.path(), "part.nc", "O1\nM30\n");
    let attended = ["run", "--json", "--attend", "--machine", &machine.display().to_string(), &path];
    for (lines, asked, text) in [("no\nok\n", false, "OK 0"), ("yes\n7\nok\n", true, "OK 7")] {
        let output = answering(&attended, lines);
        let status = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!((status.contains("Pressure"), status.contains("Reason")), (asked, false), "{status}");
        let summary = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(summary.contains(text), "{status} {summary}");
    }
}

/// Files that are not programs in UTF-8: UTF-16 without a mark in both orders, a code page by name, and a warning
/// otherwise.
#[test]
fn programs_are_read_in_their_encoding() {
    let folder = tempfile::tempdir().unwrap();
    let text = "O1\nT1 M6\nG90 G54 G0 X0 Y0\nG43 H1 Z5.\nG1 Z-5. F200\nM30\n";
    for (name, unit) in [("be.nc", u16::to_be_bytes as fn(u16) -> [u8; 2]), ("le.nc", u16::to_le_bytes)] {
        let path = folder.path().join(name);
        std::fs::write(&path, text.encode_utf16().flat_map(unit).collect::<Vec<u8>>()).unwrap();
        let output = counterpoint(&["run", "--no-timeline", &path.display().to_string()]);
        let status = String::from_utf8_lossy(&output.stderr);
        assert!(code(&output) == 0 && status.contains("machine fanuc-mill, guessed"), "{name}: {status}");
    }
    let path = folder.path().join("paged.nc");
    std::fs::write(&path, b"O1\n(FR\xc4SER)\nT1 M6\nG43 H1 Z5.\nM30\n").unwrap();
    let path = path.display().to_string();
    let run = |more: &[&str]| {
        let output = counterpoint(&[&["run", "--no-timeline", &path], more].concat());
        (code(&output), String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned())
    };
    let (ended, told) = run(&[]);
    assert!(ended == 0 && told.contains("2900540") && told.contains("first in line 2"), "{told}");
    let (ended, told) = run(&["--encoding", "windows-1252"]);
    assert!(ended == 0 && !told.contains("2900540"), "{told}");
    let (ended, told) = run(&["--encoding", "utf-8"]);
    assert!(ended == 2 && told.contains("not characters of the code page"), "{told}");
    let (ended, told) = run(&["--encoding", "ebcdic"]);
    assert!(ended == 2 && told.contains("unknown code page 'ebcdic'"), "{told}");
}

#[test]
fn plain_mistakes_are_told_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let part = program(folder.path(), "part.nc", "O1\nG21\nG50 S2500\nT0101\nG96 S200 M3\nG0 X52. Z2.\nM30\n");
    let told = |output: &Output| String::from_utf8_lossy(&output.stderr).into_owned();
    // Programs that never wait for each other are two jobs.
    let output = counterpoint(&["run", &part, &part]);
    assert!(code(&output) == 2 && told(&output).contains("never wait for each other"), "{}", told(&output));
    let output = counterpoint(&["analyse", "nodir"]);
    assert!(code(&output) != 0 && told(&output).contains("there is no file or folder 'nodir'"), "{}", told(&output));
    let help = counterpoint(&["run", "--help"]);
    assert!(String::from_utf8_lossy(&help.stdout).contains("numbers=increments"));
    // The definition in a folder means the folder.
    let own = folder.path().join("mine");
    std::fs::create_dir(&own).unwrap();
    let definition = program(&own, "machine.toml", "extends = \"fanuc-lathe\"\n[ce]\nname = \"mine\"\n");
    let output = counterpoint(&["run", "--no-timeline", "--machine", &definition, &part]);
    assert_eq!(code(&output), 0, "{}", told(&output));
    let table = program(folder.path(), "tools.csv", "Tool,Beschreibung,Radius\n1,CNMG,0.8\n");
    let output = counterpoint(&["run", "--no-timeline", "--tools", &table, &part]);
    assert!(code(&output) == 2 && told(&output).contains("column 'Beschreibung'"), "{}", told(&output));
    // No datum of the machine says how long a move at feed takes.
    let mill = program(folder.path(), "mill.nc", "O1\nT1 M6\nG43 H1 Z5.\nG1 Z-1. F300\nX130. F600\nM30\n");
    let measured = program(folder.path(), "lines.csv", "line,seconds\n4,2.5\n5,4.0\n");
    let output = counterpoint(&["calibrate", "--machine", "fanuc-mill", "--measured", &measured, &mill]);
    assert!(!told(&output).contains("panicked"), "{}", told(&output));
}

#[test]
fn a_command_for_many_jobs_asks_for_a_job_or_a_filter() {
    for command in ["cancel", "delete"] {
        for more in [&[][..], &["--yes"], &["--dry-run"]] {
            let output = counterpoint(&[&[command], more].concat());
            let text = String::from_utf8_lossy(&output.stderr);
            assert_eq!(code(&output), 2, "{text}");
            for way in ["JOB", "--state", "--machine", "--label", "--since", "--all"] {
                assert!(text.contains(way), "{command} {more:?} does not name {way}: {text}");
            }
        }
    }
}

#[test]
fn the_help_of_submit_says_how_requests_of_each_program_are_numbered() {
    let output = counterpoint(&["submit", "--help"]);
    let help = String::from_utf8_lossy(&output.stdout).split_whitespace().collect::<Vec<_>>().join(" ");
    let (_, each) = help.split_once("--each ").unwrap();
    assert!(each.contains("--request-id ID") && each.contains("ID-1, ID-2"), "{each}");
}

#[test]
fn each_program_becomes_a_job_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let (_runtime, url) = server(folder.path());
    let one = program(folder.path(), "one.nc", "O1\nG0 X1.\nM30\n");
    let other = program(folder.path(), "other.nc", "O2\nG0 X2.\nM30\n");
    let absent = folder.path().join("absent.nc").display().to_string();
    let with = ["--machine", "fanuc-mill", "--request-id", "night", "--server", &url];
    let each = |programs: &[&str], more: &[&str]| {
        let output = counterpoint(&[&["submit", "--each"][..], programs, &with, more].concat());
        let out = String::from_utf8_lossy(&output.stdout).into_owned();
        (code(&output), out, String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (status, out, talk) = each(&[&one, &absent, &other], &[]);
    assert_eq!(status, 2, "{talk}");
    assert!(talk.contains(&format!("{absent}: not submitted")) && talk.contains("does not exist"), "{talk}");
    let jobs: Vec<&str> = out.lines().collect();
    assert_eq!(jobs.len(), 2, "{out}");
    // A repeat with the same id finds the same jobs.
    let (status, lines, talk) = each(&[&one, &absent, &other], &["--json"]);
    assert_eq!(status, 2, "{talk}");
    let lines: Vec<serde_json::Value> = lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let (refused, lines): (Vec<_>, Vec<_>) = lines.into_iter().partition(|line| line.get("error").is_some());
    assert_eq!((refused.len(), &refused[0]["program"]), (1, &absent.as_str().into()));
    let pairs = [(jobs[0], &one), (jobs[1], &other)];
    for (line, (job, program)) in lines.iter().zip(pairs) {
        assert_eq!((&line["job"], &line["program"]), (&job.into(), &program.as_str().into()));
    }
    for job in jobs {
        let output = counterpoint(&["wait", job, "--server", &url]);
        assert_eq!(code(&output), 0, "{}", String::from_utf8_lossy(&output.stderr));
    }
    let output = counterpoint(&["jobs", "--server", &url, "--json"]);
    assert_eq!(String::from_utf8_lossy(&output.stdout).lines().count(), 2);
}
