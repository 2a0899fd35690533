use std::collections::BTreeMap;
use std::io::{Read as _, Write as _};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use rustls::pki_types::PrivateKeyDer;
use rustls::{ServerConfig, ServerConnection};
use tempfile::TempDir;

use super::Webhooks;
use super::delivery::Retries;
use super::message::WebhookMessage;
use super::target::WebhookTarget;
use crate::ledger::first_error::FirstError;
use crate::ledger::record::tests::record;
use crate::ledger::record::{Cause, JobRecord, JobState};
use crate::metrics::Metrics;
use crate::options::Webhook;

/// Longest time that a test waits for something that must come.
const PATIENCE: Duration = Duration::from_secs(60);

/// A request as a target has received it.
#[derive(Debug)]
struct Received {
    head: String,
    body: String,
}

impl Received {
    fn header(&self, name: &str) -> &str {
        let found = self.head.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(": "));
        found.unwrap_or_else(|| panic!("{name} in {}", self.head))
    }
}

fn read(stream: &mut TcpStream) -> Received {
    let mut bytes = Vec::new();
    let mut part = [0; 4096];
    loop {
        let text = String::from_utf8_lossy(&bytes).into_owned();
        if let Some((head, body)) = text.split_once("\r\n\r\n") {
            let received = Received { head: head.to_owned(), body: body.to_owned() };
            if body.len() >= received.header("content-length").parse::<usize>().unwrap() {
                return received;
            }
        }
        let count = stream.read(&mut part).unwrap();
        assert!(count > 0, "the request ends early: {text}");
        bytes.extend_from_slice(&part[..count]);
    }
}

/// A target that gives these answers, one for each request, and hands on the requests.
fn target(answers: &'static [&'static str]) -> (SocketAddr, Receiver<Received>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let (send, receive) = channel();
    std::thread::spawn(move || {
        for answer in answers {
            let (mut stream, _) = listener.accept().unwrap();
            let received = read(&mut stream);
            write!(stream, "HTTP/1.1 {answer}\r\ncontent-length: 0\r\n\r\n").unwrap();
            if send.send(received).is_err() {
                return;
            }
        }
    });
    (address, receive)
}

struct Table {
    folder: TempDir,
    targets: BTreeMap<String, Webhook>,
}

impl Table {
    fn new() -> Self {
        let folder = TempDir::new().unwrap();
        std::fs::write(folder.path().join("secret"), "a secret of 20 bytes\n").unwrap();
        Self { folder, targets: BTreeMap::new() }
    }

    fn secret(&self) -> PathBuf {
        self.folder.path().join("secret")
    }

    fn with(mut self, name: &str, url: &str, tenants: &[&str], states: &[&str]) -> Self {
        let texts = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect();
        let webhook = Webhook {
            url: url.to_owned(),
            secret_file: self.secret(),
            tenants: texts(tenants),
            states: texts(states),
            ca_file: None,
        };
        self.targets.insert(name.to_owned(), webhook);
        self
    }

    fn start(&self, metrics: &Arc<Metrics>) -> Webhooks {
        self.start_for(metrics, PATIENCE)
    }

    /// Messages of this age are given up.
    fn start_for(&self, metrics: &Arc<Metrics>, age: Duration) -> Webhooks {
        let retries = Retries {
            attempt: PATIENCE,
            pause: Duration::from_millis(1),
            longest_pause: Duration::from_millis(4),
            age,
        };
        Webhooks::start_with(&self.targets, false, metrics, retries).unwrap()
    }
}

fn ended(id: &str, tenant: &str, state: JobState) -> JobRecord {
    JobRecord { tenant: tenant.to_owned(), state, ended_ms: 1_700_000_000_000, ..record(id) }
}

fn count(metrics: &Metrics, target: &str, outcome: &str) -> u64 {
    let text = metrics.text();
    let start = format!("counterpoint_webhooks_total{{target=\"{target}\",outcome=\"{outcome}\"}} ");
    text.lines().find_map(|line| line.strip_prefix(&start)?.parse().ok()).unwrap_or(0)
}

#[test]
fn a_message_names_the_job_whose_results_were_reused() {
    let data = |record: &JobRecord| {
        let body: serde_json::Value = serde_json::from_str(&WebhookMessage::of(record).body).unwrap();
        body["data"]["reused_from"].clone()
    };
    let mut record = ended("7", "default", JobState::Succeeded);
    assert_eq!(data(&record), serde_json::Value::Null);
    record.reuse.from = "5".to_owned();
    assert_eq!(data(&record), "5");
}

