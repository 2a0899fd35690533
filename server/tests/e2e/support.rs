//! A server in process with a scripted runner, and a client for it.
//!
//! A program is a script: `EVENTS n`, `HANG` (until cancelled), `PANIC`, `REFUSE`, `SLOW` (prepared until it is
//! stopped), `ALARM`, `ASK name` (a dialog; the pressed button becomes a diagnostic), `FORM name` (the same with
//! fields), `STEP` (pauses until a command lets it continue), `SYSTEM` (a diagnostic tells whether commands are
//! allowed), `WRITE path` (a file with that path as its text), one per line.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, LazyLock, Mutex};
use std::time::{Duration, Instant};

use counterpoint_kernel::control::{JobControl, StopSignal};
use counterpoint_kernel::dialog::answers::DialogValue;
use counterpoint_kernel::dialog::operator::{OpenDialog, Silence};
use counterpoint_kernel::dialog::{Dialog, DialogField, FieldKind};
use counterpoint_kernel::event::Text;
use counterpoint_kernel::files::JobFiles;
use counterpoint_kernel::job::{LogSink, RunEnd};
use counterpoint_kernel::log::event::*;
use counterpoint_kernel::log::info::{Info, JobAxis, JobChannel, JobFile, MachineUnit, ResultBudget};
use counterpoint_kernel::machine::finding::Finding;
use counterpoint_kernel::operator::{Console, Heard, StepCommand, StepReply, StepReport};
use counterpoint_kernel::options::JobLimits;
use counterpoint_proto::v1;
use counterpoint_proto::v1::blobs_client::BlobsClient;
use counterpoint_proto::v1::jobs_client::JobsClient;
use counterpoint_proto::v1::machines_client::MachinesClient;
use counterpoint_proto::v1::operator_client::OperatorClient;
use counterpoint_proto::v1::results_client::ResultsClient;
use counterpoint_server::local::disk::Disk;
use counterpoint_server::options::{Retention, ServerOptions};
use counterpoint_server::runner::{PreparedJob, ResolvedJob, Runner};
use counterpoint_server::service::{self, Handle};
use sha2::{Digest, Sha256};
use tonic::Status;
use tonic::transport::Channel as Connection;
use tonic_types::StatusExt;

/// Runs scripts; `hang` off makes `HANG` a no-op.
#[derive(Clone)]
pub struct Script {
    pub hang: Arc<AtomicBool>,
    /// Dialogs that are over.
    pub asked: Arc<AtomicU64>,
    /// Limits of the job prepared last.
    pub limits: Arc<Mutex<Option<JobLimits>>>,
    /// Jobs prepared.
    pub prepared: Arc<AtomicU64>,
}

impl Default for Script {
    fn default() -> Self {
        let hang = Arc::new(AtomicBool::new(true));
        Self { hang, asked: Arc::default(), limits: Arc::default(), prepared: Arc::default() }
    }
}

struct Ready {
    info: Arc<Info>,
    script: String,
    own: Script,
}

impl Runner for Script {
    fn prepare(
        &self,
        task: ResolvedJob,
        files: &dyn JobFiles,
        stop: &StopSignal,
    ) -> Result<Box<dyn PreparedJob>, Vec<Finding>> {
        self.prepared.fetch_add(1, Ordering::SeqCst);
        *self.limits.lock().unwrap() = Some(task.options.limits.clone());
        let program = &task.programs[0];
        let read = files.read(&program.file);
        let bytes = read.map_err(|error| vec![Finding::error(&program.file, 0, 0, error.to_string())])?;
        let script = String::from_utf8_lossy(&bytes).into_owned();
        if script.contains("REFUSE") {
            return Err(vec![Finding::error(&program.file, 1, 1, "refused")]);
        }
        if script.contains("SLOW") {
            while !stop.asked() {
                std::thread::sleep(Duration::from_millis(1));
            }
            return Err(vec![Finding::error(&program.file, 0, 0, "stopped")]);
        }
        let axis = |name: &str| JobAxis { name: name.into(), rotary: false, diameter: false };
        let channel = |number| JobChannel {
            number,
            name: format!("C{number}"),
            program: program.file.clone(),
            lines: (1, 100),
            file: 0,
            lower: false,
            inch: false,
            unit_words: String::new(),
            axes: vec![axis("X"), axis("Z")],
        };
        let file = JobFile {
            name: program.file.clone(),
            stored: false,
            resident: false,
            text: Default::default(),
            sections: Vec::new(),
        };
        let text = Text::new(bytes, || false);
        file.text.set(Some(Arc::new(text))).unwrap();
        let info = Arc::new(Info {
            machine: task.machine.name.clone(),
            machine_number: 1,
            machine_revision: 1,
            machine_created: String::new(),
            machine_file: "lathe2/machine.toml".into(),
            parameters: String::new(),
            trace: Default::default(),
            room: ResultBudget { path: 1 << 20, bars: 1 << 20, waiting: 1 << 20 },
            unit: MachineUnit::Mm,
            channels: vec![channel(1), channel(2)],
            files: vec![file],
        });
        Ok(Box::new(Ready { info, script, own: self.clone() }))
    }
}

