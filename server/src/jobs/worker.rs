//! Jobs on worker threads.
//!
//! Invariant: after every run, even a failed one, the place is returned and the server continues. The job gets an end
//! state, unless the host has failed the run (disk, descriptors, threads): then the run is dropped and the job waits
//! for another.

use std::any::Any;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use counterpoint_kernel::control::{JobControl, StopSignal};
use counterpoint_kernel::job::{RunEnd, STACK};
use counterpoint_kernel::log::builder::ResultsBuilder;
use counterpoint_kernel::log::event::VerdictKind;
use counterpoint_kernel::log::summary;
use counterpoint_kernel::machine::finding::Finding;
use counterpoint_kernel::options::JobOptions;
use prost::Message as _;

use super::attended::DeskOperator;
use super::describe::description;
use super::ends::JobEnd;
use super::files::JobSandbox;
use super::limits::Stopped;
use super::live::{LiveJob, PreparedRun};
use super::seal::{Change, RESULTS_FROM, seal};
use super::sink::JobSink;
use super::system::Shell;
use super::{Core, received, reuse};
use crate::cpu;
use crate::ledger::first_error::FirstError;
use crate::ledger::record::{Cause, JobRecord, JobState, JobWork, ReachedLimit};
use crate::log::wanted::ResultGate;
use crate::log::writer::{FinishedLog, Small, Writer};
use crate::machines::MachineRecord;
use crate::pace::LogRateLimit;
use crate::reason::Refusal;
use crate::results::{Finished, StoredResult};
use crate::runner::{PreparedJob, ResolvedJob};

/// Lines about runs that the host has failed.
static FAILED_BY_HOST: LogRateLimit = LogRateLimit::new();

/// Starts a worker thread for a job, and for others while they wait.
pub(super) fn start(core: Arc<Core>, live: Arc<LiveJob>) {
    let (spare_core, spare_live) = (core.clone(), live.clone());
    let work = move || {
        cpu::run_after_callers();
        work(&core, &live);
        drop(live);
        while let Some(live) = core.take() {
            work(&core, &live);
        }
    };
    let started = std::thread::Builder::new().name("job".to_owned()).stack_size(STACK).spawn(work);
    if let Err(error) = started {
        again(&spare_core, spare_live, format!("no thread for the job: {error}"), Duration::ZERO);
    }
}

fn work(core: &Arc<Core>, live: &Arc<LiveJob>) {
    let span = live.span();
    let _inside = span.enter();
    let begin = cpu::of_this_thread();
    let used = || cpu::of_this_thread().saturating_sub(begin) + live.cpu();
    let work = || match run(core, live)? {
        Ran::Over(change) => Ok(Some((change, None))),
        Ran::Reused(change, log) => Ok(Some((change, log))),
        Ran::Through(through) => through.store(core, live).map(Some),
        Ran::Paused => Ok(None),
    };
    let (change, log) = match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(Some(stored))) => stored,
        Ok(Ok(None)) => return paused(core, live, used()),
        Ok(Err(Refusal::Storage(trouble))) => return again(core, live.clone(), trouble, used()),
        Ok(Err(refusal)) => (failed(refusal.to_string()), None),
        Err(panic) => (failed(format!("internal error: {}", panic_text(&*panic))), None),
    };
    end(core, live, change, log, used());
}

fn failed(error: String) -> Change {
    Box::new(|record| {
        record.state = JobState::Failed;
        record.runs.cause = Some(Cause::Host);
        record.error = error;
    })
}

fn refused((cause, findings): (Cause, Vec<Finding>)) -> Change {
    let first = findings.iter().find(|f| f.error).or(findings.first());
    let error = first.map_or_else(|| "the job cannot be run".to_owned(), ToString::to_string);
    Box::new(move |record| {
        record.state = JobState::Failed;
        record.runs.cause = Some(cause);
        record.error = error;
        record.first_error = findings
            .iter()
            .find(|finding| finding.error)
            .map(|finding| FirstError::new(0, (&finding.text, &finding.file), finding.line, 0));
        record.findings = findings.into_iter().map(Into::into).collect();
    })
}

/// The server is going down: the next one runs the job.
fn queued_again() -> Change {
    Box::new(|record| {
        record.state = JobState::Queued;
        record.runs.drop_last();
    })
}

/// The run has reached a limit of the server before it was prepared.
fn late((reached, limit): Stopped) -> Change {
    Box::new(move |record| {
        record.state = JobState::Failed;
        (record.runs.cause, record.runs.reached) = (Some(Cause::Limit), Some(reached));
        record.verdict.clone_from(&limit);
        record.runs.limit = limit;
    })
}

