//! A connection to a remote server, or to one embedded in this process.
//!
//! *Invariant:* an embedded server leaves nothing behind: its data folder is temporary and removed with the client.

use std::time::Duration;

use counterpoint_client::{Blob, ClientSettings, ResultChunks, ResultDocument, Through, Watch, WatchJobs};
use counterpoint_proto::v1;
use counterpoint_proto::v1::admin_client::AdminClient;
use counterpoint_proto::v1::jobs_client::JobsClient;
use counterpoint_proto::v1::machines_client::MachinesClient;
use counterpoint_proto::v1::operator_client::OperatorClient;
use counterpoint_server::options::{Embedded, Guard, ServerOptions, System};
use counterpoint_server::service;

use crate::error::Error;
use crate::say;

/// Ten years, s.
const LONG: u64 = 315_360_000;

/// Results that a caller may request from an embedded server after a job, besides those it always has.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct RequestedResults {
    /// Data made from the event log.
    pub(crate) log: bool,
    pub(crate) toolpath: bool,
}

/// A client.
#[derive(Debug)]
pub(crate) struct ServerSession {
    server: counterpoint_client::Client,
    /// The server of this process.
    own: Option<service::Handle>,
    _data: Option<tempfile::TempDir>,
}

/// A job that the server has accepted.
#[derive(Debug)]
pub(crate) struct SubmittedJob {
    pub(crate) job: String,
    /// Whether an earlier call with the same request id created the job.
    pub(crate) duplicate: bool,
    /// The machine and its signs, if the server guessed it.
    pub(crate) guess: Option<(String, String)>,
}

impl SubmittedJob {
    pub(crate) fn of(status: v1::JobStatus, duplicate: bool) -> Self {
        let v1::JobStatus { job_id: job, machine, machine_guess, .. } = status;
        Self { job, duplicate, guess: Some((machine, machine_guess)).filter(|(_, signs)| !signs.is_empty()) }
    }
}

/// Reports that this client retries its calls.
fn say_again(error: &counterpoint_client::Error, patience: Duration) {
    let why = match error.reason().as_deref() {
        Some("DRAINING") => "the server is shutting down".to_owned(),
        _ => error.to_string(),
    };
    say::status_line(format!("{why}; trying again for up to {} s", patience.as_secs()));
}

impl ServerSession {
    /// Connects to a server, with token and certificates from the environment: on a command line every user of the
    /// machine could read them.
    pub(crate) async fn connect(address: &str) -> Result<Self, Error> {
        Self::connect_as(address, false).await
    }

    /// Connects to a server. Unless `quiet`, a status line reports retries.
    pub(crate) async fn connect_as(address: &str, quiet: bool) -> Result<Self, Error> {
        let mut settings = ClientSettings::from_environment(address)?;
        if !quiet {
            settings = settings.with_notice(say_again);
        }
        let server = counterpoint_client::Client::connect(&settings).await?;
        Ok(Self { server, own: None, _data: None })
    }

    /// Starts a server in this process and connects to it over loopback. `patient`: a job that is stepped through
    /// stands until its person comes back.
    pub(crate) async fn embed(asked: RequestedResults, allow_system: bool, patient: bool) -> Result<Self, Error> {
        let data = tempfile::Builder::new().prefix("counterpoint-").tempdir();
        let data = data.map_err(Error::file(std::env::temp_dir()))?;
        let own = ServerOptions::ephemeral(data.path().to_owned());
        let RequestedResults { log, toolpath } = asked;
        let embedded = Embedded { log, toolpath, ..own.embedded };
        let usual = System { allow_system, ..System::default() };
        let system = if patient { System { operator_wait_s: LONG, ..usual } } else { usual };
        // No client asks this server for the contract, and preparing it takes longer than a small program.
        let guard = Guard { reflection: false, ..own.guard };
        let options = ServerOptions { embedded, system, guard, ..own };
        let service = service::build(options).await.map_err(|error| Error::Connection(error.to_string()))?;
        let handle = service.handle();
        let address = format!("http://{}", handle.address());
        // Ends with the runtime, when the command ends.
        tokio::spawn(service.run(std::future::pending()));
        let client = Self::connect(&address).await?;
        Ok(Self { own: Some(handle), _data: Some(data), ..client })
    }

    /// A server at an address, or one in this process.
    pub(crate) async fn at(address: Option<&str>) -> Result<Self, Error> {
        match address {
            Some(address) => Self::connect(address).await,
            None => Self::embed(RequestedResults::default(), false, false).await,
        }
    }

    /// Whether the server is in this process and knows the machines built in.
    pub(crate) fn is_embedded(&self) -> bool {
        self.own.is_some()
    }

    pub(crate) fn jobs(&self) -> JobsClient<Through> {
        self.server.jobs()
    }

    pub(crate) fn machines(&self) -> MachinesClient<Through> {
        self.server.machines()
    }

    pub(crate) fn admin(&self) -> AdminClient<Through> {
        self.server.admin()
    }

    pub(crate) fn operator(&self) -> OperatorClient<Through> {
        self.server.operator()
    }

    /// Follows the states of many jobs.
    pub(crate) fn watch_jobs(&self, filter: v1::JobFilter) -> WatchJobs {
        self.server.watch_jobs(filter)
    }

    /// Follows a job.
    pub(crate) fn watch(&self, job: &str, level: v1::WatchLevel) -> Watch {
        self.server.watch(job, level)
    }

    /// Waits for the end of a job. `look` gets its status every few seconds until then.
    pub(crate) async fn wait(&self, job: &str, look: impl FnMut(&v1::JobStatus)) -> Result<v1::JobStatus, Error> {
        Ok(self.server.wait_and_look(job, look).await?)
    }

    /// Submits a job.
    pub(crate) async fn submit(&self, request: v1::SubmitJobRequest) -> Result<SubmittedJob, Error> {
        let (status, duplicate) = self.server.submit_or_find(request).await?;
        Ok(SubmittedJob::of(status, duplicate))
    }

    /// Reads a result.
    pub(crate) async fn document(&self, job: &str, document: &ResultDocument) -> Result<ResultChunks, Error> {
        Ok(self.server.document(job, document).await?)
    }

    /// The files that macros have written.
    pub(crate) async fn files(&self, job: &str) -> Result<Vec<v1::WrittenFile>, Error> {
        Ok(self.server.files(job).await?)
    }

    /// Uploads the blobs that the server does not have; a server in this process gets all of them, without a copy.
    pub(crate) async fn upload(&self, blobs: &[Blob]) -> Result<(), Error> {
        let Some(own) = &self.own else { return Ok(self.server.upload(blobs).await?) };
        for blob in blobs {
            own.put_blob(blob.digest(), blob.content().clone()).map_err(counterpoint_client::Error::from)?;
        }
        Ok(())
    }
}
