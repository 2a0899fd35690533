//! `counterpoint macro` as a user sees it.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)]

use std::io::{BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::{Command, Output, Stdio};

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_counterpoint"));
    command.arg("macro").args(arguments).current_dir(folder).stdin(Stdio::null());
    command
}

/// Exit code, standard output, standard error.
fn counterpoint(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    shown(&command(folder, arguments).output().unwrap())
}

fn shown(output: &Output) -> (i32, String, String) {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).replace("\r\n", "\n");
    (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
}

fn typed(folder: &Path, arguments: &[&str], input: &str) -> (i32, String, String) {
    let mut command = command(folder, arguments);
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    child.stdin.take().unwrap().write_all(input.as_bytes()).unwrap();
    shown(&child.wait_with_output().unwrap())
}

fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

const TWICE: (&str, &str) = ("twice.mac", "MACRO/REAL,TWICE(REAL,V)\nTWICE=2*V\nENDMAC\n");

#[test]
fn check_finds_everything_in_every_file() {
    let files =
        [("a.mac", "A=CODE_RAPDI\n$XM=3\nB=UNSET\n"), ("b.mac", "PPRINT/'x'+1\n"), ("good.mac", "A=TWICE(1)\n"), TWICE];
    let folder = folder(&files);
    let (code, out, status) = counterpoint(folder.path(), &["check", "a.mac", "b.mac", "good.mac", "twice.mac"]);
    assert_eq!((code, out.as_str()), (1, "files: 4, errors: 3, warnings: 1\n"));
    let expected = "Error 02910032: unknown identifier CODE_RAPDI\n  --> a.mac:1:3\n    1 | A=CODE_RAPDI\n      \
                    |   ^^^^^^^^^^\n      = did you mean CODE_RAPID?\n";
    assert!(status.starts_with(expected), "{status}");
    for part in ["Error 02910024", "Warning 02910027", "  --> b.mac:1:12\n"] {
        assert!(status.contains(part), "{part}: {status}");
    }
    assert_eq!(counterpoint(folder.path(), &["check", "good.mac", "twice.mac"]).0, 0);
    assert_eq!(counterpoint(folder.path(), &["check", "none.mac"]).0, 2);
    assert_eq!(counterpoint(folder.path(), &["check"]).0, 2);
}

#[test]
fn check_prints_json() {
    let folder = folder(&[("a.mac", "A=CODE_RAPDI\nB=UNSET\n"), TWICE]);
    let (code, out, status) = counterpoint(folder.path(), &["check", "--json", "a.mac", "twice.mac"]);
    assert_eq!((code, status.as_str()), (1, ""));
    let document: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!((&document["errors"], &document["warnings"]), (&1.into(), &1.into()));
    let finding = &document["files"][0]["findings"][0];
    let expected = serde_json::json!({
        "file": "a.mac", "line": 1, "column": 3, "width": 10, "number": "02910032", "severity": 8, "type": "error",
        "name": "unknown-identifier",
        "text": "unknown identifier CODE_RAPDI", "help": "did you mean CODE_RAPID?", "source": "A=CODE_RAPDI",
    });
    assert_eq!(finding, &expected);
    assert_eq!(document["files"][1]["findings"], serde_json::json!([]));
}

#[test]
fn strong_declaration_is_asked_for() {
    let folder =
        folder(&[("m.mac", "DECLAR/GLOBAL,REAL,TOP=1\nZDEEP=TOP\n"), ("use.mac", "DECLAR/A=TOP\nPPRINT/'!(*)',A\n")]);
    let code = |arguments: &[&str]| counterpoint(folder.path(), arguments).0;
    assert_eq!(code(&["check", "m.mac"]), 0);
    let (_, out, status) = counterpoint(folder.path(), &["check", "--strong", "partial", "m.mac"]);
    assert!(out.contains("errors: 1,") && status.contains("02910026") && status.contains("m.mac:1:1"), "{out}{status}");
    let (_, out, _) = counterpoint(folder.path(), &["check", "--strong", "full", "m.mac"]);
    assert!(out.contains("errors: 2,"), "{out}");
    assert_eq!(code(&["check", "--strong", "partial", "m.mac", "use.mac"]), 0, "files before the last declare");
    assert_eq!(code(&["run", "--strong", "partial", "m.mac"]), 1);
    assert_eq!(code(&["check", "--strong", "some", "m.mac"]), 2);
}

