//! Rules for diagnostics from rows and from a file.

use super::*;

fn with_file(file: &str, text: &str) -> Loaded {
    let mut files = MemoryFiles::default();
    files.insert("m/machine.toml", format!("diagnostics_file = \"own.err\"\nmin_severity = 1\n{BASE}{text}"));
    files.insert("m/own.err", file);
    load(&files, "m")
}

#[test]
fn a_file_and_rows_over_it() {
    let file = "! own texts\n\\ 2001005 9 Not in the table:\n   !(*)\n\\ -2900006 4\n\\ 2990001 4 half\\\nway\n";
    let loaded = with_file(file, "[[diagnostics]]\nnumber = 2900006\nrepeat = 2\n");
    assert_eq!(loaded.findings, []);
    let table = loaded.machine.unwrap().diagnostics;
    assert_eq!(table.min_severity, 1);
    let rule = |number| table.rule(number).unwrap();
    assert_eq!(rule(2_001_005).severity, Some(9));
    assert_eq!(rule(2_001_005).text.as_deref(), Some("Not in the table: !(*)"));
    assert_eq!((rule(2_900_006).enable, rule(2_900_006).repeat), (true, Some(2)));
    assert_eq!(rule(2_990_001).text.as_deref(), Some("halfway"));
}

#[test]
fn mistakes_name_their_line() {
    let loaded = with_file("\\ abc 4 text\n\\ -2900042 12\n", "");
    let shown: Vec<String> = loaded.findings.iter().map(ToString::to_string).collect();
    assert_eq!(shown[0], "m/own.err:1:1: error: expected `\\ number severity text`");
    assert_eq!(
        shown[1],
        "m/own.err:2:1: error: 02900042 is an alarm that stops the channel, it cannot be switched off"
    );
    let own = after("[[diagnostics]]\nnumber = 2990007\n");
    assert_eq!(own, ["2:10: error: 02990007 is a number of your own, it needs `severity` and `text`"]);
}
