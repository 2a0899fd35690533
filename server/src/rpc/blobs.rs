//! Service `BlobsService`.

use std::io::Read;
use std::time::Duration;

use bytes::Bytes;
use counterpoint_proto::v1;
use counterpoint_proto::v1::blobs_server::Blobs as Service;
use tokio_stream::StreamExt as _;
use tokio_stream::wrappers::ReceiverStream;
use tonic::{Request, Response, Status, Streaming};

use super::door::{chunk as within, enter};
use super::stream::{CHUNK, ChunkResponse, stream};
use super::{BlobsService, blocking, look_up, to_the_end};
use crate::access::Caller;
use crate::blobs::{BlobReceiver, digest};
use crate::jobs::Core;
use crate::jobs::growing::Growing;
use crate::reason::Refusal;

impl ChunkResponse for v1::DownloadResponse {
    fn chunk(data: Bytes) -> Self {
        Self { data }
    }
}

/// The next chunk, if it comes within that many seconds.
async fn next(chunks: &mut Streaming<v1::UploadRequest>, patience: u64) -> Result<Option<v1::UploadRequest>, Status> {
    let chunk = tokio::time::timeout(Duration::from_secs(patience), chunks.next()).await;
    chunk.map_err(|_| Refusal::UploadStalled(patience))?.transpose()
}

/// Starts receiving content with its first chunk, within the quotas of the tenant. May block.
fn begin(core: &Core, tenant: &str, first: &v1::UploadRequest) -> Result<(Box<dyn BlobReceiver>, Growing), Refusal> {
    let blobs = core.blobs.of(tenant);
    core.room()?;
    // A content that is there already takes nothing more of the quota; it cannot be larger than it is.
    let stored = blobs.offers(&first.digest).then(|| blobs.size(&first.digest));
    let stored = stored.filter(|stored| first.size.is_none_or(|size| size == *stored));
    let mut growing = if stored.is_some() { core.not_growing(tenant) } else { core.growing(tenant) };
    if stored.is_none() {
        core.within_quotas(tenant)?;
        core.has_room_for(tenant, first.size.unwrap_or(0))?;
    }
    let mut receiver = blobs.receive(&first.digest, first.size.or(stored))?;
    core.grow(&mut growing, first.data.len() as u64)?;
    receiver.chunk(&first.data)?;
    Ok((receiver, growing))
}

#[tonic::async_trait]
impl Service for BlobsService {
    async fn find_missing(
        &self,
        request: Request<v1::FindMissingRequest>,
    ) -> Result<Response<v1::FindMissingResponse>, Status> {
        let (caller, v1::FindMissingRequest { digests }) = enter(request)?;
        let blobs = self.0.blobs.of(caller.tenant());
        let ask = move || Ok(digests.into_iter().filter(|d| !blobs.offers(d)).collect());
        let digests = look_up(&self.0, &caller.identity.key(), ask).await?;
        Ok(Response::new(v1::FindMissingResponse { digests }))
    }

    async fn upload(
        &self,
        request: Request<Streaming<v1::UploadRequest>>,
    ) -> Result<Response<v1::UploadResponse>, Status> {
        let caller = Caller::of(&request)?;
        let _place = self.0.upload(request.remote_addr(), caller.tenant())?;
        let patience = self.0.options.connections.upload_stall_s;
        let mut chunks = request.into_inner();
        let first = next(&mut chunks, patience).await?.unwrap_or_default();
        within(&first.data)?;
        let digest = first.digest.clone();
        caller.about(&digest);
        let (core, tenant) = (self.0.clone(), caller.tenant().to_owned());
        let (mut receiver, mut growing) = blocking(move || begin(&core, &tenant, &first)).await?;
        while let Some(chunk) = next(&mut chunks, patience).await? {
            within(&chunk.data)?;
            if receiver.in_memory() {
                receiver.chunk(&chunk.data)?;
                continue;
            }
            let core = self.0.clone();
            (receiver, growing) = blocking(move || {
                core.grow(&mut growing, chunk.data.len() as u64)?;
                receiver.chunk(&chunk.data)?;
                Ok((receiver, growing))
            })
            .await?;
        }
        let size = to_the_end(&caller, blocking(move || receiver.finish())).await?;
        drop(growing);
        Ok(Response::new(v1::UploadResponse { digest, size }))
    }

    async fn put_blob(&self, request: Request<v1::PutBlobRequest>) -> Result<Response<v1::PutBlobResponse>, Status> {
        let (caller, v1::PutBlobRequest { data }) = enter(request)?;
        let (core, tenant) = (self.0.clone(), caller.tenant().to_owned());
        let stored = blocking(move || {
            let (digest, size) = (digest(&data), data.len() as u64);
            caller.about(&digest);
            caller.begins();
            let (receiver, growing) =
                begin(&core, &tenant, &v1::UploadRequest { digest: digest.clone(), data, size: Some(size) })?;
            receiver.finish()?;
            drop(growing);
            Ok(v1::PutBlobResponse { digest, size })
        })
        .await?;
        Ok(Response::new(stored))
    }

    type DownloadStream = ReceiverStream<Result<v1::DownloadResponse, Status>>;

    async fn download(&self, request: Request<v1::DownloadRequest>) -> Result<Response<Self::DownloadStream>, Status> {
        let (caller, v1::DownloadRequest { digest }) = enter(request)?;
        caller.about(&digest);
        let blobs = self.0.blobs.of(caller.tenant());
        let turn = self.0.streams.renders.turn(caller.tenant()).await;
        let mut file = blocking(move || blobs.open(&digest)).await?;
        Ok(stream(turn, move |out, _| {
            let mut buffer = vec![0; CHUNK];
            loop {
                let got = file.read(&mut buffer)?;
                if got == 0 {
                    return Ok(());
                }
                out.write_all(buffer.get(..got).unwrap_or_default())?;
            }
        }))
    }
}