#[test]
fn fmt_rewrites_in_place_only_what_changes() {
    let folder = folder(&[("a.mac", "if/a==1\r\n$$ why\r\npprint/'x'\r\nendof/if\r\n"), TWICE, ("bad.mac", "A=(1\n")]);
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let before = (read("a.mac"), read("twice.mac"));
    let (code, out, _) = counterpoint(folder.path(), &["fmt", "--check", "a.mac", "twice.mac"]);
    assert_eq!((code, out.as_str()), (1, "a.mac\n"));
    let (code, out, _) = counterpoint(folder.path(), &["fmt", "--stdout", "--style", "c", "twice.mac"]);
    assert_eq!((code, out.as_str()), (0, "macro/real,twice(real,v)\ntwice=2*v\nendmac\n"));
    assert_eq!((read("a.mac"), read("twice.mac")), before);
    let old = std::fs::metadata(folder.path().join("twice.mac")).unwrap().modified().unwrap();
    assert_eq!(counterpoint(folder.path(), &["fmt", "a.mac", "twice.mac"]).0, 0);
    assert_eq!(read("a.mac"), "IF/A.EQ.1\r\n  $$ why\r\n  PPRINT/'x'\r\nENDOF/IF\r\n");
    assert_eq!(std::fs::metadata(folder.path().join("twice.mac")).unwrap().modified().unwrap(), old);
    assert_eq!(counterpoint(folder.path(), &["fmt", "--check", "a.mac"]), (0, String::new(), String::new()));
    let (code, _, status) = counterpoint(folder.path(), &["fmt", "bad.mac"]);
    assert!(code == 1 && status.contains("bad.mac:1:5") && read("bad.mac") == "A=(1\n", "{status}");
    let names: Vec<_> = std::fs::read_dir(folder.path()).unwrap().collect();
    assert_eq!(names.len(), 3, "nothing is left behind");
}

#[test]
fn fmt_reads_standard_input_and_refuses_other_encodings() {
    let folder = folder(&[]);
    assert_eq!(typed(folder.path(), &["fmt", "-"], "a=1\n"), (0, "A=1\n".into(), String::new()));
    assert_eq!(typed(folder.path(), &["fmt", "--check", "-"], "a=1\n").0, 1);
    std::fs::write(folder.path().join("latin.mac"), b"A='\xE4'\n").unwrap();
    assert_eq!(counterpoint(folder.path(), &["fmt", "latin.mac"]).0, 2);
    assert_eq!(std::fs::read(folder.path().join("latin.mac")).unwrap(), b"A='\xE4'\n");
}

#[test]
fn run_prints_what_the_last_file_prints_and_nothing_else() {
    let main = "PPRINT/'!(*)',TWICE(4)\nERROR/4,'look'\nOPEN/20,'STDOUT'\nWRITE/20,'console'\n";
    let folder = folder(&[TWICE, ("main.mac", main), ("stop.mac", "PPRINT/'a'\nERROR/8,'bad'\nPPRINT/'b'\n")]);
    let (code, out, status) = counterpoint(folder.path(), &["run", "twice.mac", "main.mac"]);
    assert_eq!((code, out.as_str()), (0, "8\n"));
    assert!(status.starts_with("Warning 02910090: look\n  --> main.mac:2:1 in main.mac\n"), "{status}");
    assert!(status.ends_with("console\n"), "{status}");
    let (code, out, status) = counterpoint(folder.path(), &["run", "stop.mac"]);
    assert_eq!((code, out.as_str()), (1, "a\n"));
    assert!(status.contains("Error 02910090: bad"), "{status}");
    let (code, out, _) = counterpoint(folder.path(), &["run", "main.mac"]);
    assert_eq!((code, out.as_str()), (1, ""), "TWICE is not there");
}

