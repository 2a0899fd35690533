//! Answers that end early, because the rights of their caller end or their deadline passes.
//!
//! The status goes to the body of the service, below the translation to gRPC-Web. *Invariant:* the client of an answer
//! that is cut reads the reason in the form of its protocol.

use std::convert::Infallible;
use std::future::Future;
use std::pin::Pin;
use std::sync::{Arc, OnceLock};
use std::task::{Context, Poll};

use bytes::Bytes;
use http::header::CONTENT_TYPE;
use http::{Request, Response};
use http_body::{Frame, SizeHint};
use tonic::Status;
use tonic::body::Body;
use tonic::service::Routes;
use tonic_web::GrpcWebLayer;
use tower_layer::Layer as _;
use tower_service::Service;

/// The status with which an answer is cut, once there is one.
#[derive(Clone, Default)]
pub(super) struct CutStatus(Arc<OnceLock<Status>>);

impl CutStatus {
    /// Cuts the answer. Only the first status counts.
    pub(super) fn with(&self, status: Status) {
        let _ = self.0.set(status);
    }

    /// The answer of a service, which ends when it is cut.
    fn watched(&self, answer: Response<Body>) -> Response<Body> {
        answer.map(|body| Body::new(Cuttable { body: Some(body), cut: self.clone() }))
    }
}

/// A body of a service that ends with the status of its cut.
struct Cuttable {
    /// None after a cut.
    body: Option<Body>,
    cut: CutStatus,
}

impl http_body::Body for Cuttable {
    type Data = Bytes;
    type Error = Status;

    fn poll_frame(mut self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<Option<Result<Frame<Bytes>, Status>>> {
        if let Some(status) = self.cut.0.get().cloned() {
            // The service sees that its client has gone.
            let cut = self.body.take().is_some_and(|body| !body.is_end_stream());
            let trailers = || {
                let mut headers = std::mem::take(status.into_http::<Body>().headers_mut());
                headers.remove(CONTENT_TYPE);
                Ok(Frame::trailers(headers))
            };
            return Poll::Ready(cut.then(trailers));
        }
        match &mut self.body {
            Some(body) => Pin::new(body).poll_frame(cx),
            None => Poll::Ready(None),
        }
    }

    fn is_end_stream(&self) -> bool {
        self.body.as_ref().is_none_or(Body::is_end_stream)
    }

    fn size_hint(&self) -> SizeHint {
        self.body.as_ref().map_or_else(|| SizeHint::with_exact(0), Body::size_hint)
    }
}

/// Hands a call to its service, translated from gRPC-Web where that is allowed.
pub(super) async fn ask(
    routes: Routes,
    request: Request<Body>,
    cut: &CutStatus,
    web: bool,
) -> Result<Response<Body>, Infallible> {
    let mut routes = CuttableRoutes { routes, cut: cut.clone() };
    match web {
        true => GrpcWebLayer::new().layer(routes).call(request).await,
        false => routes.call(request).await,
    }
}

/// The services, whose answer to one call can be cut.
struct CuttableRoutes {
    routes: Routes,
    cut: CutStatus,
}

impl Service<Request<Body>> for CuttableRoutes {
    type Response = Response<Body>;
    type Error = Infallible;
    type Future = Pin<Box<dyn Future<Output = Result<Response<Body>, Infallible>> + Send>>;

    fn poll_ready(&mut self, cx: &mut Context<'_>) -> Poll<Result<(), Infallible>> {
        Service::<Request<Body>>::poll_ready(&mut self.routes, cx)
    }

    fn call(&mut self, request: Request<Body>) -> Self::Future {
        let (answer, cut) = (self.routes.call(request), self.cut.clone());
        Box::pin(async move { Ok(cut.watched(answer.await?)) })
    }
}
