//! Connections: accepted within limits, served, and closed when they stall.
//!
//! Invariants: a peer that never speaks, or has not called for a while, holds no descriptor; when the process has no
//! descriptor left, the accept loop waits instead of spinning.

mod arrive;
mod cut;
mod form;
mod gate;
mod held;
mod pause;
mod status;
mod tls;
mod turn;
mod unanswered;
mod web;

use std::convert::Infallible;
use std::future::Future;
use std::net::{IpAddr, SocketAddr};
use std::pin::{Pin, pin};
use std::sync::Arc;
use std::time::Duration;

use http::header::ALLOW;
use http::{HeaderMap, HeaderValue, Request, Response, StatusCode};
use hyper::body::Incoming;
use hyper::server::conn::{http1, http2};
use hyper::service::service_fn;
use hyper_util::rt::{TokioExecutor, TokioIo, TokioTimer};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;
use tokio::time::{Instant, sleep, timeout, timeout_at};
use tonic::Status;
use tonic::body::Body;
use tonic::service::Routes;
use tonic::transport::server::TcpConnectInfo;

use crate::access::{CertificateNames, calls};
use crate::connections::{ActiveCall, ListedConnection};
use crate::jobs::Core;
use crate::memory::MemoryBudget;
use crate::places::SlotLimiter;
use crate::reason::Refusal;
use arrive::{BufferedBody, first_message};
use cut::{CutStatus, ask};
pub(crate) use gate::Gate;
use held::TrackedBody;
use pause::{Paused, ReadPause};
pub(crate) use status::serve as monitor;
use unanswered::Unanswered;
use web::AnswerForm;

/// Largest message in either direction, bytes; for a compressed message, its size without compression.
pub(crate) const MAX_MESSAGE: usize = 4 << 20;
/// Maximum size of a message to the health service, bytes. This service needs no identity, so its messages must not
/// take memory from other calls.
pub(crate) const MAX_OF_HEALTH: usize = 4 << 10;
/// Maximum numbers of open watches of the health service: in total, and from one address. They need no identity.
const HEALTH_WATCHES: usize = 256;
const HEALTH_WATCHES_OF_AN_ADDRESS: usize = 32;
/// Bytes of a frame that a client may send at once: an upload chunk with its head.
const FRAME: u32 = 128 * 1024;
/// Bytes that a stream may hold for a client that does not read.
const SEND_BUFFER: usize = 8 * 1024;
/// First bytes of every HTTP/2 connection, and how many there are; a request in HTTP/1.1 has more.
const PREFACE_OF_HTTP2: &[u8; PREFACE] = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";
const PREFACE: usize = 24;
/// Between two looks at a preface that has come in part.
const LOOK: Duration = Duration::from_millis(20);
/// Pause after an accept that failed: the process may have no descriptor left.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);
/// Descriptors that no connection gets: ledger, logs, blobs, uploads.
const RESERVE: u64 = 512;

/// The rights of connections.
#[derive(Debug, Clone, Copy)]
struct Patience {
    preface: Duration,
    idle: Duration,
    /// For more of a request.
    stall: Duration,
}

