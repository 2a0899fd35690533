//! The hostile jobs, one for each unit of work.

use std::sync::Arc;

use counterpoint_kernel::control::JobControl;
use counterpoint_kernel::dialog::operator::DialogOperator;
use counterpoint_kernel::files::MemoryFiles;
use counterpoint_kernel::machine::package::Overlay;
use counterpoint_kernel::machine::{Machine, load};
use counterpoint_kernel::options::JobOptions;
use counterpoint_tests::Work;

/// Limit of the job.
pub const LIMIT: u32 = 2_900_070;
/// Block that is too long.
pub const LONG: u32 = 2_900_014;
/// Statement that cannot be read.
pub const SYNTAX: u32 = 2_900_060;
/// Levels of brackets that the control does not have.
pub const BRACKETS: u32 = 2_900_354;
/// Macro that used up its steps.
pub const STEPS: u32 = 2_910_055;

/// A job.
#[derive(Clone)]
pub struct Case {
    pub name: &'static str,
    machine: Arc<Machine>,
    programs: Vec<String>,
    /// Other files of the job, without text.
    files: Vec<String>,
    /// The operator who answers dialogs.
    operator: Option<Arc<dyn DialogOperator>>,
    /// Its special options.
    options: fn(&mut JobOptions),
    /// Diagnostics of which one has to come when the limits are small.
    pub ends_with: &'static [u32],
}

impl Case {
    pub fn new(name: &'static str, machine: Arc<Machine>, programs: Vec<String>, ends_with: &'static [u32]) -> Self {
        Self { name, machine, programs, files: Vec::new(), operator: None, options: |_| {}, ends_with }
    }

    /// Whether an operator answers its dialogs.
    pub fn attended(mut self, operator: Arc<dyn DialogOperator>) -> Self {
        self.operator = Some(operator);
        self.with_options(|options| options.attended = true)
    }

    /// Something is special about its options.
    pub fn with_options(mut self, options: fn(&mut JobOptions)) -> Self {
        self.options = options;
        self
    }

    /// The job has these files, too.
    pub fn with_files(mut self, files: Vec<String>) -> Self {
        self.files = files;
        self
    }

    /// A control for it.
    pub fn control(&self) -> JobControl {
        let control = JobControl::new(self.machine.channels.len());
        match &self.operator {
            Some(operator) => control.with_operator(Arc::clone(operator)),
            None => control,
        }
    }

    /// The job with these options.
    pub fn work(&self, mut options: JobOptions) -> Work {
        (self.options)(&mut options);
        let mut work = Work::texts(Arc::clone(&self.machine), &self.programs, options);
        self.files.iter().for_each(|name| work.files.insert(name.as_str(), ""));
        work
    }
}

/// A machine that extends a shipped one, with files beside it.
pub fn machine(base: &str, toml: &str, files: &[(&str, &str)]) -> Arc<Machine> {
    let mut user = MemoryFiles::default();
    user.insert("hostile/machine.toml", format!("extends = \"{base}\"\n\n[ce]\nname = \"hostile\"\n{toml}"));
    for (name, text) in files {
        user.insert(format!("hostile/{name}"), text);
    }
    let loaded = load(&Overlay::new(user, counterpoint_tests::library()), "hostile");
    loaded.machine.map(Arc::new).unwrap_or_else(|| panic!("{toml}: {:#?}", loaded.findings))
}

pub const SIEMENS: &str =
    "preprocessor = \"siemens\"\n\n[format]\nrws = \"\"\nrws_at = \"none\"\ncomment = [\";\", \"\"]\n";
pub const OKUMA: &str = "preprocessor = \"okuma\"\n";
pub const ISG: &str = "preprocessor = \"isg\"\n";
pub const HEIDENHAIN: &str = "preprocessor = \"heidenhain\"\n";