fn panic_text(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("panic")
}

/// Drops a run that the host has failed and lets the job wait for another. Nothing has to be durable for that: the
/// ledger holds the job as queued all the time.
fn again(core: &Arc<Core>, live: Arc<LiveJob>, trouble: String, used: Duration) {
    core.metrics.jobs.failed_by_host.inc();
    if let Some(left_out) = FAILED_BY_HOST.pass() {
        tracing::warn!(trouble, left_out, "the host has failed the run; the job waits for another");
    }
    let record = drop_run(core, &live, used, |record| {
        record.runs.host_failures = record.runs.host_failures.saturating_add(1);
        record.runs.host_failure = trouble;
    });
    core.again(&live, record.runs.host_failures);
}

/// Drops a run that a pause has stopped; the ledger holds the job as queued and paused.
fn paused(core: &Arc<Core>, live: &Arc<LiveJob>, used: Duration) {
    drop_run(core, live, used, |_| {});
    core.aside(live);
}

/// Drops a run that does not count as an attempt.
fn drop_run(core: &Core, live: &LiveJob, used: Duration, change: impl FnOnce(&mut JobRecord)) -> JobRecord {
    live.forget_run();
    if let Err(error) = core.logs.remove(&live.id) {
        tracing::warn!(%error, "the results of the unfinished run stay until the next run");
    }
    live.change(|record| {
        if std::mem::replace(&mut record.state, JobState::Queued) == JobState::Running {
            record.runs.drop_last();
        }
        record.runs.cpu_us = record.runs.cpu_us.saturating_add(cpu::micros(used));
        change(record);
    })
}

/// Between two looks at whether the run is to end.
const LOOK: Duration = Duration::from_millis(50);

/// Hands the end over, to be made durable and then visible.
fn end(core: &Arc<Core>, live: &Arc<LiveJob>, change: Change, log: Option<Small>, used: Duration) {
    let mut record = live.record();
    change(&mut record);
    record.runs.cpu_us = record.runs.cpu_us.saturating_add(cpu::micros(used));
    record.runs.suspect = false;
    if record.state.ended() {
        record.paused = false;
        record.end(&core.board.clock);
    }
    core.leave(live);
    JobEnd::new(core, live, record, log).keep();
}

/// Data that a run leaves to be stored.
struct Through {
    outcome: RunEnd,
    finished: Finished,
    limit: String,
    reached: Option<ReachedLimit>,
    writer: Option<Writer>,
    /// Digest by which equal jobs find the results; empty if equal jobs may not use these results.
    digest: String,
}

/// A run that is over.
enum Ran {
    /// Nothing is to be stored but the state.
    Over(Change),
    Through(Box<Through>),
    /// Whether the results of an equal job have been copied.
    Reused(Change, Option<Small>),
    /// The job is held back.
    Paused,
}