/// A position of two axes; the others do not exist and are zero.
fn position(value: f64) -> Position {
    let mut position = [0.0; MAX_AXES];
    position[..2].fill(value);
    position
}

pub fn event(seq: u64) -> Event {
    let line = (seq % 100) as u32 + 1;
    let kind = match seq % 50 {
        0 => Kind::Diagnostic(Box::new(Diagnostic {
            number: 7,
            severity: 2,
            text: "note".into(),
            ..Diagnostic::default()
        })),
        n if n % 2 == 0 => Kind::Block(BlockEvent { number: seq, unit_named: false }),
        _ => Kind::Motion(Motion {
            kind: MotionKind::Linear,
            moving: 3,
            from: position(seq as f64),
            to: position(seq as f64 + 1.0),
            center: [0.0; 2],
            plane_axes: [255; 2],
            turns: 0,
            feed: 100.0,
            feed_unit: FeedUnit::PerMinute,
            length: 1.0,
        }),
    };
    Event {
        t_ns: seq as i64 * 1000,
        micro: 0,
        dur_ns: 1000,
        channel: 1,
        file: 0,
        line,
        caller: SourcePlace::NONE,
        kind,
    }
}

impl Ready {
    fn alarm(&self, seq: u64) -> Event {
        let kind = Kind::Diagnostic(Box::new(Diagnostic {
            number: 9,
            severity: 9,
            text: "alarm".into(),
            ..Diagnostic::default()
        }));
        Event { kind, ..event(seq) }
    }
}

/// Nanoseconds of a clock that all of this process shares; `PACED` events carry them as their time.
pub fn clock() -> i64 {
    static BEGIN: LazyLock<Instant> = LazyLock::new(Instant::now);
    BEGIN.elapsed().as_nanos() as i64
}

/// Gives events to the log and to the results.
fn send(sink: &mut dyn LogSink, seq: u64, batch: &[Event]) -> bool {
    if let Some(builder) = sink.results() {
        batch.iter().for_each(|event| builder.event(event));
    }
    sink.events(seq, batch)
}

/// Takes so much processor time.
fn burn(time: Duration) {
    let now = || {
        let now = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
        Duration::new(now.tv_sec.unsigned_abs(), now.tv_nsec as u32)
    };
    let begin = now();
    while now() - begin < time {
        std::hint::spin_loop();
    }
}

/// Fields of a dialog, and the values that it lists.
fn form() -> (Vec<DialogField>, Vec<(String, DialogValue)>) {
    let text = |longest| FieldKind::Text { longest };
    let number = FieldKind::Number { min: 0.0, max: 9.0, whole: true };
    let mut fields = vec![("NAME", text(5)), ("COUNT", number), ("CLAMP", FieldKind::Check)];
    fields.extend(["NOTE", "NOTE2", "NOTE3", "NOTE4"].map(|name| (name, text(100_000))));
    let field = |(name, kind): (&str, FieldKind)| {
        let label = name.to_owned();
        DialogField { variable: label.clone(), label, kind, default: None, required: false, enabled: None }
    };
    (fields.into_iter().map(field).collect(), vec![("DEPTH".to_owned(), DialogValue::Number(1.0))])
}

/// Stands at a place until a command lets it continue; `Show` shows the place.
fn stand(console: &dyn Console, control: &JobControl, place: &str) {
    let report = StepReport { reason: place.into(), ..StepReport::default() };
    console.say(StepReply::Stopped(report.clone()));
    while !control.cancelled() {
        match console.wait(Duration::from_millis(20)) {
            Heard::Command(command) if command.runs() || command == StepCommand::Detach => break,
            Heard::Command(_) => console.say(StepReply::State(report.clone())),
            Heard::Nothing => {}
            Heard::Gone => break,
        }
    }
}

impl PreparedJob for Ready {
    fn info(&self) -> &Arc<Info> {
        &self.info
    }