#[test]
fn a_message_has_the_first_error_of_a_failed_job() {
    let data = |record: &JobRecord| {
        let body: serde_json::Value = serde_json::from_str(&WebhookMessage::of(record).body).unwrap();
        body["data"]["first_error"].clone()
    };
    let mut record = ended("7", "default", JobState::Failed);
    assert_eq!(data(&record), serde_json::Value::Null);
    record.first_error = Some(FirstError::new(2_900_061, ("division by zero", "part.nc"), 3, 1));
    let expected = serde_json::json!({
        "number": 2_900_061, "text": "division by zero", "file": "part.nc", "line": 3, "channel": 1,
    });
    assert_eq!(data(&record), expected);
}

#[test]
fn the_end_of_a_job_is_posted_with_a_signature() {
    let (address, received) = target(&["204 No Content"]);
    let table = Table::new().with("mes", &format!("http://{address}/hook?cell=3"), &["default"], &[]);
    let metrics = Arc::new(Metrics::new());
    let webhooks = table.start(&metrics);
    let mut failed = ended("7", "default", JobState::Failed);
    failed.runs.cause = Some(Cause::Limit);
    webhooks.ended(&failed);
    let request = received.recv_timeout(PATIENCE).unwrap();
    assert!(request.head.starts_with("POST /hook?cell=3 HTTP/1.1\r\n"), "{}", request.head);
    assert_eq!(request.header("content-type"), "application/json");
    assert_eq!(request.header("webhook-id"), "job_7");
    let body: serde_json::Value = serde_json::from_str(&request.body).unwrap();
    assert_eq!((&body["type"], &body["data"]["state"]), (&"job.ended".into(), &"FAILED".into()));
    assert_eq!((&body["data"]["job_id"], &body["data"]["cause"]), (&"7".into(), &"LIMIT".into()));
    let of = WebhookTarget::new("mes", &table.targets["mes"], false).unwrap();
    let seconds = request.header("webhook-timestamp").parse().unwrap();
    assert_eq!(request.header("webhook-signature"), of.signature("job_7", seconds, &request.body));
    webhooks.close();
    assert_eq!(count(&metrics, "mes", "delivered"), 1);
}

/// The expected values come from Python's hmac and base64.
#[test]
fn signatures_are_those_of_standard_webhooks() {
    let table = Table::new().with("mes", "http://localhost/", &["*"], &[]);
    let sign = || {
        let target = WebhookTarget::new("mes", &table.targets["mes"], false).unwrap();
        target.signature("job_1", 1_700_000_000, "{\"a\":1}")
    };
    assert_eq!(sign(), "v1,pWnssGbpIhBV2Ru3VOQs86JmpOIBkOTBdEQnojq1rIc=");
    std::fs::write(table.secret(), "whsec_MDEyMzQ1Njc4OWFiY2RlZjAxMjM0NTY3").unwrap();
    assert_eq!(sign(), "v1,rgNV8eaFhok7bxE3jEyWp8j78UP2wQd3yS2xdnI4KpY=");
}

#[test]
fn a_message_is_sent_again_until_it_is_taken_and_the_next_one_follows_it() {
    let (address, received) = target(&["503 Service Unavailable", "429 Too Many Requests", "200 OK", "200 OK"]);
    let table = Table::new().with("mes", &format!("http://{address}/"), &["default"], &[]);
    let metrics = Arc::new(Metrics::new());
    let webhooks = table.start(&metrics);
    webhooks.ended(&ended("1", "default", JobState::Succeeded));
    webhooks.ended(&ended("2", "default", JobState::Succeeded));
    let ids = || received.recv_timeout(PATIENCE).unwrap().header("webhook-id").to_owned();
    assert_eq!([ids(), ids(), ids(), ids()], ["job_1", "job_1", "job_1", "job_2"]);
    webhooks.close();
    assert_eq!(count(&metrics, "mes", "delivered"), 2);
}

#[test]
fn a_refused_message_and_a_redirect_are_not_sent_again() {
    let (address, received) = target(&["404 Not Found", "302 Found\r\nlocation: http://127.0.0.1:1/other", "200 OK"]);
    let table = Table::new().with("mes", &format!("http://{address}/"), &["default"], &[]);
    let metrics = Arc::new(Metrics::new());
    let webhooks = table.start(&metrics);
    for id in ["1", "2", "3"] {
        webhooks.ended(&ended(id, "default", JobState::Succeeded));
    }
    let ids = || received.recv_timeout(PATIENCE).unwrap().header("webhook-id").to_owned();
    assert_eq!([ids(), ids(), ids()], ["job_1", "job_2", "job_3"]);
    webhooks.close();
    assert_eq!((count(&metrics, "mes", "refused"), count(&metrics, "mes", "delivered")), (2, 1));
}

