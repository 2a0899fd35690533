//! Submits jobs and follows them.
//!
//! *Invariant:* every job that was due is measured, counted as an error, or both.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use counterpoint_client::{Client, Error, Update, request_id};
use counterpoint_proto::v1;
use tokio::sync::watch;
use tokio::task::JoinSet;
use tokio::time::{Instant, sleep_until, timeout};

use super::measure::{JobPhase, Measured, UNFINISHED, lock};
use super::mix::{JobKind, Mix};

/// Reason of jobs that were due while too many others were in progress.
const NOT_SENT: &str = "NOT_SENT";
/// Most jobs in progress at a rate.
const MOST_OPEN: u64 = 10_000;

/// How jobs become due.
#[derive(Debug, Clone, Copy)]
pub(super) enum ArrivalSchedule {
    /// This many a second.
    Rate(f64),
    /// When one of this many callers is free.
    Callers(usize),
}

impl std::fmt::Display for ArrivalSchedule {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Rate(rate) => write!(f, "{rate} jobs/s"),
            Self::Callers(1) => write!(f, "1 caller"),
            Self::Callers(callers) => write!(f, "{callers} callers"),
        }
    }
}

/// A load.
#[derive(Debug)]
pub(super) struct LoadRun {
    pub(super) mix: Mix,
    pub(super) pace: ArrivalSchedule,
    pub(super) clients: Vec<Client>,
    pub(super) until: Instant,
    /// Most jobs.
    pub(super) jobs: Option<u64>,
    pub(super) patience: Duration,
    pub(super) delete: bool,
    pub(super) measured: Arc<Mutex<Measured>>,
    /// Receives the first refusal that a retry cannot change.
    pub(super) refused: Arc<watch::Sender<Option<Error>>>,
}

/// The jobs that are still to come.
#[derive(Debug)]
struct JobSource {
    mix: Mix,
    left: u64,
    until: Instant,
}

impl JobSource {
    fn next(&mut self) -> Option<Arc<JobKind>> {
        if self.left == 0 || Instant::now() >= self.until {
            return None;
        }
        self.left -= 1;
        self.mix.next()
    }
}

/// Runs a load to its end.
pub(super) async fn drive(load: LoadRun) {
    let LoadRun { mix, pace, clients, until, jobs, patience, delete, measured, refused } = load;
    let mut source = JobSource { mix, left: jobs.unwrap_or(u64::MAX), until };
    let mut running = JoinSet::new();
    // Turned on when patience is at its end.
    let over = watch::Sender::new(false);
    let of = |client: &Client| LoadCaller {
        client: client.clone(),
        delete,
        measured: measured.clone(),
        over: over.subscribe(),
        refused: refused.clone(),
    };
    match pace {
        ArrivalSchedule::Callers(callers) => {
            let source = Arc::new(Mutex::new(source));
            for client in clients.iter().cycle().take(callers) {
                let (mut caller, source) = (of(client), source.clone());
                running.spawn(async move {
                    while let Some(job) = next(&source) {
                        caller.job(&job, Instant::now()).await;
                    }
                });
            }
            sleep_or_end(until, &mut running).await;
        }
        ArrivalSchedule::Rate(rate) => {
            let start = Instant::now();
            for (number, client) in (0_u32..).zip(clients.iter().cycle()) {
                let due = start + Duration::from_secs_f64(f64::from(number) / rate);
                sleep_until(due).await;
                let Some(job) = source.next() else { break };
                while running.try_join_next().is_some() {}
                if running.len() as u64 >= MOST_OPEN {
                    lock(&measured).error(NOT_SENT);
                    continue;
                }
                let mut caller = of(client);
                running.spawn(async move { caller.job(&job, due).await });
            }
        }
    }
    if timeout(patience, all(&mut running)).await.is_err() {
        over.send_replace(true);
        all(&mut running).await;
    }
}

fn next(source: &Mutex<JobSource>) -> Option<Arc<JobKind>> {
    source.lock().unwrap_or_else(std::sync::PoisonError::into_inner).next()
}

async fn all(running: &mut JoinSet<()>) {
    while running.join_next().await.is_some() {}
}