/// A macro that runs before every block; the program loops without time.
pub fn block_macro(name: &'static str, text: &str, ends_with: &'static [u32]) -> Case {
    let machine = machine("fanuc-mill-exact", "[macros]\nblock_startup = \"m.mac\"\n", &[("m.mac", text)]);
    Case::new(name, machine, vec!["N1 G90\nG91\nGOTO1\n".to_owned()], ends_with)
}

pub fn fanuc(name: &'static str, text: String, ends_with: &'static [u32]) -> Case {
    Case::new(name, machine("fanuc-mill-exact", "", &[]), vec![text], ends_with)
}

pub fn dialect(name: &'static str, toml: &str, text: String, ends_with: &'static [u32]) -> Case {
    Case::new(name, machine("fanuc-mill-exact", toml, &[]), vec![text], ends_with)
}

/// Text that is doubled a number of times: `10 << times` characters.
fn doubled(times: u32) -> String {
    format!("T='0123456789'\nDO/I=1,{times}\nT=T//T\nENDOF/DO\n")
}

pub fn endless(before: &str, body: &str) -> String {
    format!("{before}\nWHILE/1.EQ.1\n{body}\nENDOF/WHILE\n")
}

fn macros() -> Vec<Case> {
    let sequence = "C={}\nDO/I=1,5000\nC+=I\nENDOF/DO";
    let text = doubled(13);
    vec![
        block_macro("macro: loop without work", &endless("", "A=1"), &[STEPS, LIMIT]),
        block_macro("macro: push of a shared sequence", &endless(sequence, "B=C\nC=B\nC+=1"), &[STEPS, LIMIT]),
        block_macro("macro: big arrays", &endless("", "DECLAR/REAL,A(1000000)"), &[STEPS, LIMIT]),
        block_macro(
            "macro: backtracking",
            &endless("T='aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa'", "B=$FMATCH(T,'\\(a*\\)*\\(a*\\)*b')"),
            &[STEPS, LIMIT],
        ),
        block_macro("macro: replacing", &endless(&text, "B=$FEDIT(T,'0','bb')"), &[STEPS, LIMIT]),
        block_macro("macro: formats", &endless(sequence, "B=$FSWRIT('!(*)',C)"), &[STEPS, LIMIT]),
        block_macro("macro: sorting", &endless(sequence, "B=$FSORT(C)"), &[STEPS, LIMIT]),
        block_macro(
            "macro: OBJECT sequence of texts",
            &format!("DECLAR/OBJECT,SEQUENCE,HOARD\n{text}{}", endless("", "HOARD+=T//'x'")),
            &[LIMIT],
        ),
        block_macro("macro: arrays that are kept", &many_arrays(), &[LIMIT]),
        block_macro(
            "macro: GLOBAL array of texts",
            &format!("DECLAR/GLOBAL,HOARD(1000)\n{text}DO/I=1,1000\nHOARD(I)=T//'x'\nENDOF/DO\n"),
            &[LIMIT],
        ),
        block_macro(
            "macro: file without end",
            &format!("{text}OPEN/20,'a'\n{}", endless("", "WRITE/20,'!(*)',T")),
            &[LIMIT, STEPS],
        ),
        block_macro("macro: endless messages", &endless("", "PPRINT/'a message without end'"), &[STEPS, LIMIT]),
        block_macro("macro: endless diagnostics", &endless("", "ERROR/4,'a warning without end'"), &[STEPS, LIMIT]),
        block_macro("macro: long diagnostics", &endless(&text, "ERROR/4,'!(*)',T"), &[STEPS, LIMIT]),
        block_macro(
            "macro: nested EXEC",
            "EXEC/NOW,'G90'\nEXEC/NOW,'G91'\nEXEC/'G90'\nEXEC/'G90'\n",
            &[LIMIT, 2_900_081],
        ),
        block_macro("macro: long text in $P2", &format!("{text}$P2=T\n"), &[LONG]),
        block_macro(
            "macro: elements of system variables",
            &endless("N=0", "N=N+1\n$TLTAB(1,N)=N"),
            &[STEPS, 2_910_057, 2_910_051, 2_910_020],
        ),
        both_channels(),
        rules("tape editor: doubling rules", "\\\\(X.*\\\\)", "\\\\1\\\\1", "X01234567\n", &[LONG]),
        rules(
            "tape editor: backtracking rules",
            "\\\\(a*\\\\)*\\\\(a*\\\\)*cb",
            "",
            "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaax cb\n",
            &[2_900_008],
        ),
        recursion(),
    ]
}

