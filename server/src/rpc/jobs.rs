//! Service `JobsService`.

use std::sync::Arc;
use std::time::Duration;

use counterpoint_proto::v1;
use counterpoint_proto::v1::jobs_server::Jobs as Service;
use prost::Message as _;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tonic::codec::SingleMessageCompressionOverride;
use tonic::{Request, Response, Status};
use tracing::Instrument as _;

use super::door::{enter, page_token};
use super::many::{self, BulkAction, Choice};
use super::submit::CheckedRequest;
use super::{JobsService, job, look_up, submit, to_the_end, watch, watch_jobs};
use crate::access::Caller;
use crate::jobs::Core;
use crate::jobs::describe::{description, options, status};
use crate::jobs::filter::{JobConditions, States};
use crate::jobs::operator_wait::status_now;
use crate::jobs::progress;
use crate::jobs::suspicion::LoneSuspect;
use crate::jobs::worker_wait;
use crate::ledger::record::{JobRecord, JobState};
use crate::ledger::{NewJob, PAGE_BYTES, Query};
use crate::log::reader::LogReader;
use crate::memory::MemoryReservation;
use crate::reason::Refusal;
use crate::trace;

/// Memory of a submit in progress, in sizes of its message: as it came, its digest, its work, and rows of the ledger.
const SUBMIT_COPIES: u64 = 6;
/// Memory of an answer that is made and sent, in sizes of its content.
const ANSWER_COPIES: u64 = 3;

/// An answer whose memory is counted until it has been sent.
fn counted<T>(answer: T, taken: MemoryReservation) -> Response<T> {
    let mut response = Response::new(answer);
    response.extensions_mut().insert(Arc::new(taken));
    response
}

/// Hands a job over and notes its id for the audit log; holds the memory `taken` until then.
async fn submitted(
    core: &Arc<Core>,
    caller: &Caller,
    job: Box<NewJob>,
    taken: MemoryReservation,
) -> Result<(Box<JobRecord>, bool), Refusal> {
    let (core, noted) = (core.clone(), caller.clone());
    // The line names no job until the new job exists: the job that is run again does not change.
    caller.about_jobs(&[]);
    caller.asks(&[format!("request {}", job.record.request_id)]);
    let submit = async move {
        let _taken = taken;
        let (record, duplicate) = core.submit(job).await?;
        noted.about(&record.id);
        Ok((record, duplicate))
    };
    to_the_end(caller, submit).await
}

/// The answer to a request that repeats an earlier one; notes the job for the audit log.
fn known(caller: &Caller, record: Box<JobRecord>) -> (Box<JobRecord>, bool) {
    caller.about(&record.id);
    (record, true)
}

/// Names the missing files of a job that is to run again: its client knows their paths, not their digests.
fn by_path(refusal: Refusal, files: &[(String, String)]) -> Refusal {
    let Refusal::MissingBlobs(digests) = refusal else { return refusal };
    let lost: Vec<_> = files.iter().filter(|(_, digest)| digests.contains(digest)).cloned().collect();
    // Else a file of the machine is missing.
    if lost.is_empty() { Refusal::MissingBlobs(digests) } else { Refusal::LostFiles(lost) }
}

/// A stream without compression, as almost every client says that it accepts gzip: to compress the events of a job
/// takes more processor time than to send them, and small frames count as a flood.
fn plain<T>(receive: mpsc::Receiver<T>) -> Response<ReceiverStream<T>> {
    let mut response = Response::new(ReceiverStream::new(receive));
    response.extensions_mut().insert(SingleMessageCompressionOverride::Disable);
    response
}

/// The status of a job, with the reason for its wait.
fn status_with_waits(core: &Core, record: JobRecord) -> v1::JobStatus {
    let mut status = status_now(core, record);
    if status.state() == v1::JobState::Queued {
        LoneSuspect::of(core).iter().for_each(|alone| alone.mark(&mut status));
        worker_wait::mark(worker_wait::of(core, &status.tenant), &mut status);
    }
    status
}

#[tonic::async_trait]
impl Service for JobsService {
    async fn submit_job(
        &self,
        request: Request<v1::SubmitJobRequest>,
    ) -> Result<Response<v1::SubmitJobResponse>, Status> {
        if self.0.drain.begun() {
            return Err(Refusal::Draining { cursor: 0 }.into());
        }
        let parent = request.metadata().get("traceparent").and_then(|value| value.to_str().ok()).unwrap_or_default();
        let traceparent = trace::parse(parent).map_or_else(String::new, |_| parent.trim().to_owned());
        let (caller, request) = enter(request)?;
        let bytes = SUBMIT_COPIES * request.encoded_len() as u64;
        let taken = submit::memory(&self.0, caller.tenant(), &request.request_id, bytes).await?;
        let (record, duplicate) = match submit::check(&self.0, &caller, request).await? {
            CheckedRequest::New(mut job) => {
                job.record.runs.traceparent = traceparent;
                submitted(&self.0, &caller, job, taken).await?
            }
            CheckedRequest::Known(record) => known(&caller, record),
        };
        Ok(Response::new(v1::SubmitJobResponse { status: Some(status(*record)), duplicate }))
    }

