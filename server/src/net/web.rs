//! gRPC-Web, for programs in browsers: HTTP/1.1 beside HTTP/2, and the questions that browsers ask first (CORS).
//!
//! *Invariant:* a page from elsewhere reads an answer only if its origin is among those of the configuration.
//! Identities are requested as in every other call: the answer to a question of a browser says nothing about the
//! server.

use http::header::{
    ACCESS_CONTROL_ALLOW_HEADERS, ACCESS_CONTROL_ALLOW_METHODS, ACCESS_CONTROL_ALLOW_ORIGIN,
    ACCESS_CONTROL_EXPOSE_HEADERS, ACCESS_CONTROL_MAX_AGE, ACCESS_CONTROL_REQUEST_METHOD, CONTENT_TYPE, ORIGIN, VARY,
};
use http::{HeaderMap, HeaderName, HeaderValue, Method, Request, Response, StatusCode};
use tonic::body::Body;

use crate::options::Guard;

/// Headers that pages may send and read beyond those that browsers always allow.
const REQUEST_HEADERS: &str = "authorization,content-type,grpc-timeout,traceparent,x-grpc-web,x-user-agent";
const ANSWER_HEADERS: &str = "grpc-status,grpc-message,grpc-status-details-bin";

/// Whether and for whom gRPC-Web is spoken.
#[derive(Debug)]
pub(crate) struct Web {
    origins: Vec<String>,
}

impl Web {
    /// As the options say; `None` = not at all.
    pub(super) fn open(options: &Guard) -> Option<Self> {
        let origins = options.grpc_web_origins.split(',').map(|origin| origin.trim().to_ascii_lowercase());
        options.grpc_web.then(|| Self { origins: origins.filter(|origin| !origin.is_empty()).collect() })
    }

    /// The origin of a request, if its page may read the answer.
    fn origin(&self, headers: &HeaderMap) -> Option<HeaderValue> {
        let origin = headers.get(ORIGIN)?;
        let known = |allowed: &String| allowed == "*" || origin.as_bytes().eq_ignore_ascii_case(allowed.as_bytes());
        self.origins.iter().any(known).then(|| origin.clone())
    }

    /// Answers the question of a browser whether a page may make a call; `None` if the request is another one.
    pub(super) fn preflight<B>(&self, request: &Request<B>) -> Option<Response<Body>> {
        if request.method() != Method::OPTIONS || !request.headers().contains_key(ACCESS_CONTROL_REQUEST_METHOD) {
            return None;
        }
        let mut response = Response::new(Body::empty());
        *response.status_mut() = StatusCode::NO_CONTENT;
        if let Some(origin) = self.origin(request.headers()) {
            let headers = response.headers_mut();
            allow(headers, origin);
            set(headers, ACCESS_CONTROL_ALLOW_METHODS, "POST");
            set(headers, ACCESS_CONTROL_ALLOW_HEADERS, REQUEST_HEADERS);
            set(headers, ACCESS_CONTROL_MAX_AGE, "600");
        }
        Some(response)
    }

    /// The form of the answer to a request.
    pub(super) fn form_of_answer(&self, request: &HeaderMap) -> AnswerForm {
        let kind = request.get(CONTENT_TYPE).map_or(&[][..], HeaderValue::as_bytes);
        let kind = match (kind.starts_with(b"application/grpc-web-text"), kind.starts_with(b"application/grpc-web")) {
            (true, _) => Some("application/grpc-web-text+proto"),
            (_, true) => Some("application/grpc-web+proto"),
            _ => None,
        };
        AnswerForm { origin: self.origin(request), kind }
    }
}

/// The form of an answer to a page.
#[derive(Default)]
pub(super) struct AnswerForm {
    /// The origin whose pages may read the answer.
    origin: Option<HeaderValue>,
    /// The content type of the protocol; none for other protocols.
    kind: Option<&'static str>,
}

impl AnswerForm {
    /// Lets pages read an answer. An answer that no service has made gets the content type of gRPC-Web.
    pub(super) fn apply(self, headers: &mut HeaderMap) {
        if let Some(origin) = self.origin {
            allow(headers, origin);
        }
        if let Some(kind) = self.kind
            && headers.get(CONTENT_TYPE).is_some_and(|kind| kind == "application/grpc")
        {
            set(headers, CONTENT_TYPE, kind);
        }
    }
}

/// Lets pages of an origin read an answer.
fn allow(headers: &mut HeaderMap, origin: HeaderValue) {
    headers.insert(ACCESS_CONTROL_ALLOW_ORIGIN, origin);
    set(headers, ACCESS_CONTROL_EXPOSE_HEADERS, ANSWER_HEADERS);
    set(headers, VARY, "origin");
}

fn set(headers: &mut HeaderMap, name: HeaderName, value: &'static str) {
    headers.insert(name, HeaderValue::from_static(value));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn web(origins: &str) -> Web {
        Web::open(&Guard { grpc_web: true, grpc_web_origins: origins.into(), ..Guard::default() }).unwrap()
    }

    fn asked(origin: &str) -> Request<()> {
        let request = Request::builder().method(Method::OPTIONS).uri("/counterpoint.v1.Jobs/GetJob");
        request.header(ORIGIN, origin).header(ACCESS_CONTROL_REQUEST_METHOD, "POST").body(()).unwrap()
    }

    #[test]
    fn only_pages_of_the_origins_of_the_configuration_may_call() {
        assert!(Web::open(&Guard::default()).is_none());
        let web = web("https://cam.example, https://b.example");
        let answer = web.preflight(&asked("https://CAM.example")).unwrap();
        assert_eq!(answer.headers()[ACCESS_CONTROL_ALLOW_ORIGIN], "https://CAM.example");
        for stranger in ["https://evil.example", "https://cam.example.evil", "null", ""] {
            let answer = web.preflight(&asked(stranger)).unwrap();
            assert!(!answer.headers().contains_key(ACCESS_CONTROL_ALLOW_ORIGIN), "{stranger}");
        }
        let post = Request::builder().method(Method::POST).header(ORIGIN, "https://cam.example").body(()).unwrap();
        assert!(web.preflight(&post).is_none());
    }
}