/// Functions that call each other as often as they may.
fn recursion() -> Case {
    let mut text = String::new();
    for level in (0..20).rev() {
        let body = if level == 19 { "F19=1".to_owned() } else { format!("F{level}=F{0}(X)+F{0}(X)", level + 1) };
        text.push_str(&format!("MACRO/F{level}(X)\n{body}\nENDMAC\n"));
    }
    let toml = "[macros]\nblock_startup = \"m.mac\"\nfunctions = [\"f.mac\"]\n";
    let machine = machine("fanuc-mill-exact", toml, &[("m.mac", "A=F0(1)\n"), ("f.mac", &text)]);
    Case::new("macro: calls within calls", machine, vec!["N1 G90\nGOTO1\n".to_owned()], &[STEPS, LIMIT])
}

fn many_arrays() -> String {
    let names: Vec<String> = (0..100).map(|number| format!("A{number}(100000)")).collect();
    names.iter().map(|name| format!("DECLAR/REAL,{name}\n")).collect()
}

fn both_channels() -> Case {
    let hoard = format!("DECLAR/GLOBAL,HOARD(3000)\nDECLAR/OBJECT,REAL,N\nN=N+1\n{}HOARD(N)=T//'x'\n", doubled(12));
    let machine = machine("fanuc-2path-lathe-exact", "[macros]\nblock_startup = \"m.mac\"\n", &[("m.mac", &hoard)]);
    let program = "N1 G4 P10\nGOTO1\n".to_owned();
    let programs = vec![program.clone(), program.replace("P10", "P15")];
    Case::new("macro: GLOBAL variables of two channels", machine, programs, &[LIMIT])
}

fn rules(name: &'static str, find: &str, replace: &str, text: &str, ends_with: &'static [u32]) -> Case {
    let rule = format!("[[tape_editor]]\nfind = \"{find}\"\nreplace = \"{replace}\"\n");
    let machine = machine("fanuc-mill-exact", &rule.repeat(24), &[]);
    Case::new(name, machine, vec![text.repeat(1000)], ends_with)
}