#[test]
fn a_target_hears_of_its_tenants_and_states_only_and_none_delays_another() {
    // Nothing listens at the address of a closed listener.
    let gone = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let (address, received) = target(&["200 OK", "200 OK"]);
    let table = Table::new().with("cell", &format!("http://{address}/"), &["a", "b"], &["FAILED", "CANCELLED"]).with(
        "down",
        &format!("http://{gone}/"),
        &["*"],
        &[],
    );
    let metrics = Arc::new(Metrics::new());
    let webhooks = table.start(&metrics);
    let jobs = [
        ("1", "a", JobState::Succeeded),
        ("2", "a", JobState::Failed),
        ("3", "default", JobState::Failed),
        ("4", "b", JobState::Cancelled),
        ("5", "b", JobState::Queued),
    ];
    jobs.iter().for_each(|(id, tenant, state)| webhooks.ended(&ended(id, tenant, *state)));
    let ids = || received.recv_timeout(PATIENCE).unwrap().header("webhook-id").to_owned();
    assert_eq!([ids(), ids()], ["job_2", "job_4"]);
    assert_eq!(webhooks.close(), 4, "the log has the number for each target");
    assert_eq!((count(&metrics, "cell", "delivered"), count(&metrics, "down", "given_up")), (2, 4));
}

/// Nothing is sent to a target whose certificate no known authority has signed; the end of the attempts is counted.
#[test]
fn a_message_to_a_target_of_an_unknown_authority_is_given_up() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let certify = || rcgen::generate_simple_self_signed(vec!["localhost".to_owned()]).unwrap();
    let (shown, known) = (certify(), certify());
    let key = PrivateKeyDer::try_from(shown.signing_key.serialize_der()).unwrap();
    let builder = ServerConfig::builder_with_provider(Arc::new(rustls::crypto::ring::default_provider()));
    let builder = builder.with_safe_default_protocol_versions().unwrap().with_no_client_auth();
    let config = Arc::new(builder.with_single_cert(vec![shown.cert.der().clone()], key).unwrap());
    let (send, outcomes) = channel();
    std::thread::spawn(move || {
        loop {
            let (mut stream, _) = listener.accept().unwrap();
            let mut connection = ServerConnection::new(config.clone()).unwrap();
            let heard = rustls::Stream::new(&mut connection, &mut stream).read(&mut [0]);
            if send.send(heard.unwrap_or(0)).is_err() {
                return;
            }
        }
    });
    let mut table = Table::new().with("mes", &format!("https://localhost:{}/", address.port()), &["*"], &[]);
    let ca_file = table.folder.path().join("ca.pem");
    std::fs::write(&ca_file, known.cert.pem()).unwrap();
    table.targets.values_mut().for_each(|webhook| webhook.ca_file = Some(ca_file.clone()));
    let metrics = Arc::new(Metrics::new());
    let webhooks = table.start_for(&metrics, Duration::from_millis(2));
    webhooks.ended(&ended("1", "default", JobState::Succeeded));
    assert_eq!(outcomes.recv_timeout(PATIENCE), Ok(0), "the handshake fails");
    webhooks.close();
    assert_eq!((count(&metrics, "mes", "given_up"), count(&metrics, "mes", "delivered")), (1, 0));
}

#[test]
fn messages_beyond_the_queue_of_a_target_are_counted_as_dropped() {
    let gone = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let table = Table::new().with("down", &format!("http://{gone}/"), &["*"], &[]);
    let metrics = Arc::new(Metrics::new());
    let webhooks = table.start(&metrics);
    for _ in 0..super::WAITING + 50 {
        webhooks.ended(&ended("1", "a", JobState::Succeeded));
    }
    let dropped = count(&metrics, "down", "dropped");
    assert!((40..=50).contains(&dropped), "{dropped}");
}

#[test]
fn a_wrong_table_is_refused_with_its_key() {
    let refused = |change: fn(&mut Webhook)| {
        let mut table = Table::new().with("mes", "https://localhost/", &["*"], &[]);
        table.targets.values_mut().for_each(change);
        let metrics = Arc::new(Metrics::new());
        Webhooks::start(&table.targets, false, &metrics).err().unwrap_or_default()
    };
    for (change, reason) in [
        ((|webhook| webhook.url = "http://mes.example/".to_owned()) as fn(&mut Webhook), "webhooks.mes: url"),
        (|webhook| webhook.tenants.clear(), "tenants is empty"),
        (|webhook| webhook.tenants.push("A B".to_owned()), "'A B'"),
        (|webhook| webhook.states.push("RUNNING".to_owned()), "states: 'RUNNING'"),
        (|webhook| webhook.secret_file.push("none"), "secret_file"),
        (|webhook| webhook.ca_file = Some(webhook.secret_file.clone()), "no certificate"),
    ] {
        let error = refused(change);
        assert!(error.contains(reason), "{reason}: {error}");
    }
    let table = Table::new().with("mes", "http://localhost/", &["*"], &[]);
    std::fs::write(table.secret(), "short").unwrap();
    let error = Webhooks::start(&table.targets, false, &Arc::new(Metrics::new())).err().unwrap_or_default();
    assert!(error.contains("5 bytes"), "{error}");
}
