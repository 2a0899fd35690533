//! `explain` on a machine, and the views of machines: sorted, filtered, compared, tried.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)]

use std::io::Write as _;
use std::process::{Command, Output, Stdio};

use serde_json::Value;

fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_counterpoint"));
    command.args(arguments).env_remove("COUNTERPOINT_SERVER");
    command
}

fn counterpoint(arguments: &[&str]) -> (i32, String, String) {
    told(command(arguments).stdin(Stdio::null()).output().unwrap())
}

fn told(output: Output) -> (i32, String, String) {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
}

fn explained(word: &str, machine: &str) -> (i32, Value) {
    let (code, out, err) = counterpoint(&["explain", word, "--machine", machine, "--json"]);
    (code, serde_json::from_str(&out).unwrap_or_else(|error| panic!("{word}: {error}: {out}{err}")))
}

#[test]
fn a_code_is_explained_with_all_that_the_machine_says_of_it() {
    let (code, value) = explained("G76", "haas-lathe");
    let row = &value["words"][0]["codes"][0];
    assert_eq!((code, row["id"].as_str()), (0, Some("CODE_THREAD_MULTI")), "{value}");
    assert_eq!(value["extends"][0], "haas-lathe");
    assert_eq!(row["meaning"], "threading cycle, all passes");
    // Haas lathe: X and Z are the end, K the height, D the first cut, F the lead.
    let reads: Vec<_> = row["reads"].as_array().unwrap().iter().map(|row| row["register"].as_str().unwrap()).collect();
    for letter in ["X", "Z", "K", "D", "F"] {
        assert!(reads.contains(&letter), "{letter} in {reads:?}");
    }
    let family = row["file"].as_str().unwrap().split('/').next().unwrap();
    assert!(row["line"].as_u64() > Some(0) && value["extends"].as_array().unwrap().iter().any(|one| one == family));
    let (_, text, _) = counterpoint(&["explain", "G76", "--machine", "haas-lathe"]);
    for part in ["CODE_THREAD_MULTI: threading cycle", "words that it reads", "machine.toml:", "refuses"] {
        assert!(text.contains(part), "{part} in {text}");
    }
}

#[test]
fn words_behind_a_code_are_those_that_it_reads() {
    let (code, out, _) = counterpoint(&["explain", "M98", "P", "--machine", "fanuc-mill"]);
    assert_eq!(code, 0, "{out}");
    let p = out.split("\nP on fanuc-mill").nth(1).expect("P");
    assert!(p.contains("REG_CALSUB_ID") && !p.contains("REG_DELAY"), "{out}");
    let (_, alone, _) = counterpoint(&["explain", "P", "--machine", "fanuc-mill"]);
    assert!(alone.contains("REG_CALSUB_ID") && alone.contains("REG_DELAY"), "{alone}");
}

#[test]
fn variables_programs_statements_and_macros_are_explained() {
    let (code, value) = explained("#5021", "haas-lathe");
    let variable = &value["words"][0]["variable"];
    assert_eq!((code, variable["write"].as_bool()), (0, Some(false)), "{value}");
    assert!(variable["means"].as_str().unwrap().contains("frame of the machine, axis 1"), "{value}");
    let (_, value) = explained("CYCLE83", "siemens-mill");
    let program = &value["words"][0]["programs"][0];
    assert!(program["path"].as_str().unwrap().ends_with("cycle83.spf"), "{value}");
    assert!(program["head"].as_str().unwrap().starts_with("PROC CYCLE83(REAL RTP"), "{value}");
    for (word, machine, page) in [
        ("SETMS", "siemens-mill", "docs/preprocessors.md"),
        ("VDIN", "okuma-lathe", "docs/coverage/okuma.md"),
        ("CYCL DEF 200", "heidenhain-mill", "docs/preprocessors.md"),
    ] {
        let (code, value) = explained(word, machine);
        let pages = value["words"][0]["pages"].as_array().unwrap_or_else(|| panic!("{value}"));
        assert!(code == 0 && pages.iter().any(|row| row["page"] == page), "{word}: {value}");
    }
    // T of the Okuma lathe is a macro.
    let (_, value) = explained("T", "okuma-lathe");
    let text = value.to_string();
    assert!(text.contains("CODE_OKUMA_TOOL") || text.contains("REG_"), "{value}");
}

