//! Cancels and pauses that are stored before the end of the run reaches the ledger.

use std::sync::mpsc::channel;

use super::*;
use crate::ledger::record::JobState;
use crate::ledger::record::tests::{record, work};
use crate::local::disk::Disk;

/// A ledger with a job, and the job as a worker copies it before the calls of clients.
struct Bench {
    ledger: LocalLedger,
    copy: JobRecord,
    runtime: tokio::runtime::Runtime,
}

impl Bench {
    fn new(folder: &tempfile::TempDir) -> Self {
        let store = DataFolder::open(folder.path().to_owned(), true, Disk::default()).unwrap();
        let ledger = LocalLedger::open(&store, Arc::new(Metrics::new())).unwrap();
        let runtime = tokio::runtime::Builder::new_current_thread().build().unwrap();
        let job = Box::new(NewJob { record: record("r"), work: work() });
        let submitted = runtime.block_on(ledger.submit(job, Box::new(|_| Ok(())), Box::new(|_| ()))).unwrap();
        let SubmitOutcome::New(copy) = submitted else { panic!("{submitted:?}") };
        Self { ledger, copy: *copy, runtime }
    }

    fn cancel(&self) {
        self.runtime.block_on(self.ledger.flag_cancel(self.copy.id.clone())).unwrap();
    }

    fn pause(&self, paused: bool) {
        self.runtime.block_on(self.ledger.flag_paused(self.copy.id.clone(), paused)).unwrap();
    }

    /// Stores the end that the worker has written to its copy.
    fn end(&self, state: JobState) {
        let (answer, answered) = channel();
        let mut record = JobRecord { state, ..self.copy.clone() };
        if state.ended() {
            record.end(&crate::clock::Clock::from(0));
        }
        self.ledger.end(record, None, Box::new(move |kept| answer.send(kept).unwrap()));
        answered.recv().unwrap().unwrap();
    }

    /// State, whether a cancel was accepted, and whether the job is held back.
    fn stored(&self) -> (JobState, bool, bool) {
        let stored = self.ledger.job(&self.copy.id).unwrap().unwrap();
        (stored.state, stored.cancel, stored.paused)
    }
}

#[test]
fn a_pause_that_was_stored_stays_when_a_drain_has_stopped_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let bench = Bench::new(&folder);
    bench.pause(true);
    bench.end(JobState::Queued);
    assert_eq!(bench.stored(), (JobState::Queued, false, true));
    let resumed = JobRecord { paused: true, ..bench.copy.clone() };
    let bench = Bench { copy: resumed, ..bench };
    bench.pause(false);
    bench.end(JobState::Queued);
    assert_eq!(bench.stored(), (JobState::Queued, false, false), "a resume stays, too");
    bench.pause(true);
    bench.end(JobState::Succeeded);
    assert_eq!(bench.stored(), (JobState::Succeeded, false, false), "an ended job is not held back");
}

#[test]
fn a_cancel_that_was_accepted_stays_whichever_of_it_and_the_end_is_stored_first() {
    for cancel_first in [true, false] {
        let folder = tempfile::tempdir().unwrap();
        let bench = Bench::new(&folder);
        if cancel_first {
            bench.cancel();
        }
        bench.end(JobState::Succeeded);
        let usage = bench.ledger.usage(&bench.copy.tenant).unwrap();
        if !cancel_first {
            bench.cancel();
        }
        assert_eq!(bench.stored(), (JobState::Succeeded, true, false), "cancel first: {cancel_first}");
        assert_eq!(bench.ledger.usage(&bench.copy.tenant).unwrap(), usage, "the job counts once");
    }
}
