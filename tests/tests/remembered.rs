//! A control's memory of its words: after every block codes, system variables, summary and stepping agree.
//!
//! Programs are made at random for a mill: offset numbers with and without their codes, macros and subprograms, data
//! that G10 sets, blocks that a macro issues (EXEC), and a second program after a reset. A model that shares nothing
//! with the kernel keeps the words; it knows the blocks as they were made, not their text.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing, missing_docs)]

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use counterpoint_kernel::control::JobControl;
use counterpoint_kernel::files::MemoryFiles;
use counterpoint_kernel::job::{Job, LogSink, ProgramSelection, Spec, WrittenFiles};
use counterpoint_kernel::log::builder::ResultsBuilder;
use counterpoint_kernel::log::event::{Event, Kind, OffsetKind};
use counterpoint_kernel::log::summary::Summary;
use counterpoint_kernel::machine::package::{Overlay, shipped};
use counterpoint_kernel::machine::{Machine, load};
use counterpoint_kernel::operator::{Console, Heard, StepCalls, StepCommand, StepReply, StepReport, Whom};
use counterpoint_kernel::options::JobOptions;
use counterpoint_tests::cases;

/// Numbers of offsets with values.
const OFFSETS: u32 = 9;

const SUBPROGRAMS: &str = "O100\nN55 #30=#11\nM99\nO200\nH7\nN66 M9\nM99\n";

/// The words of the control, and which compensation is on.
#[derive(Debug, Clone, Default, PartialEq)]
struct Model {
    /// Values by address, without those that are 0.
    words: BTreeMap<char, u32>,
    length: bool,
    radius: bool,
    /// Offsets that have come into force: lengths, radii.
    used: [Vec<u32>; 2],
}

impl Model {
    fn set(&mut self, letter: char, value: u32) {
        match value {
            0 => self.words.remove(&letter),
            _ => self.words.insert(letter, value),
        };
    }

    fn get(&self, letter: char) -> u32 {
        self.words.get(&letter).copied().unwrap_or(0)
    }

    /// A length code, or a number under one.
    fn use_length(&mut self) {
        let number = self.get('H');
        self.used[0].push(number);
    }

    fn use_radius(&mut self) {
        let number = self.get('D');
        self.used[1].push(number);
    }

    fn h(&mut self, number: u32) {
        self.set('H', number);
        if self.length {
            self.use_length();
        }
    }

    fn d(&mut self, number: u32) {
        self.set('D', number);
        if self.radius {
            self.use_radius();
        }
    }
}

/// A program: its text, and the words before each line that prints them.
struct Made {
    text: String,
    lines: BTreeMap<u32, Model>,
}

struct Maker<'m> {
    rng: fastrand::Rng,
    model: &'m mut Model,
    made: Made,
    x: u32,
    n: u32,
}

impl Maker<'_> {
    fn line(&mut self, text: &str) {
        self.made.text.push_str(text);
        self.made.text.push('\n');
    }

    /// Adds a block, sometimes with a sequence number, and the line that prints the remembered values.
    fn block(&mut self, text: &str) {
        if self.rng.u8(0..3) == 0 {
            self.n += 1;
            self.model.set('N', self.n);
            self.line(&format!("N{} {text}", self.n));
        } else {
            self.line(text);
        }
    }

    /// Adds the line after a block that prints the words.
    fn print(&mut self) {
        self.line("DPRNT[D#4107[40]H#4111[40]M#4113[40]N#4114[40]O#4115[40]]");
        let line = self.made.text.lines().count() as u32;
        self.made.lines.insert(line, self.model.clone());
    }

    fn forward(&mut self) -> u32 {
        self.x += 20;
        self.x
    }

    fn one(&mut self) {
        let number = self.rng.u32(1..=OFFSETS);
        let zero = self.rng.u32(0..=OFFSETS);
        match self.rng.u8(0..16) {
            0 => {
                self.block(&format!("H{zero}"));
                self.model.h(zero);
            }
            1 => {
                self.block(&format!("D{number}"));
                self.model.d(number);
            }
            2 => {
                let x = self.forward();
                self.block(&format!("G1 X{x}. D{number} H{zero}"));
                self.model.h(zero);
                self.model.d(number);
            }
            3 => {
                let (m, x) = (self.rng.u32(8..=9), self.forward());
                self.block(&format!("G1 X{x}. M{m}"));
                self.model.set('M', m);
            }
            4 => {
                let code = if self.rng.bool() { "G43" } else { "G44" };
                self.block(&format!("{code} H{number} Z900."));
                self.model.length = true;
                self.model.h(number);
            }
            5 => {
                self.block("G43 Z900.");
                self.model.length = true;
                self.model.use_length();
            }
            6 => {
                self.block("G49 Z900.");
                self.model.length = false;
            }
            7 | 8 if !self.model.radius => {
                let x = self.forward();
                let side = if self.rng.bool() { "G41" } else { "G42" };
                self.model.radius = true;
                if self.rng.bool() && self.model.get('D') > 0 {
                    self.block(&format!("{side} G1 X{x}."));
                    self.model.use_radius();
                } else {
                    self.block(&format!("{side} D{number} G1 X{x}."));
                    self.model.d(number);
                }
            }
            7 | 8 => {
                let x = self.forward();
                self.block(&format!("G40 G1 X{x}."));
                self.model.radius = false;
            }
            9 => {
                self.block(&format!("G65 P100 H{number} D{zero} M7"));
                self.model.set('N', 55);
            }
            10 => {
                self.block("M98 P200");
                self.model.h(7);
                self.model.set('N', 66);
                self.model.set('M', 9);
            }
            11 => self.block(&format!("G10 L10 P{number} R{number}.")),
            12 if !self.model.radius => {
                self.line("G91 G28 Z0");
                self.block("G90");
            }
            13 => {
                self.block("M90");
                self.model.set('M', 90);
                self.model.h(6);
                self.model.d(4);
            }
            14 => {
                let f = self.rng.u32(1..=9) * 100;
                self.block(&format!("F{f}."));
                self.model.set('F', f);
            }
            _ => {
                let s = self.rng.u32(1..=30) * 100;
                self.block(&format!("S{s}"));
                self.model.set('S', s);
            }
        }
        self.print();
    }
}