/// Accepts and serves connections until `closing` says so, then until all have ended.
pub(crate) async fn serve(
    listener: TcpListener,
    routes: Routes,
    core: &Core,
    gate: Arc<Gate>,
    mut closing: watch::Receiver<bool>,
) {
    let (options, listed) = (&core.options, core.connections.clone());
    let most = options.connections.max_connections.min(descriptors().saturating_sub(RESERVE).max(16) as usize);
    let places = Arc::new(SlotLimiter::new(most, options.connections.max_connections_per_address));
    let health = Arc::new(SlotLimiter::new(HEALTH_WATCHES, HEALTH_WATCHES_OF_AN_ADDRESS));
    let patience = Patience {
        preface: Duration::from_secs(options.connections.preface_s),
        idle: Duration::from_secs(options.connections.idle_s),
        stall: Duration::from_secs(options.connections.upload_stall_s),
    };
    let connections = watch::Sender::new(());
    // Accepts that have failed since the last one that did not.
    let mut failed: u64 = 0;
    loop {
        let accepted = tokio::select! {
            _ = closing.wait_for(|closing| *closing) => break,
            accepted = listener.accept() => accepted,
        };
        let (stream, peer) = match accepted {
            Ok(accepted) => accepted,
            Err(error) if left(&error) => continue,
            Err(error) => {
                if failed == 0 {
                    tracing::warn!(%error, "no connection can be accepted");
                }
                failed += 1;
                sleep(ACCEPT_PAUSE).await;
                continue;
            }
        };
        if failed > 0 {
            tracing::info!(failed, "connections are accepted again");
            failed = 0;
        }
        match places.take(peer.ip()) {
            None => tracing::debug!(%peer, "refused: too many connections"),
            Some(place) => {
                let (routes, gate, listed) = (routes.clone(), gate.clone(), listed.list(peer));
                let (closing, open) = (closing.clone(), connections.subscribe());
                let info = TcpConnectInfo { local_addr: stream.local_addr().ok(), remote_addr: Some(peer) };
                let (names, drain, pause) = (CertificateNames::default(), core.drain.follow(), ReadPause::default());
                let (memory, health) = (core.memory().clone(), health.clone());
                let peer = Peer { address: peer, info, names, gate, memory, health, drain, pause };
                // Ends with the connection.
                tokio::spawn(async move {
                    connection(stream, (peer, listed), routes, patience, closing).await;
                    drop((place, open));
                });
            }
        }
    }
    drop(listener);
    connections.closed().await;
}

/// Whether an accept failed because its peer has left: the next may succeed at once.
fn left(error: &std::io::Error) -> bool {
    use std::io::ErrorKind::{ConnectionAborted, ConnectionReset, Interrupted};
    matches!(error.kind(), ConnectionAborted | ConnectionReset | Interrupted)
}

/// Serves one connection to its end.
async fn connection(
    stream: TcpStream,
    (plain, listed): (Peer, ListedConnection),
    routes: Routes,
    patience: Patience,
    mut closing: watch::Receiver<bool>,
) {
    let _ = stream.set_nodelay(true);
    let gate = plain.gate.clone();
    let Some(tls) = &gate.tls else {
        let speaks = begins(speaks(&stream), patience, &mut closing).await;
        if let Some(Some(first)) = speaks {
            calls(stream, &first, (plain, listed), routes, patience, closing).await;
        }
        return;
    };
    if let Some(Ok((stream, names))) = begins(tls.accept(stream), patience, &mut closing).await {
        let first = *stream.first();
        calls(stream, &first, (Peer { names, ..plain }, listed), routes, patience, closing).await;
    }
}

/// First step of a peer, unless its time is over or the server shuts down.
async fn begins<T>(
    begin: impl Future<Output = T>,
    patience: Patience,
    closing: &mut watch::Receiver<bool>,
) -> Option<T> {
    tokio::select! {
        begun = timeout(patience.preface, begin) => begun.ok(),
        _ = closing.wait_for(|closing| *closing) => None,
    }
}

/// The other end of a connection.
#[derive(Debug)]
struct Peer {
    address: SocketAddr,
    info: TcpConnectInfo,
    names: CertificateNames,
    gate: Arc<Gate>,
    memory: Arc<MemoryBudget>,
    /// Places for watches of the health service.
    health: Arc<SlotLimiter<IpAddr>>,
    drain: watch::Receiver<bool>,
    pause: ReadPause,
}

