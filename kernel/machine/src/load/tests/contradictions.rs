//! Machine files in which every key is right by itself and which contradict themselves.

use super::*;

/// Findings of [`BASE`] with text after it, beside files of macros; those in the macros have their own lines.
fn with_macros(text: &str) -> Vec<String> {
    let mut files = MemoryFiles::default();
    files.insert("m/machine.toml", format!("{BASE}{text}"));
    files.insert("m/a.mac", "%G01=1");
    files.insert("m/exec.mac", "EXEC/NOW,CODE_STOP,REG_TOOL,5\nEXEC/REG_AXIS_X\nEXEC/CODE_RAPID,REG_AXIS_X,CODE_RAPID");
    files.insert("m/arguments.mac", "%L1=$P4\n$P4=3\n$P7=1\n%L2=$P7+$P6");
    files.insert("m/dialog.mac", "%L1=$FDIALOG('setup')\n%L1=$FDIALOG('other')");
    files.insert("m/declare.mac", "DECLAR/GLOBAL,REAL,FOOD=1");
    let skip = BASE.lines().count() as u32;
    let show = |finding: &Finding| {
        let kind = if finding.error { "error" } else { "warning" };
        let line = if finding.file.ends_with("machine.toml") { finding.line - skip } else { finding.line };
        let file = finding.file.trim_start_matches("m/").trim_start_matches("machine.toml");
        format!("{file}{}{line}:{}: {kind}: {}", if file.is_empty() { "" } else { ":" }, finding.column, finding.text)
    };
    load(&files, "m").findings.iter().map(show).collect()
}

#[test]
fn words_texts_and_codes() {
    let one = |text: &str| after(text).join("\n");
    assert_eq!(
        one("[[codes]]\nid = \"CODE_STOP\"\nword = \"M3\""),
        "1:1: warning: M3 overlaps the row at m/machine.toml:24, whose order 300 is less than 900, so that this one \
         never acts"
    );
    assert_eq!(
        one("[[codes]]\nid = \"CODE_STOP\"\ntext = \"HALT\"\n[[codes]]\nid = \"CODE_END\"\ntext = \"HALT\""),
        "4:1: warning: 'HALT' overlaps the row at m/machine.toml:39, which has the same order 900 and comes first"
    );
    assert_eq!(
        one("[[codes]]\nid = \"CODE_MINE\"\ncustom = true\nword = \"M77\""),
        "1:1: warning: CODE_MINE is a code of your own and no macro takes it: each use is an error (2900002); a row of \
         [[macros.code]], or `process = false` to swallow it, is expected"
    );
    assert_eq!(
        one("[[codes]]\nid = \"CODE_STOP\"\nword = \"M0\"\nwith = [\"M\"]"),
        "4:8: warning: the row's own register is on every block that it could match: this says nothing"
    );
    assert_eq!(
        one("[[codes]]\nid = \"CODE_STOP\"\nword = \"M0\"\nwithout = [\"M\"]"),
        "4:11: error: the row's own register is on every block that it could match: the row never matches"
    );
}

#[test]
fn characters_with_two_meanings() {
    for (text, expected) in [
        ("eob = \"/\"\nopskip = { mark = \"/\" }", "2:7: error: the character that ends blocks is the mark of"),
        ("comment = [\"/\", \"\"]\nopskip = { mark = \"/\" }", "3:10: error: '/' begins a `comment` too, it cannot be"),
        ("opskip = { mark = \"X\" }", "2:10: error: 'X' is part of words, it cannot be the mark of optional skip"),
        ("eob = \"7\"", "2:7: error: '7' is part of words, it cannot be the character that ends blocks"),
        ("comment = [\"G\", \")\"]", "2:11: error: \"G\" begins words, it cannot begin a `comment`"),
    ] {
        let findings = after(&format!("[format]\n{text}"));
        assert!(findings.len() == 1 && findings[0].starts_with(expected), "{expected}: {findings:#?}");
    }
}

