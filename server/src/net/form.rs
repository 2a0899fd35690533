//! The form of a gRPC call: POST, with a content type of gRPC.
//!
//! *Invariant:* a request that a page in a browser can send without asking first (GET, or POST with the content type of
//! a form or a text) reaches no service. Browsers ask before they send any other request (CORS).

use http::header::CONTENT_TYPE;
use http::{Method, Request, StatusCode};

/// The error of a request that is not a gRPC call. `web` also allows calls of gRPC-Web.
pub(super) fn wrong<B>(request: &Request<B>, web: bool) -> Option<(StatusCode, &'static str)> {
    if request.method() != Method::POST {
        return Some((StatusCode::METHOD_NOT_ALLOWED, "a gRPC call is a POST; use a gRPC client"));
    }
    let mut kinds = request.headers().get_all(CONTENT_TYPE).iter();
    match (kinds.next(), kinds.next()) {
        (Some(kind), None) if is_grpc(kind.as_bytes(), web) => None,
        _ if web => Some((
            StatusCode::UNSUPPORTED_MEDIA_TYPE,
            "the content type of a call must be application/grpc, application/grpc-web or application/grpc-web-text",
        )),
        _ => Some((
            StatusCode::UNSUPPORTED_MEDIA_TYPE,
            "the content type of a gRPC call must be application/grpc (gRPC-Web is off on this server)",
        )),
    }
}

/// Whether a content type is one of gRPC, with or without a message format and parameters.
fn is_grpc(kind: &[u8], web: bool) -> bool {
    let names: &[&[u8]] = if web {
        &[b"application/grpc", b"application/grpc-web", b"application/grpc-web-text"]
    } else {
        &[b"application/grpc"]
    };
    let end = kind.iter().position(|byte| matches!(byte, b'+' | b';' | b' ')).unwrap_or(kind.len());
    kind.get(..end).is_some_and(|name| names.iter().any(|known| name.eq_ignore_ascii_case(known)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(method: Method, kinds: &[&str], web: bool) -> Option<u16> {
        let request = Request::builder().method(method).uri("/counterpoint.v1.Jobs/SubmitJob");
        let request = kinds.iter().fold(request, |request, kind| request.header(CONTENT_TYPE, *kind));
        wrong(&request.body(()).unwrap(), web).map(|(status, _)| status.as_u16())
    }

    #[test]
    fn only_a_post_with_a_content_type_of_grpc_is_a_call() {
        let post = |kind: &str, web| asked(Method::POST, &[kind], web);
        for kind in ["application/grpc", "application/grpc+proto", "application/grpc;charset=utf-8", "Application/gRPC"]
        {
            assert_eq!((post(kind, false), post(kind, true)), (None, None), "{kind}");
        }
        for kind in ["application/grpc-web", "application/grpc-web+proto", "application/grpc-web-text"] {
            assert_eq!((post(kind, false), post(kind, true)), (Some(415), None), "{kind}");
        }
        for kind in ["", "text/plain", "application/json", "application/grpcx", "application/x-www-form-urlencoded"] {
            assert_eq!((post(kind, false), post(kind, true)), (Some(415), Some(415)), "{kind}");
        }
        assert_eq!(asked(Method::POST, &[], true), Some(415));
        assert_eq!(asked(Method::POST, &["application/grpc", "text/plain"], false), Some(415), "one of two");
        for method in [Method::GET, Method::PUT, Method::OPTIONS, Method::HEAD] {
            assert_eq!(asked(method, &["application/grpc"], true), Some(405));
        }
    }
}