/// Serves the calls of a connection that has begun to speak: HTTP/2, or HTTP/1.1 where gRPC-Web is allowed.
async fn calls<S: AsyncRead + AsyncWrite + Unpin + Send + 'static>(
    stream: S,
    first: &[u8; PREFACE],
    (caller, listed): (Peer, ListedConnection),
    routes: Routes,
    patience: Patience,
    closing: watch::Receiver<bool>,
) {
    let (caller, listed) = (Arc::new(caller), Arc::new(listed));
    let (counted, gate, pause) = (listed.clone(), caller.gate.clone(), caller.pause.clone());
    let stream = TokioIo::new(Paused::new(stream, pause.clone()));
    let service = service_fn(move |mut request: Request<Incoming>| {
        request.extensions_mut().insert(caller.info.clone());
        // In a box, since a stream keeps room for the largest of its states as long as it lives.
        Box::pin(answer(routes.clone(), request, caller.clone(), counted.begin(), patience.stall))
    });
    if gate.web.is_some() && !PREFACE_OF_HTTP2.starts_with(first) {
        let mut builder = http1::Builder::new();
        builder.timer(TokioTimer::new()).header_read_timeout(patience.preface).max_buf_size(64 * 1024);
        let server = pin!(builder.serve_connection(stream, service));
        attend(server, |server| server.graceful_shutdown(), (&listed, &pause), patience, closing).await;
    } else {
        let server = pin!(builder().serve_connection(stream, service));
        attend(server, |server| server.graceful_shutdown(), (&listed, &pause), patience, closing).await;
    }
}

/// Drives a connection until it ends, has been idle for too long, or the server goes down.
async fn attend<F: Future>(
    mut server: Pin<&mut F>,
    leave: impl Fn(Pin<&mut F>),
    (calls, pause): (&ListedConnection, &ReadPause),
    patience: Patience,
    mut closing: watch::Receiver<bool>,
) {
    let mut quiet_since = Instant::now();
    let mut leaving = false;
    loop {
        tokio::select! {
            _ = server.as_mut() => return,
            _ = closing.wait_for(|closing| *closing), if !leaving => {
                leaving = true;
                pause.end();
                leave(server.as_mut());
            }
            () = tokio::time::sleep_until(quiet_since + patience.idle) => {
                if calls.is_idle() && !leaving && calls.take_served() == 0 {
                    leaving = true;
                    leave(server.as_mut());
                } else if leaving && calls.is_idle() {
                    return;
                }
                quiet_since = Instant::now();
            }
        }
    }
}

/// Waits for the first bytes of a connection; `None` if the peer leaves before.
async fn speaks(stream: &TcpStream) -> Option<[u8; PREFACE]> {
    let mut first = [0; PREFACE];
    loop {
        match stream.peek(&mut first).await {
            Ok(PREFACE) => return Some(first),
            Ok(0) | Err(_) => return None,
            Ok(_) => sleep(LOOK).await,
        }
    }
}

fn builder() -> http2::Builder<TokioExecutor> {
    let mut builder = http2::Builder::new(TokioExecutor::new());
    builder
        .timer(TokioTimer::new())
        .keep_alive_interval(Some(Duration::from_secs(30)))
        .keep_alive_timeout(Duration::from_secs(10))
        .initial_stream_window_size(1 << 20)
        .initial_connection_window_size(4 << 20)
        .max_frame_size(FRAME)
        .max_send_buf_size(SEND_BUFFER)
        .max_concurrent_streams(256)
        .max_header_list_size(32 * 1024)
        .max_pending_accept_reset_streams(Some(64));
    builder
}

/// Answers one request in the form of its protocol.
async fn answer(
    routes: Routes,
    request: Request<Incoming>,
    peer: Arc<Peer>,
    call: ActiveCall,
    stall: Duration,
) -> Result<Response<TrackedBody>, Infallible> {
    let form = match &peer.gate.web {
        None => AnswerForm::default(),
        Some(web) => match web.preflight(&request) {
            Some(answer) => return Ok(answer.map(|body| TrackedBody::new(body, call, None, None))),
            None => web.form_of_answer(request.headers()),
        },
    };
    let mut answer = answer_call(routes, request, peer, call, stall).await?;
    form.apply(answer.headers_mut());
    Ok(answer)
}

