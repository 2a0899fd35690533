//! A fault at each step that writes in the life of one job, one after the other: the job is accepted in the end, ends
//! exactly once, and reports the same as on a good disk.

use std::io;
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use counterpoint_proto::v1;
use counterpoint_server::doctor;
use counterpoint_server::local::disk::{Disk, DiskOperation, Faults};

use crate::faults::{Said, said, submission};
use crate::support::*;

/// A log in a file, and stored results.
const SCRIPT: &str = "EVENTS 3000\nWRITE a.txt\nWRITE out/b.txt\n";
/// More steps than the life of a job has.
const MANY: usize = 300;

/// The error.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Trouble {
    /// ENOSPC.
    NoSpace,
    /// EIO.
    Input,
    /// Half of the bytes are written, and the rest by another call.
    Short,
    /// Half of the bytes are written, and then there is no space.
    Torn,
}

impl Trouble {
    /// Whether it can meet a step; reading is never met.
    fn meets(self, step: DiskOperation) -> bool {
        match self {
            Self::NoSpace | Self::Input => step != DiskOperation::Read,
            Self::Short | Self::Torn => matches!(step, DiskOperation::Write(length) if length > 1),
        }
    }
}

#[derive(Default)]
struct State {
    /// Steps that can be met, until the trouble comes.
    left: usize,
    armed: bool,
    /// The next step fails.
    torn: bool,
    met: Option<DiskOperation>,
}

/// A disk with one trouble at one step.
struct OneFault {
    trouble: Trouble,
    state: Mutex<State>,
}

impl OneFault {
    /// Lets the trouble come at this step from now.
    fn arm(&self, left: usize) {
        *self.state.lock().unwrap() = State { left, armed: true, ..State::default() };
    }

    /// The step that was met, if one was.
    fn disarm(&self) -> Option<DiskOperation> {
        std::mem::take(&mut *self.state.lock().unwrap()).met
    }
}

impl Faults for OneFault {
    fn before(&self, step: DiskOperation, _path: &Path) -> io::Result<usize> {
        let mut state = self.state.lock().unwrap();
        let no_space = || io::Error::from_raw_os_error(28);
        if step != DiskOperation::Read && std::mem::take(&mut state.torn) {
            return Err(no_space());
        }
        if !state.armed || !self.trouble.meets(step) {
            return Ok(usize::MAX);
        }
        if state.left > 0 {
            state.left -= 1;
            return Ok(usize::MAX);
        }
        state.armed = false;
        state.met = Some(step);
        match (self.trouble, step) {
            (Trouble::Input, _) => Err(io::Error::from_raw_os_error(5)),
            (Trouble::Short | Trouble::Torn, DiskOperation::Write(length)) => {
                state.torn = self.trouble == Trouble::Torn;
                Ok(length / 2)
            }
            _ => Err(no_space()),
        }
    }

    fn free(&self) -> Option<u64> {
        Some(1 << 40)
    }
}

/// Submits until the server accepts; returns the job.
async fn accepted(server: &Server, id: &str, script: &str) -> String {
    for _ in 0..1000 {
        if let Some(request) = submission(server, id, script).await
            && let Ok(accepted) = server.jobs().submit_job(request).await
        {
            return accepted.into_inner().status.unwrap().job_id;
        }
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
    panic!("{id} is not accepted");
}

/// Lives of jobs with a fault at each step, up to the first life without it; returns the number of faults.
async fn each(trouble: Trouble) -> usize {
    let folder = tempfile::tempdir().unwrap();
    let fault = Arc::new(OneFault { trouble, state: Mutex::default() });
    let server = Server::start_on(options(folder.path()), Disk::faulty(fault.clone())).await;
    let job = accepted(&server, "good", SCRIPT).await;
    let expected: Said = said(&server, &job).await;
    let mut lives = Vec::new();
    for step in 0..MANY {
        // Each has an upload of its own.
        let (id, script) = (format!("{trouble:?}-{step}"), format!("{SCRIPT}STEP {step}\n"));
        fault.arm(step);
        let job = accepted(&server, &id, &script).await;
        let status = server.wait(&job).await;
        let met = fault.disarm();
        assert_eq!(said(&server, &job).await, expected, "{id}: {met:?}");
        lives.push((id, script, job, status));
        if met.is_none() {
            break;
        }
    }
    server.stop().await;
    // Every accepted job is there after a restart, once, with the end that was seen.
    let server = Server::start(options(folder.path())).await;
    for (id, script, job, before) in &lives {
        let what = |status: &v1::JobStatus| (status.state(), status.attempt, status.ended_ms, status.events);
        assert_eq!(what(&server.status(job).await), what(before), "{id}");
        assert_eq!(said(&server, job).await, expected, "{id}");
        let request = submission(&server, id, script).await.unwrap();
        let again = server.jobs().submit_job(request).await.unwrap().into_inner();
        assert!(again.duplicate && again.status.unwrap().job_id == *job, "{id} once");
    }
    server.stop().await;
    let damages = doctor::examine(folder.path(), false).unwrap();
    assert!(damages.is_empty(), "{damages:?}");
    assert!(lives.len() < MANY, "{trouble:?} never runs out of steps");
    println!("{trouble:?} at {} steps", lives.len() - 1);
    lives.len() - 1
}

#[tokio::test]
async fn a_full_disk_at_any_step_of_a_job_loses_nothing() {
    assert!(each(Trouble::NoSpace).await >= 10);
}

#[tokio::test]
async fn an_input_or_output_error_at_any_step_of_a_job_loses_nothing() {
    assert!(each(Trouble::Input).await >= 10);
}

#[tokio::test]
async fn a_short_write_at_any_step_of_a_job_loses_nothing() {
    assert!(each(Trouble::Short).await >= 4);
}

#[tokio::test]
async fn a_write_that_is_torn_at_any_step_of_a_job_loses_nothing() {
    assert!(each(Trouble::Torn).await >= 4);
}