    async fn get_job(&self, request: Request<v1::GetJobRequest>) -> Result<Response<v1::GetJobResponse>, Status> {
        let (caller, v1::GetJobRequest { job_id: id }) = enter(request)?;
        let record = job(&self.0, &caller, &id)?;
        let core = self.0.clone();
        let read = move || {
            let work = core.work(&id)?;
            let description = match core.live(&id).and_then(|live| live.run().map(|run| description(&run.info))) {
                Some(description) => Some(description),
                None => {
                    let reader = core.kept_log(&id)?.and_then(|log| LogReader::open(&log, 0).ok());
                    reader.map(|reader| reader.description().clone())
                }
            };
            let progress = core.live(&id).filter(|live| live.state() == JobState::Running).map(|live| {
                let position = live.tail().position().last_seq;
                progress::now(&core, &live, position)
            });
            let (options, pinned_machine) = (options(&record, &work), record.machine.full_name());
            let file = |(path, digest): (String, String)| v1::FileRef { path, digest };
            let status = status_with_waits(&core, record);
            let answer = v1::GetJobResponse {
                files: work.files.into_iter().map(file).collect(),
                options: Some(options),
                pinned_machine,
                status: Some(status),
                description,
                progress,
            };
            let taken = core.memory().take_for_answer(ANSWER_COPIES * answer.encoded_len() as u64)?;
            Ok(counted(answer, taken))
        };
        Ok(look_up(&self.0, &caller.identity.key(), read).await?)
    }

    async fn list_jobs(&self, request: Request<v1::ListJobsRequest>) -> Result<Response<v1::ListJobsResponse>, Status> {
        let (caller, request) = enter(request)?;
        let tenant = caller.tenant().to_owned();
        page_token(&request.page_token)?;
        let size = if request.page_size == 0 { 50 } else { request.page_size.min(500) as usize };
        let mut filter = JobConditions::read(request.filter.unwrap_or_default())?;
        match filter.states.both(States::read("states", &request.states)?)? {
            Some(states) => filter.states = states,
            None => return Ok(Response::new(v1::ListJobsResponse::default())),
        }
        let core = self.0.clone();
        let read = move || {
            let query = Query {
                newest_first: request.newest_first,
                short_ids: request.short_ids,
                after: request.page_token,
                // With a small budget pages are small, so that two of them fit.
                most_bytes: PAGE_BYTES.min(core.memory().of_answers() / (2 * ANSWER_COPIES)),
                ..filter.query(&tenant, &core, size)
            };
            let page = core.ledger.jobs(&query)?;
            let taken = core.memory().take_for_answer(ANSWER_COPIES * page.bytes)?;
            let mut jobs: Vec<_> =
                page.jobs.into_iter().map(|record| status_now(&core, core.current(record))).collect();
            for (job, short_id) in jobs.iter_mut().zip(page.short_ids) {
                job.short_id = short_id;
            }
            if let Some(alone) = LoneSuspect::of(&core) {
                jobs.iter_mut().for_each(|job| alone.mark(job));
            }
            let wait = worker_wait::of(&core, &tenant);
            jobs.iter_mut().for_each(|job| worker_wait::mark(wait, job));
            Ok(counted(v1::ListJobsResponse { jobs, next_page_token: page.next.unwrap_or_default() }, taken))
        };
        Ok(look_up(&self.0, &caller.identity.key(), read).await?)
    }

    type WatchJobStream = ReceiverStream<Result<v1::WatchJobResponse, Status>>;

    async fn watch_job(&self, request: Request<v1::WatchJobRequest>) -> Result<Response<Self::WatchJobStream>, Status> {
        let (caller, request) = enter(request)?;
        job(&self.0, &caller, &request.job_id)?;
        let span = tracing::info_span!("watch", job = request.job_id);
        let watch = watch::JobWatcher::new(self.0.clone(), request)?;
        let (send, receive) = mpsc::channel(1);
        // Ends with the job, with the client, or with the drain.
        tokio::spawn(watch.run(send).instrument(span));
        Ok(plain(receive))
    }

    async fn wait_job(&self, request: Request<v1::WaitJobRequest>) -> Result<Response<v1::WaitJobResponse>, Status> {
        let (caller, request) = enter(request)?;
        let record = job(&self.0, &caller, &request.job_id)?;
        let timeout = if request.timeout_ms == 0 { 60_000 } else { request.timeout_ms.min(600_000) };
        if let Some(live) = self.0.live(&request.job_id) {
            let (mut state, mut drain) = (live.follow(), self.0.drain.follow());
            let ended = state.wait_for(|state| state.ended());
            tokio::select! {
                _ = tokio::time::timeout(Duration::from_millis(timeout), ended) => {}
                _ = drain.wait_for(|begun| *begun) => return Err(Refusal::Draining { cursor: 0 }.into()),
            }
            return Ok(Response::new(v1::WaitJobResponse { status: Some(status_with_waits(&self.0, live.record())) }));
        }
        Ok(Response::new(v1::WaitJobResponse { status: Some(status(record)) }))
    }

