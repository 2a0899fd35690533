//! The server as a component: [`build`] it, [`Service::run`] it until it is asked to stop.
//!
//! Invariant: [`Service::run`] returns within the grace time plus two seconds of the stop signal, regardless of the
//! behaviour of clients (a client that never answers would hold a graceful shutdown forever).

use std::collections::BTreeMap;
use std::future::Future;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use counterpoint_proto::DESCRIPTORS;
use counterpoint_proto::v1::admin_server::AdminServer;
use counterpoint_proto::v1::blobs_server::BlobsServer;
use counterpoint_proto::v1::jobs_server::JobsServer;
use counterpoint_proto::v1::machines_server::MachinesServer;
use counterpoint_proto::v1::operator_server::OperatorServer;
use counterpoint_proto::v1::results_server::ResultsServer;
use tokio::net::TcpListener;
use tonic::codec::CompressionEncoding;
use tonic::service::Routes;
use tonic_health::server::HealthReporter;

use crate::jobs::{Core, Telemetry};
use crate::local;
use crate::local::disk::Disk;
use crate::metrics::Metrics;
use crate::net::{self, Gate};
use crate::options::{ServerOptions, Tenant};
use crate::reason::Refusal;
use crate::rpc;
use crate::runner::{KernelRunner, Runner};
use crate::spans::JobSpans;
use crate::webhooks::Webhooks;

/// Largest message in either direction, bytes; of a compressed one, as it is without compression.
pub const MAX_MESSAGE: usize = net::MAX_MESSAGE;
/// Time without a look at the jobs after which the server counts as stuck.
const ALIVE: Duration = Duration::from_secs(30);
/// Time that streams and connections get to end after the jobs have.
const CLOSING: Duration = Duration::from_secs(2);

/// Why a server cannot be built or run.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The address cannot be listened on.
    #[error("cannot listen on {address} (option {option}): {error}")]
    Listen {
        /// Option that sets the address.
        option: &'static str,
        /// The address.
        address: SocketAddr,
        /// The error of the system.
        error: std::io::Error,
    },
    /// The data folder cannot be used.
    #[error("cannot use the data folder '{folder}': {reason}")]
    Data {
        /// The folder.
        folder: String,
        /// Why.
        reason: String,
    },
    /// The address for monitoring is not one.
    #[error("'{0}' is not an address for metrics: expected ADDRESS:PORT, for example 127.0.0.1:9464")]
    Metrics(String),
    /// Spans cannot be sent to the collector.
    #[error("{0}")]
    Spans(String),
    /// A target of webhooks cannot be used.
    #[error("{0}")]
    Webhooks(String),
    /// Calls cannot be guarded as asked.
    #[error("{0}")]
    Guard(String),
    /// The descriptor set is unreadable.
    #[error("reflection: {0}")]
    Reflection(#[from] tonic_reflection::server::Error),
}

impl Error {
    /// Whether the configuration must be corrected: the same start fails again.
    #[must_use]
    pub fn is_of_configuration(&self) -> bool {
        matches!(self, Self::Metrics(_) | Self::Spans(_) | Self::Webhooks(_) | Self::Guard(_))
    }
}

/// A server that is bound and recovered, not yet serving.
#[derive(Debug)]
pub struct Service {
    core: Arc<Core>,
    gate: Arc<Gate>,
    /// Where monitoring asks.
    monitor: Option<TcpListener>,
    listener: TcpListener,
    address: SocketAddr,
    stop: tokio::sync::watch::Sender<ShutdownRequest>,
}

/// Request to a server.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum ShutdownRequest {
    No,
    Drain,
    Now,
}

/// A cheap handle on a server.
#[derive(Debug, Clone)]
pub struct Handle {
    address: SocketAddr,
    metrics: Option<SocketAddr>,
    gate: Arc<Gate>,
    core: std::sync::Weak<Core>,
    stop: tokio::sync::watch::Sender<ShutdownRequest>,
}

impl Handle {
    /// The bound address.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// The bound address for monitoring, if there is one.
    #[must_use]
    pub fn metrics(&self) -> Option<SocketAddr> {
        self.metrics
    }

    /// Jobs that wait or run.
    #[must_use]
    pub fn unfinished_jobs(&self) -> usize {
        self.core.upgrade().map_or(0, |core| core.unfinished_jobs())
    }

    /// The address as clients are to be given it.
    #[must_use]
    pub fn url(&self) -> String {
        format!("{}://{}", if self.gate.encrypts() { "https" } else { "http" }, self.address)
    }

    /// Reads identities and certificates again, and reopens the audit log. Files that cannot be read keep their
    /// previous content.
    pub fn reload(&self) {
        self.gate.reload();
    }

    /// Keeps a content that the caller, in this process, has in memory and has named by its SHA-256 (64 lower-case
    /// hexadecimal digits): the same as an upload by the default tenant, without a copy.
    ///
    /// # Errors
    /// As an upload is refused.
    pub fn put_blob(&self, digest: &str, content: Bytes) -> Result<(), tonic::Status> {
        let Some(core) = self.core.upgrade() else {
            return Err(tonic::Status::unavailable("the server has stopped"));
        };
        core.room()?;
        Ok(core.blobs.put(digest, content)?)
    }