fn program(rng: fastrand::Rng, number: u32, model: &mut Model) -> Made {
    let made = Made { text: String::new(), lines: BTreeMap::new() };
    let mut maker = Maker { rng, model, made, x: 0, n: number };
    maker.model.set('O', number);
    maker.line(&format!("O{number}"));
    maker.line("POPEN");
    maker.line("G90 G17 G94 G54 G0 X0 Y0 T3 M6");
    maker.model.set('T', 3);
    maker.model.set('M', 6);
    maker.line("S500 G1 F500. X0");
    maker.model.set('F', 500);
    maker.model.set('S', 500);
    maker.print();
    for _ in 0..maker.rng.u32(5..20) {
        maker.one();
    }
    if maker.model.radius {
        let x = maker.forward();
        maker.line(&format!("G40 G1 X{x}."));
        maker.model.radius = false;
    }
    maker.line("M30");
    maker.line(SUBPROGRAMS.trim_end());
    maker.made
}

fn machine() -> Arc<Machine> {
    let mut text = "extends = \"fanuc-mill\"\n[ce]\nname = \"remembers\"\n[macros]\ndeclaration = \"declare.mac\"\nprogram_shutdown = \"again.mac\"\n\
        [[macros.code]]\nname = \"issue\"\nmatch = [\"CODE_ISSUE\"]\nfile = \"issue.mac\"\n\
        [[codes]]\nid = \"CODE_ISSUE\"\ncustom = true\nword = \"M90\"\n"
        .to_owned();
    for axis in ["X", "Y", "Z"] {
        let home = if axis == "Z" { 1000 } else { 0 };
        let _ = write!(text, "[[axes]]\nname = \"{axis}\"\nrapid = 60000\nhome = {home}\nlimits = [-100, 2000]\n");
    }
    for number in 1..=OFFSETS {
        let radius = f64::from(number) / 10.0;
        let _ = write!(text, "[[tool.offsets]]\nnumber = {number}\nradius = {radius}\nvalues = {{ Z = {number} }}\n");
    }
    let mut files = MemoryFiles::default();
    files.insert("remembers/machine.toml", text);
    files.insert("remembers/declare.mac", "DECLAR/GLOBAL,REAL,RUN=1\n");
    files.insert("remembers/issue.mac", "EXEC/NOW,'H6 D4'\n");
    files.insert("remembers/again.mac", "RUN=RUN+1\nIF/RUN.EQ.2\n%L01=$FCERST('again.nc',1,.TRUE.)\nENDOF/IF\n");
    let loaded = load(&Overlay::new(files, shipped()), "remembers");
    let findings: Vec<String> = loaded.findings.iter().map(ToString::to_string).collect();
    loaded.machine.map(Arc::new).unwrap_or_else(|| panic!("{findings:#?}"))
}

/// Steps block by block.
#[derive(Default)]
struct Steps(Mutex<Vec<StepReport>>);

impl Console for Steps {
    fn has_news(&self) -> bool {
        false
    }

    fn poll(&self) -> Heard {
        Heard::Nothing
    }

    fn wait(&self, _at_most: Duration) -> Heard {
        Heard::Command(StepCommand::Step { whom: Whom::Next, blocks: 1, calls: StepCalls::Into })
    }

    fn say(&self, said: StepReply) {
        if let StepReply::Stopped(report) = said {
            self.0.lock().unwrap().push(report);
        }
    }
}

struct Log {
    builder: ResultsBuilder,
    events: Vec<Event>,
    files: WrittenFiles,
}

impl LogSink for Log {
    fn results(&mut self) -> Option<&mut ResultsBuilder> {
        Some(&mut self.builder)
    }

    fn files(&mut self, files: WrittenFiles) {
        self.files = files;
    }