#[test]
fn macros_that_never_run_and_what_they_use() {
    let cases: &[(&str, &[&str])] = &[
        (
            "[[macros.code]]\nmatch = [\"CODE_RAPID\"]\nabsent = [\"CODE_RAPID\"]\nfile = \"a.mac\"",
            &["3:10: error: what fires the macro counts as present: it never runs"],
        ),
        (
            "[[macros.data]]\nmatch = [\"REG_TOOL\"]\nfile = \"a.mac\"",
            &["2:10: warning: no row of this machine's data table has REG_TOOL, so it is never on a block"],
        ),
        (
            "[[codes]]\nid = \"CODE_TOOL_SELECT\"\nword = \"M61-M69\"\nas_data = \"REG_TOOL\"\n[[macros.data]]\nmatch = [\"REG_TOOL\"]\n\
             file = \"a.mac\"",
            &[],
        ),
        (
            "[[codes]]\nid = \"CODE_STOP\"\nword = \"M0\"\nprocess = false\n[[macros.code]]\nmatch = [\"CODE_STOP\"]\n\
             file = \"a.mac\"",
            &[
                "6:10: warning: the rows of CODE_STOP say `process = false`: it is taken off the block and fires nothing",
            ],
        ),
        (
            "[[macros.code]]\nmatch = [\"CODE_RAPID\"]\nfile = \"exec.mac\"",
            &[
                "exec.mac:2:6: error: EXEC needs a value after REG_AXIS_X: REG_AXIS_X,value",
                "exec.mac:3:17: error: EXEC needs a value after REG_AXIS_X: REG_AXIS_X,value",
            ],
        ),
        (
            "[macros]\nblock_startup = \"arguments.mac\"",
            &["arguments.mac:4:9: warning: $P6 has no value here: a Block Startup Macro has $P1 to $P3"],
        ),
        (
            "[macros]\ndiagnostic = \"arguments.mac\"",
            &["arguments.mac:4:9: warning: $P6 has no value here: a Diagnostic Event Macro has $P1 to $P5"],
        ),
    ];
    for (text, expected) in cases {
        assert_eq!(with_macros(text), *expected, "{text}");
    }
}

#[test]
fn dialogs_and_their_variables() {
    let dialog = |fields: &str| {
        let macros = "[macros]\ndeclaration = \"declare.mac\"\nprogram_startup = \"dialog.mac\"";
        with_macros(&format!("{macros}\n[[dialogs]]\nname = \"Set up\"\n{fields}"))
    };
    let other = "dialog.mac:2:5: error: this machine has no dialog 'other'; [[dialogs]] with this name is expected";
    let fields = "fields = [{ kind = \"check\", variable = \"FOOD\" }, \
                  { kind = \"text\", variable = \"%G01\", when = \"food\" }]";
    assert_eq!(dialog(fields), [other]);
    let fields = "fields = [{ kind = \"check\", variable = \"FOD\" }, \
                  { kind = \"text\", variable = \"$XYZ\", unless = \"FEDE\" }]";
    let findings = dialog(fields);
    for expected in
        [other, "6:40: error: no macro declares FOD; a", "error: no macro declares $XYZ; a GLOBAL", "FEDE; a variable"]
    {
        assert!(findings.iter().any(|finding| finding.contains(expected)), "{expected}: {findings:#?}");
    }
    let buttons =
        after("[[dialogs]]\nname = \"A\"\nbuttons = [{ label = \"OK\" }, { label = \"ok\", type = \"cancel\" }]");
    assert_eq!(buttons, ["3:11: error: two buttons have the label \"ok\", the result of the dialog"]);
}

#[test]
fn stops_of_rotary_axes() {
    let found = after("[[axes]]\nname = \"C9\"\nrole = \"rotary\"\n[stops]\nat = { C9 = 90 }");
    assert!(
        found.iter().any(|finding| finding.contains("axis C9 is rotary: only linear axes meet stops")),
        "{found:#?}"
    );
}
