//! The calls of a server.

use std::future::Future;

use crate::backoff::Backoff;
use crate::blob::Blob;
use crate::connection::{Connection, Through};
use crate::document::{self, ResultChunks, ResultDocument};
use crate::error::Error;
use crate::settings::ClientSettings;
use crate::v1;
use crate::v1::admin_client::AdminClient;
use crate::v1::blobs_client::BlobsClient;
use crate::v1::jobs_client::JobsClient;
use crate::v1::machines_client::MachinesClient;
use crate::v1::operator_client::OperatorClient;
use crate::v1::results_client::ResultsClient;
use crate::watch::Watch;
use crate::watch_jobs::WatchJobs;

/// Digests in one question, so that the message stays small.
const ASK: usize = 10_000;
/// Longest wait of one call, ms.
const WAIT_MS: u64 = 60_000;
/// Time before the first status request for an awaited job, and between later requests, ms.
const FIRST_LOOK_MS: u64 = 1_000;
const LOOK_MS: u64 = 5_000;

/// A connection to a server; cheap to clone. A lost one is made again with the next call.
#[derive(Debug, Clone)]
pub struct Client(Connection);

/// A request id that no other request has; later ones come after earlier ones.
#[must_use]
pub fn request_id() -> String {
    uuid::Uuid::now_v7().to_string()
}

fn has_ended(status: &v1::JobStatus) -> bool {
    status.ended_ms != 0
}

impl Client {
    /// Connects to a server.
    ///
    /// # Errors
    /// [`Error::Settings`] if these cannot be used, [`Error::Unreachable`] if no server answers.
    pub async fn connect(settings: &ClientSettings) -> Result<Self, Error> {
        Ok(Self(Connection::open(settings).await?))
    }

    /// Where it is connected to, and how.
    #[must_use]
    pub fn settings(&self) -> &ClientSettings {
        &self.0.settings
    }

    /// All calls about jobs; none is repeated.
    #[must_use]
    pub fn jobs(&self) -> JobsClient<Through> {
        self.0.jobs()
    }

    /// All calls of administrators; none is repeated.
    #[must_use]
    pub fn admin(&self) -> AdminClient<Through> {
        self.0.admin()
    }

    /// All calls about machines; none is repeated.
    #[must_use]
    pub fn machines(&self) -> MachinesClient<Through> {
        self.0.machines()
    }

    /// All calls of operators; none is repeated.
    #[must_use]
    pub fn operator(&self) -> OperatorClient<Through> {
        self.0.operator()
    }

    /// All calls for results; none is repeated.
    #[must_use]
    pub fn results(&self) -> ResultsClient<Through> {
        self.0.results()
    }

    /// All calls about contents of files; none is repeated.
    #[must_use]
    pub fn blobs(&self) -> BlobsClient<Through> {
        self.0.blobs()
    }

    /// Accepted by the server and on its disk when this returns. A lost answer is requested again, with the same
    /// request id: the job is accepted once.
    ///
    /// # Errors
    /// Every refusal but UNAVAILABLE at once, that and lost connections when patience is at its end.
    pub async fn submit(&self, request: v1::SubmitJobRequest) -> Result<v1::JobStatus, Error> {
        Ok(self.submit_or_find(request).await?.0)
    }

    /// Submits like [`Client::submit`] and also returns whether the job had been accepted before with this request id.
    /// The flag is also true if the answer to the first attempt of this call was lost.
    ///
    /// # Errors
    /// As [`Client::submit`].
    pub async fn submit_or_find(&self, request: v1::SubmitJobRequest) -> Result<(v1::JobStatus, bool), Error> {
        let submit = async || Ok(self.jobs().submit_job(request.clone()).await?.into_inner());
        let v1::SubmitJobResponse { status, duplicate } = self.again(submit).await?;
        let status = status.ok_or_else(|| Error::Contract("a submit was answered without a status".to_owned()))?;
        Ok((status, duplicate))
    }

