//! Mistakes of rows and contradictions between rows, with place and text.

use super::{after, before};

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
        [r#"3:8: error: "M" is not a code word: it must be a letter and a number (G54.1), or a range (G54-G59)"#]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_STOP"
word = "M1.25""#
        ),
        [r#"3:8: error: "M1.25" is not a code word: a code number has at most one decimal"#]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_STOP"
word = "M1000.5""#
        ),
        [r#"3:8: error: "M1000.5" is not a code word: only code numbers below 1000 have a decimal"#]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_STOP"
word = "M100000000""#
        ),
        [r#"3:8: error: "M100000000" is not a code word: a code number has at most eight digits"#]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_STOP"
word = "M5-M2""#
        ),
        [r#"3:8: error: "M5-M2" is not a code word: the range must run upwards"#]
    );
    assert_eq!(
        after(
            r#"[[codes]]
id = "CODE_STOP"
word = "M5-G6""#
        ),
        [r#"3:8: error: "M5-G6" is not a code word: both ends of a range must have the same letter"#]
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
            r#"3:13: error: `dimension` must be one of "none", "length", "increments", "angle", "feed", "feed-tenths", "surface-speed", "time", not "seconds""#
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
        [
            "1:1: warning: no word can move axis Q: no row of [[data]] has REG_AXIS_Q",
            "1:1: warning: no channel has the axis Q, so nothing can move it; `axes` of [[channels]]"
        ]
    );
    assert_eq!(
        after(
            r#"[[axes]]
name = "Z"
rapid = 1"#
        ),
        [
            "1:1: warning: no word can move axis Z: no row of [[data]] has REG_AXIS_Z",
            "1:1: warning: no channel has the axis Z, so nothing can move it; `axes` of [[channels]]"
        ]
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
        [r#"3:9: error: no axis has the name "X2"; did you mean "X1"?"#, "4:11: error: no spindle has the number 7"]
    );
    assert_eq!(
        after(
            r#"[[channels]]
number = 2
axes = ["X1"]"#
        ),
        ["3:8: error: axis X1 already belongs to channel 1; `master` in its row of [[axes]] lets channels exchange it"]
    );
    assert_eq!(
        after(
            r#"[[axes]]
name = "C1"
rapid = 3600
master = 1
[[axes]]
name = "C2"
rapid = 3600
data = "REG_AXIS_BT"
master = 2
[[channels]]
number = 2
axes = ["C1", "C2"]"#
        ),
        [
            "1:1: error: `master` of axis C1 is channel 1, which does not list it in `axes`",
            "1:1: warning: no word can move axis C1: no row of [[data]] has REG_AXIS_CT",
            "5:1: warning: no word can move axis C2: no row of [[data]] has REG_AXIS_BT",
            "5:1: warning: `master` of axis C2 has no effect: only channel 2 lists the axis"
        ]
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
            "1:48: error: CODE_STOP has no modal group and cannot be active at program start",
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
            r#"[[channels]]
number = 3
axes = []
[sync]
[[codes]]
id = "CODE_BALANCE_ON"
word = "G168""#
        ),
        [r#"4:1: warning: CODE_BALANCE_ON has a word, but `dialect` is "none": the word will do nothing"#]
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
            "2:23: error: `shared` must be a list of [first, last] from 100 to 999999, the smaller number first",
            "2:33: error: `shared` must be a list of [first, last] from 100 to 999999, the smaller number first",
            "2:36: error: `shared` must be a list of [first, last] from 100 to 999999, the smaller number first",
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
fn waits_of_a_machine_with_one_channel() {
    let row = "[[waits]]\nword = \"M100-M149\"\nprimitive = \"barrier\"";
    let finding = "1:1: warning: [[waits]] on a machine with one channel: no other channel can arrive, nothing waits";
    assert_eq!(after(row), [finding]);
    assert_eq!(after(&format!("[[channels]]\nnumber = 2\naxes = []\n{row}")), [""; 0]);
}
