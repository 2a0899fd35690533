//! One job on its own thread.
//!
//! Invariant: whatever happens in a run (refusal, error of storage, panic), the job gets an end state and the place
//! is given back; the server lives on.

use std::any::Any;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use counterpoint_kernel::control::{Control, Stop};
use counterpoint_kernel::log::fold::Folds;
use counterpoint_kernel::log::summary;
use counterpoint_kernel::machine::finding::Finding;
use prost::Message as _;

use super::Core;
use super::describe::description;
use super::files::Sandbox;
use super::live::{Live, Run};
use super::sink::JobSink;
use super::system::Shell;
use crate::ledger::record::{Record, State, now_ms};
use crate::log::writer::Writer;
use crate::reason::Refusal;
use crate::results::{Document, Finished};
use crate::runner::{Prepared, Task};

/// Time between two looks at whether a job is to end while its results are stored.
const LOOK: Duration = Duration::from_millis(50);

/// Starts the worker thread of a job.
pub(super) fn start(core: Arc<Core>, live: Arc<Live>) {
    let tail = live.id.len().saturating_sub(8);
    let name = format!("job-{}", live.id.get(tail..).unwrap_or_default());
    let (spare_core, spare_live) = (core.clone(), live.clone());
    let started = std::thread::Builder::new().name(name).spawn(move || work(&core, &live));
    if let Err(error) = started {
        end(&spare_core, &spare_live, failed(format!("no thread for the job: {error}")));
    }
}

fn work(core: &Arc<Core>, live: &Live) {
    let span = tracing::info_span!("job", id = live.id);
    let _inside = span.enter();
    let change = match catch_unwind(AssertUnwindSafe(|| run(core, live))) {
        Ok(Ok(change)) => change,
        Ok(Err(refusal)) => failed(refusal.to_string()),
        Err(panic) => failed(format!("internal error: {}", panic_text(&*panic))),
    };
    end(core, live, change);
}

/// Change of a record at the end of a run.
type Change = Box<dyn FnOnce(&mut Record)>;

fn failed(error: String) -> Change {
    Box::new(|record| {
        record.state = State::Failed;
        record.error = error;
    })
}

fn refused(findings: Vec<Finding>) -> Change {
    let first = findings.iter().find(|f| f.error).or(findings.first());
    let error = first.map_or_else(|| "the job cannot be run".to_owned(), ToString::to_string);
    Box::new(|record| {
        record.state = State::Failed;
        record.error = error;
        record.findings = findings.into_iter().map(Into::into).collect();
    })
}

/// The server is going down: the next one runs the job.
fn again() -> Change {
    Box::new(|record| {
        record.state = State::Queued;
        record.attempt -= 1;
    })
}

fn panic_text(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("panic")
}

/// Makes the end durable, then visible.
fn end(core: &Arc<Core>, live: &Live, change: Change) {
    let mut record = live.record();
    change(&mut record);
    if record.state.ended() {
        record.ended_ms = now_ms();
    }
    if let Err(error) = core.ledger.update_blocking(record.clone()) {
        // The job stays RUNNING in the ledger and is run again by the next server.
        tracing::error!(%error, "the end of the job could not be kept");
        record.error = error.to_string();
        record.state = State::Failed;
    }
    tracing::info!(state = ?record.state, events = record.events, error = record.error, "ended");
    live.change(|now| *now = Record { cancel: now.cancel, ..record });
    core.free(live);
}