    /// Replaces the tables of single tenants: their quotas and retention.
    pub fn set_tenants(&self, tenants: BTreeMap<String, Tenant>) {
        if let Some(core) = self.core.upgrade() {
            core.set_tenants(tenants);
        }
    }

    /// Whether the server still looks after its jobs; for a watchdog.
    #[must_use]
    pub fn alive(&self) -> bool {
        self.core.upgrade().is_none_or(|core| core.ticks_within(ALIVE))
    }

    /// Resolves when the server was asked to stop, by any source.
    pub async fn stopping(&self) {
        reaches(&self.stop, ShutdownRequest::Drain).await;
    }

    /// Asks the server to drain; a second call asks it to stop at once.
    pub fn stop(&self) {
        self.stop.send_modify(|stop| {
            *stop = if *stop == ShutdownRequest::No { ShutdownRequest::Drain } else { ShutdownRequest::Now }
        });
    }
}

/// Builds a server that runs jobs on the control emulator.
///
/// # Errors
/// When the address or the data folder cannot be used.
pub async fn build(options: ServerOptions) -> Result<Service, Error> {
    build_with(options, KernelRunner::default()).await
}

/// Builds a server that runs jobs with `runner`.
///
/// # Errors
/// When the address or the data folder cannot be used.
pub async fn build_with(options: ServerOptions, runner: impl Runner) -> Result<Service, Error> {
    build_on(options, runner, Disk::default()).await
}

/// Builds a server that runs jobs with `runner` and writes through `disk`.
///
/// # Errors
/// When the address or the data folder cannot be used.
pub async fn build_on(options: ServerOptions, runner: impl Runner, disk: Disk) -> Result<Service, Error> {
    let metrics = Arc::new(Metrics::new());
    let gate = Arc::new(Gate::open(&options, metrics.clone()).map_err(Error::Guard)?);
    let spans = JobSpans::to(&options.connections.otlp).map_err(Error::Spans)?;
    let webhooks =
        Webhooks::start(&options.tables.webhooks, options.guard.insecure, &metrics).map_err(Error::Webhooks)?;
    let address = options.listen;
    let listen = |error| Error::Listen { option: "listen", address, error };
    let listener = TcpListener::bind(address).await.map_err(listen)?;
    let address = listener.local_addr().map_err(listen)?;
    let monitor = match options.connections.metrics.as_str() {
        "" => None,
        text => {
            let address = text.parse().map_err(|_| Error::Metrics(text.to_owned()))?;
            let listen = |error| Error::Listen { option: "metrics", address, error };
            Some(TcpListener::bind(address).await.map_err(listen)?)
        }
    };
    let folder = options.data.display().to_string();
    let data = move |reason: String| Error::Data { folder: folder.clone(), reason };
    let opened = tokio::task::spawn_blocking(move || {
        let seams = local::open(&options, disk, &metrics)?;
        let core = Core::new(options, Box::new(runner), seams, Telemetry { metrics, spans, webhooks })?;
        core.recover()?;
        Ok::<_, Refusal>(core)
    });
    let core = opened.await.map_err(|e| data(e.to_string()))?.map_err(|e| data(e.to_string()))?;
    gate.mind(&core);
    Ok(Service { core, gate, monitor, listener, address, stop: tokio::sync::watch::Sender::new(ShutdownRequest::No) })
}

/// A service with bounds on its messages, and gzip for clients that use it.
macro_rules! served {
    ($service:expr) => {
        $service
            .max_decoding_message_size(MAX_MESSAGE)
            .accept_compressed(CompressionEncoding::Gzip)
            .send_compressed(CompressionEncoding::Gzip)
    };
}

impl Service {
    /// A handle on it.
    #[must_use]
    pub fn handle(&self) -> Handle {
        let metrics = self.monitor.as_ref().and_then(|listener| listener.local_addr().ok());
        Handle {
            address: self.address,
            metrics,
            gate: self.gate.clone(),
            core: Arc::downgrade(&self.core),
            stop: self.stop.clone(),
        }
    }