/// Waits until then, or until all callers are done.
async fn sleep_or_end(until: Instant, running: &mut JoinSet<()>) {
    tokio::select! {
        () = sleep_until(until) => {}
        () = all(running) => {}
    }
}

/// Submits and follows one job at a time.
struct LoadCaller {
    client: Client,
    delete: bool,
    measured: Arc<Mutex<Measured>>,
    over: watch::Receiver<bool>,
    refused: Arc<watch::Sender<Option<Error>>>,
}

impl LoadCaller {
    async fn job(&mut self, job: &JobKind, due: Instant) {
        lock(&self.measured).open += 1;
        let mut over = self.over.clone();
        let done = tokio::select! {
            done = self.follow(job, due) => done,
            _ = over.wait_for(|over| *over) => Err(UNFINISHED.to_owned()),
        };
        let mut measured = lock(&self.measured);
        measured.open -= 1;
        if let Err(reason) = done {
            measured.error(&reason);
        }
    }

    async fn follow(&self, job: &JobKind, due: Instant) -> Result<(), String> {
        let request = v1::SubmitJobRequest { request_id: request_id(), ..job.request.clone() };
        // Not repeated: refusals by the server are to be counted.
        let answer = self.client.jobs().submit_job(request).await.map_err(|status| self.refusal(status.into()))?;
        let id = answer.into_inner().status.unwrap_or_default().job_id;
        {
            let mut measured = lock(&self.measured);
            measured.time(JobPhase::Submit, due, due.elapsed());
            measured.submitted(&job.name);
        }
        let Some(level) = job.watch else { return Ok(()) };
        let mut watch = self.client.watch(&id, level);
        let mut first = true;
        let status = loop {
            match watch.next().await.map_err(|error| reason(&error))? {
                Update::Events(batch) => {
                    let mut measured = lock(&self.measured);
                    measured.events(batch.events.len() as u64);
                    if std::mem::take(&mut first) {
                        measured.time(JobPhase::FirstEvent, due, due.elapsed());
                    }
                }
                Update::Ended(status) => break status,
                Update::Description(_) | Update::Progress(_) => {}
            }
        };
        {
            let mut measured = lock(&self.measured);
            let queued = u64::try_from(status.started_ms.saturating_sub(status.submitted_ms)).unwrap_or(0);
            measured.time(JobPhase::Queue, due, Duration::from_millis(queued));
            measured.time(JobPhase::End, due, due.elapsed());
            measured.ended();
        }
        if self.delete {
            let delete = v1::DeleteJobRequest { job_id: id };
            self.client.jobs().delete_job(delete).await.map_err(|status| reason(&status.into()))?;
        }
        match status.state() {
            v1::JobState::Succeeded => Ok(()),
            state => Err(format!("JOB_{}", state.as_str_name().trim_start_matches("JOB_STATE_"))),
        }
    }
}

impl LoadCaller {
    /// The reason of a refused submission; stops the load if every further job would also be refused.
    fn refusal(&self, error: Error) -> String {
        let reason = reason(&error);
        if is_lasting(&error) {
            self.refused.send_if_modified(|first| {
                let is_first = first.is_none();
                first.get_or_insert(error);
                is_first
            });
        }
        reason
    }
}

/// Whether the same submission would be refused again, regardless of other jobs.
fn is_lasting(error: &Error) -> bool {
    use tonic::Code;
    const LASTING: [Code; 5] = [
        Code::InvalidArgument,
        Code::NotFound,
        Code::Unauthenticated,
        Code::PermissionDenied,
        Code::FailedPrecondition,
    ];
    matches!(error, Error::Refused(status) if LASTING.contains(&status.code()))
}

/// Why something failed, as one of few words.
fn reason(error: &Error) -> String {
    error.reason().unwrap_or_else(|| match error {
        Error::Settings(_) => "SETTINGS".to_owned(),
        Error::Unreachable { .. } => "UNREACHABLE".to_owned(),
        Error::Refused(status) => format!("CONNECTION ({:?})", status.code()),
        Error::Contract(_) => "CONTRACT".to_owned(),
    })
}
