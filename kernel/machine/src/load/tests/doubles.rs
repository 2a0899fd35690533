//! Repeated rows, rows that cannot be written, and rows that never apply: correct by themselves, but useless in their
//! place.

use super::*;

/// Findings of [`BASE`] with text after it, beside a file of one macro and a file with a function.
fn with_macro(text: &str) -> Vec<String> {
    let mut files = MemoryFiles::default();
    files.insert("m/machine.toml", format!("{BASE}{text}"));
    files.insert("m/a.mac", "%G01=1");
    files.insert("m/f.mac", "MACRO/TWICE(N)\nTWICE=N*2\nENDMAC");
    shown(&load(&files, "m"), BASE.lines().count() as u32)
}

#[test]
fn seconds_of_one_m_number_are_given_once() {
    assert_eq!(
        after("[time]\nm_codes = { \"3\" = 1, \"03\" = 2, \"4\" = 1, \"0004\" = 1 }"),
        [
            "2:22: error: M3 already has its seconds at m/machine.toml:40 as \"3\"; one key for each M number is expected",
            "2:41: error: M4 already has its seconds at m/machine.toml:40 as \"4\"; one key for each M number is expected",
        ]
    );
    let family = "[time]\nm_codes = { \"3\" = 1 }\n";
    let mut files = MemoryFiles::default();
    files.insert("family/machine.toml", format!("{BASE}{family}"));
    files.insert("m/machine.toml", "extends = \"family\"\n[ce]\nname = \"m\"\n[time]\nm_codes = { \"03\" = 2 }");
    let findings = load(&files, "m").findings;
    assert_eq!(findings.len(), 1, "{findings:?}");
    assert!(findings[0].text.contains("M3 already has its seconds at family/machine.toml:40"), "{findings:?}");
}

#[test]
fn macros_have_names_of_their_own() {
    let row = |kind: &str, name: &str, of: &str| {
        format!("[[macros.{kind}]]\nname = \"{name}\"\nmatch = [\"{of}\"]\nfile = \"a.mac\"\n")
    };
    let (rapid, clw) = (row("code", "guard", "CODE_RAPID"), row("code", "guard", "CODE_SPINDLE_CLW"));
    assert_eq!(
        with_macro(&format!("{rapid}{clw}")),
        ["6:8: error: another macro of [[macros.code]] has the name \"guard\"; names must differ"]
    );
    let (one, two) = (row("data", "watch", "REG_AXIS_X"), row("data", "watch", "REG_AXIS_X"));
    assert_eq!(
        with_macro(&format!("{one}{two}")),
        ["6:8: error: another macro of [[macros.data]] has the name \"watch\"; names must differ"]
    );
    // A code macro and a data macro are in separate lists, and default names may be equal.
    assert_eq!(with_macro(&format!("{rapid}{}", row("data", "guard", "REG_AXIS_X"))), [""; 0]);
    let unnamed = "[[macros.code]]\nmatch = [\"CODE_RAPID\"]\nfile = \"a.mac\"\n";
    assert_eq!(with_macro(&format!("{unnamed}{unnamed}")), [""; 0]);
    let twice = with_macro("[macros]\nfunctions = [\"f.mac\", \"f.mac\"]");
    assert!(twice.len() == 1 && twice[0].contains("error"), "{twice:?}");
}

#[test]
fn words_that_their_register_cannot_write() {
    let does_not = |word: &str, register: &str, whole: u8, frac: u8| {
        format!(
            "\"{word}\" does not fit: numbers of register {register} have {whole} digits before the point and {frac} \
             after it; more digits in [[registers]] are expected"
        )
    };
    let code = |word: &str| after(&format!("[[codes]]\nid = \"CODE_STOP\"\nword = \"{word}\""));
    assert_eq!(code("G999"), [""; 0]);
    assert_eq!(code("G54.1"), [""; 0]);
    assert_eq!(code("G1000"), [format!("3:8: warning: {}", does_not("G1000", "G", 3, 1))]);
    assert_eq!(code("G900-G1100"), [""; 0]);
    assert_eq!(code("G1000-G1100"), [format!("3:8: warning: {}", does_not("G1000-G1100", "G", 3, 1))]);
    assert_eq!(code("M54.1"), [format!("3:8: warning: {}", does_not("M54.1", "M", 8, 0))]);
    let small = "[[registers]]\nname = \"B\"\nwhole = 2\nsecondary = { whole = 3 }\n";
    let of = |text: &str| after(&format!("{small}{text}"));
    assert_eq!(of("[[codes]]\nid = \"CODE_STOP\"\nword = \"B100\""), [""; 0]);
    let limits = "[[data]]\nid = \"REG_DELAY\"\nregister = \"B\"\n";
    assert_eq!(of(&format!("{limits}min = 0\nmax = 99999")), [""; 0]);
    let within = |key: &str, limit: &str, line: u8| {
        format!(
            "{line}:7: warning: no number can be within `{key}` {limit}: numbers of register B have 2 digits before \
             the point and 0 after it"
        )
    };
    assert_eq!(of(&format!("{limits}min = 1000")), [within("min", "1000", 8)]);
    assert_eq!(of(&format!("{limits}max = -1000")), [within("max", "-1000", 8)]);
}