/// Answers one authorized call, within its deadline if it has one.
async fn answer_call(
    routes: Routes,
    mut request: Request<Incoming>,
    peer: Arc<Peer>,
    call: ActiveCall,
    stall: Duration,
) -> Result<Response<TrackedBody>, Infallible> {
    let begin = Instant::now();
    let timeout = deadline(request.headers());
    let deadline = timeout.as_ref().ok().and_then(|time| begin.checked_add((*time)?));
    let caller = match turn::admitted(&mut request, &peer, &call, deadline).await {
        Ok(caller) => caller,
        Err(refused) => return Ok(refused.map(|body| TrackedBody::new(body, call, None, None))),
    };
    let path = request.uri().path().to_owned();
    if let Some((status, text)) = form::wrong(&request, peer.gate.web.is_some()) {
        let mut refused = peer.gate.refuse(peer.address, caller.as_ref(), &path, Refusal::UnknownCall(text.to_owned()));
        *refused.status_mut() = status;
        if status == StatusCode::METHOD_NOT_ALLOWED {
            refused.headers_mut().insert(ALLOW, HeaderValue::from_static("POST"));
        }
        return Ok(refused.map(|body| TrackedBody::new(body, call, None, None)));
    }
    if let Err(refusal) = timeout {
        let refused = peer.gate.refuse(peer.address, caller.as_ref(), &path, refusal);
        return Ok(refused.map(|body| TrackedBody::new(body, call, None, None)));
    }
    let place = match calls::watches_health(&path).then(|| peer.health.take(peer.address.ip())) {
        Some(None) => {
            let refused = peer.gate.refuse(peer.address, caller.as_ref(), &path, Refusal::TooManyHealthWatches);
            return Ok(refused.map(|body| TrackedBody::new(body, call, None, None)));
        }
        place => place.flatten(),
    };
    let mut rights = peer.gate.rights(request.headers(), &peer.names, caller.as_ref(), &path);
    caller.iter().for_each(|caller| peer.gate.note_before(peer.address, caller, &path));
    let unanswered = Unanswered::new(peer.clone(), caller.clone(), path.clone());
    let (mut stay, mut late, cut) = (None, false, CutStatus::default());
    let response = {
        // Pinned where they are, as a future that moves into another one takes its room twice.
        let answered = pin!(async {
            let (parts, body) = request.map(Body::new).into_parts();
            let (most, memory) = room(&path, &peer.memory);
            let arrived = match calls::sends_many(&path) {
                true => BufferedBody::open(body),
                false => match first_message(body, most, stall, &memory).await {
                    Ok(arrived) => arrived,
                    Err(refusal) => return Ok(Status::from(refusal).into_http()),
                },
            };
            let (turn, long) = peer.gate.turn(caller.as_ref(), &path).await;
            stay.clone_from(&long);
            let request = Request::from_parts(parts, Body::new(arrived.of(long)));
            let answer = ask(routes, request, &cut, peer.gate.web.is_some()).await;
            drop(turn);
            answer
        });
        let answered = pin!(async {
            match &mut rights {
                None => answered.await,
                Some(ended) => tokio::select! {
                    answer = answered => answer,
                    status = ended => Ok(status.into_http()),
                },
            }
        });
        match deadline {
            None => answered.await?,
            Some(deadline) => match timeout_at(deadline, answered).await {
                Ok(response) => response?,
                Err(_) => {
                    late = true;
                    Status::from(Refusal::CallDeadline).into_http()
                }
            },
        }
    };
    let mut response = detailed(response);
    match late {
        true => unanswered.late(&response, begin.elapsed()),
        false => unanswered.answered(&response, begin.elapsed()),
    }
    let taken = response.extensions_mut().remove();
    let ended = held::ended(rights, deadline.filter(|_| !late));
    Ok(response.map(|body| TrackedBody::new(body, call, stay, taken).until(ended, cut).keeping(place)))
}

