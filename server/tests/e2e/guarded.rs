//! Callers with tokens.

use std::path::Path;

use counterpoint_proto::v1;
use counterpoint_proto::v1::admin_client::AdminClient;
use counterpoint_proto::v1::blobs_client::BlobsClient;
use counterpoint_proto::v1::jobs_client::JobsClient;
use counterpoint_proto::v1::machines_client::MachinesClient;
use counterpoint_proto::v1::operator_client::OperatorClient;
use counterpoint_proto::v1::results_client::ResultsClient;
use counterpoint_server::access::{Role, edit, token};
use counterpoint_server::options::{Guard, ServerOptions};
use tonic::service::interceptor::InterceptedService;
use tonic::transport::Channel;
use tonic::{Request, Status};

use crate::support::*;

/// Adds a token to every call.
#[derive(Clone)]
pub struct Bearer(pub Option<String>);

impl tonic::service::Interceptor for Bearer {
    fn call(&mut self, mut request: Request<()>) -> Result<Request<()>, Status> {
        if let Some(token) = &self.0 {
            request.metadata_mut().insert("authorization", format!("Bearer {token}").parse().unwrap());
        }
        Ok(request)
    }
}

/// A submit of a script that has been uploaded.
pub fn request_of(request_id: &str, machine: &str, script: &str) -> v1::SubmitJobRequest {
    v1::SubmitJobRequest {
        request_id: request_id.into(),
        machine: machine.into(),
        programs: vec![v1::Program { path: "main.nc".into(), ..Default::default() }],
        files: vec![v1::FileRef { path: "main.nc".into(), digest: digest(script.as_bytes()) }],
        ..Default::default()
    }
}

/// A caller.
#[derive(Clone)]
pub struct As {
    pub connection: Channel,
    pub bearer: Bearer,
}

type Through = InterceptedService<Channel, Bearer>;

impl As {
    pub fn new(server: &Server, token: &str) -> Self {
        Self { connection: server.connection.clone(), bearer: Bearer(Some(token.to_owned())) }
    }

    pub fn nobody(server: &Server) -> Self {
        Self { connection: server.connection.clone(), bearer: Bearer(None) }
    }

    pub fn jobs(&self) -> JobsClient<Through> {
        JobsClient::with_interceptor(self.connection.clone(), self.bearer.clone())
    }

    pub fn blobs(&self) -> BlobsClient<Through> {
        BlobsClient::with_interceptor(self.connection.clone(), self.bearer.clone())
    }

    pub fn machines(&self) -> MachinesClient<Through> {
        MachinesClient::with_interceptor(self.connection.clone(), self.bearer.clone())
    }

    pub fn results(&self) -> ResultsClient<Through> {
        ResultsClient::with_interceptor(self.connection.clone(), self.bearer.clone())
    }

    pub fn operator(&self) -> OperatorClient<Through> {
        OperatorClient::with_interceptor(self.connection.clone(), self.bearer.clone())
    }

    pub fn admin(&self) -> AdminClient<Through> {
        AdminClient::with_interceptor(self.connection.clone(), self.bearer.clone())
    }

    pub async fn upload(&self, content: &[u8]) -> Result<String, Status> {
        let chunk = |data: &[u8]| v1::UploadRequest { data: data.to_vec().into(), ..Default::default() };
        let mut chunks: Vec<_> = content.chunks(1 << 19).map(chunk).collect();
        let first = v1::UploadRequest { digest: digest(content), ..Default::default() };
        chunks.insert(0, first);
        Ok(self.blobs().upload(tokio_stream::iter(chunks)).await?.into_inner().digest)
    }

    pub async fn submit(&self, request_id: &str, machine: &str, script: &str) -> Result<v1::JobStatus, Status> {
        self.submit_with(request_id, machine, script, None).await
    }

    pub async fn submit_limited(
        &self,
        request_id: &str,
        machine: &str,
        script: &str,
        limits: Option<v1::JobLimits>,
    ) -> Result<v1::JobStatus, Status> {
        let options = limits.map(|limits| v1::JobOptions { limits: Some(limits), ..Default::default() });
        self.submit_with(request_id, machine, script, options).await
    }

    pub async fn submit_with(
        &self,
        request_id: &str,
        machine: &str,
        script: &str,
        options: Option<v1::JobOptions>,
    ) -> Result<v1::JobStatus, Status> {
        self.upload(script.as_bytes()).await?;
        let request = v1::SubmitJobRequest { options, ..request_of(request_id, machine, script) };
        Ok(self.jobs().submit_job(request).await?.into_inner().status.unwrap())
    }

    pub async fn wait(&self, job: &str) -> v1::JobStatus {
        let request = v1::WaitJobRequest { job_id: job.into(), timeout_ms: 120_000 };
        self.jobs().wait_job(request).await.unwrap().into_inner().status.unwrap()
    }

    pub async fn list(&self) -> Vec<String> {
        let jobs = self.jobs().list_jobs(v1::ListJobsRequest::default()).await.unwrap().into_inner().jobs;
        jobs.into_iter().map(|job| job.job_id).collect()
    }

    /// Puts a machine that is `fanuc-2path-lathe` with another description.
    pub async fn put_machine(&self, name: &str, description: &str) -> Result<v1::MachineSummary, Status> {
        let text =
            format!("extends = \"fanuc-2path-lathe\"\n[ce]\nname = \"{name}\"\ndescription = \"{description}\"\n");
        let digest = self.upload(text.as_bytes()).await?;
        let file = v1::MachineFile { path: format!("{name}/machine.toml"), digest };
        let request = v1::PutMachineRequest { name: name.into(), files: vec![file] };
        Ok(self.machines().put_machine(request).await?.into_inner().machine.unwrap())
    }
}

/// Options of a guarded server, and a file of identities that is still empty.
pub fn guarded(folder: &Path) -> ServerOptions {
    let access = folder.join("access.toml");
    std::fs::write(&access, "").unwrap();
    ServerOptions { guard: Guard { access, ..Guard::default() }, ..options(&folder.join("data")) }
}

/// A new token in the file of identities.
pub fn grant(options: &ServerOptions, name: &str, tenant: &str, role: Role) -> String {
    let (token, row) = token::create(name, tenant, role, None).unwrap();
    edit::add_row(&options.guard.access, &row).unwrap();
    token
}
