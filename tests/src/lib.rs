//! Shared by the tests that cross crates: running a job in process and reading its summary.

pub mod processors;
pub mod spec;
pub mod watchdog;

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use counterpoint_kernel::control::JobControl;
use counterpoint_kernel::files::MemoryFiles;
use counterpoint_kernel::job::{Job, LogSink, PrepareError, ProgramSelection, RunEnd, Spec, WrittenFiles};
use counterpoint_kernel::log::builder::{JobResults, ResultsBuilder};
use counterpoint_kernel::log::event::Event;
use counterpoint_kernel::log::info::Info;
use counterpoint_kernel::log::summary::Summary;
use counterpoint_kernel::machine::package::{Overlay, shipped};
use counterpoint_kernel::machine::{Machine, load};
use counterpoint_kernel::options::JobOptions;

/// A job with everything it needs.
#[derive(Debug, Clone)]
pub struct Work {
    /// The machine.
    pub machine: Arc<Machine>,
    /// Programs and other files.
    pub files: MemoryFiles,
    /// Programs, left to right.
    pub programs: Vec<ProgramSelection>,
    /// Options.
    pub options: JobOptions,
}

/// The output.
#[derive(Debug, Clone)]
pub struct Done {
    /// The fixed facts of the job.
    pub info: Arc<Info>,
    /// Summary as users get it.
    pub summary: Summary,
    /// Events in log order.
    pub events: Vec<Event>,
    /// Outcome of the run.
    pub outcome: RunEnd,
    /// Files that macros have written.
    pub files: WrittenFiles,
}

/// Random cases of a test: `MIXED_CASES` in the environment, otherwise so many.
#[must_use]
pub fn cases(usual: u32) -> u32 {
    std::env::var("MIXED_CASES").ok().and_then(|cases| cases.parse().ok()).unwrap_or(usual)
}

/// A shipped machine or one of `tests/machines`, with `overlay` (TOML) on top if it is not empty. It is loaded once.
///
/// # Panics
/// When the machine does not load.
pub fn machine(name: &str, overlay: &str) -> Arc<Machine> {
    static LOADED: Mutex<BTreeMap<(String, String), Arc<Machine>>> = Mutex::new(BTreeMap::new());
    let loaded = || LOADED.lock().unwrap_or_else(PoisonError::into_inner);
    let key = (name.to_owned(), overlay.to_owned());
    let known = loaded().get(&key).cloned();
    known.unwrap_or_else(|| {
        let machine = load_machine(name, overlay);
        loaded().insert(key, machine.clone());
        machine
    })
}

fn load_machine(name: &str, overlay: &str) -> Arc<Machine> {
    let mut user = MemoryFiles::default();
    let folder = if overlay.is_empty() {
        name
    } else {
        user.insert("scenario/machine.toml", format!("extends = \"{name}\"\n\n[ce]\nname = \"scenario\"\n\n{overlay}"));
        "scenario"
    };
    let loaded = load(&Overlay::new(user, library()), folder);
    let findings: Vec<String> = loaded.findings.iter().map(ToString::to_string).collect();
    loaded.machine.map(Arc::new).unwrap_or_else(|| panic!("machine {name}: {findings:#?}"))
}

/// The shipped machines and those of `tests/machines`.
///
/// # Panics
/// When a file cannot be read.
#[must_use]
pub fn library() -> MemoryFiles {
    let mut files = shipped();
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("machines");
    for folder in std::fs::read_dir(root).unwrap().map(|folder| folder.unwrap()) {
        let name = folder.file_name().to_string_lossy().into_owned();
        files.insert(format!("{name}/machine.toml"), std::fs::read(folder.path().join("machine.toml")).unwrap());
    }
    files
}

