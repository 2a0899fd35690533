//! gRPC-Web over HTTP/1.1.

use base64::Engine as _;
use base64::prelude::BASE64_STANDARD as STANDARD;
use counterpoint_proto::v1;
use counterpoint_server::access::Role;
use http::Method;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;
use tonic::body::Body;
use tonic::transport::Endpoint;
use tower_service::Service as _;

use crate::guarded::*;
use crate::support::*;

const LIST: &str = "/counterpoint.v1.Jobs/ListJobs";

/// Sends a request and gives all that comes back until the server closes the connection.
pub(crate) async fn ask(server: &Server, method: &str, headers: &str, body: &[u8]) -> Vec<u8> {
    ask_at(server, (method, LIST), headers, body).await
}

/// Sends a request to a path.
pub(crate) async fn ask_at(server: &Server, (method, path): (&str, &str), headers: &str, body: &[u8]) -> Vec<u8> {
    let mut stream = TcpStream::connect(server.handle.address()).await.unwrap();
    let length = body.len();
    let head = format!(
        "{method} {path} HTTP/1.1\r\nhost: x\r\nconnection: close\r\ncontent-length: {length}\r\n{headers}\r\n"
    );
    stream.write_all(head.as_bytes()).await.unwrap();
    stream.write_all(body).await.unwrap();
    let mut answer = Vec::new();
    let _ = stream.read_to_end(&mut answer).await;
    answer
}

#[tokio::test]
async fn grpc_web_is_spoken_only_where_it_was_switched_on() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = guarded(folder.path());
    let token = grant(&options, "page", "t", Role::Read);
    let call = format!(
        "content-type: application/grpc-web+proto\r\norigin: https://cam.example\r\nauthorization: Bearer {token}\r\n"
    );
    let server = Server::start(options.clone()).await;
    let answer = ask(&server, "POST", &call, &[0; 5]).await;
    assert!(!String::from_utf8_lossy(&answer).contains("200 OK"), "it is off");
    server.stop().await;

    (options.guard.grpc_web, options.guard.grpc_web_origins) = (true, "https://cam.example".into());
    let server = Server::start(options).await;
    let text = |answer: Vec<u8>| String::from_utf8_lossy(&answer).into_owned();
    let answer = text(ask(&server, "POST", &call, &[0; 5]).await);
    assert!(answer.starts_with("HTTP/1.1 200 OK") && answer.contains("grpc-status:0"), "{answer}");
    assert!(answer.contains("access-control-allow-origin: https://cam.example"), "{answer}");
    let foreign = call.replace("cam.example", "evil.example");
    let answer = text(ask(&server, "POST", &foreign, &[0; 5]).await);
    assert!(!answer.contains("access-control-allow-origin"), "{answer}");
    let nobody = "content-type: application/grpc-web+proto\r\norigin: https://cam.example\r\n";
    let answer = text(ask(&server, "POST", nobody, &[0; 5]).await);
    assert!(answer.contains("grpc-status: 16"), "an identity is needed as ever: {answer}");
    let question = "origin: https://cam.example\r\naccess-control-request-method: POST\r\n";
    let answer = text(ask(&server, "OPTIONS", question, b"").await);
    assert!(answer.starts_with("HTTP/1.1 204") && answer.contains("access-control-allow-methods: POST"), "{answer}");
    let plain = "content-type: application/grpc\r\n".to_owned() + &format!("authorization: Bearer {token}\r\n");
    let answer = text(ask(&server, "POST", &plain, &[0; 5]).await);
    assert!(!answer.contains("grpc-status: 0") && !answer.contains("grpc-status:0"), "{answer}");
    // HTTP/2 on the same port is served as before.
    As::new(&server, &token).list().await;
    server.stop().await;
}