fn run(core: &Arc<Core>, live: &Live) -> Result<Change, Refusal> {
    // Durable, then visible: a run that takes the server down has been counted.
    let begun = core.ledger.begin_blocking(live.id.clone(), now_ms())?;
    let record = live.change(|record| {
        (record.state, record.attempt, record.started_ms) = (begun.state, begun.attempt, begun.started_ms);
    });
    let files = Sandbox::new(core.blobs.clone(), &record.files);
    let prepared = match prepare(core, &record, &files, live.stop())? {
        Ok(prepared) => prepared,
        Err(_) if live.cancelled() => return Ok(Box::new(|record| record.state = State::Cancelled)),
        Err(_) if live.stop().asked() => return Ok(again()),
        Err(findings) => return Ok(refused(findings)),
    };
    let info = prepared.info().clone();
    let mut control = Control::new(info.channels.len()).with_stop(live.stop().clone());
    if record.options.attended {
        live.desk.set_patience(Duration::from_secs(core.options.operator_wait_s));
        control = control.with_operator(live.desk.clone());
    }
    if core.options.allow_system {
        control = control.with_system(Arc::new(Shell::new(core.store.tmp(), core.options.system_wait_s)));
    }
    let control = Arc::new(control);
    live.prepared(Run { info: info.clone(), control: control.clone() });
    if core.options.log {
        let head = description(&info).encode_to_vec();
        live.begin_log(Writer::create(&core.store.log(&live.id), live.tail.clone(), &info, &head)?);
    }
    let mut sink = JobSink::new(live, core.options.log, Folds::new(&info));
    let outcome = prepared.run(&files, &control, &mut sink);
    let JobSink { folds, files, error, .. } = sink;
    let writer = live.end_log();
    if let Some(error) = error {
        return Ok(failed(format!("the event log cannot be kept: {error}")));
    }
    if let Some(writer) = writer {
        writer.finish(core.store.durable())?;
    }
    if outcome.cancelled && !live.cancelled() && core.drain.begun() {
        return Ok(again());
    }
    let finished = Arc::new(Finished { results: folds.finish(&outcome), files });
    keep(core, live, &finished)?;
    Ok(Box::new(move |record| {
        let summary = &finished.results.summary;
        record.state = match summary.state {
            summary::State::Cancelled => State::Cancelled,
            summary::State::Failed => State::Failed,
            summary::State::Succeeded => State::Succeeded,
        };
        record.events = outcome.events;
        record.makespan_ns = summary.makespan_ns;
        record.log_digest.clone_from(&summary.log_digest);
        record.highest_severity = summary.highest_severity;
        record.verdict = summary.verdict.as_ref().map_or_else(String::new, |verdict| verdict.text.clone());
    }))
}

/// Loads the machine and the programs of a job.
pub(crate) fn prepare(
    core: &Core,
    record: &Record,
    files: &Sandbox,
    stop: &Stop,
) -> Result<Result<Box<dyn Prepared>, Vec<Finding>>, Refusal> {
    let checked = core.machines.load(&record.machine)?;
    let Some(machine) = checked.machine else { return Ok(Err(checked.findings)) };
    let task = Task { machine, programs: record.programs.clone(), options: record.options.clone() };
    Ok(core.runner.prepare(task, files, stop))
}

/// Keeps the results in memory, and stores them when they are to survive. That may take long: when the run is to end
/// meanwhile, it goes on by itself behind the end of the job.
fn keep(core: &Arc<Core>, live: &Live, finished: &Arc<Finished>) -> io::Result<()> {
    live.keep(finished.clone());
    if core.options.ephemeral {
        return Ok(());
    }
    let (done, stored) = channel();
    let (core, finished, folder) = (core.clone(), finished.clone(), core.store.job(&live.id));
    let work = move || {
        let stored = store(&core, &folder, &finished);
        if let Err(Err(error)) = done.send(stored).map_err(|unheard| unheard.0) {
            tracing::warn!(%error, "results of a job that was asked to end could not be kept");
        }
    };
    std::thread::Builder::new().name("results".to_owned()).spawn(work)?;
    loop {
        match stored.recv_timeout(LOOK) {
            Ok(result) => return result,
            Err(RecvTimeoutError::Timeout) if live.stop().asked() => return Ok(()),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Err(io::Error::other("the results could not be made")),
        }
    }
}

fn store(core: &Core, folder: &Path, finished: &Finished) -> io::Result<()> {
    for document in Document::ALL {
        if let Some(text) = finished.document(document) {
            core.store.write(&folder.join(document.file()), &text)?;
        }
    }
    Ok(())
}