fn run(core: &Arc<Core>, live: &Arc<LiveJob>) -> Result<Ran, Refusal> {
    let work = live.take_work().map_or_else(|| core.work(&live.id), Ok)?;
    // A run that takes the server down has left its mark.
    let record = core.begin_run(live)?;
    core.changed(live);
    let or_most = |asked: u64, most: u64| if asked == 0 { most } else { asked.min(most) };
    let wall_ms = or_most(record.runs.wall_ms, core.options.maxima.max_wall_ms);
    let max_job_bytes = or_most(record.runs.max_job_bytes, core.options.maxima.max_job_bytes);
    live.set_limits(wall_ms, max_job_bytes, record.asked.deadline_ms);
    live.check_clock(Instant::now());
    // A cancel that came while the job waited for another run.
    let stop = live.stop();
    if live.cancelled() || live.reached().is_some() {
        stop.ask();
    }
    let digest = reuse::digest_of(core, &record, &work, wall_ms, max_job_bytes);
    if let Some(digest) = digest.as_ref().filter(|_| !stop.asked())
        && let Some((change, log)) = reuse::take(core, live, &record, digest)?
    {
        return Ok(Ran::Reused(change, log));
    }
    let outcomes = work.outcomes();
    let JobWork { machine, files, options, .. } = work;
    let files = JobSandbox::new(core.blobs.of(&record.tenant), files);
    let options = JobOptions { threads: core.threads(options.threads), ..options };
    let trusted = machine.trusted;
    let prepared = prepare_with(core, &record, &machine, options, &files, &stop)?;
    files.trouble()?;
    let prepared = match prepared {
        Ok(prepared) => prepared,
        Err(_) if live.cancelled() => return Ok(Ran::Over(Box::new(|record| record.state = JobState::Cancelled))),
        Err(_) if let Some(stopped) = live.reached() => return Ok(Ran::Over(late(stopped))),
        Err(_) if stop.asked() => return Ok(interrupted(core)),
        Err(findings) => return Ok(Ran::Over(refused(findings))),
    };
    let info = prepared.info().clone();
    let mut control = JobControl::new(info.channels.len()).with_stop(stop).with_cpu_clock(cpu::of_this_thread);
    if record.attended {
        let tenant = live.peek(|record| record.tenant.clone());
        *live.desk().received() = Some(received::received_before(core, &tenant, &outcomes));
        live.desk().record(outcomes);
        live.desk().set_patience(Duration::from_secs(core.options.system.operator_wait_s));
        let (ledger, desk, job) = (core.ledger.clone(), live.desk().clone(), live.id.clone());
        control = control.with_operator(Arc::new(DeskOperator { ledger, desk, job }));
    }
    if record.stepped {
        live.stepping().set_patience(Duration::from_secs(core.options.system.operator_wait_s));
        control = control.with_console(live.stepping().clone());
    }
    if core.options.system.allow_system && trusted {
        let shell = Shell::new(core.host.scratch(), core.options.system.system_wait_s);
        control = control.with_system(Arc::new(shell));
    }
    let control = Arc::new(control);
    live.prepared(PreparedRun { info: info.clone(), control: control.clone() });
    if core.options.embedded.log {
        let head = description(&info).encode_to_vec();
        let place = core.logs.begin(&live.id)?;
        live.begin_log(Writer::new(&live.id, place, live.tail().clone(), &info, &head));
    }
    let results = ResultsBuilder::new(&info);
    let results = if core.options.embedded.toolpath { results } else { results.without_toolpath() };
    let mut sink = JobSink::new(live, core, results);
    let outcome = prepared.run(&files, &control, &mut sink);
    let JobSink { builder, files: written, dropped, cut, error, .. } = sink;
    let writer = live.end_log();
    let blocks = control.progress().iter().map(|progress| progress.blocks.load(Ordering::Relaxed)).sum();
    core.metrics.jobs.blocks.inc_by(blocks);
    if let Some(error) = error {
        return Err(Refusal::Storage(format!("the event log cannot be kept: {error}")));
    }
    files.trouble()?;
    let limit = live.reached().filter(|_| outcome.cancelled || dropped).filter(|_| !live.cancelled());
    if cut || outcome.cancelled && limit.is_none() && !live.cancelled() {
        return Ok(interrupted(core));
    }
    let (reached, limit) = match limit {
        Some((reached, limit)) => (Some(reached), limit),
        None => (control.reached().map(ReachedLimit::from), String::new()),
    };
    let finished = Finished::new(builder.finish(&outcome), written, &limit);
    let digest = digest.filter(|_| reached.is_none() && !control.used_outside()).unwrap_or_default();
    Ok(Ran::Through(Box::new(Through { outcome, finished, limit, reached, writer, digest })))
}

/// The run was stopped although its job has not ended: by a drain or a pause.
fn interrupted(core: &Core) -> Ran {
    if core.drain.begun() { Ran::Over(queued_again()) } else { Ran::Paused }
}

impl Through {
    /// Stores log and results; a log that is small goes into the ledger with the end of the job.
    fn store(self, core: &Arc<Core>, live: &LiveJob) -> Result<(Change, Option<Small>), Refusal> {
        let Self { outcome, finished, limit, reached, writer, digest } = self;
        let bytes = writer.as_ref().map_or(0, Writer::bytes);
        let has_files = !finished.files.is_empty();
        let (log, mut place) = match writer.map(Writer::finish).transpose()? {
            Some(FinishedLog::Small(log)) => (Some(log), None),
            Some(FinishedLog::Placed(place)) => (None, Some(place)),
            None => (None, None),
        };
        let packed = place.as_mut().map_or(Ok(bytes), |place| place.pack())?;
        let finished = Finished { log: log.as_ref().map(|log| log.bytes.clone()), ..finished };
        let (finished, stored_bytes) = keep(core, live, finished, bytes)?;
        let stored_bytes = stored_bytes.saturating_sub(bytes) + packed;
        seal(core, live, place, has_files)?;
        let verdict = finished.results.summary.verdict.as_ref();
        let own_limit = verdict.is_some_and(|verdict| verdict.kind == VerdictKind::Limit);
        let cause = if reached.is_some() || own_limit { Cause::Limit } else { Cause::Program };
        let change: Change = Box::new(move |record| {
            let summary = &finished.results.summary;
            record.state = match summary.state {
                summary::JobOutcome::Cancelled => JobState::Cancelled,
                summary::JobOutcome::Failed => JobState::Failed,
                summary::JobOutcome::Succeeded => JobState::Succeeded,
            };
            record.runs.cause = (record.state == JobState::Failed).then_some(cause);
            record.first_error = FirstError::of(summary).filter(|_| record.state == JobState::Failed);
            record.runs.reached = reached.filter(|_| record.state == JobState::Failed);
            record.events = outcome.events;
            record.runs.limit = limit;
            record.runs.has_files = has_files;
            record.runs.stored_bytes = stored_bytes;
            record.makespan_ns = summary.makespan_ns;
            record.log_digest.clone_from(&summary.log_digest);
            record.highest_severity = summary.highest_severity;
            record.verdict = summary.verdict.as_ref().map_or_else(String::new, |verdict| verdict.text.clone());
            record.reuse.digest = digest;
            if !record.log_is_final() {
                record.reuse.digest.clear();
            }
        });
        Ok((change, log))
    }
}

