//! Mistakes of keys, types, numbers, words, registers and syntax, with place and text.

use super::{after, before, load_text};

#[test]
fn mistakes_in_keys() {
    assert_eq!(
        after(
            r#"[sync]
dialekt = "fanuc""#
        ),
        [r#"2:1: error: unknown key `dialekt` in [sync]; did you mean "dialect"?"#]
    );
    assert_eq!(
        before("abstrct = true\n"),
        [r#"1:1: error: unknown key `abstrct` in the machine file; did you mean "abstract"?"#]
    );
    assert_eq!(
        after(
            r#"[[data]]
id = "REG_DELAY"
banana = 1"#
        ),
        ["3:1: error: unknown key `banana` in [[data]]"]
    );
}

#[test]
fn mistakes_in_types() {
    assert_eq!(
        after(
            r#"[time]
tool_change = "long""#
        ),
        ["2:15: error: `tool_change` must be a number, not text"]
    );
    assert_eq!(
        after("[time]\nstations = 1.5"),
        ["2:12: error: `stations` must be a whole number from 0 to 999, not a number"]
    );
    assert_eq!(
        after("[time]\nstations = 1979-05-27"),
        ["2:12: error: `stations` must be a whole number from 0 to 999, not a date"]
    );
    assert_eq!(after("[time]\nrapid = true"), ["2:9: error: `rapid` must be text in quotes, not true or false"]);
    assert_eq!(
        after(
            r#"[subprograms]
repeat_is_executions = "yes""#
        ),
        ["2:24: error: `repeat_is_executions` must be true or false, not text"]
    );
    assert_eq!(
        after(
            r#"[format]
comment = "(""#
        ),
        ["2:11: error: `comment` must be a list in [ ], not text"]
    );
    assert_eq!(
        after(
            r#"[format]
comment = ["("]"#
        ),
        [
            "2:11: error: `comment` must be a list of two texts, start and end, the end empty for the end of the block, or [] for none"
        ]
    );
    assert_eq!(
        after(
            r#"[format]
comment = [1, ")"]"#
        ),
        [
            "2:11: error: `comment` must be a list of two texts, start and end, the end empty for the end of the block, or [] for none",
            "2:12: error: `comment` must be a list of texts, this one is a whole number"
        ]
    );
    assert_eq!(
        after(
            r#"[format]
opskip = "/""#
        ),
        ["2:10: error: `opskip` must be a table, not text"]
    );
    assert_eq!(before("time = 3\n"), ["1:8: error: `time` must be a table, not a whole number"]);
    assert_eq!(
        before("work_offsets = [1]\n"),
        ["1:17: error: [[work_offsets]] must be a table, this is a whole number"]
    );
}

#[test]
fn mistakes_in_numbers() {
    assert_eq!(after("[time]\ntool_change = -1"), ["2:15: error: `tool_change` must be zero or more, not -1"]);
    assert_eq!(after("[time]\ntool_change = nan"), ["2:15: error: `tool_change` must be a finite number, not NaN"]);
    assert_eq!(after("[time]\ntool_change = inf"), ["2:15: error: `tool_change` must be a finite number, not inf"]);
    assert_eq!(
        after("[time]\nstations = 1000"),
        ["2:12: error: `stations` must be a whole number from 0 to 999, not 1000"]
    );
    assert_eq!(
        after("[time]\nstations = 99999999999999999999"),
        ["2:12: error: the number 99999999999999999999 is too large"]
    );
    assert_eq!(
        after(
            r#"[format]
opskip = { mark = "//", default = 0 }"#
        ),
        [
            r#"2:19: error: `mark` must be one character or empty, not "//""#,
            "2:35: error: `default` must be a whole number from 1 to 9, not 0"
        ]
    );
    assert_eq!(
        after("[sync]\npoll = 0\nrelease = 1e9"),
        [
            "2:8: error: `poll` must be at least 1e-9 s: a polling loop must take time",
            "3:11: error: `release` must be at most 86400 s, not 1000000000"
        ]
    );
    assert_eq!(after("[[spindles]]\nnumber = 2\nmax = 0"), ["3:7: error: `max` must be above zero, not 0"]);
    assert_eq!(after("[[spindles]]\nnumber = 2\nmax = 10\nmin = 20"), ["4:7: error: `min` 20 is more than `max` 10"]);
    assert_eq!(
        after("[tool]\noffset_digits = 5"),
        ["2:17: error: `offset_digits` must be a whole number from 0 to 4, not 5"]
    );
}

#[test]
fn mistakes_in_words() {
    assert_eq!(
        after(
            r#"[time]
rapid = "slowest-axes""#
        ),
        [
            r#"2:9: error: `rapid` must be one of "slowest-axis", "linear", not "slowest-axes"; did you mean "slowest-axis"?"#
        ]
    );
    assert_eq!(
        after(
            r#"[sync]
paths = "x""#
        ),
        [r#"2:9: error: `paths` must be one of "list", "bits", "either", not "x""#]
    );
    assert_eq!(
        after(
            r#"[format]
rws_at = "start""#
        ),
        ["2:10: error: `rws_at` expects a rewind-stop, but `rws` has no text"]
    );
    assert_eq!(
        after(
            r#"[format]
comment = ["(", ")"]
message = ["(", "."]"#
        ),
        ["3:11: warning: comments and messages start with the same text; both are read as comments"]
    );
    assert_eq!(
        after(
            r#"[subprograms]
extension = ".tps""#
        ),
        ["2:13: error: `extension` must be letters and digits without a dot"]
    );
}

#[test]
fn mistakes_in_registers() {
    assert_eq!(
        after(
            r#"[[registers]]
name = "X"
whole = 4"#
        ),
        [r#"2:8: error: there is already a register with the name "X""#]
    );
    assert_eq!(
        after(
            r#"[[registers]]
name = "U"
whole = 4"#
        ),
        [r#"2:8: error: there is already a register with the name "U""#]
    );
    assert_eq!(
        after(
            r#"[[registers]]
name = "Z"
second = "Z"
whole = 4"#
        ),
        ["3:10: error: `second` must differ from `name`"]
    );
    assert_eq!(
        after(
            r#"[[registers]]
name = "z"
whole = 4"#
        ),
        [
            r#"2:8: error: `name` must be one capital letter, or a longer name of ASCII characters that does not start with a digit, not "z""#
        ]
    );
    assert_eq!(
        after(
            r#"[[registers]]
name = ""
whole = 4"#
        ),
        [r#"2:8: error: `name` must be 1 to 16 characters without blanks around them, not """#]
    );
    assert_eq!(
        after(
            r#"[[registers]]
name = "Z"
index = 1
whole = 10"#
        ),
        [
            "3:9: error: index 1 already belongs to register G",
            "4:9: error: `whole` must be a whole number from 0 to 9, not 10"
        ]
    );
    assert_eq!(
        after(
            r#"[[registers]]
name = "Z"
index = 100
whole = 4"#
        ),
        ["3:9: error: `index` must be a whole number from 1 to 99, not 100"]
    );
    assert_eq!(
        after("[[registers]]\nindex = 50"),
        [
            "1:1: error: [[registers]] needs `name`: a capital letter, or text for a special register",
            "1:1: error: [[registers]] needs `whole`: digits before the point"
        ]
    );
}

#[test]
fn mistakes_in_syntax() {
    assert_eq!(
        after(
            r#"[time]
tool_change = = 3
stations = "x""#
        ),
        [
            "2:15: error: extra `=`, expected nothing",
            "3:12: error: `stations` must be a whole number from 0 to 999, not text"
        ]
    );
    assert_eq!(
        after("[time\nstations = 3"),
        ["1:6: error: unclosed table, expected `]`", "2:1: error: unknown key `stations` in the machine file"]
    );
    assert_eq!(after("[time]\nstations = 3\nstations = 4"), ["3:1: error: duplicate key"]);
    assert_eq!(
        after(
            r#"[time]
stations = "abc
"#
        ),
        [r#"2:16: error: invalid basic string, expected `"`"#]
    );
}

#[test]
fn ten_mistakes_of_one_file_are_reported_at_once() {
    let text = r#"
extens = "fanuc-turning"
initial = ["CODE_RAPDI"]
[ce]
name = ""
units = "cm"
[machine]
type = "lath"
[[registers]]
name = "G"
whole = 30
[[codes]]
id = "CODE_STOP"
word = "M0"
order = 5000
[[data]]
id = "REG_AXIS_XY"
[[axes]]
name = "X"
rapid = "fast"
[[channels]]
number = 1
axes = ["Y"]
[sync]
poll = -1
[time]
stations = = 4
"#;
    let findings = load_text(text).findings;
    let lines: Vec<u32> = findings.iter().map(|finding| finding.line).collect();
    assert_eq!(lines, [2, 3, 5, 6, 8, 11, 14, 15, 17, 18, 20, 23, 25, 27], "{findings:#?}");
    assert_eq!(
        findings.first().map(ToString::to_string).as_deref(),
        Some("m/machine.toml:2:1: error: unknown key `extens` in the machine file; did you mean \"extends\"?")
    );
}

#[test]
fn sections_that_must_be_there_are_named() {
    let texts: Vec<String> = load_text("").findings.into_iter().map(|finding| finding.text).collect();
    for section in ["ce", "machine", "registers", "codes", "data", "axes", "channels"] {
        assert!(texts.iter().any(|text| text.starts_with(&format!("the machine file needs `{section}`"))), "{texts:?}");
    }
    assert_eq!(texts.len(), 7);
}

#[test]
fn a_channel_has_at_most_eight_axes() {
    let mut text = String::new();
    let names: Vec<String> = (2..11).map(|number| format!("X{number}")).collect();
    for name in &names {
        text.push_str(&format!("[[axes]]\nname = \"{name}\"\nrapid = 1\n"));
    }
    text.push_str(&format!("[[channels]]\nnumber = 2\naxes = {names:?}"));
    let findings = after(&text);
    assert!(findings.contains(&"30:8: error: a channel has at most 8 axes, not 9".to_owned()), "{findings:?}");
}
