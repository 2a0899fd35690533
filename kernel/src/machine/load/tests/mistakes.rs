//! Every kind of mistake with its place and text.

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
fn mistakes_in_codes() {
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_RAPDI"
word = "G5""#
        ),
        [
            r#"2:6: error: unknown code identifier "CODE_RAPDI"; did you mean "CODE_RAPID"? (a name of your own needs `custom = true`)"#
        ]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_COOLER"
word = "M50""#
        ),
        [r#"2:6: error: unknown code identifier "CODE_COOLER" (a name of your own needs `custom = true`)"#]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_RAPID"
word = "G5"
custom = true"#
        ),
        ["4:10: error: CODE_RAPID is built in; `custom` is for names of your own"]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "COOLER"
word = "M50"
custom = true"#
        ),
        [r#"2:6: error: a custom name must be CODE_ and up to 59 letters, digits or _, not "COOLER""#]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_STOP""#
        ),
        [r#"1:1: error: [[codes]] needs a form: `word` ("G1", "G54-G59"), `text` or `none = true`"#]
    );
    assert_eq!(
        after(
            r#"[[codes]]
word = "M50""#
        ),
        ["1:1: error: [[codes]] needs `id`: an identifier, CODE_…"]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_STOP"
word = "M0"
text = "STOP""#
        ),
        ["1:1: error: [[codes]] takes only one of `word`, `text` and `none`"]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_STOP"
text = "STOP"
as_data = "REG_TOOL""#
        ),
        ["4:11: error: `as_data` needs a `word`: a text has no value"]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_STOP"
text = """#
        ),
        [r#"3:8: error: `text` must be 1 to 64 characters without blanks around them, not """#]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_STOP"
word = "Q1""#
        ),
        [r#"3:8: error: no register has the name "Q""#]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_STOP"
word = "U1""#
        ),
        [r#"3:8: error: "U" is the second name of register X; say "X""#]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_STOP"
word = "M""#
        ),
        [r#"3:8: error: "M" is no code word: it must be a letter and a number (G54.1), or a range (G54-G59)"#]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_STOP"
word = "M1.25""#
        ),
        [r#"3:8: error: "M1.25" is no code word: a code number has at most one decimal"#]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_STOP"
word = "M1000.5""#
        ),
        [r#"3:8: error: "M1000.5" is no code word: only code numbers below 1000 have a decimal"#]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_STOP"
word = "M100000000""#
        ),
        [r#"3:8: error: "M100000000" is no code word: a code number has at most eight digits"#]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_STOP"
word = "M5-M2""#
        ),
        [r#"3:8: error: "M5-M2" is no code word: the range must run upwards"#]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_STOP"
word = "M5-G6""#
        ),
        [r#"3:8: error: "M5-G6" is no code word: both ends of a range must have the same letter"#]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_STOP"
word = "M0"
as_data = "REG_TOOLL""#
        ),
        [r#"4:11: error: unknown data identifier "REG_TOOLL"; did you mean "REG_TOOL"?"#]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_STOP"
word = "M0"
order = 0
group = 1000"#
        ),
        [
            "4:9: error: `order` must be a whole number from 1 to 999, not 0",
            "5:9: error: `group` must be a whole number from 0 to 999, not 1000"
        ]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_STOP"
word = "M0"
modality = "modal""#
        ),
        ["4:12: error: a modal code needs a group of 1 to 999"]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_STOP"
word = "M0"
mul = 0"#
        ),
        ["4:7: error: `mul` must not be zero"]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_STOP"
word = "M0"
seconds = -2"#
        ),
        ["4:11: error: `seconds` must be zero or more, not -2"]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_STOP"
word = "M0"
with = ["S", "P"]
without = ["P"]"#
        ),
        [
            r#"4:9: error: no register has the name "S""#,
            "5:11: error: a register cannot be both in `with` and in `without`"
        ]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_SPINDLE_CLW"
word = "M03""#
        ),
        ["2:6: error: CODE_SPINDLE_CLW is already written like this at m/machine.toml:24"]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_STOP"
word = "M0"
alias = true"#
        ),
        ["4:9: warning: `alias` is for a second form, but no row before this one has the identifier"]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_SPINDLE_CCLW"
