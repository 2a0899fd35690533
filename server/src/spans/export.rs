//! The exporter: a thread that sends the spans of ended jobs in batches.
//!
//! Each job has the span `job`, from its acceptance to its end, and in it `run`, its last run. Their ids come from that
//! of the job, so a job that ends twice because the end of the first run was lost has the same spans.

use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use opentelemetry::trace::{SpanContext, SpanId, SpanKind, Status, TraceFlags, TraceId, TraceState};
use opentelemetry::{InstrumentationScope, KeyValue};
use opentelemetry_otlp::{SpanExporter as Otlp, WithExportConfig as _};
use opentelemetry_sdk::Resource;
use opentelemetry_sdk::trace::{SpanData, SpanExporter as _};
use tokio::sync::mpsc;
use tokio::time::sleep;

use crate::ledger::record::{JobRecord, JobState};
use crate::pace::LogRateLimit;
use crate::trace::TraceContext;

/// Spans that may wait for the collector.
const WAITING: usize = 8192;
/// Most spans of a batch, and the time in which they gather.
const BATCH: usize = 512;
const GATHERING: Duration = Duration::from_millis(500);
/// Longest time of an export.
const PATIENCE: Duration = Duration::from_secs(10);
/// Time that the last batch gets when the server stops.
const CLOSING: Duration = Duration::from_secs(1);

static NOT_SENT: LogRateLimit = LogRateLimit::new();

/// Sends spans until it is closed.
#[derive(Debug)]
pub(super) struct Exporter {
    spans: Mutex<Option<mpsc::Sender<SpanData>>>,
    /// Disconnected when everything has been sent.
    done: Mutex<Receiver<()>>,
}

impl Exporter {
    /// Starts the thread.
    pub(super) fn start(endpoint: &str) -> Result<Self, String> {
        let wrong = |error: &dyn std::fmt::Display| format!("'{endpoint}' as otlp: {error}");
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(|e| wrong(&e))?;
        let guard = runtime.enter();
        let mut otlp = Otlp::builder()
            .with_tonic()
            .with_endpoint(endpoint)
            .with_timeout(PATIENCE)
            .build()
            .map_err(|e| wrong(&e))?;
        drop(guard);
        let version = KeyValue::new("service.version", env!("CARGO_PKG_VERSION"));
        let resource = Resource::builder().with_service_name("counterpointd").with_attribute(version).build();
        otlp.set_resource(&resource);
        let (spans, receiver) = mpsc::channel(WAITING);
        let (alive, done) = channel();
        let work = move || {
            runtime.block_on(send(&otlp, receiver));
            drop(alive);
        };
        std::thread::Builder::new().name("spans".to_owned()).spawn(work).map_err(|e| wrong(&e))?;
        Ok(Self { spans: Mutex::new(Some(spans)), done: Mutex::new(done) })
    }

    /// Takes the spans of a job that has ended.
    pub(super) fn ended(&self, record: &JobRecord) {
        let spans = self.spans.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let Some(sender) = spans else { return };
        for span in spans_of(record) {
            if sender.try_send(span).is_err() {
                not_sent("too many spans wait for the collector", 1);
            }
        }
    }

    /// Takes no more spans, and waits for a moment until the others are sent.
    pub(super) fn close(&self) {
        drop(self.spans.lock().unwrap_or_else(PoisonError::into_inner).take());
        let done = self.done.lock().unwrap_or_else(PoisonError::into_inner);
        if done.recv_timeout(CLOSING) == Err(RecvTimeoutError::Timeout) {
            not_sent("the server stops before the collector has taken its spans", 0);
        }
    }
}

fn not_sent(reason: &str, spans: usize) {
    if let Some(left_out) = NOT_SENT.pass() {
        tracing::warn!(spans, left_out, "spans are not sent: {reason}");
    }
}

async fn send(otlp: &Otlp, mut spans: mpsc::Receiver<SpanData>) {
    let mut batch = Vec::with_capacity(BATCH);
    while spans.recv_many(&mut batch, BATCH).await > 0 {
        if batch.len() < BATCH && !spans.is_closed() {
            sleep(GATHERING).await;
            while batch.len() < BATCH
                && let Ok(span) = spans.try_recv()
            {
                batch.push(span);
            }
        }
        let count = batch.len();
        if let Err(error) = otlp.export(std::mem::take(&mut batch)).await {
            not_sent(&error.to_string(), count);
        }
    }
}

/// A time in milliseconds since 1970.
fn at(ms: i64) -> SystemTime {
    UNIX_EPOCH + Duration::from_millis(u64::try_from(ms).unwrap_or(0))
}

/// The spans of a job; none if its client has said that its trace is not recorded.
fn spans_of(record: &JobRecord) -> Vec<SpanData> {
    let own = TraceContext::of(&record.id, &record.runs.traceparent);
    let hex = (TraceId::from_hex(&own.trace), SpanId::from_hex(&own.span), SpanId::from_hex(&own.run));
    let (Ok(trace), Ok(job), Ok(run)) = hex else { return Vec::new() };
    if !own.sampled {
        return Vec::new();
    }
    let parent = SpanId::from_hex(&own.parent).unwrap_or(SpanId::INVALID);
    let span = |id, parent, remote, name: &'static str, begin: i64, kind, attributes, status| SpanData {
        span_context: SpanContext::new(trace, id, TraceFlags::SAMPLED, false, TraceState::NONE),
        parent_span_id: parent,
        parent_span_is_remote: remote,
        span_kind: kind,
        name: name.into(),
        start_time: at(begin),
        end_time: at(record.ended_ms.max(begin)),
        attributes,
        dropped_attributes_count: 0,
        events: Default::default(),
        links: Default::default(),
        status,
        instrumentation_scope: InstrumentationScope::builder("counterpoint").build(),
    };
    let status = match record.state {
        JobState::Failed if record.error.is_empty() => Status::error(record.verdict.clone()),
        JobState::Failed => Status::error(record.error.clone()),
        JobState::Succeeded => Status::Ok,
        JobState::Queued | JobState::Running | JobState::Cancelled => Status::Unset,
    };
    let number = |value: u64| i64::try_from(value).unwrap_or(i64::MAX);
    let mut attributes = vec![
        KeyValue::new("counterpoint.job", record.id.clone()),
        KeyValue::new("counterpoint.request_id", record.request_id.clone()),
        KeyValue::new("counterpoint.tenant", record.tenant.clone()),
        KeyValue::new("counterpoint.machine", record.machine_name.clone()),
        KeyValue::new("counterpoint.state", format!("{:?}", record.state).to_uppercase()),
        KeyValue::new("counterpoint.attempts", i64::from(record.runs.attempt)),
        KeyValue::new("counterpoint.host_failures", i64::from(record.runs.host_failures)),
        KeyValue::new("counterpoint.events", number(record.events)),
        KeyValue::new("counterpoint.cpu_us", number(record.runs.cpu_us)),
    ];
    if let Some(limit) = record.runs.reached {
        attributes.push(KeyValue::new("counterpoint.limit", limit.name()));
    }
    let remote = parent != SpanId::INVALID;
    let mut spans = vec![span(job, parent, remote, "job", record.submitted_ms, SpanKind::Consumer, attributes, status)];
    if record.runs.started_ms > 0 {
        spans.push(span(run, job, false, "run", record.runs.started_ms, SpanKind::Internal, Vec::new(), Status::Unset));
    }
    spans
}
