//! Service `Jobs`.

use std::time::Duration;

use counterpoint_proto::v1;
use counterpoint_proto::v1::jobs_server::Jobs as Service;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tonic::{Request, Response, Status};
use tracing::Instrument as _;

use super::{Jobs, blocking, job, submit, watch};
use crate::access::Caller;
use crate::jobs::describe::{description, state, status};
use crate::log::reader::Reader;
use crate::reason::Refusal;
use crate::trace;

#[tonic::async_trait]
impl Service for Jobs {
    async fn submit_job(
        &self,
        request: Request<v1::SubmitJobRequest>,
    ) -> Result<Response<v1::SubmitJobResponse>, Status> {
        if self.0.drain.begun() {
            return Err(Refusal::Draining { cursor: 0 }.into());
        }
        let parent = request.metadata().get("traceparent").and_then(|value| value.to_str().ok()).unwrap_or_default();
        let traceparent = trace::parse(parent).map_or_else(String::new, |_| parent.trim().to_owned());
        let (core, caller, request) = (self.0.clone(), Caller::of(&request)?, request.into_inner());
        let tenant = caller.tenant().to_owned();
        let mut record = blocking(move || submit::record(&core, &tenant, request)).await?;
        record.runs.traceparent = traceparent;
        let (record, duplicate) = self.0.submit(record).await?;
        caller.about(&record.id);
        Ok(Response::new(v1::SubmitJobResponse { status: Some(status(record)), duplicate }))
    }

    async fn get_job(&self, request: Request<v1::GetJobRequest>) -> Result<Response<v1::GetJobResponse>, Status> {
        let (caller, id) = (Caller::of(&request)?, request.into_inner().job_id);
        let record = job(&self.0, &caller, &id)?;
        let description = match self.0.live(&id).and_then(|live| live.run().map(|run| description(&run.info))) {
            Some(description) => Some(description),
            None => {
                let (core, id) = (self.0.clone(), record.id.clone());
                let read = move || {
                    let log = core.kept_log(&id)?;
                    Ok(log.and_then(|log| Reader::open(&log, 0).ok()).map(|reader| reader.description().clone()))
                };
                blocking(read).await?
            }
        };
        Ok(Response::new(v1::GetJobResponse { status: Some(status(record)), description }))
    }

    async fn list_jobs(&self, request: Request<v1::ListJobsRequest>) -> Result<Response<v1::ListJobsResponse>, Status> {
        let (tenant, request) = (Caller::of(&request)?.tenant().to_owned(), request.into_inner());
        if !request.page_token.is_empty() && uuid::Uuid::try_parse(&request.page_token).is_err() {
            return Err(Refusal::field("page_token", "is not a next_page_token of this call").into());
        }
        if let Some(at) = request.states.iter().position(|state| v1::JobState::try_from(*state).is_err()) {
            return Err(Refusal::field(format!("states[{at}]"), "is not a state of a job").into());
        }
        let size = if request.page_size == 0 { 50 } else { request.page_size.min(500) as usize };
        let core = self.0.clone();
        let answer = blocking(move || {
            let wanted = |s: v1::JobState| request.states.is_empty() || request.states.contains(&s.into());
            let mut jobs = core.ledger.jobs(&request.page_token, size + 1, &|record| {
                let now = core.live(&record.id).map_or(record.state, |live| live.state());
                record.tenant == tenant && wanted(state(now))
            })?;
            let more = jobs.len() > size;
            jobs.truncate(size);
            let next = jobs.last().filter(|_| more).map(|job| job.id.clone());
            let newest = |record: crate::Record| core.live(&record.id).map_or(record, |live| live.record());
            let jobs = jobs.into_iter().map(|record| status(newest(record))).collect();
            Ok(v1::ListJobsResponse { jobs, next_page_token: next.unwrap_or_default() })
        });
        Ok(Response::new(answer.await?))
    }

    type WatchJobStream = ReceiverStream<Result<v1::WatchJobResponse, Status>>;

    async fn watch_job(&self, request: Request<v1::WatchJobRequest>) -> Result<Response<Self::WatchJobStream>, Status> {
        let (caller, request) = (Caller::of(&request)?, request.into_inner());
        job(&self.0, &caller, &request.job_id)?;
        let span = tracing::info_span!("watch", job = request.job_id);
        let watch = watch::Watch::new(self.0.clone(), request)?;
        let (send, receive) = mpsc::channel(1);
        // Ends with the job, with the client, or with the drain.
        tokio::spawn(watch.run(send).instrument(span));
        Ok(Response::new(ReceiverStream::new(receive)))
    }

    async fn wait_job(&self, request: Request<v1::WaitJobRequest>) -> Result<Response<v1::WaitJobResponse>, Status> {
        let (caller, request) = (Caller::of(&request)?, request.into_inner());
        let record = job(&self.0, &caller, &request.job_id)?;
        let timeout = if request.timeout_ms == 0 { 60_000 } else { request.timeout_ms.min(600_000) };
        if let Some(live) = self.0.live(&request.job_id) {
            let (mut state, mut drain) = (live.follow(), self.0.drain.follow());
            let ended = state.wait_for(|state| state.ended());
            tokio::select! {
                _ = tokio::time::timeout(Duration::from_millis(timeout), ended) => {}
                _ = drain.wait_for(|begun| *begun) => return Err(Refusal::Draining { cursor: 0 }.into()),
            }
            return Ok(Response::new(v1::WaitJobResponse { status: Some(status(live.record())) }));
        }
        Ok(Response::new(v1::WaitJobResponse { status: Some(status(record)) }))
    }

    async fn cancel_job(
        &self,
        request: Request<v1::CancelJobRequest>,
    ) -> Result<Response<v1::CancelJobResponse>, Status> {
        let (caller, id) = (Caller::of(&request)?, request.into_inner().job_id);
        job(&self.0, &caller, &id)?;
        let record = self.0.cancel(&id).await?;
        Ok(Response::new(v1::CancelJobResponse { status: Some(status(record)) }))
    }

    async fn delete_job(
        &self,
        request: Request<v1::DeleteJobRequest>,
    ) -> Result<Response<v1::DeleteJobResponse>, Status> {
        let (caller, id) = (Caller::of(&request)?, request.into_inner().job_id);
        job(&self.0, &caller, &id)?;
        self.0.delete(&id).await?;
        Ok(Response::new(v1::DeleteJobResponse {}))
    }
}