    /// Serves until `shutdown` resolves or [`Handle::stop`] is called, then drains: health NOT_SERVING, no new jobs,
    /// running jobs end within the grace time or are queued again, streams end with UNAVAILABLE.
    ///
    /// # Errors
    /// When the descriptor set is unreadable.
    pub async fn run(self, shutdown: impl Future<Output = ()>) -> Result<(), Error> {
        let Self { core, gate, monitor, listener, stop, .. } = self;
        let (health, health_service) = tonic_health::server::health_reporter();
        let reporter = tokio::spawn(report(health.clone(), core.clone()));
        // Ends with the server.
        let mut monitoring = tokio::task::JoinSet::new();
        if let Some(listener) = monitor {
            monitoring.spawn(net::monitor(listener, core.clone()));
        }
        monitoring.spawn(gate.clone().note_left_out());
        let counts = gate.clone();
        let mut routes = Routes::builder();
        let asked = stop.clone();
        let admin = rpc::AdminService { core: core.clone(), stop: Box::new(move || begin(&asked)) };
        routes
            .add_service(health_service.max_decoding_message_size(net::MAX_OF_HEALTH))
            .add_service(served!(JobsServer::new(rpc::JobsService(core.clone()))))
            .add_service(served!(BlobsServer::new(rpc::BlobsService(core.clone()))))
            .add_service(served!(MachinesServer::new(rpc::MachinesService(core.clone()))))
            .add_service(served!(ResultsServer::new(rpc::ResultsService(core.clone()))))
            .add_service(served!(OperatorServer::new(rpc::OperatorService(core.clone()))))
            .add_service(served!(AdminServer::new(admin)));
        if core.options.guard.reflection {
            let builder = || {
                tonic_reflection::server::Builder::configure()
                    .register_encoded_file_descriptor_set(DESCRIPTORS)
                    .register_encoded_file_descriptor_set(tonic_health::pb::FILE_DESCRIPTOR_SET)
                    // Details of refusals.
                    .register_encoded_file_descriptor_set(tonic_types::pb::FILE_DESCRIPTOR_SET)
            };
            routes.add_service(builder().build_v1()?).add_service(builder().build_v1alpha()?);
        }
        let close = tokio::sync::watch::Sender::new(false);
        let closed = core.clone();
        let server = net::serve(listener, routes.routes().prepare(), &core, gate, close.subscribe());
        let mut server = std::pin::pin!(server);
        let asked = stop.clone();
        tokio::select! {
            () = &mut server => return Ok(()),
            () = shutdown => begin(&asked),
            () = reaches(&stop, ShutdownRequest::Drain) => {}
        }
        tracing::info!("draining");
        let drained = async {
            reporter.abort();
            not_serving(&health).await;
            drain(&core, &stop).await;
            close.send_replace(true);
        };
        let closing = async {
            tokio::select! {
                () = &mut server => {}
                () = async { drained.await; tokio::time::sleep(CLOSING).await } => {}
            }
        };
        tokio::select! {
            () = closing => {}
            () = async { reaches(&stop, ShutdownRequest::Now).await; core.interrupt(); tokio::time::sleep(CLOSING / 4).await } => {}
        }
        // Connections that outlive the server may still hold the core; the data folder must be free all the same.
        let _ = tokio::task::spawn_blocking(move || {
            counts.note_all_left_out(true);
            closed.keep_time();
            closed.keep_cleared();
            closed.ledger.close();
            closed.host.release();
            closed.close_exports();
        })
        .await;
        tracing::info!("stopped");
        Ok(())
    }
}

/// Asks for the drain, unless more was requested.
fn begin(stop: &tokio::sync::watch::Sender<ShutdownRequest>) {
    stop.send_modify(|stop| *stop = (*stop).max(ShutdownRequest::Drain));
}

async fn reaches(stop: &tokio::sync::watch::Sender<ShutdownRequest>, level: ShutdownRequest) {
    let _ = stop.subscribe().wait_for(|stop| *stop >= level).await;
}

/// Lets running jobs end within the grace time, then interrupts them.
async fn drain(core: &Core, stop: &tokio::sync::watch::Sender<ShutdownRequest>) {
    core.drain.begin();
    let mut running = core.running();
    let grace = Duration::from_secs(core.options.grace_s);
    tokio::select! {
        _ = running.wait_for(|running| *running == 0) => return,
        () = tokio::time::sleep(grace) => {}
        () = reaches(stop, ShutdownRequest::Now) => {}
    }
    core.interrupt();
    let _ = tokio::time::timeout(CLOSING, running.wait_for(|running| *running == 0)).await;
}

/// Reports the server as serving while its ledger can be written.
async fn report(health: HealthReporter, core: Arc<Core>) {
    let mut writable = core.ledger.writable();
    loop {
        let now = *writable.borrow_and_update();
        match now {
            true => serving(&health).await,
            false => not_serving(&health).await,
        }
        if writable.changed().await.is_err() {
            return;
        }
    }
}

async fn serving(health: &HealthReporter) {
    health.set_service_status("", tonic_health::ServingStatus::Serving).await;
    health.set_serving::<JobsServer<rpc::JobsService>>().await;
    health.set_serving::<BlobsServer<rpc::BlobsService>>().await;
    health.set_serving::<MachinesServer<rpc::MachinesService>>().await;
    health.set_serving::<ResultsServer<rpc::ResultsService>>().await;
    health.set_serving::<OperatorServer<rpc::OperatorService>>().await;
    health.set_serving::<AdminServer<rpc::AdminService>>().await;
}

async fn not_serving(health: &HealthReporter) {
    health.set_service_status("", tonic_health::ServingStatus::NotServing).await;
    health.set_not_serving::<JobsServer<rpc::JobsService>>().await;
    health.set_not_serving::<BlobsServer<rpc::BlobsService>>().await;
    health.set_not_serving::<MachinesServer<rpc::MachinesService>>().await;
    health.set_not_serving::<ResultsServer<rpc::ResultsService>>().await;
    health.set_not_serving::<OperatorServer<rpc::OperatorService>>().await;
    health.set_not_serving::<AdminServer<rpc::AdminService>>().await;
}
