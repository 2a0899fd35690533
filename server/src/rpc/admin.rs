//! Service `AdminService`: the activity of the server, and commands for its maintenance.
//!
//! *Invariant:* only callers of the role `admin` get here (the table of calls); nothing that a job contains is shown.

use std::sync::atomic::Ordering;

use counterpoint_proto::v1;
use counterpoint_proto::v1::admin_server::Admin as Service;
use prost::Message as _;
use tonic::{Request, Response, Status};

use super::door::enter;
use super::{AdminService, HEAD, PAGE, blocking};
use crate::connections::ConnectionStatus;
use crate::jobs::live::LiveJob;
use crate::reason::Refusal;

fn count(value: usize) -> u32 {
    u32::try_from(value).unwrap_or(u32::MAX)
}

/// An open connection.
fn connection(seen: ConnectionStatus) -> v1::ConnectionInfo {
    v1::ConnectionInfo {
        number: seen.number,
        peer: seen.peer.to_string(),
        since_ms: seen.since_ms,
        identity: seen.identity.as_ref().map_or_else(String::new, |identity| identity.name.clone()),
        tenant: seen.identity.as_ref().map_or_else(String::new, |identity| identity.tenant.clone()),
        open_calls: count(seen.open),
        calls: seen.all,
    }
}

/// Most connections of a page.
const CONNECTIONS: usize = 1000;

/// The next page of connections, and the token of the page after it: the number of the last connection.
fn connections_page(all: impl Iterator<Item = v1::ConnectionInfo>, size: usize) -> (Vec<v1::ConnectionInfo>, String) {
    let size = if size == 0 { usize::MAX } else { size.min(CONNECTIONS) };
    let (mut page, mut bytes) = (Vec::<v1::ConnectionInfo>::new(), 0);
    for connection in all {
        bytes += connection.encoded_len() + HEAD;
        if let Some(last) = page.last().filter(|_| page.len() >= size || bytes > PAGE) {
            let token = last.number.to_string();
            return (page, token);
        }
        page.push(connection);
    }
    (page, String::new())
}

/// A running job.
fn worker(live: &LiveJob) -> v1::WorkerInfo {
    let operator_wait = live.operator_wait();
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
        operator_wait,
    }
}

#[tonic::async_trait]
impl Service for AdminService {
    async fn list_connections(
        &self,
        request: Request<v1::ListConnectionsRequest>,
    ) -> Result<Response<v1::ListConnectionsResponse>, Status> {
        let (_, v1::ListConnectionsRequest { page_size, page_token }) = enter(request)?;
        let after = match page_token.as_str() {
            "" => 0,
            token => {
                token.parse().map_err(|_| Refusal::field("page_token", "is not a next_page_token of this call"))?
            }
        };
        let seen = self.core.connections.seen().into_iter().filter(|seen| seen.number > after);
        let (connections, next_page_token) = connections_page(seen.map(connection), page_size as usize);
        Ok(Response::new(v1::ListConnectionsResponse { connections, next_page_token }))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_of_connections_ends_at_its_size_and_at_the_size_of_a_message() {
        let all = |identity: &str| -> Vec<v1::ConnectionInfo> {
            let one = |number| v1::ConnectionInfo { number, identity: identity.to_owned(), ..Default::default() };
            (1..=2500).map(one).collect()
        };
        let numbers = |page: &[v1::ConnectionInfo]| (page[0].number, page[page.len() - 1].number);
        let (page, next) = connections_page(all("ci").into_iter(), 0);
        assert_eq!((numbers(&page), next.as_str()), ((1, 2500), ""));
        let (page, next) = connections_page(all("ci").into_iter(), 5000);
        assert_eq!((numbers(&page), next.as_str()), ((1, 1000), "1000"));
        let (page, next) = connections_page(all("ci").into_iter().skip(2000), 500);
        assert_eq!((numbers(&page), next.as_str()), ((2001, 2500), ""));
        let (page, next) = connections_page(all(&"x".repeat(2000)).into_iter(), 0);
        let bytes = v1::ListConnectionsResponse { connections: page.clone(), next_page_token: next.clone() };
        assert!(bytes.encoded_len() < 4 << 20 && next == page.len().to_string(), "{next}");
    }
}
