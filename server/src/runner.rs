//! The seam between the server and the runner of a job.
//!
//! The server needs two steps: prepare (fast, may refuse with findings) and run. Invariant: the same record and the
//! same files give the same [`Info`] and the same events, so a run may be repeated and results made again later.

use std::sync::Arc;

use counterpoint_kernel::control::{Control, Stop};
use counterpoint_kernel::files::Files;
use counterpoint_kernel::job::{Job, Outcome, Program, Sink, Spec};
use counterpoint_kernel::log::info::Info;
use counterpoint_kernel::machine::Machine;
use counterpoint_kernel::machine::finding::Finding;
use counterpoint_kernel::options::Options;
use counterpoint_kernel::plans::Plans;

/// Components of a job, resolved.
#[derive(Debug)]
pub struct Task {
    /// The checked machine.
    pub machine: Arc<Machine>,
    /// Programs, left to right.
    pub programs: Vec<Program>,
    /// Options.
    pub options: Options,
}

/// Prepares jobs.
pub trait Runner: Send + Sync + 'static {
    /// Loads programs and assigns them to channels, unless `stop` is requested.
    ///
    /// # Errors
    /// Every reason why the job cannot run; when `stop` was requested, that it was.
    fn prepare(&self, task: Task, files: &dyn Files, stop: &Stop) -> Result<Box<dyn Prepared>, Vec<Finding>>;
}

/// A job ready to run.
pub trait Prepared: Send {
    /// Its fixed facts.
    fn info(&self) -> &Arc<Info>;

    /// Runs it to its end. The stack of the thread has [`counterpoint_kernel::job::STACK`] bytes.
    fn run(&self, files: &dyn Files, control: &Control, sink: &mut dyn Sink) -> Outcome;
}

/// Runs jobs on the control emulator.
#[derive(Debug, Default)]
pub struct Kernel {
    plans: Arc<Plans>,
}

impl Runner for Kernel {
    fn prepare(&self, task: Task, files: &dyn Files, stop: &Stop) -> Result<Box<dyn Prepared>, Vec<Finding>> {
        let spec = Spec { machine: task.machine, programs: task.programs, options: task.options };
        match Job::prepare_until(spec, files, stop) {
            Ok(job) => Ok(Box::new(job.sharing(&self.plans))),
            Err(error) => Err(error.findings),
        }
    }
}

impl Prepared for Job {
    fn info(&self) -> &Arc<Info> {
        Job::info(self)
    }

    fn run(&self, files: &dyn Files, control: &Control, sink: &mut dyn Sink) -> Outcome {
        Job::run_here(self, files, control, sink)
    }
}
