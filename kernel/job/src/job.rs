//! The only public entry: prepare a job, run it, receive ordered events.

pub use counterpoint_channel::macros::STACK;
pub use counterpoint_event::RunEnd;
use counterpoint_ports::control::JobControl;
use counterpoint_ports::files::JobFiles;
pub use counterpoint_program::spec::{ProgramSelection, Spec};
pub use counterpoint_sync::sink::{LogSink, WrittenFiles};

pub use crate::prepared::{Job, PrepareError};

impl Job {
    /// Same as [`run`](Self::run), with this thread as the master, whose stack has [`STACK`] bytes. A thread for each
    /// job would be a large part of the cost of a small job.
    pub fn run_here(&self, files: &dyn JobFiles, control: &JobControl, sink: &mut dyn LogSink) -> RunEnd {
        crate::multi::run(self, files, control, sink)
    }

    /// Runs the job to its end on its own threads; returns when all kernels have stopped and the sink has seen
    /// the whole log.
    pub fn run(&self, files: &dyn JobFiles, control: &JobControl, sink: &mut dyn LogSink) -> RunEnd {
        if self.macros().is_none() {
            return crate::multi::run(self, files, control, sink);
        }
        // Macros nest deeper than the stack of any thread that asks for a job.
        let (shown, thread) = (&mut *sink, std::thread::Builder::new().name("job".to_owned()));
        let ended = std::thread::scope(|scope| {
            let work = move || control.measured(|| crate::multi::run(self, files, control, shown));
            let handle = thread.stack_size(STACK).spawn_scoped(scope, work).ok()?;
            Some(handle.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
        });
        // Without a thread from the operating system the job cannot be run and counts as cancelled.
        ended.unwrap_or_else(|| {
            control.cancel();
            crate::multi::run(self, files, control, sink)
        })
    }
}