/// The number of the alarm is the value that a stored program writes to #3000, plus the base of the control.
#[test]
fn an_alarm_of_a_stored_program_is_explained_with_its_comment() {
    for (number, machine, comment) in
        [("3180", "mitsubishi-mill", "NO DRILLING CYCLE"), ("1012", "haas-mill", "G12 AND G13 NEED A RADIUS I")]
    {
        let (code, value) = explained(number, machine);
        assert_eq!((code, &value["words"][0]["alarms"][0]["about"]), (0, &comment.into()), "{value}");
        let (_, text, _) = counterpoint(&["explain", number, "--machine", machine]);
        assert!(text.contains(&format!("): {comment}\n")) && text.contains("alarm of a program stored"), "{text}");
    }
    assert_eq!(explained("3999", "mitsubishi-mill").0, 2, "no program raises it");
}

#[test]
fn a_diagnostic_and_an_alarm_are_explained_for_the_machine() {
    let (code, value) = explained("PS0217", "fanuc-lathe");
    let found = &value["words"][0]["diagnostic"];
    assert_eq!(code, 0);
    assert_eq!(found["refusals"][0]["codes"][0], "CODE_POLYGON_ON", "{value}");
    let (_, value) = explained("no-feed", "fanuc-mill");
    assert_eq!(value["words"][0]["diagnostic"]["rule"]["number"], 2_019_001, "{value}");
}

#[test]
fn an_unknown_word_says_what_happens_and_who_has_it() {
    let (code, value) = explained("G411", "fanuc-mill");
    let unknown = &value["words"][0]["unknown"];
    assert_eq!(code, 2, "{value}");
    assert!(unknown["diagnostics"][0]["text"].as_str().unwrap().contains("PS0010"), "{value}");
    let (code, out, _) = counterpoint(&["explain", "G154", "--machine", "fanuc-mill"]);
    assert_eq!(code, 2);
    assert!(out.contains("machines that have it") && out.contains("haas-mill"), "{out}");
    let (code, out, _) = counterpoint(&["explain", "PLANE RESET STAI", "--machine", "heidenhain-mill"]);
    assert!(code == 2 && out.contains("did you mean PLANE RESET STAY?"), "{out}");
    let (code, out, _) = counterpoint(&["explain", "G76"]);
    assert!(code == 0 && out.contains("CODE_THREAD_MULTI") && out.contains("haas-lathe"), "{out}");
    let (code, _, err) = counterpoint(&["explain", "G76", "--machine", "haas-lath"]);
    assert!(code == 2 && err.contains("did you mean haas-lathe?"), "{err}");
    assert_eq!(counterpoint(&["explain", "QWERTZUIOP"]).0, 2);
}

#[test]
fn rows_are_sorted_and_filtered() {
    let (code, out, _) = counterpoint(&["machine", "show", "fanuc-mill", "codes", "--sort", "order"]);
    assert_eq!(code, 0);
    let order = |line: &str| line.split_whitespace().nth(2).and_then(|cell| cell.parse::<u32>().ok());
    let orders: Vec<u32> = out.lines().skip(1).filter_map(order).collect();
    assert!(orders.len() > 50 && orders.is_sorted(), "{orders:?}");
    let (_, out, _) = counterpoint(&["machine", "show", "fanuc-mill", "codes", "--filter", "code_cycle_deep"]);
    assert!(out.lines().count() > 1 && out.lines().skip(1).all(|line| line.contains("CODE_CYCLE_DEEP")), "{out}");
    let (_, out, _) = counterpoint(&["machine", "show", "fanuc-mill", "codes", "--filter", "G83", "--json"]);
    let value: Value = serde_json::from_str(&out).unwrap();
    assert!(value["codes"].as_array().unwrap().iter().all(|row| row.to_string().contains("G83")), "{out}");
    let (code, _, err) = counterpoint(&["machine", "show", "fanuc-mill", "codes", "--sort", "ordre"]);
    assert!(code == 2 && err.contains("did you mean order?"), "{err}");
    let (_, out, _) = counterpoint(&["machine", "show", "fanuc-mill", "undefined"]);
    let listed = |id: &str| out.lines().any(|line| line.split(' ').next() == Some(id));
    assert!(listed("CODE_TURN_ROUGH") && listed("REG_TURN_TYPE"), "{out}");
    assert!(!listed("CODE_RAPID") && !listed("REG_AXIS_X"), "{out}");
}