word = "M2-M4""#
        ),
        ["1:1: warning: M2-M4 overlaps the row at m/machine.toml:24, which has the same order 300 and comes first"]
    );
}

#[test]
fn mistakes_in_data() {
    assert_eq!(
        after(
            r#"[[data]]
id = "REG_AXIS_XX"
register = "P""#
        ),
        [
            r#"2:6: error: unknown data identifier "REG_AXIS_XX"; did you mean "REG_AXIS_X"? (a name of your own needs `custom = true`)"#
        ]
    );
    assert_eq!(
        after(
            r#"[[data]]
id = "REG_DELAY"
register = "Q""#
        ),
        [r#"3:12: error: no register has the name "Q""#]
    );
    assert_eq!(
        after(
            r#"[[data]]
id = "REG_DELAY"
register = "U""#
        ),
        [r#"3:12: error: "U" is the second name of register X; say "X""#]
    );
    assert_eq!(
        after(
            r#"[[data]]
id = "REG_DELAY"
register = "P"
min = 2
max = 1"#
        ),
        ["5:7: error: `max` 1 is less than `min` 2"]
    );
    assert_eq!(
        after(
            r#"[[data]]
id = "REG_AXIS_X"
register = "X""#
        ),
        ["2:6: error: REG_AXIS_X already has this register at m/machine.toml:27"]
    );
    assert_eq!(
        after(
            r#"[[data]]
id = "REG_DELAY"
dimension = "seconds""#
        ),
        [
            r#"3:13: error: `dimension` must be one of "none", "length", "angle", "feed", "surface-speed", "time", not "seconds""#
        ]
    );
}

#[test]
fn mistakes_in_axes_channels_spindles() {
    assert_eq!(
        after(
            r#"[[axes]]
name = "X1"
rapid = 1"#
        ),
        [r#"2:8: error: there is already an axis with the name "X1""#]
    );
    assert_eq!(
        after(
            r#"[[axes]]
name = "Q"
rapid = 1"#
        ),
        ["1:1: warning: no word can move axis Q: no row of [[data]] has REG_AXIS_Q"]
    );
    assert_eq!(
        after(
            r#"[[axes]]
name = "Z"
rapid = 1"#
        ),
        ["1:1: warning: no word can move axis Z: no row of [[data]] has REG_AXIS_Z"]
    );
    assert_eq!(
        after(
            r#"[[axes]]
name = "X2"
data = "REG_DELAY"
rapid = 0"#
        ),
        [
            "3:8: error: `data` must be an axis identifier (REG_AXIS_…), not REG_DELAY",
            "4:9: error: `rapid` must be above zero, not 0"
        ]
    );
    assert_eq!(
        after(
            r#"[[axes]]
name = "X2"
rapid = 1
acceleration = 0
limits = [5, 1]"#
        ),
        [
            "4:16: error: `acceleration` must be above zero, not 0",
            "5:10: error: `limits` must be the smaller and the larger one, not 5 and 1"
        ]
    );
    assert_eq!(
        after(
            r#"[[axes]]
name = "X2"
rapid = 1
home = 9
limits = [0, 1]
references = [1, 2, 3, 4]"#
        ),
        [
            "5:10: error: `home` 9 is outside the limits 0 to 1",
            "6:14: error: `references` must be a list of 0 to 3 numbers, not of 4"
        ]
    );
    assert_eq!(
        after(
            r#"[[axes]]
name = "X2"
role = "rotary"
diameter = true"#
        ),
        ["1:1: error: [[axes]] needs `rapid`: the rapid rate per minute", "4:12: error: a rotary axis has no diameter"]
    );
    assert_eq!(after("[[channels]]\nnumber = 1\naxes = []"), ["2:10: error: there is already a channel 1"]);
    assert_eq!(
        after(
            r#"[[channels]]
number = 2
axes = ["X2"]
spindle = 7"#
        ),
        [r#"3:9: error: no axis has the name "X2"; did you mean "X1"?"#, "4:11: error: there is no spindle 7"]
    );
    assert_eq!(
        after(
            r#"[[channels]]
number = 2
axes = ["X1"]"#
        ),
        ["3:8: error: axis X1 already belongs to channel 1"]
    );
    assert_eq!(
        after(
            r#"[[axes]]
name = "X2"
rapid = 1
[[axes]]
name = "X3"
rapid = 1
[[channels]]
number = 2
axes = ["X2", "X2", "X3"]"#
        ),
        ["9:15: error: axis X2 is listed twice", "9:21: error: axes X2 and X3 of one channel have the same `data`"]
    );
    assert_eq!(after("[[spindles]]\nnumber = 1\nmax = 5"), ["2:10: error: there is already a spindle 1"]);
    assert_eq!(
        after(
            r#"[[spindles]]
number = 2
name = "S1"
max = 5"#
        ),
        [r#"3:8: error: there is already a spindle with the name "S1""#]
    );
}

#[test]
fn mistakes_in_the_rest() {
    assert_eq!(
        before(
            r#"initial = ["CODE_RAPID", "CODE_INTERP_LINEAR", "CODE_STOP", "CODE_RAPIDD"]
"#
        ),
        [
            "1:26: error: CODE_INTERP_LINEAR and CODE_RAPID are both of group 1; one can be active",
            "1:48: error: CODE_STOP belongs to no modal group and cannot be active at program start",
            r#"1:61: error: unknown code identifier "CODE_RAPIDD"; did you mean "CODE_RAPID"?"#
        ]
    );
    assert_eq!(
        after(
            r#"[[channels]]
number = 3
axes = []
[sync]
dialect = "fanuc"
paths = "either""#
        ),
        [
            "5:11: warning: the channels of this machine cannot meet: no row of [[codes]] has CODE_SYNC_REG",
            r#"6:9: error: `paths = "either"` is unambiguous with channels 1 and 2 only; say "list" or "bits""#
        ]
    );
    assert_eq!(
        after(
            r#"[[channels]]
number = 11
axes = []
[sync]
paths = "list""#
        ),
        ["5:9: error: a list of digits cannot name channel 11, only 1 to 10"]
    );
    assert_eq!(
        after(
            r#"[[channels]]
number = 27
axes = []
[sync]
paths = "bits""#
        ),
        ["5:9: error: a sum of eight digits cannot name channel 27, only 1 to 26"]
    );
    assert_eq!(
        after(
            r#"[sync]
[[codes]]
id = "CODE_SYNC_REG"
word = "M100-M199"
as_data = "REG_SYNC""#
        ),
        [r#"1:1: warning: CODE_SYNC_REG has a word, but `dialect` is "none": the word will do nothing"#]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_STOP"
word = "M10-M20"
[time]
m_codes = { "3" = -1, "M4" = 1, "15" = 1, "5" = "x" }"#
        ),
        [
            "5:19: error: seconds of M3 must be zero or more",
            r#"5:23: error: `m_codes` takes M numbers as keys ("3" = 1.5), not "M4""#,
            "5:33: error: M15 is one of a range of codes; give that row `seconds`, or the number a row of its own",
            "5:49: error: `5` must be a number, not text"
        ]
    );
    assert_eq!(
        after("[variables]\nshared = [[100, 199], [33, 40], 5, [300, 200]]\nchannel = [[150, 160]]"),
        [
            "2:23: error: `shared` must be a list of [first, last] from 100 to 99999, the smaller number first",
            "2:33: error: `shared` must be a list of [first, last] from 100 to 99999, the smaller number first",
            "2:36: error: `shared` must be a list of [first, last] from 100 to 99999, the smaller number first",
            "3:12: error: #150-#160 overlaps #100-#199"
        ]
    );
    assert_eq!(
        after(
            r#"[tool]
[[tool.offsets]]
number = 1
tip = 10
radius = -1
values = { X = 1, X1 = "a" }
[[tool.offsets]]
number = 1"#
        ),
        [
            "4:7: error: `tip` must be a whole number from 0 to 9, not 10",
            "5:10: error: `radius` must be zero or more, not -1",
            r#"6:12: error: no axis has the name "X"; did you mean "X1"?"#,
            "6:24: error: `X1` must be a number, not text",
            "8:10: error: there is already a tool offset 1"
        ]
    );
    assert_eq!(
        after("[[work_offsets]]\nnumber = 0\n[[work_offsets]]\nnumber = 2\n[[work_offsets]]\nnumber = 2"),
        [
            "2:10: error: `number` must be a whole number from 1 to 999, not 0",
            "6:10: error: there is already a work offset 2"
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
