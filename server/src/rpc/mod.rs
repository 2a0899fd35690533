//! The services of the wire contract over the core of the server.
//!
//! Invariant: nothing here blocks the async threads on files or renderers; blocking work runs on blocking threads.

mod admin;
mod answers;
mod blobs;
mod debug;
mod door;
mod guess;
mod jobs;
mod machines;
mod many;
mod operator;
mod results;
mod stream;
mod submit;
mod to_the_end;
mod watch;
mod watch_jobs;

use std::sync::Arc;
use std::time::Duration;

use prost::Message;
use tonic::{Status, Streaming};

use to_the_end::to_the_end;

use crate::JobRecord;
use crate::access::Caller;
use crate::jobs::Core;
use crate::reason::Refusal;

/// Service `JobsService`.
#[derive(Debug)]
pub(crate) struct JobsService(pub(crate) Arc<Core>);
/// Service `BlobsService`.
#[derive(Debug)]
pub(crate) struct BlobsService(pub(crate) Arc<Core>);
/// Service `MachinesService`.
#[derive(Debug)]
pub(crate) struct MachinesService(pub(crate) Arc<Core>);
/// Service `OperatorService`.
#[derive(Debug)]
pub(crate) struct OperatorService(pub(crate) Arc<Core>);
/// Service `ResultsService`.
#[derive(Debug)]
pub(crate) struct ResultsService(pub(crate) Arc<Core>);

/// Service `AdminService`.
pub(crate) struct AdminService {
    pub(crate) core: Arc<Core>,
    /// Asks the server to drain.
    pub(crate) stop: Box<dyn Fn() + Send + Sync>,
}

/// Maximum bytes of the entries of a page, which is a single message.
const PAGE: usize = 3 << 20;
/// Maximum bytes before each entry of a page: field number and length.
const HEAD: usize = 6;

/// A job of the caller's tenant.
fn job(core: &Core, caller: &Caller, id: &str) -> Result<JobRecord, Refusal> {
    caller.about(id);
    core.job_of(caller.tenant(), id)
}

/// The first message of a client stream; an error if the stream stalls.
async fn first<T>(core: &Core, messages: &mut Streaming<T>) -> Result<Option<T>, Status> {
    let seconds = core.options.connections.upload_stall_s;
    let first = tokio::time::timeout(Duration::from_secs(seconds), messages.message()).await;
    first.map_err(|_| Refusal::CallStalled(seconds))?
}

/// The messages of a sorted list after the entry that `token` names, and the token of the next page. A page ends after
/// `size` messages (0 = any number, otherwise at most `most`), or before a message that would make it too large.
fn page<T, M: Message>(
    all: &[T],
    (size, most): (u32, usize),
    token: &str,
    name: impl Fn(&T) -> &str,
    mut message: impl FnMut(&T) -> Result<M, Refusal>,
) -> Result<(Vec<M>, String), Refusal> {
    let begin = all.partition_point(|entry| !token.is_empty() && name(entry) <= token);
    let size = if size == 0 { usize::MAX } else { (size as usize).min(most) };
    let (mut page, mut bytes, mut last) = (Vec::new(), 0, "");
    for entry in all.iter().skip(begin) {
        if page.len() == size {
            return Ok((page, last.to_owned()));
        }
        let made = message(entry)?;
        bytes += made.encoded_len() + HEAD;
        if bytes > PAGE && !page.is_empty() {
            return Ok((page, last.to_owned()));
        }
        page.push(made);
        last = name(entry);
    }
    Ok((page, String::new()))
}

/// Runs a lookup that may block, as soon as its identity has a turn. So a flood of calls takes few threads, and a call
/// whose client disconnects before its turn reads nothing.
async fn look_up<T: Send + 'static>(
    core: &Core,
    identity: &str,
    read: impl FnOnce() -> Result<T, Refusal> + Send + 'static,
) -> Result<T, Refusal> {
    let turn = core.streams.lookups.turn(identity).await;
    // The thread holds the turn, because the lookup continues after its client has disconnected.
    let held = move || {
        let read = read();
        drop(turn);
        read
    };
    blocking(held).await
}

/// Does work that may block.
async fn blocking<T: Send + 'static>(work: impl FnOnce() -> Result<T, Refusal> + Send + 'static) -> Result<T, Refusal> {
    tokio::task::spawn_blocking(work).await.map_err(|error| Refusal::Storage(error.to_string()))?
}