#[test]
fn parts_of_the_format_that_say_nothing() {
    let place =
        "`rws` has no effect without `rws_at`, the place of the rewind-stop; \"start\" or \"optional\" is expected";
    assert_eq!(after("[format]\nrws = \"%\""), [format!("2:7: warning: {place}")]);
    assert_eq!(after("[format]\nrws = \"%\"\nrws_at = \"none\""), [""; 0]);
    assert_eq!(
        after("[format]\nopskip = { default = 2 }"),
        ["2:22: warning: `default` has no effect without `mark`, the mark of optional skip"]
    );
}

#[test]
fn registers_that_look_alike() {
    let tools = "[[registers]]\nname = \"TOOL\"\nbefore = \"T=\"\nwhole = 4\n[[registers]]\nname = \"NEXT\"\nbefore = \
                 \"T=\"\nwhole = 4\n";
    assert_eq!(
        after(tools),
        ["7:10: error: register TOOL has the same texts around its number, so that words of both look the same",]
    );
    assert_eq!(after(&tools.replace("\"T=\"\nwhole = 4\n[[", "\"T=\"\nafter = \"T\"\nwhole = 4\n[[")), [""; 0]);
}

#[test]
fn hooks_whose_event_never_comes() {
    let hook = |key: &str| with_macro(&format!("[macros]\n{key} = \"a.mac\""));
    for (key, column, expected) in [
        ("machine_startup", 19, "the Machine Startup Macro never runs: a machine with one channel has no master"),
        ("machine_shutdown", 20, "the Machine Shutdown Macro never runs: a machine with one channel has no master"),
        ("preprocessor_startup", 24, "the Pre-Processor Startup Macro never runs: this machine has no pre-processor"),
        ("preprocessor_identification", 31, "the Pre-Processor Identification Macro never runs: this machine has no"),
        ("subprogram_startup", 22, "the Subprogram Startup Macro never runs: no row of [[codes]] calls a subprogram"),
        ("cycle", 9, "the Cycle Event Macro never runs: no row of [[codes]] has a canned cycle"),
        ("tool", 8, "the Load Tool Event Macro never runs: no row of [[codes]] has a tool or a head"),
    ] {
        let findings = hook(key);
        let expected = format!("2:{column}: warning: {expected}");
        assert!(findings.len() == 1 && findings[0].starts_with(&expected), "{expected}: {findings:#?}");
    }
    for key in ["motion", "diagnostic", "block_startup", "program_startup"] {
        assert_eq!(hook(key), [""; 0], "{key}");
    }
    // With the source of the event there is nothing to report.
    for (key, code, word) in [
        ("cycle", "CODE_CYCLE_DRILL", "G81"),
        ("tool", "CODE_TOOL_LOAD", "M6"),
        ("tool", "CODE_HEAD_MAIN", "M7"),
        ("subprogram_shutdown", "CODE_CALSUB_ID", "M98"),
    ] {
        let text = format!("[macros]\n{key} = \"a.mac\"\n[[codes]]\nid = \"{code}\"\nword = \"{word}\"");
        assert_eq!(with_macro(&text), [""; 0], "{key}");
    }
    assert_eq!(
        with_macro("[[macros.code]]\nmatch = [\"CODE_RAPPID\"]\nfile = \"a.mac\""),
        ["2:10: error: unknown code identifier \"CODE_RAPPID\"; did you mean \"CODE_RAPID\"?"]
    );
    assert_eq!(
        with_macro(
            "[[data]]\nid = \"REG_DELAY\"\nregister = \"P\"\nprocess = false\n[[macros.data]]\nmatch = [\"REG_DELAY\"]\n\
             file = \"a.mac\""
        ),
        ["6:10: warning: the rows of REG_DELAY say `process = false`: it is dropped and no macro sees it"]
    );
}