    /// Uploads the blobs that the server does not have.
    ///
    /// # Errors
    /// As [`Client::submit`].
    pub async fn upload(&self, blobs: &[Blob]) -> Result<(), Error> {
        let mut missing: Vec<&Blob> = Vec::new();
        for part in blobs.chunks(ASK) {
            let digests: Vec<String> = part.iter().map(|blob| blob.digest().to_owned()).collect();
            let ask = async || {
                let request = v1::FindMissingRequest { digests: digests.clone() };
                Ok(self.blobs().find_missing(request).await?.into_inner().digests)
            };
            let answer: std::collections::HashSet<String> = self.again(ask).await?.into_iter().collect();
            missing.extend(part.iter().filter(|blob| answer.contains(blob.digest())));
        }
        self.upload_all(missing).await
    }

    /// Uploads contents without asking whether the server has them.
    async fn upload_all<'a>(&self, blobs: impl IntoIterator<Item = &'a Blob>) -> Result<(), Error> {
        let mut blobs: Vec<&Blob> = blobs.into_iter().collect();
        blobs.sort_by_key(|blob| blob.digest());
        blobs.dedup_by_key(|blob| blob.digest());
        for blob in blobs {
            self.again(async || Ok(self.blobs().upload(tokio_stream::iter(blob.chunks())).await?)).await?;
        }
        Ok(())
    }

    /// Follows a job from its first event to its end.
    #[must_use]
    pub fn watch(&self, job: &str, level: v1::WatchLevel) -> Watch {
        Watch::new(self.0.clone(), job, level)
    }

    /// Follows the states of many jobs, beginning with those that have not ended.
    #[must_use]
    pub fn watch_jobs(&self, filter: v1::JobFilter) -> WatchJobs {
        WatchJobs::new(self.0.clone(), filter)
    }

    /// Waits until a job has ended.
    ///
    /// # Errors
    /// As [`Client::submit`].
    pub async fn wait(&self, job: &str) -> Result<v1::JobStatus, Error> {
        loop {
            let status = self.wait_for(job, WAIT_MS).await?;
            if has_ended(&status) {
                return Ok(status);
            }
        }
    }

    /// Waits like [`Client::wait`]. Until the job has ended, `look` gets its status after a second and then every five
    /// seconds: for example, the job may be paused or wait for an operator.
    ///
    /// # Errors
    /// As [`Client::submit`].
    pub async fn wait_and_look(&self, job: &str, mut look: impl FnMut(&v1::JobStatus)) -> Result<v1::JobStatus, Error> {
        let mut timeout_ms = FIRST_LOOK_MS;
        loop {
            let status = self.wait_for(job, timeout_ms).await?;
            if has_ended(&status) {
                return Ok(status);
            }
            look(&status);
            timeout_ms = LOOK_MS;
        }
    }

    /// The status of a job at its end, or when the timeout expires.
    async fn wait_for(&self, job: &str, timeout_ms: u64) -> Result<v1::JobStatus, Error> {
        let request = v1::WaitJobRequest { job_id: job.to_owned(), timeout_ms };
        let wait = async || Ok(self.jobs().wait_job(request.clone()).await?.into_inner().status);
        self.again(wait).await?.ok_or_else(|| Error::Contract("a wait was answered without a status".to_owned()))
    }

    /// Reads a result of an ended job.
    ///
    /// # Errors
    /// When the server refuses or the connection is lost.
    pub async fn document(&self, job: &str, document: &ResultDocument) -> Result<ResultChunks, Error> {
        document::read(&self.0, job, document).await
    }

    /// The files that macros of a machine have written.
    ///
    /// # Errors
    /// As [`Client::submit`].
    pub async fn files(&self, job: &str) -> Result<Vec<v1::WrittenFile>, Error> {
        let mut request = v1::ListFilesRequest { job_id: job.to_owned(), ..Default::default() };
        let mut files = Vec::new();
        loop {
            let page = self.again(async || Ok(self.results().list_files(request.clone()).await?.into_inner())).await?;
            files.extend(page.files);
            if page.next_page_token.is_empty() {
                return Ok(files);
            }
            request.page_token = page.next_page_token;
        }
    }

    /// Repeats a call that may be repeated until it succeeds or is refused.
    async fn again<T, F: Future<Output = Result<T, Error>>>(&self, call: impl Fn() -> F) -> Result<T, Error> {
        let mut backoff = Backoff::of(self.settings());
        loop {
            let error = match call().await {
                Err(error) if error.is_passing() => error,
                other => return other,
            };
            match backoff.failed(&error) {
                Some(pause) => tokio::time::sleep(pause).await,
                None => return Err(error),
            }
        }
    }
}
