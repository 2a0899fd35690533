//! A machine with words for every primitive, and macros that share a variable and a file.

use std::fmt::Write as _;
use std::sync::Arc;

use counterpoint_kernel::files::MemoryFiles;
use counterpoint_kernel::machine::package::Overlay;
use counterpoint_kernel::machine::{Machine, load};

/// Time of a pass of a loop that only reads, ns: other things happen in whole milliseconds.
pub const TICK: i64 = 701_300;

const WORDS: &str = "
[sync]
dialect = \"none\"
poll = 0.0007013

[[data]]
id = \"REG_SYNC_PATHS\"
register = \"P\"
min = 0
";

/// Word, primitive, and action.
const WAITS: [(&str, &str, &str); 10] = [
    ("SYNC", "barrier", "wait"),
    ("MEET", "count", "wait"),
    ("FLAG", "flag", "wait"),
    ("RAISE", "flag", "set"),
    ("LOWER", "flag", "clear"),
    ("RANK", "order", "wait"),
    ("SEND", "signal", "signal"),
    ("TAKE", "signal", "wait"),
    ("GET", "lease", "wait"),
    ("PUT", "lease", "release"),
];

const MACROS: &str = "
[[waits]]
text = \"JOIN\"
primitive = \"join\"

[macros]
declaration = \"declare.mac\"
code = [{ name = \"stop\", match = [\"CODE_OPSTOP\"], file = \"stop.mac\" }]
";

/// Action of M1: a number that all channels share, and a line in a file that all channels share.
const STOP: &str = "
NUMBER=NUMBER*2+$VMCHN
IF/NUMBER.GT.1000000
  NUMBER=1
ENDOF/IF
OPEN/20,'shared.txt',REAR
WRITE/20,'!(*) !(*)',$VMCHN,NUMBER
CLOSE/20
OUTPUT
";

/// A lathe of this many channels with one axis each.
pub fn machine(channels: u16) -> Arc<Machine> {
    let mut text = format!(
        "extends = \"fanuc-turning\"\n[ce]\nname = \"kernels\"\n\n[variables]\nshared = [[100, 199], [500, 999]]\nchannel = []\n\n{WORDS}"
    );
    for (index, (word, primitive, act)) in WAITS.iter().enumerate() {
        let need = if *primitive == "count" { "\nneed = 2" } else { "" };
        write!(
            text,
            "\n[[registers]]\nindex = {}\nname = \"{word}\"\nwhole = 3\n\
             [[waits]]\nword = \"{word}0-{word}999\"\nprimitive = \"{primitive}\"\nact = \"{act}\"{need}\n",
            60 + index
        )
        .unwrap();
    }
    for number in 1..=channels {
        write!(
            text,
            "[[axes]]\nname = \"X{number}\"\nrapid = 10_000\nhome = 0\n[[spindles]]\nnumber = {number}\nmax = 4000\n\
             [[channels]]\nnumber = {number}\naxes = [\"X{number}\"]\nspindle = {number}\n"
        )
        .unwrap();
    }
    text += MACROS;
    let mut files = MemoryFiles::default();
    files.insert("kernels/declare.mac", "DECLAR/GLOBAL,INTEGER,NUMBER=0\n");
    files.insert("kernels/stop.mac", STOP);
    files.insert("kernels/machine.toml", text);
    let loaded = load(&Overlay::new(files, counterpoint_tests::library()), "kernels");
    let findings: Vec<String> = loaded.findings.iter().map(ToString::to_string).collect();
    loaded.machine.map(Arc::new).unwrap_or_else(|| panic!("the machine does not load: {findings:#?}"))
}