/// Unusable parts of a job, and the reasons.
type Unusable = (Cause, Vec<Finding>);

/// Loads the machine and the programs of a job, or says which of them cannot be used.
pub(crate) fn prepare(
    core: &Core,
    record: &JobRecord,
    work: JobWork,
    files: &JobSandbox,
    stop: &StopSignal,
) -> Result<Result<Box<dyn PreparedJob>, Unusable>, Refusal> {
    prepare_with(core, record, &work.machine, work.options, files, stop)
}

fn prepare_with(
    core: &Core,
    record: &JobRecord,
    machine: &MachineRecord,
    options: JobOptions,
    files: &JobSandbox,
    stop: &StopSignal,
) -> Result<Result<Box<dyn PreparedJob>, Unusable>, Refusal> {
    let checked = core.machines.load(machine)?;
    let Some(machine) = checked.machine else { return Ok(Err((Cause::Machine, checked.findings))) };
    let task = ResolvedJob { machine, programs: record.programs.clone(), options };
    Ok(core.runner.prepare(task, files, stop).map_err(|findings| (Cause::Program, findings)))
}

/// Stores the results that take time to make from the log, and keeps all results in memory for a while. `bytes`: of the
/// log. Also returns the bytes of log, files and results.
fn keep(core: &Arc<Core>, live: &LiveJob, mut finished: Finished, bytes: u64) -> Result<(Arc<Finished>, u64), Refusal> {
    let files = if finished.files.is_empty() { None } else { finished.document(StoredResult::Files) };
    finished.bytes = bytes + files.as_ref().map_or(0, |files| files.len() as u64);
    let finished = Arc::new(finished);
    live.keep(finished.clone());
    let mut stored = finished.bytes;
    if core.options.embedded.ephemeral {
        return Ok((finished, stored));
    }
    if let Some(files) = files {
        core.logs.write(&live.id, StoredResult::Files.file(), &files)?;
    }
    if bytes >= RESULTS_FROM {
        stored += store_results(core, live, finished.clone());
    }
    Ok((finished, stored))
}

/// Stores results that can be made again; returns their bytes. This may take long: if the run is to end meanwhile, the
/// remaining results are not stored. Results that are not stored are made from the log on request.
fn store_results(core: &Core, live: &LiveJob, finished: Arc<Finished>) -> u64 {
    let (done, stored) = channel();
    let (logs, id, run) = (core.logs.clone(), live.id.clone(), live.run());
    let wanted = Arc::new(ResultGate::default());
    let still = wanted.clone();
    let store = move || {
        for document in StoredResult::ALL.into_iter().filter(|document| *document != StoredResult::Files) {
            if let Some(text) = finished.document(document) {
                logs.write_spare(&id, document.file(), &text, &still)?;
                // If the receiver is gone, the run has ended without this result.
                let _ = done.send(text.len() as u64);
            }
        }
        Ok(())
    };
    let work = move || {
        let stored: io::Result<()> = match run {
            Some(run) => run.control.measured(store),
            None => store(),
        };
        match stored {
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => tracing::warn!(%error, "results are not stored; they will be made from the log"),
            Ok(()) => {}
        }
    };
    if let Err(error) = std::thread::Builder::new().name("results".to_owned()).spawn(work) {
        tracing::warn!(%error, "results are not stored; they will be made from the log");
    }
    let mut bytes = 0;
    loop {
        match stored.recv_timeout(LOOK) {
            Ok(more) => bytes += more,
            Err(RecvTimeoutError::Timeout) if !live.stop().asked() => {}
            Err(_) => {
                wanted.end();
                return stored.try_iter().fold(bytes, |bytes, more| bytes + more);
            }
        }
    }
}