    fn events(&mut self, _first_seq: u64, batch: &[Event]) -> bool {
        self.events.extend_from_slice(batch);
        true
    }
}

/// Reports of a run.
struct Told {
    summary: Summary,
    events: Vec<Event>,
    printed: String,
    reports: Vec<StepReport>,
}

fn run(machine: &Arc<Machine>, first: &Made, second: &Made) -> Told {
    let mut files = MemoryFiles::default();
    files.insert("first.nc", first.text.as_bytes());
    files.insert("again.nc", second.text.as_bytes());
    let program = ProgramSelection { file: "first.nc".into(), number: None, section: None, channel: None };
    let options = JobOptions { threads: 1, ..JobOptions::default() };
    let job = Job::prepare(Spec { machine: machine.clone(), programs: vec![program], options }, &files).unwrap();
    let steps = Arc::new(Steps::default());
    let control = JobControl::new(1).with_console(steps.clone());
    let mut log = Log { builder: ResultsBuilder::new(job.info()), events: Vec::new(), files: Vec::new() };
    let outcome = job.run(&files, &control, &mut log);
    let reports = std::mem::take(&mut *steps.0.lock().unwrap());
    let printed = log.files.iter().map(|(_, text)| text.to_string()).collect();
    Told { summary: log.builder.finish(&outcome).summary, events: log.events, printed, reports }
}

/// The words of a printed line: `D    2H    3M …`.
fn printed(line: &str) -> BTreeMap<char, u32> {
    let mut words = BTreeMap::new();
    let mut rest = line.replace(' ', "");
    while let Some(letter) = rest.chars().next() {
        let end = rest[1..].find(|c: char| c.is_ascii_alphabetic()).map_or(rest.len(), |end| end + 1);
        let value = rest[1..end].parse().unwrap_or_else(|_| panic!("a number in {line}"));
        if value != 0 {
            words.insert(letter, value);
        }
        rest.replace_range(..end, "");
    }
    words
}

fn numbers(events: &[Event], kind: OffsetKind) -> Vec<u32> {
    let offset = |event: &Event| match &event.kind {
        Kind::Mode(mode) => mode.offset.filter(|offset| offset.kind == kind).map(|offset| offset.number),
        _ => None,
    };
    events.iter().filter_map(offset).collect()
}

/// The numbers without those that have come before.
fn once(numbers: &[u32]) -> Vec<u32> {
    let mut seen = Vec::new();
    for &number in numbers.iter().filter(|number| **number > 0) {
        if !seen.contains(&number) {
            seen.push(number);
        }
    }
    seen
}

#[test]
fn codes_variables_summary_and_stepping_agree_after_every_block() {
    let machine = machine();
    for seed in 0..u64::from(cases(1000)) {
        let mut rng = fastrand::Rng::with_seed(seed);
        let mut model = Model::default();
        let first = program(rng.fork(), 1000 + rng.u32(1..9), &mut model);
        let used = std::mem::take(&mut model).used;
        // A reset has been.
        model.used = used;
        let second = program(rng.fork(), 2000 + rng.u32(1..9), &mut model);
        let told = run(&machine, &first, &second);
        let what = || format!("seed {seed}\n{}\n--\n{}\n{:#?}", first.text, second.text, told.summary.diagnostics);

        // Codes.
        assert_eq!(numbers(&told.events, OffsetKind::Length), model.used[0], "lengths, {}", what());
        assert_eq!(numbers(&told.events, OffsetKind::Diameter), model.used[1], "radii, {}", what());

        // System variables.
        let expected: Vec<&Model> = first.lines.values().chain(second.lines.values()).collect();
        let lines: Vec<&str> = told.printed.lines().collect();
        assert_eq!(lines.len(), expected.len(), "lines, {}", what());
        for (line, model) in lines.iter().zip(&expected) {
            let of = |(letter, _): &(&char, &u32)| "DHMNO".contains(**letter);
            let words: BTreeMap<char, u32> = model.words.iter().filter(of).map(|(l, v)| (*l, *v)).collect();
            assert_eq!(printed(line), words, "variables, {}", what());
        }

        // Stepping.
        let mut stops = 0;
        for report in &told.reports {
            let channel = &report.channels[0];
            let made = if channel.file.ends_with("again.nc") { &second } else { &first };
            let Some(model) = made.lines.get(&channel.line) else { continue };
            let words: BTreeMap<char, u32> = channel.words.iter().map(|(l, v)| (*l, *v as u32)).collect();
            assert_eq!(words, model.words, "stepping at line {}, {}", channel.line, what());
            stops += 1;
        }
        assert_eq!(stops, expected.len(), "stops, {}", what());

        // The summary.
        let tool = &told.summary.channels[0].tools[0];
        assert_eq!(tool.length_offsets, once(&model.used[0]), "lengths of the tool, {}", what());
        assert_eq!(tool.diameter_offsets, once(&model.used[1]), "radii of the tool, {}", what());
    }
}