#[test]
fn axes_that_no_channel_has() {
    assert_eq!(
        after("[[data]]\nid = \"REG_AXIS_Z\"\nregister = \"P\"\n[[axes]]\nname = \"Z1\"\nrapid = 100"),
        ["4:1: warning: no channel has the axis Z1, so nothing can move it; `axes` of [[channels]]"]
    );
}

#[test]
fn fields_of_dialogs() {
    let field = |keys: &str| after(&format!("[[dialogs]]\nname = \"A\"\n[[dialogs.fields]]\n{keys}"));
    for (keys, expected) in [
        (
            "kind = \"check\"\nvariable = \"A\"\nmin = 0\nmax = 1",
            &[
                "6:7: error: `min` belongs to a field of kind \"number\", this one ignores it",
                "7:7: error: `max` belongs to a field of kind \"number\", this one ignores it",
            ][..],
        ),
        (
            "kind = \"text\"\nvariable = \"A\"\nwhole = true\nchoices = [\"a\"]",
            &[
                "6:9: error: `whole` belongs to a field of kind \"number\", this one ignores it",
                "7:11: error: `choices` belongs to a field of kind \"choice\", this one ignores it",
            ],
        ),
        (
            "kind = \"number\"\nvariable = \"A\"\nlongest = 3",
            &["6:11: error: `longest` belongs to a field of kind \"text\", this one ignores it"],
        ),
        (
            "kind = \"label\"\ndefault = 3",
            &[
                "5:11: error: `default` belongs to a field of kind \"text\", \"number\", \"check\" or \"choice\", this one \
                 ignores it",
            ],
        ),
        (
            "kind = \"number\"\nvariable = \"A\"\nmin = 1.2\nmax = 1.8\nwhole = true",
            &["8:9: error: no whole number lies from 1.2 to 1.8"],
        ),
        (
            "kind = \"number\"\nvariable = \"A\"\nmin = 1\nmax = 3\ndefault = 4",
            &["8:11: error: A must be 1 to 3, not 4"],
        ),
        (
            "kind = \"choice\"\nvariable = \"A\"\nchoices = [\"a\", 1, \"a\", 1]",
            &[
                "6:20: error: another choice of this field has the label \"a\"",
                "6:25: error: another choice of this field has the label \"1\"",
            ],
        ),
        (
            "kind = \"choice\"\nvariable = \"A\"\nchoices = [{ label = \"a\", value = 1 }, { label = \"b\", value = 1 }]",
            &["6:40: warning: the choices \"a\" and \"b\" have the same value 1: the first one is shown"],
        ),
        (
            "kind = \"choice\"\nvariable = \"A\"\nchoices = [{ label = \"a\", value = \"b\" }, \"b\"]",
            &["6:42: warning: the choices \"a\" and \"b\" have the same value b: the first one is shown"],
        ),
        (
            "kind = \"choice\"\nvariable = \"A\"\nchoices = [{ label = \"a\", value = \"b\" }, { label = \"b\", value = 2 }]",
            &["6:42: warning: what is the value of one of the choices \"a\" and \"b\" is the label of the other"],
        ),
        (
            "kind = \"text\"\nvariable = \"A\"\nwhen = \"a\"",
            &["6:8: error: A is the variable of this field; a different variable must decide about it"],
        ),
        (
            "kind = \"text\"\nvariable = \"A\"\n[[dialogs.fields]]\nkind = \"check\"\nvariable = \"a\"",
            &["8:12: error: another field of this dialog sets a too, but only one of the values can be kept"],
        ),
    ] {
        assert_eq!(field(keys), expected, "{keys}");
    }
    // One of two fields takes the value.
    let either = "kind = \"check\"\nvariable = \"B\"\n[[dialogs.fields]]\nkind = \"text\"\nvariable = \"A\"\nwhen = \"B\"\n\
                  [[dialogs.fields]]\nkind = \"number\"\nvariable = \"A\"\nunless = \"B\"";
    assert_eq!(field(either), [""; 0]);
}