#[test]
fn the_trace_stands_between_what_is_printed() {
    let main = "a=twice(1) $$ two\nif/a.gt.2\npprint/'no'\nelse\npprint/'!(*)',a\nendof/if\n";
    let folder = folder(&[TWICE, ("main.mac", main)]);
    let (code, out, status) = counterpoint(folder.path(), &["run", "--trace", "twice.mac", "main.mac"]);
    let expected = [
        " Macro:* Entering main.mac",
        " Macro:  A=TWICE(1)",
        " Macro:* Entering TWICE",
        " Macro:  TWICE=2*V",
        " Macro:  ENDMAC",
        " Macro:* Leaving TWICE, Returning to main.mac",
        " Macro:  IF/A.GT.2",
        " Macro:  ELSE",
        " Macro:  PPRINT/'!(*)',A",
        "2",
        " Macro:  ENDOF/IF",
        " Macro:  ENDMAC",
        " Macro:* Leaving main.mac, Returning to regular processing",
    ];
    assert_eq!((code, out.lines().collect::<Vec<_>>()), (0, expected.to_vec()), "{status}");
}

#[test]
fn lines_come_as_they_are_printed_and_a_closed_pipe_ends_the_run() {
    let folder = folder(&[("loop.mac", "N=0\nAGAIN: N+=1\nPPRINT/'!(*)',N\nJUMPTO/AGAIN\n")]);
    let mut command = command(folder.path(), &["run", "--ticks", "1000000000000", "loop.mac"]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    // The macro never ends: the text read here was written while it runs.
    assert_eq!(lines.next().unwrap().unwrap(), "1");
    assert_eq!(lines.next().unwrap().unwrap(), "2");
    drop(lines);
    assert_eq!(shown(&child.wait_with_output().unwrap()), (0, String::new(), String::new()));
    let mut command = self::command(folder.path(), &["run", "--trace", "loop.mac"]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    assert_eq!(shown(&child.wait_with_output().unwrap()), (0, String::new(), String::new()));
}

#[test]
fn a_budget_ends_a_run() {
    let folder = folder(&[("loop.mac", "AGAIN: JUMPTO/AGAIN\n")]);
    let (code, _, status) = counterpoint(folder.path(), &["run", "--ticks", "1000", "loop.mac"]);
    assert!(code == 1 && status.contains("02910055"), "{status}");
    assert_eq!(counterpoint(folder.path(), &["run", "--ticks", "0", "loop.mac"]).0, 2);
}

#[test]
fn files_of_a_macro_stay_below_the_folder() {
    let text = "OPEN/20,'out.txt'\nWRITE/20,'X!(*)',1.5\nCLOSE/20\nPPRINT/'!(*) !(*)',$ERRNO,$FSTAT('out.txt','size')\n\
                OPEN/20,'../out.txt'\nPPRINT/'!(*)',$ERRNO\nOPEN/20,'link/secret'\nPPRINT/'!(*)',$ERRNO.GT.0\n\
                PPRINT/'!(*) !(*)',$FACCESS('../secret'),$FSETCWD('sub')\nOPEN/20,'in.txt'\nWRITE/20,'in'\nCLOSE/20\n";
    let outer = folder(&[("secret", "s\n")]);
    let inner = outer.path().join("inner");
    std::fs::create_dir_all(inner.join("sub")).unwrap();
    std::fs::write(inner.join("m.mac"), text).unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink(outer.path(), inner.join("link")).unwrap();
    let (code, out, status) = counterpoint(&inner, &["run", "m.mac"]);
    let expected = if cfg!(unix) { "0 5\n13\nTRUE\nFALSE sub\n" } else { "0 5\n13\nFALSE\nFALSE sub\n" };
    assert_eq!((code, out.as_str()), (0, expected), "{status}");
    assert_eq!(status.matches("Warning 02910067").count(), 2, "{status}");
    assert_eq!(std::fs::read_to_string(inner.join("out.txt")).unwrap(), "X1.5\n");
    assert_eq!(std::fs::read_to_string(inner.join("sub/in.txt")).unwrap(), "in\n");
    assert!(!outer.path().join("out.txt").exists());
}

#[test]
fn the_console_is_read_and_temporary_files_go_away() {
    let text = "OPEN/20,'STDIN'\nREAD/20,'!(*) !(A)',N,T\nPPRINT/'!(*) !(*)',N*2,T\nREAD/20,'!(A)',T\nPPRINT/'!(*)',$ERRNO\n\
                T=$FTMPFILE('m.mac')\nPPRINT/'!(*)',$FACCESS(T)\nPPRINT/'!(*)',$FLEN($DATE)\n";
    let folder = folder(&[("m.mac", text)]);
    let (code, out, status) = typed(folder.path(), &["run", "m.mac"], "6 holes\n");
    assert_eq!((code, out.as_str()), (0, "12 holes\n-1\nTRUE\n23\n"), "{status}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn explain_knows_numbers_and_names() {
    let folder = folder(&[]);
    let explained = |what: &str| counterpoint(folder.path(), &["explain", what]);
    let (code, out, _) = explained("2910011");
    assert!(code == 0 && out.starts_with("# 02910011 `unknown-command`: "), "{out}");
    assert_eq!(explained("unknown-command"), explained("2910011"));
    assert_eq!(explained("02910011"), explained("2910011"));
    assert_eq!(explained("$FSIN").1, "$FSIN(angle)\ngives: number\n\nSine of an angle in degrees.\n");
    assert_eq!(explained("fsin"), explained("$FSIN"));
    assert!(explained("DECLAR").1.starts_with("DECLAR/[GLOBAL"));
    let expected = "$OPSKIPL(1..9)\nLOGICAL, can be assigned (program)\n\nA block skip level is on.\n";
    assert_eq!(explained("$opskipl").1, expected);
    assert!(explained("CODE_RAPID").1.contains("modal group 1"));
    assert!(explained("CODE_DELAY").1.ends_with("Uses REG_DELAY.\n"));
    assert!(explained("data_tool").1.contains("Used by CODE_TOOL_LOAD, CODE_TOOL_SELECT.\n"));
    assert!(
        explained("PS0160")
            .1
            .starts_with("PS0160: waiting codes that do not match: 2900050\n\n# 02900050 `wait-mismatch`: ")
    );
    assert!(explained("ps0161").1.contains("# 02900051 `wait-illegal-channels`: "));
    assert_eq!(explained("wait_mismatch"), explained("wait-mismatch"));
    assert!(explained("nofed").2.contains("did you mean no-feed?"), "{:?}", explained("nofed"));
    assert!(explained("//").1.starts_with("//\nOperator"));
    assert!(explained(".and.").1.starts_with(".AND. &&\nOperator"));
    assert!(explained("!(s34)").1.contains("7.35 gives '73500'"));
    assert!(explained("\\<").1.contains("beginning and end of a word"));
    assert!(explained("THRU").1.contains("WHEN list"));
    let arguments = explained("$P1").1;
    assert!(
        arguments.contains("tool event: 1 tool selected") && arguments.contains("code macro: the code"),
        "{arguments}"
    );
    assert_eq!(explained("PS9999").0, 2);
    // Zeros and letters of an alarm may be left out.
    for short in ["160", "0160", "PS160", "P/S160", "ps0160"] {
        assert_eq!(explained(short), explained("PS0160"), "{short}");
    }
    for nothing in ["9999", "0", "M136", "G199", "F100", "O2102"] {
        assert_eq!(explained(nothing).0, 2, "{nothing}");
    }
    assert!(explained("Motion Event Macro").1.starts_with("Motion Event Macro\n`motion` of [macros]"));
    assert_eq!(explained("block_startup"), explained("Block Startup Macro"));
    assert!(explained("code macro").1.contains("$P1: the code, may be set\n"));
    assert!(explained("$FMSGPOS").1.contains("needs a machine model, and there is none here"));
    assert!(explained("$FPAUSE").1.contains("runs in the background"));
    assert!(!explained("$FMSGLCV").1.contains("2910070"));
    assert!(explained("$VMXFER").1.ends_with("Machine models are not emulated: only macros change this variable.\n"));
    assert!(explained("#{").1.contains("before the pre-processor"));
    assert!(explained("and").1.contains("`condition`"));
    assert!(explained("DATA_AXIS_X").1.starts_with("REG_AXIS_X\n"));
    assert!(explained("CODE_LINEAR").1.starts_with("CODE_INTERP_LINEAR\n"));
    assert_eq!(explained("$FSQTR"), (2, String::new(), "error: '$FSQTR' not found; did you mean $FSQRT?\n".into()));
    assert_eq!(explained("DECLARE").2, "error: 'DECLARE' not found; did you mean DECLAR?\n");
    assert_eq!(explained("99").0, 2);
}