    fn run(&self, _files: &dyn JobFiles, control: &JobControl, sink: &mut dyn LogSink) -> RunEnd {
        let mut seq = 1;
        let writes = self.script.lines().filter_map(|line| line.strip_prefix("WRITE "));
        sink.files(writes.map(|path| (path.to_owned(), path.into())).collect());
        for line in self.script.lines() {
            match line.split_once(' ').unwrap_or((line, "")) {
                ("EVENTS", count) => {
                    let end = seq + count.parse::<u64>().unwrap();
                    while seq < end && !control.cancelled() {
                        let batch: Vec<_> = (seq..end.min(seq + 100)).map(event).collect();
                        if !send(sink, seq, &batch) {
                            return RunEnd { events: seq - 1, cancelled: false, sink_failed: true };
                        }
                        seq += batch.len() as u64;
                    }
                }
                ("HANG", _) => {
                    while self.own.hang.load(Ordering::SeqCst) && !control.cancelled() {
                        std::thread::sleep(Duration::from_millis(2));
                    }
                }
                ("PACED", count) => {
                    for _ in 0..count.parse::<u64>().unwrap() {
                        if control.cancelled() {
                            break;
                        }
                        std::thread::sleep(Duration::from_millis(5));
                        assert!(send(sink, seq, &[Event { t_ns: clock(), ..event(seq) }]));
                        seq += 1;
                    }
                }
                ("BURN", ms) => burn(Duration::from_millis(ms.parse().unwrap())),
                ("PANIC", _) => panic!("scripted"),
                ("ASK" | "FORM", name) => {
                    control.note_outside();
                    let (fields, values) = if line.starts_with("FORM") { form() } else { Default::default() };
                    let dialog = Dialog { name: name.into(), title: name.into(), fields, buttons: vec![] };
                    let (file, values) = ("main.nc", &values[..]);
                    let question = OpenDialog { channel: 1, file, line: 1, dialog: &dialog, values, problem: None };
                    let answer = control.operator().map(|operator| operator.ask(&question));
                    self.own.asked.fetch_add(1, Ordering::SeqCst);
                    let text = match answer {
                        Some(Ok(answer)) => answer.button.unwrap_or_default(),
                        Some(Err(Silence::Late)) => "late".to_owned(),
                        Some(Err(_)) | None => "-".to_owned(),
                    };
                    let text = format!("{name}: {text}");
                    let kind = Kind::Diagnostic(Box::new(Diagnostic {
                        number: 8,
                        severity: 0,
                        text: text.into(),
                        ..Diagnostic::default()
                    }));
                    assert!(send(sink, seq, &[Event { kind, ..event(seq) }]));
                    seq += 1;
                }
                ("STEP", place) => {
                    if let Some(console) = control.console() {
                        stand(console, control, place);
                    }
                }
                ("SYSTEM", _) => {
                    control.note_outside();
                    let text = if control.system().is_some() { "allowed" } else { "refused" };
                    let diagnostic = Diagnostic { number: 8, text: text.into(), ..Diagnostic::default() };
                    assert!(send(sink, seq, &[Event { kind: Kind::Diagnostic(Box::new(diagnostic)), ..event(seq) }]));
                    seq += 1;
                }
                ("ALARM", _) => {
                    assert!(send(sink, seq, &[self.alarm(seq)]));
                    seq += 1;
                }
                _ => {}
            }
        }
        RunEnd { events: seq - 1, cancelled: control.cancelled(), sink_failed: false }
    }
}

/// A running server.
pub struct Server {
    pub handle: Handle,
    pub task: tokio::task::JoinHandle<()>,
    pub script: Script,
    pub connection: Connection,
}

pub fn options(data: &Path) -> ServerOptions {
    ServerOptions {
        // Tests submit equal jobs and expect each of them to run.
        retention: Retention { result_cache: false, ..Retention::default() },
        listen: "127.0.0.1:0".parse().unwrap(),
        data: data.to_owned(),
        grace_s: 0,
        workers: 2,
        ..ServerOptions::default()
    }
}

impl Server {
    pub async fn start(options: ServerOptions) -> Self {
        Self::start_on(options, Disk::default()).await
    }

    pub async fn start_on(options: ServerOptions, disk: Disk) -> Self {
        Self::try_start(options, disk).await.unwrap()
    }

    /// A server, if it starts.
    pub async fn try_start(options: ServerOptions, disk: Disk) -> Result<Self, service::Error> {
        let script = Script::default();
        let service = service::build_on(options, script.clone(), disk).await?;
        let handle = service.handle();
        let task = tokio::spawn(async { service.run(std::future::pending()).await.unwrap() });
        let address = format!("http://{}", handle.address());
        let connection = Connection::from_shared(address).unwrap().connect().await.unwrap();
        Ok(Self { handle, task, script, connection })
    }

    pub async fn stop(self) {
        self.handle.stop();
        tokio::time::timeout(Duration::from_secs(10), self.task).await.expect("stops in time").unwrap();
    }

