//! Monitoring over HTTP: `/metrics`, `/livez`, `/readyz`.
//!
//! Invariant: nothing here changes the server. One peer holds a connection for no longer than [`PATIENCE`], and
//! connections that ask nothing keep no other one out.

use std::collections::VecDeque;
use std::convert::Infallible;
use std::future::Future;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;

use bytes::Bytes;
use http::{Method, Request, Response, StatusCode, header};
use http_body::{Frame, SizeHint};
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::{TcpListener, TcpStream};
use tokio::task::AbortHandle;
use tokio::time::{sleep, timeout};
use tonic::body::Body;

use super::ACCEPT_PAUSE;
use crate::jobs::Core;

/// Longest time of a connection.
const PATIENCE: Duration = Duration::from_secs(30);
/// Most connections at the same time; a further one ends the oldest.
const MOST: usize = 32;

/// Answers until it is dropped.
pub(crate) async fn serve(listener: TcpListener, core: Arc<Core>) {
    let mut open: VecDeque<AbortHandle> = VecDeque::new();
    loop {
        match listener.accept().await {
            Ok((stream, _)) => {
                open.retain(|connection| !connection.is_finished());
                if open.len() >= MOST
                    && let Some(oldest) = open.pop_front()
                {
                    oldest.abort();
                }
                let core = Arc::downgrade(&core);
                let connection = tokio::spawn(async move {
                    let answer = |request| {
                        let core = core.clone();
                        async move { Ok::<_, Infallible>(answer(core.upgrade(), request).await) }
                    };
                    let _ = timeout(PATIENCE, connection(stream, answer)).await;
                });
                open.push_back(connection.abort_handle());
            }
            Err(_) => sleep(ACCEPT_PAUSE).await,
        }
    }
}

async fn connection<F, R>(stream: TcpStream, answer: F) -> hyper::Result<()>
where
    F: Fn(Request<Incoming>) -> R,
    R: Future<Output = Result<Response<Body>, Infallible>>,
{
    http1::Builder::new().timer(TokioTimer::new()).serve_connection(TokioIo::new(stream), service_fn(answer)).await
}

async fn answer(core: Option<Arc<Core>>, request: Request<Incoming>) -> Response<Body> {
    let text = |status: StatusCode, text: &str| response(status, "text/plain; charset=utf-8", text.to_owned());
    if !matches!(*request.method(), Method::GET | Method::HEAD) {
        return text(StatusCode::METHOD_NOT_ALLOWED, "only GET and HEAD are answered\n");
    }
    let Some(core) = core else { return text(StatusCode::SERVICE_UNAVAILABLE, "the server has stopped\n") };
    match request.uri().path() {
        "/livez" => text(StatusCode::OK, "ok\n"),
        "/readyz" => match core.unready() {
            None => text(StatusCode::OK, "ok\n"),
            Some(reason) => text(StatusCode::SERVICE_UNAVAILABLE, &format!("{reason}\n")),
        },
        "/metrics" => {
            let read = tokio::task::spawn_blocking(move || {
                core.observe();
                core.metrics.text()
            });
            let kind = "application/openmetrics-text; version=1.0.0; charset=utf-8";
            read.await.map_or_else(
                |error| text(StatusCode::INTERNAL_SERVER_ERROR, &error.to_string()),
                |metrics| response(StatusCode::OK, kind, metrics),
            )
        }
        _ => text(StatusCode::NOT_FOUND, "there are /metrics, /livez and /readyz\n"),
    }
}

fn response(status: StatusCode, kind: &'static str, text: String) -> Response<Body> {
    let mut response = Response::new(Body::new(Full(Some(text.into()))));
    *response.status_mut() = status;
    response.headers_mut().insert(header::CONTENT_TYPE, header::HeaderValue::from_static(kind));
    response
}

/// A content that is there as a whole.
struct Full(Option<Bytes>);

impl http_body::Body for Full {
    type Data = Bytes;
    type Error = Infallible;

    fn poll_frame(mut self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<Option<Result<Frame<Bytes>, Infallible>>> {
        Poll::Ready(self.0.take().map(|content| Ok(Frame::data(content))))
    }

    fn is_end_stream(&self) -> bool {
        self.0.is_none()
    }

    fn size_hint(&self) -> SizeHint {
        SizeHint::with_exact(self.0.as_ref().map_or(0, |content| content.len() as u64))
    }
}