/// Requests that a page in a browser can send by HTTP/2 without asking first.
#[tokio::test]
async fn a_request_that_is_no_grpc_call_reaches_no_service() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(options(folder.path())).await;
    let endpoint = Endpoint::from_shared(format!("http://{}", server.handle.address())).unwrap();
    let mut connection = endpoint.connect().await.unwrap();
    let drain = "/counterpoint.v1.Admin/Drain";
    let mut send = async |method: &Method, path: &str, kind: &str| {
        let request = http::Request::builder().method(method).uri(path).header("origin", "https://evil.example");
        let request = request.header("content-type", kind).body(Body::empty()).unwrap();
        std::future::poll_fn(|cx| connection.poll_ready(cx)).await.unwrap();
        connection.call(request).await.unwrap()
    };
    for kind in ["text/plain", "application/json", "application/grpc-web+proto", ""] {
        for path in [drain, "/grpc.health.v1.Health/Check", "/nothing"] {
            let answer = send(&Method::POST, path, kind).await;
            assert_eq!(answer.status(), 415, "{path} {kind}");
            assert_eq!(answer.headers()["grpc-status"], "12", "{path} {kind}");
        }
    }
    for method in [Method::GET, Method::PUT, Method::OPTIONS] {
        let answer = send(&method, drain, "application/grpc").await;
        assert_eq!((answer.status().as_u16(), &answer.headers()["allow"]), (405, &"POST".parse().unwrap()), "{method}");
    }
    // Nothing was drained.
    server.jobs().list_jobs(v1::ListJobsRequest::default()).await.unwrap();
    server.stop().await;
}

/// Libraries for pages read the status of an answer only if its content type is that of gRPC-Web.
#[tokio::test]
async fn a_refusal_before_the_service_has_the_content_type_of_the_request() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = guarded(folder.path());
    (options.guard.grpc_web, options.guard.grpc_web_origins) = (true, "https://cam.example".into());
    let token = grant(&options, "page", "t", Role::Read);
    let server = Server::start(options).await;
    let known = format!("authorization: Bearer {token}\r\n");
    let cases = [
        (LIST, "", "16"),
        ("/counterpoint.v1.Admin/Drain", &known, "7"),
        ("/counterpoint.v1.Jobs/Nothing", &known, "12"),
        (LIST, &format!("{known}grpc-timeout: soon\r\n"), "3"),
    ];
    for (path, headers, status) in cases {
        for kind in ["application/grpc-web+proto", "application/grpc-web-text+proto"] {
            let headers = format!("content-type: {kind}\r\norigin: https://cam.example\r\n{headers}");
            let answer = ask_at(&server, ("POST", path), &headers, &[0; 5]).await;
            let text = String::from_utf8_lossy(&answer);
            assert!(text.contains(&format!("grpc-status: {status}")), "{path}: {text}");
            assert!(text.contains(&format!("content-type: {kind}\r\n")), "{path}: {text}");
            assert!(text.contains("access-control-allow-origin: https://cam.example"), "{path}: {text}");
        }
    }
    server.stop().await;
}

/// A page reads no HTTP trailers, so the status has to be in the last message.
#[tokio::test]
async fn a_stream_that_ends_early_tells_a_page_its_reason() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = guarded(folder.path());
    options.guard.grpc_web = true;
    let token = grant(&options, "page", "t", Role::Read);
    let server = Server::start(options).await;
    let calls: [(&str, &[u8]); 2] =
        [("application/grpc-web+proto", &[0; 5]), ("application/grpc-web-text+proto", b"AAAAAAA=")];
    for (kind, body) in calls {
        let headers = format!(
            "content-type: {kind}\r\ngrpc-timeout: 300m\r\nauthorization: Bearer {token}\r\naccept: {kind}\r\n"
        );
        let answer = ask_at(&server, ("POST", "/counterpoint.v1.Jobs/WatchJobs"), &headers, body).await;
        let text = String::from_utf8_lossy(&answer);
        let (head, messages) = text.split_once("\r\n\r\n").unwrap();
        assert!(head.starts_with("HTTP/1.1 200 OK") && !head.contains("grpc-status"), "{text}");
        let decoded =
            messages.split("\r\n").filter_map(|chunk| STANDARD.decode(chunk).ok()).flatten().collect::<Vec<u8>>();
        let read = messages.to_owned() + &String::from_utf8_lossy(&decoded);
        assert!(read.contains("grpc-status:4") && !read.contains("content-type"), "{kind}: {text}");
    }
    server.stop().await;
}