#[test]
fn what_a_machine_changes_is_shown_with_both_values() {
    let folder = tempfile::tempdir().unwrap();
    let mine = folder.path().join("mine");
    std::fs::create_dir(&mine).unwrap();
    let text = "extends = \"fanuc-lathe\"\n[ce]\nname = \"mine\"\n[time]\nstations = 8\nblock_time = 0.004\n\
                [[codes]]\nid = \"CODE_IGNORE\"\nword = \"M77\"\n";
    std::fs::write(mine.join("machine.toml"), text).unwrap();
    let mine = mine.display().to_string();
    let (code, out, err) = counterpoint(&["machine", "show", &mine, "--changed"]);
    assert_eq!(code, 0, "{err}");
    for part in [
        "- 12  [fanuc-lathe/machine.toml:",
        "+ 8  [mine/machine.toml:5]",
        "(default)",
        "+ id = \"CODE_IGNORE\", word = \"M77\"",
    ] {
        assert!(out.contains(part), "{part} in {out}");
    }
    assert!(!out.contains("tool_change"), "{out}");
    let (_, json, _) = counterpoint(&["machine", "diff", "fanuc-lathe", &mine, "--json"]);
    let value: Value = serde_json::from_str(&json).unwrap();
    assert_eq!((value["a"].as_str(), value["b"].as_str()), (Some("fanuc-lathe"), Some("mine")));
    let time = value["rows"].as_array().unwrap().iter().find(|row| row["section"] == "time").unwrap();
    assert_eq!((time["keys"][0]["a"].as_str(), time["keys"][0]["b"].as_str()), (Some("12"), Some("8")), "{json}");
    let (code, out, _) = counterpoint(&["machine", "diff", "fanuc-mill", "fanuc-mill"]);
    assert_eq!((code, out.as_str()), (0, "fanuc-mill and fanuc-mill are the same\n"));
    assert_eq!(counterpoint(&["machine", "diff", "fanuc-mill", "nothing"]).0, 2);
}