fn programs() -> Vec<Case> {
    let mega = 1_000_000;
    vec![
        fanuc("fanuc: WHILE without work", "WHILE[1EQ1]DO1\nEND1\nM30\n".into(), &[LIMIT]),
        fanuc(
            "fanuc: subprograms that call each other",
            "O1\nN1 M98 P2\nGOTO1\nO2\nM98 P99990003\nM99\nO3\nG90\nM99\n".into(),
            &[LIMIT],
        ),
        fanuc("fanuc: subprogram within subprogram", "O1\nM98 P1\nM30\n".into(), &[2_900_041, 2_900_352]),
        fanuc("fanuc: a line of a megabyte", format!("G1 X{}\n", "1".repeat(mega)), &[LONG]),
        fanuc("fanuc: a block of many words", format!("{}\n", "X1.".repeat(mega / 3)), &[LONG]),
        fanuc("fanuc: deep brackets", format!("#1={}1\n", "[".repeat(8000)), &[SYNTAX, BRACKETS]),
        fanuc("fanuc: deep brackets of a megabyte", format!("#1={}1\n", "[".repeat(mega)), &[LONG, SYNTAX, BRACKETS]),
        fanuc("fanuc: deep variables", format!("#1={}1\n", "#".repeat(8000)), &[SYNTAX, BRACKETS]),
        fanuc("fanuc: deep IF", format!("{}#1=1\n", "IF[1EQ1]THEN ".repeat(600)), &[SYNTAX, BRACKETS]),
        fanuc(
            "fanuc: loops that do not pair",
            format!("WHILE[1EQ1]DO2\n{}{}", "DO1\n".repeat(100_000), "END3\n".repeat(100_000)),
            &[LIMIT, 2_900_064, 2_900_355],
        ),
        fanuc("fanuc: jumps among equal numbers", format!("{}N2 GOTO1\n", "N1\n".repeat(100_000)), &[LIMIT]),
        fanuc("fanuc: a million numbers", numbered("GOTO1\n"), &[LIMIT]),
        fanuc(
            "fanuc: MCALL storm",
            "O1\nG66 P2\nN1 G0 X1.\nG0 X2.\nGOTO1\nO2\nG90\nM99\n".into(),
            &[LIMIT, 2_900_041, 2_900_352, 2_900_353],
        ),
        fanuc("fanuc: endless diagnostics", "N1 Y7 Q3 %% ??\nGOTO1\n".into(), &[2_900_018, 2_900_320, 2_900_321]),
        fanuc("fanuc: dwells without end", "N1 G4 P1\nGOTO1\n".into(), &[LIMIT]),
        dialect("siemens: deep brackets", SIEMENS, format!("R1={}1\n", "(".repeat(8000)), &[SYNTAX, BRACKETS]),
        dialect(
            "siemens: deep brackets of a megabyte",
            SIEMENS,
            format!("R1={}1\n", "(".repeat(mega)),
            &[LONG, SYNTAX, BRACKETS],
        ),
        dialect("siemens: deep NOT", SIEMENS, format!("R1={}1\n", "NOT ".repeat(2000)), &[SYNTAX, BRACKETS]),
        dialect(
            "siemens: deep minus",
            SIEMENS,
            format!("R1={}1\n", "-".repeat(8000)),
            &[SYNTAX, LIMIT, LONG, 2_900_016],
        ),
        dialect("siemens: deep names", SIEMENS, format!("R1={}1\n", "R[".repeat(4000)), &[SYNTAX, BRACKETS]),
        dialect(
            "siemens: big arrays",
            SIEMENS,
            "AGAIN: DEF REAL A[100000]\nA[0]=REP(1)\nGOTOB AGAIN\n".into(),
            &[LIMIT, 2_900_201],
        ),
        dialect("siemens: REP in a loop", SIEMENS, "DEF REAL A[30000]\nLOOP\nA[0]=REP(1)\nENDLOOP\n".into(), &[LIMIT]),
        dialect(
            "siemens: texts that grow",
            SIEMENS,
            "DEF STRING[200] A\nLOOP\nA=A<<\"0123456789\"\nENDLOOP\n".into(),
            &[LIMIT, 2_900_200],
        ),
        dialect(
            "siemens: distinct lines",
            SIEMENS,
            distinct(|line| format!("R{}=R1+{line}\n", line % 300), "GOTOB AGAIN\n", "AGAIN:\n"),
            &[LIMIT],
        ),
        dialect(
            "siemens: jumps among equal labels",
            SIEMENS,
            format!("{}GOTOB ONE\n", "ONE:\n".repeat(100_000)),
            &[LIMIT],
        ),
        dialect(
            "siemens: MCALL storm",
            SIEMENS,
            "MCALL SUB\nAGAIN: X1\nX2\nGOTOB AGAIN\nM30\n%_N_SUB_SPF\nG90\nM17\n".into(),
            &[LIMIT, 2_900_040, 2_900_060],
        ),
        dialect("isg: deep brackets", ISG, format!("P1={}1\n", "[".repeat(8000)), &[SYNTAX]),
        dialect("isg: deep parameters", ISG, format!("P1={}1\n", "P".repeat(8000)), &[SYNTAX]),
        dialect(
            "isg: distinct lines",
            ISG,
            distinct(|line| format!("P{}={line}\n", line % 300), "$GOTO N1\n", "N1\n"),
            &[LIMIT],
        ),
        dialect(
            "isg: deep control blocks",
            ISG,
            format!("{}$BREAK\n{}", "$DO\n".repeat(50_000), "$ENDDO\n".repeat(50_000)),
            &[LIMIT],
        ),
        dialect("isg: big arrays", ISG, "N1\nV.P.A[100][100]\nV.P.B[9999]\n$GOTO N1\n".into(), &[LIMIT]),
        dialect("okuma: deep brackets", OKUMA, format!("VC1={}1\n", "[".repeat(8000)), &[SYNTAX, BRACKETS]),
        dialect(
            "okuma: deep brackets of a megabyte",
            OKUMA,
            format!("VC1={}1\n", "[".repeat(mega)),
            &[LONG, SYNTAX, BRACKETS],
        ),
        dialect("okuma: deep NOT", OKUMA, format!("VC1={}1\n", "NOT ".repeat(2000)), &[SYNTAX, BRACKETS]),
        dialect(
            "okuma: distinct lines",
            OKUMA,
            distinct(|line| format!("VC{}=VC1+{line}\n", line % 100 + 1), "GOTO N1\n", "N1\n"),
            &[LIMIT],
        ),
        dialect("okuma: jumps among equal names", OKUMA, format!("{}GOTO NA\n", "NA\n".repeat(100_000)), &[LIMIT]),
        dialect(
            "heidenhain: deep brackets",
            HEIDENHAIN,
            format!("BEGIN PGM A MM\nQ1 = {}1\n", "(".repeat(8000)),
            &[SYNTAX, BRACKETS],
        ),
        dialect(
            "heidenhain: deep brackets of a megabyte",
            HEIDENHAIN,
            format!("BEGIN PGM A MM\nQ1 = {}1\n", "(".repeat(mega)),
            &[LONG, SYNTAX, BRACKETS],
        ),
        dialect(
            "heidenhain: deep minus",
            HEIDENHAIN,
            format!("BEGIN PGM A MM\nQ1 = {}1\nQ1 = SIN {}1\n", "-".repeat(4000), "SIN ".repeat(1900)),
            &[SYNTAX, 2_900_016],
        ),
        dialect(
            "heidenhain: labels in a loop",
            HEIDENHAIN,
            format!("BEGIN PGM A MM\n{}FN 9: IF +1 EQU +1 GOTO LBL 7\n", labels()),
            &[LIMIT],
        ),
        dialect(
            "heidenhain: distinct lines",
            HEIDENHAIN,
            distinct(
                |line| format!("Q{} = Q1 + {line}\n", line % 300),
                "FN 9: IF +1 EQU +1 GOTO LBL 7\n",
                "BEGIN PGM A MM\nLBL 7\n",
            ),
            &[LIMIT],
        ),
        dialect(
            "heidenhain: repeats within repeats",
            HEIDENHAIN,
            "BEGIN PGM A MM\nLBL 1\nLBL 2\nQ1 = Q1 + 1\nCALL LBL 2 REP 65534\nCALL LBL 1 REP 65534\n".into(),
            &[LIMIT],
        ),
    ]
}

/// A program of many lines of which no two are equal, between a head and a jump back to it.
fn distinct(line: impl Fn(u32) -> String, last: &str, head: &str) -> String {
    let mut text = head.to_owned();
    (0..200_000).for_each(|number| text.push_str(&line(number)));
    text + last
}

fn numbered(last: &str) -> String {
    let mut text = String::new();
    (1..200_000).for_each(|number| text.push_str(&format!("N{number}\n")));
    text + last
}

fn labels() -> String {
    (7..100_000).map(|label| format!("LBL {label}\n")).collect()
}

/// All of them.
pub fn all() -> Vec<Case> {
    let mut all = macros();
    all.append(&mut programs());
    all.append(&mut super::storms::all());
    all
}
