//! Shared by the tests that cross crates: running a job in process and reading its summary.

use std::sync::Arc;

use counterpoint_kernel::control::Control;
use counterpoint_kernel::files::Memory;
use counterpoint_kernel::job::{Job, Outcome, PrepareError, Program, Sink, Spec};
use counterpoint_kernel::log::digest::Digest;
use counterpoint_kernel::log::event::Event;
use counterpoint_kernel::log::summary::{Builder, Summary};
use counterpoint_kernel::machine::package::{Overlay, shipped};
use counterpoint_kernel::machine::{Machine, load};
use counterpoint_kernel::options::Options;

/// A job with everything it needs.
#[derive(Debug, Clone)]
pub struct Work {
    /// The machine.
    pub machine: Arc<Machine>,
    /// Programs and other files.
    pub files: Memory,
    /// Programs, left to right.
    pub programs: Vec<Program>,
    /// Options.
    pub options: Options,
}

/// What came out.
#[derive(Debug, Clone)]
pub struct Done {
    /// Summary as users get it.
    pub summary: Summary,
    /// Events in log order.
    pub events: Vec<Event>,
    /// Outcome of the run.
    pub outcome: Outcome,
}

/// A shipped machine, with `overlay` (TOML) on top if it is not empty.
///
/// # Panics
/// When the machine does not load.
pub fn machine(name: &str, overlay: &str) -> Arc<Machine> {
    let mut user = Memory::default();
    let folder = if overlay.is_empty() {
        name
    } else {
        user.insert("scenario/machine.toml", format!("extends = \"{name}\"\n\n[ce]\nname = \"scenario\"\n\n{overlay}"));
        "scenario"
    };
    let loaded = load(&Overlay::new(user, shipped()), folder);
    let findings: Vec<String> = loaded.findings.iter().map(ToString::to_string).collect();
    loaded.machine.map(Arc::new).unwrap_or_else(|| panic!("machine {name}: {findings:#?}"))
}

impl Work {
    /// Programs as texts, one per channel from the left.
    pub fn texts<T: AsRef<[u8]>>(machine: Arc<Machine>, texts: &[T], options: Options) -> Self {
        let mut files = Memory::default();
        let mut programs = Vec::new();
        for (index, text) in texts.iter().enumerate() {
            let file = format!("p{}.nc", index + 1);
            files.insert(file.clone(), text);
            programs.push(Program { file, number: None, channel: None });
        }
        Self { machine, files, programs, options }
    }

    /// Prepares and runs, calling `jitter` around every shared operation.
    ///
    /// # Errors
    /// When the job cannot be prepared.
    pub fn run(&self, jitter: Option<fn(u16)>) -> Result<Done, PrepareError> {
        let spec =
            Spec { machine: self.machine.clone(), programs: self.programs.clone(), options: self.options.clone() };
        let job = Job::prepare(spec, &self.files)?;
        let control = Control::new(self.machine.channels.len());
        let control = match jitter {
            Some(jitter) => control.with_jitter(jitter),
            None => control,
        };
        let mut sink = Collect { builder: Builder::new(job.info()), digest: Digest::new(), events: Vec::new() };
        let outcome = job.run(&self.files, &control, &mut sink);
        let digest = sink.digest.hex();
        Ok(Done { summary: sink.builder.finish(&outcome, digest), events: sink.events, outcome })
    }
}

struct Collect {
    builder: Builder,
    digest: Digest,
    events: Vec<Event>,
}

impl Sink for Collect {
    fn events(&mut self, first_seq: u64, batch: &[Event]) -> bool {
        for (seq, event) in (first_seq..).zip(batch) {
            self.builder.event(seq, event);
            self.digest.event(event);
        }
        self.events.extend_from_slice(batch);
        true
    }
}