    async fn cancel_job(
        &self,
        request: Request<v1::CancelJobRequest>,
    ) -> Result<Response<v1::CancelJobResponse>, Status> {
        let (caller, v1::CancelJobRequest { job_id: id }) = enter(request)?;
        job(&self.0, &caller, &id)?;
        let core = self.0.clone();
        let record = to_the_end(&caller, async move { core.cancel(&id).await }).await?;
        Ok(Response::new(v1::CancelJobResponse { status: Some(status(record)) }))
    }

    async fn pause_job(&self, request: Request<v1::PauseJobRequest>) -> Result<Response<v1::PauseJobResponse>, Status> {
        let (caller, v1::PauseJobRequest { job_id: id }) = enter(request)?;
        job(&self.0, &caller, &id)?;
        let core = self.0.clone();
        let record = to_the_end(&caller, async move { core.pause(&id).await }).await?;
        Ok(Response::new(v1::PauseJobResponse { status: Some(status(record)) }))
    }

    async fn resume_job(
        &self,
        request: Request<v1::ResumeJobRequest>,
    ) -> Result<Response<v1::ResumeJobResponse>, Status> {
        let (caller, v1::ResumeJobRequest { job_id: id }) = enter(request)?;
        job(&self.0, &caller, &id)?;
        let core = self.0.clone();
        let record = to_the_end(&caller, async move { core.resume(&id).await }).await?;
        Ok(Response::new(v1::ResumeJobResponse { status: Some(status(record)) }))
    }

    async fn delete_job(
        &self,
        request: Request<v1::DeleteJobRequest>,
    ) -> Result<Response<v1::DeleteJobResponse>, Status> {
        let (caller, v1::DeleteJobRequest { job_id: id }) = enter(request)?;
        job(&self.0, &caller, &id)?;
        let core = self.0.clone();
        to_the_end(&caller, async move { core.delete(&id).await }).await?;
        Ok(Response::new(v1::DeleteJobResponse {}))
    }

    async fn cancel_jobs(
        &self,
        request: Request<v1::CancelJobsRequest>,
    ) -> Result<Response<v1::CancelJobsResponse>, Status> {
        let (caller, request) = enter(request)?;
        let v1::CancelJobsRequest { filter, all, dry_run, page_size, page_token } = request;
        let choice = Choice { filter, all, dry_run, page_size, page_token };
        let (job_ids, next_page_token) = many::each(&self.0, &caller, choice, BulkAction::Cancel).await?;
        Ok(Response::new(v1::CancelJobsResponse { job_ids, next_page_token }))
    }

    async fn delete_jobs(
        &self,
        request: Request<v1::DeleteJobsRequest>,
    ) -> Result<Response<v1::DeleteJobsResponse>, Status> {
        let (caller, request) = enter(request)?;
        let v1::DeleteJobsRequest { filter, all, dry_run, page_size, page_token } = request;
        let choice = Choice { filter, all, dry_run, page_size, page_token };
        let (job_ids, next_page_token) = many::each(&self.0, &caller, choice, BulkAction::Delete).await?;
        Ok(Response::new(v1::DeleteJobsResponse { job_ids, next_page_token }))
    }

    async fn rerun_job(&self, request: Request<v1::RerunJobRequest>) -> Result<Response<v1::RerunJobResponse>, Status> {
        if self.0.drain.begun() {
            return Err(Refusal::Draining { cursor: 0 }.into());
        }
        let (caller, request) = enter(request)?;
        let earlier = job(&self.0, &caller, &request.job_id);
        let bytes = SUBMIT_COPIES * earlier.as_ref().map_or(0, JobRecord::bytes);
        let taken = submit::memory(&self.0, caller.tenant(), &request.request_id, bytes).await?;
        let (record, duplicate) = match submit::check_rerun(&self.0, &caller, earlier, request).await? {
            CheckedRequest::New(job) => {
                let files = job.work.files.clone();
                let done = submitted(&self.0, &caller, job, taken).await;
                done.map_err(|refusal| by_path(refusal, &files))?
            }
            CheckedRequest::Known(record) => known(&caller, record),
        };
        Ok(Response::new(v1::RerunJobResponse { status: Some(status(*record)), duplicate }))
    }

    type WatchJobsStream = ReceiverStream<Result<v1::WatchJobsResponse, Status>>;

    async fn watch_jobs(
        &self,
        request: Request<v1::WatchJobsRequest>,
    ) -> Result<Response<Self::WatchJobsStream>, Status> {
        let (caller, request) = enter(request)?;
        let watch = watch_jobs::JobFeedWatcher::new(self.0.clone(), &caller, request)?;
        let (send, receive) = mpsc::channel(1);
        // Ends with the client or with the drain.
        tokio::spawn(watch.run(send).instrument(tracing::info_span!("watch jobs")));
        Ok(plain(receive))
    }
}