impl Work {
    /// Programs as texts, one per channel from the left.
    pub fn texts<T: AsRef<[u8]>>(machine: Arc<Machine>, texts: &[T], options: JobOptions) -> Self {
        let mut files = MemoryFiles::default();
        let mut programs = Vec::new();
        for (index, text) in texts.iter().enumerate() {
            let file = format!("p{}.nc", index + 1);
            files.insert(file.clone(), text);
            programs.push(ProgramSelection { file, number: None, section: None, channel: None });
        }
        Self { machine, files, programs, options }
    }

    /// Prepares and runs, calling `jitter` around every shared operation.
    ///
    /// # Errors
    /// When the job cannot be prepared.
    pub fn run(&self, jitter: Option<fn(u16)>) -> Result<Done, PrepareError> {
        let with = |control: JobControl| match jitter {
            Some(jitter) => control.with_jitter(jitter),
            None => control,
        };
        self.run_with(with, false)
    }

    /// Prepares and runs with a control of its own; `watched`: a thread looks at the progress as fast as it can.
    ///
    /// # Errors
    /// When the job cannot be prepared.
    pub fn run_with(&self, with: impl FnOnce(JobControl) -> JobControl, watched: bool) -> Result<Done, PrepareError> {
        let (job, control) = self.prepare(None)?;
        let control = with(control);
        let mut sink = Collect { builder: ResultsBuilder::new(job.info()), events: Vec::new(), files: Vec::new() };
        let run = || job.run(&self.files, &control, &mut sink);
        let outcome = if watched { watchdog::beside(&control, run) } else { watchdog::watched(&control, run) };
        let Collect { builder, events, files } = sink;
        let info = Arc::clone(job.info());
        let summary = builder.finish(&outcome).summary;
        let mut again = ResultsBuilder::new(&info);
        events.iter().for_each(|event| again.event(event));
        assert_eq!(again.finish(&outcome).summary, summary, "what the kernels made, and what the log gives");
        Ok(Done { info, summary, events, outcome, files })
    }

    /// The same without an ordered log: every kernel feeds its results. The files are those that macros have written.
    ///
    /// # Errors
    /// When the job cannot be prepared.
    pub fn results(&self, jitter: Option<fn(u16)>) -> Result<(JobResults, RunEnd, WrittenFiles), PrepareError> {
        let (job, control) = self.prepare(jitter)?;
        let mut sink = Fold { builder: ResultsBuilder::new(job.info()), files: Vec::new() };
        let outcome = watchdog::watched(&control, || job.run(&self.files, &control, &mut sink));
        Ok((sink.builder.finish(&outcome), outcome, sink.files))
    }

    /// The fixed facts of the job.
    ///
    /// # Panics
    /// When the job cannot be prepared.
    pub fn info(&self) -> Arc<Info> {
        Arc::clone(self.prepare(None).unwrap_or_else(|error| panic!("{error}")).0.info())
    }

    fn prepare(&self, jitter: Option<fn(u16)>) -> Result<(Job, JobControl), PrepareError> {
        let mut options = self.options.clone();
        options.threads = processors::forced_threads().unwrap_or(options.threads);
        let spec = Spec { machine: self.machine.clone(), programs: self.programs.clone(), options };
        let job = Job::prepare(spec, &self.files)?;
        let control = JobControl::new(self.machine.channels.len());
        let control = match jitter {
            Some(jitter) => control.with_jitter(jitter),
            None => control,
        };
        Ok((job, control))
    }
}

struct Collect {
    builder: ResultsBuilder,
    events: Vec<Event>,
    files: WrittenFiles,
}

impl LogSink for Collect {
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

struct Fold {
    builder: ResultsBuilder,
    files: WrittenFiles,
}

impl LogSink for Fold {
    fn results(&mut self) -> Option<&mut ResultsBuilder> {
        Some(&mut self.builder)
    }

    fn is_logged(&self) -> bool {
        false
    }

    fn files(&mut self, files: WrittenFiles) {
        self.files = files;
    }

    fn events(&mut self, _first_seq: u64, _batch: &[Event]) -> bool {
        false
    }
}