    pub fn jobs(&self) -> JobsClient<Connection> {
        JobsClient::new(self.connection.clone())
    }

    pub fn blobs(&self) -> BlobsClient<Connection> {
        BlobsClient::new(self.connection.clone())
    }

    pub fn machines(&self) -> MachinesClient<Connection> {
        MachinesClient::new(self.connection.clone())
    }

    pub fn operator(&self) -> OperatorClient<Connection> {
        OperatorClient::new(self.connection.clone())
    }

    pub fn results(&self) -> ResultsClient<Connection> {
        ResultsClient::new(self.connection.clone())
    }

    pub async fn upload(&self, content: &[u8]) -> String {
        let (name, size) = self.try_upload(content).await.unwrap();
        assert_eq!((name.as_str(), size), (digest(content).as_str(), content.len() as u64));
        name
    }

    /// The digest and the size that the server returns.
    pub async fn try_upload(&self, content: &[u8]) -> Result<(String, u64), tonic::Status> {
        let mut chunks: Vec<_> =
            content.chunks(1000).map(|c| v1::UploadRequest { data: c.to_vec().into(), ..Default::default() }).collect();
        chunks.insert(0, v1::UploadRequest { digest: digest(content), ..Default::default() });
        let response = self.blobs().upload(tokio_stream::iter(chunks)).await?.into_inner();
        Ok((response.digest, response.size))
    }

    /// A submit of one script.
    pub async fn request(&self, request_id: &str, script: &str) -> v1::SubmitJobRequest {
        let digest = self.upload(script.as_bytes()).await;
        v1::SubmitJobRequest {
            request_id: request_id.into(),
            machine: "fanuc-2path-lathe".into(),
            programs: vec![v1::Program { path: "main.nc".into(), ..Default::default() }],
            files: vec![v1::FileRef { path: "main.nc".into(), digest }],
            ..Default::default()
        }
    }

    pub async fn submit(&self, request_id: &str, script: &str) -> String {
        let request = self.request(request_id, script).await;
        self.jobs().submit_job(request).await.unwrap().into_inner().status.unwrap().job_id
    }

    pub async fn wait(&self, job: &str) -> v1::JobStatus {
        let request = v1::WaitJobRequest { job_id: job.into(), timeout_ms: 20_000 };
        self.jobs().wait_job(request).await.unwrap().into_inner().status.unwrap()
    }

    pub async fn status(&self, job: &str) -> v1::JobStatus {
        let request = v1::GetJobRequest { job_id: job.into() };
        self.jobs().get_job(request).await.unwrap().into_inner().status.unwrap()
    }

    pub async fn until(&self, job: &str, state: v1::JobState) {
        for _ in 0..1000 {
            if self.status(job).await.state() == state {
                return;
            }
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
        panic!("{job} never became {state:?}");
    }

    /// All events of a job after this one, up to its end.
    pub async fn events(&self, job: &str, after: u64) -> Vec<v1::Event> {
        let mut stream = self.watch(job, after, v1::WatchLevel::Everything).await;
        let mut events = Vec::new();
        while let Some(message) = stream.message().await.unwrap() {
            if let Some(v1::watch_job_response::Content::Batch(batch)) = message.content {
                events.extend(batch.events);
            }
        }
        events
    }

    /// Waits until a running job has logged this many events.
    pub async fn until_events(&self, job: &str, events: usize) {
        let mut watch = self.watch(job, 0, v1::WatchLevel::Everything).await;
        let mut seen = 0;
        while seen < events {
            let message = watch.message().await.unwrap().expect("the job logs as many events");
            if let Some(v1::watch_job_response::Content::Batch(batch)) = message.content {
                seen += batch.events.len();
            }
        }
    }

    pub async fn watch(
        &self,
        job: &str,
        after_seq: u64,
        level: v1::WatchLevel,
    ) -> tonic::Streaming<v1::WatchJobResponse> {
        let request = v1::WatchJobRequest { job_id: job.into(), after_seq, level: level.into(), heartbeat_ms: 0 };
        self.jobs().watch_job(request).await.unwrap().into_inner()
    }
}

/// The file of the log of a job that has ended.
pub fn log_file(data: &Path, job: &str) -> PathBuf {
    let folder = data.join("jobs").join(job);
    let compressed = folder.join("log.segments");
    if compressed.is_file() { compressed } else { folder.join("log") }
}

pub fn digest(content: &[u8]) -> String {
    Sha256::digest(content).iter().map(|b| format!("{b:02x}")).collect()
}

pub fn reason(status: &Status) -> String {
    let details = status.get_error_details();
    let info = details.error_info().expect("every status has an ErrorInfo");
    assert_eq!(info.domain, "counterpoint");
    info.reason.clone()
}
