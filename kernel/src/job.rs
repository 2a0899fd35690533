//! The one public entry: prepare a job, run it, receive ordered events.

use std::sync::Arc;

use counterpoint_lang::compile;

use crate::control::Control;
use crate::files::Files;
use crate::log::event::Event;
use crate::log::fold::Folds;
use crate::log::info::Info;
use crate::machine::Machine;
use crate::machine::finding::Finding;
use crate::options::Options;

/// A program given to a channel.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Program {
    /// File in the job's files.
    pub file: String,
    /// O-number inside the file; none = the file's first (or next free) main program.
    pub number: Option<u32>,
    /// Channel number; none = left to right.
    pub channel: Option<u16>,
}

/// Everything a job consists of.
#[derive(Debug, Clone)]
pub struct Spec {
    /// The checked machine.
    pub machine: Arc<Machine>,
    /// Programs, left to right.
    pub programs: Vec<Program>,
    /// Options.
    pub options: Options,
}

/// A prepared job: programs are loaded and assigned to channels.
#[derive(Debug)]
pub struct Job {
    spec: Spec,
    info: Arc<Info>,
    /// The machine's macros as its kernels run them.
    macros: Option<Arc<compile::Program>>,
}

/// Why a job cannot be run at all.
#[derive(Debug, Clone, thiserror::Error)]
#[error("the job cannot be run: {}", .findings.first().map_or("", |f| f.text.as_str()))]
pub struct PrepareError {
    /// All reasons.
    pub findings: Vec<Finding>,
}

/// Text files that macros have written, ascending by path with `/` between parts.
pub type WrittenFiles = Vec<(String, Arc<str>)>;

/// Receives what a job logs.
pub trait Sink: Send {
    /// Results to feed instead of an ordered log, when nobody needs the order between channels: every kernel then
    /// feeds its own lane on its own thread, nothing is merged, and [`events`](Self::events) is never called.
    fn folds(&mut self) -> Option<&mut Folds> {
        None
    }

    /// The files that macros have written; once, when all kernels have ended.
    fn files(&mut self, files: WrittenFiles) {
        let _ = files;
    }

    /// A batch of events in log order; `first_seq` is the number of the first one (the log counts from 1).
    /// Returning `false` stops the run (the log cannot be kept, for example the disk is full).
    fn events(&mut self, first_seq: u64, batch: &[Event]) -> bool;
}

/// How the run ended, apart from what the log says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Outcome {
    /// Events in the log.
    pub events: u64,
    /// It was cancelled.
    pub cancelled: bool,
    /// The sink refused events.
    pub sink_failed: bool,
}

impl Job {
    /// Loads the programs and assigns them to channels.
    ///
    /// # Errors
    /// Every reason why the job cannot run: missing files, unknown channels, too many programs, bad options.
    pub fn prepare(mut spec: Spec, files: &dyn Files) -> Result<Self, PrepareError> {
        spec.options.limits = spec.options.limits.capped();
        let info = crate::mcd::layout::assign(&spec, files).map_err(|findings| PrepareError { findings })?;
        let macros = spec.machine.macros.as_deref().map(|macros| macros.program_for(&spec.machine, info.trace));
        Ok(Self { spec, info: Arc::new(info), macros })
    }

    /// What is fixed about the job.
    #[must_use]
    pub fn info(&self) -> &Arc<Info> {
        &self.info
    }

    /// What it was made of.
    #[must_use]
    pub fn spec(&self) -> &Spec {
        &self.spec
    }

    /// The machine's macros as its kernels run them.
    pub(crate) fn macros(&self) -> Option<&Arc<compile::Program>> {
        self.macros.as_ref()
    }

    /// Runs the job to its end on its own threads; returns when all kernels have stopped and the sink has seen
    /// the whole log.
    pub fn run(&self, files: &dyn Files, control: &Control, sink: &mut dyn Sink) -> Outcome {
        if self.macros.is_none() {
            return crate::multi::run(self, files, control, sink);
        }
        // Macros nest deeper than the stack of any thread that asks for a job.
        let (shown, thread) = (&mut *sink, std::thread::Builder::new().name("job".to_owned()));
        let ended = std::thread::scope(|scope| {
            let work = move || crate::multi::run(self, files, control, shown);
            let handle = thread.stack_size(crate::macros::STACK).spawn_scoped(scope, work).ok()?;
            Some(handle.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
        });
        // Without a thread from the operating system the job cannot be run and counts as cancelled.
        ended.unwrap_or_else(|| {
            control.cancel();
            crate::multi::run(self, files, control, sink)
        })
    }
}
