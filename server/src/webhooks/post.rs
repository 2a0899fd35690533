//! One attempt to deliver a message.

use hyper::client::conn::http1;
use hyper::header::{CONTENT_TYPE, HOST, USER_AGENT};
use hyper::{Request, StatusCode};
use hyper_util::rt::TokioIo;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpStream;

use super::message::WebhookMessage;
use super::target::WebhookTarget;

/// Posts a message, and returns the status of the answer. Its content is not read.
pub(super) async fn post(target: &WebhookTarget, message: &WebhookMessage, seconds: i64) -> Result<StatusCode, String> {
    let endpoint = &target.endpoint;
    let stream = TcpStream::connect((endpoint.host.as_str(), endpoint.port)).await.map_err(|e| e.to_string())?;
    match &target.tls {
        Some((connector, name)) => {
            let stream = connector.connect(name.clone(), stream).await.map_err(|e| e.to_string())?;
            send(stream, target, message, seconds).await
        }
        None => send(stream, target, message, seconds).await,
    }
}

async fn send(
    stream: impl AsyncRead + AsyncWrite + Unpin + Send + 'static,
    target: &WebhookTarget,
    message: &WebhookMessage,
    seconds: i64,
) -> Result<StatusCode, String> {
    let (mut sender, connection) = http1::handshake(TokioIo::new(stream)).await.map_err(|e| e.to_string())?;
    let request = Request::post(&target.endpoint.path)
        .header(HOST, &target.endpoint.authority)
        .header(USER_AGENT, concat!("counterpoint/", env!("CARGO_PKG_VERSION")))
        .header(CONTENT_TYPE, "application/json")
        .header("webhook-id", &message.id)
        .header("webhook-timestamp", seconds)
        .header("webhook-signature", target.signature(&message.id, seconds, &message.body))
        .body(message.body.clone())
        .map_err(|e| e.to_string())?;
    let mut answer = std::pin::pin!(sender.send_request(request));
    let answer = tokio::select! {
        answer = &mut answer => answer,
        // The answer, or the reason why there is none, is available when the connection has ended.
        _ = connection => answer.await,
    };
    answer.map(|answer| answer.status()).map_err(|e| e.to_string())
}