/// Maximum size of a message to the call of a path, bytes, and the budget that counts it: none for health checks.
fn room(path: &str, memory: &Arc<MemoryBudget>) -> (usize, Arc<MemoryBudget>) {
    match calls::is_of_health(path) {
        true => (MAX_OF_HEALTH, MemoryBudget::new(0)),
        false => (MAX_MESSAGE, memory.clone()),
    }
}

/// Gives the status of a call that the transport has refused the details that all refusals have.
fn detailed(response: Response<Body>) -> Response<Body> {
    let headers = response.headers();
    let refused = headers.get("grpc-status").is_some_and(|status| status != "0");
    if !refused || headers.contains_key("grpc-status-details-bin") {
        return response;
    }
    match Status::from_header_map(headers) {
        Some(status) => Status::from(Refusal::of_transport(&status)).into_http(),
        None => response,
    }
}

/// Time that `grpc-timeout` gives a call, if any.
fn deadline(headers: &HeaderMap) -> Result<Option<Duration>, Refusal> {
    let mut values = headers.get_all("grpc-timeout").iter();
    let Some(value) = values.next() else { return Ok(None) };
    if values.next().is_some() {
        return Err(Refusal::field("grpc-timeout", "must be given once"));
    }
    let wrong = || Refusal::field("grpc-timeout", "must be 1 to 8 digits and a unit (H, M, S, m, u, n)");
    value.to_str().ok().and_then(span).map(Some).ok_or_else(wrong)
}

/// A time as gRPC writes it: 1 to 8 digits and a unit.
fn span(text: &str) -> Option<Duration> {
    let (digits, unit) = text.split_at_checked(text.len().checked_sub(1)?)?;
    if digits.len() > 8 || !digits.bytes().all(|b| b.is_ascii_digit()) {
        return None;
    }
    let count: u64 = digits.parse().ok()?;
    Some(match unit {
        "H" => Duration::from_secs(count * 3600),
        "M" => Duration::from_secs(count * 60),
        "S" => Duration::from_secs(count),
        "m" => Duration::from_millis(count),
        "u" => Duration::from_micros(count),
        "n" => Duration::from_nanos(count),
        _ => return None,
    })
}

/// Descriptors that the process may have, after asking for all that it can get.
#[cfg(unix)]
fn descriptors() -> u64 {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
    let limit = getrlimit(Resource::Nofile);
    let _ = setrlimit(Resource::Nofile, Rlimit { current: limit.maximum, maximum: limit.maximum });
    getrlimit(Resource::Nofile).current.unwrap_or(u64::MAX)
}

#[cfg(not(unix))]
fn descriptors() -> u64 {
    u64::MAX
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deadlines_are_read_as_grpc_writes_them() {
        let read = |text: &str| {
            let mut headers = HeaderMap::new();
            headers.insert("grpc-timeout", text.parse().unwrap());
            deadline(&headers)
        };
        assert_eq!(deadline(&HeaderMap::new()), Ok(None));
        let mut twice = HeaderMap::new();
        for text in ["5S", "6S"] {
            twice.append("grpc-timeout", text.parse().unwrap());
        }
        assert!(deadline(&twice).is_err());
        assert_eq!(read("5S"), Ok(Some(Duration::from_secs(5))));
        assert_eq!(read("250m"), Ok(Some(Duration::from_millis(250))));
        assert_eq!(read("99999999H"), Ok(Some(Duration::from_secs(99_999_999 * 3600))));
        for wrong in ["", "S", "5", "5x", "123456789S", "-1S", "ü"] {
            assert!(matches!(read(wrong), Err(Refusal::InvalidField { .. })), "{wrong}");
        }
    }
}
