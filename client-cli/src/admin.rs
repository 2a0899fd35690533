//! `admin`: the activity of a server, and commands for its maintenance.

use counterpoint_proto::v1;

use crate::arguments::AdminCommand;
use crate::client::ServerSession;
use crate::error::Error;
use crate::job_status::awaited;
use crate::say;
use crate::text::table;

/// Executes a command; returns the exit code.
pub(crate) async fn dispatch(command: AdminCommand) -> Result<u8, Error> {
    let (AdminCommand::Connections(at)
    | AdminCommand::Streams(at)
    | AdminCommand::Workers(at)
    | AdminCommand::Drain(at)
    | AdminCommand::Collect(at)
    | AdminCommand::Compact(at)) = &command;
    let client = ServerSession::connect(&at.remote.server).await?;
    let text = match command {
        AdminCommand::Connections(_) => connections(&client).await?,
        AdminCommand::Streams(_) => streams(&client).await?,
        AdminCommand::Workers(_) => workers(&client).await?,
        AdminCommand::Drain(_) => {
            let answer = client.admin().drain(v1::DrainRequest {}).await?.into_inner();
            drained(answer.running, answer.grace_s)
        }
        AdminCommand::Collect(_) => {
            let answer = client.admin().collect(v1::CollectRequest {}).await?.into_inner();
            format!("removed {} jobs, {} blobs\n", answer.jobs, answer.blobs)
        }
        AdminCommand::Compact(_) => {
            let answer = client.admin().compact_ledger(v1::CompactLedgerRequest {}).await?.into_inner();
            let v1::CompactLedgerResponse { before_bytes, after_bytes, waited_ms } = answer;
            if after_bytes < before_bytes {
                format!(
                    "the ledger had {before_bytes} bytes and has {after_bytes} now; submits waited {waited_ms} ms\n"
                )
            } else {
                format!(
                    "the ledger stays at {before_bytes} bytes, a copy would not be smaller; \
                     submits waited {waited_ms} ms\n"
                )
            }
        }
    };
    say::data(text.as_bytes())?;
    Ok(0)
}

/// A table with a head.
fn rows(head: &[&str], rows: impl Iterator<Item = Vec<String>>, left: usize) -> String {
    let head = head.iter().map(|text| (*text).to_owned()).collect();
    table(&std::iter::once(head).chain(rows).collect::<Vec<_>>(), left)
}

async fn connections(client: &ServerSession) -> Result<String, Error> {
    let (mut all, mut request) = (Vec::new(), v1::ListConnectionsRequest::default());
    loop {
        let page = client.admin().list_connections(request.clone()).await?.into_inner();
        all.extend(page.connections);
        if page.next_page_token.is_empty() {
            break;
        }
        request.page_token = page.next_page_token;
    }
    let row = |c: v1::ConnectionInfo| {
        vec![c.peer, c.tenant, c.identity, c.number.to_string(), c.open_calls.to_string(), c.calls.to_string()]
    };
    let head = ["peer", "tenant", "identity", "number", "open calls", "calls"];
    Ok(rows(&head, all.into_iter().map(row), 3))
}

async fn streams(client: &ServerSession) -> Result<String, Error> {
    let answer = client.admin().list_streams(v1::ListStreamsRequest {}).await?.into_inner();
    let row = |s: v1::StreamInfo| {
        vec![s.job_id, s.tenant, s.number.to_string(), s.position.to_string(), s.behind.to_string()]
    };
    Ok(rows(&["job", "tenant", "number", "position", "behind"], answer.streams.into_iter().map(row), 2))
}

async fn workers(client: &ServerSession) -> Result<String, Error> {
    let answer = client.admin().list_workers(v1::ListWorkersRequest {}).await?.into_inner();
    let running = answer.workers.len();
    let alone = answer.workers.iter().filter(|worker| worker.suspect);
    let alone = alone.map(|worker| format!("job {} runs alone after a crash; other jobs wait\n", worker.job_id));
    let alone: String = alone.collect();
    let head = ["job", "tenant", "machine", "state", "run", "blocks", "events"];
    let list = rows(&head, answer.workers.into_iter().map(worker), 4);
    let v1::ListWorkersResponse { slots, storing, queued, .. } = answer;
    Ok(format!("{list}{alone}{running} of {slots} workers run jobs, {storing} jobs are being stored, {queued} wait\n"))
}

/// A running job of the list.
fn worker(w: v1::WorkerInfo) -> Vec<String> {
    let state = w.operator_wait.map_or_else(|| "runs".to_owned(), |wait| format!("waits for {}", awaited(&wait)));
    vec![w.job_id, w.tenant, w.machine, state, w.attempt.to_string(), w.blocks.to_string(), w.events.to_string()]
}

/// The answer to a request for a shutdown.
fn drained(running: u32, grace_s: u64) -> String {
    let jobs = match running {
        0 => "no job is running".to_owned(),
        1 => format!("1 job is running and has {grace_s} s to end"),
        running => format!("{running} jobs are running and have {grace_s} s to end"),
    };
    format!("the server is shutting down: {jobs}\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_worker_whose_job_waits_for_a_client_says_so() {
        let wait = v1::OperatorWait { action: v1::OperatorAction::Answer.into(), since_ms: 1, until_ms: 2 };
        let waits = v1::WorkerInfo { operator_wait: Some(wait), ..Default::default() };
        assert_eq!((&*worker(waits)[3], &*worker(v1::WorkerInfo::default())[3]), ("waits for an operator", "runs"));
    }

    #[test]
    fn the_jobs_of_a_shutdown_are_counted_in_words() {
        for (running, text) in [
            (0, "the server is shutting down: no job is running\n"),
            (1, "the server is shutting down: 1 job is running and has 30 s to end\n"),
            (2, "the server is shutting down: 2 jobs are running and have 30 s to end\n"),
        ] {
            assert_eq!(drained(running, 30), text);
        }
    }
}
