//! Service `Admin`: the activity of the server, and commands for its maintenance.
//!
//! *Invariant:* only callers of the role `admin` get here (the table of calls); nothing that a job contains is shown.

use std::sync::atomic::Ordering;

use counterpoint_proto::v1;
use counterpoint_proto::v1::admin_server::Admin as Service;
use tonic::{Request, Response, Status};

use super::{Admin, blocking};
use crate::jobs::live::Live;

fn count(value: usize) -> u32 {
    u32::try_from(value).unwrap_or(u32::MAX)
}

/// A running job.
fn worker(live: &Live) -> v1::WorkerInfo {
    let record = live.record();
    let progress = live.run().map(|run| {
        let channels = run.control.progress().iter();
        channels.map(|progress| progress.blocks.load(Ordering::Relaxed)).sum()
    });
    v1::WorkerInfo {
        job_id: record.id,
        tenant: record.tenant,
        machine: record.machine_name,
        started_ms: record.runs.started_ms,
        attempt: record.runs.attempt,
        blocks: progress.unwrap_or(0),
        events: live.tail().position().last_seq,
        suspect: record.runs.suspect,
    }
}

#[tonic::async_trait]
impl Service for Admin {
    async fn list_connections(
        &self,
        _: Request<v1::ListConnectionsRequest>,
    ) -> Result<Response<v1::ListConnectionsResponse>, Status> {
        let connections = self.core.connections.seen().into_iter().map(|seen| v1::ConnectionInfo {
            number: seen.number,
            peer: seen.peer.to_string(),
            since_ms: seen.since_ms,
            identity: seen.identity.as_ref().map_or_else(String::new, |identity| identity.name.clone()),
            tenant: seen.identity.as_ref().map_or_else(String::new, |identity| identity.tenant.clone()),
            open_calls: count(seen.open),
            calls: seen.all,
        });
        Ok(Response::new(v1::ListConnectionsResponse { connections: connections.collect() }))
    }

    async fn list_streams(
        &self,
        _: Request<v1::ListStreamsRequest>,
    ) -> Result<Response<v1::ListStreamsResponse>, Status> {
        let streams = self.core.streams.seen().into_iter().map(|seen| v1::StreamInfo {
            number: seen.number,
            job_id: seen.job,
            tenant: seen.tenant,
            position: seen.cursor,
            behind: seen.behind,
        });
        Ok(Response::new(v1::ListStreamsResponse { streams: streams.collect() }))
    }

    async fn list_workers(
        &self,
        _: Request<v1::ListWorkersRequest>,
    ) -> Result<Response<v1::ListWorkersResponse>, Status> {
        let busy = self.core.workers();
        Ok(Response::new(v1::ListWorkersResponse {
            slots: count(self.core.options.slots()),
            workers: busy.running.iter().map(|live| worker(live)).collect(),
            storing: count(busy.storing),
            queued: busy.queued as u64,
        }))
    }

    async fn drain(&self, _: Request<v1::DrainRequest>) -> Result<Response<v1::DrainResponse>, Status> {
        tracing::info!("an administrator asks for the shutdown");
        let running = count(*self.core.running().borrow());
        (self.stop)();
        Ok(Response::new(v1::DrainResponse { running, grace_s: self.core.options.grace_s }))
    }

    async fn collect(&self, _: Request<v1::CollectRequest>) -> Result<Response<v1::CollectResponse>, Status> {
        let core = self.core.clone();
        let (jobs, blobs) = blocking(move || core.collect()).await?;
        Ok(Response::new(v1::CollectResponse { jobs, blobs }))
    }

    async fn compact_ledger(
        &self,
        _: Request<v1::CompactLedgerRequest>,
    ) -> Result<Response<v1::CompactLedgerResponse>, Status> {
        let core = self.core.clone();
        let done = blocking(move || core.compact()).await?;
        Ok(Response::new(v1::CompactLedgerResponse {
            before_bytes: done.before,
            after_bytes: done.after,
            waited_ms: u64::try_from(done.time.as_millis()).unwrap_or(u64::MAX),
        }))
    }
}
