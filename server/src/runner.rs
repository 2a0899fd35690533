//! The seam between the server and the runner of a job.
//!
//! The server needs two steps: prepare (fast, may refuse with findings) and run. Invariant: the same record and the
//! same files give the same [`Info`] and the same events, so a run may be repeated and results made again later.

use std::sync::Arc;

use counterpoint_kernel::control::{JobControl, StopSignal};
use counterpoint_kernel::files::JobFiles;
use counterpoint_kernel::job::{Job, LogSink, ProgramSelection, RunEnd, Spec};
use counterpoint_kernel::log::info::Info;
use counterpoint_kernel::machine::Machine;
use counterpoint_kernel::machine::finding::Finding;
use counterpoint_kernel::options::JobOptions;
use counterpoint_kernel::plans::Plans;

/// Components of a job, resolved.
#[derive(Debug)]
pub struct ResolvedJob {
    /// The checked machine.
    pub machine: Arc<Machine>,
    /// Programs, left to right.
    pub programs: Vec<ProgramSelection>,
    /// Options.
    pub options: JobOptions,
}

/// Prepares jobs.
pub trait Runner: Send + Sync + 'static {
    /// Loads programs and assigns them to channels, unless `stop` is requested.
    ///
    /// # Errors
    /// Every reason why the job cannot run; when `stop` was requested, that it was.
    fn prepare(
        &self,
        task: ResolvedJob,
        files: &dyn JobFiles,
        stop: &StopSignal,
    ) -> Result<Box<dyn PreparedJob>, Vec<Finding>>;
}

/// A job ready to run.
pub trait PreparedJob: Send {
    /// Its fixed facts.
    fn info(&self) -> &Arc<Info>;

    /// Runs it to its end. The stack of the thread has [`counterpoint_kernel::job::STACK`] bytes.
    fn run(&self, files: &dyn JobFiles, control: &JobControl, sink: &mut dyn LogSink) -> RunEnd;
}

/// Runs jobs on the control emulator.
#[derive(Debug, Default)]
pub struct KernelRunner {
    plans: Arc<Plans>,
}

impl Runner for KernelRunner {
    fn prepare(
        &self,
        task: ResolvedJob,
        files: &dyn JobFiles,
        stop: &StopSignal,
    ) -> Result<Box<dyn PreparedJob>, Vec<Finding>> {
        let spec = Spec { machine: task.machine, programs: task.programs, options: task.options };
        match Job::prepare_until(spec, files, stop) {
            Ok(job) => Ok(Box::new(job.sharing(&self.plans))),
            Err(error) => Err(error.findings),
        }
    }
}

impl PreparedJob for Job {
    fn info(&self) -> &Arc<Info> {
        Job::info(self)
    }

    fn run(&self, files: &dyn JobFiles, control: &JobControl, sink: &mut dyn LogSink) -> RunEnd {
        Job::run_here(self, files, control, sink)
    }
}