#[test]
fn the_tape_editor_is_tried_on_lines() {
    let folder = tempfile::tempdir().unwrap();
    let mine = folder.path().join("mine");
    std::fs::create_dir(&mine).unwrap();
    let text = "extends = \"fanuc-mill\"\n[ce]\nname = \"mine\"\n[[tape_editor]]\nfind = \"M66\"\nreplace = \"M6\"\n\
                [[tape_editor]]\nfind = \"M6\"\nreplace = \"M06\"\n";
    std::fs::write(mine.join("machine.toml"), text).unwrap();
    let mine = mine.display().to_string();
    let (code, out, _) = counterpoint(&["machine", "edit", &mine, "T1 M66"]);
    let expected = "T1 M66\n  rule 1 \"M66\" -> \"M6\"  [mine/machine.toml:4]\nT1 M6\n\
                    \u{20} rule 2 \"M6\" -> \"M06\"  [mine/machine.toml:7]\nT1 M06\n";
    assert_eq!((code, out.as_str()), (0, expected));
    let mut child = command(&["machine", "edit", &mine, "-", "--json"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(b"G0 X1\r\nM6\n").unwrap();
    let value: Value = serde_json::from_slice(&child.wait_with_output().unwrap().stdout).unwrap();
    assert_eq!((value[0]["line"].as_str(), value[1]["steps"][0]["rule"].as_u64()), (Some("G0 X1"), Some(2)), "{value}");
    assert_eq!(value.as_array().map(Vec::len), Some(2));
    let (code, _, err) = counterpoint(&["machine", "edit", "fanuc-mill", "M6"]);
    assert!(code == 2 && err.contains("no rules of the tape editor"), "{err}");
}

#[test]
fn words_that_the_control_takes_without_a_row_are_explained() {
    for (word, machine, says) in [
        ("R10", "siemens-mill", "variable of the control: a block 'R10=1' is accepted"),
        ("NLAP", "okuma-lathe", "name of the control: a block 'NLAP' is accepted"),
        ("WHILE", "fanuc-mill", "WHILE […] DO n … END n"),
        ("IF", "fanuc-lathe", "one statement if the condition is true"),
        ("GOTO", "haas-mill", "continues at sequence number n"),
        ("/", "fanuc-mill", "block skip"),
        ("%", "fanuc-mill", "rewind-stop"),
        ("TOOL CALL", "heidenhain-mill", "TOOLCALL"),
    ] {
        let (code, out, err) = counterpoint(&["explain", word, "--machine", machine]);
        assert!(code == 0 && out.contains(says) && !out.contains("word of macros"), "{word}: {out}{err}");
    }
    // An unknown code is not taken for a variable of the same letters.
    assert_eq!(counterpoint(&["explain", "M999", "--machine", "okuma-lathe"]).0, 2);
    assert_eq!(counterpoint(&["explain", "FOO", "--machine", "siemens-mill"]).0, 2);
    for empty in [vec!["explain", ""], vec!["explain", " ", "--machine", "fanuc-mill"]] {
        let (code, out, err) = counterpoint(&empty);
        assert!(code == 2 && out.is_empty() && err.contains("give a word"), "{out}{err}");
    }
}

#[test]
fn without_a_machine_all_shipped_machines_are_asked() {
    for (word, machine) in [
        ("WAITM", "siemens-2channel"),
        ("#5021", "fanuc-mill"),
        ("M98 P", "fanuc-mill"),
        ("TOOL CALL", "heidenhain-mill"),
    ] {
        let (code, out, err) = counterpoint(&["explain", word]);
        assert!(code == 0 && out.contains(machine), "{word}: {out}{err}");
    }
}

/// A machine based on the composite machine, whose milling component has a word of its own.
fn composite(folder: &std::path::Path) -> String {
    let own = folder.join("own");
    let at = own.display().to_string();
    assert_eq!(counterpoint(&["machine", "new", &at, "--from", "composite-millturn"]).0, 0);
    let milling = own.join("fanuc-milling/machine.toml");
    let rules =
        "\n[[codes]]\nid = \"CODE_IGNORE\"\nword = \"M777\"\n\n[[tape_editor]]\nfind = \"Q\"\nreplace = \"R\"\n";
    let text = std::fs::read_to_string(&milling).unwrap();
    std::fs::write(&milling, format!("{text}{rules}")).unwrap();
    at
}

#[test]
fn every_component_of_a_composite_machine_is_shown_compared_and_explained() {
    let folder = tempfile::tempdir().unwrap();
    let own = composite(folder.path());
    assert_eq!(counterpoint(&["machine", "check", &own]), (0, format!("{own}: usable, 0 findings\n"), String::new()));
    let (code, out, _) = counterpoint(&["explain", "M777", "--machine", &own]);
    assert_eq!(code, 0, "{out}");
    for part in ["MILL: M777 on own (own/fanuc-milling, ", "CODE_IGNORE", "component TURN of own does not have M777"] {
        assert!(out.contains(part), "{part} in {out}");
    }
    // Both components have M91; only the milling component has G81, though a page of the control names it.
    let of = |word: &str| {
        let (code, value) = explained(word, &own);
        let words = value["words"].as_array().unwrap().clone();
        let row = |word: &Value| (word["component"].as_str().unwrap_or("-").to_owned(), word["known"] == true);
        (code, words.iter().map(row).collect::<Vec<_>>())
    };
    let (turn, mill) = ("TURN".to_owned(), "MILL".to_owned());
    assert_eq!(of("M91"), (0, vec![(turn.clone(), true), (mill.clone(), true)]));
    assert_eq!(of("G81"), (0, vec![(mill.clone(), true), (turn.clone(), false)]));
    assert_eq!(of("M778"), (2, vec![("-".to_owned(), false)]));
    let (_, out, _) = counterpoint(&["explain", "G81"]);
    assert!(out.contains("composite-millturn"), "{out}");
    // Tables name the component of each row, and so does JSON.
    let (_, out, _) = counterpoint(&["machine", "show", &own, "codes", "--filter", "M777"]);
    assert!(out.lines().count() == 2 && out.contains("\nMILL       M777 "), "{out}");
    let (_, out, _) = counterpoint(&["machine", "show", &own, "codes", "--filter", "M777", "--json"]);
    let value: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(
        (&value["codes"][0]["component"], value["codes"].as_array().unwrap().len()),
        (&"MILL".into(), 1),
        "{out}"
    );
    let (_, out, _) = counterpoint(&["machine", "show", &own, "undefined", "--filter", "drilling cycle"]);
    assert!(out.contains("TURN") && !out.contains("MILL"), "{out}");
    // The differences from the family are those from the shipped machine.
    for arguments in [["machine", "show", &own, "--changed"], ["machine", "diff", "composite-millturn", &own]] {
        let (_, out, _) = counterpoint(&arguments);
        assert!(out.contains("MILL: codes\n  + id = \"CODE_IGNORE\", word = \"M777\""), "{out}");
        assert!(!out.contains("TURN") && !out.contains("MILL: ce\n"), "{out}");
    }
    let (_, out, _) = counterpoint(&["machine", "show", "composite-millturn", "--changed"]);
    assert!(out.contains("TURN: codes") && !out.contains("TURN: format"), "{out}");
    // The tape editor of each component.
    let (_, out, _) = counterpoint(&["machine", "edit", &own, "G83 Q2"]);
    assert!(out.contains("TURN: G83 Q2\n  no rule changes it\nMILL: G83 Q2\n") && out.contains("\nG83 R2\n"), "{out}");
}

#[test]
fn a_code_of_another_component_is_named_with_the_word_that_selects_it() {
    let folder = tempfile::tempdir().unwrap();
    let own = composite(folder.path());
    let program = folder.path().join("part.nc");
    std::fs::write(&program, "O1\nM777\nM30\n").unwrap();
    let (code, out, _) = counterpoint(&["run", "--machine", &own, &program.display().to_string()]);
    assert_eq!(code, 1, "{out}");
    for part in ["component TURN of machine own has no M777 (component MILL has it)", "program M91 before the block"] {
        assert!(out.contains(part), "{part} in {out}");
    }
}

#[test]
fn changes_are_limited_to_a_part_filtered_and_sorted() {
    let (code, out, _) = counterpoint(&["machine", "show", "fanuc-mill-5axis", "codes", "--changed", "--sort", "word"]);
    assert!(code == 0 && out.contains("codes\n") && !out.contains("axes\n"), "{out}");
    let words: Vec<&str> = out.lines().filter_map(|line| line.split("word = \"").nth(1)).collect();
    assert!(words.len() > 2 && words.iter().map(|word| word.len()).all(|length| length > 1), "{out}");
    let (code, out, _) = counterpoint(&["machine", "show", "fanuc-mill-5axis", "--changed", "--filter", "kinematics"]);
    assert!(code == 0 && out.contains("kinematics") && !out.contains("codes\n"), "{out}");
    let (code, out, err) = counterpoint(&["machine", "show", "fanuc-mill", "--changed", "--filter", "xyzzy"]);
    assert_eq!((code, out.as_str(), err.as_str()), (1, "", "--filter: no row has 'xyzzy'\n"));
    let (code, out, err) = counterpoint(&["machine", "show", "fanuc-mill", "--filter", "xyzzy"]);
    assert_eq!((code, out.as_str(), err.as_str()), (1, "", "--filter: no row has 'xyzzy'\n"));
    let (code, out, _) = counterpoint(&["machine", "show", "fanuc-mill", "codes", "--filter", "xyzzy", "--json"]);
    assert_eq!((code, serde_json::from_str::<Value>(&out).unwrap()["codes"].as_array().map(Vec::len)), (1, Some(0)));
    let (code, _, err) = counterpoint(&["machine", "show", "fanuc-mill", "--sort", "foo"]);
    assert!(code == 2 && err.contains("columns are channel, name") && err.matches("spindle,").count() == 1, "{err}");
    let (code, _, err) = counterpoint(&["machine", "show", "fanuc-mill", "--changed", "--sort", "foo"]);
    assert!(code == 2 && err.contains("no column 'foo'") && err.contains("file"), "{err}");
}

#[test]
fn a_code_lists_the_words_that_it_reads_on_this_machine() {
    let reads = |word: &str, machine: &str| {
        let (_, value) = explained(word, machine);
        let rows = value["words"][0]["codes"][0]["reads"].as_array().unwrap().clone();
        let row =
            |row: &Value| (row["register"].as_str().unwrap_or("-").to_owned(), row["id"].as_str().unwrap().to_owned());
        rows.iter().map(row).collect::<Vec<_>>()
    };
    let has = |rows: &[(String, String)], letter: &str| rows.iter().any(|(own, _)| own == letter);
    // A tap has steps and a dwell, but neither the shift I, J of boring nor the rotary axes of other mills.
    let tap = reads("G84", "fanuc-mill");
    assert!(has(&tap, "Q") && has(&tap, "P") && has(&tap, "R"), "{tap:?}");
    assert!(!has(&tap, "I") && !has(&tap, "J") && !has(&tap, "A") && !has(&tap, "B"), "{tap:?}");
    assert!(!tap.iter().any(|(_, id)| id == "REG_CYCLE_BOTTOM" || id.starts_with("REG_CYCLE_BORE")), "{tap:?}");
    let bore = reads("G76", "fanuc-mill");
    assert!(bore.contains(&("Q".to_owned(), "REG_CYCLE_BORE_JOG".to_owned())), "{bore:?}");
    assert!(has(&reads("G1", "fanuc-mill-4axis"), "A") && !has(&reads("G1", "fanuc-lathe"), "Y"));
    // G10 has no data rows of its own; G65 has no data rows at all.
    let set = reads("G10", "fanuc-mill");
    assert!(["L", "P", "R", "X"].iter().all(|letter| has(&set, letter)), "{set:?}");
    let (_, value) = explained("G65", "fanuc-mill");
    let words = value["words"][0]["words"].as_array().unwrap();
    let of = |letter: &str| words.iter().find(|row| row["word"] == letter).map(|row| row["meaning"].as_str().unwrap());
    assert_eq!((of("D"), of("Z")), (Some("argument, local variable #7"), Some("argument, local variable #26")));
    // The two blocks of G76 of Fanuc lathes: P and Q have two meanings.
    let (_, value) = explained("G76", "fanuc-lathe");
    let rows = value["words"][0]["codes"][0]["reads"].as_array().unwrap().clone();
    let block = |register: &str, id: &str| {
        let row = rows.iter().find(|row| row["register"] == register && row["id"] == id).unwrap();
        row["block"].as_str().unwrap_or("-").to_owned()
    };
    assert_eq!(block("P", "REG_THREAD_MULTI_PWORD"), "without X and Z");
    assert_eq!(block("P", "REG_THREAD_MULTI_HEIGHT_X"), "with X or Z");
    assert_eq!(block("Q", "REG_THREAD_MULTI_STEP_MIN"), "without X and Z");
}

#[test]
fn explanations_say_what_a_reader_needs() {
    let text = |words: &[&str], machine: &str| {
        let (_, out, _) = counterpoint(&[&["explain"], words, &["--machine", machine]].concat());
        out
    };
    for (words, machine, parts) in [
        (
            &["T0101"][..],
            "fanuc-lathe",
            &["the last 2 digits are the number of the offset: T0203 is tool 2 with offset 3"][..],
        ),
        (&["T"], "fanuc-mill", &["  T0-T99999999  CODE_TOOL_SELECT"]),
        (&["TOOL", "CALL"], "heidenhain-mill", &["  TOOL CALL 0 to 32767  CODE_TOOL_LOAD"]),
        (&["CYCL", "DEF", "200"], "heidenhain-mill", &["//ICAMFS/200.h:1", "Drilling", "reads Q200", "Q202"]),
        (&["G12"], "haas-mill", &["calls O99000012", "//ICAMFS/O99000012.nc:1"]),
        (&["#500"], "haas-mill", &["; programs may set it"]),
        (&["#5021"], "haas-mill", &["; read only"]),
        (&["G187"], "haas-mill", &["CODE_IGNORE: ignored by the machine"]),
    ] {
        let out = text(words, machine);
        assert!(parts.iter().all(|part| out.contains(part)), "{parts:?} in {out}");
    }
    // After M98 only the refusals of M98 are listed, not those of P beside G8 or G10.
    let out = text(&["M98", "P"], "fanuc-mill");
    assert!(!out.contains("P of G8") && !out.contains("G10 has a value"), "{out}");
    let out = text(&["P"], "fanuc-mill");
    assert!(out.contains("P of G8 is 0 or 1") && out.contains("no decimal point"), "{out}");
}

#[test]
fn an_empty_address_in_the_environment_counts_as_absent() {
    let call = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_counterpoint"));
        let output = command.args(arguments).env("COUNTERPOINT_SERVER", "").output().unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (code, text) = call(&["machine", "list"]);
    assert_eq!(code, Some(0), "{text}");
    let (code, text) = call(&["status", "01938f2c-5d1e"]);
    // No server listens there, or one that does not know the job.
    assert!(code == Some(3) && text.contains("http://127.0.0.1:7878") || code == Some(2), "{text}");
    assert!(!text.contains("COUNTERPOINT_SERVER=") && !text.contains("invalid"), "{text}");
    let (code, text) = call(&["status", "01938f2c-5d1e", "--server", "http://127.0.0.1:1"]);
    assert!(code == Some(3) && text.contains("http://127.0.0.1:1"), "{text}");
}
